"""What the plant lets its sensors see: delivered pulls, counted rates, angles that are not exact."""

import numpy as np
import pytest

from steeplejack.runtime import Command
from steeplejack.simulation import winch

STEPS = 2  # of physics in a control step of 1 ms


def command(pull: np.ndarray, brake: bool = False) -> Command:
    return Command(pull, np.zeros(4), np.zeros(4), np.ones(4, bool), np.full(4, brake))


def seen(plant, order: Command, count: int = 400) -> np.ndarray:
    """Readings at 1 kHz under one command (count, 7, 4)."""
    plant.apply(order)
    rows = np.empty((count, 7, 4))
    for row in rows:
        plant.advance(STEPS)
        row[:] = plant.measure().values
    return rows


def current_noise(squad) -> float:
    """Standard deviation of a measured pull [N]."""
    return squad.winch.current_noise * squad.winch.torque_constant * squad.winch.ratio / squad.winch.drum_radius


def test_a_winch_delivers_up_to_its_torque_and_nothing_on_its_brake(squad) -> None:
    most = squad.winch.max_torque * squad.winch.ratio / squad.winch.drum_radius
    pull, braked = np.array([3.0 * most, -3.0 * most, 100.0, 100.0]), np.array([False, False, False, True])
    delivered, scratch = np.full(4, np.nan), np.zeros((3, 4))
    lengths = np.full(4, 20.0)
    winch.advance(
        lengths,
        np.zeros(4),
        lengths.copy(),
        np.zeros(4),
        pull,
        braked,
        winch.constants(squad),
        5e-4,
        delivered,
        *scratch,
    )
    np.testing.assert_allclose(delivered, [most, -most, 100.0, 0.0])


def test_a_motor_at_its_limit_measures_the_limit(case) -> None:
    """Asked for five times what it can, a winch reports what it gives, not what it was asked."""
    plant, squad = case.plant(0, 0), case.squad
    most = squad.winch.max_torque * squad.winch.ratio / squad.winch.drum_radius
    # Few readings: the squad is being torn tight.
    pulls = seen(plant, command(np.full(4, 5.0 * most)), 40)[:, 2]
    scale = 1.0 + plant.sensors.errors[1]
    assert np.abs(pulls.mean(axis=0) - most * scale).max() < 5.0 * current_noise(squad) / np.sqrt(40)


def test_a_braked_motor_measures_nothing_but_noise(case) -> None:
    plant, squad = case.plant(0, 0), case.squad
    pulls = seen(plant, command(np.full(4, 200.0), brake=True))[:, 2]
    assert plant.tensions.min() > 10.0  # the brakes carry what the motors do not
    assert np.abs(pulls.mean(axis=0)).max() < 5.0 * current_noise(squad) / np.sqrt(len(pulls))
    assert pulls.std() == pytest.approx(current_noise(squad), rel=0.1)


def test_the_first_reading_is_of_the_squad_as_it_stands(case) -> None:
    plant, squad, at = case.plant(0, 0), case.squad, case.mission.legs[0].waypoints[0]
    reading = plant.measure()
    assert (reading.pay_rate == 0.0).all()
    assert (reading.s_rate == 0.0).all()
    np.testing.assert_allclose(reading.s, at.base_s_m, atol=squad.base.encoder_step)
    assert np.abs(reading.pull - np.array(at.tension_n) * (1.0 + plant.sensors.errors[1])).max() < 5.0 * current_noise(
        squad
    )


def test_wheel_rates_follow_a_drive_to_a_grain_and_the_drift(case) -> None:
    """A base pulled along by its wheels: the counted rate is the mean true rate over the period, whole grains of it."""
    leg = next(i for i, leg in enumerate(case.mission.legs) if leg.kind == "drive")
    base = case.mission.legs[leg].base - 1
    plant = case.plant(leg, 0)
    plant.palm[base] = 0.0
    plant._set_friction()
    order = command(plant.tensions.copy())
    order.grip[base], order.drive[base] = False, 140.0
    plant.apply(order)
    plant.measure()
    grain, drift = case.squad.base.encoder_step, plant.sensors.errors[0, base]
    before = plant.s[base]
    for _ in range(200):
        plant.advance(STEPS)
        rate = plant.measure().s_rate[base]
        true = (plant.s[base] - before) / 1e-3 * (1.0 + drift)
        before = plant.s[base]
        assert abs(rate - true) <= 1.0001 * grain / 1e-3
        assert abs(rate * 1e-3 / grain - np.round(rate * 1e-3 / grain)) < 1e-3
    assert abs(plant.measure().s_rate[base]) > 0.05


def test_gripped_bases_do_not_seem_to_creep(case) -> None:
    """At 1 kHz the counted rate of a loaded grip stays a tenth under the 20 mm/s that pass for a lost one."""
    rates = seen(case.plant(0, 0), command(np.zeros(4), brake=True), 1000)[:, 4]
    assert np.abs(rates).max() < 2e-3


def test_clock_angles_are_biased_and_noisy(case) -> None:
    plant, base = case.plant(0, 0), case.squad.base
    angles = seen(plant, command(np.zeros(4), brake=True))[:, 5]
    true = plant.data.qpos[plant._turn]
    error = angles.mean(axis=0) - true
    assert np.abs(error - plant.sensors.errors[2]).max() < 5.0 * base.clock_noise / np.sqrt(len(angles))
    assert angles.std(axis=0).min() > 0.9 * base.clock_noise
