"""Bounded tension distribution for any number of cables, with a margin and a proof of infeasibility.

Question: tensions ``f`` with ``structure @ f + wrench = 0`` (Eq. 7 of Zheng et al., CCRobot-S, IEEE T-RO) and
``lower <= f <= upper``, for a structure matrix of n rows and m >= n cables. All solutions are ``f = start + N lambda``
(Eq. 9), ``N`` an orthonormal null basis of ``r = m - n`` columns and ``start`` perpendicular to it: a point, a line, a
plane or more. `METHODS` says which of those inside the box each method chooses and what it promises.

*Margin*: the greatest least distance to a bound over all solutions, divided by half the widest window. 1 is the middle
of the box, 0 its surface; -0.1 means every bound would have to give way by a tenth of that half-width. It belongs to
the question and not to the method: the chosen tensions may be on the surface where the margin is 0.5.

*Feasible* does not depend on that width: each bound may be passed by what `choice` allows for its own numbers.

*Certificate*: that distance is set by at most r + 1 bounds. Their weights, carried back through the structure matrix,
are a vector ``z`` with ``z . (structure @ f + wrench) >= gap > 0`` for every ``f`` in the box (Farkas): a motion of the
platform along which tensions and load do positive work whatever is tried. `certificate_gap` checks it, however it was
found.

A singular structure matrix is never feasible here, whatever the load, because an arbitrarily small disturbance would
not be resisted; the certificate is then the direction of that disturbance. A cable of zero length has no direction, and
nothing is known about it. Nothing raises for a state a control loop can meet: read `Status`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.tension import choice
from steeplejack.mechanics.cable.tension.line import TOLERANCE
from steeplejack.mechanics.cable.tension.methods import METHODS, Method, MethodRecord

Array = NDArray[np.float64]

GREATEST_POWER = 64.0
"""Of the p-norm [1]; beyond it, min-max is meant."""


class Status(IntEnum):
    """How a distribution ended; `advice` says what to do."""

    FEASIBLE = choice.FEASIBLE
    INFEASIBLE = choice.INFEASIBLE
    SINGULAR = choice.SINGULAR
    UNDEFINED = choice.UNDEFINED
    MISSED = choice.MISSED

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _ADVICE[self]


_ADVICE = {
    Status.FEASIBLE: "tensions hold the load inside their bounds",
    Status.INFEASIBLE: "no tensions inside the bounds hold the load; move the pose or the anchors, or widen the window",
    Status.SINGULAR: "the cables cannot resist the certificate's wrench at all; move off the singular pose",
    Status.UNDEFINED: "an input is not finite, or a cable has no length; check pose, wrench and bounds",
    Status.MISSED: "tensions inside the bounds exist, but this method left them; use a complete one, such as qp",
}


@dataclass(frozen=True)
class TensionDistribution:
    """Tensions and what is known about them; leading axes are those of the question.

    Attributes:
        tensions: In equilibrium with the wrench, (..., m) [N]. Where infeasible, the ones that leave the box by the
            least; not a number where singular or undefined.
        feasible: Whether they are inside the bounds, (...).
        margin: Greatest distance inside the box over half the widest window, (...) [1]; negative where there is no
            answer, -inf where singular or undefined. Where ``MISSED`` it is not negative.
        interval: For one cable too many, ``lambda`` that stays inside, growing with pretension, (..., 2) [N]; not a
            number elsewhere (see `tension_polygon` for two cables too many).
        certificate: ``z`` that proves infeasibility, (..., n); not a number where feasible tensions exist, and where a
            least tension is above its greatest, which needs no proof.
        status: `Status` by number, (...).
    """

    tensions: Array
    feasible: NDArray[np.bool_]
    margin: Array
    interval: Array
    certificate: Array
    status: NDArray[np.int64]


def distribute(
    structure: ArrayLike,
    wrench: ArrayLike,
    lower: ArrayLike,
    upper: ArrayLike,
    method: Method = "min-max",
    *,
    reference: ArrayLike | None = None,
    weights: ArrayLike | None = None,
    power: float | None = None,
) -> TensionDistribution:
    """Choose tensions within bounds that balance a wrench (Eq. 7 and 9).

    Args:
        structure: (..., n, m), m >= n; rows in any units.
        wrench: External wrench on the platform, same rows, (..., n).
        lower: Least tensions, finite, (..., m) or a scalar [N].
        upper: Greatest tensions, finite, (..., m) or a scalar [N].
        method: One of `METHODS`.
        reference: Tensions to stay near to, (..., m) or a scalar [N]; for ``qp`` (the middle of the box if None) and
            ``p-norm`` (zero if None).
        weights: Positive, of each cable's squares for ``qp``; of any sign, of each cable's tension for ``lp``; (..., m)
            or a scalar [1]; ones if None.
        power: Of ``p-norm``, 2 to 64 [1]; 4 if None.

    Returns:
        Tensions with margin, certificate and status, over the broadcast leading axes.

    Raises:
        InputError: Unknown method, one that does not take so many cables or that option, or bounds with no open window.
    """
    if method not in METHODS:
        raise InputError("method", f"{method!r}", f"one of {', '.join(METHODS)}")
    matrix, load, low, high = (np.asarray(value, dtype=np.float64) for value in (structure, wrench, lower, upper))
    n, m = _sizes(matrix, method, METHODS[method])
    _check_options(method, METHODS[method], reference, weights, power)
    costs = np.asarray(1.0 if weights is None else weights, dtype=np.float64)
    wanted = np.asarray(0.0 if reference is None else reference, dtype=np.float64)
    each = {"lower": low, "upper": high, "reference": wanted, "weights": costs}
    shape = _leading(matrix.shape[:-2], (n,), {"wrench": load}, _leading((), (m,), each, ()))
    if method == "qp" and reference is None:
        wanted = 0.5 * (low + high)
    if np.any(np.max(np.broadcast_to(high - low, (*shape, m)), axis=-1) <= 0.0):
        raise InputError("tension bounds", "no window is open", "at least one upper bound above its lower one")
    count = int(np.prod(shape))
    tensions, interval, certificate = (np.full((count, size), np.nan) for size in (m, 2, n))
    margin, status = np.empty(count), np.empty(count, np.int64)
    choice.distribute_each(
        _stack(matrix, shape, (n, m)),
        _stack(load, shape, (n,)),
        _stack(low, shape, (m,)),
        _stack(high, shape, (m,)),
        _stack(wanted, shape if wanted.ndim > 1 else (1,), (m,)),
        _stack(costs, shape if costs.ndim > 1 else (1,), (m,)),
        METHODS[method].number,
        4.0 if power is None else float(power),
        tensions,
        interval,
        certificate,
        margin,
        status,
    )
    return TensionDistribution(
        tensions=tensions.reshape(*shape, m),
        feasible=(status == Status.FEASIBLE).reshape(shape),
        margin=margin.reshape(shape),
        interval=interval.reshape(*shape, 2),
        certificate=certificate.reshape(*shape, n),
        status=status.reshape(shape),
    )


def certificate_gap(
    certificate: ArrayLike, structure: ArrayLike, wrench: ArrayLike, lower: ArrayLike, upper: ArrayLike
) -> Array:
    """Least value of ``z . (structure @ f + wrench)`` over the box; positive proves that no ``f`` in it balances.

    A component of ``structure^T z`` of at most ``TOLERANCE`` times the largest is taken for the rounding of a zero
    where the bound it reaches for is infinite, as in `wrench_feasible`; against finite bounds every component counts.

    Args:
        certificate: ``z``, (..., n).
        structure: (..., n, m).
        wrench: (..., n).
        lower: (..., m) or a scalar; may be -inf [N].
        upper: (..., m) or a scalar; may be inf [N].

    Returns:
        The gap, (...) [N], -inf where an infinite bound is reached for; for an infeasible `distribute`, ``-margin``
        times half the widest window.
    """
    z = np.asarray(certificate, dtype=np.float64)
    power = np.einsum("...r,...rc->...c", z, np.asarray(structure, dtype=np.float64))
    bound = np.where(power > 0.0, np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64))
    noise = np.isinf(bound) & (np.abs(power) <= TOLERANCE * np.abs(power).max(axis=-1, keepdims=True))
    least = (power * np.where(noise, 0.0, bound)).sum(axis=-1)
    return least + np.sum(z * np.asarray(wrench), axis=-1)


def _sizes(matrix: Array, method: str, record: MethodRecord) -> tuple[int, int]:
    """Rows and cables of a structure matrix the method takes."""
    if matrix.ndim < 2 or not 0 < matrix.shape[-2] <= matrix.shape[-1]:
        raise InputError(
            "structure matrix", f"shape {matrix.shape}", "(..., n, m) with at least as many cables as rows"
        )
    n, m = matrix.shape[-2:]
    if record.most_redundancy is not None and m - n > record.most_redundancy:
        raise InputError(
            "method", f"{method} with {m - n} cables too many", f"at most {record.most_redundancy} of them"
        )
    return n, m


def _leading(
    shape: tuple[int, ...], tail: tuple[int, ...], values: dict[str, Array], other: tuple[int, ...]
) -> tuple[int, ...]:
    """Leading axes that all values broadcast to, their last axis being ``tail``."""
    shape = np.broadcast_shapes(shape, other)
    for name, value in values.items():
        try:
            shape = np.broadcast_shapes((*shape, *tail), value.shape)[:-1]
        except ValueError:
            raise InputError(name, f"shape {value.shape}", f"shape (..., {tail[0]}) over {shape}") from None

    return shape


def _check_options(
    method: str, record: MethodRecord, reference: ArrayLike | None, weights: ArrayLike | None, power: float | None
) -> None:
    """Refuse options the method does not read, and values that mean nothing."""
    for name, value in (("reference", reference), ("weights", weights), ("power", power)):
        if value is not None and name not in record.options:
            readers = [other for other, known in METHODS.items() if name in known.options]
            raise InputError(name, f"not read by {method}", f"only with {' or '.join(readers)}")
    if power is not None and not 2.0 <= power <= GREATEST_POWER:
        raise InputError("power", f"{power:g}", f"2 to {GREATEST_POWER:g}")
    if method == "qp" and weights is not None and np.any(np.asarray(weights, dtype=np.float64) <= 0.0):
        raise InputError("weights", f"{np.min(np.asarray(weights, dtype=np.float64)):g}", "positive")


def _stack(values: Array, shape: tuple[int, ...], tail: tuple[int, ...]) -> Array:
    """Broadcast to ``shape + tail``, leading axes flattened to one; always a copy, so that one compilation serves."""
    return np.array(np.broadcast_to(values, (*shape, *tail)), order="C").reshape(-1, *tail)
