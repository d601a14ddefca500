"""Places of the platform on a lattice, which of them a stance holds, and routes through the held ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from steeplejack.planning.certificate import Held, Scene, hold

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

ACROSS_STEP = 0.25  # [stays] between neighbours across the bay
ALONG_STEP = 0.5  # [m] between stations along a stay, for inspection
OFF_STEP = 0.05  # [m] between levels of stand-off, for inspection
BEYOND_CAMERA = 0.8  # [m] past the camera's range that the platform may use when it does not inspect
SWING = 0.05  # [m] kept from both ends of the camera's range: off the face the platform hangs and swings
SAMPLE = 0.25  # [m] between certified poses of a leg


@dataclass(frozen=True)
class Lattice:
    """Places (eta, s, d) on a regular grid over the interior of a bay."""

    eta: Array
    s: Array
    d: Array

    @classmethod
    def over(cls, scene: Scene, low: float, high: float, coarse: int = 1) -> Lattice:
        """The lattice over the interior stays and [low, high] along them, ``coarse`` times wider steps."""
        bay, camera = scene.bay, scene.squad.camera
        stays = len(bay.interior)
        radius = max(bay.radius(k) for k in bay.interior)
        return cls(
            np.linspace(1.0, stays, round((stays - 1) / ACROSS_STEP) + 1),
            np.linspace(low, high, max(2, round((high - low) / (ALONG_STEP * coarse)) + 1)),
            np.arange(radius + camera.stand_off[0], radius + camera.stand_off[1] + BEYOND_CAMERA, OFF_STEP * coarse),
        )

    @property
    def shape(self) -> tuple[int, int, int]:
        """Nodes across, along and off the stays."""
        return len(self.eta), len(self.s), len(self.d)

    @property
    def places(self) -> Array:
        """All nodes (n, 3), C order."""
        return np.stack(np.meshgrid(self.eta, self.s, self.d, indexing="ij"), -1).reshape(-1, 3)

    def nearest(self, place: Array, good: Flags) -> list[int]:
        """Good nodes (flat indices), nearest to a place (3,) first."""
        nodes = np.flatnonzero(good.ravel())
        offset = (self.places[nodes] - place) / np.array([ACROSS_STEP, self.s[1] - self.s[0], self.d[1] - self.d[0]])
        return [int(node) for node in nodes[np.argsort(np.sum(offset**2, axis=1), kind="stable")]]

    def held(self, scene: Scene, anchors: Array, pull: Array) -> tuple[Held, Flags]:
        """Equilibria at every node and which nodes are good, in the lattice's shape."""
        held = hold(scene, anchors, pull, self.places)
        return held, held.good.reshape(self.shape)


def visible_levels(scene: Scene, lattice: Lattice, k: int) -> Flags:
    """Levels of the lattice within the camera's range of stay ``k``, less what the platform swings."""
    near, far = scene.squad.camera.stand_off
    surface = lattice.d - scene.bay.radius(k)
    return (surface >= near + SWING - 1e-9) & (surface <= far - SWING + 1e-9)


def profile_along(room: Array, good: Flags, levels: Array, preferred: float) -> tuple[NDArray[np.int64], Flags]:
    """A level for each station: smooth, with room, near the preferred stand-off (Viterbi).

    Args:
        room: Width of the interval of tensions (stations, levels) [N].
        good: Which nodes are good (stations, levels).
        levels: Stand-offs (levels,) [m].
        preferred: Stand-off that pictures are best from [m].

    Returns:
        Level of every station (stations,) and whether it is held: stations without a good level, and stations whose
        levels cannot be reached from the one before within two steps, break the run.
    """
    stations, count = good.shape
    cost = np.where(good, 40.0 / (np.maximum(room, 0.0) + 10.0) + np.abs(levels - preferred), np.inf)
    best = np.full((stations, count), np.inf)
    back = np.full((stations, count), -1)
    best[0] = cost[0]
    for j in range(1, stations):
        if not np.isfinite(best[j - 1]).any():
            best[j] = cost[j]
            continue
        for step in range(-2, 3):
            source = np.arange(count) - step
            inside = (source >= 0) & (source < count)
            value = np.full(count, np.inf)
            value[inside] = best[j - 1][source[inside]] + cost[j][inside] + 2.0 * abs(step)
            better = value < best[j]
            best[j][better], back[j][better] = value[better], source[better]
        if not np.isfinite(best[j]).any():
            best[j], back[j] = cost[j], -1
    chosen = np.full(stations, -1)
    level = -1
    for j in range(stations - 1, -1, -1):
        if level < 0 and np.isfinite(best[j]).any():
            level = int(np.argmin(best[j]))
        chosen[j] = level
        level = int(back[j, level]) if level >= 0 else -1
    return np.maximum(chosen, 0), chosen >= 0


def runs(flags: Flags, starts: Flags) -> list[tuple[int, int]]:
    """Index ranges [first, last] over which ``flags`` holds; ``starts`` marks stations where a new run begins."""
    out: list[tuple[int, int]] = []
    begin: int | None = None
    for j, flag in enumerate(flags):
        if begin is not None and (not flag or starts[j]):
            out.append((begin, j - 1))
            begin = None
        if flag and begin is None:
            begin = j
    if begin is not None:
        out.append((begin, len(flags) - 1))
    return out


def route(lattice: Lattice, good: Flags, room: Array, start: int, end: int, spacing: float) -> list[int] | None:
    """Nodes of a short, roomy way from node ``start`` to ``end`` through good nodes; None when there is none.

    Args:
        lattice: The grid.
        good: Good nodes (across, along, off).
        room: Width of the interval of tensions at every node, same shape [N].
        start: Flat index.
        end: Flat index.
        spacing: Distance between neighbouring stays [m].
    """
    index = np.arange(good.size).reshape(good.shape)
    rows, columns, weights = [], [], []
    size = (spacing * ACROSS_STEP, float(lattice.s[1] - lattice.s[0]), float(lattice.d[1] - lattice.d[0]))
    price = 1.0 + 20.0 / (np.maximum(room, 0.0) + 10.0)
    moves = [(a, b, c) for a in (0, 1) for b in (-1, 0, 1) for c in (-2, -1, 0, 1, 2) if (a, b, c) > (0, 0, 0)]
    for move in moves:
        near = tuple(slice(max(0, -m), n - max(0, m)) for m, n in zip(move, good.shape, strict=True))
        far = tuple(slice(max(0, m), n - max(0, -m)) for m, n in zip(move, good.shape, strict=True))
        both = good[near] & good[far]
        length = float(np.sqrt(sum((m * e) ** 2 for m, e in zip(move, size, strict=True))))
        rows.append(index[near][both])
        columns.append(index[far][both])
        weights.append(length * 0.5 * (price[near][both] + price[far][both]))
    graph = coo_array(
        (np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns))), shape=(good.size, good.size)
    ).tocsr()
    _cost, back = dijkstra(graph, directed=False, indices=start, return_predecessors=True)
    if start != end and back[end] < 0:
        return None
    nodes = [end]
    while nodes[-1] != start:
        nodes.append(int(back[nodes[-1]]))
    return nodes[::-1]


def densify(scene: Scene, corners: Array) -> Array:
    """Places at most a sample apart along straight pieces between corners (n, 3) = (eta, s, d)."""
    out = [corners[:1]]
    for a, b in zip(corners[:-1], corners[1:], strict=True):
        ends = scene.bay.place(np.array([a[0], b[0]]), np.array([a[1], b[1]]), np.array([a[2], b[2]]))
        count = max(2, int(np.ceil(np.linalg.norm(ends[1] - ends[0]) / SAMPLE)))
        out.append(a + (b - a) * np.linspace(0.0, 1.0, count + 1)[1:, None])
    return np.concatenate(out)


def straighten(scene: Scene, anchors: Array, pull: Array, corners: Array) -> list[Array]:
    """Replace a lattice route by as few straight, certified pieces as it takes; each piece as places (n, 3)."""
    pieces: list[Array] = []
    first = 0
    while first < len(corners) - 1:
        last = len(corners) - 1
        while True:
            places = densify(scene, corners[[first, last]])
            if last == first + 1 or bool(hold(scene, anchors, pull, places).along.all()):
                break
            last = first + max(1, (last - first) // 2)
        pieces.append(places)
        first = last
    return pieces
