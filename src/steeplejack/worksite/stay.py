"""A stay cable: two anchorages, what is known about it, and what stands in the way along it.

A place on a stay is (stay id, s, clock): s is the arc length [m] from the lower anchorage and the clock has 12 on top
and runs clockwise looking up the stay.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from steeplejack.worksite.catenary import Catenary, hang
from steeplejack.worksite.chord import Array, Chord, Point


@dataclass(frozen=True)
class Interval:
    """A stretch of a stay that is not plain sheath.

    Args:
        start: Where it begins [m], arc length from the lower anchorage.
        end: Where it ends [m].
        kind: A zone at an anchorage that nobody inspects from the stay, or something standing on the stay.
        height: How far it stands out from the sheath [m]; ``None`` where unknown.
        note: What it is, with its source or the word "estimate".
    """

    start: float
    end: float
    kind: Literal["end zone", "obstacle"]
    height: float | None = None
    note: str = ""


@dataclass(frozen=True)
class Stay:
    """A stay cable; an elastic catenary where weight and tension are known, else its chord.

    Args:
        id: Name on the drawings.
        tower: Tower it hangs from.
        plane: Cable plane, left or right of the deck.
        side: Main span or side span.
        index: Place along its fan, counted from the tower.
        lower: Lower (deck) anchorage [m], world frame: x along the bridge, y transverse, z up.
        upper: Upper (tower) anchorage [m], world frame.
        diameter: Outside diameter [m].
        weight: Weight per metre of unstressed length [N/m].
        tension: Tension where the tangent is parallel to the chord [N].
        axial_stiffness: EA [N]; ``None`` for an inextensible stay.
        intervals: End zones and obstacles.
        chord_only: Whether to take the chord although the catenary is known.
    """

    id: str
    tower: str
    plane: Literal["L", "R"]
    side: Literal["main", "side"]
    index: int
    lower: Point
    upper: Point
    diameter: float | None = None
    weight: float | None = None
    tension: float | None = None
    axial_stiffness: float | None = None
    intervals: tuple[Interval, ...] = ()
    chord_only: bool = False

    @cached_property
    def curve(self) -> Catenary | Chord:
        """The stay's axis."""
        if self.chord_only or self.weight is None or self.tension is None:
            return Chord(self.lower, self.upper)
        return hang(self.lower, self.upper, self.weight, self.tension, self.axial_stiffness)

    @property
    def fan(self) -> str:
        """Name of the fan it belongs to, ``T{tower}{plane}-{side}``."""
        return f"T{self.tower}{self.plane}-{self.side}"

    @property
    def length(self) -> float:
        """Arc length between the anchorages [m]."""
        return self.curve.length

    @property
    def radius(self) -> float | None:
        """Outside radius [m]; ``None`` where the diameter is unknown."""
        return None if self.diameter is None else 0.5 * self.diameter

    @property
    def inclination(self) -> float:
        """Angle of the chord above the horizontal [rad]."""
        x, y, z = np.subtract(self.upper, self.lower)
        return float(np.arctan2(z, np.hypot(x, y)))

    @property
    def sag(self) -> float:
        """Largest distance of the axis from its chord, close to mid-span and at right angles to the chord [m]."""
        return self.curve.sag

    @property
    def unknown(self) -> tuple[str, ...]:
        """Names of the data this stay lacks; on a chord that was asked for, nobody misses weight and tension."""
        needed = ("diameter",) if self.chord_only else ("diameter", "weight", "tension")
        return tuple(name for name in needed if getattr(self, name) is None)

    def position(self, s: ArrayLike) -> Array:
        """Points (..., 3) [m] of the axis at arc length ``s`` (...) [m] from the lower anchorage."""
        return self.curve.position(s)

    def tangent(self, s: ArrayLike) -> Array:
        """Unit tangents (..., 3) [1] of the axis, from lower to upper, at arc length ``s`` (...) [m]."""
        return self.curve.tangent(s)

    def nearest(self, p: ArrayLike) -> tuple[Array, Array]:
        """Arc length (...) [m] of, and distance (...) [m] to, the axis point nearest to points ``p`` (..., 3) [m]."""
        return self.curve.nearest(p)

    def clock_frame(self, s: ArrayLike) -> tuple[Array, Array]:
        """Directions of 12 and 3 o'clock, at right angles to the axis.

        12 is the direction that points up most; on a vertical stay, where none does, it is -x. Looking up the stay the
        clock runs clockwise, so ``tangent x twelve = three`` and the direction at clock angle c is
        ``cos(c) twelve + sin(c) three``.

        Args:
            s: Arc length (...) [m] from the lower anchorage.

        Returns:
            Unit vectors (..., 3) [1] towards 12 and towards 3 o'clock, world frame.
        """
        tangent, heading = self.curve.tangent(s), self.curve.heading
        twelve = -tangent[..., 2:] * heading
        twelve[..., 2] = tangent @ heading
        three = np.array([heading[1], -heading[0], 0.0])
        return twelve, np.broadcast_to(three, twelve.shape).copy()

    def free_intervals(self, start: float, end: float, passable: float = 0.0) -> tuple[tuple[float, float], ...]:
        """Parts of a stretch that are neither end zone nor obstacle.

        Args:
            start: Where the stretch begins [m], arc length from the lower anchorage.
            end: Where it ends [m].
            passable: Height [m] up to which an obstacle does not count; one of unknown height always does.

        Returns:
            (start, end) [m] of each free part, in order; the stretch is cut at the anchorages.
        """
        free: list[tuple[float, float]] = []
        start, end = max(start, 0.0), min(end, self.length)
        for block in sorted(self.intervals, key=lambda interval: interval.start):
            if block.kind == "obstacle" and block.height is not None and block.height <= passable:
                continue
            if start < min(block.start, end):
                free.append((start, min(block.start, end)))
            start = max(start, block.end)
        return (*free, (start, end)) if start < end else tuple(free)

    def as_chord(self) -> Stay:
        """The same stay on its chord; its intervals shrink with the length."""
        straight = replace(self, chord_only=True)
        ratio = straight.length / self.length
        moved = tuple(replace(i, start=i.start * ratio, end=i.end * ratio) for i in self.intervals)
        return replace(straight, intervals=moved)


def with_end_zones(stay: Stay, lower: float, upper: float, note: str) -> Stay:
    """The stay with an end zone at each anchorage in place of any it had.

    Args:
        stay: A stay.
        lower: Length of the zone at the lower anchorage [m]; at most half the stay counts.
        upper: Length of the zone at the upper anchorage [m]; at most half the stay counts.
        note: Why, with its source or the word "estimate".

    Returns:
        A new stay.
    """
    length = stay.length
    zones = (
        Interval(0.0, min(lower, 0.5 * length), "end zone", note=note),
        Interval(length - min(upper, 0.5 * length), length, "end zone", note=note),
    )
    return replace(stay, intervals=(*zones, *(i for i in stay.intervals if i.kind != "end zone")))
