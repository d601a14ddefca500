"""The shift by drifting odometry, against what a platform under the control law really does."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import fsolve

from steeplejack.report.drift import drift_shift
from steeplejack.robots.squad.parameters import load_squad
from steeplejack.robots.squad.suspension import hang
from steeplejack.spatial import from_vector

Array = NDArray[np.float64]

SQUAD = load_squad()
ATTACHMENTS = np.array(SQUAD.platform.attachments)
WEIGHT = np.array([0.0, 0.0, -9.81 * SQUAD.platform.mass])
CENTRE = np.array([0.0, 0.0, 0.02])
# Four exits of a leaning bay, neither coplanar nor symmetric; the platform hangs in front of them.
EXITS = np.array([[-14.0, -6.0, -4.5], [13.0, -5.0, -4.0], [16.0, 12.0, 14.0], [-12.5, 9.0, 11.5]])
PLACE = np.array([0.6, 0.2, -1.4])


@cache
def planned() -> tuple[Array, Array]:
    """Orientation and tensions of the planned equilibrium, turned in the world so that no axis is special."""
    low, high = np.full(4, 5.0), np.full(4, 500.0)
    free = np.zeros((2, 4, 4))
    free[..., 3] = 1e9
    guess = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]).T
    candidates = (
        hang(EXITS, ATTACHMENTS, WEIGHT, CENTRE, PLACE, g, low, free, high, np.full(4, 150.0))
        for g in (guess, np.eye(3))
    )
    rotation, tension, room = max(candidates, key=lambda found: found[2])
    assert room > 0.0
    return rotation, tension


def lengths(exits: Array, position: Array, rotation: Array) -> Array:
    return np.linalg.norm(exits - position - ATTACHMENTS @ rotation.T, axis=1)


def rest(moved: Array) -> Array:
    """Where the control law brings the platform to rest with exits really moved, by the full equations (6,)."""
    turn, tension = planned()
    goal = lengths(EXITS, PLACE, turn)

    def missing(x: Array) -> Array:
        rotation, position = from_vector(x[:3]) @ turn, PLACE + x[3:]
        arms = ATTACHMENTS @ rotation.T
        reach = EXITS + moved - position - arms
        u = reach / np.linalg.norm(reach, axis=1, keepdims=True)
        force = tension[:, None] * u
        wrench = np.concatenate(
            [np.cross(arms, force).sum(0) + np.cross(rotation @ CENTRE, WEIGHT), force.sum(0) + WEIGHT]
        )
        # In the plane: the planned structure matrix makes least squares of the four lengths' errors.
        arms0 = ATTACHMENTS @ turn.T
        u0 = (EXITS - PLACE - arms0) / goal[:, None]
        matrix = np.column_stack([u0 @ turn[:, 0], u0 @ turn[:, 1], np.cross(arms0, u0) @ turn[:, 2]])
        plane = matrix.T @ (lengths(EXITS + moved, position, rotation) - goal)
        out = [wrench[:3] @ turn[:, 0], wrench[:3] @ turn[:, 1], wrench[3:] @ turn[:, 2]]
        return np.concatenate([plane, out])

    x, _info, found, message = fsolve(missing, np.zeros(6), full_output=True, xtol=1e-13)
    assert found == 1 or np.abs(missing(x)).max() < 1e-9, message
    return x


def shift(moved: Array) -> Array:
    rotation, tension = planned()
    return drift_shift(
        (EXITS + moved)[None], EXITS[None], ATTACHMENTS, WEIGHT, CENTRE, PLACE[None], rotation[None], tension[None]
    )[0]


def test_the_planned_pose_is_at_rest_where_nothing_has_moved():
    np.testing.assert_allclose(rest(np.zeros((4, 3))), 0.0, atol=1e-9)
    np.testing.assert_array_equal(shift(np.zeros((4, 3))), np.zeros(6))


@pytest.mark.parametrize("seed", range(6))
def test_the_shift_is_the_derivative_of_the_rest_pose(seed: int):
    moved = np.random.default_rng(seed).normal(0.0, 1.0, (4, 3))
    size = 1e-4
    expected = (rest(size * moved) - rest(-size * moved)) / (2.0 * size)
    np.testing.assert_allclose(shift(moved), expected, rtol=2e-5, atol=2e-5 * np.abs(expected).max())


def test_exits_that_shift_alike_take_the_platform_along():
    moved = np.tile([0.013, -0.021, 0.008], (4, 1))
    np.testing.assert_allclose(shift(moved), [0.0, 0.0, 0.0, 0.013, -0.021, 0.008], atol=1e-9)


def test_shifts_add_up():
    rng = np.random.default_rng(3)
    a, b = rng.normal(0.0, 0.02, (2, 4, 3))
    np.testing.assert_allclose(shift(a + 2.0 * b), shift(a) + 2.0 * shift(b), atol=1e-12)


def test_no_samples_give_no_shifts():
    empty, turns = np.empty((0, 4, 3)), np.empty((0, 3, 3))
    found = drift_shift(empty, empty, ATTACHMENTS, WEIGHT, CENTRE, np.empty((0, 3)), turns, np.empty((0, 4)))
    assert found.shape == (0, 6)


def test_slack_cables_leave_the_shift_finite():
    rotation, _tension = planned()
    found = drift_shift(
        (EXITS + 0.01)[None], EXITS[None], ATTACHMENTS, WEIGHT, CENTRE, PLACE[None], rotation[None], np.zeros((1, 4))
    )
    assert np.isfinite(found).all()
