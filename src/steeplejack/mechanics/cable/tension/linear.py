"""Exact linear programs over the null space of a few cables: depth in the tension box, largest tension, total tension.

All tensions that balance a wrench are ``f = start + N lambda`` with a null basis ``N`` (m, r). The programs here have
r or r + 1 unknowns and a few inequalities a cable, and each has a set of active inequalities whose multipliers are
known to be non-negative before anything is solved. The dual simplex method (Lemke 1954) begins there: it brings in the
inequality that is violated most, lets go the one whose multiplier reaches zero first, and ends where none is violated.
No first phase, no start inside the box, and the multipliers at the end are the proof of the optimum.

Ties. Where a step brings no progress the choice falls to the lowest index (Bland 1977), which cannot cycle.

The kernels write to arrays of the caller and trust finite input.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

ROUNDING = 1e-13
"""Violation taken for rounding, relative to the terms of the inequality itself [1]."""

MOST_STEPS = 1000
"""Exchanges before giving up; a dozen are usual."""


@njit(cache=True, error_model="numpy")
def climb(rows: Array, bounds: Array, active: Index, inverse: Array, weights: Array, place: Array) -> bool:
    """Maximise ``c . x`` subject to ``rows @ x <= bounds`` from active inequalities that prove dual feasibility.

    Args:
        rows: (k, d).
        bounds: (k,).
        active: Independent inequalities whose multipliers make up the objective, (d,); the optimal ones on return.
        inverse: Overwritten, (d, 2 d).
        weights: Their multipliers, (d,), non-negative with ``weights @ rows[active] = c``; the optimal ones on return.
        place: Written, the optimum ``x``, (d,).

    Returns:
        Whether an optimum was found. If not, no ``x`` satisfies the inequalities.
    """
    count, d = rows.shape
    size = 0.0
    for k in range(count):
        size = max(size, abs(bounds[k]))
    _settle(rows, bounds, active, inverse, place)
    stalled, fresh = 0, True
    for _ in range(MOST_STEPS):
        enters, worst = -1, 0.0
        for k in range(count):
            excess, terms = -bounds[k], abs(bounds[k])
            for j in range(d):
                excess += rows[k, j] * place[j]
                terms += abs(rows[k, j] * place[j])
            if excess > worst and excess > ROUNDING * terms:
                enters, worst = k, excess
                if stalled > count:
                    break
        if worst <= ROUNDING * size and not fresh:
            _settle(rows, bounds, active, inverse, place)
            fresh = True
            continue
        if enters < 0:
            return True
        leaves, least, lead = -1, math.inf, 0.0
        for j in range(d):
            share = 0.0
            for i in range(d):
                share += rows[enters, i] * inverse[i, j]
            if share > 1e-11:
                ratio = weights[j] / share
                closer = ratio < least or (
                    ratio == least and (active[j] < active[leaves] if stalled > count else share > lead)
                )
                if closer:
                    leaves, least, lead = j, ratio, share
        if leaves < 0:
            return False
        stalled = 0 if least > 0.0 else stalled + 1
        _exchange(rows, bounds, active, inverse, weights, place, enters, leaves, lead, least)
        fresh = False
    return False


@njit(cache=True, error_model="numpy")
def _exchange(
    rows: Array, bounds: Array, active: Index, inverse: Array, weights: Array, place: Array,
    enters: int, leaves: int, lead: float, step: float,
) -> None:  # fmt: skip
    """Let one inequality take the place of an active one, and follow with inverse, multipliers and place."""
    d = active.size
    excess = -bounds[enters]
    for j in range(d):
        excess += rows[enters, j] * place[j]
    for i in range(d):
        place[i] -= inverse[i, leaves] * excess / lead
    for j in range(d):
        if j == leaves:
            continue
        share = 0.0
        for i in range(d):
            share += rows[enters, i] * inverse[i, j]
        weights[j] = max(weights[j] - step * share, 0.0)
        for i in range(d):
            inverse[i, j] -= inverse[i, leaves] * share / lead
    for i in range(d):
        inverse[i, leaves] /= lead
    weights[leaves] = step
    active[leaves] = enters


@njit(cache=True, error_model="numpy")
def _settle(rows: Array, bounds: Array, active: Index, inverse: Array, place: Array) -> None:
    """Invert the active rows afresh (Gauss and Jordan, with exchange of rows) and write where they meet."""
    d = active.size
    for i in range(d):
        for j in range(d):
            inverse[i, j] = rows[active[i], j]
            inverse[i, d + j] = 1.0 if i == j else 0.0
    for k in range(d):
        best = k
        for i in range(k + 1, d):
            if abs(inverse[i, k]) > abs(inverse[best, k]):
                best = i
        for j in range(2 * d):
            inverse[k, j], inverse[best, j] = inverse[best, j], inverse[k, j]
        pivot = inverse[k, k]
        for j in range(2 * d):
            inverse[k, j] /= pivot
        for i in range(d):
            factor = inverse[i, k]
            if i != k and factor != 0.0:
                for j in range(2 * d):
                    inverse[i, j] -= factor * inverse[k, j]
    for i in range(d):
        place[i] = 0.0
        for j in range(d):
            inverse[i, j] = inverse[i, d + j]
            place[i] += inverse[i, j] * bounds[active[j]]


@njit(cache=True, error_model="numpy")
def independent(basis: Array, work: Array, chosen: Index) -> None:
    """Choose r cables whose rows of the null basis are independent: each time the row with most left.

    Args:
        basis: ``N``, orthonormal columns, (m, r).
        work: Overwritten, (m, r).
        chosen: Written, (r,).
    """
    m, r = basis.shape
    for i in range(m):
        for j in range(r):
            work[i, j] = basis[i, j]
    for k in range(r):
        most = -1.0
        for i in range(m):
            size = 0.0
            for j in range(r):
                size += work[i, j] * work[i, j]
            if size > most:
                most, chosen[k] = size, i
        best = chosen[k]
        for i in range(m):
            if i == best:
                continue
            dot = 0.0
            for j in range(r):
                dot += work[i, j] * work[best, j]
            for j in range(r):
                work[i, j] -= dot / most * work[best, j]
        for j in range(r):
            work[best, j] = 0.0


@njit(cache=True, error_model="numpy")
def room(m: int, r: int) -> int:
    """How much workspace the programs below need for m cables, r of them too many."""
    return 3 * m * (r + 2) + (2 * r + 3) * (r + 1)


@njit(cache=True, error_model="numpy")
def _table(count: int, d: int, space: Array) -> tuple[Array, Array, Array, Array]:
    """Cut rows (count, d), bounds (count,), inverse (d, 2 d) and weights (d,) out of the workspace."""
    a = count * d
    b = a + count
    c = b + 2 * d * d
    return space[:a].reshape(count, d), space[a:b], space[b:c].reshape(d, 2 * d), space[c : c + d]


@njit(cache=True, error_model="numpy")
def deepest(
    start: Array, basis: Array, lower: Array, upper: Array, chosen: Index,
    space: Array, active: Index, place: Array, proof: Array,
) -> bool:  # fmt: skip
    """The balancing tensions deepest inside the box: greatest least distance to a bound.

    Args:
        start: (m,) [N].
        basis: ``N``, (m, r).
        lower: (m,) [N].
        upper: (m,) [N].
        chosen: From `independent`, (r,).
        space: Overwritten, `room` long.
        active: Written, the bounds that set the depth: the cable's index, plus m for an upper bound, (r + 1,).
        place: Written, ``lambda`` and the depth, (r + 1,) [N]; the depth is negative where no tensions are inside.
        proof: Written, ``v`` (m,) perpendicular to ``N``, of absolute sum at most 1, with ``v . (f - start) >= -depth``
            for every ``f`` in the box.

    Returns:
        Whether it was found; it always exists.
    """
    m, r = basis.shape
    rows, bounds, inverse, weights = _table(2 * m, r + 1, space)
    for i in range(m):
        for j in range(r):
            rows[i, j], rows[m + i, j] = -basis[i, j], basis[i, j]
        rows[i, r] = rows[m + i, r] = 1.0
        bounds[i], bounds[m + i] = start[i] - lower[i], upper[i] - start[i]
    for j in range(r):
        active[j + 1], weights[j + 1] = chosen[j], 0.0
    active[0], weights[0] = 0, 1.0
    if r > 0:
        active[0], weights[0], weights[1] = m + chosen[0], 0.5, 0.5
    found = climb(rows, bounds, active, inverse, weights, place)
    for i in range(m):
        proof[i] = 0.0
    for j in range(r + 1):
        proof[active[j] % m] += weights[j] if active[j] < m else -weights[j]
    return found


@njit(cache=True, error_model="numpy")
def cheapest(
    largest: bool, start: Array, basis: Array, lower: Array, upper: Array, cost: Array, chosen: Index,
    space: Array, active: Index, place: Array,
) -> bool:  # fmt: skip
    """The balancing tensions in the box whose largest is least, or of least ``cost . f``.

    One function for both, so that they share one compiled copy of `climb`.

    Args:
        largest: Which of the two.
        start: (m,) [N].
        basis: ``N``, (m, r), r > 0.
        lower: (m,) [N].
        upper: (m,) [N].
        cost: Of each cable's tension, (m,).
        chosen: From `independent`, (r,).
        space: Overwritten, `room` long.
        active: Overwritten, (r + 1,).
        place: Written, ``lambda`` and, for the first, the largest tension, (r + 1,) [N].

    Returns:
        Whether it was found; False where no balancing tensions are in the box.
    """
    m, r = basis.shape
    count, d = (3 * m, r + 1) if largest else (2 * m, r)
    rows, bounds, inverse, weights = _table(count, d, space)
    for i in range(m):
        for j in range(r):
            rows[i, j], rows[m + i, j] = -basis[i, j], basis[i, j]
        bounds[i], bounds[m + i] = start[i] - lower[i], upper[i] - start[i]
    if largest:
        for i in range(m):
            for j in range(r):
                rows[2 * m + i, j] = basis[i, j]
            rows[i, r] = rows[m + i, r] = 0.0
            rows[2 * m + i, r] = -1.0
            bounds[2 * m + i] = -start[i]
        for j in range(r):
            active[j + 1], weights[j + 1] = chosen[j], 0.0
        active[0], weights[0], weights[1] = 2 * m + chosen[0], 1.0, 1.0
    else:
        _price(basis, cost, chosen, rows, bounds, active, inverse, weights, place)
    return climb(rows, bounds, active[:d], inverse, weights, place[:d])


@njit(cache=True, error_model="numpy")
def _price(
    basis: Array, cost: Array, chosen: Index,
    rows: Array, bounds: Array, active: Index, inverse: Array, weights: Array, place: Array,
) -> None:  # fmt: skip
    """Write which bounds of the chosen cables make up the cost, and their multipliers: signs choose the side."""
    m, r = basis.shape
    for j in range(r):
        active[j] = m + chosen[j]
    _settle(rows, bounds, active[:r], inverse, place[:r])
    for j in range(r):
        weights[j] = 0.0
        for i in range(r):
            slope = 0.0
            for k in range(m):
                slope -= cost[k] * basis[k, i]
            weights[j] += slope * inverse[i, j]
    for j in range(r):
        if weights[j] < 0.0:
            active[j], weights[j] = chosen[j], -weights[j]
