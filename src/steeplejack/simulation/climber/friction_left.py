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
from steeplejack.planning.climb.plan import Phase
from steeplejack.robots.pipe_climber import PipeClimber
from steeplejack.robots.pipe_climber.pads import BOTH, FIRST, LAST, grip_body, grip_use, pad_clock, pad_row
from steeplejack.simulation.climber.truth import Truth
from steeplejack.worksite.pipe_run import PipeRun

THIN = 0.1  # [1] by how much thinner than the thinnest pipe jaws may close and still press on one: at its very end
SAME = 1e-4  # [m] radii of pipe that share one body


def declared_press(robot: PipeClimber, radius: float) -> float:
    """What both jaws of a closed gripper press with along their way on a pipe of a radius, ``2 F cos phi`` [N]."""
    return robot.gripper.jaws * robot.gripper.force * math.cos(pad_clock(robot, radius))


def resting_rows(robot: PipeClimber, run: PipeRun, phase: Phase) -> tuple[int, int]:
    """Which rows of pads of the lower and the upper gripper rest on the pipe where a phase begins.

    Of rows on two diameters those on the larger one.
    """

    def rows(pipe: str, s: float) -> int:
        first, last = (float(run.radius(s + sign * pad_row(robot), pipe)) for sign in (-1.0, 1.0))
        return BOTH if first == last else FIRST if first > last else LAST

    return rows(phase.pipe_lower, phase.s_lower), rows(phase.pipe_upper, phase.s_upper)


class FrictionLeft:
    """Friction left to both grippers.

    Args:
        robot: The machine.
        friction: Of the pads of the lower and of the upper gripper [1].
    """

    def __init__(self, robot: PipeClimber, friction: tuple[float, float]) -> None:
        self._robots = [replace(robot, gripper=replace(robot.gripper, friction=mu)) for mu in friction]
        self._bodies: dict[tuple[int, int, int], Array] = {}

    def __call__(self, truth: Truth, radii: Array, rows: tuple[int, int]) -> Array:
        """What is left to each.

        Args:
            truth: The robot now.
            radii: Of the pipe in either gripper (2,) [m].
            rows: Of pads that rest on it, as `robots.pipe_climber.pads` counts them.

        Returns:
            (2,), 1 where nothing is asked of a gripper, 0 at the limit, NaN where it presses on no pipe that it is made
            for [1].
        """
        left = np.full(2, np.nan)
        for end in range(2):
            radius, robot = float(radii[end]), self._robots[end]
            if truth.press[end] <= 0.0 or radius < 0.5 * (1.0 - THIN) * robot.gripper.pipe_diameter[0]:
                continue
            use = float(grip_use(self._body(end, radius, rows[end]), -truth.wrench[end]))
            left[end] = 1.0 - use * declared_press(robot, radius) / truth.press[end]
        return left

    def _body(self, end: int, radius: float, rows: int) -> Array:
        """`grip_body` of a gripper, made once a radius and rows."""
        key = end, round(radius / SAME), rows
        if key not in self._bodies:
            self._bodies[key] = grip_body(self._robots[end], radius, rows)
        return self._bodies[key]
