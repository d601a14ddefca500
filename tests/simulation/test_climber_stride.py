"""One stride of the climber in physics: tracking, forces and friction against statics; grips that cannot hold."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace as with_gravity
from pathlib import Path

import numpy as np
import pytest
from hung_climber import GRAVITY, LAYOUT, ROBOT, RUN, hung, leaning, nothing, started, strides
from msgspec.structs import replace

from steeplejack.robots.pipe_climber.bearing import holding_forces
from steeplejack.robots.pipe_climber.pads import grip_body, grip_use
from steeplejack.robots.pipe_climber.weights import grip_loads
from steeplejack.runtime.climb_record import ClimbSample
from steeplejack.simulation.climber.plant import ClimberPlant
from steeplejack.simulation.climber.watch import PRESSED, STILL, Watch

BOUND = tomllib.loads((Path(__file__).parents[1] / "reference" / "pipe_climber.toml").read_text())["climbing"]["speed"]


def least_left(watch: Watch) -> float:
    """Least friction left to a gripper counted on."""
    return min(one for sample in watch.samples for one in sample.margin if one is not None)


def coasting(samples: list[ClimbSample], holds: int) -> list[ClimbSample]:
    """Samples of a move at constant speed, one gripper holding alone."""
    moves = [one for one in samples if one.act == "move" and one.closed[holds] and not one.closed[1 - holds]]
    return moves[len(moves) // 4 : -len(moves) // 4]


def test_a_stride_tracks_its_plan_and_its_forces_are_those_of_statics() -> None:
    """50 mm at 17 mm/s: 95 % of the bound, 1 mm and 0.5 degrees where grippers close, forces and friction to 5 %."""
    course, plant, watch = started(strides(1))
    before = plant.truth()
    end = course.run(nothing)
    assert end.completed and end.safe and end.slips == 0 and end.collisions == 0
    rise = plant.truth().lower[2, 3] - before.lower[2, 3]
    assert rise == pytest.approx(0.050, abs=5e-4)
    assert 0.95 * BOUND <= rise / end.duration_s <= BOUND
    assert end.travelled_m == pytest.approx(rise, abs=1e-4)
    closed = [grip for grip in watch.grips if grip.phase > 0]
    assert [grip.gripper for grip in closed] == ["upper", "lower"]
    assert max(grip.error_m for grip in closed) < 1e-3
    assert max(grip.error_rad for grip in closed) < math.radians(0.5)
    assert min(grip.force_n for grip in closed) >= 0.9 * ROBOT.gripper.force
    assert max(max(sample.slip_m) for sample in watch.samples) < 2e-4
    assert max(max(map(abs, sample.speeds_m_s)) for sample in watch.samples) < 1.05 * ROBOT.cylinders.speed
    assert least_left(watch) > 0.15
    for holds in range(2):
        statics_hold(coasting(watch.samples, holds), holds)


def statics_hold(samples: list[ClimbSample], holds: int, gravity: np.ndarray = GRAVITY, mu: float = 0.3) -> None:
    """Forces of the cylinders are the static Jacobian's, friction used is what the balance over the pads asks for.

    Their means: a grain of an encoder makes a rod's force jump by a newton.
    """
    robot = replace(ROBOT, gripper=replace(ROBOT.gripper, friction=mu))
    poses = np.array([one.actual for one in samples])
    assert len(samples) > 50
    expected = np.mean([holding_forces(ROBOT, LAYOUT, pose, gravity)[holds] for pose in poses], axis=0)
    forces = np.mean([one.forces_n for one in samples], axis=0)
    assert np.abs(forces - expected).max() < 0.05 * np.abs(expected).max()
    used = np.mean([1.0 - (one.margin[holds] or 0.0) for one in samples])
    asked = grip_use(grip_body(robot, 0.03), grip_loads(ROBOT, LAYOUT, poses, gravity)[:, holds]).mean()
    assert used == pytest.approx(asked, rel=0.05)


@pytest.mark.long
@pytest.mark.parametrize(("lean", "clock"), [(0.25, 0.0), (0.5, 0.9), (0.5, -2.2)])
def test_a_stride_up_a_leaning_pipe_tracks_and_its_forces_are_those_of_statics(lean: float, clock: float) -> None:
    """Pipes 45 and 90 degrees off the vertical, toward several clocks of the robot."""
    gravity, mu = leaning(lean * math.pi, clock), 1.0
    course, _plant, watch = started(strides(1), mu, run=with_gravity(RUN, gravity=tuple(gravity)))
    end = course.run(nothing)
    assert end.completed and end.safe and end.slips == 0
    closed = [grip for grip in watch.grips if grip.phase > 0]
    assert max(grip.error_m for grip in closed) < 1e-3
    assert max(grip.error_rad for grip in closed) < math.radians(0.5)
    for holds in range(2):
        statics_hold(coasting(watch.samples, holds), holds, gravity, mu)


def fastest(plant: ClimberPlant, steps: int) -> float:
    """Of either gripper, over 20 ms, while time goes on [m/s]."""
    speeds = list[float]()
    for _ in range(steps):
        before = plant.truth()
        plant.advance(40)
        after = plant.truth()
        speeds += [float(np.linalg.norm(b[:3, 3] - a[:3, 3])) / 0.02
                   for a, b in ((before.lower, after.lower), (before.upper, after.upper))]  # fmt: skip
    return max(speeds)


def test_grippers_that_cannot_hold_end_the_climb_safely() -> None:
    """At mu = 0.2 one gripper cannot bear 2 kg and two can: the slip is seen, met, and nothing falls."""
    course, plant, watch = started(strides(1), mu=0.2)
    before = plant.truth()
    end = course.run(nothing)
    assert not end.completed and end.safe
    assert "slip" in end.why and end.slips >= 2
    assert -1e-3 < least_left(watch) < 1e-2
    assert np.linalg.norm(plant.truth().lower[:3, 3] - before.lower[:3, 3]) < 0.03
    assert plant.truth().normal.min() > PRESSED * 2.0 * ROBOT.gripper.force
    still = plant.truth().lower[2, 3]
    assert fastest(plant, 25) < STILL
    assert abs(plant.truth().lower[2, 3] - still) < 1e-4


def test_what_slides_on_two_closed_grippers_does_not_hang() -> None:
    """Two grippers hold 2 kg from mu = 0.123 on; below that the end is no safe one, and the run says so."""
    course, _plant, _watch = started(strides(1), mu=0.1)
    end = course.run(nothing)
    assert not end.completed and not end.safe


def test_one_closed_gripper_is_no_end() -> None:
    for closed in ((True, True), (True, False), (False, True)):
        plant = hung(closed)
        plant.advance(100)
        assert Watch(plant, RUN, None).hanging is all(closed)
