"""Wrench feasibility: do tensions within their limits hold every task wrench, by how much, and if not, why not.

A wrench ``w`` on the platform is held where ``structure @ f + w = 0`` for some ``lower <= f <= upper``, that is where
``-w`` lies in the available wrench set ``structure @ [lower, upper]``, a zonotope. A set of wrenches is held where its
worst vertex is, facet by facet (Bouchard, Gosselin, Moore, J. Mechanisms Robotics 2(1), 2010).

*Capacity margin*: the least signed distance of the task to the planes of the facets (Guay, Cardou, Cruz-Ruiz, Caro, New
Trends in Mechanism and Machine Science, 2014). Inside it is how large a wrench of any direction can still be added;
outside, how far the worst facet is passed, at most the distance to the set. Forces and moments share one scale through
a characteristic length: a moment counts as the force that has it at that arm. 1 m takes newtons and newton-metres as
they come; `characteristic_length` is the mean distance of the attachments.

*Certificate*: the worst facet's inward normal ``z``, with ``z . (structure @ f + w) >= gap > 0`` for every ``f`` within
limits and the worst task wrench ``w`` (Farkas). Scaling ``z`` scales the gap; its length here is 1 in the scale above.

Degeneracy. A singular pose (`degeneracy`) is never feasible, whatever the load: an arbitrarily small wrench along the
certificate is resisted by nothing. An infinite bound is allowed; the set is then unbounded, and the margin infinite in
wrench closure. A window whose lower end is above its upper one holds nothing, and needs no proof. Where the worst facet
is passed or missed by less than ``DOUBTFUL`` of the sizes summed in its distance, the tensions themselves are asked, by
the rule of `tension.depth`, so that feasibility and distribution never contradict each other. Nothing raises for a
pose: read the status.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import (
    characteristic,
    each_cable,
    leading,
    numbers,
    spread,
    structures_of,
    vectors,
)
from steeplejack.mechanics.cable.status import FeasibilityStatus
from steeplejack.mechanics.cable.tension.depth import verdicts_each
from steeplejack.mechanics.cable.wrench import hyperplanes
from steeplejack.mechanics.cable.wrench.task import TaskWrenches

Array = NDArray[np.float64]

DOUBTFUL = 1e-6  # [1] share of the sizes in a facet's distance below which the tensions are asked


@dataclass(frozen=True)
class Feasibility:
    """Wrench feasibility and what is known about it; leading axes are those of the question.

    Attributes:
        feasible: Whether every task wrench can be held, (...).
        margin: Capacity margin, a force, (...) [N]; infinite where nothing limits, -inf where singular or undefined or
            a window is empty. (The margin of a `TensionDistribution` is another: a depth in the box of tensions [1].)
        certificate: ``z`` with ``z . (structure @ f + worst) > 0`` for every ``f`` within limits, or never negative
            and ``z`` perpendicular to all columns where singular, (..., n); not a number where feasible or undefined,
            and where a window is empty.
        worst: The task wrench nearest its facet or farthest beyond it, (..., n); not a number where none is.
        status: `FeasibilityStatus` by number, (...).
    """

    feasible: NDArray[np.bool_]
    margin: Array
    certificate: Array
    worst: Array
    status: NDArray[np.int64]


def wrench_feasible(
    structure: ArrayLike, lower: ArrayLike, upper: ArrayLike, task: TaskWrenches | ArrayLike, length: float = 1.0
) -> Feasibility:
    """Decide whether tensions within limits hold every task wrench, by the facets of the available wrench set.

    Args:
        structure: (..., n, m) with n from 2 to 6; (fx, fy, mz) or (moment; force) rows.
        lower: Least tensions, (..., m) or a scalar [N]; may be -inf.
        upper: Greatest tensions, (..., m) or a scalar [N]; may be inf.
        task: `TaskWrenches`, or one wrench (..., n). Motion is a shift of the task (`load.inertial_wrench`).
        length: Characteristic length that turns moments into forces in the margin, above 0 [m].

    Returns:
        Feasibility over the broadcast leading axes.

    Raises:
        InputError: No numbers, shapes that do not match, or a length that is not above 0.
    """
    matrices, poses = structures_of(structure, 2, 6)
    count, n, m = matrices.shape
    wanted = task if isinstance(task, TaskWrenches) else TaskWrenches.point(vectors("task", task, n))
    low, high = each_cable("lower", lower, m), each_cable("upper", upper, m)
    weights = row_lengths(n, characteristic(length))
    if wanted.vertices.shape[-1] != n:
        raise InputError("task", f"wrenches of {wanted.vertices.shape[-1]} rows", f"{n}, as the structure matrix")
    shape = leading(
        ("structure", (*poses, n, m), 2),
        ("lower", low.shape, 1),
        ("upper", high.shape, 1),
        ("task", wanted.vertices.shape, 2),
        ("task", wanted.half.shape, 1),
    )
    stacked = spread(matrices.reshape(*poses, n, m), shape, (n, m))
    lowers, uppers = spread(low, shape, (m,)), spread(high, shape, (m,))
    count = len(stacked)
    margin, surplus, status = np.empty(count), np.empty(count), np.empty(count, np.int64)
    certificate, worst = np.empty((count, n)), np.empty((count, n))
    hyperplanes.margins_each(
        stacked,
        math.comb(m, n - 1),
        lowers,
        uppers,
        spread(wanted.vertices, shape, wanted.vertices.shape[-2:]),
        spread(wanted.half, shape, (n,)),
        weights,
        margin,
        surplus,
        certificate,
        worst,
        status,
    )
    close = np.flatnonzero(np.abs(surplus) < DOUBTFUL)
    if close.size:
        proofs = np.full((close.size, n), np.nan)
        status[close] = verdicts_each(stacked[close], worst[close], lowers[close], uppers[close], proofs)
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            certificate[close] = proofs / lengths_of(proofs * weights)
    certificate[status == FeasibilityStatus.FEASIBLE] = np.nan
    return Feasibility(
        feasible=(status == FeasibilityStatus.FEASIBLE).reshape(shape),
        margin=margin.reshape(shape),
        certificate=certificate.reshape(*shape, n),
        worst=worst.reshape(*shape, n),
        status=status.reshape(shape),
    )


def capacity_margin(
    structure: ArrayLike, lower: ArrayLike, upper: ArrayLike, task: TaskWrenches | ArrayLike, length: float = 1.0
) -> Array:
    """Capacity margin alone: the least signed distance of the task wrenches to the facets, (...) [N].

    Arguments and errors are those of `wrench_feasible`.
    """
    return wrench_feasible(structure, lower, upper, task, length).margin


def characteristic_length(attachments: ArrayLike) -> float:
    """Mean distance of the attachments (m, d) from the platform's reference point [m].

    Raises:
        InputError: No attachments, or all of them on the reference point.
    """
    given = numbers("attachments", attachments)
    if given.ndim != 2 or given.size == 0:
        raise InputError("attachments", f"shape {given.shape}", "(m, d) with at least one attachment")
    with np.errstate(invalid="ignore", over="ignore"):
        mean = float(np.linalg.norm(given, axis=-1).mean())
    if not 0.0 < mean < math.inf:
        raise InputError("attachments", f"mean distance {mean} m", "attachments off the reference point")
    return mean


def lengths_of(vectors: Array) -> Array:
    """Lengths of vectors (..., n), (..., 1); over the largest part first, so that no square vanishes or overflows."""
    largest = np.abs(vectors).max(axis=-1, keepdims=True)
    largest = np.where(largest > 0.0, largest, 1.0)
    return largest * np.linalg.norm(vectors / largest, axis=-1, keepdims=True)


def row_lengths(n: int, length: float) -> Array:
    """Weight of each row in the norm of a normal: the characteristic length for moments, 1 for forces, (n,)."""
    weights = np.ones(n)
    if n == 3:
        weights[2] = length
    if n == 6:
        weights[:3] = length
    return weights
