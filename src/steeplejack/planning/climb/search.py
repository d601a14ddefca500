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

Uses = NDArray[np.float32]
Poses = tuple[Flags, Indices, Flags, Array]
"""Of pairs: whether any clock will do (k,), clock index of either side (k, 2), whether its pose keeps the limits (k,
2), lengths of the cylinders (k, 2, 3) [m]."""
Net = tuple[Indices, Indices, Indices, Indices]
"""Pairs of lower and upper places (k, 2), the pair with the next place of the (upper, lower) gripper (k, 2), that with
the one before (k, 2), clocks allowed on the way to the next (k, 2, 2)."""
Clocks = tuple[Indices, Array]
"""Clocks near each (c, b), -1 for none, and the turn to them (c, b) [rad]."""
Bars = tuple[Uses, Indices, Uses, Uses, Indices, Flags, Indices, Flags, Flags]
"""What holding alone takes of the lower and the upper gripper (k, c, b, 2); and of `uses.Uses` the kinds and the two
tables of swings; row of a pair in the next, -1 for none (k,); turns in which the mechanism's bars meet something (r, c,
b); row of a lower place in the next two (n,); turns of the upper, and of the lower gripper in which the linkage's do
(q, c, b, b)."""
Ground = tuple[Flags, Flags, Indices]
"""Of one gripper's places: where it may close (n,), where it passes turning between clocks (n, c, b), which pipe."""
Groups = tuple[Indices, Indices, Indices]
"""Where the pairs of each lower place begin (n + 1,), where those of each upper place do (m + 1,) in an order (k,)."""
Pace = tuple[float, float, float, float]
"""Speed of a cylinder [m/s] and of the linkage [rad/s], time from rest to full speed, to open and to close [s]."""
TIDY = 1e-3
"""Time that a turn counts for beyond what it takes, so that none is made that gains nothing [s/rad]."""
Heap = Any
"""List of times and states still to look at; the checker cannot tell the integers apart."""


@njit(cache=True)
def shortest_times(
    poses: Poses, net: Net, wheel: Clocks, bars: Bars, grounds: tuple[Ground, Ground], groups: Groups, banned: Indices,
    start: Indices, goal: Flags, pace: Pace,
) -> tuple[Any, Any, Any]:  # fmt: skip
    """Least time to every state from the start states, until a goal pair is reached.

    Args:
        poses: See `Poses`; as the next five.
        net: Which pairs follow one another.
        wheel: Clocks.
        bars: Where grip and bars let a gripper open and turn.
        grounds: Where the upper, and where the lower gripper may close and pass.
        groups: Pairs by place.
        banned: (j, 2) pairs with no way between pipes.
        start: States to start from.
        goal: (k,) pairs to come to.
        pace: Speeds and times.

    Returns:
        Times (states,), the state before each (-1 for none), and the goal state reached or -1.
    """
    pairs, near = net[0], wheel[0]
    rows, columns, order = groups
    times = np.full(pairs.shape[0] * near.shape[0] * near.shape[1], np.inf)
    before = np.full(times.shape[0], -1, dtype=np.int64)
    done = np.zeros(times.shape[0], dtype=np.bool_)
    every = np.arange(pairs.shape[0])
    heap: Heap = [(0.0, np.int64(-1))]
    heap.pop()
    for state in start:
        times[state] = 0.0
        heapq.heappush(heap, (0.0, state))
    while len(heap) > 0:
        _time, state = heapq.heappop(heap)
        if done[state]:
            continue
        done[state] = True
        if goal[state // (near.shape[0] * near.shape[1])]:
            return times, before, state
        for way in range(2):
            _along(state, 0, way, poses, net, wheel, bars, pace, grounds[0], times, before, heap)
            _along(state, 1, way, poses, net, wheel, bars, pace, grounds[1], times, before, heap)
        at = pairs[state // (near.shape[0] * near.shape[1])]
        beside, above = every[rows[at[0]] : rows[at[0] + 1]], order[columns[at[1]] : columns[at[1] + 1]]
        _across(state, 0, beside, poses, net, wheel, bars, pace, grounds[0], banned, times, before, heap)
        _across(state, 1, above, poses, net, wheel, bars, pace, grounds[1], banned, times, before, heap)
    return times, before, -1


@njit(cache=True)
def _along(
    state: Index, gripper: int, way: int, poses: Poses, net: Net, wheel: Clocks, bars: Bars, pace: Pace,
    ground: Ground, times: Array, before: Indices, heap: Heap,
) -> None:  # fmt: skip
    """Offer the states one gripper (0 upper, 1 lower) reaches along its pipe, turning on the way if it likes."""
    holds, passes, _pipes = ground
    (coaxial, sides, allowed, lengths), (pairs, ahead, behind, middles), (near, turns) = poses, net, wheel
    pair, upper, lower = _parts(state, near)
    own, here, travelled, column = upper if gripper == 0 else lower, pair, 0.0, 1 - gripper
    slot, may = _slot(near, upper, lower), near[own] >= 0
    while passes[pairs[here, column], own, 0] and _stands(pairs, bars, here, upper, slot, gripper):
        offers = holds[pairs[here, column]] and (way == 0 or here != pair)
        for b in range(near.shape[1]):
            if not may[b]:
                continue
            clock = near[own, b]
            new_upper, new_lower = (clock, lower) if gripper == 0 else (upper, clock)
            if b > 0:
                if gripper == 0 and not (coaxial[pair] and coaxial[here]):
                    may[b] = False
                elif not passes[pairs[here, column], own, b]:
                    may[b] = False
                else:
                    may[b] = _turns(pairs, near, bars, here, gripper, b, upper, slot, new_upper, new_lower)
            if not (offers and may[b]) or (here == pair and b == 0):
                continue
            needed = max(travelled / pace[0], abs(turns[own, b]) / pace[1]) + TIDY * abs(turns[own, b])
            _offer(state, here, new_upper, new_lower, needed, near, pace, times, before, heap)
        following = ahead[here, gripper] if way == 0 else behind[here, gripper]
        if following < 0 or not _between(middles, here if way == 0 else following, gripper, upper):
            return
        to = _side(coaxial, sides, allowed, following, upper)
        if to < 0:
            return
        travelled += _travel(lengths, here, _side(coaxial, sides, allowed, here, upper), following, to)
        here = following


@njit(cache=True)
def _across(
    state: Index, gripper: int, others: Indices, poses: Poses, net: Net, wheel: Clocks, bars: Bars, pace: Pace,
    ground: Ground, banned: Indices, times: Array, before: Indices, heap: Heap,
) -> None:  # fmt: skip
    """Offer the states one gripper (0 upper, 1 lower) reaches on other pipes, the other one kept in place."""
    (coaxial, sides, allowed, lengths), pairs, near = poses, net[0], wheel[0]
    holds, passes, pipes = ground
    pair, upper, lower = _parts(state, near)
    own, column = upper if gripper == 0 else lower, 1 - gripper
    place, at, slot = pairs[pair, column], _side(coaxial, sides, allowed, pair, upper), _slot(near, upper, lower)
    if not _stands(pairs, bars, pair, upper, slot, gripper):
        return
    for other in others:
        target = pairs[other, column]
        if pipes[place] == pipes[target] or not holds[target]:
            continue
        if not (passes[place, own, 0] and passes[target, own, 0]):
            continue
        to = _side(coaxial, sides, allowed, other, upper)
        if to < 0 or _forbidden(banned, pair, other):
            continue
        if not _stands(pairs, bars, other, upper, slot, gripper):
            continue
        needed = _travel(lengths, pair, at, other, to) / pace[0]
        _offer(state, other, upper, lower, needed, near, pace, times, before, heap)


@njit(cache=True)
def _parts(state: Index, near: Indices) -> tuple[Index, Index, Index]:
    """Pair and clocks of the upper and the lower gripper of a state."""
    count, spread = near.shape
    upper = (state // spread) % count
    return state // (count * spread), upper, near[upper, state % spread]


@njit(cache=True)
def _offer(
    state: Index, pair: Index, upper: Index, lower: Index, needed: float, near: Indices, pace: Pace,
    times: Array, before: Indices, heap: Heap,
) -> None:  # fmt: skip
    """Keep a way to a pair and clocks if it is the fastest yet."""
    slot = _slot(near, upper, lower)
    if slot < 0:
        return
    reached = (pair * near.shape[0] + upper) * near.shape[1] + slot
    total = times[state] + pace[3] + _rest_to_rest(needed, pace[2])
    if total < times[reached] - 1e-12:
        times[reached], before[reached] = total, state
        heapq.heappush(heap, (total, np.int64(reached)))


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
def _stands(pairs: Indices, bars: Bars, pair: Index, upper: Index, slot: Index, gripper: int) -> bool:
    """Whether a state holds with one gripper open: the other's grip suffices and no bar meets anything."""
    uses, _kinds, _on, _off, row_of_pair, mechanism, row_of_place, by_upper, _by_lower = bars
    if slot < 0 or uses[pair, upper, slot, gripper] > 1.0:
        return False
    row, place = row_of_pair[pair], row_of_place[pairs[pair, 0]]
    if row >= 0 and mechanism[row, upper, 0]:
        return False
    if place >= 0 and by_upper[place, upper, slot, 0]:
        return False
    return True


@njit(cache=True)
def _turns(
    pairs: Indices, near: Indices, bars: Bars, here: Index, gripper: int, turn: int, upper: Index, slot: Index,
    new_upper: Index, new_lower: Index,
) -> bool:  # fmt: skip
    """Whether grip and bars let one gripper (0 upper, 1 lower) turn at a pair, as far as any part of the turn."""
    uses, kinds, swing_on, swing_off, row_of_pair, mechanism, row_of_place, by_upper, by_lower = bars
    new_slot = _slot(near, new_upper, new_lower)
    if new_slot < 0:
        return False
    end = new_slot if gripper == 1 else turn
    swing = swing_on[kinds[here], gripper, upper, slot, end] if kinds[here] >= 0 else swing_off[here]
    if max(uses[here, upper, slot, gripper], uses[here, new_upper, new_slot, gripper]) * swing > 1.0:
        return False
    row, place = row_of_pair[here], row_of_place[pairs[here, 0]]
    if gripper == 0:
        return not (row >= 0 and mechanism[row, upper, turn] or place >= 0 and by_upper[place, upper, slot, turn])
    return not (place >= 0 and by_lower[place, upper, slot, turn])


@njit(cache=True)
def _forbidden(banned: Indices, start: int, end: int) -> bool:
    for row in range(banned.shape[0]):
        if banned[row, 0] == start and banned[row, 1] == end:
            return True
    return False
