"""What a flown trajectory saw: metre and clock sector of the stays, from camera poses and footprint alone.

The camera sits at the platform's origin and looks along the platform's z axis. From one pose a point of a stay's
surface is seen where

- the stay's surface is within the camera's stand-off range (distance to the axis less the radius),
- the line of sight lies within the cone of view, and
- it meets the surface, from outside, at no more than the largest incidence.

Other stays in the way are not modelled: the camera's range is shorter than the distance between neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.planning.mission import Uncovered
from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Camera
from steeplejack.worksite import Stay

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Stretch = tuple[float, float]  # from, to [m] along a stay

STATION = 0.1  # [m] length of a cell along the stay
SECTOR = math.radians(15.0)  # [rad] width of a cell around it
BLUR = 0.5  # [m] a footprint may end beside the stretch whose reason it shares
UNSEEN = "not seen by the executed trajectory"


@dataclass(frozen=True)
class Seen:
    """What was seen of one interior stay: cells along the requested stretch, clock samples around it."""

    stay: str
    edges: Array  # (n + 1,) [m] borders of the cells, arc length from the lower anchorage
    clock: Array  # (m,) [rad] from 12 on top, clockwise looking up the stay
    seen: Flags  # (n, m)
    faced: Flags  # (n, m) clock samples of the faced sector
    facing: Array  # (n,) [rad] clock angle of the face's outward normal
    half_sector: float  # [rad] of the faced sector, either side of it
    asked: tuple[Stretch, ...]  # the requested stretch less end zones and obstacles

    @property
    def stations(self) -> Array:
        """Middles of the cells (n,) [m]."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])

    @property
    def covered(self) -> Flags:
        """Cells (n,) of which every sample of the faced sector was seen."""
        return np.all(self.seen | ~self.faced, axis=1)

    @property
    def weight(self) -> Array:
        """Length of every cell that was asked for (n,) [m]."""
        weight = np.zeros(len(self.edges) - 1)
        for low, high in self.asked:
            weight += np.diff(np.clip(self.edges, low, high))
        return weight

    @property
    def asked_length(self) -> float:
        """Length asked for [m]."""
        return sum(high - low for low, high in self.asked)

    @property
    def covered_length(self) -> float:
        """Length asked for and covered on the faced sector [m]."""
        return float(self.weight @ self.covered)

    @property
    def around(self) -> Array:
        """Share of the length asked for over which each clock sample was seen (m,)."""
        return self.weight @ self.seen / max(self.asked_length, 1e-12)


def observe(
    bay: Bay,
    camera: Camera,
    position: Array,
    rotation: Array,
    low: float,
    high: float,
    station: float = STATION,
    sector: float = SECTOR,
) -> tuple[Seen, ...]:
    """What camera poses saw of the bay's interior stays.

    Args:
        bay: The stays and the face they are seen from.
        camera: Footprint.
        position: Camera positions (p, 3) [m], world frame.
        rotation: Platform to world (p, 3, 3); the third column is the optical axis.
        low: Where the requested stretch begins on every stay [m].
        high: Where it ends [m].
        station: Largest length of a cell along the stay [m].
        sector: Largest width of a cell around it [rad].
    """
    view = np.ascontiguousarray(rotation[:, :, 2])
    return tuple(_observe_stay(bay, k, camera, position, view, low, high, station, sector) for k in bay.interior)


def _observe_stay(
    bay: Bay,
    k: int,
    camera: Camera,
    position: Array,
    view: Array,
    low: float,
    high: float,
    station: float,
    sector: float,
) -> Seen:
    stay, radius = bay.stays[k], bay.radius(k)
    high = max(low, min(high, stay.length))
    edges = np.linspace(low, high, max(1, math.ceil((high - low) / station - 1e-9)) + 1)
    clock = np.linspace(0.0, 2.0 * math.pi, math.ceil(2.0 * math.pi / sector - 1e-9), endpoint=False)
    s = 0.5 * (edges[1:] + edges[:-1])
    normals = _outward(stay, s, clock)
    place, distance = stay.nearest(position)
    near, far = camera.stand_off
    used = (distance - radius >= near) & (distance - radius <= far)
    # Along the stay a line of sight within the largest incidence reaches no farther than its tangent times its
    # distance at right angles to the axis, which is at most that of the far side of the surface.
    reach = (far + 2.0 * radius) * math.tan(min(camera.max_incidence, 1.5))
    place = place[used]
    seen = np.zeros((len(s), len(clock)), np.bool_)
    _mark(
        seen,
        stay.position(s)[:, None, :] + radius * normals,
        normals,
        position[used],
        view[used],
        np.searchsorted(s, place - reach),
        np.searchsorted(s, place + reach),
        math.cos(0.5 * camera.field_of_view),
        math.cos(min(camera.max_incidence, 0.5 * math.pi)),
    )
    facing = _facing(bay, k, s)
    away = np.abs((clock - facing[:, None] + math.pi) % (2.0 * math.pi) - math.pi)
    half = np.maximum(camera.faced_half_sector, away.min(axis=1, keepdims=True))
    return Seen(
        stay.id,
        edges,
        clock,
        seen,
        away <= half + 1e-9,
        facing,
        camera.faced_half_sector,
        stay.free_intervals(low, high),
    )


def _outward(stay: Stay, s: Array, clock: Array) -> Array:
    """Outward normals (n, m, 3) of a stay's surface at stations (n,) and clock angles (m,)."""
    twelve, three = stay.clock_frame(s)
    return np.cos(clock)[:, None] * twelve[:, None, :] + np.sin(clock)[:, None] * three[:, None, :]


def _facing(bay: Bay, k: int, s: Array) -> Array:
    """Clock angles (n,) [rad] of the face's outward normal at stations (n,) of stay ``k``."""
    twelve, three = bay.stays[k].clock_frame(s)
    normal = bay.normal(np.full(len(s), float(k)), s)
    return np.arctan2(np.sum(normal * three, axis=-1), np.sum(normal * twelve, axis=-1))


@njit(cache=True)
def _mark(
    seen: Flags,
    surface: Array,
    normals: Array,
    position: Array,
    view: Array,
    first: NDArray[np.int64],
    last: NDArray[np.int64],
    cosine_of_view: float,
    cosine_of_incidence: float,
) -> None:
    """Mark what each pose sees of its window of stations.

    Args:
        seen: Cells (n, m), updated.
        surface: Points of the surface (n, m, 3) [m].
        normals: Outward normals there (n, m, 3).
        position: Camera positions (p, 3) [m].
        view: Optical axes (p, 3).
        first: First station of each window (p,).
        last: One past its last station (p,).
        cosine_of_view: Of half the cone of view.
        cosine_of_incidence: Of the largest incidence.
    """
    for p in range(position.shape[0]):
        for i in range(first[p], last[p]):
            for j in range(surface.shape[1]):
                if seen[i, j]:
                    continue
                x = position[p, 0] - surface[i, j, 0]
                y = position[p, 1] - surface[i, j, 1]
                z = position[p, 2] - surface[i, j, 2]
                length = math.sqrt(x * x + y * y + z * z)
                ahead = -(x * view[p, 0] + y * view[p, 1] + z * view[p, 2])
                facing = x * normals[i, j, 0] + y * normals[i, j, 1] + z * normals[i, j, 2]
                seen[i, j] = (
                    facing > 0.0 and facing >= cosine_of_incidence * length and ahead >= cosine_of_view * length
                )


def coverage_fraction(seen: Sequence[Seen]) -> float:
    """Length covered on the faced sector over length asked for; 0 where nothing was asked for."""
    asked = sum(stay.asked_length for stay in seen)
    return sum(stay.covered_length for stay in seen) / asked if asked > 0.0 else 0.0


def clock_coverage(seen: Sequence[Seen]) -> float:
    """Share of all clock sectors seen over the length asked for; one face never sees all round."""
    asked = sum(stay.asked_length for stay in seen)
    return sum(float(np.mean(stay.around)) * stay.asked_length for stay in seen) / asked if asked > 0.0 else 0.0


def not_covered(seen: Sequence[Seen], reasons: Sequence[Uncovered]) -> tuple[Uncovered, ...]:
    """Stretches not covered on the faced sector, each with a reason.

    Args:
        seen: From :func:`observe`.
        reasons: Stretches whose reason is known; in doubt the nearest within ``BLUR``, of equals the first.
    """
    return tuple(gap for stay in seen for gap in _gaps(stay, [r for r in reasons if r.stay == stay.stay]))


def _gaps(stay: Seen, reasons: Sequence[Uncovered]) -> list[Uncovered]:
    why = [None if good else _reason(s, reasons) for s, good in zip(stay.stations, stay.covered, strict=True)]
    out: list[Uncovered] = []
    for low, high in stay.asked:
        for i, text in enumerate(why):
            start, end = max(float(stay.edges[i]), low), min(float(stay.edges[i + 1]), high)
            if text is None or end - start < 1e-9:
                continue
            last = out[-1] if out else None
            if last and last.why == text and abs(last.to_m - start) < 1e-9:
                out[-1] = Uncovered(stay.stay, last.from_m, end, text)
            else:
                out.append(Uncovered(stay.stay, start, end, text))
    return out


def _reason(s: float, reasons: Sequence[Uncovered]) -> str:
    away = [max(reason.from_m - s, s - reason.to_m, 0.0) for reason in reasons]
    return reasons[int(np.argmin(away))].why if away and min(away) <= BLUR else UNSEEN
