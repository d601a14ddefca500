"""A worksite as a TOML file: a bridge (its schedule or its stays, and what is assumed about them) or a planar site.

Unknown keys are refused and named by their path. SI throughout. Example of a bridge::

    kind = "bridge"
    name = "my-bridge"
    description = "12 stays beside the road"
    source = "drawing 17-B"
    schedule = "stays.csv"              # beside this file; or [[stays]] tables

    [assumed]                           # for stays the schedule leaves open; each value with its source
    diameter = 0.120                    # [m], or diameter_range = [shortest stay, longest stay]
    mass_per_metre = 60.0               # [kg/m]
    tension_per_mass = 5.96e4           # [m2/s2] T / m, or tension [N]
    [assumed.source]
    diameter = "drawing"
    mass_per_metre = "estimate"
    tension_per_mass = "measured frequency"

    [[obstacles]]
    stay = "T1L-M05"
    start = 40.0                        # [m] arc length from the lower anchorage
    end = 40.6
    height = 0.02                       # [m], left out where unknown
    note = "damper collar, as-built record"
"""

from __future__ import annotations

from typing import Annotated, Literal, cast

import msgspec

from steeplejack.files import decode_toml
from steeplejack.worksite.chord import Point

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NonNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Text = Annotated[str, msgspec.Meta(min_length=1)]


class StayEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One stay written out in the file."""

    id: Text
    tower: Annotated[str, msgspec.Meta(pattern="^[0-9A-Za-z]+$")]
    plane: Literal["L", "R"]
    side: Literal["main", "side"]
    index: Annotated[int, msgspec.Meta(ge=0)]
    lower: Point
    upper: Point
    diameter: Positive | None = None
    mass_per_metre: Positive | None = None
    tension: Positive | None = None
    area: Positive | None = None


class Assumed(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Values for the stays that lack them, each with its source or the word "estimate"."""

    source: dict[str, Text]
    diameter: Positive | None = None
    diameter_range: tuple[Positive, Positive] | None = None
    mass_per_metre: Positive | None = None
    tension: Positive | None = None
    tension_per_mass: Positive | None = None

    def __post_init__(self) -> None:
        """Refuse a value without a source, a source without a value and two values for one thing."""
        given = {name for name in self.__struct_fields__ if name != "source" and getattr(self, name) is not None}
        for name in sorted(given ^ set(self.source)):
            raise ValueError(f"`{name}` needs both a value and an entry under `source`")
        for one, other in (("diameter", "diameter_range"), ("tension", "tension_per_mass")):
            if {one, other} <= given:
                raise ValueError(f"`{one}` and `{other}` exclude each other")


class EndZones(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Lengths at both anchorages that nobody inspects from the stay [m]."""

    lower: NonNegative
    upper: NonNegative
    source: Text


class Obstacle(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Something standing on a stay, between two arc lengths from the lower anchorage [m]."""

    stay: Text
    start: NonNegative
    end: NonNegative
    note: Text
    height: Positive | None = None


class BridgeFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="kind", tag="bridge"):
    """A bridge: a schedule beside the file, or stays written out."""

    name: Text
    description: Text
    source: Text
    notes: tuple[Text, ...] = ()
    schedule: Text | None = None
    stays: tuple[StayEntry, ...] = ()
    assumed: Assumed | None = None
    end_zones: EndZones | None = None
    obstacles: tuple[Obstacle, ...] = ()

    def __post_init__(self) -> None:
        """Ask for the stays exactly once."""
        if (self.schedule is None) == (not self.stays):
            raise ValueError("either `schedule` or `stays` is needed, not both")


class Line(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A straight stay y = slope x + intercept of a planar site."""

    id: Text
    slope: float
    intercept: float
    source: Text


class PlanarFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="kind", tag="planar"):
    """A planar site: four anchors [m] and lines."""

    name: Text
    description: Text
    source: Text
    anchors: tuple[tuple[float, float], tuple[float, float], tuple[float, float], tuple[float, float]]
    stays: tuple[Line, ...]
    notes: tuple[Text, ...] = ()


def decode_site(content: bytes, where: str) -> BridgeFile | PlanarFile:
    """Decode a worksite file.

    Args:
        content: Its bytes.
        where: Its name, for messages.

    Returns:
        What it says, checked field by field.

    Raises:
        InputError: Not TOML, or a field that cannot be used; the message gives its path.
    """
    kinds = cast("type[BridgeFile | PlanarFile]", BridgeFile | PlanarFile)
    return decode_toml(content, kinds, where, 'kind = "bridge" or "planar" and the fields of a built-in worksite file')
