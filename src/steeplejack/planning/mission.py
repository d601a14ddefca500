"""The mission: what the squad will do, leg by leg, as one readable, hashed file.

A leg is a flight of the platform between gripped bases (``inspect`` along a stay, ``fly`` elsewhere), the drive of one
base while the platform is parked, or a ``brace``: the tensions change at one place, all bases gripped, before or after
a base may carry less. Its waypoints are equilibria certified at planning time; positions between them follow by cubic
interpolation in the travel. Angles in this file are degrees and say so.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Literal

import msgspec

from steeplejack.errors import InputError

Four = tuple[float, float, float, float]
Three = tuple[float, float, float]
FORMAT = "steeplejack-mission-1"


class Waypoint(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An equilibrium on the way."""

    travel: float  # along the leg: of the platform or of the base under way [m]; of the most changed tension [N]
    place: Three  # (stays across the bay, metres along, metres off the axis)
    position_m: Three  # world
    quaternion: Four  # platform to world, (w, x, y, z)
    tension_n: Four
    base_s_m: Four
    base_clock_deg: Four


class Leg(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One rest-to-rest motion."""

    kind: Literal["inspect", "fly", "drive", "brace"]
    stance: int
    stay: str | None  # inspected stay
    base: int | None  # base under way, 1 to 4
    speed: float  # of the travel [m/s or N/s]
    acceleration: float  # of the travel [m/s2 or N/s2]
    waypoints: tuple[Waypoint, ...]


class Uncovered(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A stretch that the plan does not inspect."""

    stay: str
    from_m: float
    to_m: float
    why: str


class Request(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What was asked for."""

    worksite: str
    robot: str
    fan: str
    stays: tuple[int, int]
    from_m: float
    to_m: float
    face: Literal["under", "upper"]
    payload_kg: float
    tension_n: tuple[float, float]


class Mission(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A whole inspection."""

    format: str
    request: Request
    boundary: tuple[str, str]
    interior: tuple[str, ...]
    carriers: tuple[str, str, str, str]  # stay of each base
    reserve: float
    assumed: tuple[str, ...]  # data of the bridge that were unknown and assumed
    legs: tuple[Leg, ...]
    uncovered: tuple[Uncovered, ...]
    sha256: str = ""

    @property
    def stances(self) -> int:
        """Number of stances that inspect."""
        return len({leg.stance for leg in self.legs if leg.kind == "inspect"})

    @property
    def moves(self) -> int:
        """Number of squad moves: changes of stance."""
        return len({leg.stance for leg in self.legs if leg.kind == "drive"})

    @property
    def intact(self) -> bool:
        """Whether the content is the one that was hashed."""
        return self.sha256 == _digest(self)

    def sealed(self) -> Mission:
        """The same mission with the hash of its content."""
        return msgspec.structs.replace(self, sha256=_digest(self))


def _digest(mission: Mission) -> str:
    return hashlib.sha256(msgspec.json.encode(msgspec.structs.replace(mission, sha256=""))).hexdigest()


def encode(mission: Mission) -> bytes:
    """The mission as readable JSON: one line a waypoint."""
    legs = [_leg(leg) for leg in mission.legs]
    head = msgspec.json.format(msgspec.json.encode(msgspec.structs.replace(mission, legs=())), indent=1).decode()
    return head.replace('"legs": []', '"legs": [\n' + ",\n".join(legs) + "\n ]", 1).encode()


def _leg(leg: Leg) -> str:
    head = msgspec.json.encode(msgspec.structs.replace(leg, waypoints=())).decode()
    points = ",\n".join("   " + msgspec.json.encode(point).decode() for point in leg.waypoints)
    return "  " + head.replace('"waypoints":[]', '"waypoints":[\n' + points + "\n  ]", 1)


def decode(content: bytes, where: str) -> Mission:
    """Read a mission and check its hash.

    Raises:
        InputError: Not a mission, or changed since it was planned.
    """
    try:
        mission = msgspec.json.decode(content, type=Mission)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError(where, str(error), "a mission written by `steeplejack inspect`") from None
    if mission.format != FORMAT:
        raise InputError(where, f"format {mission.format!r}", FORMAT)
    if not mission.intact:
        raise InputError(
            where, "content does not match its sha256", "a mission that has not been edited since planning"
        )
    return mission


def write(mission: Mission, path: Path) -> None:
    """Write a mission file."""
    path.write_bytes(encode(mission))
