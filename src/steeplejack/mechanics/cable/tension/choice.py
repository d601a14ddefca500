"""Compiled choice of tensions for a batch of questions; the kernel behind `distribute`.

For each question: decide it and find how deep in the tension box the balancing tensions ``f = start + N lambda`` go
(`depth`), and, where they go inside, choose ``lambda`` by the method asked for. Nothing here depends on which null
basis ``N`` came out: every method is stated in tensions.

Methods that work on the surface of the feasible set get a box widened within what may be passed of each bound, and
where even that set is too thin for them, the deepest tensions stand: they are known to be inside. So a complete method
never misses.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.degeneracy import TOLERANCE
from steeplejack.mechanics.cable.status import MISSED, NO, UNDEFINED, YES
from steeplejack.mechanics.cable.tension import line, linear, projection
from steeplejack.mechanics.cable.tension.depth import settle, share_of_window, soften
from steeplejack.mechanics.cable.tension.methods import (
    BARYCENTRE,
    CLOSED_FORM,
    IMPROVED,
    LP,
    MAX_MARGIN,
    MIN_MAX,
    MIN_NORM,
    P_NORM,
    QP,
)
from steeplejack.mechanics.cable.tension.polygon import centroid, clip

Array = NDArray[np.float64]
Index = NDArray[np.int64]

ROUNDING = 1e-12  # [1] widening of a box without depth, relative to the largest tension met


@njit(cache=True, error_model="numpy")
def distribute_each(
    structures: Array, wrenches: Array, lowers: Array, uppers: Array, references: Array, costs: Array,
    method: int, power: float,
    tensions: Array, interval: Array, certificate: Array, margin: Array, status: Index,
) -> None:  # fmt: skip
    """Tensions of every question of a batch.

    Args:
        structures: (k, n, m), n <= m.
        wrenches: (k, n).
        lowers: (k, m) [N].
        uppers: (k, m) [N]; may be inf where the method takes open windows.
        references: (k or 1, m) [N].
        costs: Weights, (k or 1, m).
        method: A number of `methods`.
        power: Of the p-norm [1].
        tensions: Written where they exist, (k, m) [N].
        interval: Written for one cable too many where feasible, (k, 2) [N].
        certificate: Written where infeasible or singular, (k, n).
        margin: Written, (k,) [1].
        status: Written, (k,).
    """
    n, m = structures.shape[1], structures.shape[2]
    r = m - n
    left, tau, scale, order = np.empty((n, m)), np.empty(n), np.empty(n), np.empty(n, np.int64)
    start, basis, proof, work = np.empty(m), np.empty((m, r)), np.empty(m), np.empty((m, r))
    chosen, active, place, x = np.empty(r, np.int64), np.empty(r + 1, np.int64), np.empty(r + 1), np.empty(r)
    low, high, least, most, weight = np.empty(m), np.empty(m), np.empty(m), np.empty(m), np.empty(m + r)
    space = np.empty(max(linear.room(m, r), projection.room(m, r)))
    points, labels = np.empty((2, 2 * m + 4, 2)), np.empty((2, 2 * m + 4), np.int64)
    for k in range(structures.shape[0]):
        lower, upper = lowers[k], uppers[k]
        reference, cost = references[min(k, references.shape[0] - 1)], costs[min(k, costs.shape[0] - 1)]
        margin[k], status[k] = -np.inf, UNDEFINED
        acting = _asked(method, reference, cost, lower, upper)
        if not acting < np.inf:
            continue
        status[k], depth = settle(
            structures[k], wrenches[k], lower, upper, acting, left, tau, scale, order, start, basis, low, high,
            least, most, chosen, work, space, active, place, proof, certificate[k],
        )  # fmt: skip
        if status[k] > NO:
            continue
        margin[k] = share_of_window(status[k], depth, start, lower, upper)
        _copy(place, x)
        if status[k] == YES:
            if depth >= 0.0:
                _widen(low, high, ROUNDING * _size(start, low, high) - depth, least, most)
            if r == 1:
                null = basis.reshape(m)
                _bracket(null, start, lower, upper, least, most, depth, interval[k])
                if method != IMPROVED:
                    x[0] = _on_line(method, power, reference, cost, start, null, lower, upper, depth, interval[k])
            if r == 2 and method == BARYCENTRE:
                _middle(start, basis, lower, upper, least, most, depth, chosen, points, labels, x)
            elif r > 1 or r == 1 and method == IMPROVED:
                _choose(
                    method, power, reference, cost, start, basis, low, high, least, most, weight, depth, chosen,
                    space, active, place, x,
                )  # fmt: skip
        _tensions(start, basis, x, tensions[k])
        if status[k] == YES and not _kept(method, start, basis, low, high, least, most, x, space, active, tensions[k]):
            status[k] = MISSED


@njit(cache=True, error_model="numpy")
def _asked(method: int, reference: Array, cost: Array, lower: Array, upper: Array) -> float:
    """Largest reference of a question [N]; infinite where reference, weights or open windows mean nothing to a method.

    Without upper bounds there is no middle and no greatest depth, and a sum with a negative weight has no least.
    """
    size, total, opened, negative = 0.0, 0.0, False, False
    for i in range(lower.size):
        size = max(size, abs(reference[i]))
        total += abs(reference[i]) + abs(cost[i]) + abs(lower[i])
        opened = opened or math.isinf(upper[i])
        negative = negative or cost[i] < 0.0
    if opened and (
        method == BARYCENTRE
        or method == CLOSED_FORM
        or method == IMPROVED
        or method == MAX_MARGIN
        or (method == LP and negative)
    ):
        return np.inf
    return size if total < np.inf else np.inf


@njit(cache=True, error_model="numpy")
def _bracket(
    null: Array, start: Array, lower: Array, upper: Array, least: Array, most: Array, depth: float, ends: Array
) -> None:
    """Write the ``lambda`` between which all bounds are kept, or what may be passed of them where they are not."""
    if depth >= 0.0:
        ends[0], ends[1] = line.interval(null, start, lower, upper, 0.0)
    else:
        ends[0], ends[1] = line.interval(null, start, least, most, 0.0)


@njit(cache=True, error_model="numpy")
def _on_line(
    method: int, power: float, reference: Array, cost: Array, start: Array, null: Array, lower: Array, upper: Array,
    depth: float, ends: Array,
) -> float:  # fmt: skip
    """``lambda`` of the method for one cable too many; between its ``ends`` it is inside the box."""
    low, high = ends[0], ends[1]
    if method == BARYCENTRE:
        return 0.5 * (low + high)
    if method == MIN_MAX:
        return line.least_largest(null, start, low, high)
    if method == MIN_NORM:
        return min(max(0.0, low), high)
    if method == P_NORM:
        return line.least_power(null, start, reference, power, low, high)
    pull, stretch, middle = 0.0, 0.0, 0.0
    for i in range(null.size):
        pull += cost[i] * null[i] * (1.0 if method == LP else reference[i] - start[i])
        stretch += cost[i] * null[i] * null[i]
        middle += 0.5 * (lower[i] + upper[i]) * null[i]
    if method == LP:
        return low if pull >= 0.0 else high
    if method == QP:
        return min(max(pull / stretch, low), high)
    if method == MAX_MARGIN:
        low, high = line.interval(null, start, lower, upper, depth)
        return min(max(middle, low), high)
    return middle


@njit(cache=True, error_model="numpy")
def _middle(
    start: Array, basis: Array, lower: Array, upper: Array, least: Array, most: Array, depth: float, chosen: Index,
    points: Array, labels: Index, x: Array,
) -> None:  # fmt: skip
    """Write the centre of the polygon to ``x``, which holds the deepest tensions and keeps them where it is a point."""
    if depth >= 0.0:
        corners = clip(start, basis, lower, upper, chosen, points, labels)
    else:
        corners = clip(start, basis, least, most, chosen, points, labels)
    if corners > 0:
        x[0], x[1] = centroid(points[0], corners)


@njit(cache=True, error_model="numpy")
def _kept(
    method: int, start: Array, basis: Array, low: Array, high: Array, least: Array, most: Array, x: Array,
    space: Array, active: Index, tensions: Array,
) -> bool:  # fmt: skip
    """Whether chosen tensions keep their bounds; those of a complete method, moved by rounding, are brought back."""
    soften(start, basis, x, low, high, least, most)
    if method != CLOSED_FORM and method != IMPROVED and x.size > 0 and _outside(tensions, least, most):
        projection.project(start, basis, least, most, x, space, active)
        _tensions(start, basis, x, tensions)
    soften(start, basis, x, least, most, least, most)
    return not _outside(tensions, least, most)


@njit(cache=True, error_model="numpy")
def _choose(
    method: int, power: float, reference: Array, cost: Array, start: Array, basis: Array, lower: Array, upper: Array,
    least: Array, most: Array, weight: Array, depth: float, chosen: Index,
    space: Array, active: Index, place: Array, x: Array,
) -> None:  # fmt: skip
    """Write ``lambda`` of the method to ``x``, which holds the deepest one; it stays where rounding defeats a method.

    ``least`` and ``most`` are the bounds, widened; they and ``weight`` (m + r,) may be overwritten. Every method but
    the linear and the closed ones ends in one projection.
    """
    m, r = basis.shape
    if method == MIN_MAX or method == LP:
        found = linear.cheapest(method == MIN_MAX, start, basis, least, most, cost, chosen, space, active, place)
        if found:
            _copy(place, x)
        if not found or method == LP:
            return
        for i in range(m):
            most[i] = min(most[i], place[r] + ROUNDING * _size(start, place, place))
    for i in range(m):
        weight[i] = cost[i] if method == QP else 1.0
    for j in range(r):
        place[j] = 0.0
        if method == QP:
            for i in range(m):
                place[j] += cost[i] * basis[i, j] * (reference[i] - start[i])
        elif method == CLOSED_FORM or method == IMPROVED or method == MAX_MARGIN:
            for i in range(m):
                place[j] += 0.5 * (lower[i] + upper[i]) * basis[i, j]
    if method == CLOSED_FORM or method == IMPROVED:
        if method == IMPROVED:
            _meet(start, basis, lower, upper, space, place)
        _copy(place, x)
        return
    if method == MAX_MARGIN:
        inset = depth - ROUNDING * (abs(depth) + _size(start, x, x))
        for i in range(m):
            least[i], most[i] = lower[i] + inset, upper[i] - inset
    slope = weight[m : m + r]
    _copy(place, slope)
    if projection.nearest(start, basis, weight[:m], slope, least, most, place[:r], space, active):
        _copy(place, x)
    if method == P_NORM:
        projection.least_power(start, basis, least, most, reference, power, x, space, active)


@njit(cache=True, error_model="numpy")
def _copy(place: Array, x: Array) -> None:
    """Write ``lambda`` to ``x``; element by element, which is faster than a slice for so few."""
    for j in range(x.size):
        x[j] = place[j]


@njit(cache=True, error_model="numpy")
def _size(start: Array, lower: Array, upper: Array) -> float:
    """Largest force that enters [N]; rounding is measured against it."""
    size = 0.0
    for i in range(start.size):
        size = max(size, abs(start[i]))
    for i in range(lower.size):
        size = max(size, max(abs(lower[i]), abs(upper[i])))
    return float(size)


@njit(cache=True, error_model="numpy")
def _widen(lower: Array, upper: Array, slack: float, least: Array, most: Array) -> None:
    """Draw softened bounds in to what leaves the feasible set some thickness, if only that of rounding."""
    slack = max(slack, 0.0)
    for i in range(lower.size):
        least[i], most[i] = max(least[i], lower[i] - slack), min(most[i], upper[i] + slack)


@njit(cache=True, error_model="numpy")
def _meet(start: Array, basis: Array, lower: Array, upper: Array, space: Array, place: Array) -> None:
    """From the closed form, fix the cable that is worst outside on its bound, and again, while cables are left.

    Fixing a cable and solving the closed form of the others is a projection onto the plane where its tension is that
    bound, within the planes of those fixed before.
    """
    m, r = basis.shape
    frame = space[: r * r].reshape(r, r)
    for count in range(r):
        cable, worst = -1, 0.0
        for i in range(m):
            value = start[i]
            for j in range(r):
                value += basis[i, j] * place[j]
            gap = max(lower[i] - value, 0.0) - max(value - upper[i], 0.0)
            if abs(gap) > abs(worst):
                cable, worst = i, gap
        if cable < 0:
            return
        size = 0.0
        for j in range(r):
            frame[count, j] = basis[cable, j]
        for k in range(count):
            dot = 0.0
            for j in range(r):
                dot += frame[k, j] * frame[count, j]
            for j in range(r):
                frame[count, j] -= dot * frame[k, j]
        for j in range(r):
            size += frame[count, j] ** 2
        if size < TOLERANCE**2:
            return
        for j in range(r):
            place[j] += worst * frame[count, j] / size
            frame[count, j] /= math.sqrt(size)


@njit(cache=True, error_model="numpy")
def _tensions(start: Array, basis: Array, x: Array, tensions: Array) -> None:
    """Write ``f = start + N x``."""
    for i in range(start.size):
        tensions[i] = start[i]
        for j in range(x.size):
            tensions[i] += basis[i, j] * x[j]


@njit(cache=True, error_model="numpy")
def _outside(tensions: Array, least: Array, most: Array) -> bool:
    """Whether a tension passes a bound."""
    for i in range(tensions.size):
        if tensions[i] < least[i] or tensions[i] > most[i]:
            return True
    return False
