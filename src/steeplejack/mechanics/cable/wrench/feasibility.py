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

Degeneracy. A facet counts as passed where it is by more than ``TOLERANCE`` of the sizes summed in its distance, so that
nothing depends on units. A singular pose is never feasible, whatever the load: an arbitrarily small wrench along the
certificate is resisted by nothing. An infinite bound is allowed; the set is then unbounded, and the margin infinite in
wrench closure. Nothing raises for a pose: read the status.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.wrench import hyperplanes
from steeplejack.mechanics.cable.wrench.closure import stacked
from steeplejack.mechanics.cable.wrench.task import TaskWrenches

Array = NDArray[np.float64]


class FeasibilityStatus(IntEnum):
    """How a feasibility question ended; `advice` says what to do."""

    FEASIBLE = hyperplanes.INSIDE
    INFEASIBLE = hyperplanes.OUTSIDE
    SINGULAR = hyperplanes.SINGULAR
    UNDEFINED = hyperplanes.UNDEFINED

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _ADVICE[self]


_ADVICE = {
    FeasibilityStatus.FEASIBLE: "tensions within their limits hold every task wrench",
    FeasibilityStatus.INFEASIBLE: "no tensions within their limits hold the worst wrench; move the pose, or widen the "
    "window",
    FeasibilityStatus.SINGULAR: "the cables cannot resist the certificate's wrench at all; move off the singular pose",
    FeasibilityStatus.UNDEFINED: "an input is not finite, a cable has no length or a window is empty; check pose, task "
    "and bounds",
}


@dataclass(frozen=True)
class Feasibility:
    """Wrench feasibility and what is known about it; leading axes are those of the question.

    Attributes:
        feasible: Whether every task wrench can be held, (...).
        margin: Capacity margin, (...) [N]; infinite where nothing limits, -inf where singular or undefined.
        certificate: ``z`` with ``z . (structure @ f + worst) > 0`` for every ``f`` within limits, or never negative
            and ``z`` perpendicular to all columns where singular, (..., n); not a number where feasible or undefined.
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
        InputError: Shapes that do not match, or a length that is not above 0.
    """
    if not 0.0 < length < math.inf:
        raise InputError("characteristic length", f"{length} m", "a finite length above 0")
    matrices, leading = stacked(structure)
    _, n, m = matrices.shape
    wanted = task if isinstance(task, TaskWrenches) else TaskWrenches.point(task)
    low, high = (np.asarray(bound, dtype=np.float64) for bound in (lower, upper))
    if wanted.vertices.shape[-1] != n:
        raise InputError("task", f"wrenches of {wanted.vertices.shape[-1]} rows", f"{n}, as the structure matrix")
    if any(bound.ndim and bound.shape[-1] not in (1, m) for bound in (low, high)):
        raise InputError("tension bounds", f"shapes {low.shape} and {high.shape}", f"a scalar or (..., {m})")
    shape = np.broadcast_shapes(
        leading, low.shape[:-1], high.shape[:-1], wanted.vertices.shape[:-2], wanted.half.shape[:-1]
    )
    count = math.prod(shape)
    margin, status = np.empty(count), np.empty(count, np.int64)
    certificate, worst = np.empty((count, n)), np.empty((count, n))
    hyperplanes.margins_each(
        _spread(matrices.reshape(*leading, n, m), shape, (n, m)),
        math.comb(m, n - 1),
        _spread(low, shape, (m,)),
        _spread(high, shape, (m,)),
        _spread(wanted.vertices, shape, wanted.vertices.shape[-2:]),
        _spread(wanted.half, shape, (n,)),
        row_lengths(n, length),
        margin,
        certificate,
        worst,
        status,
    )
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
        InputError: All attachments on the reference point.
    """
    mean = float(np.linalg.norm(np.asarray(attachments, dtype=np.float64), axis=-1).mean())
    if not 0.0 < mean < math.inf:
        raise InputError("attachments", f"mean distance {mean} m", "attachments off the reference point")
    return mean


def row_lengths(n: int, length: float) -> Array:
    """Weight of each row in the norm of a normal: the characteristic length for moments, 1 for forces, (n,)."""
    weights = np.ones(n)
    if n == 3:
        weights[2] = length
    if n == 6:
        weights[:3] = length
    return weights


def _spread(values: Array, shape: tuple[int, ...], tail: tuple[int, ...]) -> Array:
    """Broadcast to ``shape + tail``, leading axes flattened to one; always a copy, so that one compilation serves."""
    return np.array(np.broadcast_to(values, (*shape, *tail)), order="C").reshape(-1, *tail)
