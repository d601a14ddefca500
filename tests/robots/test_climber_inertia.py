"""Inertia of the pipe climber's moves and what its drives bear: against points followed in time, and virtual work."""

from __future__ import annotations

import math

import numpy as np
import pytest

from steeplejack.robots.pipe_climber import Layout, load_pipe_climber
from steeplejack.robots.pipe_climber.bearing import servo_torques
from steeplejack.robots.pipe_climber.grippers import free_gripper
from steeplejack.robots.pipe_climber.inertia import inertia, points
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.weights import first_moments
from steeplejack.spatial import profile

ROBOT = load_pipe_climber()
LAYOUT = Layout.of(ROBOT)
PAYLOAD = 0.3


def drawn(rng: np.random.Generator, count: int) -> np.ndarray:
    columns = ((-0.02, 0.02), (0.15, 0.2), (-0.4, 0.4), (-0.5, 0.5))
    return np.column_stack([rng.uniform(low, high, count) for low, high in columns])


def test_points_have_the_mass_and_the_first_moment_of_the_robot(rng: np.random.Generator):
    freedoms = drawn(rng, 8)
    masses, places = points(ROBOT, LAYOUT, freedoms, PAYLOAD)
    mass, moment = first_moments(ROBOT, LAYOUT, freedoms, PAYLOAD)
    assert masses.sum() == pytest.approx(mass)
    np.testing.assert_allclose((masses[:, None] * places).sum(axis=-2), moment, atol=1e-12)


@pytest.mark.parametrize("end", [0, 1])
def test_loads_are_those_of_points_followed_through_a_ramp(end: int, rng: np.random.Generator):
    """A move timed as the plan times it: second differences of where everything is, when the ramp is steepest."""
    gait, speed, tick = ROBOT.gait, ROBOT.cylinders.speed, 1e-5
    peak = 0.5 * math.pi / gait.ramp
    for start, way in zip(drawn(rng, 4), rng.normal(size=(4, 4)) * [0.02, 0.02, 0.2, 0.3], strict=True):
        lengths = limb_lengths(LAYOUT, np.array([start[:3] - 1e-6 * way[:3], start[:3] + 1e-6 * way[:3]]))
        needed = max(np.abs(np.diff(lengths, axis=0)).max() / 2e-6 / speed, abs(way[3]) / gait.turn_speed)
        timing = profile(1.0, 1.0 / needed, peak / needed)
        assert timing.ramp == pytest.approx(gait.ramp)
        middle = 0.5 * timing.ramp
        share = np.array([timing.at(middle + step * tick)[0] for step in (-1, 0, 1)])
        freedoms = start + (share - share[1])[:, None] * way
        masses, places = points(ROBOT, LAYOUT, freedoms, PAYLOAD)
        if end:
            upper = free_gripper(freedoms, ROBOT.linkage.claw_offset)
            places = (places - upper[:, None, :3, 3]) @ upper[:, :3, :3]
        pushes = -masses[:, None] * (places[0] - 2.0 * places[1] + places[2]) / tick**2
        expected = np.concatenate((np.cross(places[1], pushes).sum(axis=0), pushes.sum(axis=0)))
        found = inertia(ROBOT, LAYOUT, start[None], peak / needed * way[None], end, PAYLOAD)[0][0]
        np.testing.assert_allclose(found, expected, atol=0.06, rtol=0.02)  # speeds squared are left out


def test_along_the_pipe_it_is_mass_times_acceleration():
    """The rods go with the upper gripper; what holds stands still."""
    rods = 3.0 * 0.4 * ROBOT.cylinders.mass
    upper = ROBOT.build.gripper_mass + ROBOT.build.plate_mass + rods + PAYLOAD
    middle, up = np.array([[0.0, 0.175, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0, 0.0]])
    found = [inertia(ROBOT, LAYOUT, middle, up, end, PAYLOAD)[0] for end in (0, 1)]
    assert found[0][0, 5] == pytest.approx(-upper, rel=0.01)  # limbs lean by a few degrees
    assert found[1][0, 5] == pytest.approx(ROBOT.body.mass + PAYLOAD - upper, rel=0.01)


def test_the_servo_bears_what_turning_slowly_would_cost(rng: np.random.Generator):
    """Virtual work about the lower gripper's axis, the lower, then the upper gripper fixed."""
    step = 1e-6 * np.eye(4)[3]
    for freedoms, pull in zip(drawn(rng, 5), 9.81 * rng.normal(size=(5, 3)), strict=True):
        torques = servo_torques(ROBOT, LAYOUT, freedoms, pull, PAYLOAD)

        def gained(now: np.ndarray, fixed: int, at: np.ndarray = freedoms, pull: np.ndarray = pull) -> float:
            mass, moment = first_moments(ROBOT, LAYOUT, now, PAYLOAD)
            hz = ROBOT.linkage.claw_offset
            carry = free_gripper(at, hz) @ np.linalg.inv(free_gripper(now, hz)) if fixed else np.eye(4)
            return float((carry[:3, :3] @ moment + mass * carry[:3, 3]) @ pull)

        for fixed in range(2):
            slope = (gained(freedoms + step, fixed) - gained(freedoms - step, fixed)) / 2e-6
            assert torques[fixed] == pytest.approx(slope, abs=1e-6)
