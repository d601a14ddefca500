"""A bridge as a set of stays in fans, and the leaning plane of a fan."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from steeplejack.errors import InputError
from steeplejack.worksite.chord import Array, Point, heading
from steeplejack.worksite.stay import Stay

UPRIGHT = math.radians(0.5)  # [rad] lean below which a plane counts as vertical and has no under face
GRAVITY: Point = (0.0, 0.0, -9.81)  # [m/s2] the value squad.md computes its references with


def plane_normal(stays: Sequence[Stay]) -> Array:
    """Unit normal of the plane that fits the anchorages of some stays best, least squares; its sign is arbitrary.

    Args:
        stays: At least one stay; a single one stands in its vertical plane.

    Returns:
        Unit vector (3,) [1], world frame.
    """
    if len(stays) == 1:
        along = heading(stays[0].lower, stays[0].upper)
        return np.array([-along[1], along[0], 0.0])
    points = np.array([anchorage for stay in stays for anchorage in (stay.lower, stay.upper)])
    return np.linalg.svd(points - points.mean(axis=0))[2][2]


def lean(stays: Sequence[Stay]) -> float:
    """Angle between the best-fit plane of some stays and the vertical [rad], 0 to pi/2."""
    return math.asin(min(1.0, abs(float(plane_normal(stays)[2]))))


def under_normal(stays: Sequence[Stay], centreline_y: float = 0.0) -> Array:
    """Outward unit normal of the under face of the best-fit plane of some stays.

    The under face is the one whose outward normal points down. A plane vertical to within 0.5 deg has none: there the
    normal points away from the bridge's centreline, and towards +y (+x in a transverse plane) where that decides
    nothing.

    Args:
        stays: At least one stay.
        centreline_y: Transverse place of the bridge's centreline [m].

    Returns:
        Unit vector (3,) [1], world frame.
    """
    normal = plane_normal(stays)
    if lean(stays) > UPRIGHT:
        return -math.copysign(1.0, normal[2]) * normal
    outward = float(np.mean([stay.lower[1] for stay in stays])) - centreline_y
    sense = math.copysign(1.0, outward) if abs(outward) > 1e-6 else 1.0
    pointer = normal[1] * sense if abs(normal[1]) > 1e-6 else normal[0]
    return math.copysign(1.0, pointer) * normal


@dataclass(frozen=True)
class Fan:
    """The stays of one tower, plane and side, in the order of their index.

    Args:
        id: ``T{tower}{plane}-{side}``, such as ``T1L-main``.
        stays: Its stays by rising index.
        centreline_y: Transverse place of the bridge's centreline at this tower [m].
    """

    id: str
    stays: tuple[Stay, ...]
    centreline_y: float = 0.0

    def between(self, first: int, last: int) -> tuple[Stay, ...]:
        """Stays with index ``first`` to ``last``, both included.

        Raises:
            InputError: An index the fan does not have, or the wrong order.
        """
        indices = [stay.index for stay in self.stays]
        if first > last or first not in indices or last not in indices:
            valid = f"two indices of {indices[0]} to {indices[-1]}, the smaller one first"
            raise InputError(f"fan {self.id}", f"no stays {first}:{last}", valid)
        return tuple(stay for stay in self.stays if first <= stay.index <= last)

    @cached_property
    def lean(self) -> float:
        """Angle of the fan's best-fit plane from the vertical [rad]."""
        return lean(self.stays)

    @cached_property
    def under_normal(self) -> Array:
        """Outward unit normal (3,) [1] of the fan's under face; see :func:`under_normal`."""
        return under_normal(self.stays, self.centreline_y)


@dataclass(frozen=True)
class Bridge:
    """A cable-stayed bridge, as far as climbing it goes.

    Args:
        name: Its name.
        stays: All stays, each id and each place in a fan once.
        source: Where the data come from.
        notes: What is estimated, reconstructed or left out.
        gravity: Gravitational acceleration [m/s2], world frame.
    """

    name: str
    stays: tuple[Stay, ...]
    source: str
    notes: tuple[str, ...] = ()
    gravity: Point = GRAVITY

    @cached_property
    def fans(self) -> dict[str, Fan]:
        """Fans by id, in the order of the schedule."""
        groups: dict[str, list[Stay]] = {}
        ends: dict[str, list[float]] = {}
        for stay in self.stays:
            groups.setdefault(stay.fan, []).append(stay)
            ends.setdefault(stay.tower, []).append(stay.lower[1])
        return {
            name: Fan(name, tuple(sorted(group, key=lambda s: s.index)), float(np.mean(ends[group[0].tower])))
            for name, group in groups.items()
        }

    def as_chords(self) -> Bridge:
        """The same bridge with every stay on its chord."""
        return replace(self, stays=tuple(stay.as_chord() for stay in self.stays))

    def fan(self, id: str) -> Fan:
        """The fan called ``id``.

        Raises:
            InputError: No such fan; the message lists those there are.
        """
        if id not in self.fans:
            raise InputError(f"worksite {self.name}", f"no fan {id}", f"one of {', '.join(self.fans)}")
        return self.fans[id]

    def stay(self, id: str) -> Stay:
        """The stay called ``id``.

        Raises:
            InputError: No such stay; the message says what its names look like.
        """
        for stay in self.stays:
            if stay.id == id:
                return stay
        first, last = self.stays[0].id, self.stays[-1].id
        raise InputError(f"worksite {self.name}", f"no stay {id}", f"one of its {len(self.stays)}, {first} to {last}")
