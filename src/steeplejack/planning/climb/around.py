"""At which clocks all round a straight pipe the robot's bars meet something."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.planning.climb.collide import SPACING, local_ends, meets_any, placed
from steeplejack.planning.climb.solids import Solids

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

SAME_AXIS = 1e-9
"""How far frame and sector may miss one axis to count as on one straight, [m2] and [1]."""


def blocked_clocks(
    solids: Solids, points: Array, frames: Array, bars: Array, radii: Array, air: float, count: int
) -> Flags:
    """`meets` at equal steps of the clock all round, for frames on a straight pipe: (k, count).

    A sector about the frames' own axis keeps its distances when they turn, so that each point of a bar near it blocks
    one interval of clocks. The frames' own pipe, which no turn brings nearer, is left out.
    """
    found = np.zeros((len(points), count), dtype=np.bool_)
    flat = np.ascontiguousarray
    _blocked(solids.capsules, solids.sectors, flat(points), flat(frames), flat(bars), radii, air, found)
    return found


@njit(cache=True)
def _blocked(
    capsules: Array, sectors: Array, points: Array, frames: Array, bars: Array, radii: Array, air: float, found: Flags
) -> None:
    count = found.shape[1]
    ends, clocks, turned = np.empty((2, 3)), np.empty((1, 1)), np.zeros((1, 1), dtype=np.bool_)
    others, near = np.empty(sectors.shape[0], dtype=np.bool_), np.empty(capsules.shape[0], dtype=np.bool_)
    for k in range(bars.shape[0]):
        size, some = _extent(bars[k], radii) + air, False
        for m in range(sectors.shape[0]):
            along, aside, lean = _off_axis(points[k], frames[k], sectors[m, 0:3], sectors[m, 9:12])
            own = lean < SAME_AXIS and aside < SAME_AXIS
            others[m] = not own and math.sqrt(along * along + aside) < size + sectors[m, 12] + sectors[m, 13]
            some = some or others[m]
            if own:
                for n in range(bars.shape[1]):
                    placed(points[k], frames[k], 1.0, 0.0, bars[k, n], ends)
                    _shade(sectors[m], ends, radii[n] + air, found[k])
        for m in range(capsules.shape[0]):
            near[m] = _may_meet(points[k], frames[k], capsules[m], size)
            some = some or near[m]
        if not some:
            continue
        left, apart = capsules[near], sectors[others]
        for j in range(count):
            if not found[k, j]:
                clocks[0, 0], turned[0, 0] = 2.0 * math.pi * j / count, False
                meets_any(left, apart, points[k:], frames[k:], clocks, bars[k : k + 1], radii, air, turned)
                found[k, j] = turned[0, 0]


@njit(cache=True)
def _extent(bars: Array, radii: Array) -> float:
    """How far bars go from the origin of their frame."""
    size = 0.0
    for n in range(bars.shape[0]):
        for e in range(2):
            x, y, z = bars[n, e, 0], bars[n, e, 1], bars[n, e, 2]
            size = max(size, math.sqrt(x * x + y * y + z * z) + radii[n])
    return size


@njit(cache=True)
def _off_axis(point: Array, frame: Array, place: Array, way: Array) -> tuple[float, float, float]:
    """Distance of a point along a line, the square of that beside it, and how little the frame's z is along it."""
    along = total = cosine = 0.0
    for i in range(3):
        offset = point[i] - place[i]
        along += offset * way[i]
        total += offset * offset
        cosine += frame[i, 2] * way[i]
    return along, total - along * along, 1.0 - abs(cosine)


@njit(cache=True)
def _may_meet(point: Array, frame: Array, capsule: Array, size: float) -> bool:
    """Whether a capsule is near enough, and not about the frame's own axis."""
    way, length = np.empty(3), 0.0
    for i in range(3):
        way[i] = capsule[3 + i] - capsule[i]
        length += way[i] * way[i]
    length = math.sqrt(length)
    for i in range(3):
        way[i] /= length
    along, aside, lean = _off_axis(point, frame, capsule[0:3], way)
    if lean < SAME_AXIS and aside < SAME_AXIS:
        return False
    beyond = max(-along, along - length, 0.0)
    return math.sqrt(max(aside, 0.0) + beyond * beyond) < size + capsule[6]


@njit(cache=True)
def _shade(sector: Array, ends: Array, reach: float, found: Flags) -> None:
    """Mark the clocks by which a bar, turned about the sector's axis, comes within a reach of it."""
    count = found.shape[0]
    half, outer, middle, spread = sector[12], sector[13], sector[14], sector[15]
    local = np.empty((2, 3))
    steps = int(local_ends(sector, ends, local) / SPACING) + 2
    for step in range(steps):
        t = step / (steps - 1.0)
        dz = max(abs(local[0, 2] + t * (local[1, 2] - local[0, 2])) - half, 0.0)
        if dz >= reach:
            continue
        x = local[0, 0] + t * (local[1, 0] - local[0, 0])
        y = local[0, 1] + t * (local[1, 1] - local[0, 1])
        rho = math.sqrt(x * x + y * y)
        out = max(rho - outer, 0.0)
        room = reach * reach - out * out - dz * dz
        if room <= 0.0:
            continue
        arc = min(spread + math.sqrt(room) / max(min(rho, outer), 1e-9), math.pi) * count / (2.0 * math.pi)
        centre = (middle - math.atan2(y, x)) * count / (2.0 * math.pi)
        for cell in range(math.ceil(centre - arc), math.floor(centre + arc) + 1):
            found[cell % count] = True
