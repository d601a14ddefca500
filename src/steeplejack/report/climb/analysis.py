"""A climb in figures, from its log alone."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from steeplejack.design.climber.transmission import local_transmission
from steeplejack.report.climb.log import ClimbLog

Array = NDArray[np.float64]


class ClimbSummary(msgspec.Struct, frozen=True):
    """What the command answers; keys are a contract.

    Distance is that of the robot's middle along its own axis, below 0 where it slid back. The mean speed is one of
    climbing: 0 for a robot that ended no further than it began. The least friction left is that of all samples; while
    one gripper moves the robot it is apart, for what grippers rub each other with as they change lasts a moment. Slips
    are those that the controller saw, None where the log breaks off before the end.
    """

    distance_m: float
    steps: int
    duration_s: float
    mean_speed_mm_s: float
    max_actuator_force_n: float
    min_transmission: float
    min_friction_margin: float | None
    min_friction_margin_moving: float | None
    slips: int | None
    collisions: int


@dataclass(frozen=True)
class Least:
    """Where least friction was left.

    Attributes:
        margin: What was [1].
        time: When [s].
        gripper: Index of the gripper.
        act: What was being done.
    """

    margin: float
    time: float
    gripper: int
    act: str


@dataclass(frozen=True)
class ClimbAnalysis:
    """Figures of a climb.

    Attributes:
        summary: Of the whole run.
        transmission: Local transmission index at every sample (n,) [1].
        bound: Mean speed that stroke, speed and close time allow on a straight pipe [m/s].
        least: Friction left at any time; None if no gripper was counted on.
        least_moving: While one gripper moved the robot.
        largest_error: At the moments of gripping [m, rad].
        energy: Put in by cylinders and servo [J].
    """

    summary: ClimbSummary
    transmission: Array
    bound: float
    least: Least | None
    least_moving: Least | None
    largest_error: tuple[float, float]
    energy: float


def speed_bound(log: ClimbLog) -> float:
    """``stroke / (2 stroke / v + 4 grip times)``: out and back at full speed, each gripper opened and closed [m/s]."""
    cylinders = log.robot.cylinders
    cycle = 2.0 * cylinders.stroke / cylinders.speed + 4.0 * log.robot.gripper.close_time
    return cylinders.stroke / cycle


def summarise(log: ClimbLog) -> ClimbAnalysis:
    """The figures of a climb."""
    samples = log.samples
    transmission = local_transmission(log.layout, samples.actual[:, :3])
    duration = float(samples.time[-1] if log.end is None else log.end.duration_s)
    distance = float(samples.travelled[-1])
    least, moving = _least(log), _least(log, "move")
    summary = ClimbSummary(
        distance_m=distance,
        steps=_steps(log),
        duration_s=duration,
        mean_speed_mm_s=max(1e3 * distance / duration, 0.0) if duration > 0.0 else 0.0,
        max_actuator_force_n=float(samples.strongest.max()),
        min_transmission=float(transmission.min()),
        min_friction_margin=least.margin if least else None,
        min_friction_margin_moving=moving.margin if moving else None,
        slips=None if log.end is None else log.end.slips,
        collisions=int(samples.collisions[-1]),
    )
    errors = [(one.error_m, one.error_rad) for one in log.grips] or [(np.nan, np.nan)]
    return ClimbAnalysis(
        summary,
        transmission,
        speed_bound(log),
        least,
        moving,
        (max(one[0] for one in errors), max(one[1] for one in errors)),
        float(samples.energy[-1]),
    )


def _least(log: ClimbLog, act: str | None = None) -> Least | None:
    """Where least friction was left, of all samples or of those of one act."""
    samples = log.samples
    counted = np.where(np.isnan(samples.margin), np.inf, samples.margin)
    if act is not None:
        counted[samples.act != act] = np.inf
    row, gripper = np.unravel_index(int(np.argmin(counted)), counted.shape)
    least = float(counted[row, gripper])
    return Least(least, float(samples.time[row]), int(gripper), str(samples.act[row])) if np.isfinite(least) else None


def _steps(log: ClimbLog) -> int:
    """How often the lower gripper was set down as planned."""
    phases = log.plan.phases
    return len({one.phase for one in log.grips if phases[one.phase].kind == "grip-lower" and one.gripper == "lower"})
