"""A climb as a plan: the phases of grip, move and release that bring the robot along a run of pipes.

Where the robot is follows from a phase alone: the lower gripper's frame is that of the pipe's chord between its two
rows of pads about ``s_lower`` (`worksite.pipe_line.Pipe.chord`), turned by ``clock`` about its z axis, and the upper
gripper's is `robots.pipe_climber.grippers.free_gripper` of the pose. A move with the lower gripper holding leaves
``s_lower`` and ``clock`` as they are; one with the upper gripper holding leaves
``s_upper``, and the lower gripper's new place and clock stand in the next phase.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Pose = tuple[float, float, float, float]
Kind = Literal["move", "grip-lower", "grip-upper", "release-lower", "release-upper"]


class Hold(Enum):
    """Which grippers are closed; there is no word for neither."""

    BOTH = "both"
    LOWER = "lower"
    UPPER = "upper"


def _no_times() -> Array:
    return np.empty(0)


def _no_poses() -> Array:
    return np.empty((0, 4))


@dataclass(frozen=True)
class Phase:
    """One act of a climb, from rest to rest.

    Attributes:
        kind: A move, or one gripper closing or opening.
        hold: The grippers that bear the robot throughout: of a gripper that closes or opens only the other one.
        duration: [s].
        start: (x, w, alpha, beta) of the mechanism when it begins [m, m, rad, rad].
        end: The same when it ends.
        times: (k,) from 0 to the duration [s]; empty but for a move.
        poses: (k, 4) reference at these times; empty but for a move.
        s_lower: Where the lower gripper is along its pipe when the phase begins [m].
        s_upper: The same of the upper gripper.
        clock: Angle of the lower gripper's X axis about its pipe when the phase begins [rad]; that of the mechanism's
            and of the upper gripper is ``clock + beta``.
        why: What it is for, in words.
        pipe_lower: Name of the pipe the lower gripper is on when the phase begins.
        pipe_upper: The same of the upper gripper.
        crosses: Whether it belongs to a step from one pipe to another.
    """

    kind: Kind
    hold: Hold
    duration: float
    start: Pose
    end: Pose
    s_lower: float
    s_upper: float
    clock: float
    why: str
    times: Array = field(default_factory=_no_times)
    poses: Array = field(default_factory=_no_poses)
    pipe_lower: str = "main"
    pipe_upper: str = "main"
    crosses: bool = False


@dataclass(frozen=True)
class ClimbPlan:
    """What `plan_climb` finds: the fastest climb, or the furthest one and what ends it.

    Attributes:
        run: Name of the run of pipes.
        robot: Name of the machine.
        phases: From the run's start on.
        reached_m: How far the lower gripper has then come along the way [m].
        complete: Whether that is the goal.
        blocked: Which limit ends the climb and what would change that; None if complete.
    """

    run: str
    robot: str
    phases: tuple[Phase, ...]
    reached_m: float
    complete: bool
    blocked: str | None

    @property
    def duration(self) -> float:
        """Of all phases [s]."""
        return sum(phase.duration for phase in self.phases)

    @property
    def steps(self) -> int:
        """How often the lower gripper is set down."""
        return sum(phase.kind == "grip-lower" for phase in self.phases)
