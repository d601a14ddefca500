"""The grid of stances for a cell: where the four bases may stand so that the platform is held along it.

Candidates are products of a few offsets of each base from the ends of the cell. The fast survey ranks them by how much
of the cell they hold, at some stations first to save time; the best are certified until one holds as much as any can.
From there :mod:`steeplejack.planning.pool` goes on. With far fewer plans miss stations or keep less slip margin.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.cell import Candidate, Cell, Judge, middle
from steeplejack.planning.certificate import Scene, binding, survey
from steeplejack.planning.lattice import Lattice, visible_levels
from steeplejack.robots.squad.anchorage import admissible, facing

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# Offsets of a lower base above the cell's lower end, of an upper base above its upper end [m]. Upper bases stand well
# above: at 25-45 deg of inclination a cable from close above pulls along the platform's own stay and lifts little.
LOWER = (-10.0, -6.0, -4.0, -2.0, 0.0, 2.0, 4.0)
UPPER = (3.0, 6.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0)
SOME = 4, 3  # every so many stations, and stand-offs, are looked at first
RANKED = 400  # stances surveyed at all of them
CERTIFIED = 12  # stances certified in full before the best of them is taken


def grid_about(scene: Scene, cell: Cell) -> Array:
    """Stances (n, 4) of base positions [m] that stand clear of end zones, obstacles and each other."""
    bay, squad = scene.bay, scene.squad
    grid = np.array(list(product(LOWER, LOWER, UPPER, UPPER)))
    grid += np.array([cell.low, cell.low, cell.high, cell.high])
    good = np.ones(len(grid), bool)
    for base in range(4):
        good &= admissible(bay, squad, base, grid[:, base])
    spacing = squad.base.spacing
    good &= (grid[:, 3] - grid[:, 0] >= spacing) & (grid[:, 2] - grid[:, 1] >= spacing)
    reach = squad.winch.stored_length
    return grid[good & (np.max(grid, axis=1) - cell.low < reach)]


def ranked(scene: Scene, cell: Cell, lattice: Lattice) -> tuple[Array, Indices]:
    """Stances (n, 4) [m] that hold most of a cell by the survey, best first, and how many stations each holds (n,).

    Among stances that hold the same number of stations, the one with more room on average comes first.
    """
    grid = grid_about(scene, cell)
    if not len(grid) or not cell.wanted.any():
        return np.empty((0, 4)), np.empty(0, np.int64)
    some, full = Judge.of(scene, cell, lattice, every=SOME), Judge.of(scene, cell, lattice)
    if len(full.places) > 2 * len(some.places):
        count, room = some.surveyed(grid)
        if np.count_nonzero(count) >= RANKED:  # of fewer nothing is known: what they hold may lie between
            grid = grid[np.sort(_order(count, room)[:RANKED])]
    count, room = full.surveyed(grid)
    order = _order(count, room)
    return grid[order], count[order]


def _order(count: Indices, room: Array) -> Indices:
    return np.argsort(-(count + room / 1000.0), kind="stable")


def find(scene: Scene, cell: Cell, lattice: Lattice) -> Candidate | None:
    """The stance of the grid that holds most of a cell; None where none holds any."""
    return first_of(Judge.of(scene, cell, lattice), *ranked(scene, cell, lattice))


def first_of(judge: Judge, grid: Array, count: Indices) -> Candidate | None:
    """Of ranked stances the one certified to hold most; None where none of the first holds any."""
    best: Candidate | None = None
    for s, most in zip(grid[:CERTIFIED], count, strict=False):
        if best is not None and most <= best.held.sum():
            break
        one = judge.candidate(s)
        if best is None or one.held.sum() > best.held.sum():
            best = one
    return best if best is not None and best.held.any() else None


def why_not(scene: Scene, cell: Cell, lattice: Lattice, row: int, stations: Iterable[int]) -> list[str]:
    """The limit that binds at each of some stations no candidate holds, for the candidate that comes closest there."""
    grid = grid_about(scene, cell)
    if not len(grid):
        return ["no place for the bases clear of end zones and obstacles" for _ in stations]
    k = scene.bay.interior[row]
    levels = lattice.d[visible_levels(scene, lattice, k)]
    anchors, pull = scene.anchors(grid, facing(scene.bay, grid, middle(scene, cell)))
    lower, upper = scene.window
    out: list[str] = []
    for station in stations:
        s = float(lattice.s[station])
        places = np.column_stack([np.full(len(levels), float(k)), np.full(len(levels), s), levels])
        points = scene.bay.place(places[:, 0], places[:, 1], places[:, 2])
        rotation = scene.bay.frame(float(k), s)
        room = survey(anchors, pull, scene.attachments, scene.weight, rotation, points, lower, upper)
        stance, level = np.unravel_index(int(np.argmax(room)), room.shape)
        out.append(binding(scene, anchors[stance], pull[stance], places[level]))
    return out
