"""Runs of the platform along the interior stays of a cell, certified as they will be flown."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from steeplejack.planning.certificate import Scene, hold
from steeplejack.planning.lattice import SAMPLE, Lattice, profile_along, runs, visible_levels

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

SMOOTHING = 5  # stations over which the stand-off is averaged, twice


def visits(
    scene: Scene,
    lattice: Lattice,
    stance: tuple[Array, Array],
    room: Array,
    good: Flags,
    wanted: Flags,
    place: Array | None,
) -> list[tuple[int, int, int, Array]]:
    """Runs (row, first, last station, places) in zigzag order from the corner nearest to the platform."""
    rows = list(range(len(scene.bay.interior)))
    up = True
    if place is not None:
        up = abs(place[1] - lattice.s[0]) <= abs(place[1] - lattice.s[-1])
        if abs(place[0] - scene.bay.interior[0]) > abs(place[0] - scene.bay.interior[-1]):
            rows.reverse()
    out: list[tuple[int, int, int, Array]] = []
    for row in rows:
        found = _stay_runs(scene, lattice, stance, room, good, wanted[row], row)
        for first, last, places in found if up else found[::-1]:
            out.append((row, first, last, places if up else places[::-1]))
        up = up != bool(found)
    return out


def _stay_runs(
    scene: Scene,
    lattice: Lattice,
    stance: tuple[Array, Array],
    room: Array,
    good: Flags,
    wanted: Flags,
    row: int,
) -> list[tuple[int, int, Array]]:
    """Certified runs (first, last station, places) along one interior stay.

    Stations are certified on the lattice; the run between them, stand-off smoothed, is certified again as it will be
    flown, and cut where that fails.
    """
    k = scene.bay.interior[row]
    node = int(np.argmin(np.abs(lattice.eta - k)))
    visible = good[node] & visible_levels(scene, lattice, k)[None, :]
    near, far = scene.squad.camera.stand_off
    preferred = scene.bay.radius(k) + near + 0.4 * (far - near)
    level, reached = profile_along(room[node], visible, lattice.d, preferred)
    jump = np.concatenate([[False], np.abs(np.diff(level)) > 2])
    out: list[tuple[int, int, Array]] = []
    for first, last in runs(reached & wanted, jump):
        out += _certified(scene, lattice, stance, float(k), first, last, level)
    return out


def _certified(
    scene: Scene,
    lattice: Lattice,
    stance: tuple[Array, Array],
    k: float,
    first: int,
    last: int,
    level: NDArray[np.int64],
) -> list[tuple[int, int, Array]]:
    """A run as it will be flown: smoothed, or as found where smoothing leaves the certified set, or its good parts."""
    if last == first:
        return []
    part = slice(first, last + 1)
    for smoothing in (SMOOTHING, 1):
        places = _path(lattice, k, part, level, smoothing)
        good = hold(scene, *stance, places).along
        if good.all():
            return [(first, last, places)]
    broken = np.flatnonzero(~good)
    cut = int(np.clip(np.searchsorted(lattice.s, places[broken[0], 1]), first + 1, last))
    halves = ((first, cut - 1), (cut, last))
    return [run for a, b in halves for run in _certified(scene, lattice, stance, k, a, b, level)]


def _path(lattice: Lattice, k: float, part: slice, level: NDArray[np.int64], smoothing: int) -> Array:
    """Places (n, 3) of a run, a sample apart, its stand-off averaged twice over ``smoothing`` stations."""
    s, raw = lattice.s[part], lattice.d[level[part]]
    off = uniform_filter1d(uniform_filter1d(raw, smoothing, mode="nearest"), smoothing, mode="nearest")
    fine = np.linspace(s[0], s[-1], max(3, int(np.ceil((s[-1] - s[0]) / SAMPLE)) + 1))
    return np.column_stack([np.full(len(fine), k), fine, np.interp(fine, s, off)])
