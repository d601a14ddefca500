"""Planar dynamics by energy balance, inversion and agreement with the statics."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.mechanics.cable import distribute, planar_lengths, planar_structure_matrix
from steeplejack.robots.squad.dynamics import forward_dynamics, inverse_dynamics, planar_mass_matrix, planar_weight

MASS, INERTIA, GRAVITY = 17.7, 0.14, np.array([0.4, -9.8])


@pytest.fixture
def table(reference):
    return np.array(reference["table_iii"]["anchors"]), np.array(reference["table_iii"]["attachments"])


def runge_kutta(rate, state, dt):
    a = rate(state)
    b = rate(state + 0.5 * dt * a)
    c = rate(state + 0.5 * dt * b)
    d = rate(state + dt * c)
    return state + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d)


def test_work_of_the_cables_is_the_change_of_energy(table):
    anchors, attachments = table
    tensions, applied = np.array([60.0, 90.0, 180.0, 70.0]), np.array([3.0, -2.0, 0.4])

    def rate(state):
        structure = planar_structure_matrix(anchors, attachments, state[:3])
        return np.concatenate((state[3:], forward_dynamics(structure, tensions, MASS, INERTIA, GRAVITY, applied)))

    state = start = np.array([-0.1, 0.45, 0.87, 0.2, -0.1, 1.5])
    for _ in range(500):
        state = runge_kutta(rate, state, 2e-4)
    kinetic = [0.5 * s[3:] @ planar_mass_matrix(MASS, INERTIA) @ s[3:] for s in (start, state)]
    shortened = planar_lengths(anchors, attachments, start[:3]) - planar_lengths(anchors, attachments, state[:3])
    moved = state[:3] - start[:3]
    work = tensions @ shortened + MASS * GRAVITY @ moved[:2] + applied @ moved
    assert kinetic[1] - kinetic[0] == pytest.approx(work, rel=1e-9)
    assert abs(work) > 0.1


def test_inverse_undoes_forward(table, rng):
    poses = np.array([-0.1, 0.45, 0.87]) + rng.uniform(-0.1, 0.1, (30, 3))
    structure = planar_structure_matrix(*table, poses)
    tensions, applied = rng.uniform(10.0, 250.0, (30, 4)), rng.normal(size=(30, 3))
    acceleration = forward_dynamics(structure, tensions, MASS, INERTIA, GRAVITY, applied)
    cables = inverse_dynamics(acceleration, MASS, INERTIA, GRAVITY, applied)
    np.testing.assert_allclose(cables, np.einsum("kij,kj->ki", structure, tensions), rtol=1e-12, atol=1e-12)


def test_free_fall_needs_no_cables():
    np.testing.assert_allclose(inverse_dynamics([*GRAVITY, 0.0], MASS, INERTIA, GRAVITY), 0.0, atol=1e-12)
    slack = forward_dynamics(np.zeros((3, 4)), np.zeros(4), MASS, INERTIA, GRAVITY)
    np.testing.assert_allclose(slack, [*GRAVITY, 0.0])


def test_tensions_distributed_for_an_acceleration_produce_it(table):
    structure = planar_structure_matrix(*table, [-0.15, 0.20, 0.87])
    wanted = np.array([0.3, 0.2, -0.5])
    answer = distribute(structure, -inverse_dynamics(wanted, MASS, INERTIA, GRAVITY), 10.0, 250.0)
    assert answer.feasible
    got = forward_dynamics(structure, answer.tensions, MASS, INERTIA, GRAVITY)
    np.testing.assert_allclose(got, wanted, atol=1e-10)


def test_weight_of_several_masses():
    np.testing.assert_allclose(planar_weight([1.0, 2.0], GRAVITY), [[0.4, -9.8, 0.0], [0.8, -19.6, 0.0]])
