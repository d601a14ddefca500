"""What a climb leaves in its log: run, robot, plan, samples, grips. One MCAP file, as `runtime.recorder` writes it.

Topics: ``/run``, ``/robot``, ``/plan`` once at the start and ``/end`` at the end, ``/climb`` fifty times a second,
``/grip`` whenever a gripper has closed, ``/event`` when something happens, ``/camera`` pictures, ``/film`` an animated
one at the end if asked for. Lower gripper first, then upper.
"""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

Pair = tuple[float, float]
Triple = tuple[float, float, float]
Pose = tuple[float, float, float, float]


def pair(values: Iterable[float]) -> Pair:
    """Two numbers as they are recorded."""
    a, b = map(float, values)
    return a, b


def triple(values: Iterable[float]) -> Triple:
    """Three numbers as they are recorded."""
    a, b, c = map(float, values)
    return a, b, c


def pose_record(values: Iterable[float]) -> Pose:
    """(x, w, alpha, beta) as it is recorded."""
    x, w, alpha, beta = map(float, values)
    return x, w, alpha, beta


class SolidRecord(msgspec.Struct, frozen=True):
    """A straight round piece of pipe or of an obstacle."""

    kind: str
    start_m: Triple
    end_m: Triple
    radius_m: float


class RunRecord(msgspec.Struct, frozen=True):
    """What was climbed, on what grips, with what on the upper gripper, and the seed of the sensors' errors."""

    name: str
    description: str
    source: str
    gravity: Triple
    friction: Pair
    solids: tuple[SolidRecord, ...]
    version: str
    payload_kg: float = 0.0
    seed: int | None = None


class PhaseRecord(msgspec.Struct, frozen=True):
    """One act of the plan."""

    kind: str
    hold: str
    duration_s: float
    start: Pose
    end: Pose
    s_lower_m: float
    s_upper_m: float
    clock_rad: float
    pipe_lower: str
    pipe_upper: str
    why: str


class PlanRecord(msgspec.Struct, frozen=True):
    """The plan as it was before the run."""

    phases: tuple[PhaseRecord, ...]
    duration_s: float
    reached_m: float
    complete: bool
    blocked: str | None


class ClimbSample(msgspec.Struct, frozen=True):
    """One sample of the run; poses are (x, w, alpha, beta), forces positive when pushing."""

    time_s: float
    phase: int
    act: str
    closed: tuple[bool, bool]
    reference: Pose
    actual: Pose
    lengths_m: Triple
    speeds_m_s: Triple
    forces_n: Triple
    max_force_n: float
    grip_n: Pair
    margin: tuple[float | None, float | None]
    slip_m: Pair
    lower_m: Triple
    upper_m: Triple
    travelled_m: float
    energy_j: float
    collisions: int


class GripRecord(msgspec.Struct, frozen=True):
    """A gripper has closed: pose of the free end against the commanded one, and against the place on the pipe."""

    time_s: float
    phase: int
    gripper: str
    error_m: float
    error_rad: float
    place_error_m: float
    force_n: float


class EndRecord(msgspec.Struct, frozen=True):
    """How the run ended."""

    completed: bool
    safe: bool
    why: str
    duration_s: float
    travelled_m: float
    collisions: int
    slips: int
    regrips: int
