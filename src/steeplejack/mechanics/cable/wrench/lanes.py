"""Compiled tension factors of an eight-cable spatial robot straight from poses, many poses abreast.

The arithmetic is that of `sectors` for two cables too many, on blocks of ``LANES`` poses: every loop over a block is a
run of vector instructions. Two things make that possible. All poses of a block share the order of pivots, each the
column whose smallest entry over the block is largest; and every pose goes all the way, its answer picked at the end.
A pose that shared pivots do not suit (one below ``PIVOT``, or rows of ``N`` above ``GROWTH``) or whose factor is below
`sectors.NARROW` is told to the caller, who settles it on its own.

Moments are divided by the longest arm, so that cables through one point are told from a small robot.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.structure import LENGTHLESS
from steeplejack.mechanics.cable.wrench.sectors import NARROW, PARALLEL

Array = NDArray[np.float64]

LANES = 64
PIVOT = 1e-3  # [1] shared pivot below which a pose is settled on its own
GROWTH = 1e2  # [1] entry of N above which a pose is settled on its own
FARTHEST = 1e140  # [m] coordinate whose square still has room
UNSETTLED = -1.0
FAR = 1e300


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def eight_cable_factors(anchors: Array, attachments: Array, positions: Array, rotations: Array, factors: Array) -> None:
    """Tension factor of every pose, 0 outside wrench closure or where a cable has no length, -1 where unsettled.

    Args:
        anchors: (8, 3) [m].
        attachments: (8, 3), not all zero [m].
        positions: (k, 3) [m].
        rotations: (k, 3, 3).
        factors: Written, (k,) [1].
    """
    matrix, poses, order = np.empty((6, 8, LANES)), np.empty((12, LANES)), np.empty(8, np.int64)
    held, pivot, turns = np.empty(LANES, np.bool_), np.empty(LANES), np.empty((8, 8, LANES))
    rows, low, high, growth = np.empty((2, 8, LANES)), np.empty(LANES), np.empty(LANES), np.empty(LANES)
    less, more = np.empty(LANES), np.empty(LANES)
    count = positions.shape[0]
    for begin in range(0, count, LANES):
        _gather(positions, rotations, begin, poses, held)
        _columns(anchors, attachments, poses, matrix, held)
        _eliminate(matrix, order, pivot)
        _half_plane(matrix, order, rows, low, high, growth)
        _least_ratio(rows, turns, less, more)
        for lane in range(min(LANES, count - begin)):
            factor = less[lane] / more[lane]
            if not held[lane]:
                factor = 0.0
            elif not (pivot[lane] > PIVOT and growth[lane] < GROWTH):
                factor = UNSETTLED
            elif not low[lane] < high[lane]:
                factor = 0.0
            elif not factor > NARROW:
                factor = UNSETTLED
            factors[begin + lane] = factor


@njit(cache=True)
def _gather(positions: Array, rotations: Array, begin: int, poses: Array, held: NDArray[np.bool_]) -> None:
    """Write a block's poses side by side (12, LANES); a pose that is no number is replaced and not held."""
    last = positions.shape[0] - 1
    for lane in range(LANES):
        k = min(begin + lane, last)
        total = 0.0
        for r in range(3):
            poses[r, lane] = positions[k, r]
            total += abs(positions[k, r])
            for c in range(3):
                poses[3 + 3 * r + c, lane] = rotations[k, r, c]
                total += abs(rotations[k, r, c])
        held[lane] = total < FARTHEST
        if not held[lane]:
            for r in range(12):
                poses[r, lane] = poses[r, lane - 1] if lane > 0 else 0.0


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _columns(anchors: Array, attachments: Array, poses: Array, matrix: Array, held: NDArray[np.bool_]) -> None:
    """Write the structure matrices (6, 8, LANES), forces first, moments over the longest arm."""
    arm = 0.0
    for i in range(8):
        arm = max(arm, attachments[i, 0] ** 2 + attachments[i, 1] ** 2 + attachments[i, 2] ** 2)
    shrink = 1.0 / math.sqrt(arm)
    for i in range(8):
        a0, a1, a2 = attachments[i, 0], attachments[i, 1], attachments[i, 2]
        x, y, z = anchors[i, 0], anchors[i, 1], anchors[i, 2]
        size = arm + x * x + y * y + z * z
        for k in range(LANES):
            p0, p1, p2 = poses[0, k], poses[1, k], poses[2, k]
            b0 = poses[3, k] * a0 + poses[4, k] * a1 + poses[5, k] * a2
            b1 = poses[6, k] * a0 + poses[7, k] * a1 + poses[8, k] * a2
            b2 = poses[9, k] * a0 + poses[10, k] * a1 + poses[11, k] * a2
            u0, u1, u2 = x - b0 - p0, y - b1 - p1, z - b2 - p2
            square = u0 * u0 + u1 * u1 + u2 * u2
            least = LENGTHLESS * LENGTHLESS * (size + p0 * p0 + p1 * p1 + p2 * p2)
            held[k] = held[k] and square > least
            inverse = 1.0 / math.sqrt(max(square, least))
            lever = inverse * shrink
            matrix[0, i, k], matrix[1, i, k], matrix[2, i, k] = u0 * inverse, u1 * inverse, u2 * inverse
            matrix[3, i, k] = (b1 * u2 - b2 * u1) * lever
            matrix[4, i, k] = (b2 * u0 - b0 * u2) * lever
            matrix[5, i, k] = (b0 * u1 - b1 * u0) * lever


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _eliminate(matrix: Array, order: NDArray[np.int64], pivot: Array) -> None:
    """Gauss-Jordan of a block; ``order`` gets the six pivot columns and the two left over."""
    for c in range(8):
        order[c] = c
    pivot[:] = 1.0
    for q in range(6):
        at, most = q, -1.0
        for c in range(q, 8):
            weakest = _weakest(matrix, q, order[c])
            if weakest > most:
                at, most = c, weakest
        order[q], order[at] = order[at], order[q]
        p = order[q]
        for k in range(LANES):
            pivot[k] = min(pivot[k], abs(matrix[q, p, k]))
            matrix[q, p, k] = 1.0 / matrix[q, p, k]
        for c in range(q + 1, 8):
            j = order[c]
            for k in range(LANES):
                matrix[q, j, k] *= matrix[q, p, k]
            for r in range(6):
                if r != q:
                    for k in range(LANES):
                        matrix[r, j, k] -= matrix[r, p, k] * matrix[q, j, k]


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz", "nnan"})
def _weakest(matrix: Array, row: int, column: int) -> float:
    """Smallest size of an entry over a block."""
    least = FAR
    for k in range(LANES):
        least = min(least, abs(matrix[row, column, k]))
    return least


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _half_plane(matrix: Array, order: NDArray[np.int64], rows: Array, low: Array, high: Array, growth: Array) -> None:
    """Write the rows of ``N`` (2, 8, LANES), their largest entry and the interval of ``lambda_2 / lambda_1``."""
    a, b = order[6], order[7]
    low[:], high[:], growth[:] = 0.0, FAR, 1.0
    for q in range(6):
        for k in range(LANES):
            x, y = -matrix[q, a, k], -matrix[q, b, k]
            rows[0, q, k], rows[1, q, k] = x, y
            growth[k] = max(growth[k], max(abs(x), abs(y)))
            bound = -x / y
            low[k] = max(low[k], bound if y > 0.0 else 0.0)
            high[k] = min(high[k], bound if y < 0.0 else FAR)
    rows[0, 6], rows[1, 6], rows[0, 7], rows[1, 7] = 1.0, 0.0, 0.0, 1.0


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _least_ratio(rows: Array, turns: Array, less: Array, more: Array) -> None:
    """Write the tension factor of a block as a fraction ``less / more``; compared without divisions."""
    for i in range(8):
        for j in range(i + 1, 8):
            for k in range(LANES):
                turns[i, j, k] = rows[0, i, k] * rows[1, j, k] - rows[0, j, k] * rows[1, i, k]
    less[:], more[:] = 1.0, 1.0
    for i in range(8):
        for j in range(i + 1, 8):
            for h in range(j + 1, 8):
                for k in range(LANES):
                    ij, jh, ih = turns[i, j, k], turns[j, h, k], turns[i, h, k]
                    net, size = abs(ij + jh - ih), abs(ij) + abs(jh) + abs(ih)
                    small, large = size - net, size + net
                    tighter = small * more[k] < less[k] * large and size > PARALLEL
                    less[k] = small if tighter else less[k]
                    more[k] = large if tighter else more[k]
