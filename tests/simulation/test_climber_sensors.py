"""What the climber's sensors get wrong: drawn from a seed within tolerances, read as declared, and climbed with."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hung_climber import GRAVITY, LAYOUT, ROBOT, nothing, started, strides

from steeplejack.simulation.climber import sensors
from steeplejack.simulation.climber.plant import ClimberPlant, Start
from steeplejack.simulation.climber.sensors import SensorErrors
from steeplejack.simulation.climber.solids import Solid


def test_errors_are_those_of_their_seed_and_within_their_tolerances() -> None:
    def drawn(seed: int, times: float = 1.0) -> np.ndarray:
        one = SensorErrors.drawn(np.random.default_rng(seed), times)
        return np.concatenate([one.encoder, one.zero, one.current, one.servo, one.grip, one.passed, one.lean])

    most = np.repeat(
        [sensors.ENCODER, sensors.ZERO, sensors.CURRENT, sensors.SERVO, sensors.SERVO_ZERO, sensors.GRIP,
         sensors.PASSED, sensors.LEAN], [3, 3, 3, 1, 1, 2, 2, 2],
    )  # fmt: skip
    many = np.array([drawn(seed) for seed in range(200)])
    assert np.array_equal(drawn(7), drawn(7)) and not np.array_equal(drawn(7), drawn(8))
    assert (np.abs(many) <= most).all() and (np.abs(many).max(axis=0) > 0.9 * most).all()
    assert np.allclose(drawn(3, 2.0), 2.0 * drawn(3)) and not drawn(3, 0.0).any()


def test_a_sensor_says_the_truth_with_its_errors() -> None:
    pipe = Solid("pipe", "cylinder", np.array([0.0, 0.0, -0.5]), np.array([0.0, 0.0, 2.0]), 0.03)
    start = Start(np.eye(4), np.array([0.0, 0.19, 0.0, 0.2]), np.full(2, 0.03))
    errors = SensorErrors(
        encoder=np.array([1e-2, -1e-2, 0.0]), zero=np.array([0.0, 1e-3, 0.0]), current=np.array([0.1, 0.0, -0.1]),
        servo=np.array([0.1, 0.05]), grip=np.array([0.1, -0.2]), lean=np.array([0.01, -0.02]),
    )  # fmt: skip
    wrong, right = (
        ClimberPlant(ROBOT, LAYOUT, [pipe], GRAVITY, start, (0.3, 0.3), 0.0, each) for each in (errors, None)
    )
    for plant in (wrong, right):
        plant.advance(100)
    said, true = wrong.measure(), right.measure()
    out = true.lengths - np.array(ROBOT.cylinders.retracted)
    assert said.lengths - true.lengths == pytest.approx(errors.encoder * out + errors.zero, abs=1.1e-5)
    assert said.forces == pytest.approx([1.1, 1.0, 0.9] * true.forces)
    assert said.beta == pytest.approx(1.1 * true.beta + 0.05, abs=1.1 * ROBOT.build.angle_step)
    assert said.grip == pytest.approx([1.1, 0.8] * true.grip)
    assert true.gravity == pytest.approx(GRAVITY, abs=1e-3)
    leant = math.acos(said.gravity @ true.gravity / np.linalg.norm(said.gravity) / 9.81)
    assert leant == pytest.approx(math.hypot(0.01, 0.02), rel=1e-3)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_a_climb_keeps_its_bounds_whatever_the_sensors_get_wrong(seed: int) -> None:
    course, plant, watch = started(strides(2), seed=seed)
    before = plant.truth().lower
    end = course.run(nothing)
    assert end.completed and end.safe and end.slips == 0 and end.collisions == 0
    closed = [grip for grip in watch.grips if grip.phase > 0]
    assert max(grip.error_m for grip in closed) < 2e-4
    assert max(grip.error_rad for grip in closed) < math.radians(0.1)
    assert plant.truth().lower[2, 3] - before[2, 3] == pytest.approx(0.1, abs=4e-4)
    moving = [one for sample in watch.samples if sample.act == "move" for one in sample.margin if one is not None]
    assert min(moving) > 0.15
