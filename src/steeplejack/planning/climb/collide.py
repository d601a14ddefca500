"""Whether the robot's bars keep clear of pipes and of what stands on them.

Pipes are capsules: one to a straight, chords with the sagitta added to their radius to a bend. Obstacles are sectors of
a cylinder about their pipe's axis: up to a radius, between two places and two clocks. The distance to a sector is that
in cylindrical coordinates, ``hypot(dz, drho, rho dtheta)`` of what a point is outside each of the three ranges: exact
where one of them is zero, and within a few percent near its edges.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.worksite.pipe_line import Part
from steeplejack.worksite.pipe_run import PipeObstacle, PipeRun

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

AIR = 0.003
"""Least distance kept between bars and what they pass when a climb is planned [m]."""
SAGITTA = 2e-4
"""By how much the chords of a bend may leave its arc [m]."""
SAME_AXIS = 1e-9
"""How far frame and sector may miss one axis to count as on one straight, [m2] and [1]."""
SPACING = 0.002
"""Of the points of a bar that are looked at near a sector [m]."""


@dataclass(frozen=True)
class Solids:
    """What the bars must not meet.

    Attributes:
        capsules: Both ends and radius, (m, 7) [m].
        sectors: Middle (3), axes x, y, z (9), half length, outer radius, middle and half of the clock,
            (n, 16) [m, rad].
    """

    capsules: Array
    sectors: Array


def obstacles_of(run: PipeRun) -> Solids:
    """All pipes and obstacles of a run."""
    capsules = [capsule for pipe in run.pipes for part in pipe.parts for capsule in _chords(part)]
    sectors = [_sector(run, one) for one in run.obstacles]
    return Solids(np.array(capsules).reshape(-1, 7), np.array(sectors).reshape(-1, 16))


def _chords(part: Part) -> list[Array]:
    count, extra = 1, 0.0
    if not part.straight:
        count = max(1, math.ceil(part.length / (2.0 * math.sqrt(2.0 * part.radius * SAGITTA))))
        extra = SAGITTA
    points, _frames = part.at(part.start + np.linspace(0.0, part.length, count + 1))
    size = [0.5 * part.diameter + extra]
    return [np.concatenate((a, b, size)) for a, b in zip(points[:-1], points[1:], strict=True)]


def _sector(run: PipeRun, one: PipeObstacle) -> Array:
    middle = 0.5 * (one.start + one.end)
    point, frame = run.centre_line(middle, one.pipe)
    first, last = one.clock if one.clock is not None else (-math.pi, math.pi)
    reach = float(run.radius(middle, one.pipe)) + one.height
    tail = [0.5 * (one.end - one.start), reach, 0.5 * (first + last), 0.5 * (last - first)]
    return np.concatenate((point, frame.T.ravel(), tail))


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
    _meets(
        solids.capsules, solids.sectors, flat(points), flat(frames), flat(clocks), flat(bars), radii, air, found
    )  # fmt: skip
    return found


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
                    _placed(points[k], frames[k], 1.0, 0.0, bars[k, n], ends)
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
                _meets(left, apart, points[k:], frames[k:], clocks, bars[k : k + 1], radii, air, turned)
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
def _placed(point: Array, frame: Array, c: float, s: float, bar: Array, ends: Array) -> None:
    """Ends of a bar in the world, its frame turned by a clock of cosine c and sine s."""
    for e in range(2):
        x, y = c * bar[e, 0] - s * bar[e, 1], s * bar[e, 0] + c * bar[e, 1]
        for i in range(3):
            ends[e, i] = point[i] + frame[i, 0] * x + frame[i, 1] * y + frame[i, 2] * bar[e, 2]


@njit(cache=True)
def _local(sector: Array, ends: Array, local: Array) -> float:
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
def _shade(sector: Array, ends: Array, reach: float, found: Flags) -> None:
    """Mark the clocks by which a bar, turned about the sector's axis, comes within a reach of it."""
    count = found.shape[0]
    half, outer, middle, spread = sector[12], sector[13], sector[14], sector[15]
    local = np.empty((2, 3))
    steps = int(_local(sector, ends, local) / SPACING) + 2
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


@njit(cache=True)
def _meets(
    capsules: Array, sectors: Array, points: Array, frames: Array, clocks: Array, bars: Array, radii: Array,
    air: float, found: Flags,
) -> None:  # fmt: skip
    ends = np.empty((2, 3))
    for k in range(bars.shape[0]):
        for j in range(clocks.shape[1]):
            c, s = math.cos(clocks[k, j]), math.sin(clocks[k, j])
            for n in range(bars.shape[1]):
                _placed(points[k], frames[k], c, s, bars[k, n], ends)
                if _near_capsule(capsules, ends, radii[n] + air) or _near_sector(sectors, ends, radii[n] + air):
                    found[k, j] = True
                    break


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
        length = _local(sectors[m], ends, local)
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
