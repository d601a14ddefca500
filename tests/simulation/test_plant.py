"""The physics against the laws it must obey and against the planner's statics."""

import mujoco
import numpy as np
import pytest

from steeplejack.robots.squad.anchorage import exits
from steeplejack.runtime.plant import Command
from steeplejack.simulation import winch
from steeplejack.simulation.scene import rail


def parked(plant) -> Command:
    """Brakes on, palms closed."""
    return Command(plant.tensions.copy(), np.zeros(4), np.zeros(4), np.ones(4, bool), np.ones(4, bool))


def test_compiled_model_has_the_declared_machine(case) -> None:
    plant = case.plant(0, 0)
    model, squad = plant.model, case.squad
    assert model.body("platform").mass[0] == pytest.approx(squad.platform.mass)
    for i in range(1, 5):
        assert model.body(f"base{i}").mass[0] == pytest.approx(squad.base.mass)
        assert model.dof_frictionloss[model.joint(f"along{i}").dofadr[0]] == pytest.approx(squad.base.hold_force)
        assert model.dof_frictionloss[model.joint(f"turn{i}").dofadr[0]] == pytest.approx(squad.base.twist_torque)
    start = case.mission.legs[0].waypoints[0]
    points, _tangents, _arms = exits(
        case.bay, squad, np.array(start.base_s_m), np.radians(np.array(start.base_clock_deg))
    )
    assert np.abs(plant.truth().exits - points).max() < 1e-5


def test_rail_follows_the_sagging_axis(case) -> None:
    k = case.bay.carriers[0]
    stay = case.bay.stays[k]
    track = rail(case.bay, k, 20.0, 70.0)
    for s in np.linspace(20.0, 70.0, 11):
        x = track.x(s)
        point = track.origin + track.axes @ np.array([x, track.y(x), 0.0])
        assert np.linalg.norm(point - stay.position(s)) < 1e-4


@pytest.mark.parametrize("kind", ["inspect", "fly", "drive"])
def test_predicted_equilibria_are_where_physics_settles(case, kind: str) -> None:
    leg = next(i for i, leg in enumerate(case.mission.legs) if leg.kind == kind)
    for point in (0, len(case.mission.legs[leg].waypoints) // 2):
        plant = case.plant(leg, point)
        wanted = case.mission.legs[leg].waypoints[point]
        plant.apply(parked(plant))
        plant.advance(6000)
        truth = plant.truth()
        assert np.linalg.norm(truth.position - np.array(wanted.position_m)) < 5e-4
        assert np.abs(truth.tension - np.array(wanted.tension_n)).max() < 0.5


def test_a_disturbed_platform_returns(case) -> None:
    """Stability of a certified equilibrium, in physics: pushed out of the plane it swings back."""
    plant = case.plant(0, 5)
    plant.apply(parked(plant))
    start = plant.truth().position.copy()
    plant.data.qvel[plant._free_dof : plant._free_dof + 3] = 0.05
    plant.advance(20000)
    assert np.linalg.norm(plant.truth().position - start) < 0.15


def test_grip_creeps_less_than_a_tenth_of_a_millimetre_a_minute(case) -> None:
    plant = case.plant(0, 0)
    plant.apply(parked(plant))
    plant.advance(2000)
    before = plant.s
    plant.advance(20000)
    assert np.abs(plant.s - before).max() * 60.0 / 10.0 < 1e-4


def test_grip_holds_to_its_limit_and_slips_beyond_it(case) -> None:
    plant = case.plant(0, 0)
    base, hold = 0, case.squad.base.hold_force
    pull = float(np.sum(plant.truth().tension[base] * _along(plant, case, base)))
    for share, slips in ((0.97, False), (1.05, True)):
        plant = case.plant(0, 0)
        plant.apply(parked(plant))
        before = plant.s[base]
        plant.data.qfrc_applied[plant._along_dof[base]] = np.sign(pull) * share * hold - pull
        plant.advance(400)
        assert (abs(plant.s[base] - before) > 1e-3) == slips


def _along(plant, case, base: int) -> float:
    truth = plant.truth()
    end = truth.position + truth.rotation @ np.array(case.squad.platform.attachments[base])
    towards = end - truth.exits[base]
    return float(towards / np.linalg.norm(towards) @ plant.rails[base].axes[:, 0])


def test_a_slack_cable_never_pushes() -> None:
    rng = np.random.default_rng(2)
    for _ in range(500):
        length, paid = rng.uniform(5, 30, 2)
        rate, pay_rate = rng.normal(size=2) * 5
        tension = winch.tension(length, rate, paid, pay_rate, 2e5, 0.01)
        assert tension >= 0.0
        if length <= paid:
            assert tension == 0.0


def test_paying_out_leaves_cables_slack_without_force(case) -> None:
    plant = case.plant(0, 0)
    plant.paid += 0.5
    plant.apply(parked(plant))
    plant.advance(20)
    assert (plant.tensions == 0.0).all()


def test_brakes_hold_what_the_motor_does_not(case) -> None:
    plant = case.plant(0, 0)
    plant.apply(Command(np.zeros(4), np.zeros(4), np.zeros(4), np.ones(4, bool), np.ones(4, bool)))
    before = plant.paid.copy()
    plant.advance(2000)
    assert np.abs(plant.paid - before).max() < 1e-9


def test_energy_is_kept_without_friction_drag_or_damping(case) -> None:
    """Platform on locked elastic cables, bases frozen: kinetic, elastic and gravity energy add up to a constant."""
    plant = case.plant(0, 4)
    plant.model.opt.density = 0.0
    plant._constants[1] = 0.0
    plant.model.dof_frictionloss[np.concatenate([plant._along_dof, plant._turn_dof])] = 1e6
    plant.apply(parked(plant))
    plant.data.qvel[plant._free_dof : plant._free_dof + 3] = 0.4
    plant.data.qvel[plant._free_dof + 3 : plant._free_dof + 6] = [0.5, -0.7, 0.3]
    ea = case.squad.cable.axial_stiffness

    def energy() -> float:
        mujoco.mj_energyVel(plant.model, plant.data)
        mujoco.mj_energyPos(plant.model, plant.data)
        stretch = np.maximum(plant.data.ten_length - plant.paid, 0.0)
        return float(plant.data.energy.sum() + np.sum(0.5 * ea / plant.paid * stretch**2))

    plant.advance(1)
    mujoco.mj_forward(plant.model, plant.data)
    first, kinetic = energy(), plant.data.energy[1]
    worst = 0.0
    for _ in range(100):
        plant.advance(40)
        mujoco.mj_forward(plant.model, plant.data)
        worst = max(worst, abs(energy() - first))
    assert worst < 0.02 * kinetic


def test_a_stop_in_the_middle_of_a_drive_holds_the_open_base(case) -> None:
    """Palms open, base under way at speed: brakes of winches and wheels stop it within centimetres, no cable slack."""
    leg = next(i for i, leg in enumerate(case.mission.legs) if leg.kind == "drive")
    base = case.mission.legs[leg].base - 1
    plant = case.plant(leg, len(case.mission.legs[leg].waypoints) // 2)
    plant.palm[base] = 0.0
    plant._set_friction()
    plant.data.qvel[plant._along_dof[base]] = case.squad.motion.drive_speed
    before = plant.s
    stop = parked(plant)
    stop.wheel_brake[:] = True
    plant.apply(stop)
    plant.extremes()
    plant.advance(12000)
    assert np.abs(plant.s - before).max() < 0.15
    assert plant.extremes()[0].min() > 0.0
