"""Branch and bound for the largest tension factor over boxes of positions, compiled.

Best first: the box of the largest bound is cut across its longer side until no bound exceeds the best position found by
more than the gap. Deepest first, to find any position above a floor: the smallest box is cut, so a ridge along which
the tension factor hardly changes is followed down to one of its positions instead of all along. Positions are tried at
the centre of every box and at the corner or the ridge its bound points to, so a maximum on the border of the region or
on a kink is found as fast as a smooth one inside.
"""

from __future__ import annotations

import heapq

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.design.grasps.bounds import LEAST_FACTOR, bound_over, factor_at

Array = NDArray[np.float64]

THINNEST = 1e-15  # [1] half side, in scaled units, of a box that is not cut


@njit(cache=True, error_model="numpy")
def climb(
    boxes: Array, floor: float, gap: float, most: int, dive: bool,
    roots: Array, polynomials: Array, slack: Array, off: float, arm: float, best: Array,
) -> tuple[float, int]:  # fmt: skip
    """Search boxes for a position above a floor.

    Args:
        boxes: Least and greatest coordinate along and across, (k, 4), scaled.
        floor: TF that is of no interest [1]; at least what counts as zero.
        gap: Difference of TF at which the search ends [1].
        most: Boxes to look at before giving up.
        dive: Deepest first, and end at the first position above the floor.
        roots: Of `Cofactors`, (4, 2).
        polynomials: Of `Cofactors`, (4, 6).
        slack: Of `Cofactors`, (4,).
        off: Of `Cofactors`.
        arm: Of `Cofactors`.
        best: Written: position and TF, (3,); TF is the floor where no position is above it.

    Returns:
        Upper bound of TF over the boxes, not below the floor [1], and how many boxes were looked at; 1 for the bound
        where a search deepest first ended before it was through.
    """
    model, trial = np.empty((5, 7)), np.empty(2)
    best[0], best[1], best[2] = np.nan, np.nan, max(floor, LEAST_FACTOR)
    found = False
    heap = [(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)]
    heap.clear()
    pending = [(boxes[k, 0], boxes[k, 1], boxes[k, 2], boxes[k, 3]) for k in range(boxes.shape[0])]
    looked = 0
    while True:
        for left, right, low, high in pending:
            s, t = left + 0.5 * (right - left), low + 0.5 * (high - low)
            a, b = max(right - s, s - left), max(high - t, t - low)
            bound = bound_over(s, t, a, b, roots, polynomials, slack, off, arm, model, trial)
            looked += 1
            for x, y in ((s, t), (min(max(trial[0], left), right), min(max(trial[1], low), high))):
                factor = factor_at(x, y, roots, polynomials, arm)
                if factor > best[2]:
                    best[0], best[1], best[2] = x, y, factor
                    found = True
            if bound > best[2] + (gap if found else 0.0):
                heapq.heappush(heap, (max(a, b) if dive else -bound, bound, left, right, low, high))
        pending.clear()
        reached = best[2] + (gap if found else 0.0)
        if len(heap) == 0:
            return reached, looked
        if dive and (found or looked >= most):
            return 1.0, looked
        _, bound, left, right, low, high = heapq.heappop(heap)
        if not dive and (bound <= reached or looked >= most or max(right - left, high - low) <= 2.0 * THINNEST):
            return max(bound, best[2]), looked
        if max(right - left, high - low) <= 2.0 * THINNEST:
            continue
        if right - left >= high - low:
            s = left + 0.5 * (right - left)
            pending.append((left, s, low, high))
            pending.append((s, right, low, high))
        else:
            t = low + 0.5 * (high - low)
            pending.append((left, right, low, t))
            pending.append((left, right, t, high))
