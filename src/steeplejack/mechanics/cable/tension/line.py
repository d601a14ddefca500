"""Compiled arithmetic on the line of tensions that balance a wrench, for robots with one cable too many.

The equations ``structure @ f + wrench = 0`` leave a line ``f = start + lambda null`` (Eq. 9 of Zheng et al., CCRobot-S,
IEEE T-RO). Each cable puts two bounds on it, whose distances are straight lines in ``lambda``: one rises, one falls.
How deep in the box the line goes, where it is inside, and which two bounds forbid it is arithmetic on those.

`planar_margins` does so for a grid of planar poses of four cables, with null vector and start from cofactors; the
kernels of `choice` do it for any number of cables.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

Array = NDArray[np.float64]

TOLERANCE = (
    1e-9  # [1] relative volume of a singular matrix, and relative excess over a bound that still counts as inside
)


@njit(cache=True, error_model="numpy", parallel=True)
def planar_margins(
    roots: Array, arms: Array, xs: Array, ys: Array, wrench: Array, lower: Array, upper: Array,
    stays: Array, pull_limit: Array, half: float, margins: Array,
) -> None:  # fmt: skip
    """Margin of every node of a planar grid at one orientation; singular nodes and cables of no length get -inf.

    Args:
        roots: ``A_i - b_i``, (4, 2) [m].
        arms: ``b_i``, (4, 2) [m].
        xs: (nx,) [m].
        ys: (ny,) [m].
        wrench: ``(fx, fy, mz)`` on the platform, (3,) [N, N, N m].
        lower: (4,) [N].
        upper: (4,) [N].
        stays: Unit directions the anchors would slip along, (4, 2) [1].
        pull_limit: Greatest component of a cable's tension along its stay, (4,) [N]; infinite for none.
        half: Depth that counts as margin 1 [N].
        margins: Written, (ny, nx) [1].
    """
    for j in prange(ys.size):
        structure, limit, proof = np.empty((3, 4)), np.empty(4), np.empty(4)
        null, start, dual = np.empty(4), np.empty(4), np.empty((4, 3))
        for i in range(xs.size):
            attached = True
            for k in range(4):
                dx, dy = roots[k, 0] - xs[i], roots[k, 1] - ys[j]
                length = math.sqrt(dx * dx + dy * dy)
                attached = attached and length > 0.0
                scale = 1.0 / length if length > 0.0 else 0.0
                structure[0, k], structure[1, k] = dx * scale, dy * scale
                structure[2, k] = (arms[k, 0] * dy - arms[k, 1] * dx) * scale
                along = abs(structure[0, k] * stays[k, 0] + structure[1, k] * stays[k, 1])
                limit[k] = min(upper[k], pull_limit[k] / along) if along > 0.0 else upper[k]
            if attached and _solve(structure, wrench, null, start, dual):
                margins[j, i] = deepest(null, start, lower, limit, proof) / half
            else:
                margins[j, i] = -np.inf


@njit(cache=True, error_model="numpy")
def _solve(structure: Array, wrench: Array, null: Array, start: Array, dual: Array) -> bool:
    """Write the unit null vector, the start perpendicular to it and the dual; False where singular.

    The null vector points where the sum of tensions grows. The dual takes any ``v`` perpendicular to it to
    ``v @ dual = z`` with ``structure^T z = v``. The column with the largest cofactor is left out: the three that stay
    are the best conditioned.
    """
    rows = 1.0
    for i in range(3):
        rows *= math.sqrt(structure[i, 0] ** 2 + structure[i, 1] ** 2 + structure[i, 2] ** 2 + structure[i, 3] ** 2)
    out, volume = 0, 0.0
    for i in range(4):
        a, b, c = (i + 1) % 4, (i + 2) % 4, (i + 3) % 4
        u, v, w = _cross(structure, b, c)
        det = structure[0, a] * u + structure[1, a] * v + structure[2, a] * w
        null[i] = det if i % 2 == 0 else -det
        volume += det * det
        if abs(null[i]) > abs(null[out]):
            out = i
    volume = math.sqrt(volume)
    if not volume > TOLERANCE * rows:
        return False
    det = null[out] if out % 2 == 0 else -null[out]
    if null[0] + null[1] + null[2] + null[3] < 0.0:
        volume = -volume
    along = 0.0
    for step in range(4):
        i, b, c = (out + step) % 4, (out + 1 + step % 3) % 4, (out + 1 + (step + 1) % 3) % 4
        null[i] /= volume
        for r, part in enumerate(_cross(structure, b, c)):
            dual[i, r] = part / det if step > 0 else 0.0
        start[i] = -(dual[i, 0] * wrench[0] + dual[i, 1] * wrench[1] + dual[i, 2] * wrench[2])
        along += start[i] * null[i]
    for i in range(4):
        start[i] -= along * null[i]
    return True


@njit(cache=True, error_model="numpy")
def _cross(structure: Array, i: int, j: int) -> tuple[float, float, float]:
    """Cross product of two columns."""
    return (
        structure[1, i] * structure[2, j] - structure[2, i] * structure[1, j],
        structure[2, i] * structure[0, j] - structure[0, i] * structure[2, j],
        structure[0, i] * structure[1, j] - structure[1, i] * structure[0, j],
    )


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
    """Where along the line every distance is at least ``level``; cables null hardly moves do not limit it."""
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
