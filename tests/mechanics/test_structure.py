"""Structure matrices against finite differences, at rotated and asymmetric poses."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from steeplejack.mechanics.cable import (
    planar_arms,
    planar_lengths,
    planar_structure_matrix,
    planar_vectors,
    spatial_lengths,
    spatial_structure_matrix,
)

STEP = 1e-6


def random_planar(rng, count=200, cables=5):
    attachments = rng.uniform(-0.5, 0.5, (cables, 2))
    anchors = rng.uniform(-3.0, 3.0, (count, cables, 2))
    pose = rng.uniform([-1.0, -1.0, -np.pi], [1.0, 1.0, np.pi], (count, 3))
    return anchors, attachments, pose


def test_lengths_of_table_iii(reference):
    x, y, phi = reference["lengths"]["x_y_phi_deg"]
    table = reference["table_iii"]
    lengths = planar_lengths(table["anchors"], table["attachments"], [x, y, np.deg2rad(phi)])
    np.testing.assert_allclose(lengths, reference["lengths"]["lengths"], rtol=1e-6)


def test_cable_vectors_close_the_loop(rng):
    anchors, attachments, pose = random_planar(rng)
    ends = pose[:, None, :2] + planar_arms(attachments, pose[:, 2]) + planar_vectors(anchors, attachments, pose)
    np.testing.assert_allclose(ends, anchors, atol=1e-14)


def test_planar_structure_is_the_negative_gradient_of_lengths(rng):
    anchors, attachments, pose = random_planar(rng)
    structure = planar_structure_matrix(anchors, attachments, pose)
    for coordinate in range(3):
        shift = np.zeros(3)
        shift[coordinate] = STEP
        ahead, behind = (planar_lengths(anchors, attachments, pose + s * shift) for s in (1, -1))
        np.testing.assert_allclose(-structure[:, coordinate], (ahead - behind) / (2 * STEP), atol=1e-8)


def test_the_printed_local_moment_arm_is_not_the_gradient(rng):
    anchors, attachments, pose = random_planar(rng)
    directions = planar_structure_matrix(anchors, attachments, pose)[:, :2]
    printed = attachments[:, 0] * directions[:, 1] - attachments[:, 1] * directions[:, 0]
    turn = np.array([0.0, 0.0, STEP])
    ahead, behind = (planar_lengths(anchors, attachments, pose + s * turn) for s in (1, -1))
    assert np.abs(-printed - (ahead - behind) / (2 * STEP)).max() > 0.1


def test_planar_functions_broadcast_like_a_loop(rng):
    anchors, attachments, pose = random_planar(rng, count=6)
    batch = planar_structure_matrix(anchors.reshape(2, 3, 5, 2), attachments, pose.reshape(2, 3, 3))
    loop = [planar_structure_matrix(a, attachments, p) for a, p in zip(anchors, pose, strict=True)]
    np.testing.assert_array_equal(batch.reshape(6, 3, 5), loop)


def test_a_cable_without_length_has_a_zero_column():
    structure = planar_structure_matrix([[0.1, 0.0], [1.0, 0.0]], [[0.1, 0.0], [0.0, 0.1]], [0.0, 0.0, 0.0])
    np.testing.assert_array_equal(structure[:, 0], 0.0)
    assert np.linalg.norm(structure[:2, 1]) == pytest.approx(1.0)


def test_spatial_structure_is_the_negative_gradient_along_the_twist(reference, rng):
    anchors, attachments = (np.array(reference["cogiro"][name]) for name in ("anchors", "attachments"))
    position = rng.uniform(-2.0, 2.0, (50, 3))
    rotation = Rotation.random(50, rng)
    still = rotation.as_matrix()
    structure = spatial_structure_matrix(anchors, attachments, position, still)
    for axis in range(3):
        turn, shift = np.zeros(3), np.zeros(3)
        turn[axis] = shift[axis] = STEP
        turned = [(Rotation.from_rotvec(s * turn) * rotation).as_matrix() for s in (1, -1)]
        ahead, behind = (spatial_lengths(anchors, attachments, position, r) for r in turned)
        np.testing.assert_allclose(-structure[:, axis], (ahead - behind) / (2 * STEP), atol=1e-8)
        ahead, behind = (spatial_lengths(anchors, attachments, position + s * shift, still) for s in (1, -1))
        np.testing.assert_allclose(-structure[:, 3 + axis], (ahead - behind) / (2 * STEP), atol=1e-8)


def test_spatial_structure_contains_the_planar_one(rng):
    anchors, attachments, pose = random_planar(rng, count=20, cables=4)
    planar = planar_structure_matrix(anchors, attachments, pose)
    flat = [np.concatenate((points, np.zeros((*points.shape[:-1], 1))), axis=-1) for points in (anchors, attachments)]
    position = np.concatenate((pose[:, :2], np.zeros((20, 1))), axis=-1)
    rotation = Rotation.from_rotvec(pose[:, 2:] * np.array([0.0, 0.0, 1.0])).as_matrix()
    spatial = spatial_structure_matrix(*flat, position, rotation)
    np.testing.assert_allclose(spatial[:, [3, 4, 2]], planar, atol=1e-14)
    np.testing.assert_allclose(spatial[:, [0, 1, 5]], 0.0, atol=1e-14)


def test_suspended_cogiro_is_nowhere_in_wrench_closure(reference, rng):
    anchors, attachments = (np.array(reference["cogiro"][name]) for name in ("anchors", "attachments"))
    position = rng.uniform([-5.0, -4.0, 0.5], [5.0, 4.0, 3.0], (40, 3))
    rotation = Rotation.from_rotvec(rng.uniform(-0.3, 0.3, (40, 3))).as_matrix()
    for structure in spatial_structure_matrix(anchors, attachments, position, rotation):
        assert linprog(np.zeros(8), A_eq=structure, b_eq=np.zeros(6), bounds=(1.0, None)).status == 2
