"""Compiled statics of one pose against the batch functions, closed forms and singular values."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.mechanics.cable import spatial_lengths, spatial_stiffness, spatial_structure_matrix
from steeplejack.mechanics.cable.rest import statics
from steeplejack.spatial import from_vector

ATTACHMENTS = np.array([[-0.1, -0.09, 0.01], [0.11, -0.1, -0.02], [0.09, 0.1, 0.0], [-0.1, 0.12, 0.015]])
CENTRE = np.array([0.01, -0.02, -0.03])
WEIGHT = np.array([3.0, -5.0, -170.0])


@pytest.mark.parametrize("cables", (1, 4, 9))
def test_one_pose_has_the_statics_of_the_batch(cables, rng):
    """Directions, lengths, wrench and stiffness of random rotated poses, a cable slack: no second definition."""
    for _ in range(10):
        anchors, attachments = rng.uniform(-4.0, 4.0, (cables, 3)), rng.uniform(-0.5, 0.5, (cables, 3))
        position, rotation = rng.uniform(-0.5, 0.5, 3), from_vector(rng.normal(size=3))
        tensions = rng.uniform(50.0, 500.0, cables)
        tensions[0] *= rng.choice([1.0, 0.0, -0.1])
        u, lengths = statics.directions(anchors, attachments, position, rotation)
        structure = spatial_structure_matrix(anchors, attachments, position, rotation)
        np.testing.assert_allclose(u.T, structure[3:], atol=1e-14)
        np.testing.assert_allclose(lengths, spatial_lengths(anchors, attachments, position, rotation), rtol=1e-14)
        left = statics.residual(attachments, WEIGHT, CENTRE, rotation, u, tensions)
        load = np.concatenate((np.cross(rotation @ CENTRE, WEIGHT), WEIGHT))
        np.testing.assert_allclose(left, structure @ tensions + load, atol=1e-11)
        rates = rng.uniform(1e3, 1e4, cables)
        found = statics.stiffness(attachments, WEIGHT, CENTRE, rotation, u, lengths, tensions, rates)
        wanted = spatial_stiffness(anchors, attachments, position, rotation, tensions, rates, WEIGHT, CENTRE)
        np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-9)


def test_stiffness_at_constant_tension_is_the_slope_of_the_residual(rng):
    """For tensions of any sign, by central differences; the skew part is the moment's and left out."""
    anchors, attachments = rng.uniform(-4.0, 4.0, (5, 3)), rng.uniform(-0.5, 0.5, (5, 3))
    position, rotation = rng.uniform(-0.5, 0.5, 3), from_vector(rng.normal(size=3))
    tensions = np.array([100.0, -5.0, 0.0, 300.0, 20.0])

    def left(move):
        turn = from_vector(move[:3].copy()) @ rotation
        u, _lengths = statics.directions(anchors, attachments, position + move[3:], turn)
        return statics.residual(attachments, WEIGHT, CENTRE, turn, u, tensions)

    slope = -np.stack([(left(s) - left(-s)) / 2e-6 for s in 1e-6 * np.eye(6)], axis=-1)
    u, lengths = statics.directions(anchors, attachments, position, rotation)
    found = statics.tension_stiffness(attachments, WEIGHT, CENTRE, rotation, u, lengths, tensions)
    np.testing.assert_allclose(found, 0.5 * (slope + slope.T), atol=1e-6 * np.abs(slope).max())


def test_least_pivot_sees_indefinite_matrices() -> None:
    rng = np.random.default_rng(3)
    for _ in range(200):
        a = rng.normal(size=(6, 6))
        matrix = a @ a.T - rng.uniform(0, 3) * np.eye(6)
        assert (statics.least_pivot(matrix) > 0.0) == bool(np.linalg.eigvalsh(matrix)[0] > 0.0)


@pytest.mark.parametrize("seed", range(8))
def test_balanced_rotation_is_wahbas(seed: int) -> None:
    """Newton from any start ends where the singular value decomposition does."""
    rng = np.random.default_rng(seed)
    forces = rng.normal(size=(4, 3)) * 100
    moment = forces.T @ ATTACHMENTS + np.outer(WEIGHT, CENTRE)
    left, _values, right = np.linalg.svd(moment)
    best = left @ np.diag([1, 1, np.linalg.det(left) * np.linalg.det(right)]) @ right
    for _ in range(5):
        start = from_vector(rng.normal(size=3) * 2.0)
        found = statics.balanced_rotation(forces, ATTACHMENTS, WEIGHT, CENTRE, start)
        assert np.abs(found - best).max() < 1e-7


def test_a_cable_of_no_length_is_no_number_and_raises_nothing() -> None:
    u, lengths = statics.directions(np.zeros((4, 3)), np.zeros((4, 3)), np.zeros(3), np.eye(3))
    assert not np.isfinite(u).any()
    assert (lengths == 0.0).all()
