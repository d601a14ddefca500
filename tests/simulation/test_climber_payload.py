"""Loads on the upper gripper: weighed by the model, carried up to what statics allow, and no further."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from hung_climber import GRAVITY, LAYOUT, ROBOT, RUN, nothing, strides

from steeplejack.robots.pipe_climber.bearing import holding_forces
from steeplejack.robots.pipe_climber.pads import grip_body, grip_use
from steeplejack.robots.pipe_climber.weights import grip_loads
from steeplejack.runtime.climb_record import EndRecord
from steeplejack.simulation.climber.run import ClimbRun
from steeplejack.simulation.climber.session import ClimbSession
from steeplejack.simulation.climber.watch import Watch

pytestmark = pytest.mark.long


def carried(payload: float, mu: float) -> EndRecord:
    """How one stride with a load ends."""
    plan = strides(1)
    plant = ClimbSession(plan, RUN, ROBOT, LAYOUT, (mu, mu), payload).plant()
    assert plant.model.body_mass.sum() == pytest.approx(ROBOT.body.mass + payload)
    return ClimbRun(plan, RUN, ROBOT, LAYOUT, plant, Watch(plant, RUN, None)).run(nothing)


def grip_taken(payload: float, mu: float) -> float:
    """By statics, how much of a grip the robot and its load take."""
    robot = msgspec.structs.replace(ROBOT, gripper=msgspec.structs.replace(ROBOT.gripper, friction=mu))
    pose = np.array([0.0, 0.175, 0.0, 0.0])
    return float(grip_use(grip_body(robot, 0.03), grip_loads(robot, LAYOUT, pose, GRAVITY, payload)).max())


def test_physics_carries_nine_tenths_of_the_grip_and_not_one_and_a_tenth() -> None:
    mu = 0.4
    for payload, holds in ((0.90, True), (1.65, False)):
        assert (grip_taken(payload, mu) < 0.91) is holds
        end = carried(payload, mu)
        assert (end.completed and end.slips == 0) is holds
        assert end.safe


def test_cylinders_too_weak_end_the_climb_safely() -> None:
    payload = 7.0
    forces = holding_forces(ROBOT, LAYOUT, np.array([0.0, 0.175, 0.0, 0.0]), GRAVITY, payload)
    assert np.abs(forces).max() > ROBOT.cylinders.force
    end = carried(payload, 1.5)
    assert not end.completed and end.safe and ("cylinder" in end.why or "not done" in end.why)
