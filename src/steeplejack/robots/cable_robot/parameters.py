"""A cable robot as data: one TOML file decoded once into frozen structs, SI, every value with its source.

Each table of the file carries a second table ``source`` with the same keys. A value without a source, an unknown key,
points of the wrong dimension, a negative mass or a tension window upside down is refused with the path of the field.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import msgspec

Point = tuple[float, ...]
Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NonNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Dimension = Literal["planar", "spatial"]

AXES: dict[Dimension, int] = {"planar": 2, "spatial": 3}
"""Coordinates of a point."""

SHORTEST_AXIS = 1e-9
"""Length of a direction below which it is none [1]."""


class Sourced(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of values, each with its source or the word "estimate"."""

    source: dict[str, str]

    def __post_init__(self) -> None:
        """Refuse a value without a source and numbers that are not finite (a greatest tension may be infinite)."""
        names = {name for name in self.__struct_fields__ if name != "source" and getattr(self, name) is not None}
        for name in sorted(names ^ set(self.source)):
            raise ValueError(f"`{name}` needs both a value and an entry under `source`")
        for name, text in self.source.items():
            _need_line(f"source.{name}", text)
        for name in sorted(names):
            for number in _numbers(getattr(self, name)):
                if math.isnan(number) or (math.isinf(number) and name != "tension_max"):
                    raise ValueError(f"`{name}` has an entry that is not a finite number")


class Platform(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Rigid platform; its frame is the one the attachments are given in.

    Attributes:
        mass: [kg].
        inertia: About the centre of mass, platform axes; a number for planar robots, 3x3 for spatial ones [kg m2].
        centre_of_mass: In the platform frame [m].
    """

    mass: Positive
    inertia: Positive | tuple[Point, ...]
    centre_of_mass: Point


class Cables(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Cables 1..m; a number stands for all of them.

    Attributes:
        anchors: Where cables leave the world [m].
        attachments: Where they meet the platform, platform frame [m].
        tension_min: [N].
        tension_max: [N]; may be infinite.
        axial_stiffness: EA of the rope [N].
    """

    anchors: Annotated[tuple[Point, ...], msgspec.Meta(min_length=1)]
    attachments: Annotated[tuple[Point, ...], msgspec.Meta(min_length=1)]
    tension_min: NonNegative | tuple[NonNegative, ...]
    tension_max: Positive | tuple[Positive, ...]
    axial_stiffness: Positive | tuple[Positive, ...] | None = None


class Pulleys(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Swivelling pulleys at the anchors; a number or a single axis stands for all of them.

    Attributes:
        radius: [m]; 0 is none.
        axis: Way the cable travels where it reaches the pulley, the axis the pulley swivels about; any length but zero.
    """

    radius: NonNegative | tuple[NonNegative, ...]
    axis: tuple[Point, ...]


class Parameters(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The whole robot."""

    name: str
    description: str
    dimension: Dimension
    platform: Platform
    cables: Cables
    pulleys: Pulleys | None = None

    def __post_init__(self) -> None:
        """Refuse parts that do not fit each other."""
        for name in ("name", "description"):
            _need_line(name, getattr(self, name))
        count, axes = len(self.cables.anchors), AXES[self.dimension]
        for name in ("anchors", "attachments"):
            _need_points(f"cables.{name}", getattr(self.cables, name), count, axes)
        for name in ("tension_min", "tension_max", "axial_stiffness"):
            _need_count(f"cables.{name}", getattr(self.cables, name), count)
        _need_points("platform.centre_of_mass", (self.platform.centre_of_mass,), 1, axes)
        _need_windows(self.cables, count)
        _need_inertia(self.platform, self.dimension)
        if self.pulleys is not None:
            _need_count("pulleys.radius", self.pulleys.radius, count)
            _need_points("pulleys.axis", self.pulleys.axis, 1 if len(self.pulleys.axis) == 1 else count, axes)
            if any(math.hypot(*axis) < SHORTEST_AXIS for axis in self.pulleys.axis):
                raise ValueError("`pulleys.axis` has a direction without length")


def _numbers(value: object) -> tuple[float, ...]:
    """All numbers in a number or in nested tuples of numbers."""
    if isinstance(value, tuple):
        return tuple(number for part in value for number in _numbers(part))  # pyright: ignore[reportUnknownVariableType]
    return (value,) if isinstance(value, float) else ()


def _need_line(name: str, text: str) -> None:
    if not text.strip() or len(text.splitlines()) > 1:
        raise ValueError(f"`{name}` is not one line of text")


def _need_points(name: str, points: tuple[Point, ...], count: int, axes: int) -> None:
    if len(points) != count:
        raise ValueError(f"`{name}` has {len(points)} entries for {count} cables")
    for index, point in enumerate(points):
        if len(point) != axes:
            raise ValueError(f"`{name}`, entry {index + 1}, has {len(point)} coordinates and needs {axes}")


def _need_count(name: str, values: float | tuple[float, ...] | None, count: int) -> None:
    if isinstance(values, tuple) and len(values) != count:
        raise ValueError(f"`{name}` has {len(values)} entries for {count} cables")


def _need_windows(cables: Cables, count: int) -> None:
    lows, highs = (v if isinstance(v, tuple) else (v,) * count for v in (cables.tension_min, cables.tension_max))
    for index, (low, high) in enumerate(zip(lows, highs, strict=True)):
        if not low < high:
            raise ValueError(f"tension window [{low}, {high}] of cable {index + 1} is upside down or empty")


def _need_inertia(platform: Platform, dimension: Dimension) -> None:
    inertia = platform.inertia
    if dimension == "planar":
        if isinstance(inertia, tuple):
            raise ValueError("`platform.inertia` of a planar robot is one number")
        return
    if not isinstance(inertia, tuple) or [len(row) for row in inertia] != [3, 3, 3]:
        raise ValueError("`platform.inertia` of a spatial robot needs 3 x 3 numbers")
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = inertia
    if (xy, xz, yz) != (yx, zx, zy):
        raise ValueError("`platform.inertia` is not symmetric")
    volume = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    if not (xx > 0.0 and xx * yy > xy * xy and volume > 0.0):
        raise ValueError("`platform.inertia` is not positive definite")
