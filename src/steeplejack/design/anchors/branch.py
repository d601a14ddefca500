"""Best-first branch and bound over boxes of anchor offsets, pose by pose, in one kernel.

The box with the largest bound is cut next, at the offset its chord problem suggests, in the interval of the cable whose
force is farthest from an arc: shorter than the least tension, or longer than the largest.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.design.anchors.boxes import PIECES, examine, pop, push, separate
from steeplejack.design.anchors.twists import columns, factor_of
from steeplejack.mechanics.cable.wrench.hyperplanes import TOLERANCE

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

REACH, LEAST_REACH = 0.25, 1e-7  # size of the box of a local search over that of the windows: first, and least
CERTIFIED, INFEASIBLE, EXHAUSTED = 0, 1, 2


@njit(cache=True)
def optimise(
    arms: Array, roots: Array, along: Array, shortest: Array, windows: Array, start: Array, unit: bool, gap: float,
    most: int, offsets: Array, values: Array, uppers: Array, boxes: Integers,
    status: Integers,
) -> None:  # fmt: skip
    """Maximise the tension factor over boxes of offsets.

    Args:
        arms: ``b_i`` at each pose, (k, 4, 2) [m].
        roots: ``BA_i`` at no offset, (k, 4, 2) [m].
        along: Change of ``BA_i`` with the offset, (4, 2) [1].
        shortest: Length at each pose from which a cable has a direction, (k,) [m].
        windows: Least and largest offset, (4, 2) [m].
        start: Offsets tried first, (4,) [m].
        unit: Whether columns are divided by the length of their cable: J, else J~.
        gap: Difference between bound and value to reach [1].
        most: Boxes to look at before giving up, a pose.
        offsets: Written, (k, 4) [m].
        values: Written, tension factor at the offsets, (k,) [1].
        uppers: Written, proved upper bound, (k,) [1].
        boxes: Written, boxes looked at, (k,).
        status: Written, (k,).
    """
    room = most + PIECES
    corners, twists = np.empty((room, 2, 4)), np.empty((room, 3))
    keys, cuts = np.empty(room), np.empty(room)
    sides, heap = np.empty(room, np.int64), np.empty(room, np.int64)
    for k in range(len(arms)):
        values[k], uppers[k], boxes[k] = _search(
            arms[k], roots[k], along, shortest[k], windows, start, unit, gap, most, offsets[k],
            corners, twists, keys, cuts, sides, heap,
        )  # fmt: skip
        if uppers[k] <= TOLERANCE:
            status[k] = INFEASIBLE
        else:
            status[k] = CERTIFIED if values[k] > 0.0 and uppers[k] <= values[k] + gap else EXHAUSTED


@njit(cache=True)
def _search(
    arms: Array, roots: Array, along: Array, shortest: float, windows: Array, start: Array, unit: bool, gap: float,
    most: int, best: Array, corners: Array, twists: Array, keys: Array, cuts: Array, sides: Integers, heap: Integers,
) -> tuple[float, float, int]:  # fmt: skip
    """One pose: value, proved upper bound, boxes looked at; ``best`` gets the offsets."""
    trial, wrenches = start.copy(), np.empty((4, 4))
    value = factor_of(wrenches) if columns(arms, roots, along, unit, shortest, trial, 0.0, wrenches) else 0.0
    best[:] = trial
    filled = separate(roots, along, windows, shortest if unit else 0.0, corners)
    twists[:filled] = 0.0
    waiting, looked, dropped = 0, 0, 0.0
    fresh = np.arange(filled)
    while True:
        for at in range(len(fresh)):
            box = int(fresh[at])
            looked += 1
            keys[box], sides[box], cuts[box] = examine(
                arms, roots, along, unit, shortest, enough(value, gap), corners[box, 0], corners[box, 1], twists[box],
                trial,
            )  # fmt: skip
            if columns(arms, roots, along, unit, shortest, trial, 0.0, wrenches):
                found = factor_of(wrenches)
                if found > value:
                    best[:] = trial
                    value = _climb(arms, roots, along, shortest, windows, unit, gap, found, best)
            if keys[box] <= enough(value, gap) or sides[box] < 0:
                dropped = max(dropped, keys[box])
            else:
                if keys[box] >= 1.0:
                    keys[box] = 1.0 + looked  # the newest of many boxes with the trivial bound is the smallest
                push(heap, waiting, keys, box)
                waiting += 1
        if waiting == 0 or keys[heap[0]] <= enough(value, gap) or looked + 2 > most:
            break
        one, two = pop(heap, waiting, keys), filled
        fresh = np.array([one, two])
        waiting, filled = waiting - 1, filled + 1
        corners[two], twists[two] = corners[one], twists[one]
        corners[one, 1, sides[one]] = corners[two, 0, sides[one]] = cuts[one]
    upper = max(dropped, float(keys[int(heap[0])])) if waiting > 0 else dropped
    return value, max(min(upper, 1.0), value), looked


@njit(cache=True)
def _climb(
    arms: Array, roots: Array, along: Array, shortest: float, windows: Array, unit: bool, gap: float, value: float,
    best: Array,
) -> float:  # fmt: skip
    """Improve offsets in place by the chord problem of a small box about them, whose error is of second order.

    Returns:
        Their value.
    """
    low, high, trial = np.empty(4), np.empty(4), np.empty(4)
    twist, wrenches, reach = np.empty(3), np.empty((4, 4)), REACH
    while reach > LEAST_REACH and value + gap < 1.0:
        for i in range(4):
            half = 0.5 * reach * (windows[i, 1] - windows[i, 0])
            low[i], high[i] = max(best[i] - half, windows[i, 0]), min(best[i] + half, windows[i, 1])
        twist[:] = 0.0
        bound, _, _ = examine(arms, roots, along, unit, shortest, 0.0, low, high, twist, trial)
        found = 0.0
        if columns(arms, roots, along, unit, shortest, trial, 0.0, wrenches):
            found = factor_of(wrenches)
        if found > value:
            value, best[:] = found, trial
        if bound - value <= 0.25 * gap:
            break
        if found <= value:
            reach *= 0.25
    return value


@njit(cache=True)
def enough(value: float, gap: float) -> float:
    """A bound up to this ends a box; without any closure yet only one that excludes it does."""
    return value + gap if value > 0.0 else TOLERANCE
