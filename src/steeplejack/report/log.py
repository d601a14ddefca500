"""A log read back: everything a run recorded, also where the run was killed and the file ends in the middle."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TypeVar

import msgspec
import numpy as np
from mcap.exceptions import McapError
from mcap.records import Channel, Footer, Message
from mcap.stream_reader import StreamReader
from numpy.typing import NDArray
from zstandard import ZstdError

from steeplejack.errors import InputError
from steeplejack.planning.mission import Mission
from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Squad
from steeplejack.runtime.gait import Phase
from steeplejack.runtime.recorder import Event, Picture, Seed, Site, State
from steeplejack.spatial import from_quaternion
from steeplejack.worksite import Fan

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Kind = TypeVar("Kind")

MAGIC = b"\x89MCAP0\r\n"
VALID = "a log written by `steeplejack inspect`"
DAMAGE = (McapError, ZstdError, struct.error, ValueError)  # what reading past the end of a killed file can raise
COMPLETE = "mission complete"
BREAKS_OFF = "the log breaks off before the run's end"


@dataclass(frozen=True)
class States:
    """The samples of a run as columns, in the order of time; world frame, SI. See ``runtime.recorder.State``."""

    time: Array  # (n,) [s]
    leg: NDArray[np.int64]  # (n,) index into the mission's legs
    phase: NDArray[np.str_]  # (n,) values of ``runtime.gait.Phase``
    base_moving: NDArray[np.int64]  # (n,) 1 to 4, 0 for none
    desired_position: Array  # (n, 3) [m]
    desired_rotation: Array  # (n, 3, 3) platform to world
    actual_position: Array  # (n, 3) [m]
    actual_rotation: Array  # (n, 3, 3) platform to world
    actual_tension: Array  # (n, 4) [N]
    max_tension: Array  # (n,) [N] since the sample before
    min_tension: Array  # (n,) [N] since the sample before
    slip_margin: Array  # (n, 4) [1] least since the sample before
    tension_factor: Array  # (n,) [1]
    actual_s: Array  # (n, 4) [m] bases
    exits_measured: Array  # (n, 4, 3) [m]
    exits_actual: Array  # (n, 4, 3) [m]

    @classmethod
    def of(cls, samples: list[State]) -> States:
        """Columns of at least one sample."""
        return cls(
            np.array([s.time_s for s in samples]),
            np.array([s.leg for s in samples]),
            np.array([s.phase for s in samples]),
            np.array([s.base_moving for s in samples]),
            np.array([s.desired_position_m for s in samples]),
            np.array([from_quaternion(np.array(s.desired_quaternion)) for s in samples]),
            np.array([s.actual_position_m for s in samples]),
            np.array([from_quaternion(np.array(s.actual_quaternion)) for s in samples]),
            np.array([s.actual_tension_n for s in samples]),
            np.array([s.max_tension_n for s in samples]),
            np.array([s.min_tension_n for s in samples]),
            np.array([s.slip_margin for s in samples]),
            np.array([s.tension_factor for s in samples]),
            np.array([s.actual_s_m for s in samples]),
            np.array([s.exits_measured_m for s in samples]),
            np.array([s.exits_actual_m for s in samples]),
        )

    @property
    def stopped(self) -> Flags:
        """Samples (n,) taken after a breach, on the brakes."""
        return self.phase == Phase.STOPPED.value


@dataclass(frozen=True)
class Log:
    """One run, as recorded."""

    path: Path
    site: Site
    squad: Squad  # that plan, controller and safety believed in
    actual: Squad  # that physics ran
    mission: Mission
    seed: Seed
    bay: Bay
    states: States
    events: tuple[Event, ...]
    pictures: tuple[Picture, ...]
    complete: bool  # the file was closed; otherwise its end is missing

    @property
    def accomplished(self) -> bool:
        """Whether the mission was flown to its end."""
        return any(event.kind == "note" and event.text == COMPLETE for event in self.events)

    @property
    def faults(self) -> tuple[str, ...]:
        """Why the run is not a whole one, in words; empty for a mission flown to its end and logged."""
        breaches = tuple(event.text for event in self.events if event.kind == "breach")
        if breaches or self.accomplished:
            return breaches
        return ("the run ended before the mission did" if self.complete else BREAKS_OFF,)


def read_log(path: Path) -> Log:
    """Read a log; a file that breaks off gives everything up to there.

    Args:
        path: An MCAP file.

    Raises:
        InputError: It cannot be read, is not an MCAP file, or lacks what a report needs.
    """
    messages, complete = messages_of(path)
    site, squad, mission, seed = (
        only(path, messages, topic, kind)
        for topic, kind in (("/worksite", Site), ("/robot", Squad), ("/mission", Mission), ("/seed", Seed))
    )
    assert isinstance(site, Site) and isinstance(squad, Squad)
    assert isinstance(mission, Mission) and isinstance(seed, Seed)
    actual = decoded(path, messages, "/robot/actual", Squad)
    samples = decoded(path, messages, "/state", State)
    if not samples:
        raise InputError(str(path), "no samples in /state", VALID)
    fan = Fan(mission.request.fan, tuple(stay.stay() for stay in site.stays))
    return Log(
        path,
        site,
        squad,
        actual[-1] if actual else squad,
        mission,
        seed,
        Bay.of(fan, *mission.request.stays, mission.request.face, squad),
        States.of(samples),
        tuple(decoded(path, messages, "/event", Event)),
        tuple(decoded(path, messages, "/camera", Picture)),
        complete,
    )


def messages_of(path: Path) -> tuple[dict[str, list[bytes]], bool]:
    """Messages of every topic, and whether the file is whole."""
    found: dict[str, list[bytes]] = {}
    try:
        with path.open("rb") as file:
            head = file.read(len(MAGIC))
            if head != MAGIC:
                raise InputError(str(path), "an empty file" if not head else "not an MCAP file", VALID)
            file.seek(0)
            complete = False
            for item in _records(file):
                if item is None:
                    complete = True
                else:
                    found.setdefault(item[0], []).append(item[1])
    except OSError as error:
        raise InputError(str(path), error.strerror or "cannot be read", VALID) from None
    return found, complete


def _records(file: IO[bytes]) -> Iterator[tuple[str, bytes] | None]:
    """Topic and data of every message, then None if the file is whole; ends where the file is damaged."""
    topics: dict[int, str] = {}
    try:
        for record in StreamReader(file, validate_crcs=True).records:
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            elif isinstance(record, Message):
                yield topics[record.channel_id], record.data
            elif isinstance(record, Footer):
                yield None
    except DAMAGE:
        return


def decoded(path: Path, messages: dict[str, list[bytes]], topic: str, kind: type[Kind]) -> list[Kind]:
    """Every message of a topic."""
    decoder = msgspec.json.Decoder(kind)
    try:
        return [decoder.decode(data) for data in messages.get(topic, [])]
    except msgspec.DecodeError as error:
        raise InputError(f"{path}, {topic}", str(error).replace("\n", " "), VALID) from None


def only(path: Path, messages: dict[str, list[bytes]], topic: str, kind: type[Kind]) -> Kind:
    """The last message of a topic that has to be there."""
    found = decoded(path, messages, topic, kind)
    if not found:
        raise InputError(str(path), f"no {topic}", VALID)
    return found[-1]
