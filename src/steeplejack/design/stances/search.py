"""The outer problem of a stance: where the movable bases stand, by a grid, then by compass search.

The objective is continuous in the places of the bases but neither smooth nor concave, so the search looks at a grid
over all movable bases together, then walks from the best of its nodes with steps in every combination of directions
(coordinates alone stall on the kinks), halving them down to a tolerance. What it returns is feasible and at least as
good as every node it saw; it is no proof of optimality.

An optimum is often flat: among places within a slack of the best, the one with the least driving from where the bases
stand is taken, again from the grid and by compass.

Many questions are asked at once, one a row; what a stance is worth is a function handed in.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Worth = Callable[[Indices, Array], Array]
"""Worth (n, c) of stances (n, c, m) asked for rows (n,); ``-inf`` where the bases may not stand."""


@dataclass(frozen=True, eq=False)
class Room:
    """Where the bases of every row may stand.

    Attributes:
        windows: Least and largest place (n, m, 2) [m]; upside down where a base has none.
        barred: Open intervals that no base's centre may stand in (m, q, 2) [m].
        pairs: Lower and upper base on one stay (p, 2).
        spacing: Least distance of a pair [m].
    """

    windows: Array
    barred: Array
    pairs: Indices
    spacing: float

    def admits(self, rows: Indices, stances: Array) -> NDArray[np.bool_]:
        """Whether bases may stand at ``stances`` (n, c, m) of rows (n,), as (n, c)."""
        windows = self.windows[rows][:, None]
        good = np.all((stances >= windows[..., 0]) & (stances <= windows[..., 1]), axis=-1)
        for base in range(stances.shape[-1]):
            for low, high in self.barred[base]:
                good &= (stances[..., base] <= low) | (stances[..., base] >= high)
        for low, high in self.pairs:
            good &= stances[..., high] - stances[..., low] >= self.spacing
        return good

    def grid(self, count: int) -> Array:
        """A grid (n, c, m) over the windows with ``count`` places a base; one for a base that does not move."""
        m = self.windows.shape[1]
        moves = np.any(self.windows[..., 1] > self.windows[..., 0], axis=0)
        axes = [np.linspace(0.0, 1.0, count) if moves[base] else np.zeros(1) for base in range(m)]
        share = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, m)
        return self.windows[:, None, :, 0] + share * (self.windows[..., 1] - self.windows[..., 0])[:, None]


@dataclass(frozen=True, eq=False)
class Found:
    """The best stance of every row.

    Attributes:
        s: Places of the bases (n, m) [m]; not a number where none is admitted.
        worth: (n,).
        best: The largest worth found (n,).
    """

    s: Array
    worth: Array
    best: Array


def compass(
    worth: Worth, room: Room, s: Array, value: Array, wide: float, tolerance: float, together: bool = True
) -> tuple[Array, Array]:
    """Walk uphill from stances (n, m) worth ``value`` (n,), with steps from ``wide`` down to ``tolerance`` [m].

    Bases step ``together``, in every combination, or one at a time where a worth is dear.

    Returns:
        Stances (n, m) [m] and their worth (n,).
    """
    moves = np.any(room.windows[..., 1] > room.windows[..., 0], axis=0)
    steps = np.array([step for step in product(*((-1.0, 0.0, 1.0) if move else (0.0,) for move in moves)) if any(step)])
    steps = steps if together or not len(steps) else steps[np.count_nonzero(steps, axis=1) == 1]
    s, value = s.copy(), value.copy()
    width = np.where(np.isfinite(value), wide, 0.0) if len(steps) else np.zeros(len(s))
    while len(rows := np.flatnonzero(width > tolerance)):
        windows = room.windows[rows][:, None]
        trial = np.clip(s[rows, None] + width[rows, None, None] * steps, windows[..., 0], windows[..., 1])
        values = worth(rows, trial)
        choice = np.argmax(values, axis=1)
        found = np.take_along_axis(values, choice[:, None], 1)[:, 0]
        better = found > value[rows]
        s[rows[better]], value[rows[better]] = trial[better, choice[better]], found[better]
        width[rows[~better]] *= 0.5
    return s, value


def best_stances(
    worth: Worth, room: Room, now: Array, count: int, starts: int, tolerance: float, slack: float = 0.0
) -> Found:
    """The best stance of every row.

    Args:
        worth: What a stance is worth.
        room: Where bases may stand.
        now: Where they stand (n, m) [m]; counts as a node of the grid.
        count: Nodes of the grid for each movable base.
        starts: Nodes that compass search starts from.
        tolerance: Its last step [m].
        slack: Of the objective that less driving may cost; with 0 the best itself.
    """
    rows = np.arange(len(now))
    nodes = np.concatenate([now[:, None], room.grid(count)], axis=1)
    values = worth(rows, nodes)
    mesh = float(np.max(room.windows[..., 1] - room.windows[..., 0], initial=0.0)) / max(count - 1, 1)
    order = np.argsort(-values, axis=1, kind="stable")[:, :starts]
    s, most = np.full(now.shape, np.nan), np.full(len(now), -np.inf)
    for rank in range(order.shape[1]):
        begin, value = nodes[rows, order[:, rank]], values[rows, order[:, rank]]
        begin, value = compass(worth, room, begin, value, 0.5 * mesh, tolerance)
        better = value > most
        s[better], most[better] = begin[better], value[better]
    if slack <= 0.0:
        return Found(s, most, most)
    near = _nearest(worth, room, now, nodes, values, s, most - slack, 0.5 * mesh, tolerance)
    return Found(near, worth(rows, near[:, None])[:, 0], most)


def _nearest(
    worth: Worth,
    room: Room,
    now: Array,
    nodes: Array,
    values: Array,
    s: Array,
    floor: Array,
    wide: float,
    tolerance: float,
) -> Array:
    """Stances (n, m) [m] worth at least ``floor`` (n,) with little driving, from the nodes and from ``s``."""
    every = np.arange(len(now))
    drive = np.where(values >= floor[:, None], np.sum(np.abs(nodes - now[:, None]), axis=-1), np.inf)
    nearest = np.argmin(drive, axis=1)
    node = nodes[every, nearest]
    closer = drive[every, nearest] < np.sum(np.abs(s - now), axis=-1)
    begin = np.where(closer[:, None], node, s)

    def less(rows: Indices, stances: Array) -> Array:
        return np.where(
            worth(rows, stances) >= floor[rows, None], -np.sum(np.abs(stances - now[rows, None]), axis=-1), -np.inf
        )

    # The whole way home first, and each base's: what costs nothing is not driven.
    shares = np.linspace(0.0, 1.0, 9)[1:]
    trial = begin[:, None] + shares[:, None] * (now - begin)[:, None]
    for base in range(now.shape[1]):
        alone = np.repeat(begin[:, None], len(shares), axis=1)
        alone[..., base] += shares * (now - begin)[:, base, None]
        trial = np.concatenate([trial, alone], axis=1)
    trial = np.concatenate([begin[:, None], trial], axis=1)
    values = less(every, trial)
    choice = np.argmax(values, axis=1)
    return compass(less, room, trial[every, choice], values[every, choice], wide, tolerance)[0]
