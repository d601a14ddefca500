"""What a machine can do in one place: lengths, tilt, hinges, singularity and actuator forces of a pose.

A pose is allowed when every cylinder is within its own window (between its retracted length and that plus the stroke,
and within the reach of the mechanism), the platform's tilt within the joints' range, the hinges within theirs where
the machine names a neutral, det J on the home pose's side, and when cylinders and the linkage's servo hold the weight
of either half of the robot (`robots.pipe_climber.bearing`): whichever gripper then opens, the other one bears the
robot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import InputError
from steeplejack.planning.climb.collide import AIR
from steeplejack.robots.pipe_climber.bars import inner_radius
from steeplejack.robots.pipe_climber.bearing import weight_wrenches
from steeplejack.robots.pipe_climber.inverse import hinge_angles, limb_lengths
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.pads import pad_row
from steeplejack.robots.pipe_climber.parameters import PipeClimber
from steeplejack.robots.pipe_climber.singularity import determinant
from steeplejack.robots.pipe_climber.weights import first_moments, own_moment

Array = NDArray[np.float64]
Limit = Literal["plane", "shortest", "longest", "tilt", "hinge", "singularity", "force", "servo"]
LIMITS: tuple[Limit, ...] = ("plane", "shortest", "longest", "tilt", "hinge", "singularity", "force", "servo")
SINGULAR = 1e-3
"""Least |det J| in parts of L1 that a climb goes near [1]; at home it is about 0.5."""
ROUNDING = 1e-9


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
        if not 0.0 <= payload_kg < math.inf:
            raise InputError("payload", f"{payload_kg:g} kg", "a finite mass of at least 0 kg")
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


def margins(machine: Machine, poses: Array, gravity: Array, any_clock: bool = False) -> Array:
    """How far poses are inside each limit.

    Args:
        machine: With its limits.
        poses: (x, w, alpha), (k, 3) [m, m, rad].
        gravity: In the mechanism's frame, (k, 3) [m/s2].
        any_clock: Whether gravity across the pipe may point to any side of the mechanism.

    Returns:
        (k, 8) in the order of `LIMITS`, negative where the limit is passed: [1] (plane, always 1 here), [m], [m],
        [rad], [rad], [m], [N], [N m]. Force and torque only where the others hold, else infinite.
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
    found[:, 6:] = np.inf
    held = (found[:, :6] >= -ROUNDING).all(axis=1)
    found[held, 6] = machine.robot.cylinders.force - largest_force(machine, poses[held], gravity[held], any_clock)
    found[held, 7] = machine.robot.build.servo_torque - largest_torque(machine, poses[held], gravity[held], any_clock)
    return np.where(np.isnan(found), -1.0, found)


def largest_force(machine: Machine, poses: Array, gravity: Array, any_clock: bool = False) -> Array:
    """Largest push or pull of a cylinder while either gripper holds alone, slow motion, whatever beta is, (k,) [N].

    Arguments as of `margins`. With the upper gripper holding, forces are linear in cos beta, so that the largest are
    those at the ends of its range.
    """
    ends = (0.0, min(machine.robot.rcm.limit, math.pi))
    first, last = (weight_wrenches(machine.robot, machine.layout, poses, beta, machine.payload) for beta in ends)
    wrenches = np.concatenate((first, last[:, 1:]), axis=1)  # (k, 3, 2 axes, 3): lower, upper at either end
    columns = np.swapaxes(wrenches.reshape(len(poses), 6, 3), -1, -2)
    rows = np.swapaxes(jacobian(machine.layout, poses), -1, -2)
    each = np.linalg.solve(rows, columns).reshape(len(poses), 3, 3, 2)  # limb, holding, axis
    across, along = each[..., 0], gravity[:, 2, None, None] * each[..., 1]
    if any_clock:
        worst = np.hypot(gravity[:, 0], gravity[:, 1])[:, None, None] * np.abs(across) + np.abs(along)
    else:
        worst = np.abs(gravity[:, 0, None, None] * across + along)
    return worst.max(axis=(1, 2))


def largest_torque(machine: Machine, poses: Array, gravity: Array, any_clock: bool = False) -> Array:
    """Largest torque of the linkage's servo while either gripper holds alone, at rest, whatever beta is, (k,) [N m].

    Arguments as of `margins`. What hangs from the lower gripper may have gravity to any side.
    """
    freedoms = np.append(poses, np.zeros((len(poses), 1)), axis=1)
    _mass, moment = first_moments(machine.robot, machine.layout, freedoms, machine.payload)
    own, across = own_moment(machine.robot), np.hypot(gravity[:, 0], gravity[:, 1])
    aside = across if any_clock else np.abs(gravity[:, 1])
    return np.maximum(np.abs(moment[:, 0] - own) * aside, abs(own) * across)
