"""What a pose and a grip have to hold: cylinders and servo against statics at every clock, grips with what moves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from climb_cases import ROBOT, changed

from steeplejack.planning.climb.grip import alone, along_way, either_way
from steeplejack.planning.climb.limits import LIMITS, Machine, largest_force, largest_torque, margins
from steeplejack.planning.climb.places import footing, trouble
from steeplejack.robots.pipe_climber.bars import linkage_bars, ring_radius, widest_turn
from steeplejack.robots.pipe_climber.bearing import holding_forces, servo_torques
from steeplejack.robots.pipe_climber.pads import BOTH, FIRST, LAST
from steeplejack.worksite.pipe_builtin import load_pipe

MACHINE = Machine.of(ROBOT, 0.2)
POSES = np.array([[0.0, 0.17, 0.0], [0.015, 0.19, 0.3], [-0.01, 0.16, -0.2]])
GRAVITY = np.array([[1.0, -3.0, -9.0], [-6.0, 2.0, -7.0], [5.0, 5.0, 5.0]])


def test_forces_and_torques_are_the_largest_over_every_turn_and_every_clock():
    forces, torques = np.zeros((2, 3)), np.zeros((2, 3))  # clock known, any clock
    for beta in np.linspace(-ROBOT.rcm.limit, ROBOT.rcm.limit, 21):
        freedoms = np.column_stack((POSES, np.full(3, beta)))
        for clock in np.linspace(0.0, 2.0 * math.pi, 73):
            c, s = math.cos(clock + beta), math.sin(clock + beta)  # from the mechanism to the lower gripper
            x, y, z = GRAVITY.T
            pull = np.stack((x * c - y * s, x * s + y * c, z), axis=-1)
            force = np.abs(holding_forces(ROBOT, MACHINE.layout, freedoms, pull, 0.2)).max(axis=(1, 2))
            torque = np.abs(servo_torques(ROBOT, MACHINE.layout, freedoms, pull, 0.2)).max(axis=1)
            for row in (0, 1) if clock == 0.0 else (1,):
                forces[row], torques[row] = np.maximum(forces[row], force), np.maximum(torques[row], torque)
    for row in range(2):
        found = largest_force(MACHINE, POSES, GRAVITY, bool(row))
        np.testing.assert_array_less(forces[row], found + 1e-9)
        np.testing.assert_allclose(forces[row], found, rtol=5e-3)
        assert (torques[row] <= largest_torque(MACHINE, POSES, GRAVITY, bool(row)) + 1e-9).all()
    np.testing.assert_allclose(torques[1], largest_torque(MACHINE, POSES, GRAVITY, True), rtol=5e-3)


def test_weak_cylinders_and_a_weak_servo_are_limits_of_their_own():
    level = np.array([[0.0, -9.81, 0.0]])
    for table, name, limit in (("cylinders", "force", "force"), ("build", "servo_torque", "servo")):
        weak = Machine.of(changed(ROBOT, table, **{name: 0.1}))
        kept = margins(weak, POSES[:1], level + [[3.0, 0.0, -3.0]])[0]
        assert kept[LIMITS.index(limit)] < 0.0
        assert (np.delete(kept, LIMITS.index(limit)) >= 0.0).all()
    assert 1.0 < largest_torque(MACHINE, POSES, GRAVITY, True).max() / 0.3 < ROBOT.build.servo_torque / 0.3


def test_a_plan_counts_weight_inertia_and_reserve():
    """Up a vertical pipe it is the closed form: mass times g, and what accelerates, against friction less reserve."""
    feet = np.full((1, 2, 2), [0.03, BOTH])
    pose, ways = np.array([[0.0, 0.175, 0.0]]), np.array([[[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]])
    gravity, still = np.array([[0.0, 0.0, -9.81]]), np.array([[0.0, 0.175, 0.0, 0.0]])
    machine = Machine.of(changed(ROBOT, "gait", reserve=0.2, turn_speed=1e-9))
    pushes = either_way(machine, pose, ways, np.array([0]), np.zeros(1))
    used = alone(machine, still, gravity, feet, pushes)[0]
    holds = ROBOT.gripper.friction * ROBOT.gripper.force * ROBOT.gripper.jaws
    for end in range(2):
        inertia = np.abs(pushes[:, 0, end, 5]).max()
        assert used[end] == pytest.approx((ROBOT.body.mass * 9.81 + inertia) / holds / 0.8, rel=2e-3)
    travel = np.column_stack((np.zeros(9), np.linspace(0.15, 0.2, 9), np.zeros(9), np.zeros(9)))
    assert machine.peaks[0] == pytest.approx(0.5 * math.pi * ROBOT.cylinders.speed / ROBOT.gait.ramp)
    np.testing.assert_allclose(np.abs(along_way(machine, travel)[0, 4]), np.abs(pushes[0, 0]), atol=1e-6)


def test_turning_takes_grip_of_its_own():
    feet = np.full((1, 2, 2), [0.03, BOTH])
    pose, ways = np.array([[0.0, 0.175, 0.0]]), np.array([[[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]])
    gravity, still = np.array([[0.0, 0.0, -9.81]]), np.array([[0.0, 0.175, 0.0, 0.0]])
    used = [
        alone(machine, still, gravity, feet, either_way(machine, pose, ways, np.array([0]), np.zeros(1)))[0, 0]
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
