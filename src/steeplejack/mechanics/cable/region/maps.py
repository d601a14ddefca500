"""Maps over many poses: wrench closure and wrench feasibility of any number of cables, planar or spatial.

A map is what `wrench_closure` and `wrench_feasible` say of the structure matrix of every pose, without their
certificates. Structure matrices are written by a kernel, block by block, so memory does not grow with the map; eight
cables in space take a path of their own (`lanes`). Poses may have any leading axes: a grid, a grid times a range of
orientations, a path.

Degeneracy. Poses know more than matrices, and what only rounding makes of them counts as nothing: a cable shorter than
``LENGTHLESS`` times the coordinates it is the difference of has no length, and moments that are all below ``TOLERANCE``
times the longest arm are zero (cables through one point, which no tensions turn). Such a pose is undefined or singular,
never held; so is one that is not finite, and one of many whose matrix is no rotation. Everything else is as
`wrench_closure` and `wrench_feasible` decide.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import (
    cables,
    characteristic,
    leading,
    limits,
    owned,
    rotation_matrices,
    spread,
    vectors,
)
from steeplejack.mechanics.cable.structure import LENGTHLESS
from steeplejack.mechanics.cable.wrench import lanes
from steeplejack.mechanics.cable.wrench.closure import MOST_CABLES, tension_factor
from steeplejack.mechanics.cable.wrench.feasibility import FeasibilityStatus, wrench_feasible
from steeplejack.mechanics.cable.wrench.hyperplanes import TOLERANCE
from steeplejack.mechanics.cable.wrench.task import TaskWrenches

Array = NDArray[np.float64]
Blocks = Iterator[tuple[slice, Array]]

BLOCK = 4096
"""Poses whose structure matrices exist at one time."""


@dataclass(frozen=True, eq=False)
class FeasibilityMap:
    """Wrench feasibility of many poses; leading axes are those of the poses.

    Attributes:
        feasible: Whether every task wrench is held within the tension limits, (...).
        margin: Capacity margin, (...) [N]; infinite where nothing limits, -inf where singular or undefined.
        status: `FeasibilityStatus` by number, (...).
    """

    feasible: NDArray[np.bool_]
    margin: Array
    status: NDArray[np.int64]


def planar_closure_map(anchors: ArrayLike, attachments: ArrayLike, poses: ArrayLike) -> Array:
    """Tension factor of a planar robot at many poses, 0 outside wrench closure.

    On a regular grid of a robot with four cables `tension_factor_grid` is some fifty times faster.

    Args:
        anchors: (m, 2), m >= 4 [m].
        attachments: (m, 2) in the platform frame [m].
        poses: ``(x, y, phi)``, (..., 3) [m, m, rad].

    Returns:
        TF, (...) [1]; 0 where a cable has no length or a pose is not finite.

    Raises:
        InputError: Shapes or numbers that cannot be meant.
    """
    fixed, local = _robot(anchors, attachments, 2)
    where = owned("poses", poses, 3)
    factors = np.empty(math.prod(where.shape[:-1]))
    for block, structures in _planar_blocks(fixed, local, where.reshape(-1, 3)):
        factors[block] = tension_factor(structures)
    return factors.reshape(where.shape[:-1])


def spatial_closure_map(
    anchors: ArrayLike, attachments: ArrayLike, positions: ArrayLike, rotations: ArrayLike
) -> Array:
    """Tension factor of a spatial robot at many poses, 0 outside wrench closure.

    Args:
        anchors: (m, 3), m >= 7; fewer close nowhere [m].
        attachments: (m, 3) in the platform frame [m].
        positions: (..., 3) [m].
        rotations: From platform to world, (..., 3, 3); leading axes broadcast with those of the positions.

    Returns:
        TF, (...) [1]; 0 where a cable has no length or a pose is not finite.

    Raises:
        InputError: Shapes or numbers that cannot be meant, or one matrix for all that is no rotation.
    """
    fixed, local = _robot(anchors, attachments, 3)
    where, turns, shape = _spatial_poses(positions, rotations)
    factors = np.full(len(where), lanes.UNSETTLED)
    if len(fixed) == 8 and local.any():
        lanes.eight_cable_factors(fixed, local, where, turns, factors)
    left = np.flatnonzero(factors == lanes.UNSETTLED)
    for block, structures in _spatial_blocks(fixed, local, where[left], turns[left]):
        factors[left[block]] = tension_factor(structures)
    return factors.reshape(shape)


def planar_feasibility_map(
    anchors: ArrayLike,
    attachments: ArrayLike,
    poses: ArrayLike,
    lower: ArrayLike,
    upper: ArrayLike,
    task: TaskWrenches | ArrayLike,
    length: float = 1.0,
) -> FeasibilityMap:
    """Whether a planar robot holds every task wrench within its tension limits, and by how much, at many poses.

    Args:
        anchors: (m, 2) [m].
        attachments: (m, 2) in the platform frame [m].
        poses: ``(x, y, phi)``, (..., 3) [m, m, rad].
        lower: Least tensions, (m,) or a scalar [N]; may be -inf.
        upper: Greatest tensions, (m,) or a scalar [N]; may be inf.
        task: `TaskWrenches`, or one wrench ``(fx, fy, mz)`` [N, N, N m]; for all poses, or with leading axes that
            broadcast to theirs (the weight of a platform that turns about a point beside its centre of mass).
        length: Characteristic length that turns moments into forces in the margin, above 0 [m].

    Returns:
        The map.

    Raises:
        InputError: Shapes or numbers that cannot be meant.
    """
    fixed, local = _robot(anchors, attachments, 2)
    where = owned("poses", poses, 3)
    shape = where.shape[:-1]
    blocks = _planar_blocks(fixed, local, where.reshape(-1, 3))
    return _feasibility(blocks, shape, limits(lower, upper, len(fixed)), _task(task, 3, shape), length)


def spatial_feasibility_map(
    anchors: ArrayLike,
    attachments: ArrayLike,
    positions: ArrayLike,
    rotations: ArrayLike,
    lower: ArrayLike,
    upper: ArrayLike,
    task: TaskWrenches | ArrayLike,
    length: float = 1.0,
) -> FeasibilityMap:
    """Whether a spatial robot holds every task wrench within its tension limits, and by how much, at many poses.

    Args:
        anchors: (m, 3) [m].
        attachments: (m, 3) in the platform frame [m].
        positions: (..., 3) [m].
        rotations: From platform to world, (..., 3, 3); leading axes broadcast with those of the positions.
        lower: Least tensions, (m,) or a scalar [N]; may be -inf.
        upper: Greatest tensions, (m,) or a scalar [N]; may be inf.
        task: `TaskWrenches`, or one wrench (moment; force) [N m, N]; for all poses, or with leading axes that broadcast
            to theirs (`gravity_wrench` of a centre of mass that turns with the platform).
        length: Characteristic length that turns moments into forces in the margin, above 0 [m].

    Returns:
        The map.

    Raises:
        InputError: Shapes or numbers that cannot be meant, or one matrix for all that is no rotation.
    """
    fixed, local = _robot(anchors, attachments, 3)
    where, turns, shape = _spatial_poses(positions, rotations)
    blocks = _spatial_blocks(fixed, local, where, turns)
    return _feasibility(blocks, shape, limits(lower, upper, len(fixed)), _task(task, 6, shape), length)


def _feasibility(
    blocks: Blocks, shape: tuple[int, ...], window: tuple[Array, Array], task: TaskWrenches, length: float
) -> FeasibilityMap:
    """The map from blocks of structure matrices."""
    arm, count = characteristic(length), math.prod(shape)
    margin, status = np.empty(count), np.empty(count, dtype=np.int64)
    many = task.vertices.ndim > 2
    for block, structures in blocks:
        wanted = TaskWrenches(task.vertices[block], task.half[block]) if many else task
        answer = wrench_feasible(structures, *window, wanted, arm)
        margin[block], status[block] = answer.margin, answer.status
    feasible = status == FeasibilityStatus.FEASIBLE
    return FeasibilityMap(feasible.reshape(shape), margin.reshape(shape), status.reshape(shape))


def _robot(anchors: ArrayLike, attachments: ArrayLike, size: int) -> tuple[Array, Array]:
    """Anchors and attachments of a robot that is not too large to walk all its hyperplanes."""
    fixed, local = cables(anchors, attachments, size)
    if len(fixed) > MOST_CABLES:
        raise InputError("cables", f"{len(fixed)} of them", f"at most {MOST_CABLES}")
    return fixed, local


def _spatial_poses(positions: ArrayLike, rotations: ArrayLike) -> tuple[Array, Array, tuple[int, ...]]:
    """Flat positions (k, 3) and rotations (k, 3, 3), and the leading axes they came with."""
    where, turns = vectors("positions", positions, 3), rotation_matrices("rotations", rotations)
    shape = leading(("positions", where.shape, 1), ("rotations", turns.shape, 2))
    return spread(where, shape, (3,)), spread(turns, shape, (3, 3)), shape


def _task(task: TaskWrenches | ArrayLike, rows: int, shape: tuple[int, ...]) -> TaskWrenches:
    """The task with its leading axes as those of the poses, flat, or with none where one task serves all."""
    wanted = task if isinstance(task, TaskWrenches) else TaskWrenches.point(owned("task", task, rows))
    vertices, half = wanted.vertices, wanted.half
    if vertices.shape[-1] != rows or half.shape[-1] != rows:
        raise InputError("task", f"wrenches of {vertices.shape[-1]} rows", f"{rows}")
    if not (np.isfinite(vertices).all() and np.isfinite(half).all()):
        raise InputError("task", "a number that is not finite", "finite wrenches")
    if vertices.ndim == 2 and half.ndim == 1:
        return wanted
    try:
        corners = np.broadcast_to(vertices, (*shape, *vertices.shape[-2:])).reshape(-1, *vertices.shape[-2:])
        sides = np.broadcast_to(half, (*shape, rows)).reshape(-1, rows)
    except ValueError:
        raise InputError("task", f"leading axes {vertices.shape[:-2]}", f"those of the poses, {shape}") from None
    return TaskWrenches(corners, sides)


def _planar_blocks(anchors: Array, attachments: Array, poses: Array) -> Blocks:
    """Structure matrices (k, 3, m) of planar poses, block by block."""
    for begin in range(0, len(poses), BLOCK):
        part = poses[begin : begin + BLOCK]
        structures = np.empty((len(part), 3, len(anchors)))
        planar_structures(anchors, attachments, part, structures)
        yield slice(begin, begin + len(part)), structures


def _spatial_blocks(anchors: Array, attachments: Array, positions: Array, rotations: Array) -> Blocks:
    """Structure matrices (k, 6, m) of spatial poses, block by block."""
    for begin in range(0, len(positions), BLOCK):
        block = slice(begin, min(begin + BLOCK, len(positions)))
        structures = np.empty((block.stop - begin, 6, len(anchors)))
        spatial_structures(anchors, attachments, positions[block], rotations[block], structures)
        yield block, structures


@njit(cache=True)
def planar_structures(anchors: Array, attachments: Array, poses: Array, structures: Array) -> None:
    """Write structure matrices of planar poses; not-a-number where undefined, zero moments where they are rounding.

    Args:
        anchors: (m, 2) [m].
        attachments: (m, 2) [m].
        poses: (k, 3) [m, m, rad].
        structures: Written, (k, 3, m).
    """
    longest = 0.0
    for i in range(anchors.shape[0]):
        longest = max(longest, math.hypot(attachments[i, 0], attachments[i, 1]))
    for k in range(poses.shape[0]):
        px, py = poses[k, 0], poses[k, 1]
        cosine, sine, most = math.cos(poses[k, 2]), math.sin(poses[k, 2]), 0.0
        for i in range(anchors.shape[0]):
            bx = cosine * attachments[i, 0] - sine * attachments[i, 1]
            by = sine * attachments[i, 0] + cosine * attachments[i, 1]
            x, y = anchors[i, 0] - bx - px, anchors[i, 1] - by - py
            size = abs(anchors[i, 0]) + abs(anchors[i, 1]) + abs(px) + abs(py) + longest
            length = math.hypot(x, y)
            if not LENGTHLESS * size < length < math.inf:
                structures[k] = math.nan
                break
            structures[k, 0, i], structures[k, 1, i] = x / length, y / length
            structures[k, 2, i] = (bx * y - by * x) / length
            most = max(most, abs(structures[k, 2, i]))
        if most <= TOLERANCE * longest:
            structures[k, 2] *= 0.0


@njit(cache=True)
def spatial_structures(
    anchors: Array, attachments: Array, positions: Array, rotations: Array, structures: Array
) -> None:
    """Write structure matrices of spatial poses; not-a-number where undefined, zero moments where they are rounding.

    Args:
        anchors: (m, 3) [m].
        attachments: (m, 3) [m].
        positions: (k, 3) [m].
        rotations: (k, 3, 3).
        structures: Written, (k, 6, m).
    """
    longest = 0.0
    for i in range(anchors.shape[0]):
        longest = max(longest, math.sqrt((attachments[i] ** 2).sum()))
    b, u = np.empty(3), np.empty(3)
    for k in range(positions.shape[0]):
        most = 0.0
        for i in range(anchors.shape[0]):
            size, square = longest, 0.0
            for r in range(3):
                b[r] = 0.0
                for c in range(3):
                    b[r] += rotations[k, r, c] * attachments[i, c]
                u[r] = anchors[i, r] - b[r] - positions[k, r]
                size += abs(anchors[i, r]) + abs(positions[k, r])
                square += u[r] * u[r]
            length = math.sqrt(square)
            if not LENGTHLESS * size < length < math.inf:
                structures[k] = math.nan
                break
            for r in range(3):
                u[r] /= length
                structures[k, 3 + r, i] = u[r]
            for r in range(3):
                moment = b[(r + 1) % 3] * u[(r + 2) % 3] - b[(r + 2) % 3] * u[(r + 1) % 3]
                structures[k, r, i] = moment
                most = max(most, abs(moment))
        if most <= TOLERANCE * longest:
            structures[k, :3] *= 0.0
