"""Forward kinematics over the whole workspace, in false minima, with twins, noise and stretch."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.mechanics.cable import (
    forward_kinematics,
    loaded_lengths,
    planar_lengths,
    planar_structure_matrix,
    pose_rates,
    tension_factor,
)
from steeplejack.mechanics.cable.pose.tracking import TrackingStatus, track_planar


@pytest.fixture(scope="module")
def table(reference):
    return np.array(reference["table_iii"]["anchors"]), np.array(reference["table_iii"]["attachments"])


@pytest.fixture(scope="module")
def start(reference):
    x, y, phi = reference["balanced"]["x_y_phi_deg"]
    return np.array([x, y, np.deg2rad(phi)])


def nodes(phi_deg, step=0.01):
    x, y = np.meshgrid(np.arange(-0.62, 0.41, step), np.arange(0.0, 0.90, step))
    return np.stack((x.ravel(), y.ravel(), np.full(x.size, np.deg2rad(phi_deg))), axis=-1)


def test_every_pose_of_the_workspace_is_found_from_the_best_one(table, start):
    poses = np.concatenate([nodes(phi_deg) for phi_deg in (44.0, 50.0, 56.0)])
    poses = poses[tension_factor(planar_structure_matrix(*table, poses)) > 0.0][::5]
    found = track_planar(planar_lengths(*table, poses), *table, start)
    np.testing.assert_allclose(found.pose, poses, atol=1e-9)
    assert (found.status == TrackingStatus.CONVERGED).all() and found.residual.max() < 1e-9
    assert np.mean(found.iterations <= 9) > 0.995  # a few poses at the workspace's tips have steps refused on the way
    assert found.iterations.max() <= 20


def test_workspace_poses_are_unique(table, start):
    poses = nodes(50.0, 0.04)
    poses = poses[tension_factor(planar_structure_matrix(*table, poses)) > 0.0]
    for pose in poses[::4]:
        answer = forward_kinematics(planar_lengths(*table, pose), *table, start)
        np.testing.assert_allclose(answer.pose, pose, atol=1e-9)
        assert answer.unique and answer.converged


def test_a_false_minimum_outside_the_workspace_is_not_taken_for_the_pose(table, start):
    poses = nodes(50.0, 0.04)
    poses = poses[tension_factor(planar_structure_matrix(*table, poses)) == 0.0]
    ends = track_planar(planar_lengths(*table, poses), *table, start)
    trapped = poses[ends.residual > 1e-6]
    assert len(trapped) > 0
    for pose in trapped[:10]:
        answer = forward_kinematics(planar_lengths(*table, pose), *table, start)
        np.testing.assert_allclose(answer.pose, pose, atol=1e-7)


def test_lengths_no_pose_explains_are_reported(table, start):
    lengths = planar_lengths(*table, start) + np.array([0.05, -0.05, 0.05, 0.0])
    answer = forward_kinematics(lengths, *table, start)
    assert not answer.unique
    assert answer.residual == pytest.approx(np.linalg.norm(planar_lengths(*table, answer.pose) - lengths))
    assert answer.residual > 0.02


def test_a_mirror_twin_is_reported():
    anchors = np.array([[-2.0, 0.0], [-0.5, 0.0], [0.7, 0.0], [2.0, 0.0]])
    attachments = np.array([[-0.3, 0.0], [-0.1, 0.0], [0.1, 0.0], [0.3, 0.0]])
    pose = np.array([0.2, -0.8, 0.15])
    answer = forward_kinematics(planar_lengths(anchors, attachments, pose), anchors, attachments, pose + 0.05)
    np.testing.assert_allclose(answer.pose, pose, atol=1e-9)
    assert answer.converged and answer.residual < 1e-9
    assert not answer.unique


def test_noise_moves_the_pose_a_little_and_stays_unique(table, start, rng):
    pose = np.array([-0.10, 0.45, np.deg2rad(50.0)])
    answer = forward_kinematics(planar_lengths(*table, pose) + rng.normal(0.0, 5e-5, 4), *table, start)
    np.testing.assert_allclose(answer.pose, pose, atol=2e-3)
    assert answer.unique


def test_the_tolerance_decides_what_counts_as_explained(table, start):
    pose = np.array([-0.10, 0.45, np.deg2rad(50.0)])
    lengths = planar_lengths(*table, pose) + np.array([2e-3, 0.0, 0.0, 0.0])
    assert not forward_kinematics(lengths, *table, start).unique
    assert forward_kinematics(lengths, *table, start, tolerance=2e-3).unique


def test_phi_stays_within_half_a_turn_of_the_start(table, start):
    pose = np.array([-0.10, 0.45, np.deg2rad(50.0)])
    whole = np.array([0.0, 0.0, 2.0 * np.pi])
    answer = forward_kinematics(planar_lengths(*table, pose), *table, start + whole)
    np.testing.assert_allclose(answer.pose, pose + whole, atol=1e-9)


def test_stretch_is_taken_out(table, start):
    pose, tensions, stiffness = np.array([-0.10, 0.45, np.deg2rad(50.0)]), np.array([150.0, 80.0, 210.0, 60.0]), 2e5
    unstretched = planar_lengths(*table, pose) / (1.0 + tensions / stiffness)
    blind = forward_kinematics(unstretched, *table, start).pose
    seen = forward_kinematics(loaded_lengths(unstretched, tensions, stiffness), *table, start).pose
    np.testing.assert_allclose(seen, pose, atol=1e-9)
    assert np.abs(blind - pose).max() > 1e-4


def test_twenty_metres_at_150_newtons_stretch_ten_to_thirty_millimetres():
    assert loaded_lengths(20.0, 150.0, 3e5) - 20.0 == pytest.approx(0.010)
    assert loaded_lengths(20.0, 150.0, 1e5) - 20.0 == pytest.approx(0.030)
    assert loaded_lengths(20.0, -5.0, 1e5) == 20.0


def test_pose_rates_invert_length_rates(table, rng):
    poses = np.array([-0.10, 0.45, 0.87]) + rng.uniform(-0.05, 0.05, (20, 3))
    rates = rng.normal(size=(20, 3))
    step = 1e-6
    ahead, behind = (planar_lengths(*table, poses + s * step * rates) for s in (1, -1))
    found = pose_rates(planar_structure_matrix(*table, poses), (ahead - behind) / (2 * step))
    np.testing.assert_allclose(found, rates, atol=1e-7)
