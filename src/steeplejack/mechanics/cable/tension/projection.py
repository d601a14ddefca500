"""Balancing tensions nearest to wanted ones inside the box: weighted squares, and p-norms by a sequence of them.

All tensions that balance a wrench are ``f = start + N lambda`` with a null basis ``N`` (m, r), so "nearest" is a
projection onto a polytope in r unknowns. It is strictly convex: the answer is unique, and moves continuously with pose,
wrench and bounds as long as the feasible set has an interior.

The projection follows the dual active-set method of Goldfarb and Idnani (1983): from the wanted point take in the bound
that is violated most, give up those whose multiplier runs out, until none is violated. The p-norm is minimised by
Newton's method, each step such a projection in the metric of its Hessian, with a line search; p >= 2 keeps it convex.

The kernels write to arrays of the caller and trust finite input.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.cholesky import cholesky
from steeplejack.mechanics.cable.tension.powers import raised

Array = NDArray[np.float64]
Index = NDArray[np.int64]

ROUNDING = 1e-13  # [1] violation taken for rounding, relative to the terms of the inequality itself
DEPENDENT = 1e-20  # [1] squared share of a row below which it counts as dependent on the active ones
MOST_STEPS = 1000  # bounds taken in or given up before giving up; a handful are usual
MOST_NEWTON = 200  # Newton steps; under ten are usual
FLOOR = 1e-14  # [1] added to a metric, relative to its trace, so that it is never singular
SETTLED = 1e-12  # [1] Newton step that ends the search, relative to the largest distance


@njit(cache=True, error_model="numpy")
def room(m: int, r: int) -> int:
    """How much workspace the programs below need for m cables, r of them too many."""
    return (r + 1) + (2 * r + 2) * r + r * r + m * r + 3 * m + 2 * r


@njit(cache=True, error_model="numpy")
def project(start: Array, rows: Array, lower: Array, upper: Array, x: Array, space: Array, active: Index) -> bool:
    """Replace ``x`` by the nearest point (in the plain norm) with ``lower <= start + rows @ x <= upper``.

    Args:
        start: (m,).
        rows: (m, r), r > 0.
        lower: (m,).
        upper: (m,).
        x: Where to project from, (r,); the projection on return.
        space: Overwritten, `room` long.
        active: Overwritten, (at least r,); bounds met: the row, plus m for an upper one.

    Returns:
        Whether it was found; False where the set is empty, or so thin that rounding decides.
    """
    m, r = rows.shape
    weights, frame = space[: r + 1], space[r + 1 : r + 1 + (2 * r + 2) * r].reshape(2 * r + 2, r)
    count, steps = 0, 0
    while True:
        enters, worst = -1, 0.0
        for i in range(m):
            value, terms = start[i], abs(start[i])
            for j in range(r):
                value += rows[i, j] * x[j]
                terms += abs(rows[i, j] * x[j])
            if value - upper[i] > max(worst, ROUNDING * (terms + abs(upper[i]))):
                enters, worst = i + m, value - upper[i]
            if lower[i] - value > max(worst, ROUNDING * (terms + abs(lower[i]))):
                enters, worst = i, lower[i] - value
        if enters < 0:
            return True
        weights[count] = 0.0
        joined = False
        while not joined:
            steps += 1
            free = _decompose(rows, active, count, enters, frame)
            partial, leaves = math.inf, -1
            for j in range(count):
                share = frame[2 * r + 1, j]
                if share > 0.0 and weights[j] / share < partial:
                    partial, leaves = weights[j] / share, j
            full = worst / free if free > 0.0 else math.inf
            step = min(partial, full)
            if step == math.inf or steps > MOST_STEPS:
                return False
            for j in range(r):
                x[j] -= step * frame[2 * r, j]
            for j in range(count):
                weights[j] -= step * frame[2 * r + 1, j]
            worst -= step * free
            weights[count] += step
            joined = full <= partial
            if joined:
                active[count] = enters
                count += 1
            else:
                _drop(active, weights, leaves, count)
                count -= 1


@njit(cache=True, error_model="numpy")
def _drop(active: Index, weights: Array, leaves: int, count: int) -> None:
    """Close the gap an active bound leaves; the entering one's multiplier, after the others, moves up too."""
    for j in range(leaves, count):
        weights[j] = weights[j + 1]
        if j + 1 < count:
            active[j] = active[j + 1]


@njit(cache=True, error_model="numpy")
def _decompose(rows: Array, active: Index, count: int, enters: int, frame: Array) -> float:
    """Split the entering row into a combination of the active ones and a rest; the squared length of the rest.

    ``frame`` holds an orthonormal frame of the active rows (r rows), their triangle (r rows), the rest (one row) and
    the shares of the combination (one row). The rest is zero, and so is what is returned, where the row depends on the
    active ones.
    """
    m, r = rows.shape
    rest = 0.0
    for k in range(count + 1):
        bound = active[k] if k < count else enters
        target = k if k < count else 2 * r
        sign = -1.0 if bound < m else 1.0
        length = 0.0
        for j in range(r):
            frame[target, j] = sign * rows[bound % m, j]
            length += frame[target, j] ** 2
        if k == count:
            for i in range(count):
                frame[2 * r + 1, i] = 0.0
        for _ in range(2):
            for i in range(min(k, count)):
                dot = 0.0
                for j in range(r):
                    dot += frame[i, j] * frame[target, j]
                for j in range(r):
                    frame[target, j] -= dot * frame[i, j]
                if k < count:
                    frame[r + i, k] = dot if _ == 0 else frame[r + i, k] + dot
                else:
                    frame[2 * r + 1, i] += dot
        rest = 0.0
        for j in range(r):
            rest += frame[target, j] ** 2
        if k < count:
            frame[r + k, k] = math.sqrt(rest)
            for j in range(r):
                frame[k, j] /= frame[r + k, k]
        elif count == r or rest <= DEPENDENT * length:
            rest = 0.0
            for j in range(r):
                frame[target, j] = 0.0
    for k in range(count - 1, -1, -1):
        for i in range(k + 1, count):
            frame[2 * r + 1, k] -= frame[r + k, i] * frame[2 * r + 1, i]
        frame[2 * r + 1, k] /= frame[r + k, k]
    return rest


@njit(cache=True, error_model="numpy")
def nearest(
    start: Array, basis: Array, weight: Array, slope: Array, lower: Array, upper: Array, x: Array,
    space: Array, active: Index,
) -> bool:  # fmt: skip
    """Minimise ``1/2 sum weight_i (N x)_i^2 - slope . x`` subject to ``lower <= start + N x <= upper``.

    Args:
        start: (m,).
        basis: ``N``, (m, r), r > 0.
        weight: Not negative, positive where the null space needs it, (m,).
        slope: (r,).
        lower: (m,).
        upper: (m,).
        x: Written, (r,).
        space: Overwritten, `room` long.
        active: Overwritten, (at least r,).

    Returns:
        Whether it was found, as of `project`.
    """
    m, r = basis.shape
    a = r + 1 + (2 * r + 2) * r
    metric, turned = space[a : a + r * r].reshape(r, r), space[a + r * r : a + r * r + m * r].reshape(m, r)
    trace = 0.0
    for k in range(r):
        for j in range(k + 1):
            metric[k, j] = 0.0
            for i in range(m):
                metric[k, j] += weight[i] * basis[i, k] * basis[i, j]
        trace += metric[k, k]
    for k in range(r):
        metric[k, k] += FLOOR * trace
    if not cholesky(metric, 0.0, metric) > 0.0:
        return False
    for k in range(r):
        x[k] = slope[k]
        for j in range(k):
            x[k] -= metric[k, j] * x[j]
        x[k] /= metric[k, k]
        for i in range(m):
            turned[i, k] = basis[i, k]
            for j in range(k):
                turned[i, k] -= metric[k, j] * turned[i, j]
            turned[i, k] /= metric[k, k]
    found = project(start, turned, lower, upper, x, space, active)
    for k in range(r - 1, -1, -1):
        for j in range(k + 1, r):
            x[k] -= metric[j, k] * x[j]
        x[k] /= metric[k, k]
    return found


@njit(cache=True, error_model="numpy")
def least_power(
    start: Array, basis: Array, lower: Array, upper: Array, reference: Array, power: float, x: Array,
    space: Array, active: Index,
) -> None:  # fmt: skip
    """Minimise ``sum |f_i - reference_i|^power`` over the balancing tensions in the box, from feasible ones.

    Args:
        start: (m,) [N].
        basis: ``N``, (m, r), r > 0.
        lower: (m,) [N].
        upper: (m,) [N].
        reference: (m,) [N].
        power: At least 2 [1].
        x: ``lambda`` of feasible tensions, (r,) [N]; the minimum on return.
        space: Overwritten, `room` long.
        active: Overwritten, (at least r,).
    """
    m, r = basis.shape
    a = r + 1 + (2 * r + 2) * r + r * r + m * r
    weight, tensions, offset = space[a : a + m], space[a + m : a + 2 * m], space[a + 2 * m : a + 3 * m]
    slope, step = space[a + 3 * m : a + 3 * m + r], space[a + 3 * m + r : a + 3 * m + 2 * r]
    for _ in range(MOST_NEWTON):
        scale = 0.0
        for i in range(m):
            tensions[i] = start[i]
            for j in range(r):
                tensions[i] += basis[i, j] * x[j]
            offset[i] = tensions[i] - reference[i]
            scale = max(scale, abs(offset[i]))
        if scale == 0.0:
            return
        for j in range(r):
            slope[j] = 0.0
        for i in range(m):
            share = raised(abs(offset[i]) / scale, power - 2.0)
            weight[i] = (power - 1.0) * share
            pull = share * offset[i]
            for j in range(r):
                slope[j] -= pull * basis[i, j]
        if not nearest(tensions, basis, weight, slope, lower, upper, step, space, active):
            return
        fall, length = 0.0, 0.0
        for j in range(r):
            fall += slope[j] * step[j]
            length += step[j] ** 2
        if math.sqrt(length) <= SETTLED * scale or not fall > 0.0:
            return
        share = _searched(offset, basis, step, power, scale, fall)
        if share == 0.0:
            return
        for j in range(r):
            x[j] += share * step[j]


@njit(cache=True, error_model="numpy")
def _searched(offset: Array, basis: Array, step: Array, power: float, scale: float, fall: float) -> float:
    """Share of a step that lowers the sum of powers enough (Armijo's rule); 0 where rounding hides any progress."""
    before = 0.0
    for i in range(offset.size):
        before += raised(abs(offset[i]) / scale, power)
    share = 1.0
    for _ in range(40):
        after = 0.0
        for i in range(offset.size):
            value = offset[i]
            for j in range(step.size):
                value += share * basis[i, j] * step[j]
            after += raised(abs(value) / scale, power)
        if before - after >= 1e-4 * share * power * fall / (scale * scale):
            return share
        share *= 0.5
    return 0.0
