"""Bounded tension distribution for any number of cables, with a margin and a proof of infeasibility.

Question: tensions ``f`` with ``structure @ f + wrench = 0`` (Eq. 7 of Zheng et al., CCRobot-S, IEEE T-RO) and
``lower <= f <= upper``, for a structure matrix of n rows and m >= n cables. All solutions are ``f = start + N lambda``
(Eq. 9), ``N`` an orthonormal null basis of ``r = m - n`` columns and ``start`` perpendicular to it: a point, a line, a
plane or more. `METHODS` says which of those inside the box each method chooses and what it promises.

*Margin*: the greatest least distance to a bound over all solutions, divided by half the widest window. 1 is the middle
of the box, 0 its surface; -0.1 means every bound would have to give way by a tenth of that half-width. It belongs to
the question and not to the method: the chosen tensions may be on the surface where the margin is 0.5. It is negative
exactly where the question is infeasible.

*Feasible* does not depend on that width: each bound may be passed by what `depth` allows for its own numbers.

*Open windows*: an upper bound may be infinite where the method says so (`MethodRecord.open_windows`), and the question
is ``UNDEFINED`` to one that does not. Windows without an upper end have no width: the margin is counted in the widest
one that has, and where there is none in the largest force that must act; it is infinite where nothing limits.

*Certificate*: that distance is set by at most r + 1 bounds. Their weights, carried back through the structure matrix,
are a vector ``z`` with ``z . (structure @ f + wrench) >= gap > 0`` for every ``f`` in the box (Farkas): a motion of the
platform along which tensions and load do positive work whatever is tried. `certificate_gap` checks it, however it was
found.

A singular pose (`degeneracy`) is never feasible here, whatever the load, because an arbitrarily small disturbance would
not be resisted; the certificate is then the direction of that disturbance. A window whose lower end is above its upper
one is infeasible. Nothing raises for a state a control loop can meet: read the status.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import each_cable, kind, leading, numbers, spread, structures_of, vectors
from steeplejack.mechanics.cable.degeneracy import TOLERANCE
from steeplejack.mechanics.cable.status import DistributionStatus
from steeplejack.mechanics.cable.tension import choice
from steeplejack.mechanics.cable.tension.methods import METHODS, Method, MethodRecord

Array = NDArray[np.float64]

NOISE = 1e-14
"""Rounding of a product of two vectors, relative to the sizes of its terms [1]."""

GREATEST_POWER = 64.0
"""Of the p-norm [1]; beyond it, min-max is meant."""


@dataclass(frozen=True)
class TensionDistribution:
    """Tensions and what is known about them; leading axes are those of the question.

    Attributes:
        tensions: In equilibrium with the wrench, (..., m) [N]. Where infeasible, the ones that leave the box by the
            least; not a number where singular or undefined.
        feasible: Whether they are inside the bounds, (...).
        margin: Depth in the box over half the widest window, a share, (...) [1]; negative where there is no answer,
            -inf where singular or undefined. Where ``MISSED`` it is not negative. (`capacity_margin` is another: a
            force.)
        interval: For one cable too many, ``lambda`` that stays inside, growing with pretension, (..., 2) [N]; not a
            number elsewhere (see `tension_polygon` for two cables too many).
        certificate: ``z`` that proves infeasibility, (..., n); not a number where feasible tensions exist, and where a
            least tension is above its greatest, which needs no proof.
        status: `DistributionStatus` by number, (...).
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
        upper: Greatest tensions, (..., m) or a scalar [N]; may be inf where the method takes open windows. A question
            with other infinite bounds, or without a middle that the method needs, is ``UNDEFINED``.
        method: One of `METHODS`.
        reference: Tensions to stay near to, (..., m) or a scalar [N]; for ``qp`` (the middle of the box if None) and
            ``p-norm`` (zero if None).
        weights: Positive, of each cable's squares for ``qp``; of any sign, of each cable's tension for ``lp``; (..., m)
            or a scalar [1]; ones if None.
        power: Of ``p-norm``, 2 to 64 [1]; 4 if None.

    Returns:
        Tensions with margin, certificate and status, over the broadcast leading axes.

    Raises:
        InputError: Unknown method, one that does not take so many cables or that option, no numbers, or shapes that do
            not match.
    """
    if kind("method", method, str) not in METHODS:
        raise InputError("method", f"{method!r}", f"one of {', '.join(METHODS)}")
    matrices, poses = structures_of(structure)
    _, n, m = matrices.shape
    _check_redundancy(method, METHODS[method], n, m)
    _check_options(method, METHODS[method], reference, weights, power)
    load, low, high = vectors("wrench", wrench, n), each_cable("lower", lower, m), each_cable("upper", upper, m)
    costs = each_cable("weights", 1.0 if weights is None else weights, m)
    wanted = each_cable("reference", 0.0 if reference is None else reference, m)
    shape = leading(
        ("structure", (*poses, n, m), 2),
        ("wrench", load.shape, 1),
        ("lower", low.shape, 1),
        ("upper", high.shape, 1),
        ("reference", wanted.shape, 1),
        ("weights", costs.shape, 1),
    )
    if method == "qp" and reference is None:
        wanted = _middle(low, high)
    count = math.prod(shape)
    tensions, interval, certificate = (np.full((count, size), np.nan) for size in (m, 2, n))
    margin, status = np.empty(count), np.empty(count, np.int64)
    choice.distribute_each(
        spread(matrices.reshape(*poses, n, m), shape, (n, m)),
        spread(load, shape, (n,)),
        spread(low, shape, (m,)),
        spread(high, shape, (m,)),
        spread(wanted, shape if wanted.ndim > 1 else (1,), (m,)),
        spread(costs, shape if costs.ndim > 1 else (1,), (m,)),
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
        feasible=(status == DistributionStatus.FEASIBLE).reshape(shape),
        margin=margin.reshape(shape),
        interval=interval.reshape(*shape, 2),
        certificate=certificate.reshape(*shape, n),
        status=status.reshape(shape),
    )


@np.errstate(invalid="ignore", over="ignore")
def certificate_gap(
    certificate: ArrayLike, structure: ArrayLike, wrench: ArrayLike, lower: ArrayLike, upper: ArrayLike
) -> Array:
    """Least value of ``z . (structure @ f + wrench)`` over the box; positive proves that no ``f`` in it balances.

    Components of ``structure^T z`` that reach for infinite bounds, but are together at most ``degeneracy.TOLERANCE`` of
    the others, or each no more than the rounding of its terms, are zeros, as in `wrench_feasible`; against finite
    bounds every component counts.

    Args:
        certificate: ``z``, (..., n).
        structure: (..., n, m).
        wrench: (..., n).
        lower: (..., m) or a scalar; may be -inf [N].
        upper: (..., m) or a scalar; may be inf [N].

    Returns:
        The gap, (...) [N], -inf where an infinite bound is reached for; for an infeasible `distribute` of finite
        windows, ``-margin`` times half the widest one.

    Raises:
        InputError: No numbers, or shapes that do not match.
    """
    matrix = vectors("structure", structure, "n", "m")
    n, m = matrix.shape[-2:]
    z, load = vectors("certificate", certificate, n), vectors("wrench", wrench, n)
    low, high = each_cable("lower", lower, m), each_cable("upper", upper, m)
    leading(
        ("structure", matrix.shape, 2),
        ("certificate", z.shape, 1),
        ("wrench", load.shape, 1),
        ("lower", low.shape, 1),
        ("upper", high.shape, 1),
    )
    power = np.einsum("...r,...rc->...c", z, matrix)
    bound = np.where(power > 0.0, low, high)
    noise = NOISE * np.sum(np.abs(z) * np.abs(matrix).max(axis=-1), axis=-1, keepdims=True)
    endless, size = np.isinf(bound), np.where(np.abs(power) > noise, np.abs(power), 0.0)
    reached = np.sum(size * endless, axis=-1) > TOLERANCE * np.sum(size * ~endless, axis=-1)
    least = (power * np.where(endless, 0.0, bound)).sum(axis=-1) + np.sum(z * load, axis=-1)
    return np.where(reached, -np.inf, least)


def _middle(low: Array, high: Array) -> Array:
    """Middle of the box (..., m) [N]; not a number where a window is open."""
    with np.errstate(over="ignore"):
        width = np.where(np.isfinite(low) & np.isfinite(high), high, np.nan) - low
    return low + 0.5 * width


def _check_redundancy(method: str, record: MethodRecord, n: int, m: int) -> None:
    """Refuse robots that a method does not take."""
    if n > m:
        raise InputError("structure", f"{n} rows and {m} cables", "(..., n, m) with at least as many cables as rows")
    if record.most_redundancy is not None and m - n > record.most_redundancy:
        raise InputError(
            "method", f"{method} with {m - n} cables too many", f"at most {record.most_redundancy} of them"
        )


def _check_options(
    method: str, record: MethodRecord, reference: ArrayLike | None, weights: ArrayLike | None, power: float | None
) -> None:
    """Refuse options the method does not read, and values that mean nothing."""
    for name, value in (("reference", reference), ("weights", weights), ("power", power)):
        if value is not None and name not in record.options:
            readers = [other for other, known in METHODS.items() if name in known.options]
            raise InputError(name, f"not read by {method}", f"only with {' or '.join(readers)}")
    if power is not None and not (np.ndim(power) == 0 and 2.0 <= numbers("power", power) <= GREATEST_POWER):
        raise InputError("power", f"{power}", f"2 to {GREATEST_POWER:g}")
    if method == "qp" and weights is not None and np.any(numbers("weights", weights) <= 0.0):
        raise InputError("weights", f"{np.min(numbers('weights', weights)):g}", "positive")
