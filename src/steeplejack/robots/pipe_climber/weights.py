"""Where the robot's mass is: lumps of its parts, and the load that its weight puts on the gripper that holds alone.

Lumps stand where the physics puts them: each gripper's frame behind its jaws, the bars of the linkage about the pipe
below the lower gripper, plates between their hinges, bodies and rods of the cylinders along the limbs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.inverse import limb_lengths, limb_vectors
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.parameters import PipeClimber

Array = NDArray[np.float64]

FRAME = (-0.03, 0.01)
"""Middle of a gripper's frame, along X and, away from the other gripper, along Z [m]; estimate."""
BODY_SHARE = 0.6
"""Of a cylinder's mass that is in its body, the rest in its rod; estimate [1]."""
BEHIND = 0.005
"""By how much the body of a cylinder is shorter than its least length [m]; estimate."""
LINKAGE_BELOW = 0.020
"""From the end of the lower jaws to the plane of the linkage [m]; estimate."""


def linkage_height(robot: PipeClimber) -> float:
    """Height of the linkage's plane over the lower gripper's middle; below it, so negative [m]."""
    return -(0.5 * robot.build.jaw_length + LINKAGE_BELOW)


def linkage_mass(robot: PipeClimber) -> float:
    """What the other parts leave of the robot's mass [kg].

    Raises:
        InputError: Nothing is left.
    """
    build = robot.build
    rest = robot.body.mass - 2.0 * (build.gripper_mass + build.plate_mass) - 3.0 * robot.cylinders.mass
    if not (rest > 0.0 and build.gripper_mass > 2.0 * build.jaw_mass):
        raise InputError("[build] masses", f"parts leave {rest:g} kg for the linkage", "parts lighter than the robot")
    return rest


def own_moment(robot: PipeClimber) -> float:
    """First moment, along its X, of what turns with the lower gripper; the linkage's bars have none [kg m]."""
    return (robot.build.gripper_mass - 2.0 * robot.build.jaw_mass) * FRAME[0]


def first_moments(robot: PipeClimber, layout: Layout, freedoms: ArrayLike, payload: float = 0.0) -> tuple[float, Array]:
    """Mass of robot and payload, and its first moment about the lower gripper's middle.

    Args:
        robot: The machine.
        layout: Its hinges.
        freedoms: (x, w, alpha, beta), (..., 4) [m, m, rad, rad].
        payload: At the upper gripper's middle [kg].

    Returns:
        Mass [kg] and ``sum m r`` in the frame of the lower gripper, (..., 3) [kg m].
    """
    given = np.asarray(freedoms, dtype=np.float64)
    poses, beta = given[..., :3], given[..., 3]
    upward = (robot.build.gripper_mass - 2.0 * robot.build.jaw_mass) * FRAME[1]
    turned = np.zeros((*beta.shape, 3))  # what turns with the mechanism
    turned[..., 0] += robot.build.plate_mass * 0.5 * float(layout.base.min())
    turned += _cylinders(robot, layout, poses) + _upper(robot, layout, poses, payload)
    out = np.empty_like(turned)
    cosine, sine = np.cos(beta), np.sin(beta)
    out[..., 0] = own_moment(robot) + turned[..., 0] * cosine - turned[..., 1] * sine
    out[..., 1] = turned[..., 0] * sine + turned[..., 1] * cosine
    out[..., 2] = turned[..., 2] - upward + linkage_mass(robot) * linkage_height(robot)
    return robot.body.mass + payload, out


def _cylinders(robot: PipeClimber, layout: Layout, poses: Array) -> Array:
    """First moment of bodies and rods [kg m]."""
    directions = limb_vectors(layout, poses) / limb_lengths(layout, poses)[..., None]
    half, lengths = 0.5 * (robot.cylinders.reach[0] - BEHIND), limb_lengths(layout, poses)
    along = robot.cylinders.mass * (BODY_SHARE * half + (1.0 - BODY_SHARE) * (lengths - half))
    out = np.zeros((*poses.shape[:-1], 3))
    out[..., 0] = robot.cylinders.mass * float(layout.base.sum()) + (along * directions[..., 0]).sum(axis=-1)
    out[..., 2] = (along * directions[..., 1]).sum(axis=-1)
    return out


def _upper(robot: PipeClimber, layout: Layout, poses: Array, payload: float) -> Array:
    """First moment of the upper plate, gripper and payload [kg m]."""
    x, w, alpha = np.moveaxis(poses, -1, 0)
    build, hz = robot.build, robot.linkage.claw_offset
    frame = build.gripper_mass - 2.0 * build.jaw_mass
    mass = build.plate_mass + build.gripper_mass + payload
    forward = build.plate_mass * 0.5 * float(layout.platform.min()) + frame * FRAME[0]
    upward = frame * FRAME[1] + (build.gripper_mass + payload) * hz
    c, s = np.cos(alpha), np.sin(alpha)
    out = np.zeros((*poses.shape[:-1], 3))
    out[..., 0] = mass * x + forward * c + upward * s
    out[..., 2] = mass * w - forward * s + upward * c
    return out


def grip_loads(
    robot: PipeClimber, layout: Layout, freedoms: ArrayLike, gravity: ArrayLike, payload: float = 0.0
) -> Array:
    """Weight as the load on either gripper when it holds alone.

    Args:
        robot: The machine.
        layout: Its hinges.
        freedoms: (x, w, alpha, beta), (..., 4) [m, m, rad, rad].
        gravity: In the frame of the lower gripper, (..., 3) [m/s2].
        payload: At the upper gripper's middle [kg].

    Returns:
        (moment; force) at the lower gripper's middle in its frame, and at the upper one's in its own,
        (..., 2, 6) [N m, N].
    """
    given, g = np.asarray(freedoms, dtype=np.float64), np.asarray(gravity, dtype=np.float64)
    mass, moment = first_moments(robot, layout, given, payload)
    x, w, alpha, beta = np.moveaxis(given, -1, 0)
    hz, c, s = robot.linkage.claw_offset, np.cos(alpha), np.sin(alpha)
    cb, sb = np.cos(beta), np.sin(beta)
    out = x + hz * s
    upper = np.stack((out * cb, out * sb, w + hz * c), axis=-1)
    turn = np.stack((
        np.stack((c * cb, c * sb, -s), axis=-1), np.stack((-sb, cb, np.zeros_like(cb)), axis=-1),
        np.stack((s * cb, s * sb, c), axis=-1),
    ), axis=-2)  # fmt: skip
    g = np.broadcast_to(g, moment.shape)
    lower = np.concatenate((np.cross(moment, g), mass * g), axis=-1)
    about = np.cross(moment - mass * upper, g)
    there = np.concatenate(((turn @ about[..., None])[..., 0], mass * (turn @ g[..., None])[..., 0]), axis=-1)
    return np.stack((lower, there), axis=-2)
