"""Plain search for stances: where the four bases stand so that the platform is held along a cell.

Candidates are products of a few offsets of each base from the ends of the cell. The fast survey ranks them by how much
of the cell they hold; the best are certified until one holds as much as any can.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.certificate import Scene, binding, hold, survey
from steeplejack.planning.lattice import Lattice, visible_levels
from steeplejack.robots.squad.anchorage import Stance, admissible, facing

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Offsets of a lower base above the cell's lower end, of an upper base above its upper end [m]. Upper bases stand well
# above: at 25-45 deg of inclination a cable from close above pulls along the platform's own stay and lifts little.
LOWER = (-10.0, -6.0, -4.0, -2.0, 0.0, 2.0, 4.0)
UPPER = (3.0, 6.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0)
CERTIFIED = 12  # stances certified in full before the best of them is taken


@dataclass(frozen=True)
class Cell:
    """A stretch of the bay inspected from one stance: stations (interior stays, stations) along [low, high]."""

    low: float
    high: float
    wanted: Flags  # (interior stays, stations)


def candidates(scene: Scene, cell: Cell) -> Array:
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


def middle(scene: Scene, cell: Cell) -> Array:
    """World point (3,) [m] in the middle of a cell at the middle of the camera's range."""
    near, far = scene.squad.camera.stand_off
    radius = max(scene.bay.radius(k) for k in scene.bay.interior)
    eta = 0.5 * (len(scene.bay.stays) - 1)
    return scene.bay.place(eta, 0.5 * (cell.low + cell.high), radius + 0.5 * (near + far))


def _inspected(scene: Scene, cell: Cell, lattice: Lattice) -> tuple[Array, NDArray[np.int64]]:
    """Places (n, 3) from which wanted stations can be seen, and the flat station of each."""
    places, stations = [], []
    for row, k in enumerate(scene.bay.interior):
        levels = lattice.d[visible_levels(scene, lattice, k)]
        for j in np.flatnonzero(cell.wanted[row]):
            places.append(np.column_stack([np.full(len(levels), float(k)), np.full(len(levels), lattice.s[j]), levels]))
            stations.append(np.full(len(levels), row * cell.wanted.shape[1] + j))
    return np.concatenate(places), np.concatenate(stations)


def find(scene: Scene, cell: Cell, lattice: Lattice) -> tuple[Stance, Flags] | None:
    """The stance that holds most of a cell, and the stations it holds; None where no candidate holds any."""
    grid = candidates(scene, cell)
    if not len(grid) or not cell.wanted.any():
        return None
    places, stations = _inspected(scene, cell, lattice)
    points = scene.bay.place(places[:, 0], places[:, 1], places[:, 2])
    clock = facing(scene.bay, grid, middle(scene, cell))
    anchors, pull = scene.anchors(grid, clock)
    lower, upper = scene.window
    eta = 0.5 * (len(scene.bay.stays) - 1)
    rotation = scene.bay.frame(eta, 0.5 * (cell.low + cell.high))
    room = survey(anchors, pull, scene.attachments, scene.weight, rotation, points, lower, upper)
    held = np.zeros((len(grid), cell.wanted.size))
    np.maximum.at(held.T, stations, np.maximum(room, 0.0).T)
    count = np.sum(held > 0.0, axis=1)
    # Among stances that hold the same number of stations, the one with more room on average.
    order = np.argsort(-(count + np.mean(np.minimum(held, 200.0), axis=1) / 1000.0), kind="stable")
    best: tuple[Stance, Flags] | None = None
    for index in order[:CERTIFIED]:
        if best is not None and count[index] <= best[1].sum():
            break
        certified = hold(scene, anchors[index], pull[index], places).good
        flags = np.zeros(cell.wanted.size, bool)
        flags[stations[certified]] = True
        if best is None or flags.sum() > best[1].sum():
            s, angle = (tuple(float(v) for v in row) for row in (grid[index], clock[index]))
            best = Stance(s, angle), flags.reshape(cell.wanted.shape)  # pyright: ignore[reportArgumentType]
    return best if best is not None and best[1].any() else None


def why_not(scene: Scene, cell: Cell, lattice: Lattice, row: int, station: int) -> str:
    """The limit that binds at a station no candidate holds, for the candidate that comes closest."""
    grid = candidates(scene, cell)
    if not len(grid):
        return "no place for the bases clear of end zones and obstacles"
    k = scene.bay.interior[row]
    levels = lattice.d[visible_levels(scene, lattice, k)]
    places = np.column_stack([np.full(len(levels), float(k)), np.full(len(levels), lattice.s[station]), levels])
    points = scene.bay.place(places[:, 0], places[:, 1], places[:, 2])
    clock = facing(scene.bay, grid, middle(scene, cell))
    anchors, pull = scene.anchors(grid, clock)
    lower, upper = scene.window
    rotation = scene.bay.frame(float(k), float(lattice.s[station]))
    room = survey(anchors, pull, scene.attachments, scene.weight, rotation, points, lower, upper)
    stance, level = np.unravel_index(int(np.argmax(room)), room.shape)
    return binding(scene, anchors[stance], pull[stance], places[level])
