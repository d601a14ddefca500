"""Shortest time over the lattice: Dijkstra's algorithm on the pairs of places and the clocks of both grippers.

A state is a pair, the upper gripper's clock and the lower one's (as one of those the linkage reaches). An edge is one
move with one gripper open: along its pipe as far as every place between allows, turning on the way if it likes, or
from one pipe to another. Its cost is the rest-to-rest time and the time to open and to close.
"""

from __future__ import annotations

import heapq
import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]
Index = Any
"""An integer that numba takes from an array; the checker sees an array."""


@njit(cache=True)
def shortest_times(
    pairs: Indices, coaxial: Flags, sides: Indices, allowed: Flags, lengths: Array, ahead: Indices, behind: Indices,
    middles: Indices, holds_lower: Flags, holds_upper: Flags, pipe_lower: Indices, pipe_upper: Indices,
    near: Indices, turns: Array, passes_lower: Flags, passes_upper: Flags,
    rows: Indices, columns: Indices, order: Indices, banned: Indices,
    start: Indices, goal: Flags, speed: float, turn_speed: float, ramp: float, grip: float,
) -> tuple[Any, Any, Any]:  # fmt: skip
    """Least time to every state from the start states, until a goal pair is reached.

    Args:
        pairs: (k, 2) lower and upper place.
        coaxial: (k,) whether any clock will do.
        sides: (k, 2) clock index of either side.
        allowed: (k, 2) whether a pose keeps the limits.
        lengths: (k, 2, 3) of the cylinders [m].
        ahead: (k, 2) pair with the next place of the upper, lower gripper.
        behind: (k, 2) with the one before.
        middles: (k, 2, 2) clocks allowed on the way ahead.
        holds_lower: (n,) where it may close.
        holds_upper: (m,) the same.
        pipe_lower: (n,) index of the pipe.
        pipe_upper: (m,) the same.
        near: (c, b) clocks near each.
        turns: (c, b) turn to them [rad].
        passes_lower: (n, c, b) open gripper turning from c to near b.
        passes_upper: (m, c, b) the same.
        rows: (n + 1,) where the pairs of each lower place begin.
        columns: (m + 1,) where those of each upper place begin in the order below.
        order: (k,) pairs by upper place.
        banned: (j, 2) pairs with no way between pipes.
        start: States to start from.
        goal: (k,) pairs to come to.
        speed: Of a cylinder [m/s].
        turn_speed: Of the linkage [rad/s].
        ramp: From rest to full speed [s].
        grip: To open and to close [s].

    Returns:
        Times (states,), the state before each (-1 for none), and the goal state reached or -1.
    """
    count, spread = near.shape[0], near.shape[1]
    times = np.full(pairs.shape[0] * count * spread, np.inf)
    before = np.full(times.shape[0], -1, dtype=np.int64)
    done = np.zeros(times.shape[0], dtype=np.bool_)
    heap = [(0.0, np.int64(-1))]
    heap.pop()
    for state in start:
        times[state] = 0.0
        heapq.heappush(heap, (0.0, state))
    while len(heap) > 0:
        time, state = heapq.heappop(heap)
        if done[state]:
            continue
        done[state] = True
        pair = state // (count * spread)
        if goal[pair]:
            return times, before, state
        upper_clock = (state // spread) % count
        lower_clock = near[upper_clock, state % spread]
        for gripper in range(2):  # 0: the upper one moves, 1: the lower one
            own_clock = upper_clock if gripper == 0 else lower_clock
            for way in range(2):
                here, travelled = pair, 0.0
                while True:
                    place = pairs[here, 1] if gripper == 0 else pairs[here, 0]
                    free = passes_upper[place] if gripper == 0 else passes_lower[place]
                    if not free[own_clock, 0]:
                        break
                    if (holds_upper[place] if gripper == 0 else holds_lower[place]) and (way == 0 or here != pair):
                        for b in range(spread):
                            clock = near[own_clock, b]
                            if clock < 0 or (here == pair and b == 0):
                                continue
                            if gripper == 0 and b > 0 and not (coaxial[pair] and coaxial[here]):
                                continue
                            new_upper = clock if gripper == 0 else upper_clock
                            new_lower = lower_clock if gripper == 0 else clock
                            slot = _slot(near, new_upper, new_lower)
                            if slot < 0 or not free[own_clock, b]:
                                continue
                            if b > 0 and not _clear(
                                passes_upper if gripper == 0 else passes_lower, pairs, ahead, behind,
                                pair, here, gripper, way, own_clock, b,
                            ):  # fmt: skip
                                continue
                            reached = (here * count + new_upper) * spread + slot
                            needed = max(travelled / speed, abs(turns[own_clock, b]) / turn_speed)
                            total = time + grip + _rest_to_rest(needed, ramp)
                            if total < times[reached] - 1e-12:
                                times[reached], before[reached] = total, state
                                heapq.heappush(heap, (total, np.int64(reached)))
                    following = ahead[here, gripper] if way == 0 else behind[here, gripper]
                    if following < 0:
                        break
                    cell = here if way == 0 else following
                    if not _between(middles, cell, gripper, upper_clock):
                        break
                    to = _side(coaxial, sides, allowed, following, upper_clock)
                    if to < 0:
                        break
                    at = _side(coaxial, sides, allowed, here, upper_clock)
                    travelled += _travel(lengths, here, at, following, to)
                    here = following
            at = _side(coaxial, sides, allowed, pair, upper_clock)
            first, last = (
                (rows[pairs[pair, 0]], rows[pairs[pair, 0] + 1])
                if gripper == 0
                else (columns[pairs[pair, 1]], columns[pairs[pair, 1] + 1])
            )
            for index in range(first, last):
                other = index if gripper == 0 else order[index]
                mine, theirs = (1, 1) if gripper == 0 else (0, 0)
                place, target = pairs[pair, mine], pairs[other, theirs]
                pipes = pipe_upper if gripper == 0 else pipe_lower
                if pipes[place] == pipes[target]:
                    continue
                if not (holds_upper[target] if gripper == 0 else holds_lower[target]):
                    continue
                free_here = passes_upper[place] if gripper == 0 else passes_lower[place]
                free_there = passes_upper[target] if gripper == 0 else passes_lower[target]
                if not (free_here[own_clock, 0] and free_there[own_clock, 0]):
                    continue
                to = _side(coaxial, sides, allowed, other, upper_clock)
                if to < 0 or _forbidden(banned, pair, other):
                    continue
                slot = _slot(near, upper_clock, lower_clock)
                reached = (other * count + upper_clock) * spread + slot
                total = time + grip + _rest_to_rest(_travel(lengths, pair, at, other, to) / speed, ramp)
                if total < times[reached] - 1e-12:
                    times[reached], before[reached] = total, state
                    heapq.heappush(heap, (total, np.int64(reached)))
    return times, before, -1


@njit(cache=True)
def _rest_to_rest(needed: Any, ramp: float) -> float:
    """Duration of a move that takes ``needed`` at full speed: see `spatial.timing.Profile`."""
    return needed + ramp if needed >= ramp else 2.0 * math.sqrt(needed * ramp)


@njit(cache=True)
def _slot(near: Indices, upper: Index, lower: Index) -> int:
    """Which of the clocks near the upper one's the lower one's is, -1 if none."""
    for b in range(near.shape[1]):
        if near[upper, b] == lower:
            return b
    return -1


@njit(cache=True)
def _side(coaxial: Flags, sides: Indices, allowed: Flags, pair: Index, clock: Index) -> int:
    """Which side's pose a pair has at a clock, -1 if none is allowed."""
    if coaxial[pair]:
        return 0 if allowed[pair, 0] else -1
    for side in range(2):
        if sides[pair, side] == clock and allowed[pair, side]:
            return side
    return -1


@njit(cache=True)
def _between(middles: Indices, pair: Index, gripper: int, clock: Index) -> bool:
    """Whether the middle of the way ahead is allowed at a clock."""
    for side in range(2):
        if middles[pair, gripper, side] == -2 or middles[pair, gripper, side] == clock:
            return True
    return False


@njit(cache=True)
def _travel(lengths: Array, start: int, side: int, end: int, other: int) -> float:
    """Longest travel of a cylinder between two poses [m]."""
    far = 0.0
    for limb in range(3):
        far = max(far, abs(lengths[end, other, limb] - lengths[start, side, limb]))
    return far


@njit(cache=True)
def _clear(
    passes: Flags, pairs: Indices, ahead: Indices, behind: Indices,
    start: Index, end: Index, gripper: int, way: int, clock: Index, turn: int,
) -> bool:  # fmt: skip
    """Whether the open gripper passes every place from one pair to another while turning."""
    here = start
    while True:
        place = pairs[here, 1] if gripper == 0 else pairs[here, 0]
        if not passes[place, clock, turn]:
            return False
        if here == end:
            return True
        here = ahead[here, gripper] if way == 0 else behind[here, gripper]


@njit(cache=True)
def _forbidden(banned: Indices, start: int, end: int) -> bool:
    for row in range(banned.shape[0]):
        if banned[row, 0] == start and banned[row, 1] == end:
            return True
    return False
