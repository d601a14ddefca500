"""Wrenches of gravity and inertia, against numerical rates of momentum along a motion."""

from __future__ import annotations

import numpy as np
from published_robots import rotations

from steeplejack.mechanics.cable import gravity_wrench, inertial_wrench, planar_inertial_wrench

MASS, CENTRE = 7.0, np.array([0.11, -0.07, 0.2])
INERTIA = np.array([[1.3, 0.1, -0.2], [0.1, 0.9, 0.05], [-0.2, 0.05, 1.6]])


def place(t):
    """A platform that translates and tumbles: position and rotation at a time."""
    turn = rotations(np.array([[0.3, -0.4, 0.2]]))[0] @ rotations(np.array([[0.9, 1.1, -0.7]]) * np.sin(1.3 * t))[0]
    return np.array([np.sin(t), t**2, np.cos(2.0 * t)]), turn


def rate(function, t, step=1e-4):
    """Central difference of fourth order."""
    a, b = function(t + step) - function(t - step), function(t + 2.0 * step) - function(t - 2.0 * step)
    return (8.0 * a - b) / (12.0 * step)


def spin(t):
    skew = rate(lambda s: place(s)[1], t) @ place(t)[1].T
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])


def test_inertia_is_the_negative_rate_of_momentum():
    t = 0.37
    position, turn = place(t)

    def momentum(s):
        where, rotation = place(s)
        velocity = rate(lambda r: place(r)[0] + place(r)[1] @ CENTRE, s)
        linear = MASS * velocity
        angular = rotation @ INERTIA @ rotation.T @ spin(s) + np.cross(where + rotation @ CENTRE, linear)
        return np.concatenate((angular, linear))

    change = rate(momentum, t, 1e-3)
    change[:3] -= np.cross(position, change[3:])  # about the platform's reference point
    acceleration = np.concatenate((rate(spin, t, 1e-3), rate(lambda s: rate(lambda r: place(r)[0], s), t, 1e-3)))
    wrench = inertial_wrench(MASS, INERTIA, CENTRE, turn, spin(t), acceleration)
    np.testing.assert_allclose(wrench, -change, rtol=1e-5, atol=1e-5)


def test_planar_inertia_is_the_spatial_one_in_its_plane(rng):
    for _ in range(20):
        phi, speed, mass, inertia = rng.normal(size=4)
        centre, motion = rng.normal(size=2), rng.normal(size=3)
        turn = rotations(np.array([[0.0, 0.0, phi]]))[0]
        spatial = inertial_wrench(
            mass,
            np.diag([0.3, 0.4, inertia]),
            [*centre, 0.0],
            turn,
            [0.0, 0.0, speed],
            [0.0, 0.0, motion[2], *motion[:2], 0.0],
        )
        planar = planar_inertial_wrench(mass, inertia, centre, phi, speed, motion)
        np.testing.assert_allclose(planar, spatial[[3, 4, 2]], atol=1e-12)


def test_free_fall_needs_no_tension(rng):
    arm, gravity = rng.normal(size=3), np.array([0.0, 0.0, -9.81])
    falling = inertial_wrench(MASS, INERTIA, arm, np.eye(3), np.zeros(3), np.concatenate((np.zeros(3), gravity)))
    np.testing.assert_allclose(falling + gravity_wrench(MASS, gravity, arm), 0.0, atol=1e-12)


def test_gravity_planar_spatial_and_in_batches(rng):
    arms = rng.normal(size=(4, 5, 2))
    planar = gravity_wrench(3.0, [0.0, -9.81], arms)
    np.testing.assert_allclose(planar[..., :2], np.broadcast_to([0.0, -29.43], (4, 5, 2)))
    np.testing.assert_allclose(planar[..., 2], -29.43 * arms[..., 0])
    spatial = gravity_wrench([1.0, 2.0], [0.0, -9.81, 0.0], [0.5, 0.0, 0.0])
    np.testing.assert_allclose(spatial, np.outer([1.0, 2.0], [0.0, 0.0, -4.905, 0.0, -9.81, 0.0]))
