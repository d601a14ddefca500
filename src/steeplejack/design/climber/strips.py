"""The workspace of the 3-RPR mechanism strip by strip: for each w the set of x is a union of intervals, known exactly.

At fixed alpha and w every limit changes sides at a few places along x, all in closed form:

- limb i has length q where ``x = b_i - p_i cos a +- sqrt(q^2 - v_i^2)``, ``v_i = w - p_i sin a``;
- a hinge of it is turned by the angle t where ``x = b_i - p_i cos a + v_i tan t``;
- ``q1 q2 q3 det J``, linear in x, vanishes at one x.

Between neighbours nothing changes, so testing the middle of each gap decides it. Areas integrate the lengths of the
strips over w by Gauss-Legendre rules on panels that are halved until halving changes nothing.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from steeplejack.design.climber.limits import Arrays, Turn, determinant, holds

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
Marks = NDArray[np.int32]

MOST_ENDS = 32  # 3 limbs with 4 lengths and 4 turns, the singular surface, and the two ends of all
NODES, WEIGHTS = np.polynomial.legendre.leggauss(10)
PANELS = 48  # before any is halved: what is thinner along w than a panel's nodes and lies between them is missed
DEPTH = 40  # of halving


@njit(cache=True, error_model="numpy")
def intervals(w: float, turn: Turn, limits: Arrays, ends: Array) -> int:
    """Intervals of x reached at one w and alpha.

    Args:
        w: [m].
        turn: alpha [rad], its cosine and its sine.
        limits: `Limits.arrays`.
        ends: (MOST_ENDS,), filled with lower and upper ends in turn, ascending [m].

    Returns:
        How many intervals.
    """
    count = _candidates(w, turn, limits, ends)
    pieces, inside = 0, False
    for k in range(count - 1):
        low, high = ends[k], ends[k + 1]
        if not high > low:
            continue
        if holds(0.5 * (low + high), w, turn, limits):
            # Written behind what has been read: 2 pieces + 1 <= k + 1.
            if not inside:
                ends[2 * pieces] = low
                pieces += 1
            ends[2 * pieces - 1] = high
            inside = True
        else:
            inside = False
    return pieces


@njit(cache=True, error_model="numpy")
def _candidates(w: float, turn: Turn, limits: Arrays, ends: Array) -> int:
    """Places along x where a limit changes sides, ascending, between the ends that the largest lengths leave."""
    (alpha, cos, sin), (base, platform, bounds, neutral) = turn, limits
    if not w > 0.0:
        return 0
    left, right, count = -np.inf, np.inf, 0
    for i in range(3):
        middle, v = base[i] - platform[i] * cos, w - platform[i] * sin
        if not abs(v) < bounds[1]:
            return 0
        half = math.sqrt((bounds[1] - v) * (bounds[1] + v))
        left, right = max(left, middle - half), min(right, middle + half)
        if abs(v) < bounds[0]:
            half = math.sqrt((bounds[0] - v) * (bounds[0] + v))
            ends[count], ends[count + 1] = middle - half, middle + half
            count += 2
        if bounds[2] < math.pi:
            for end in range(2):
                for side in range(-1, 2, 2):
                    angle = neutral[i, end] + end * alpha + side * bounds[2]
                    if math.cos(angle) * v > 0.0:
                        ends[count] = middle + v * math.tan(angle)
                        count += 1
    if not left < right:
        return 0
    at_zero = determinant(0.0, w, cos, sin, base, platform)
    slope = determinant(1.0, w, cos, sin, base, platform) - at_zero
    if slope != 0.0:
        ends[count] = -at_zero / slope
        count += 1
    kept = 0
    for k in range(count):
        if left < ends[k] < right:
            ends[kept] = ends[k]
            kept += 1
    ends[kept], ends[kept + 1] = left, right
    ends[: kept + 2].sort()
    return kept + 2


@njit(cache=True, error_model="numpy")
def strip_length(w: float, turn: Turn, limits: Arrays, ends: Array) -> float:
    """Length of the set of x reached at one w and alpha [m]."""
    pieces = intervals(w, turn, limits, ends)
    total = 0.0
    for k in range(pieces):
        total += ends[2 * k + 1] - ends[2 * k]
    return total


@njit(cache=True, error_model="numpy")
def _panel(low: float, high: float, turn: Turn, limits: Arrays, ends: Array) -> float:
    """Gauss-Legendre rule for the strip lengths from ``low`` to ``high`` [m2]."""
    middle, half, total = 0.5 * (low + high), 0.5 * (high - low), 0.0
    for k in range(NODES.size):
        w = middle + half * NODES[k]
        total += WEIGHTS[k] * strip_length(w, turn, limits, ends)
    return half * total


@njit(cache=True, error_model="numpy")
def strip_area(alpha: float, limits: Arrays, tolerance: float) -> float:
    """Area reached at one orientation, by strips [m2].

    Args:
        alpha: [rad].
        limits: `Limits.arrays`.
        tolerance: Change, relative to the square of the largest length, below which a panel is not halved again.
    """
    turn, platform, largest = (alpha, math.cos(alpha), math.sin(alpha)), limits[1], limits[2][1]
    top = largest + min(platform[0] * turn[2], platform[1] * turn[2], platform[2] * turn[2])
    if not top > 0.0:
        return 0.0
    ends, stack = np.empty(MOST_ENDS), np.empty((DEPTH + 2, 4))
    total, enough = 0.0, tolerance * largest * largest
    for panel in range(PANELS):
        low, high = top * panel / PANELS, top * (panel + 1) / PANELS
        stack[0] = (low, high, _panel(low, high, turn, limits, ends), 0.0)
        left = 1
        while left > 0:
            left -= 1
            low, high, whole, depth = stack[left, 0], stack[left, 1], stack[left, 2], stack[left, 3]
            middle = 0.5 * (low + high)
            first = _panel(low, middle, turn, limits, ends)
            second = _panel(middle, high, turn, limits, ends)
            if abs(first + second - whole) <= enough or depth >= DEPTH:
                total += first + second
                continue
            stack[left] = (low, middle, first, depth + 1.0)
            stack[left + 1] = (middle, high, second, depth + 1.0)
            left += 2
    return total


@njit(cache=True, error_model="numpy")
def cell_span(low: float, high: float, step: float) -> tuple[int, int]:
    """First cell whose centre ``(k + 1/2) step`` is not below ``low``, and one past the last not above ``high``."""
    return math.ceil(low / step - 0.5), math.floor(high / step - 0.5) + 1


@njit(cache=True, parallel=True, error_model="numpy")
def count_cells(
    alphas: Array, step: float, base: Array, platform: Array, bounds: Array, neutral: Array, counts: Counts
) -> None:
    """Cells of a square grid whose centres are reached, at each orientation; fills ``counts``."""
    for a in prange(alphas.size):
        alpha = alphas[a]
        cos, sin, ends, total = math.cos(alpha), math.sin(alpha), np.empty(MOST_ENDS), 0
        top = bounds[1] + min(platform[0] * sin, platform[1] * sin, platform[2] * sin)
        for r in range(max(0, math.ceil(top / step - 0.5))):
            pieces = intervals((r + 0.5) * step, (alpha, cos, sin), (base, platform, bounds, neutral), ends)
            for k in range(pieces):
                first, past = cell_span(ends[2 * k], ends[2 * k + 1], step)
                total += max(0, past - first)
        counts[a] = total


@njit(cache=True, parallel=True, error_model="numpy")
def mark_cells(
    alphas: Array,
    step: float,
    first_column: int,
    first_row: int,
    base: Array,
    platform: Array,
    bounds: Array,
    neutral: Array,
    counts: Marks,
) -> None:
    """At how many of the orientations each cell's centre is reached, (rows of w, columns of x); adds to ``counts``."""
    for r in prange(counts.shape[0]):
        ends, w = np.empty(MOST_ENDS), (first_row + r + 0.5) * step
        for a in range(alphas.size):
            alpha = alphas[a]
            turn = (alpha, math.cos(alpha), math.sin(alpha))
            pieces = intervals(w, turn, (base, platform, bounds, neutral), ends)
            for k in range(pieces):
                first, past = cell_span(ends[2 * k], ends[2 * k + 1], step)
                for column in range(max(first - first_column, 0), min(past - first_column, counts.shape[1])):
                    counts[r, column] += 1
