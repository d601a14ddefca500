"""The log: one append-only MCAP file that survives a kill and that any MCAP reader opens.

Topics, all JSON with their schema in the file: ``/worksite`` and ``/mission`` and ``/robot`` once at the start,
``/state`` twenty times a second, ``/event`` when something happens, ``/camera`` pictures (foxglove.CompressedImage),
``/seed`` with what makes the run repeatable; ``/robot/actual`` where physics ran another machine than the one believed
in. Chunks hold about half a second of states and go to the operating system
as they fill, so a kill loses less than a second.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import msgspec
from mcap.writer import CompressionType, Writer

from steeplejack.worksite import Interval, Stay

CHUNK = 16 * 1024  # [bytes] of messages before compression


class Zone(msgspec.Struct, frozen=True):
    """An interval of a stay, see ``worksite.Interval``."""

    start: float
    end: float
    kind: Literal["end zone", "obstacle"]
    height: float | None
    note: str


class StayRecord(msgspec.Struct, frozen=True):
    """Everything ``worksite.Stay`` is made of, so that the log alone gives the curve back."""

    id: str
    tower: str
    plane: Literal["L", "R"]
    side: Literal["main", "side"]
    index: int
    lower: tuple[float, float, float]
    upper: tuple[float, float, float]
    diameter: float | None
    weight: float | None
    tension: float | None
    axial_stiffness: float | None
    intervals: tuple[Zone, ...]
    chord_only: bool

    @classmethod
    def of(cls, stay: Stay) -> StayRecord:
        """Record a stay."""
        zones = tuple(Zone(z.start, z.end, z.kind, z.height, z.note) for z in stay.intervals)
        x, y = (tuple(float(v) for v in point) for point in (stay.lower, stay.upper))
        return cls(
            stay.id, stay.tower, stay.plane, stay.side, stay.index, (x[0], x[1], x[2]), (y[0], y[1], y[2]),
            stay.diameter, stay.weight, stay.tension, stay.axial_stiffness, zones, stay.chord_only,
        )  # fmt: skip

    def stay(self) -> Stay:
        """The stay again."""
        zones = tuple(Interval(z.start, z.end, z.kind, z.height, z.note) for z in self.intervals)
        return Stay(
            self.id, self.tower, self.plane, self.side, self.index, self.lower, self.upper,
            self.diameter, self.weight, self.tension, self.axial_stiffness, zones, self.chord_only,
        )  # fmt: skip


class VerdictRecord(msgspec.Struct, frozen=True):
    """Whether the machine fits a stay, as checked before the plan."""

    stay: str
    fits: bool | None
    reasons: tuple[str, ...]
    unknown: tuple[str, ...]


class Site(msgspec.Struct, frozen=True):
    """The part of the worksite a run takes place on."""

    name: str
    source: str
    gravity: tuple[float, float, float]
    stays: tuple[StayRecord, ...]  # of the bay, boundary stays first and last
    verdicts: tuple[VerdictRecord, ...]  # of every stay of the worksite


class Seed(msgspec.Struct, frozen=True):
    """What makes the run repeatable."""

    seed: int
    version: str


class State(msgspec.Struct, frozen=True):
    """One sample of the run; world frame, SI, tensions and margins as extremes since the sample before."""

    time_s: float
    leg: int
    phase: str
    stay: str
    base_moving: int  # 1 to 4, 0 for none
    desired_position_m: list[float]
    estimated_position_m: list[float]
    actual_position_m: list[float]
    desired_quaternion: list[float]
    estimated_quaternion: list[float]
    actual_quaternion: list[float]
    actual_velocity_m_s: list[float]
    desired_tension_n: list[float]
    measured_tension_n: list[float]
    actual_tension_n: list[float]
    max_tension_n: float
    min_tension_n: float
    min_slip_margin: float
    slip_margin: list[float]
    tension_factor: float
    desired_s_m: list[float]
    measured_s_m: list[float]
    actual_s_m: list[float]
    exits_measured_m: list[list[float]]
    exits_actual_m: list[list[float]]
    residual_m: float
    allocation: int


class Event(msgspec.Struct, frozen=True):
    """Something that happened."""

    time_s: float
    kind: str  # phase, breach, stop, note
    text: str


class Picture(msgspec.Struct, frozen=True):
    """A picture of the squad at work, as foxglove.CompressedImage."""

    timestamp: dict[str, int]
    frame_id: str
    data: bytes
    format: str


class Recorder:
    """Writes one log.

    Args:
        path: File to create.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb")
        self._writer = Writer(self._file, chunk_size=CHUNK, compression=CompressionType.ZSTD)
        self._writer.start(profile="", library="steeplejack")
        self._channels: dict[str, int] = {}
        self._sequence = 0

    def write(self, topic: str, message: Any, at: float) -> None:
        """Append a message (a msgspec struct or anything msgspec encodes) stamped with a time [s] of the run."""
        if topic not in self._channels:
            self._channels[topic] = self._register(topic, type(message))
        stamp = int(at * 1e9)
        self._sequence += 1
        data = msgspec.json.encode(message)
        self._writer.add_message(self._channels[topic], stamp, data, stamp, self._sequence)
        self._file.flush()

    def note(self, at: float, text: str, kind: str = "note") -> None:
        """Append an event."""
        self.write("/event", Event(at, kind, text), at)

    def close(self) -> None:
        """Finish the file with its index."""
        self._writer.finish()
        self._file.close()

    def _register(self, topic: str, kind: type) -> int:
        name = "foxglove.CompressedImage" if kind is Picture else f"steeplejack.{kind.__name__}"
        schema: dict[str, Any] = {"type": "object"}
        if issubclass(kind, msgspec.Struct):
            (reference,), definitions = msgspec.json.schema_components([kind])
            schema = {**definitions[kind.__name__], "$defs": definitions} if "$ref" in reference else reference
        identifier = self._writer.register_schema(name, "jsonschema", msgspec.json.encode(schema))
        return self._writer.register_channel(topic, "json", identifier)
