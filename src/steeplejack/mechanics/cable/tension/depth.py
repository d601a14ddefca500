"""Compiled verdict on tensions within bounds: the one rule of distribution, polygon and feasibility.

Question: ``structure @ f + wrench = 0`` with ``lower <= f <= upper``. The tensions that balance are
``f = start + N lambda`` (`nullspace`), and the *depth* is the greatest least distance to a bound over them [N], found
on a line (`line`) or by a linear program (`linear`) with the weights that prove it.

A question is feasible where every bound is kept, and a bound counts as kept where it is passed by no more than a
billionth of the cable's own half-window, or of the largest force that must act if that is less, and the rounding of the
numbers that meet there. Each bound has its own such allowance: a wide window makes no other bound soft.

Infinite bounds leave a side open. In the programs they are bounds beyond anything tensions can be made to reach: a pose
whose tension factor is above ``degeneracy.TOLERANCE`` never needs more than its inverse times the forces that act. A
depth set by one of them is infinite.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.degeneracy import TOLERANCE, decide, row_scales, surely_regular, unresisted
from steeplejack.mechanics.cable.status import NO, SINGULAR, UNDEFINED, YES
from steeplejack.mechanics.cable.tension import line, linear
from steeplejack.mechanics.cable.tension.nullspace import carry_back, decompose, least_norm, null_columns

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LOST = 1e-13  # [1] rounding of a tension, relative to the numbers that make it up
ENDLESS = 4.0 / TOLERANCE  # [1] what stands for an infinite bound, over the largest force that acts


@njit(cache=True, error_model="numpy")
def settle(
    structure: Array, wrench: Array, lower: Array, upper: Array, acting: float,
    left: Array, tau: Array, scale: Array, order: Index, start: Array, basis: Array, low: Array, high: Array,
    least: Array, most: Array, chosen: Index, work: Array, space: Array, active: Index, place: Array, proof: Array,
    certificate: Array,
) -> tuple[int, float]:  # fmt: skip
    """Decide one question; what was found on the way is left in the arrays.

    Args:
        structure: (n, m), n <= m.
        wrench: (n,).
        lower: (m,) [N]; may be -inf.
        upper: (m,) [N]; may be inf.
        acting: Largest force the caller will ask about, beside wrench and bounds [N].
        left: Written as by `decompose`, (n, m).
        tau: Written as by `decompose`, (n,).
        scale: Written as by `decompose`, (n,).
        order: Written as by `decompose`, (n,).
        start: Written, (m,) [N].
        basis: Written, ``N``, (m, r); a line's points where the sum of tensions grows.
        low: Written, finite least tensions, (m,) [N].
        high: Written, finite greatest tensions, (m,) [N].
        least: Written where feasible, least tensions less what may be passed of them, (m,) [N].
        most: Written where feasible, greatest tensions and what may be passed of them, (m,) [N].
        chosen: Written for r > 1, cables with independent rows of ``N``, (r,).
        work: Overwritten, (m, r).
        space: Overwritten, `linear.room` long.
        active: Overwritten, (r + 1,).
        place: Written, ``lambda`` of the deepest tensions, (r + 1,) [N].
        proof: Overwritten, (m,).
        certificate: Written where infeasible or singular, (n,); left alone where a window is empty.

    Returns:
        `YES`, `NO`, `SINGULAR` or `UNDEFINED`, and the depth [N]; negative and `YES` where the depth is within what may
        be passed of the bounds, and then ``place`` is that of the bounds so moved.
    """
    n = structure.shape[0]
    squares = row_scales(structure, scale)
    if not (squares > 0.0 and _numbers(wrench, lower, upper)):
        return UNDEFINED, -np.inf
    volume = 1.0
    for r in range(n):
        volume *= scale[r]
    volume *= decompose(structure, left, tau, scale, order)
    if not surely_regular(volume, squares, n) and _flat(structure, wrench, certificate):
        return SINGULAR, -np.inf
    null_columns(left, tau, basis)
    least_norm(left, tau, scale, order, wrench, start)
    endless = _finite(start, lower, upper, acting, low, high)
    depth = _depth(start, basis, low, high, chosen, work, space, active, place, proof)
    if endless and depth > 0.0 and _open(proof, lower, upper):
        depth = np.inf
    allowed = soften(start, basis, place, low, high, least, most)
    if depth >= 0.0:
        return YES, depth
    if not upside_down(lower, upper):
        carry_back(left, tau, scale, order, proof, certificate)
    if depth >= -allowed and _depth(start, basis, least, most, chosen, work, space, active, place, proof) >= 0.0:
        certificate[:] = np.nan
        return YES, depth
    return NO, depth


@njit(cache=True, error_model="numpy")
def verdicts_each(structures: Array, wrenches: Array, lowers: Array, uppers: Array, certificates: Array) -> Index:
    """`YES`, `NO`, `SINGULAR` or `UNDEFINED` of every question of a batch, as `settle` decides.

    Args:
        structures: (k, n, m), n <= m.
        wrenches: (k, n).
        lowers: (k, m) [N]; may be -inf.
        uppers: (k, m) [N]; may be inf.
        certificates: Written where infeasible or singular, (k, n).

    Returns:
        (k,).
    """
    count, n, m = structures.shape
    r = m - n
    left, tau, scale, order = np.empty((n, m)), np.empty(n), np.empty(n), np.empty(n, np.int64)
    start, basis, proof, work = np.empty(m), np.empty((m, r)), np.empty(m), np.empty((m, r))
    chosen, active, place = np.empty(r, np.int64), np.empty(r + 1, np.int64), np.empty(r + 1)
    bounds, space, verdicts = np.empty((4, m)), np.empty(linear.room(m, r)), np.empty(count, np.int64)
    for k in range(count):
        verdicts[k], _ = settle(
            structures[k], wrenches[k], lowers[k], uppers[k], 0.0, left, tau, scale, order, start, basis,
            bounds[0], bounds[1], bounds[2], bounds[3], chosen, work, space, active, place, proof, certificates[k],
        )  # fmt: skip
    return verdicts


@njit(cache=True, error_model="numpy")
def share_of_window(status: int, depth: float, start: Array, lower: Array, upper: Array) -> float:
    """Depth over half the widest finite window; where none is open, over the largest force that must act [1].

    Negative exactly where not feasible.
    """
    widest = 0.0
    if status == YES:
        depth = max(depth, 0.0)
    for i in range(lower.size):
        if upper[i] - lower[i] < np.inf:
            widest = max(widest, upper[i] - lower[i])
    half = 0.5 * widest if widest > 0.0 else _must_act(start, lower, upper)
    return depth / half if half > 0.0 else (0.0 if depth == 0.0 else math.copysign(np.inf, depth))


@njit(cache=True, error_model="numpy")
def upside_down(lower: Array, upper: Array) -> bool:
    """Whether a least tension is above its greatest: the box itself is empty, and no motion is needed to prove it."""
    for i in range(lower.size):
        if lower[i] > upper[i]:
            return True
    return False


@njit(cache=True, error_model="numpy")
def _numbers(wrench: Array, lower: Array, upper: Array) -> bool:
    """Whether the wrench is finite and bounds are numbers, none infinite on the wrong side."""
    total = 0.0
    for r in range(wrench.size):
        total += abs(wrench[r])
    for i in range(lower.size):
        if not (lower[i] < np.inf and upper[i] > -np.inf):
            return False
    return total < np.inf


@njit(cache=True, error_model="numpy")
def _flat(structure: Array, wrench: Array, certificate: Array) -> bool:
    """Whether the pose is singular, with the motion that no cable resists; rarely asked."""
    n, m = structure.shape
    scale, motions, sizes = np.empty(n), np.empty((n, n)), np.empty(n)
    row_scales(structure, scale)
    if decide(structure, scale, np.empty((n, m)), motions, sizes) == n:
        return False
    unresisted(scale, motions, sizes, wrench, certificate)
    return True


@njit(cache=True, error_model="numpy")
def _finite(start: Array, lower: Array, upper: Array, acting: float, low: Array, high: Array) -> bool:
    """Write bounds, infinite ones as far away as ``ENDLESS`` says; whether there were any."""
    size, endless = acting, False
    for i in range(lower.size):
        low[i], high[i] = lower[i], upper[i]
        size = max(size, abs(start[i]))
        if math.isinf(lower[i]) or math.isinf(upper[i]):
            endless = True
        if not math.isinf(lower[i]):
            size = max(size, abs(lower[i]))
        if not math.isinf(upper[i]):
            size = max(size, abs(upper[i]))
    if endless:
        far = ENDLESS * size if size > 0.0 else 1.0
        for i in range(lower.size):
            low[i], high[i] = max(lower[i], -far), min(upper[i], far)
    return endless


@njit(cache=True, error_model="numpy")
def _open(proof: Array, lower: Array, upper: Array) -> bool:
    """Whether the depth was set by a bound that stands for an infinite one."""
    for i in range(proof.size):
        if (proof[i] < 0.0 and math.isinf(upper[i])) or (proof[i] > 0.0 and math.isinf(lower[i])):
            return True
    return False


@njit(cache=True, error_model="numpy")
def _depth(
    start: Array, basis: Array, lower: Array, upper: Array, chosen: Index, work: Array,
    space: Array, active: Index, place: Array, proof: Array,
) -> float:  # fmt: skip
    """Greatest least distance to a bound [N], its ``lambda`` in ``place``; on a line the null vector is turned up."""
    m, r = basis.shape
    if r != 1:
        linear.independent(basis, work, chosen)
        linear.deepest(start, basis, lower, upper, chosen, space, active, place, proof)
        return float(place[r])
    null = basis.reshape(m)
    total = 0.0
    for i in range(m):
        total += null[i]
    if total < 0.0:
        for i in range(m):
            null[i] = -null[i]
    depth = line.deepest(null, start, lower, upper, proof)
    low, high = line.interval(null, start, lower, upper, depth)
    place[0] = 0.5 * (low + high)
    return depth


@njit(cache=True, error_model="numpy")
def _must_act(start: Array, lower: Array, upper: Array) -> float:
    """Largest force that must act whatever is chosen [N]: of the least-norm tensions, and of bounds that ask for it."""
    size = 0.0
    for i in range(start.size):
        size = max(size, max(abs(start[i]), min(abs(lower[i]), abs(upper[i]))))
    return float(size)


@njit(cache=True, error_model="numpy")
def soften(start: Array, basis: Array, x: Array, lower: Array, upper: Array, least: Array, most: Array) -> float:
    """Write the bounds moved outwards by what may be passed of each at ``x`` [N]; the greatest of those allowances.

    The bounds may be overwritten in place.
    """
    load, greatest = 0.0, 0.0
    for i in range(start.size):
        load = max(load, abs(start[i]))
    size = _must_act(start, lower, upper)
    for i in range(start.size):
        own = load
        for j in range(basis.shape[1]):
            own += abs(basis[i, j] * x[j])
        share = TOLERANCE * max(min(0.5 * (upper[i] - lower[i]), size), 0.0)
        under, over = share + LOST * (own + abs(lower[i])), share + LOST * (own + abs(upper[i]))
        greatest = max(greatest, max(under, over))
        least[i], most[i] = lower[i] - under, upper[i] + over
    return float(greatest)
