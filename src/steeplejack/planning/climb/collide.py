"""Whether the robot's bars keep clear of pipes and of what stands on them; see `solids`.

The distance to a sector is that in cylindrical coordinates, ``hypot(dz, drho, rho dtheta)`` of what a point is outside
each of the three ranges: exact where one of them is zero, and within a few percent near its edges.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.planning.climb.solids import Solids

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

SPACING = 0.002
"""Of the points of a bar that are looked at near a sector [m]."""


def meets(solids: Solids, points: Array, frames: Array, clocks: Array, bars: Array, radii: Array, air: float) -> Flags:
    """Whether any bar comes nearer than ``air`` to a solid.

    Args:
        solids: Of the run.
        points: Origins of the bars' frames, (k, 3) [m].
        frames: At clock 0, (k, 3, 3).
        clocks: By which they are turned about z, (k, c) [rad].
        bars: (k, n, 2, 3) [m].
        radii: (n,) [m].
        air: [m].

    Returns:
        (k, c).
    """
    found = np.zeros(clocks.shape, dtype=np.bool_)
    flat = np.ascontiguousarray
    meets_any(
        solids.capsules, solids.sectors, flat(points), flat(frames), flat(clocks), flat(bars), radii, air, found
    )  # fmt: skip
    return found


@njit(cache=True)
def meets_any(
    capsules: Array, sectors: Array, points: Array, frames: Array, clocks: Array, bars: Array, radii: Array,
    air: float, found: Flags,
) -> None:  # fmt: skip
    """`meets` for arrays, into (k, c)."""
    ends = np.empty((2, 3))
    for k in range(bars.shape[0]):
        for j in range(clocks.shape[1]):
            c, s = math.cos(clocks[k, j]), math.sin(clocks[k, j])
            for n in range(bars.shape[1]):
                placed(points[k], frames[k], c, s, bars[k, n], ends)
                if _near_capsule(capsules, ends, radii[n] + air) or _near_sector(sectors, ends, radii[n] + air):
                    found[k, j] = True
                    break


@njit(cache=True)
def placed(point: Array, frame: Array, c: float, s: float, bar: Array, ends: Array) -> None:
    """Ends of a bar in the world, its frame turned by a clock of cosine c and sine s."""
    for e in range(2):
        x, y = c * bar[e, 0] - s * bar[e, 1], s * bar[e, 0] + c * bar[e, 1]
        for i in range(3):
            ends[e, i] = point[i] + frame[i, 0] * x + frame[i, 1] * y + frame[i, 2] * bar[e, 2]


@njit(cache=True)
def local_ends(sector: Array, ends: Array, local: Array) -> float:
    """Ends of a bar in a sector's frame; its length."""
    length = 0.0
    for i in range(3):
        for e in range(2):
            local[e, i] = 0.0
            for j in range(3):
                local[e, i] += sector[3 + 3 * i + j] * (ends[e, j] - sector[j])
        length += (local[1, i] - local[0, i]) ** 2
    return math.sqrt(length)


@njit(cache=True)
def _near_capsule(capsules: Array, ends: Array, reach: float) -> bool:
    """Whether a segment comes within a reach of any capsule."""
    for m in range(capsules.shape[0]):
        far = reach + capsules[m, 6]
        apart, both = 0.0, 0.0
        for i in range(3):
            between = ends[0, i] + ends[1, i] - capsules[m, i] - capsules[m, 3 + i]
            apart += 0.25 * between * between
        own, other = 0.0, 0.0
        for i in range(3):
            own += (ends[1, i] - ends[0, i]) ** 2
            other += (capsules[m, 3 + i] - capsules[m, i]) ** 2
        both = 0.5 * (math.sqrt(own) + math.sqrt(other)) + far
        if apart < both * both and _squared(ends, capsules[m]) < far * far:
            return True
    return False


@njit(cache=True)
def _squared(ends: Array, capsule: Array) -> float:
    """Squared distance of two segments (Ericson, Real-Time Collision Detection, 5.1.9) [m2]."""
    a = e = f = b = c = 0.0
    for i in range(3):
        d1, d2, r = ends[1, i] - ends[0, i], capsule[3 + i] - capsule[i], ends[0, i] - capsule[i]
        a += d1 * d1
        e += d2 * d2
        f += d2 * r
        b += d1 * d2
        c += d1 * r
    below = a * e - b * b
    s = min(max((b * f - c * e) / below, 0.0), 1.0) if below > 1e-14 * a * e else 0.0
    t = (b * s + f) / e if e > 0.0 else 0.0
    if t < 0.0:
        t = 0.0
        s = min(max(-c / a, 0.0), 1.0) if a > 0.0 else 0.0
    elif t > 1.0:
        t = 1.0
        s = min(max((b - c) / a, 0.0), 1.0) if a > 0.0 else 0.0
    total = 0.0
    for i in range(3):
        one = ends[0, i] + s * (ends[1, i] - ends[0, i])
        total += (one - capsule[i] - t * (capsule[3 + i] - capsule[i])) ** 2
    return total


@njit(cache=True)
def _near_sector(sectors: Array, ends: Array, reach: float) -> bool:
    """Whether a segment comes within a reach of any sector."""
    local = np.empty((2, 3))
    for m in range(sectors.shape[0]):
        length = local_ends(sectors[m], ends, local)
        half, outer, middle, spread = sectors[m, 12], sectors[m, 13], sectors[m, 14], sectors[m, 15]
        low, high = 0.0, 1.0
        rise = local[1, 2] - local[0, 2]
        if abs(rise) > 1e-12:
            first, last = (-half - reach - local[0, 2]) / rise, (half + reach - local[0, 2]) / rise
            low, high = max(low, min(first, last)), min(high, max(first, last))
        elif abs(local[0, 2]) > half + reach:
            continue
        if low > high:
            continue
        count = int((high - low) * length / SPACING) + 2
        for k in range(count):
            t = low + (high - low) * k / (count - 1)
            x = local[0, 0] + t * (local[1, 0] - local[0, 0])
            y = local[0, 1] + t * (local[1, 1] - local[0, 1])
            rho = math.sqrt(x * x + y * y)
            out = max(rho - outer, 0.0)
            if out > reach:
                continue
            dz = max(abs(local[0, 2] + t * rise) - half, 0.0)
            beside = (math.atan2(y, x) - middle + math.pi) % (2.0 * math.pi) - math.pi
            aside = min(rho, outer) * max(abs(beside) - spread, 0.0)
            if out * out + dz * dz + aside * aside < reach * reach:
                return True
    return False
