"""What holding alone takes of grips, cylinders and servo: against statics, closed forms, and with what moves."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from climb_cases import ROBOT, changed

from steeplejack.planning.climb.alone import along_way, either_way, uses_alone
from steeplejack.planning.climb.lattice import build_lattice
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import footing, trouble
from steeplejack.robots.pipe_climber.bars import linkage_bars, ring_radius, widest_turn
from steeplejack.robots.pipe_climber.bearing import holding_forces, servo_torques
from steeplejack.robots.pipe_climber.pads import BOTH, FIRST, LAST, STRAIGHT
from steeplejack.worksite.pipe_builtin import load_pipe

MACHINE = Machine.of(ROBOT, 0.2)
POSES = np.array([[0.0, 0.17, 0.0], [0.015, 0.19, 0.3], [-0.01, 0.16, -0.2]])
GRAVITY = np.array([[1.0, -3.0, -9.0], [-6.0, 2.0, -7.0], [5.0, 5.0, 5.0]])


def straight(count: int) -> tuple[np.ndarray, np.ndarray]:
    """What both grippers stand on where the pipe is straight."""
    return np.full((count, 2, 2), [0.03, BOTH]), np.broadcast_to(STRAIGHT, (count, 2, *STRAIGHT.shape))


def moved(machine: Machine, rates: float) -> tuple[np.ndarray, ...]:
    """States, gravity, pipes and what moves of the three poses, the speeds so many times the robot's."""
    quick = replace(machine, robot=changed(machine.robot, "gait", turn_speed=rates * machine.robot.gait.turn_speed))
    quick = replace(quick, robot=changed(quick.robot, "cylinders", speed=rates * quick.robot.cylinders.speed))
    ways = np.array([[[0.1, 1.0, 2.0], [-0.1, -1.0, 1.0]]] * 3)
    beta = np.array([0.0, 0.4, -0.3])
    freedoms = np.column_stack((POSES, beta))
    return freedoms, GRAVITY, *straight(3), either_way(quick, POSES, ways).at(np.arange(3), beta)


def test_drives_bear_the_weight_and_what_the_ramps_add():
    still = uses_alone(MACHINE, *moved(MACHINE, 1e-9))[..., 1:]
    freedoms, gravity, *pipes, (loads, drives) = moved(MACHINE, 1.0)
    forces = holding_forces(ROBOT, MACHINE.layout, freedoms, gravity, 0.2)
    torques = servo_torques(ROBOT, MACHINE.layout, freedoms, gravity, 0.2)
    np.testing.assert_allclose(still[..., 0], np.abs(forces).max(axis=-1) / ROBOT.cylinders.force, rtol=1e-6)
    np.testing.assert_allclose(still[..., 1], np.abs(torques) / ROBOT.build.servo_torque, rtol=1e-6)
    moving = uses_alone(MACHINE, freedoms, gravity, *pipes, (loads, drives))[..., 1:]
    worst = np.abs(forces) + np.abs(drives[..., :3]).max(axis=0)  # either way of either: signs agree in one of them
    np.testing.assert_allclose(moving[..., 0], worst.max(axis=-1) / ROBOT.cylinders.force)
    worst = np.abs(torques) + np.abs(drives[..., 3]).max(axis=0)
    np.testing.assert_allclose(moving[..., 1], worst / ROBOT.build.servo_torque)
    assert (moving[..., 0] > still[..., 0]).all() and (moving[..., 1] > still[..., 1]).all()


@pytest.mark.parametrize(
    ("table", "name", "scarce"), [("cylinders", "force", "force"), ("build", "servo_torque", "servo")]
)
def test_weak_cylinders_and_a_weak_servo_are_limits_of_their_own(table: str, name: str, scarce: str):
    run = replace(load_pipe("around"), goal_s=0.12)
    found = {
        weak: build_lattice(run, Machine.of(changed(ROBOT, table, **{name: weak})), 0.01).uses.scarce
        for weak in (0.05, 50.0)
    }
    assert found[0.05] - found[50.0] == {scarce}


def test_a_plan_counts_weight_inertia_and_reserve():
    """Up a vertical pipe it is the closed form: mass times g, and what accelerates, against friction less reserve."""
    pose, ways = np.array([[0.0, 0.175, 0.0]]), np.array([[[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]])
    gravity, still = np.array([[0.0, 0.0, -9.81]]), np.array([[0.0, 0.175, 0.0, 0.0]])
    machine = Machine.of(changed(ROBOT, "gait", reserve=0.2, turn_speed=1e-9))
    moving = either_way(machine, pose, ways).at(np.array([0]), np.zeros(1))
    used, pushes = uses_alone(machine, still, gravity, *straight(1), moving)[0, :, 0], moving[0]
    holds = ROBOT.gripper.friction * ROBOT.gripper.force * ROBOT.gripper.jaws
    for end in range(2):
        inertia = np.abs(pushes[:, 0, end, 5]).max()
        assert used[end] == pytest.approx((ROBOT.body.mass * 9.81 + inertia) / holds / 0.8, rel=2e-3)
    travel = np.column_stack((np.zeros(9), np.linspace(0.15, 0.2, 9), np.zeros(9), np.zeros(9)))
    assert machine.peaks[0] == pytest.approx(0.5 * math.pi * ROBOT.cylinders.speed / ROBOT.gait.ramp)
    np.testing.assert_allclose(np.abs(along_way(machine, travel)[0][0, 4]), np.abs(pushes[0, 0]), atol=1e-6)


def test_turning_takes_grip_of_its_own():
    pose, ways = np.array([[0.0, 0.175, 0.0]]), np.array([[[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]])
    gravity, still = np.array([[0.0, 0.0, -9.81]]), np.array([[0.0, 0.175, 0.0, 0.0]])
    used = [
        uses_alone(
            machine, still, gravity, *straight(1), either_way(machine, pose, ways).at(np.array([0]), np.zeros(1))
        )[0, 0, 0]
        for machine in (Machine.of(changed(ROBOT, "gait", turn_speed=speed)) for speed in (1e-9, 1.0, 2.0))
    ]
    assert used[0] < used[1] < used[2] and used[1] - used[0] > 0.02


def test_diameters_are_judged_under_the_rows_of_pads():
    run = load_pipe("reducer")
    pipe, step, half = run.pipes[0], run.pipes[0].parts[1].start, 0.5 * ROBOT.build.jaw_length
    s = step + np.array([-half - 1e-3, -half + 1e-3, 0.0, half - 1e-3, half + 1e-3])
    np.testing.assert_allclose(footing(MACHINE, pipe, s)[[0, 2, 4]], [[0.03, BOTH], [0.03, FIRST], [0.025, BOTH]])
    wrong = dict(trouble(run, MACHINE, pipe, s))["diameter"]
    assert wrong.tolist() == [False, True, False, True, False]  # a row of pads across the step
    assert footing(MACHINE, pipe, s)[2, 1] != LAST


def test_the_linkage_keeps_off_its_own_pipe():
    turn = widest_turn(ROBOT, 0.033)
    bars, radii = linkage_bars(ROBOT, turn)
    share = np.linspace(0.0, 1.0, 401)[:, None, None]
    places = bars[0, :, 0] + share * (bars[0, :, 1] - bars[0, :, 0])
    nearest = np.hypot(places[..., 0], places[..., 1]).min() - radii[0]
    assert nearest == pytest.approx(0.033, abs=1e-5) and float(ring_radius(ROBOT, turn)) == pytest.approx(0.033)
