"""Compiled arithmetic on the line of tensions that balance a wrench; `distribution` and `grid` are its public faces.

Three equations in four tensions, ``structure @ f + wrench = 0``, leave a line ``f = start + lambda null`` (Eq. 9 of
Zheng et al.). Each cable puts two bounds on it, whose distances are straight lines in ``lambda``: one rises, one falls.
Everything asked of the line (how deep in the box it goes, where it is inside, which two bounds forbid it) is arithmetic
on those eight lines.

All compiled code about the line is in this one file because numba's disk cache notices changes in a function's own file
only.
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
FEASIBLE, INFEASIBLE, SINGULAR, UNDEFINED = range(4)
MIN_MAX, MIN_NORM, MAX_MARGIN = range(3)


@njit(cache=True)
def distribute_each(
    structures: Array, wrenches: Array, lowers: Array, uppers: Array, method: int
) -> tuple[Array, Array, Array, Array, NDArray[np.int64]]:
    """Distribution of every question of a batch.

    Args:
        structures: (k, 3, 4).
        wrenches: (k, 3).
        lowers: (k, 4) [N].
        uppers: (k, 4) [N].
        method: One of ``MIN_MAX``, ``MIN_NORM``, ``MAX_MARGIN``.

    Returns:
        Tensions (k, 4) [N], interval of lambda (k, 2) [N], certificate (k, 3), margin (k,) [1] and status (k,).
    """
    count = structures.shape[0]
    tensions, interval = np.full((count, 4), np.nan), np.full((count, 2), np.nan)
    certificate = np.full((count, 3), np.nan)
    margin, status = np.full(count, -np.inf), np.full(count, SINGULAR)
    null, start, dual, proof = np.empty(4), np.empty(4), np.empty((4, 3)), np.empty(4)
    for k in range(count):
        lower, upper = lowers[k], uppers[k]
        if not math.isfinite(structures[k].sum() + wrenches[k].sum() + lower.sum() + upper.sum()):
            status[k] = UNDEFINED
            continue
        if not _solve(structures[k], wrenches[k], null, start, dual):
            _unresisted(structures[k], wrenches[k], certificate[k])
            continue
        depth = _deepest(null, start, lower, upper, proof)
        margin[k] = depth / (0.5 * np.max(upper - lower))
        if margin[k] >= -TOLERANCE:
            status[k] = FEASIBLE
            low, high = _interval(null, start, lower, upper, min(depth, 0.0))
            interval[k, 0], interval[k, 1] = low, high
            place = _place(null, start, lower, upper, depth, low, high, method)
        else:
            status[k] = INFEASIBLE
            for i in range(3):
                certificate[k, i] = (
                    proof[0] * dual[0, i] + proof[1] * dual[1, i] + proof[2] * dual[2, i] + proof[3] * dual[3, i]
                )
            low, high = _interval(null, start, lower, upper, depth)
            place = 0.5 * (low + high)
        for i in range(4):
            tensions[k, i] = start[i] + place * null[i]
    return tensions, interval, certificate, margin, status


@njit(cache=True, parallel=True)
def planar_margins(
    roots: Array, arms: Array, xs: Array, ys: Array, wrench: Array, lower: Array, upper: Array,
    stays: Array, pull_limit: Array, half: float, margins: Array,
) -> None:  # fmt: skip
    """Margin of every node of a planar grid at one orientation; singular nodes get -inf.

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
            for k in range(4):
                dx, dy = roots[k, 0] - xs[i], roots[k, 1] - ys[j]
                length = math.sqrt(dx * dx + dy * dy)
                scale = 1.0 / length if length > 0.0 else 0.0
                structure[0, k], structure[1, k] = dx * scale, dy * scale
                structure[2, k] = (arms[k, 0] * dy - arms[k, 1] * dx) * scale
                along = abs(structure[0, k] * stays[k, 0] + structure[1, k] * stays[k, 1])
                limit[k] = min(upper[k], pull_limit[k] / along) if along > 0.0 else upper[k]
            if _solve(structure, wrench, null, start, dual):
                margins[j, i] = _deepest(null, start, lower, limit, proof) / half
            else:
                margins[j, i] = -np.inf


@njit(cache=True)
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


@njit(cache=True)
def _cross(structure: Array, i: int, j: int) -> tuple[float, float, float]:
    """Cross product of two columns."""
    return (
        structure[1, i] * structure[2, j] - structure[2, i] * structure[1, j],
        structure[2, i] * structure[0, j] - structure[0, i] * structure[2, j],
        structure[0, i] * structure[1, j] - structure[1, i] * structure[0, j],
    )


@njit(cache=True)
def _bounds(null: Array, start: Array, lower: Array, upper: Array, i: int) -> tuple[float, float, float]:
    """Distances of cable ``i`` to its bounds at lambda = 0: the one rising with lambda, the one falling, the slope."""
    if null[i] >= 0.0:
        return start[i] - lower[i], upper[i] - start[i], null[i]
    return upper[i] - start[i], start[i] - lower[i], -null[i]


@njit(cache=True)
def _deepest(null: Array, start: Array, lower: Array, upper: Array, proof: Array) -> float:
    """Greatest least distance to a bound [N]; ``proof`` gets the weights of the two bounds that set it.

    By duality of a linear program in one unknown: the least, over pairs of a rising and a falling line, of their
    crossing.
    """
    depth = np.inf
    proof[:] = 0.0
    for i in range(4):
        rise, _, up = _bounds(null, start, lower, upper, i)
        for j in range(4):
            _, fall, down = _bounds(null, start, lower, upper, j)
            if up + down > 0.0:
                crossing = (down * rise + up * fall) / (up + down)
                if crossing < depth:
                    depth = crossing
                    proof[:] = 0.0
                    proof[i] += down / (up + down) if null[i] >= 0.0 else -down / (up + down)
                    proof[j] += -up / (up + down) if null[j] >= 0.0 else up / (up + down)
    return depth


@njit(cache=True)
def _interval(null: Array, start: Array, lower: Array, upper: Array, level: float) -> tuple[float, float]:
    """Where along the line every distance is at least ``level``; cables null hardly moves do not limit it."""
    low, high = -np.inf, np.inf
    for i in range(4):
        rise, fall, slope = _bounds(null, start, lower, upper, i)
        if slope > TOLERANCE:
            low, high = max(low, (level - rise) / slope), min(high, (fall - level) / slope)
    if low > high:
        low = high = 0.5 * (low + high)
    return low, high


@njit(cache=True)
def _place(
    null: Array, start: Array, lower: Array, upper: Array, depth: float, low: float, high: float, method: int
) -> float:
    """Lambda in ``[low, high]`` that the method asks for."""
    if method == MIN_NORM:
        return min(max(0.0, low), high)
    if method == MAX_MARGIN:
        deep_low, deep_high = _interval(null, start, lower, upper, depth)
        return min(max(0.5 * (deep_low + deep_high), low), high)
    best, least = low, _largest(null, start, low)
    if _largest(null, start, high) < least:
        best, least = high, _largest(null, start, high)
    for i in range(4):
        for j in range(i):
            if null[i] != null[j]:
                crossing = (start[j] - start[i]) / (null[i] - null[j])
                if low < crossing < high and _largest(null, start, crossing) < least:
                    best, least = crossing, _largest(null, start, crossing)
    return best


@njit(cache=True)
def _largest(null: Array, start: Array, place: float) -> float:
    """Largest tension at lambda = ``place``."""
    return max(
        max(start[0] + place * null[0], start[1] + place * null[1]),
        max(start[2] + place * null[2], start[3] + place * null[3]),
    )


@njit(cache=True)
def _unresisted(structure: Array, wrench: Array, certificate: Array) -> None:
    """Unit direction no column has a component along, turned against the wrench; untouched where rank is below two."""
    most = 0.0
    for i in range(4):
        for j in range(i):
            x, y, z = _cross(structure, i, j)
            size = math.sqrt(x * x + y * y + z * z)
            if size > most:
                most = size
                certificate[0], certificate[1], certificate[2] = x / size, y / size, z / size
    if certificate[0] * wrench[0] + certificate[1] * wrench[1] + certificate[2] * wrench[2] < 0.0:
        certificate *= -1.0
