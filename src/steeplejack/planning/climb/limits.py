"""What a machine can do in one place: lengths, tilt, hinges and singularity of a pose.

A pose is allowed when every cylinder is within its own window (between its retracted length and that plus the stroke,
and within the reach of the mechanism), the platform's tilt within the joints' range, the hinges within theirs where
the machine names a neutral, and det J on the home pose's side. What grips and drives have to bear there is another
question: see `alone`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import InputError
from steeplejack.planning.climb.solids import AIR
from steeplejack.robots.pipe_climber.bars import inner_radius
from steeplejack.robots.pipe_climber.inverse import hinge_angles, limb_lengths
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.pads import pad_row
from steeplejack.robots.pipe_climber.parameters import PipeClimber
from steeplejack.robots.pipe_climber.singularity import determinant

Array = NDArray[np.float64]
Limit = Literal["plane", "shortest", "longest", "tilt", "hinge", "singularity"]
LIMITS: tuple[Limit, ...] = ("plane", "shortest", "longest", "tilt", "hinge", "singularity")
SINGULAR = 1e-3
"""Least |det J| in parts of L1 that a climb goes near [1]; at home it is about 0.5."""
ROUNDING = 1e-9
MOST_PAYLOAD = 1e6
"""[kg] Beyond what any robot lifts, and of what its square and cube are still numbers."""


@dataclass(frozen=True)
class Machine:
    """A pipe climber as the planner sees it.

    Attributes:
        robot: All of it.
        layout: Its hinges.
        shortest: Of each cylinder, (3,) [m].
        longest: Of each cylinder, (3,) [m].
        side: Sign of det J at the home pose.
        payload: On the upper gripper [kg].
    """

    robot: PipeClimber
    layout: Layout
    shortest: Array
    longest: Array
    side: float
    payload: float = 0.0

    @classmethod
    def of(cls, robot: PipeClimber, payload_kg: float = 0.0) -> Machine:
        """The planner's view of a machine with a payload on its upper gripper [kg]."""
        if not 0.0 <= payload_kg <= MOST_PAYLOAD:
            raise InputError("payload", f"{payload_kg:g} kg", f"0 to {MOST_PAYLOAD:g} kg")
        cylinders, layout = robot.cylinders, Layout.of(robot)
        shortest = np.maximum(cylinders.retracted, cylinders.reach[0])
        longest = np.minimum(np.array(cylinders.retracted) + cylinders.stroke, cylinders.reach[1])
        side = float(np.sign(determinant(layout, np.array(robot.joints.home))))
        return cls(robot, layout, shortest, longest, side, payload_kg)

    @property
    def claw_offset(self) -> float:
        """hz, from O2 to the upper gripper's centre [m]."""
        return self.robot.linkage.claw_offset

    @property
    def peaks(self) -> tuple[float, float]:
        """Largest acceleration of a cylinder [m/s2] and of the linkage [rad/s2] in a ramp; see `spatial.timing`."""
        gait = self.robot.gait
        rise = 0.5 * math.pi / gait.ramp
        return rise * self.robot.cylinders.speed, rise * gait.turn_speed

    @property
    def row(self) -> float:
        """Distance of a gripper's rows of pads from its middle: where it touches the pipe [m]."""
        return pad_row(self.robot)

    @property
    def lowest_bar(self) -> float:
        """What ends below this distance from a straight pipe's axis meets none of the robot's bars [m]."""
        return inner_radius(self.robot) - AIR

    @property
    def straight_gaps(self) -> tuple[float, float]:
        """Least and largest distance of the grippers on a straight pipe; least above largest if there is none [m]."""
        across = self.layout.platform - self.layout.base
        squares = np.maximum(self.shortest**2 - across**2, 0.0)
        least = math.sqrt(max(float(squares.max()), 0.0))
        rest = self.longest**2 - across**2
        largest = math.sqrt(float(rest.min())) if (rest > 0.0).all() else -math.inf
        return least + self.claw_offset, largest + self.claw_offset


def margins(machine: Machine, poses: Array) -> Array:
    """How far poses are inside each limit.

    Args:
        machine: With its limits.
        poses: (x, w, alpha), (k, 3) [m, m, rad].

    Returns:
        (k, 6) in the order of `LIMITS`, negative where the limit is passed: [1] (plane, always 1 here), [m], [m],
        [rad], [rad], [m].
    """
    lengths = limb_lengths(machine.layout, poses)
    joints = machine.robot.joints
    found = np.empty((len(poses), len(LIMITS)))
    found[:, 0] = 1.0
    found[:, 1] = (lengths - machine.shortest).min(axis=1)
    found[:, 2] = (machine.longest - lengths).min(axis=1)
    found[:, 3] = joints.limit - np.abs(poses[:, 2])
    found[:, 4] = np.pi
    if joints.neutral != "none":
        turns = np.abs(hinge_angles(machine.layout, poses, joints.neutral))
        found[:, 4] = joints.limit - turns.reshape(len(poses), -1).max(axis=1)
    ahead = np.where(poses[:, 1] > 0.0, 1.0, -1.0)
    with np.errstate(invalid="ignore", divide="ignore"):  # where a limb has no length
        det = machine.side * determinant(machine.layout, poses)
    found[:, 5] = np.minimum(det, ahead) - SINGULAR * machine.layout.lengths[0]
    return np.where(np.isnan(found), -1.0, found)
