"""One move as a reference in time: the way of the open gripper, timed so that no cylinder and no servo is too fast.

Along its pipe the open gripper goes where it would be if it closed; from one pipe to another the cylinders go straight
from lengths to lengths, which keeps each in its window, and the poses follow by forward kinematics. With tau the time
the way takes when the slowest actuator runs at its speed throughout, tau(t) is a rest-to-rest profile of speed at
most 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.pairs import join
from steeplejack.robots.pipe_climber.forward import forward_kinematics
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.spatial import profile
from steeplejack.worksite.pipe_run import PipeRun

Array = NDArray[np.float64]

FINE = 0.0005
"""Distance of the places a way is computed at [m]."""
SAMPLE = 0.02
"""Time between two samples of a reference [s]."""
RESERVE = 0.999
"""Part of the actuators' speed that a reference uses [1]; what its straight pieces round off is less."""


@dataclass(frozen=True)
class Standing:
    """Where both grippers are.

    Attributes:
        lower: Pipe and place of the lower gripper [1, m].
        upper: Pipe and place of the upper gripper.
        lower_clock: Angle of its X axis [rad], unwrapped.
        upper_clock: Angle of its X axis and of the mechanism's.
        pose: (x, w, alpha) [m, m, rad].
    """

    lower: tuple[int, float]
    upper: tuple[int, float]
    lower_clock: float
    upper_clock: float
    pose: tuple[float, float, float]

    @property
    def freedoms(self) -> tuple[float, float, float, float]:
        """(x, w, alpha, beta)."""
        return (*self.pose, self.upper_clock - self.lower_clock)


def lower_moves(start: Standing, end: Standing) -> bool:
    """Whether it is the lower gripper that moves or turns from one standing to the next."""
    return start.lower != end.lower or abs(start.lower_clock - end.lower_clock) > 1e-9


def way(run: PipeRun, machine: Machine, start: Standing, end: Standing) -> Array | None:
    """Poses (k, 3) along a move [m, m, rad]; None if there is no way between two pipes."""
    lower_free = lower_moves(start, end)
    before, after = (start.lower, end.lower) if lower_free else (start.upper, end.upper)
    if before[0] != after[0]:
        return _across(machine, start, end)
    count = max(2, math.ceil(abs(after[1] - before[1]) / FINE) + 1)
    s = np.linspace(before[1], after[1], count)
    moving = run.pipes[before[0]].chord(s, machine.row)
    fixed_at = start.upper if lower_free else start.lower
    fixed = run.pipes[fixed_at[0]].chord(np.full(count, fixed_at[1]), machine.row)
    lower, upper = (moving, fixed) if lower_free else (fixed, moving)
    joined = join(machine, lower, upper)
    away = np.abs((joined.clocks - start.upper_clock + math.pi) % (2.0 * math.pi) - math.pi)
    side = np.where(joined.coaxial, 0, away.argmin(axis=1))
    return joined.poses[np.arange(count), side]


def _across(machine: Machine, start: Standing, end: Standing) -> Array | None:
    """Poses while the cylinders go straight from the lengths of one pose to those of another; None if they cannot."""
    ends = np.array([start.pose, end.pose])
    lengths = limb_lengths(machine.layout, ends)
    count = max(2, math.ceil(float(np.abs(lengths[1] - lengths[0]).max()) / (0.2 * FINE)) + 1)
    along = lengths[0] + np.linspace(0.0, 1.0, count)[:, None] * (lengths[1] - lengths[0])
    poses = forward_kinematics(machine.layout, along).poses[:, 0]
    good = np.isfinite(poses).all() and np.abs(poses[[0, -1]] - ends).max() < 1e-6
    steady = np.abs(np.diff(poses, axis=0)).max() < 0.05 if good else False
    tilted = np.abs(poses[:, 2]).max() > machine.robot.joints.limit + 1e-9 if good else True
    return poses if steady and not tilted else None


def timed(machine: Machine, poses: Array, turn: tuple[float, float]) -> tuple[Array, Array]:
    """Times (k,) [s] and freedoms (k, 4) of a move from rest to rest.

    Args:
        machine: With its speeds.
        poses: Along the way, (n, 3) [m, m, rad].
        turn: beta when it begins and when it ends [rad].
    """
    cylinders, gait = machine.robot.cylinders, machine.robot.gait
    lengths = limb_lengths(machine.layout, poses)
    cells = np.abs(np.diff(lengths, axis=0)).max(axis=1) / (RESERVE * cylinders.speed)
    tau = np.concatenate(([0.0], np.cumsum(cells)))
    turning = abs(turn[1] - turn[0]) / (RESERVE * gait.turn_speed)
    needed = max(float(tau[-1]), turning)
    if needed <= 0.0:
        return np.array([0.0]), np.append(poses[:1], [[turn[0]]], axis=1)
    share = tau / tau[-1] if tau[-1] > 0.0 else np.linspace(0.0, 1.0, len(tau))
    shape = profile(needed, 1.0, math.pi / (2.0 * gait.ramp))
    times = np.linspace(0.0, shape.duration, max(2, math.ceil(shape.duration / SAMPLE) + 1))
    at = np.array([shape.at(float(time))[0] for time in times]) / needed
    at[-1] = 1.0
    columns = [np.interp(at, share, poses[:, axis]) for axis in range(3)]
    return times, np.stack((*columns, turn[0] + at * (turn[1] - turn[0])), axis=-1)
