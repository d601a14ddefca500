"""A box of anchor offsets: its bound, the offsets it suggests, where to cut it, and a queue of boxes."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.design.anchors.chords import solve
from steeplejack.design.anchors.twists import columns, upper_bound

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

EDGE = 0.1  # a cut stays this share of the interval away from its ends
PIECES = 16  # most boxes that `separate` makes of one


@njit(cache=True)
def separate(roots: Array, along: Array, windows: Array, shortest: float, corners: Array) -> int:
    """Boxes of the windows without the offsets at which a cable is too short to have a direction.

    A stay that passes through an attachment has such offsets in between: on either side the direction is known, and
    nothing there counts as held.

    Args:
        roots: ``BA_i`` at no offset, (4, 2) [m].
        along: Change of ``BA_i`` with the offset, (4, 2) [1].
        windows: Least and largest offset, (4, 2) [m].
        shortest: Length from which a cable has a direction [m].
        corners: Written, lower and upper corner of each box, (>= `PIECES`, 2, 4) [m].

    Returns:
        How many boxes, 0 where a cable has no direction anywhere in its window.
    """
    corners[0, 0], corners[0, 1] = windows[:, 0], windows[:, 1]
    count = 1
    for i in range(4):
        low, high = windows[i]
        before, after = _without_direction(roots[i], along[i], shortest)
        if after < low or high < before or after < before:
            continue
        if low <= before and after <= high:
            corners[count : 2 * count] = corners[:count]
            corners[:count, 1, i], corners[count : 2 * count, 0, i] = before, after
            count *= 2
        elif low <= before:
            corners[:count, 1, i] = before
        elif after <= high:
            corners[:count, 0, i] = after
        else:
            return 0
    return count


@njit(cache=True)
def _without_direction(root: Array, along: Array, shortest: float) -> tuple[float, float]:
    """Offsets between which one cable is too short, in the wrong order where there are none."""
    square = along[0] ** 2 + along[1] ** 2
    if not square > 0.0:
        short = root[0] ** 2 + root[1] ** 2 < shortest**2
        return (-math.inf, math.inf) if short else (math.inf, -math.inf)
    miss = (along[0] * root[1] - along[1] * root[0]) ** 2 / square
    if miss >= shortest**2:
        return math.inf, -math.inf
    middle = -(root[0] * along[0] + root[1] * along[1]) / square
    half = math.sqrt((shortest**2 - miss) / square)
    return middle - half, middle + half


@njit(cache=True)
def examine(
    arms: Array, roots: Array, along: Array, unit: bool, shortest: float, enough: float, low: Array, high: Array,
    twist: Array, trial: Array,
) -> tuple[float, int, float]:  # fmt: skip
    """Bound the tension factor over a box and look for good offsets in it.

    Args:
        arms: ``b_i``, (4, 2) [m].
        roots: ``BA_i`` at no offset, (4, 2) [m].
        along: Change of ``BA_i`` with the offset, (4, 2) [1].
        unit: Whether columns are those of J, else of J~.
        shortest: As for `columns` [m].
        enough: A bound up to this needs no improvement [1].
        low: Lower corner of the box, (4,) [m].
        high: Upper corner, (4,) [m].
        twist: That of the parent box, tried first; written with the box's own where it is better, (3,).
        trial: Written, offsets to try, (4,) [m]; the middle where the parent's twist was enough.

    Returns:
        The bound [1], and the cable and offset [m] at which to cut; the cable is -1 for a box without width.
    """
    left, right, shares = np.empty((4, 4)), np.empty((4, 4)), np.full((4, 2), 0.5)
    columns(arms, roots, along, unit, shortest, low, 1.0, left)
    columns(arms, roots, along, unit, shortest, high, -1.0, right)
    bound = upper_bound(twist, arms, left, right, unit)
    if bound > enough:
        own = np.empty(3)
        solve(left, right, unit, own, shares)
        better = upper_bound(own, arms, left, right, unit)
        if better < bound:
            bound, twist[:] = better, own
    for i in range(4):
        a, b = shares[i, 0] * left[i, 3], shares[i, 1] * right[i, 3]
        share = b / (a + b) if a + b > 0.0 else 0.5
        trial[i] = min(max(low[i] + share * (high[i] - low[i]), low[i]), high[i])
    side = _farthest(left, right, shares, low, high)
    if side < 0:
        return bound, side, 0.0
    reach = EDGE * (high[side] - low[side])
    return bound, side, min(max(trial[side], low[side] + reach), high[side] - reach)


@njit(cache=True)
def _farthest(left: Array, right: Array, shares: Array, low: Array, high: Array) -> int:
    """Cable whose force is farthest from its arc, or with the widest sector where all lie on theirs; -1 for none."""
    worst, side = 0.0, -1
    widest, wide = -1.0, -1
    for i in range(4):
        if not high[i] > low[i]:
            continue
        x = shares[i, 0] * left[i, 0] + shares[i, 1] * right[i, 0]
        y = shares[i, 0] * left[i, 1] + shares[i, 1] * right[i, 1]
        pull = math.sqrt(x * x + y * y)
        sector = _opening(left[i], right[i])
        off = min(max(shares[i, 0] + shares[i, 1] - pull, pull - 1.0), sector)
        if off > worst:
            worst, side = off, i
        if sector > widest:
            widest, wide = sector, i
    return side if side >= 0 else wide


@njit(cache=True)
def _opening(left: Array, right: Array) -> float:
    """How far arc and chord may be apart: squared distance between the ends of directions of unit length."""
    x, y = left[0] - right[0], left[1] - right[1]
    return x * x + y * y


@njit(cache=True)
def push(heap: Integers, size: int, keys: Array, box: int) -> None:
    """Put a box into a heap of ``size`` boxes, the largest key first."""
    at = size
    while at > 0 and keys[heap[(at - 1) // 2]] < keys[box]:
        heap[at] = heap[(at - 1) // 2]
        at = (at - 1) // 2
    heap[at] = box


@njit(cache=True)
def pop(heap: Integers, size: int, keys: Array) -> int:
    """Take the box with the largest key from a heap of ``size`` boxes."""
    top, last = heap[0], heap[size - 1]
    at, child = 0, 1
    while child < size - 1:
        if child + 1 < size - 1 and keys[heap[child + 1]] > keys[heap[child]]:
            child += 1
        if keys[heap[child]] <= keys[last]:
            break
        heap[at] = heap[child]
        at, child = child, 2 * child + 1
    heap[at] = last
    return top
