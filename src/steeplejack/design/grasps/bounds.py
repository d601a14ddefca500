"""Bounds of the tension factor over boxes of positions, compiled.

Over a box every ``P_i = N_i l_i`` is its value at the centre, a slope, and a rest of second order in the size of the
box. Where all ``P`` have the sign ``g``, the tension factor is the least ratio ``P_i / P_j``, so each pair bounds it:

    TF <= max over the box of (g P_i + rest_i) / (g P_j - rest_j),

a ratio of affine functions, whose maximum sits at a corner of the box if the divisor is positive there. Along a ridge,
where two ``P`` are equally small or equally large, no pair is tight; but a mean of the two with any weights bounds as
well, and with the weights that cancel its slope along or across it is tight to second order. The least of the twelve
pairs and of these, over both signs that the box may hold, is the bound; a sign falls away where some ``g N_i`` is
nowhere above what counts as zero.

At a singular position, and where a cable has no length, the tension factor is undefined, and beside it takes another
value from every side, however weak all cables together are there. Positions are therefore left out where the null
vector of the unit columns is nowhere above `SINGULAR` longest arms, or a cable is shorter than `SHORTEST` of them.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_FACTOR = 1e-9  # [1] tension factor that counts as zero, as in `wrench.closure`
LEAST_VOLUME = 1e-12  # [1] cofactor that counts as zero, over the longest arm times its cables' lengths
SHORTEST = 1e-3  # [1] length of a cable, over the longest arm, at which it still has a direction
SINGULAR = 1e-4  # [1] null vector of the unit columns, over the longest arm, at which a position is not yet singular
ROUNDING = 2.0**-48  # [1] of the operations on a box over the terms they act on


@njit(cache=True, error_model="numpy")
def factor_at(s: float, t: float, roots: Array, polynomials: Array, arm: float) -> float:
    """Tension factor at a position, 0 outside wrench closure.

    Args:
        s: Along the stay, scaled.
        t: Across it, scaled.
        roots: Of `Cofactors`, (4, 2).
        polynomials: Of `Cofactors`, (4, 6).
        arm: Of `Cofactors`.

    Returns:
        TF [1].
    """
    least, most, lengths, shortest = math.inf, -math.inf, 1.0, math.inf
    for i in range(4):
        c = polynomials[i]
        length = math.hypot(roots[i, 0] - s, roots[i, 1] - t)
        value = (c[0] + s * (c[1] + s * c[3] + t * c[4]) + t * (c[2] + t * c[5])) * length
        least, most, lengths = min(least, value), max(most, value), lengths * length
        shortest = min(shortest, length)
    small, large = max(least, -most), max(most, -least)
    if shortest < SHORTEST * arm or large < SINGULAR * arm * lengths:
        return 0.0
    return small / large if small > LEAST_FACTOR * large + LEAST_VOLUME * arm * lengths else 0.0


@njit(cache=True, error_model="numpy")
def bound_over(
    s: float, t: float, a: float, b: float,
    roots: Array, polynomials: Array, slack: Array, off: float, arm: float, model: Array, trial: Array,
) -> float:  # fmt: skip
    """Upper bound of the tension factor over a box, and a position in it that may come near: a corner or on a ridge.

    Args:
        s: Centre along the stay, scaled.
        t: Centre across it, scaled.
        a: Half side along the stay.
        b: Half side across it.
        roots: Of `Cofactors`, (4, 2).
        polynomials: Of `Cofactors`, (4, 6).
        slack: Of `Cofactors`, (4,).
        off: Of `Cofactors`.
        arm: Of `Cofactors`.
        model: Room for what `_models` writes and a mean of two, (5, 7).
        trial: Written, (2,).

    Returns:
        The bound, in [0, 1].
    """
    bound = 0.0
    trial[0], trial[1] = s, t
    if not _models(s, t, a, b, roots, polynomials, slack, off, arm, model):
        return bound
    for sign in (-1.0, 1.0):
        held = True
        for i in range(4):
            held &= (model[i, 5] if sign > 0.0 else -model[i, 4]) > model[i, 6]
        if held:
            ratio, along, across = _pairs(sign, a, b, model)
            mean, ridge_along, ridge_across = _ridges(sign, a, b, model)
            if mean < ratio:
                ratio, along, across = mean, ridge_along, ridge_across
            if ratio > bound:
                bound = ratio
                trial[0], trial[1] = s + along, t + across
    return bound


@njit(cache=True, error_model="numpy")
def _models(
    s: float, t: float, a: float, b: float,
    roots: Array, polynomials: Array, slack: Array, off: float, arm: float, model: Array,
) -> bool:  # fmt: skip
    """Write, for every cable: value, two slopes and rest of ``P``; least and greatest ``N``; what of ``N`` counts as 0.

    Returns False where all of the box is left out.

    The length is convex, so it lies above its tangent, and below it plus ``r^2 / (2 least)`` or ``2 r``, with ``r`` the
    distance from the centre to a corner.
    """
    r = math.hypot(a, b)
    product, nearest, largest = 1.0, math.inf, 0.0
    for i in range(4):
        c, x, y = polynomials[i], s - roots[i, 0], t - roots[i, 1]
        length = math.hypot(x, y)
        if length + r + off < SHORTEST * arm:
            return False
        ls, lt = (x / length, y / length) if length > 0.0 else (0.0, 0.0)
        shortest = max(length - r - off, 0.0)
        bend = r if shortest * 4.0 <= r else 0.25 * r * r / shortest
        middle, doubt = length + bend, bend + off + ROUNDING * (length + r)
        value = c[0] + s * (c[1] + s * c[3] + t * c[4]) + t * (c[2] + t * c[5])
        ns, nt = c[1] + 2.0 * c[3] * s + c[4] * t, c[2] + c[4] * s + 2.0 * c[5] * t
        spread, stretch = abs(ns) * a + abs(nt) * b, abs(ls) * a + abs(lt) * b
        rest = abs(c[3]) * a * a + abs(c[4]) * a * b + abs(c[5]) * b * b
        rest += slack[i] + ROUNDING * (abs(value) + spread)
        most = abs(value) + spread
        model[i, 0], model[i, 1], model[i, 2] = value * middle, ns * middle + value * ls, nt * middle + value * lt
        model[i, 3] = spread * stretch + rest * (middle + stretch + doubt) + most * doubt
        model[i, 3] += ROUNDING * most * (middle + stretch)
        model[i, 4], model[i, 5] = value - spread - rest, value + spread + rest
        largest = max(largest, (most + rest) * (middle + stretch + doubt))
        model[i, 6] = shortest
        product *= shortest
        nearest = min(nearest, shortest)
    for i in range(4):
        model[i, 6] = LEAST_VOLUME * arm * (product / model[i, 6] if nearest > 0.0 else 0.0)
    return largest >= SINGULAR * arm * product


@njit(cache=True, error_model="numpy")
def _pairs(sign: float, a: float, b: float, model: Array) -> tuple[float, float, float]:
    """Least of the bounds of the twelve ratios, at most 1, and from the centre to the corner it is reached at."""
    bound, along, across = 1.0, 0.0, 0.0
    for j in range(4):
        for i in range(4):
            if i != j:
                ratio, p, q = _largest(sign, a, b, model[i], model[j])
                if ratio < bound:
                    bound, along, across = ratio, p, q
    return max(bound, 0.0), along, across


@njit(cache=True, error_model="numpy")
def _ridges(sign: float, a: float, b: float, model: Array) -> tuple[float, float, float]:
    """Least of the bounds by means of the two smallest and of the two largest, and from the centre to that ridge."""
    least, less, more, most = _order(sign, model)
    bound, along, across = 1.0, 0.0, 0.0
    for first, second, other in ((least, less, most), (most, more, least)):
        small = first == least
        one, two, rest = model[first], model[second], model[other]
        # Of the ratio to the third, up to a common factor: only slopes that differ in sign can cancel.
        for k in range(1, 3):
            u, v = one[k] * rest[0] - rest[k] * one[0], two[k] * rest[0] - rest[k] * two[0]
            if not u * v < 0.0:
                continue
            share = v / (v - u)
            for m in range(4):
                model[4, m] = share * one[m] + (1.0 - share) * two[m]
            top, bottom = (4, other) if small else (other, 4)
            ratio, _, _ = _largest(sign, a, b, model[top], model[bottom])
            if ratio < bound:
                ds, dt = one[1] - two[1], one[2] - two[2]
                step = (two[0] - one[0]) / (ds * ds + dt * dt)
                bound, along, across = ratio, step * ds, step * dt
    return max(bound, 0.0), along, across


@njit(cache=True, error_model="numpy")
def _order(sign: float, model: Array) -> tuple[int, int, int, int]:
    """Cables by their ``P`` at the centre, the smallest first."""
    i, j, k, m = 0, 1, 2, 3
    if sign * model[j, 0] < sign * model[i, 0]:
        i, j = j, i
    if sign * model[m, 0] < sign * model[k, 0]:
        k, m = m, k
    if sign * model[k, 0] < sign * model[i, 0]:
        i, k = k, i
    if sign * model[m, 0] < sign * model[j, 0]:
        j, m = m, j
    if sign * model[k, 0] < sign * model[j, 0]:
        j, k = k, j
    return i, j, k, m


@njit(cache=True, error_model="numpy")
def _largest(sign: float, a: float, b: float, top: Array, bottom: Array) -> tuple[float, float, float]:
    """Bound of the ratio of two models over the box, infinite where the lower may vanish, and to which corner."""
    above, below = sign * top[0] + top[3], sign * bottom[0] - bottom[3]
    spread = abs(bottom[1]) * a + abs(bottom[2]) * b
    if not below - spread > 0.0:
        return math.inf, 0.0, 0.0
    largest, along, across = -math.inf, 0.0, 0.0
    for p in (-a, a):
        for q in (-b, b):
            ratio = (above + sign * (p * top[1] + q * top[2])) / (below + sign * (p * bottom[1] + q * bottom[2]))
            if ratio > largest:
                largest, along, across = ratio, p, q
    terms = abs(above) + abs(top[1]) * a + abs(top[2]) * b + abs(below) + spread
    return largest + ROUNDING * terms / (below - spread), along, across
