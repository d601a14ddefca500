"""Where open jaws stand beside a pipe, and which pipe closed ones stand on."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.robots.pipe_climber import PipeClimber
from steeplejack.robots.pipe_climber.pads import pad_place


def open_place(robot: PipeClimber, radius: float) -> float:
    """Where pads stand when open beside a pipe of a radius [m]."""
    return pad_place(robot, radius) + robot.build.jaw_clearance


def pipe_radius(robot: PipeClimber, place: ArrayLike) -> NDArray[np.float64]:
    """Radius of the pipe that pads touch where they stand so far from the axis, (...) [m]: see `pads.pad_place`."""
    return np.hypot(np.asarray(place, dtype=np.float64), 0.5 * robot.build.jaw_width) - robot.build.pad_radius
