"""A run of pipes as a TOML file: a main pipe of straights and bends, what stands on it, and pipes that cross it.

SI but for angles, which are in degrees and say so. Example::

    kind = "pipes"
    name = "riser"
    description = "a vertical pipe with a bend"
    source = "drawing 4-A"
    start = { s = 0.05, clock_deg = 0.0 }    # where the lower gripper's middle begins [m]
    goal = { s = 1.05 }                      # how far it has to come; pipe = "..." if on another one

    [main]
    diameter = 0.060
    point = [0.0, 0.0, 0.0]                  # where it begins
    direction = [0.0, 0.0, 1.0]
    [[main.parts]]
    kind = "straight"
    length = 0.5
    [[main.parts]]
    kind = "bend"
    radius = 0.3                             # [m] of the centre line
    angle_deg = 90.0
    toward_deg = 0.0                         # clock of the bend's centre
    diameter = 0.055                         # from here on, where it changes

    [[obstacles]]
    pipe = "main"
    start = 0.2
    end = 0.21
    height = 0.012                           # [m] above the pipe
    clock_deg = [-30.0, 30.0]                # left out: all round
    note = "weld-on lug"

    [[crossings]]
    name = "rail"
    at = 0.4                                 # [m] along the main pipe
    angle_deg = 90.0                         # between the two directions
    toward_deg = 0.0                         # clock of the crossing pipe's far end
    diameter = 0.050
    before = 0.3                             # [m] on the near side; 0 for a branch
    after = 0.6

The clock's zero is the world axis least along the pipe, made square to it (``x_axis`` says another), and counts about
the pipe's direction; it is carried along without twist.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Annotated, Any

import msgspec

from steeplejack.errors import InputError
from steeplejack.files import decode_toml, shortened

Length = Annotated[float, msgspec.Meta(ge=1e-4, le=1e6)]
"""Of something that is there [m]; what is too long for a run is said with its own words."""
Size = Annotated[float, msgspec.Meta(ge=1e-4, le=10.0)]
"""Diameters and heights [m]."""
NonNegative = Annotated[float, msgspec.Meta(ge=0.0, le=1e6)]
Degrees = Annotated[float, msgspec.Meta(ge=-3600.0, le=3600.0)]
Text = Annotated[str, msgspec.Meta(min_length=1, max_length=500)]
Name = Annotated[str, msgspec.Meta(min_length=1, max_length=60, pattern=r"^[^\x00-\x1f\x7f]+$")]
"""On one line, so that messages are."""
Coordinate = Annotated[float, msgspec.Meta(ge=-1e6, le=1e6)]
Point = tuple[Coordinate, Coordinate, Coordinate]
Acceleration = Annotated[float, msgspec.Meta(ge=-100.0, le=100.0)]
MAIN = "main"
EXAMPLE = Path(__file__).parent / "data" / "pipe-bend-300.toml"
"""What a message names for somebody to open."""


class StraightPart(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="kind", tag="straight"
):
    """A straight length of pipe."""

    length: Length
    diameter: Size | None = None


class BendPart(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="kind", tag="bend"):
    """A bend of constant radius in a plane."""

    radius: Length
    angle_deg: Annotated[float, msgspec.Meta(ge=0.1, le=180.0)]
    toward_deg: Degrees = 0.0
    diameter: Size | None = None


class MainEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The pipe the robot begins on."""

    diameter: Size
    parts: Annotated[tuple[StraightPart | BendPart, ...], msgspec.Meta(min_length=1, max_length=200)]
    point: Point = (0.0, 0.0, 0.0)
    direction: Point = (0.0, 0.0, 1.0)
    x_axis: Point | None = None


class ObstacleEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Something standing on a pipe, between two places along it."""

    start: Coordinate
    end: Coordinate
    height: Size
    note: Text
    pipe: Name = MAIN
    clock_deg: tuple[Degrees, Degrees] | None = None


class CrossingEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A straight pipe whose axis meets that of the main pipe."""

    name: Name
    at: NonNegative
    angle_deg: Annotated[float, msgspec.Meta(ge=5.0, le=175.0)]
    diameter: Size
    after: Length
    before: NonNegative = 0.0
    toward_deg: Degrees = 0.0


class StartEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Where the lower gripper begins, on the main pipe."""

    s: NonNegative
    clock_deg: Degrees = 0.0


class GoalEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Where the lower gripper has to come."""

    s: Coordinate
    pipe: Name = MAIN


class PipeFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, tag_field="kind", tag="pipes"):
    """The file as it is written."""

    name: Name
    description: Text
    source: Text
    start: StartEntry
    goal: GoalEntry
    main: MainEntry
    notes: tuple[Text, ...] = ()
    gravity: tuple[Acceleration, Acceleration, Acceleration] = (0.0, 0.0, -9.81)
    obstacles: Annotated[tuple[ObstacleEntry, ...], msgspec.Meta(max_length=200)] = ()
    crossings: Annotated[tuple[CrossingEntry, ...], msgspec.Meta(max_length=20)] = ()


def decode_pipes(content: bytes, where: str) -> PipeFile:
    """Decode a file of pipes.

    Args:
        content: Its bytes.
        where: Its name, for messages.

    Returns:
        What it says, checked field by field.

    Raises:
        InputError: Not TOML, or a field that cannot be used; the message gives its path.
    """
    try:
        return decode_toml(content, PipeFile, where, f"every field is in docs/climbing.md, an example in {EXAMPLE}")
    except InputError as error:
        raise InputError(error.where, _with_value(error.what, content), error.valid) from None


def _with_value(what: str, content: bytes) -> str:
    """What the decoder says of a field, with what the file has there; of a list its length."""
    found = re.match(r"(Expected [^,]*)( - at `\$\.(.*)`)$", what)
    if found is None:
        return what
    value: Any = tomllib.loads(content.decode())
    for key in re.findall(r"[^.\[\]]+", found[3]):
        value = value[int(key) if isinstance(value, list) else key]
    value = len(value) if isinstance(value, list) else shortened(repr(value))  # pyright: ignore[reportUnknownArgumentType]
    return f"{found[1]}, got {value}{found[2]}"
