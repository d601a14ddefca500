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

SAME = 1e-4  # [m] radii of pipe that share one body


class FrictionLeft:
    """Friction left to both grippers.

    Args:
        robot: The machine.
        friction: Of the pads of the lower and of the upper gripper [1].
    """

    def __init__(self, robot: PipeClimber, friction: tuple[float, float]) -> None:
        self._robots = [replace(robot, gripper=replace(robot.gripper, friction=mu)) for mu in friction]
        self._bodies: dict[tuple[int, int], Array] = {}

    def __call__(self, truth: Truth, radii: Array) -> Array:
        """What is left to each.

        Args:
            truth: The robot now.
            radii: Of the pipe in either gripper (2,) [m].

        Returns:
            (2,), 1 where nothing is asked of a gripper, 0 at the limit, NaN where it does not press [1].
        """
        left = np.full(2, np.nan)
        for end in range(2):
            if truth.press[end] <= 0.0:
                continue
            radius, gripper = float(radii[end]), self._robots[end].gripper
            declared = gripper.jaws * gripper.force * math.cos(pad_clock(self._robots[end], radius))
            use = float(grip_use(self._body(end, radius), -truth.wrench[end]))
            left[end] = 1.0 - use * declared / truth.press[end]
        return left

    def _body(self, end: int, radius: float) -> Array:
        """`grip_body` of a gripper, made once a radius."""
        key = end, round(radius / SAME)
        if key not in self._bodies:
            self._bodies[key] = grip_body(self._robots[end], radius)
        return self._bodies[key]
