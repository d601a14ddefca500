"""How much friction is left to a gripper in physics: what its pads really bear against what they could.

The wrench of the pipe on a gripper, force and moment as its pads make them, is set against the body of wrenches that
pads give (`robots.pipe_climber.pads`); what is left is ``1 - u``. That body is for the force a gripper is declared to
press with and grows with it, so u counts in parts of what the jaws really press with. Its cones have 16 edges and are
inscribed, so that pads at their limit in a direction between two of them give up to 2 % less than nothing left.
"""

from __future__ import annotations

import math

import numpy as np
from msgspec.structs import replace

from steeplejack.control.climber.signals import Array
from steeplejack.robots.pipe_climber import PipeClimber
from steeplejack.robots.pipe_climber.pads import grip_body, grip_use, pad_clock
from steeplejack.simulation.climber.truth import Truth


def declared_press(robot: PipeClimber, radius: float) -> float:
    """What both jaws of a closed gripper press with along their way on a pipe of a radius, ``2 F cos phi`` [N]."""
    return robot.gripper.jaws * robot.gripper.force * math.cos(pad_clock(robot, radius))


class FrictionLeft:
    """Friction left to both grippers.

    Args:
        robot: The machine.
        friction: Of the pads of the lower and of the upper gripper [1].
    """

    def __init__(self, robot: PipeClimber, friction: tuple[float, float]) -> None:
        self._robots = [replace(robot, gripper=replace(robot.gripper, friction=mu)) for mu in friction]
        self._bodies: dict[tuple[int, float, int], Array] = {}

    def __call__(self, truth: Truth, radii: Array, rows: tuple[int, int]) -> Array:
        """What is left to each.

        Args:
            truth: The robot now.
            radii: Of the pipe under either gripper (2,) [m].
            rows: Of pads that rest on it; see `pipe.resting`.

        Returns:
            (2,), 1 where nothing is asked of a gripper, 0 at the limit, NaN where it does not press [1].
        """
        left = np.full(2, np.nan)
        for end in range(2):
            if truth.press[end] <= 0.0:
                continue
            radius = float(radii[end])
            use = float(grip_use(self._body(end, radius, rows[end]), -truth.wrench[end]))
            left[end] = 1.0 - use * declared_press(self._robots[end], radius) / truth.press[end]
        return left

    def _body(self, end: int, radius: float, rows: int) -> Array:
        """`grip_body` of a gripper, made once a radius and rows."""
        key = end, radius, rows
        if key not in self._bodies:
            self._bodies[key] = grip_body(self._robots[end], radius, rows)
        return self._bodies[key]
