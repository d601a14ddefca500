"""Every sensor error as the robot file states it, measured over many readings."""

from dataclasses import dataclass, field

import msgspec
import numpy as np
import pytest

from steeplejack.robots.squad import Squad
from steeplejack.runtime import Measurement
from steeplejack.simulation.sensors import Sensors, sense

PERIOD = 1e-3
START = np.array([24.0, 31.7, 55.25, 60.125])
CLOCK = np.array([-2.1, 0.3, 1.234, 2.9])


@dataclass
class World:
    """What there is to sense."""

    paid: np.ndarray = field(default_factory=lambda: np.array([9.1, 12.3, 18.7, 25.9]))
    pull: np.ndarray = field(default_factory=lambda: np.array([20.0, 80.0, 140.0, 250.0]))
    s: np.ndarray = field(default_factory=START.copy)
    clock: np.ndarray = field(default_factory=CLOCK.copy)
    palm: np.ndarray = field(default_factory=lambda: np.array([0.0, 100.0, 600.0, 600.0]))


def read(out: Measurement, sensors: Sensors, world: World, elapsed: float = PERIOD) -> None:
    sense(
        out.values, elapsed, world.paid, world.pull, world.s, START, world.clock, world.palm,
        sensors.noise(), sensors.errors, sensors.grains,
    )  # fmt: skip


def readings(sensors: Sensors, count: int) -> np.ndarray:
    """Many readings of a world at rest (count, 7, 4)."""
    out, world = Measurement(), World()
    read(out, sensors, world, 0.0)
    rows = np.empty((count, 7, 4))
    for row in rows:
        read(out, sensors, world)
        row[:] = out.values
    return rows


def changed(squad: Squad, **values: float) -> Squad:
    return msgspec.structs.replace(squad, base=msgspec.structs.replace(squad.base, **values))


def test_what_is_drawn_once_has_the_stated_spread(squad: Squad) -> None:
    """800 bases: scale errors of odometry and torque constant, bias of the inclinometer."""
    errors = np.hstack([Sensors(squad, np.random.default_rng(seed)).errors for seed in range(200)])
    stated = np.array([squad.base.odometry_drift, squad.winch.torque_scale_error, squad.base.clock_bias])
    assert errors.std(axis=1) == pytest.approx(stated, rel=0.1)
    assert (np.abs(errors.mean(axis=1)) < 4.0 * stated / np.sqrt(800)).all()


def test_noise_has_the_stated_spread_about_what_is_drawn_once(squad: Squad, rng: np.random.Generator) -> None:
    sensors, world, count = Sensors(squad, rng), World(), 5000
    base, winch = squad.base, squad.winch
    rows = readings(sensors, count)
    _odometry, torque, bias = sensors.errors
    current = winch.current_noise * winch.torque_constant * winch.ratio / winch.drum_radius
    # A resolution fine against the noise adds its own variance, step^2 / 12.
    clock = np.hypot(base.clock_noise, base.clock_step / np.sqrt(12.0))
    for row, mean, spread in (
        (2, world.pull * (1.0 + torque), current),
        (5, world.clock + bias, clock),
        (6, world.palm, squad.gripper.palm_noise),
    ):
        assert rows[:, row].std(axis=0) == pytest.approx(np.full(4, spread), rel=0.05)
        assert (np.abs(rows[:, row].mean(axis=0) - mean) < 5.0 * spread / np.sqrt(count)).all()


def test_noise_is_white(squad: Squad, rng: np.random.Generator) -> None:
    """Across the blocks it is drawn in too: neighbouring readings and different sensors do not go together."""
    noise = readings(Sensors(squad, rng), 3000)[:, (2, 5, 6)].reshape(3000, 12)
    together = np.corrcoef(np.hstack([noise[1:], noise[:-1]]).T)
    assert np.abs(together - np.eye(24)).max() < 0.1


def test_clock_angles_come_in_steps(squad: Squad, rng: np.random.Generator) -> None:
    counts = readings(Sensors(squad, rng), 500)[:, 5] / squad.base.clock_step
    assert np.abs(counts - np.round(counts)).max() < 1e-6
    assert (np.array([len(np.unique(np.round(column))) for column in counts.T]) > 3).all()


def test_encoders_are_quantised_and_nothing_else(squad: Squad, rng: np.random.Generator) -> None:
    """Without drift, positions are within half a grain of the truth and whole grains from where they count from."""
    sensors, out, world = Sensors(changed(squad, odometry_drift=0.0), rng), Measurement(), World()
    winch, wheel, _clock = sensors.grains
    assert winch == pytest.approx(
        2.0 * np.pi * squad.winch.drum_radius / squad.winch.ratio / squad.winch.encoder_counts
    )
    assert wheel == squad.base.encoder_step
    for _ in range(200):
        world.paid, world.s = rng.uniform(5.0, 60.0, 4), rng.uniform(5.0, 90.0, 4)
        read(out, sensors, world)
        for seen, true, origin, grain in ((out.paid, world.paid, 0.0, winch), (out.s, world.s, START, wheel)):
            assert np.abs(seen - true).max() <= 0.5 * grain + 1e-12
            counts = (seen - origin) / grain
            assert np.abs(counts - np.round(counts)).max() < 1e-6


def test_odometry_drifts_with_the_distance_driven(squad: Squad, rng: np.random.Generator) -> None:
    sensors, out, world = Sensors(squad, rng), Measurement(), World()
    for distance in (0.0, -7.5, 30.0):
        world.s = START + distance
        read(out, sensors, world)
        assert np.abs(out.s - world.s - sensors.errors[0] * distance).max() <= 0.5 * squad.base.encoder_step + 1e-12


@pytest.mark.parametrize("speed", [0.0, 3e-4, -0.02, 0.5, 1.0])
def test_rates_are_what_the_encoders_count(squad: Squad, rng: np.random.Generator, speed: float) -> None:
    """Whole grains a period, off by less than one grain, and their mean is the speed the encoder went."""
    sensors, out, world, steps = Sensors(squad, rng), Measurement(), World(), 400
    read(out, sensors, world, 0.0)
    rates = np.empty((steps, 2, 4))
    for row in rates:
        world.paid, world.s = world.paid + speed * PERIOD, world.s + speed * PERIOD
        read(out, sensors, world)
        row[:] = out.pay_rate, out.s_rate
    true = np.array([np.full(4, speed), speed * (1.0 + sensors.errors[0])])
    grains = sensors.grains[:2, None] / PERIOD
    counts = rates / grains
    assert np.abs(counts - np.round(counts)).max() < 1e-4
    assert (np.abs(rates - true) < grains * (1.0 + 1e-4)).all()
    assert (np.abs(rates.mean(axis=0) - true) <= grains / steps * (1.0 + 1e-4)).all()


def test_a_coarse_wheel_encoder_steps_the_rate(squad: Squad, rng: np.random.Generator) -> None:
    """0.1 mm grains at 1 kHz: a base at 20 mm/s reads 0 or 100 mm/s."""
    sensors, out, world = Sensors(changed(squad, encoder_step=1e-4), rng), Measurement(), World()
    read(out, sensors, world, 0.0)
    seen = set()
    for _ in range(100):
        world.s = world.s + 0.02 * PERIOD
        read(out, sensors, world)
        seen |= set(np.round(out.s_rate, 6))
    assert seen == {0.0, 0.1}


def test_a_second_look_at_the_same_time_keeps_the_rates(squad: Squad, rng: np.random.Generator) -> None:
    sensors, out, world = Sensors(squad, rng), Measurement(), World()
    read(out, sensors, world, 0.0)
    assert (out.values[[1, 4]] == 0.0).all()
    world.s, world.paid = world.s + 1e-3, world.paid - 1e-3
    read(out, sensors, world)
    rates = out.values[[1, 4]].copy()
    read(out, sensors, world, 0.0)
    np.testing.assert_array_equal(out.values[[1, 4]], rates)


def test_the_same_seed_senses_the_same(squad: Squad) -> None:
    one, two = (readings(Sensors(squad, np.random.default_rng(5)), 20) for _ in range(2))
    np.testing.assert_array_equal(one, two)
