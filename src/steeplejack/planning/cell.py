"""A cell of the stretch to be inspected, and what a stance is worth along it by the certificate.

Stations of a cell are seen from places at several stand-offs; a stance holds a station where one of them is good. Its
margin at a station is that of the best such place, and what it is worth is counted in stations first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.certificate import Scene, hold, slip_margin, survey
from steeplejack.planning.lattice import Lattice, visible_levels
from steeplejack.robots.squad.anchorage import Stance, facing

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]

AMPLE = 0.2
"""Slip margin beyond which more counts no further [1]: twice the usual reserve."""
PLENTY = 200.0
"""Room of the tensions beyond which more ranks no higher [N]."""
APART = 1e-9
"""Distance at which a base counts as driven [m]."""
Four = tuple[float, float, float, float]


@dataclass(frozen=True)
class Cell:
    """A stretch of the bay inspected from one stance: stations (interior stays, stations) along [low, high]."""

    low: float
    high: float
    wanted: Flags  # (interior stays, stations)


@dataclass(frozen=True, eq=False)
class Candidate:
    """A stance for a cell, the stations it holds, and the least over them of its slip margin there, ample at most."""

    stance: Stance
    held: Flags  # (interior stays, stations)
    margin: float


def middle(scene: Scene, cell: Cell) -> Array:
    """World point (3,) [m] in the middle of a cell at the middle of the camera's range."""
    near, far = scene.squad.camera.stand_off
    radius = max(scene.bay.radius(k) for k in scene.bay.interior)
    eta = 0.5 * (len(scene.bay.stays) - 1)
    return scene.bay.place(eta, 0.5 * (cell.low + cell.high), radius + 0.5 * (near + far))


@dataclass(frozen=True, eq=False)
class Judge:
    """Places of a cell that stances are judged by; each shows one wanted station.

    A base at its place of ``now`` keeps its clock angle; any other turns its exit to the cell's middle.
    """

    scene: Scene
    cell: Cell
    now: Stance | None
    places: Array  # (n, 3)
    points: Array  # (n, 3) [m]
    stations: Indices  # (n,) flat index into the cell's wanted

    @classmethod
    def of(
        cls, scene: Scene, cell: Cell, lattice: Lattice, now: Stance | None = None, every: tuple[int, int] = (1, 1)
    ) -> Judge:
        """Places from which wanted stations can be seen: of each stay ``every`` so many stations, and stand-offs."""
        along, off = every
        places, stations = [np.empty((0, 3))], [np.empty(0, np.int64)]
        for row, k in enumerate(scene.bay.interior):
            levels = lattice.d[visible_levels(scene, lattice, k)][::off]
            wanted = np.flatnonzero(cell.wanted[row])
            some = np.unique(np.append(wanted[::along], wanted[-1:]))
            s, d = (grid.ravel() for grid in np.meshgrid(lattice.s[some], levels, indexing="ij"))
            places.append(np.column_stack([np.full(len(s), float(k)), s, d]))
            stations.append(np.repeat(row * cell.wanted.shape[1] + some, len(levels)))
        found = np.concatenate(places)
        return cls(scene, cell, now, found, scene.bay.place(*found.T), np.concatenate(stations))

    def clock(self, s: Array) -> Array:
        """Clock angles (..., 4) [rad] of bases at ``s`` (..., 4) [m]."""
        clock = facing(self.scene.bay, s, middle(self.scene, self.cell))
        if self.now is None:
            return clock
        return np.where(np.abs(s - np.array(self.now.s)) > APART, clock, np.array(self.now.clock))

    def surveyed(self, s: Array) -> tuple[Indices, Array]:
        """Stations that stances (c, 4) [m] hold by the fast survey (c,), and the mean room there (c,) [N]."""
        scene, cell = self.scene, self.cell
        anchors, pull = scene.anchors(s, self.clock(s))
        eta = 0.5 * (len(scene.bay.stays) - 1)
        rotation = scene.bay.frame(eta, 0.5 * (cell.low + cell.high))
        room = survey(anchors, pull, scene.attachments, scene.weight, rotation, self.points, *scene.window)
        most = np.zeros((cell.wanted.size, len(s)))
        np.maximum.at(most, self.stations, np.maximum(room, 0.0).T)
        return np.sum(most > 0.0, axis=0), np.mean(np.minimum(most, PLENTY), axis=0)

    def candidate(self, s: Array) -> Candidate:
        """A stance (4,) [m] with the stations it is certified to hold, of those looked at."""
        clock = self.clock(s)
        anchors, pull = self.scene.anchors(s, clock)
        held = hold(self.scene, anchors, pull, self.places)
        most = np.full(self.cell.wanted.size, -np.inf)
        margins = slip_margin(self.scene, anchors, pull, self.points, held.rotation, held.tension)
        np.maximum.at(most, self.stations[held.good], margins[held.good])
        flags = np.isfinite(most)
        least = float(np.min(most[flags], initial=AMPLE))
        return Candidate(Stance(_four(s), _four(clock)), flags.reshape(self.cell.wanted.shape), least)


def worth(candidate: Candidate) -> float:
    """Stations held plus the margin, which is below 1; 0 where none is held."""
    return float(candidate.held.sum()) + candidate.margin if candidate.held.any() else 0.0


def _four(values: Array) -> Four:
    a, b, c, d = (float(value) for value in values)
    return a, b, c, d
