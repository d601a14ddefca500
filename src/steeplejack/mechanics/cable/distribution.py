"""Bounded tension distribution for one cable too many, in closed form, with a margin and a proof of infeasibility.

Question: tensions ``f`` with ``structure @ f + wrench = 0`` (Eq. 7 of Zheng et al., CCRobot-S, IEEE T-RO) and
``lower <= f <= upper``, for a 3x4 structure matrix. All solutions lie on a line ``f = start + lambda n`` (Eq. 9), ``n``
the unit null vector, towards more tension, and ``start`` perpendicular to it.

*Margin*: the greatest least distance to a bound over the line, divided by half the widest window. 1 is the middle of
the box, 0 its surface; -0.1 means every bound would have to give way by a tenth of that half-width.

*Certificate*: that distance is set by two bounds. Their weights, carried back through the structure matrix, are a
vector ``z`` with ``z . (structure @ f + wrench) >= gap > 0`` for every ``f`` in the box (Farkas): a motion of the
platform along which tensions and load do positive work whatever is tried. `certificate_gap` checks it, however it was
found.

A singular structure matrix is never feasible here, whatever the load, because an arbitrarily small disturbance would
not be resisted; the certificate is then the direction of that disturbance. Nothing raises for a state a control loop
can meet: read `Status`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import line

Array = NDArray[np.float64]
Method = Literal["min-max", "min-norm", "max-margin"]

METHODS: dict[Method, int] = {"min-max": line.MIN_MAX, "min-norm": line.MIN_NORM, "max-margin": line.MAX_MARGIN}


class Status(IntEnum):
    """How a distribution ended; `advice` says what to do."""

    FEASIBLE = line.FEASIBLE
    INFEASIBLE = line.INFEASIBLE
    SINGULAR = line.SINGULAR
    UNDEFINED = line.UNDEFINED

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _ADVICE[self]


_ADVICE = {
    Status.FEASIBLE: "tensions hold the load inside their bounds",
    Status.INFEASIBLE: "no tensions inside the bounds hold the load; move the pose or the anchors, or widen the window",
    Status.SINGULAR: "the cables cannot resist the certificate's wrench at all; move off the singular pose",
    Status.UNDEFINED: "an input is not finite; check pose, wrench and bounds",
}


@dataclass(frozen=True)
class TensionDistribution:
    """Tensions and what is known about them; leading axes are those of the question.

    Attributes:
        tensions: In equilibrium with the wrench, (..., 4) [N]. Where infeasible, the ones that leave the box by the
            least; not a number where singular or undefined.
        feasible: Whether they are inside the bounds, (...).
        margin: Distance inside the box over half the widest window, (...) [1]; negative outside, -inf where singular.
        interval: ``lambda`` that stays inside, growing with pretension, (..., 2) [N]; not a number where infeasible.
        certificate: ``z`` that proves infeasibility, (..., 3); not a number where feasible.
        status: `Status` by number, (...).
    """

    tensions: Array
    feasible: NDArray[np.bool_]
    margin: Array
    interval: Array
    certificate: Array
    status: NDArray[np.int64]


def distribute(
    structure: ArrayLike, wrench: ArrayLike, lower: ArrayLike, upper: ArrayLike, method: Method = "min-max"
) -> TensionDistribution:
    """Choose tensions within bounds that balance a wrench (Eq. 7 and 9).

    Args:
        structure: (..., 3, 4); any three rows, in any units.
        wrench: External wrench on the platform, same rows, (..., 3).
        lower: Least tensions, finite, (..., 4) or a scalar [N].
        upper: Greatest tensions, finite, (..., 4) or a scalar [N].
        method: ``min-max`` makes the largest tension least, ``min-norm`` the sum of squares, ``max-margin`` goes
            deepest into the box.

    Returns:
        Tensions with margin, interval, certificate and status, over the broadcast leading axes.

    Raises:
        InputError: Unknown method, or bounds with no open window.
    """
    if method not in METHODS:
        raise InputError("method", f"{method!r}", f"one of {', '.join(METHODS)}")
    matrix, load, low, high = (np.asarray(value, dtype=np.float64) for value in (structure, wrench, lower, upper))
    windows = np.broadcast_to(high - low, np.broadcast_shapes(high.shape, low.shape, (4,)))
    if np.any(windows.max(axis=-1) <= 0.0):
        raise InputError("tension bounds", "no window is open", "at least one upper bound above its lower one")
    shape = np.broadcast_shapes(matrix.shape[:-2], load.shape[:-1], windows.shape[:-1])
    tensions, interval, certificate, margin, status = line.distribute_each(
        _stack(matrix, shape, (3, 4)),
        _stack(load, shape, (3,)),
        _stack(low, shape, (4,)),
        _stack(high, shape, (4,)),
        METHODS[method],
    )
    return TensionDistribution(
        tensions=tensions.reshape(*shape, 4),
        feasible=(status == Status.FEASIBLE).reshape(shape),
        margin=margin.reshape(shape),
        interval=interval.reshape(*shape, 2),
        certificate=certificate.reshape(*shape, 3),
        status=status.reshape(shape),
    )


def certificate_gap(
    certificate: ArrayLike, structure: ArrayLike, wrench: ArrayLike, lower: ArrayLike, upper: ArrayLike
) -> Array:
    """Least value of ``z . (structure @ f + wrench)`` over the box; positive proves that no ``f`` in it balances.

    Args:
        certificate: ``z``, (..., 3).
        structure: (..., 3, 4).
        wrench: (..., 3).
        lower: (..., 4) or a scalar [N].
        upper: (..., 4) or a scalar [N].

    Returns:
        The gap, (...) [N]; for an infeasible `distribute`, ``-margin`` times half the widest window.
    """
    z = np.asarray(certificate, dtype=np.float64)
    power = np.einsum("...r,...rc->...c", z, np.asarray(structure, dtype=np.float64))
    least = np.minimum(power * np.asarray(lower), power * np.asarray(upper)).sum(axis=-1)
    return least + np.sum(z * np.asarray(wrench), axis=-1)


def _stack(values: Array, shape: tuple[int, ...], tail: tuple[int, ...]) -> Array:
    """Broadcast to ``shape + tail``, leading axes flattened to one; always a copy, so that one compilation serves."""
    return np.array(np.broadcast_to(values, (*shape, *tail)), order="C").reshape(-1, *tail)
