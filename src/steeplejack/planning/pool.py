"""Stances for a cell that a plan may choose from.

Each cell has a small pool: the stance of the grid; stances with a large slip margin, found uphill from the best of the
grid by the compass search of :mod:`steeplejack.design.stances`; the best of the cell below, moved up the stays; stances
for what the best one leaves over; and stances about as good with less driving from, or to, a neighbouring cell's. Which
of them a plan takes is decided together with the moves between them, see :mod:`steeplejack.planning.chain`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.stances.ground import on_bay
from steeplejack.design.stances.search import Room, compass
from steeplejack.planning.cell import AMPLE, Candidate, Cell, Judge, worth
from steeplejack.planning.certificate import Scene
from steeplejack.planning.lattice import Lattice
from steeplejack.planning.stances import SOME, find, first_of, ranked
from steeplejack.robots.squad.anchorage import Stance

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

LOWER = -10.0, 8.0  # [m] above a cell's lower end that a lower base may stand
UPPER = 0.0, 40.0  # [m] above its upper end that an upper base may stand
SEEDS = 30  # stances of the grid certified at some places before the search starts from the best
WALKS = 2  # searches, from stances that lie
DIFFERENT = 4.0  # [m] of driving apart
WIDE, TOLERANCE = 2.0, 0.5  # [m] first and last step of a search
RESTS = 2  # stances for what the best one leaves over
HOME = np.linspace(0.0, 1.0, 5)  # shares of each base's way to a neighbour's stance that are tried
TRIED = 16  # of these, certified at some places
SAVED = 1.0  # [m] of driving that make a stance worth having
GIVEN_UP = 0.01  # [1] of margin that less driving may cost
SAME = 0.05  # [m] within which two stances are one


Site = tuple[Scene, Cell, Lattice]


def pools(sites: Sequence[Site], step: Callable[[float], None]) -> list[tuple[Candidate, ...]]:
    """Candidates for every cell of a stretch, from below; ``step`` is called with the share done."""
    own: list[tuple[Candidate, ...]] = []
    for i, (scene, cell, lattice) in enumerate(sites):
        below = _moved(_best(own[-1])[:WALKS], cell.low - sites[i - 1][1].low) if own else np.empty((0, 4))
        own.append(_pool(scene, cell, lattice, below))
        step((i + 1) / len(sites))
    return [_distinct([*own[i], *_between(site, own, i)]) for i, site in enumerate(sites)]


def _between(site: Site, own: Sequence[Sequence[Candidate]], i: int) -> list[Candidate]:
    """Candidates for cell ``i`` with less driving from the best of the cell below, and to that of the cell above."""
    found: list[Candidate] = []
    for j in (i - 1, i + 1):
        if own[i] and 0 <= j < len(own) and own[j]:
            near = _nearer(*site, _best(own[i])[0], _best(own[j])[0].stance, j < i)
            found += [] if near is None else [near]
    return found


def _best(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Candidates by what they are worth, best first."""
    return sorted(candidates, key=worth, reverse=True)


def _moved(candidates: Sequence[Candidate], by: float) -> Array:
    """Stances (n, 4) [m], moved along the stays."""
    return np.array([each.stance.s for each in candidates]).reshape(-1, 4) + by


def _distinct(candidates: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Candidates that hold anything, the first of those that stand alike."""
    out: list[Candidate] = []
    for one in candidates:
        apart = [np.max(np.abs(np.subtract(one.stance.s, other.stance.s))) for other in out]
        if one.held.any() and min(apart, default=np.inf) > SAME:
            out.append(one)
    return tuple(out)


def _pool(scene: Scene, cell: Cell, lattice: Lattice, below: Array) -> tuple[Candidate, ...]:
    """Candidates for a cell; ``below`` (n, 4) [m] the best of the cell below, moved up here."""
    grid, count = ranked(scene, cell, lattice)
    if not len(grid):
        return ()
    some, full = Judge.of(scene, cell, lattice, every=SOME), Judge.of(scene, cell, lattice)
    room = room_about(scene, cell)
    below = below[room.admits(np.zeros(1, np.int64), below[None])[0]]
    first = first_of(full, grid, count)
    out = [] if first is None else [first]
    out += [full.candidate(s) for s in _uphill(some, room, np.concatenate([grid[:SEEDS], below]))]
    out += [full.candidate(s) for s in below[:1]]
    left = cell.wanted & ~_best(out)[0].held
    for _ in range(RESTS):
        rest = find(scene, replace(cell, wanted=left), lattice)
        if rest is None:
            break
        out.append(full.candidate(np.array(rest.stance.s)))
        left &= ~rest.held
    return _distinct(out)


def room_about(scene: Scene, cell: Cell) -> Room:
    """Where the bases may stand for a cell: on their stays, about its ends."""
    ground = on_bay(scene.bay, scene.squad, scene.rules.tension, scene.rules.reserve)
    low, high = (np.array([cell.low + LOWER[k]] * 2 + [cell.high + UPPER[k]] * 2) for k in (0, 1))
    windows = np.stack([np.maximum(low, ground.range[:, 0]), np.minimum(high, ground.range[:, 1])], -1)
    return Room(windows[None], ground.barred, ground.pairs, float(ground.machine[3]))


def _uphill(judge: Judge, room: Room, seeds: Array) -> list[Array]:
    """Stances (4,) [m] that the compass search reaches from the best seeds (n, 4) that differ."""
    seeds = seeds[room.admits(np.zeros(1, np.int64), seeds[None])[0]]
    values = np.array([worth(judge.candidate(s)) for s in seeds])
    starts: list[int] = []
    for i in np.argsort(-values, kind="stable"):
        if len(starts) < WALKS and all(np.sum(np.abs(seeds[i] - seeds[j])) > DIFFERENT for j in starts):
            starts.append(int(i))
    return [_walked(judge, room, seeds[i], float(values[i])) for i in starts]


def _walked(judge: Judge, room: Room, start: Array, value: float) -> Array:
    """The stance (4,) [m] worth most by the places looked at, uphill from one worth ``value``, one base at a time."""
    most = value

    def certified(rows: Indices, trials: Array) -> Array:
        """Worth of trials (1, c, 4), ``-inf`` where by the survey they hold less than the best so far."""
        nonlocal most
        out, open_ = np.full(trials.shape[:2], -np.inf), room.admits(rows, trials)[0]
        open_[open_] = judge.surveyed(trials[0][open_])[0] + AMPLE > most
        for i in np.flatnonzero(open_):
            out[0, i] = worth(judge.candidate(trials[0, i]))
        most = max(most, float(np.max(out)))
        return out

    return compass(certified, room, start[None], np.array([value]), WIDE, TOLERANCE, together=False)[0][0]


def _nearer(
    scene: Scene, cell: Cell, lattice: Lattice, best: Candidate, goal: Stance, standing: bool
) -> Candidate | None:
    """A candidate as good as the best with less driving to, or where it is ``standing``, from a neighbour's stance."""
    now = goal if standing else None
    s, there = np.array(best.stance.s), np.array(goal.s)
    ways = np.array(list(product(*(s[i] + HOME * (there[i] - s[i]) for i in range(4)))))
    away = np.sum(np.abs(ways - there), axis=1)
    room = room_about(scene, cell)
    between = np.stack([np.minimum(room.windows[..., 0], there), np.maximum(room.windows[..., 1], there)], -1)
    good = replace(room, windows=between).admits(np.zeros(1, np.int64), ways[None])[0]
    good &= away <= np.sum(np.abs(s - there)) - SAVED
    judge = Judge.of(scene, replace(cell, wanted=best.held), lattice, now, SOME)
    stations = len(np.unique(judge.stations))
    good[good] = judge.surveyed(ways[good])[0] >= stations
    options = np.flatnonzero(good)
    for i in options[np.argsort(away[options], kind="stable")][:TRIED]:
        one = judge.candidate(ways[i])
        if one.held.sum() < stations or one.margin < best.margin - GIVEN_UP:
            continue
        one = Judge.of(scene, cell, lattice, now).candidate(ways[i])
        if one.held.sum() >= best.held.sum():
            return one
    return None
