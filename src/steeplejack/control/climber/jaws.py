"""Where the pads of a jaw stand when they touch a pipe: two of them beside the jaw's middle, so they wedge it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber import PipeClimber


def pad_place(robot: PipeClimber, radius: float) -> float:
    """How far pads stand from the gripper's axis, along the way of the jaws, when they touch a pipe.

    Pads of radius r_p, half a jaw's width b to either side, touch a pipe of radius r at ``sqrt((r + r_p)^2 - b^2)``.

    Args:
        robot: The machine.
        radius: Of the pipe [m].

    Returns:
        [m].

    Raises:
        InputError: A pipe so thin that it would slip between the pads of one jaw.
    """
    reach, half = radius + robot.build.pad_radius, 0.5 * robot.build.jaw_width
    if not reach > half:
        raise InputError("pipe radius", f"{radius:g} m", f"above {half - robot.build.pad_radius:g} m")
    return math.sqrt(reach**2 - half**2)


def open_place(robot: PipeClimber, radius: float) -> float:
    """Where pads stand when open beside a pipe of a radius [m]."""
    return pad_place(robot, radius) + robot.build.jaw_clearance


def pipe_radius(robot: PipeClimber, place: ArrayLike) -> NDArray[np.float64]:
    """Radius of the pipe that pads touch where they stand so far from the axis, (...) [m]: inverse of `pad_place`."""
    return np.hypot(np.asarray(place, dtype=np.float64), 0.5 * robot.build.jaw_width) - robot.build.pad_radius
