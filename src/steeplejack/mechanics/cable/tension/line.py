"""Compiled arithmetic on the line of tensions that balance a wrench, for robots with one cable too many.

The equations ``structure @ f + wrench = 0`` leave a line ``f = start + lambda null`` (Eq. 9 of Zheng et al., CCRobot-S,
IEEE T-RO) with a null vector of unit length. Each cable puts two bounds on it, whose distances are straight lines in
``lambda``: one rises, one falls. How deep in the box the line goes, where it is inside, and which two bounds forbid it
is arithmetic on those.

A cable whose share of the null vector is at most ``degeneracy.TOLERANCE`` is not moved by it: its tension is the
wrench's.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.degeneracy import TOLERANCE
from steeplejack.mechanics.cable.tension.powers import raised

Array = NDArray[np.float64]

MOST_STEPS = 200  # of the search for the least sum of powers; under ten are usual
SETTLED = 1e-13  # [1] its last step, relative to lambda and the largest distance


@njit(cache=True, error_model="numpy")
def _bounds(null: Array, start: Array, lower: Array, upper: Array, i: int) -> tuple[float, float, float]:
    """Distances of cable ``i`` to its bounds at lambda = 0: the one rising with lambda, the one falling, the slope."""
    if null[i] >= 0.0:
        return start[i] - lower[i], upper[i] - start[i], null[i]
    return upper[i] - start[i], start[i] - lower[i], -null[i]


@njit(cache=True, error_model="numpy")
def deepest(null: Array, start: Array, lower: Array, upper: Array, proof: Array) -> float:
    """Greatest least distance to a bound [N]; ``proof`` gets the weights of the two bounds that set it.

    Of the rising and the falling line that are lowest at one place, the crossing is the next place, where a lower line
    takes the place of its like; each exchange lowers the crossing, and where there is no lower line it is the answer.
    """
    place, depth, share = 0.0, math.inf, 0.0
    first, second = 0, 0
    for _ in range(4 * null.size):
        low, high, i, j = math.inf, math.inf, 0, 0
        for k in range(null.size):
            rise, fall, slope = _bounds(null, start, lower, upper, k)
            if rise + slope * place < low:
                low, i = rise + slope * place, k
            if fall - slope * place < high:
                high, j = fall - slope * place, k
        if not min(low, high) < depth:
            break
        if depth == math.inf or low <= high:
            first = i
        if depth == math.inf or high <= low:
            second = j
        rise, _, up = _bounds(null, start, lower, upper, first)
        _, fall, down = _bounds(null, start, lower, upper, second)
        if up + down == 0.0:
            depth, share = min(low, high), 1.0 if low <= high else 0.0
            break
        crossing = (down * rise + up * fall) / (up + down)
        if not crossing < depth:
            break
        place, depth, share = (fall - rise) / (up + down), crossing, down / (up + down)
    for k in range(null.size):
        proof[k] = 0.0
    proof[first] += share if null[first] >= 0.0 else -share
    proof[second] -= 1.0 - share if null[second] >= 0.0 else share - 1.0
    return depth


@njit(cache=True, error_model="numpy")
def interval(null: Array, start: Array, lower: Array, upper: Array, level: float) -> tuple[float, float]:
    """Where along the line every distance is at least ``level``; cables it does not move do not limit it."""
    low, high = -np.inf, np.inf
    for i in range(null.size):
        rise, fall, slope = _bounds(null, start, lower, upper, i)
        if slope > TOLERANCE:
            low, high = max(low, (level - rise) / slope), min(high, (fall - level) / slope)
    if low > high:
        low = high = 0.5 * (low + high)
    return low, high


@njit(cache=True, error_model="numpy")
def least_largest(null: Array, start: Array, low: float, high: float) -> float:
    """Lambda in ``[low, high]`` whose largest tension is least; of several the one of least norm.

    From ``low`` up along the largest tension, from one cable to the next, until it grows.
    """
    place = low
    for _ in range(null.size):
        most, slope = -math.inf, 0.0
        for i in range(null.size):
            value = start[i] + place * null[i]
            if value > most or (value == most and null[i] > slope):
                most, slope = value, null[i]
        if slope > TOLERANCE:
            return place
        end, crossing = high, 0.0
        for i in range(null.size):
            if null[i] > slope:
                crossing = place + (most - start[i] - place * null[i]) / (null[i] - slope)
                if crossing < end:
                    end = crossing
        if slope >= -TOLERANCE:
            return min(max(0.0, place), end)
        if end <= place or end == high:
            return max(end, place)
        place = end
    return place


@njit(cache=True, error_model="numpy")
def least_power(null: Array, start: Array, reference: Array, power: float, low: float, high: float) -> float:
    """Lambda in ``[low, high]`` with the least ``sum |f_i - reference_i|^power``, power >= 2.

    The slope of a convex sum rises, and changes sign between the places where the first and the last cable reach their
    reference: Newton's method, and halving where it leaves the bracket or does not halve it.
    """
    first, last, place, stretch = math.inf, -math.inf, 0.0, 0.0
    for i in range(null.size):
        if abs(null[i]) > TOLERANCE:
            reached = (reference[i] - start[i]) / null[i]
            first, last = min(first, reached), max(last, reached)
            place += null[i] * null[i] * reached
            stretch += null[i] * null[i]
    low, high = min(max(low, first), high), max(min(high, last), low)
    place, before = min(max(place / stretch, low), high), high - low
    for _ in range(MOST_STEPS):
        scale, slope, curve = 0.0, 0.0, 0.0
        for i in range(null.size):
            if abs(null[i]) > TOLERANCE:
                scale = max(scale, abs(start[i] + place * null[i] - reference[i]))
        if scale == 0.0:
            return place
        for i in range(null.size):
            if abs(null[i]) > TOLERANCE:
                offset = (start[i] + place * null[i] - reference[i]) / scale
                share = raised(abs(offset), power - 2.0) * null[i]
                slope += share * offset
                curve += share * null[i] * (power - 1.0)
        low, high = (place, high) if slope < 0.0 else (low, place)
        step = -scale * slope / curve
        if not (low < place + step < high and abs(step) <= 0.5 * before):
            step = 0.5 * (low + high) - place
        place, before = place + step, abs(step)
        if before <= SETTLED * (abs(place) + scale):
            return place
    return place
