"""Geometrico-statics: where a platform comes to rest on locked winches, some cables slack.

Given unstressed lengths, the equilibria of a platform under constant loads are the minima of the potential energy

    E = sum_i EA_i / (2 L_i) max(0, l_i - L_i)^2 - sum_j F_j . (p + R c_j)

over position and rotation. Cables pull and never push, so which of them are taut is part of the answer. Sources:
Carricato and Merlet, "Stability analysis of underconstrained cable-driven parallel robots", IEEE T-RO 29(1), 2013;
Idà, Briot and Carricato, "Natural oscillations of underactuated cable-driven parallel robots", IEEE Access 9, 2021. The
descent is `potential.descend`: trust-region Newton on the manifold, its Hessian analytic. Inextensible cables (the
default) are exact limits, not stiff springs.

`settle` answers for the minimum downhill of a start; `equilibria` collects those of many starts, which is no proof that
there are no others. The energy is bounded below as long as one cable is there, so every fall ends.

Policy at degeneracies. Without load, a start from which no cable is ever taut, or all lose their tension to the
rounding of their lengths, is ``LOOSE``. A rest with a direction that meets no stiffness (below 1e-9 of load over size)
is ``NEUTRAL``: the pose is one of a family, or its stability is decided by higher orders. ``UNFINISHED`` are a constant
moment with nothing to hold it, which turns for ever, inextensible cables so short that no pose has them all, whose
tensions grow without bound, and an attachment that runs into its pulley, where a cable has no course. Next to a
singular pose, where tensions are many times the load and multipliers converge slowly, the descent is completed by
Newton's method on the lengths and the balance together (`hold`), which is also asked at the start whether the platform
rests there already. ``UNDEFINED`` starts, and falls that end in a pulley, have no stiffness: not a number. A cable
within 1e-9 of the greatest force of no tension counts as slack.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import kind, numbers, vectors
from steeplejack.mechanics.cable.pulleys import in_space, pulley_runs
from steeplejack.mechanics.cable.rest import hold, potential
from steeplejack.mechanics.cable.rest.locked import LockedPlatform
from steeplejack.mechanics.cable.rest.modes import cross_matrix, natural_modes
from steeplejack.mechanics.cable.rest.stiffness import turn_about_z
from steeplejack.spatial.rotation import rotation_matrix

Array = NDArray[np.float64]

SLACK = 1e-9  # [1] tension over the greatest force up to which a cable counts as slack
TWIN = 1e-6  # [1] equilibria closer than this, relative to the longest cable, are one


class Rest(IntEnum):
    """How a fall ended; `advice` says what it means."""

    STABLE = potential.SETTLED
    LOOSE = potential.LOOSE
    UNFINISHED = potential.UNFINISHED
    UNDEFINED = potential.UNDEFINED
    NEUTRAL = 4

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _ADVICE[self]


_ADVICE = {
    Rest.STABLE: "at rest; every small motion meets a restoring force",
    Rest.NEUTRAL: "at rest, but some motion meets no restoring force: the pose is one of a family",
    Rest.LOOSE: "nothing pulls on the platform: no load and no taut cable",
    Rest.UNFINISHED: "no rest found: inextensible cables too short to meet, a moment nothing holds, an attachment "
    "that runs into its pulley, or a singularity",
    Rest.UNDEFINED: "the start has no energy: a number is not finite or an attachment is inside its pulley",
}


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A pose of rest and what is known about it; in space also for planar robots.

    Attributes:
        position: Of the platform's reference point, (3,) [m].
        rotation: From platform to world, (3, 3).
        turned: Angle turned about z since the start [rad].
        tensions: (m,) [N].
        taut: Which cables pull, (m,).
        lengths: (m,) [m].
        energy: Elastic energy less the work of the loads at the pose [J].
        residual: Force missing to equilibrium, moments over the radius of gyration [N].
        stiffness: Hessian of the energy in (x, y, phi) or (angular; linear) about the reference point, without the
            taut inextensible cables, (n, n).
        free: Orthonormal columns: the motions those leave, (n, f).
        least_stiffness: Least stiffness of a free motion, rotations taken times the radius of gyration; infinite
            where nothing is free [N/m].
        status: How the fall ended.
        steps: Of the descent.
    """

    position: Array
    rotation: Array
    turned: float
    tensions: Array
    taut: NDArray[np.bool_]
    lengths: Array
    energy: float
    residual: float
    stiffness: Array
    free: Array
    least_stiffness: float
    status: Rest
    steps: int

    @property
    def phi(self) -> float:
        """Orientation of a planar platform, between minus half a turn and half a turn [rad]."""
        return float(np.arctan2(self.rotation[1, 0], self.rotation[0, 0]))

    @property
    def pose(self) -> Array:
        """``(x, y, phi)`` of a planar platform, (3,) [m, m, rad]."""
        return np.array([self.position[0], self.position[1], self.phi])

    @property
    def stable(self) -> bool:
        """Whether every small motion meets a restoring force."""
        return self.status is Rest.STABLE


def settle(platform: LockedPlatform, position: ArrayLike, rotation: ArrayLike) -> Equilibrium:
    """The equilibrium downhill of a start.

    Args:
        platform: Cables, loads and lengths.
        position: Of the reference point, (2,) or (3,) [m].
        rotation: (3, 3), or the angle phi of a planar platform [rad].

    Returns:
        The equilibrium; read its status.

    Raises:
        InputError: The start has the wrong shape or is not finite.
    """
    place, turn = start_of(platform, position, rotation)
    spring = springs(platform, platform.unstressed, platform.axial_stiffness)
    fall = fall_of(platform, platform.unstressed, spring, place, turn, 0.25 * platform.unstressed.max(), 0)
    return rest_of(platform, platform.unstressed, spring, fall)


def equilibria(platform: LockedPlatform, positions: ArrayLike, rotations: ArrayLike) -> list[Equilibrium]:
    """Different stable equilibria downhill of many starts, least energy first; others may exist.

    Args:
        platform: Cables, loads and lengths.
        positions: (k, 2) or (k, 3) [m].
        rotations: (k, 3, 3), or angles (k,) of a planar platform [rad].

    Returns:
        Those found, each once.

    Raises:
        InputError: A start has the wrong shape or is not finite.
    """
    kind("platform", platform, LockedPlatform)
    places, turns = numbers("positions", positions), numbers("rotations", rotations)
    if not (places.ndim == 2 and turns.ndim in (1, 3) and len(places) == len(turns)):
        found = f"shapes {places.shape} and {turns.shape}"
        raise InputError("positions and rotations", found, "as many of each, a list of both")
    rests: list[Equilibrium] = []
    size = platform.unstressed.max()
    for place, turn in zip(places, turns, strict=True):
        rest = settle(platform, place, turn)
        if rest.status is Rest.STABLE and all(_apart(rest, other, size) > TWIN for other in rests):
            rests.append(rest)
    return sorted(rests, key=lambda rest: rest.energy)


def natural_frequencies(rest: Equilibrium, mass: ArrayLike) -> Array:
    """Natural frequencies of small swings about an equilibrium, winches locked, undamped.

    Args:
        rest: The equilibrium.
        mass: Mass matrix about the reference point in the order of a pose, see `modes`, (n, n).

    Returns:
        One for each motion that taut inextensible cables leave free, slowest first, (f,) [Hz]; not a number where a
        motion meets no restoring force.

    Raises:
        InputError: The mass matrix has the wrong shape or is not symmetric positive definite.
    """
    n = len(kind("rest", rest, Equilibrium).stiffness)
    weight = vectors("mass matrix", mass, n, n)
    if weight.ndim != 2:
        raise InputError("mass matrix", f"shape {weight.shape}", f"({n}, {n})")
    if rest.free.shape[1] == 0:
        return np.empty(0)
    weighed = rest.free.T @ weight @ rest.free
    return natural_modes(rest.free.T @ rest.stiffness @ rest.free, weighed).frequencies


@dataclass(frozen=True, eq=False)
class Fall:
    """What the compiled descent leaves behind; places are of the load's centre."""

    status: int
    steps: int
    residual: float
    turned: float
    position: Array
    rotation: Array
    tensions: Array
    box: Array
    path_positions: Array
    path_rotations: Array


def start_of(platform: LockedPlatform, position: ArrayLike, rotation: ArrayLike) -> tuple[Array, Array]:
    """A start in space, checked: position (3,) [m] and rotation (3, 3)."""
    kind("platform", platform, LockedPlatform)
    place, turn = numbers("position", position), numbers("rotation", rotation)
    if turn.ndim == 0 and platform.in_plane:
        turn = turn_about_z(turn)
    if place.shape != (2 if platform.in_plane else 3,) or not np.isfinite(place).all():
        raise InputError("position", f"shape {place.shape}", "a finite point of the platform's dimension in metres")
    if turn.ndim != 2:
        raise InputError("rotation", f"shape {turn.shape}", "a rotation matrix (3, 3), or an angle in the plane")
    return in_space(place), rotation_matrix(turn, "rotation")


def springs(platform: LockedPlatform, unstressed: Array, axial_stiffness: Array) -> Array:
    """Stiffness ``EA / L`` of the cables, for inextensible ones what the method of multipliers uses, (m,) [N/m]."""
    elastic = axial_stiffness[np.isfinite(axial_stiffness)]
    load = platform.load or potential.PRETENSION * float(elastic.max(initial=0.0))
    stiff = potential.STIFF * load / float(unstressed.max())
    return np.where(np.isinf(axial_stiffness), stiff, axial_stiffness / unstressed)


def fall_of(
    platform: LockedPlatform,
    unstressed: Array,
    spring: Array,
    position: Array,
    rotation: Array,
    stride: float,
    record: int,
    corners: Array | None = None,
) -> Fall:
    """Descend from a place of the reference point; ``spring`` 0 takes a cable away, ``record`` poses are kept."""
    centre = platform.points[0]
    place, turn = position + rotation @ centre, rotation.copy()
    around = (np.zeros((1, 3)) if corners is None else np.vstack((np.zeros((1, 3)), corners))) - centre
    tensions, box = np.zeros(len(unstressed)), np.empty((2, 2, 3))
    kept_positions, kept_rotations = np.empty((record, 3)), np.empty((record, 3, 3))
    start = Fall(potential.UNFINISHED, 0, np.nan, 0.0, place, turn, tensions, box, kept_positions, kept_rotations)
    held = _held(platform, unstressed, spring, start, 0.0)
    if held is not None:
        box[:] = _swept(place, turn, around)
        kept_positions[:1], kept_rotations[:1] = place, turn
        return replace(held, path_positions=kept_positions[:1], path_rotations=kept_rotations[:1])
    status, steps, count, residual, turned = potential.descend(
        platform.anchors,
        platform.axes,
        platform.radii,
        platform.attachments - centre,
        unstressed,
        spring,
        np.isinf(platform.axial_stiffness),
        platform.forces,
        platform.points - centre,
        platform.moment,
        platform.freedoms,
        platform.gyration,
        stride,
        around,
        place,
        turn,
        tensions,
        np.empty((6, 6)),
        box,
        kept_positions,
        kept_rotations,
    )
    path = kept_positions[:count], kept_rotations[:count]
    fall = Fall(status, steps, residual, turned, place, turn, tensions, box, *path)
    held = _held(platform, unstressed, spring, fall, stride) if status == potential.UNFINISHED else None
    if held is None:
        return fall
    end = _swept(held.position, held.rotation, around)
    box[:, 0], box[:, 1] = np.minimum(box[:, 0], end[:, 0]), np.maximum(box[:, 1], end[:, 1])
    if 0 < count < record:
        kept_positions[count], kept_rotations[count] = held.position, held.rotation
        path = kept_positions[: count + 1], kept_rotations[: count + 1]
    return replace(held, path_positions=path[0], path_rotations=path[1])


def _held(platform: LockedPlatform, unstressed: Array, spring: Array, fall: Fall, reach: float) -> Fall | None:
    """The rest next to a fall's end that taut inextensible cables hold, None where there is none (`hold`)."""
    rigid, centre = np.isinf(platform.axial_stiffness), platform.points[0]
    if not rigid.any():
        return None
    place, turn, tensions = fall.position.copy(), fall.rotation.copy(), fall.tensions.copy()
    residual, turned = hold.settled_by(
        platform.anchors,
        platform.axes,
        platform.radii,
        platform.attachments - centre,
        unstressed,
        spring,
        rigid,
        platform.forces,
        platform.points - centre,
        platform.moment,
        platform.freedoms,
        platform.gyration,
        reach,
        place,
        turn,
        fall.turned,
        tensions,
    )
    if np.isnan(residual):
        return None
    return replace(
        fall,
        status=potential.SETTLED,
        residual=residual,
        turned=turned,
        position=place,
        rotation=turn,
        tensions=tensions,
    )


def _swept(position: Array, rotation: Array, points: Array) -> Array:
    """Boxes (2, 2, 3) of one pose: of the reference point, which is the first, and of the other points."""
    ends = position + points @ rotation.T
    rest = ends[1:] if len(ends) > 1 else np.array([[np.inf] * 3, [-np.inf] * 3])
    return np.array([[ends[0], ends[0]], [rest.min(axis=0), rest.max(axis=0)]])


def rest_of(platform: LockedPlatform, unstressed: Array, spring: Array, fall: Fall) -> Equilibrium:
    """The end of a fall as an equilibrium, with its stiffness and stability."""
    n, centre = len(platform.freedoms), platform.points[0]
    position = fall.position - fall.rotation @ centre
    lengths, along = pulley_runs(
        platform.anchors, platform.axes, platform.radii, position + platform.attachments @ fall.rotation.T
    )
    greatest = max(platform.load, float(fall.tensions.max(initial=0.0)))
    taut = fall.tensions > SLACK * greatest
    status = Rest(fall.status)
    if status is Rest.UNDEFINED or not np.isfinite(lengths[taut]).all():
        return _unknown(platform, fall, position, taut, lengths)
    blocked = taut & np.isinf(platform.axial_stiffness)
    arms = platform.attachments @ fall.rotation.T
    structure = np.vstack((np.cross(arms, along).T, along.T))[platform.freedoms]
    energy, hessian = _curvature(platform, unstressed, np.where(taut, spring, 0.0), fall, position)
    hessian = hessian[np.ix_(platform.freedoms, platform.freedoms)]
    blocking = structure[:, blocked]
    hessian = hessian - (blocking * spring[blocked]) @ blocking.T
    free = _complement(blocking, platform.gyration, platform.freedoms)
    scale = _weights(centre, fall.rotation, platform)
    reduced = np.linalg.qr(scale @ free)[0] if free.shape[1] else np.empty((n, 0))
    inverse = np.linalg.inv(scale)
    values = np.linalg.eigvalsh(reduced.T @ inverse.T @ hessian @ inverse @ reduced) if free.shape[1] else np.empty(0)
    least = float(values[0]) if len(values) else np.inf
    flat = potential.NEUTRAL * greatest / float(unstressed.max()) + 1e-13 * float(np.abs(values).max(initial=0.0))
    if status is Rest.STABLE and least <= flat:
        status = Rest.NEUTRAL
    return Equilibrium(
        position,
        fall.rotation,
        fall.turned,
        np.where(taut, fall.tensions, 0.0),
        taut,
        lengths,
        energy,
        fall.residual,
        hessian,
        free,
        least,
        status,
        fall.steps,
    )


def _unknown(
    platform: LockedPlatform, fall: Fall, position: Array, taut: NDArray[np.bool_], lengths: Array
) -> Equilibrium:
    """The end of a fall where a cable that pulls has no course: neither energy nor stiffness."""
    n = len(platform.freedoms)
    return Equilibrium(
        position,
        fall.rotation,
        fall.turned,
        np.where(taut, fall.tensions, 0.0),
        taut,
        lengths,
        np.nan,
        fall.residual,
        np.full((n, n), np.nan),
        np.empty((n, 0)),
        np.nan,
        Rest.UNDEFINED if fall.status == potential.UNDEFINED else Rest.UNFINISHED,
        fall.steps,
    )


def _curvature(
    platform: LockedPlatform, unstressed: Array, spring: Array, fall: Fall, position: Array
) -> tuple[float, Array]:
    """Energy [J] less the multipliers' share, and Hessian (6, 6) about the reference point at the fall's tensions."""
    hessian, shift, unused = np.empty((6, 6)), np.zeros(len(spring)), np.empty(len(spring))
    robot = (platform.anchors, platform.axes, platform.radii, platform.attachments, unstressed)
    loads = (platform.forces, platform.points, platform.moment)
    pose, gradient = (position, fall.rotation, fall.turned), np.empty(6)
    potential.evaluate(robot, loads, spring, shift, *pose, gradient, hessian, unused)
    shift = fall.tensions - unused
    energy = potential.evaluate(robot, loads, spring, shift, *pose, gradient, hessian, unused)
    rigid = np.isinf(platform.axial_stiffness) & (spring > 0.0)
    return float(energy - np.sum(0.5 * unused[rigid] ** 2 / spring[rigid])), hessian


def _weights(centre: Array, rotation: Array, platform: LockedPlatform) -> Array:
    """Matrix (n, n) that takes a motion of the reference point to (gyration omega; v of the load's centre)."""
    full = np.eye(6)
    full[:3, :3] *= platform.gyration
    full[3:, :3] = -cross_matrix(rotation @ centre)
    return full[np.ix_(platform.freedoms, platform.freedoms)]


def _complement(columns: Array, gyration: float, freedoms: NDArray[np.int64]) -> Array:
    """Orthonormal basis (n, f) of the motions that do no work on the columns (n, c)."""
    scale = np.where(freedoms < 3, gyration, 1.0)
    left, sizes, _right = np.linalg.svd(columns / scale[:, None], full_matrices=True)
    rank = int(np.sum(sizes > 1e-9 * max(sizes.max(initial=0.0), 1e-300)))
    basis = left[:, rank:] / scale[:, None]
    return np.linalg.qr(basis)[0] if basis.shape[1] else basis


def _apart(one: Equilibrium, other: Equilibrium, size: float) -> float:
    """Distance of two equilibria over a size, or in radians, whichever is larger."""
    turn = one.rotation.T @ other.rotation
    cosine = np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0)
    apart = np.arccos(cosine) if cosine < 0.9 else np.linalg.norm(turn - np.eye(3)) / np.sqrt(2.0)
    return max(float(np.linalg.norm(one.position - other.position)) / size, float(apart))
