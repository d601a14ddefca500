"""Anchors along a path with a price on driving: which configuration at each pose, and which base drives when.

Between two poses the bases drive one at a time while the platform stands; each base at most once, in the order that
serves best. A base may drive only where the platform stays held all the way with that base's own, lower limit on its
pull. Over a grid of offsets this is solved exactly by dynamic programming:

    ``V_k(v') = W_k(v') + max over orders and v of V_{k-1}(v) - price sum_i |v'_i - v_i| s_i``

where ``s_i`` is the length of stay in a metre of x. The cost is a sum over bases and every one drives once, so the
maximum over the 24 orders is built up over the sixteen sets of bases that have had their turn:
``V_S = max over i in S of drive_i(V_{S without i})``, and a drive moves along one axis of the grid.

Poses no configuration holds count nothing and leave the bases free; where one exists, holding comes before any value.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.design.anchors.problem import Reconfiguration
from steeplejack.design.anchors.worth import GRIPPED, Duty, worth

Array = NDArray[np.float64]
Flags = NDArray[np.uint8]
Candidates = tuple[Array, Array, Array, Array]


@dataclass(frozen=True, eq=False)
class Travel:
    """A path of configurations.

    Attributes:
        offsets: Of the anchors along x at every pose, (k, 4) [m].
        orders: Bases in the order they drive before each pose but the first, k - 1 tuples of indices.
    """

    offsets: Array
    orders: tuple[tuple[int, ...], ...]


def best_travel(
    problem: Reconfiguration,
    candidates: Candidates,
    duty: Duty,
    price: float,
    most_step: float = np.inf,
    start: Array | None = None,
) -> Travel:
    """The best path over every combination of candidate offsets.

    Args:
        problem: Anchors, platform and path.
        candidates: Offsets each anchor may take, four sorted arrays [m].
        duty: What is borne and what counts.
        price: Of a metre driven along a stay, in units of the objective summed over poses [1/m].
        most_step: Farthest a base drives between two poses, along its stay [m].
        start: Offsets the bases stand at, at the first pose (4,) [m], among the candidates; None if free to choose.

    Returns:
        The path; the choice of a best path among equals is the first of the grid.
    """
    value, flags = worth(problem, candidates, duty)
    held = (flags & GRIPPED) > 0
    possible = held.any(axis=(1, 2, 3, 4))
    stretch = np.hypot(problem.directions[:, 0], problem.directions[:, 1])
    grids = tuple(np.ascontiguousarray(axis) * scale for axis, scale in zip(candidates, stretch, strict=True))
    # A pose that is not held where it could be costs more than any path can gain by values or save by not driving.
    farthest = len(value) * sum(float(axis[-1] - axis[0]) for axis in grids)
    value[~held] = -(1.0 + 2.0 * len(value) * float(np.abs(value).max()) + price * farthest)
    value[~possible] = 0.0
    flags[~possible] = 31
    if start is not None:
        allowed = np.full(value.shape[1:], -np.inf)
        allowed[tuple(int(np.argmin(np.abs(axis - at))) for axis, at in zip(candidates, start, strict=True))] = 0.0
        value[0] += allowed
    # Only the last stage of each pose is kept; on the way back the sets of bases are computed again from it.
    stages = value
    for k in range(1, len(stages)):
        stages[k] += _drives(stages[k - 1], flags[k - 1], grids, price, most_step)[15]
    return _traced(stages, flags, candidates, grids, price, most_step)


def _drives(before: Array, flags: Flags, grids: Candidates, price: float, most_step: float) -> Array:
    """Values after every set of bases has had its turn, (16, n_1, n_2, n_3, n_4)."""
    after = np.full((16, *before.shape), -np.inf)
    after[0] = before
    for turn in range(1, 16):
        for base in range(4):
            if turn >> base & 1:
                shape = _lines(before.shape, base)
                source, target = after[turn ^ (1 << base)].reshape(shape), after[turn].reshape(shape)
                _drive(source, target, flags.reshape(shape), _needed(base), grids[base], price, most_step)
    return after


def _lines(shape: tuple[int, ...], base: int) -> tuple[int, int, int]:
    """A grid with the axis of one base in the middle."""
    return int(np.prod(shape[:base])), shape[base], int(np.prod(shape[base + 1 :]))


def _needed(base: int) -> np.uint8:
    """The flags of a place a base may drive at: held gripped, and with it driving."""
    return np.uint8(GRIPPED | 1 << base)


@njit(cache=True)
def _drive(
    source: Array, target: Array, flags: Flags, needed: np.uint8, places: Array, price: float, most_step: float
) -> None:
    """Raise ``target`` to the best value after one base drove along the middle axis or stood, held all the way."""
    pre, n, post = source.shape
    for a in range(pre):
        for j in range(n):
            for c in range(post):
                target[a, j, c] = max(target[a, j, c], source[a, j, c])
        if most_step >= places[n - 1] - places[0]:
            _sweep(source[a], target[a], flags[a], needed, places, price, 0, n, 1)
            _sweep(source[a], target[a], flags[a], needed, places, price, n - 1, -1, -1)
        else:
            _reach(source[a], target[a], flags[a], needed, places, price, most_step)


@njit(cache=True)
def _sweep(
    source: Array,
    target: Array,
    flags: Flags,
    needed: np.uint8,
    places: Array,
    price: float,
    first: int,
    stop: int,
    way: int,
) -> None:
    """Drives of any length one way: what a place gives is carried on, less the price of each stretch."""
    post = source.shape[1]
    carried = np.full(post, -np.inf)
    gap = 0.0
    for j in range(first, stop, way):
        if j != first:
            gap = price * abs(places[j] - places[j - way])
        for c in range(post):
            if flags[j, c] & needed == needed:
                carried[c] = max(carried[c] - gap, source[j, c])
                target[j, c] = max(target[j, c], carried[c])
            else:
                carried[c] = -np.inf


@njit(cache=True)
def _reach(
    source: Array, target: Array, flags: Flags, needed: np.uint8, places: Array, price: float, most_step: float
) -> None:
    """Drives no longer than ``most_step``."""
    n, post = source.shape
    for j in range(n):
        for c in range(post):
            for way in (-1, 1):
                i = j
                while 0 <= i < n and flags[i, c] & needed == needed and abs(places[i] - places[j]) <= most_step:
                    target[j, c] = max(target[j, c], source[i, c] - price * abs(places[i] - places[j]))
                    i += way


def _traced(
    stages: Array, flags: Flags, candidates: Candidates, grids: Candidates, price: float, most_step: float
) -> Travel:
    """The best path, from its end back to its start."""
    at = [int(i) for i in np.unravel_index(int(np.argmax(stages[-1])), stages[-1].shape)]
    offsets, orders = np.empty((len(stages), 4)), []
    for k in range(len(stages) - 1, -1, -1):
        offsets[k] = [axis[index] for axis, index in zip(candidates, at, strict=True)]
        if k:
            after = _drives(stages[k - 1], flags[k - 1], grids, price, most_step)
            orders.append(_back(after, at, flags[k - 1], grids, price, most_step))
    return Travel(offsets, tuple(reversed(orders)))


def _back(
    after: Array, at: list[int], flags: Flags, grids: Candidates, price: float, most_step: float
) -> tuple[int, ...]:
    """Undo one stage: moves ``at`` to where the bases stood before; returns the order in which they drove."""
    order: list[int] = []
    turn = 15
    while turn:
        goal = after[turn][tuple(at)]
        base, index = _last(after, turn, at, goal, flags, grids, price, most_step)
        if index != at[base]:
            order.append(base)
            at[base] = index
        turn ^= 1 << base
    return tuple(reversed(order))


def _last(
    after: Array,
    turn: int,
    at: list[int],
    goal: float,
    flags: Flags,
    grids: Candidates,
    price: float,
    most_step: float,
) -> tuple[int, int]:
    """The base that had the last turn, and the place it came from: tried one by one with the kernel that drove."""
    for base in range(4):
        if not turn >> base & 1:
            continue
        line = tuple(slice(None) if axis == base else at[axis] for axis in range(4))
        came, may = after[turn ^ (1 << base)][line], flags[line].reshape(1, -1, 1)
        for index in np.argsort(np.abs(np.arange(len(came)) - at[base]), kind="stable"):
            source, target = np.full((2, 1, len(came), 1), -np.inf)
            source[0, index, 0] = came[index]
            _drive(source, target, may, _needed(base), grids[base], price, most_step)
            if target[0, at[base], 0] >= goal > -np.inf:
                return base, int(index)
    raise AssertionError("a value without an origin")
