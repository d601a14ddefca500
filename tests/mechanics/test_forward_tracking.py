"""Tracking forward kinematics: planar and spatial, pulleys, streams, noise, singular poses and bad readings."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    TrackingStatus,
    planar_arms,
    planar_lengths,
    pulley_runs,
    spatial_lengths,
    track_planar,
    track_spatial,
)
from steeplejack.spatial import from_vector

CORNERS = np.array([[-1, 1], [1, 1], [1, -1], [-1, -1]])
ANCHORS = np.array([[4.0 * x, 3.0 * y, z] for z in (5.0, 1.0) for x, y in CORNERS])  # IPAnema 2
UPPER, LOWER = ((0.65, 0.125, 0.25), (0.75, 0.1, 0.75))
ATTACHMENTS = np.array([[a * x, b * y, z] for a, b, z in (UPPER, LOWER) for x, y in CORNERS])
PLANAR_ANCHORS = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [0.0, 6.0]])
PLANAR_ATTACHMENTS = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


def spatial_poses(rng, count=300):
    positions = rng.uniform([-1.5, -1.0, 1.5], [1.5, 1.0, 3.0], (count, 3))
    return positions, np.array([from_vector(rng.normal(size=3) * 0.15) for _ in range(count)])


def test_spatial_poses_are_found_from_the_middle(rng):
    positions, rotations = spatial_poses(rng)
    lengths = spatial_lengths(ANCHORS, ATTACHMENTS, positions, rotations)
    found = track_spatial(lengths, ANCHORS, ATTACHMENTS, [0.0, 0.0, 2.2], np.eye(3))
    assert (found.status == TrackingStatus.CONVERGED).all()
    np.testing.assert_allclose(found.position, positions, atol=1e-9)
    np.testing.assert_allclose(found.rotation, rotations, atol=1e-9)
    assert found.residual.max() < 1e-9


def test_a_stream_follows_the_path_and_batches_lead(rng):
    t = np.linspace(0.0, 4.0, 400)
    poses = np.stack((5.0 + 3.0 * np.sin(t), 3.0 + np.cos(2.0 * t), 2.0 * t), axis=-1)  # more than a whole turn
    lengths = planar_lengths(PLANAR_ANCHORS, PLANAR_ATTACHMENTS, poses)
    stream = track_planar(lengths, PLANAR_ANCHORS, PLANAR_ATTACHMENTS, poses[0] + 0.05, follow=True)
    np.testing.assert_allclose(stream.pose, poses, atol=1e-9)
    assert stream.iterations[1:].max() <= 4
    two = track_planar(
        np.stack((lengths[:50], lengths[50:100])), PLANAR_ANCHORS, PLANAR_ATTACHMENTS, poses[[0, 50]][:, None],
        follow=True,
    )  # fmt: skip
    np.testing.assert_allclose(two.pose.reshape(-1, 3), poses[:100], atol=1e-9)


def test_noise_gives_the_least_squares_pose(rng):
    positions, rotations = spatial_poses(rng, 5)
    lengths = spatial_lengths(ANCHORS, ATTACHMENTS, positions, rotations) + rng.normal(0.0, 2e-3, (5, 8))
    found = track_spatial(lengths, ANCHORS, ATTACHMENTS, positions, rotations)
    for k in range(5):

        def error(x, k=k):
            turn = from_vector(x[3:].copy()) @ rotations[k]
            return spatial_lengths(ANCHORS, ATTACHMENTS, positions[k] + x[:3], turn) - lengths[k]

        best = least_squares(error, np.zeros(6), xtol=1e-14, ftol=1e-14, gtol=1e-14)
        np.testing.assert_allclose(found.position[k], positions[k] + best.x[:3], atol=1e-7)
        assert found.residual[k] == pytest.approx(np.linalg.norm(best.fun), rel=1e-7)
    assert (found.status == TrackingStatus.CONVERGED).all()
    strict = track_spatial(lengths, ANCHORS, ATTACHMENTS, positions, rotations, tolerance=1e-6)
    assert (strict.status == TrackingStatus.UNEXPLAINED).all()


def test_spatial_pulleys(rng):
    positions, rotations = spatial_poses(rng, 100)
    axes, radii = np.tile([0.0, 0.0, 1.0], (8, 1)), np.full(8, 0.06)
    ends = positions[:, None] + np.einsum("kij,mj->kmi", rotations, ATTACHMENTS)
    lengths, _along = pulley_runs(ANCHORS, axes, radii, ends)
    start = [0.0, 0.0, 2.2], np.eye(3)
    found = track_spatial(lengths, ANCHORS, ATTACHMENTS, *start, radii=radii, axes=axes)
    np.testing.assert_allclose(found.position, positions, atol=1e-9)
    np.testing.assert_allclose(found.rotation, rotations, atol=1e-9)
    blind = track_spatial(lengths, ANCHORS, ATTACHMENTS, *start)
    assert np.abs(blind.position - positions).max() > 1e-2


def test_planar_pulleys(rng):
    poses = np.array([5.0, 3.0, 0.1]) + rng.uniform(-1.0, 1.0, (50, 3)) * [2.0, 1.0, 0.4]
    axes = np.array([[0.0, 1.0], [0.0, 1.0], [0.0, -1.0], [0.0, -1.0]])
    ends = poses[:, None, :2] + planar_arms(PLANAR_ATTACHMENTS, poses[:, 2])
    lengths, _along = pulley_runs(PLANAR_ANCHORS, axes, 0.1, ends)
    found = track_planar(lengths, PLANAR_ANCHORS, PLANAR_ATTACHMENTS, [5.0, 3.0, 0.0], radii=0.1, axes=axes)
    np.testing.assert_allclose(found.pose, poses, atol=1e-9)


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_units_do_not_matter(rng, scale):
    positions, rotations = spatial_poses(rng, 20)
    lengths = scale * spatial_lengths(ANCHORS, ATTACHMENTS, positions, rotations)
    found = track_spatial(lengths, scale * ANCHORS, scale * ATTACHMENTS, [0.0, 0.0, 2.2 * scale], np.eye(3))
    assert (found.status == TrackingStatus.CONVERGED).all()
    np.testing.assert_allclose(found.position / scale, positions, atol=1e-9)


def test_a_singular_pose_is_reported():
    """Coincident attachments leave the angle open; on the line through a middle anchor it is open to first order."""
    pose = np.array([4.0, 2.0, 0.3])
    found = track_planar(
        planar_lengths(PLANAR_ANCHORS, np.zeros((4, 2)), pose), PLANAR_ANCHORS, np.zeros((4, 2)), pose + 0.01
    )
    assert found.status == TrackingStatus.SINGULAR
    np.testing.assert_allclose(found.pose[:2], pose[:2], atol=1e-9)


def test_bad_readings_are_skipped_and_named(rng):
    poses = np.array([5.0, 3.0, 0.1]) + np.linspace(0.0, 0.2, 6)[:, None]
    lengths = planar_lengths(PLANAR_ANCHORS, PLANAR_ATTACHMENTS, poses)
    lengths[2, 1], lengths[3, 0] = np.nan, np.inf
    found = track_planar(lengths, PLANAR_ANCHORS, PLANAR_ATTACHMENTS, poses[0], follow=True)
    assert found.status.tolist() == [0, 0, TrackingStatus.UNDEFINED, TrackingStatus.UNDEFINED, 0, 0]
    assert np.isnan(found.residual[2:4]).all()
    np.testing.assert_allclose(found.pose[[0, 1, 4, 5]], poses[[0, 1, 4, 5]], atol=1e-9)
    assert all(status.advice for status in TrackingStatus)


def test_zero_lengths_and_a_cable_of_zero_length():
    start = np.array([5.0, 3.0, 0.0])
    assert track_planar(np.zeros(4), PLANAR_ANCHORS, PLANAR_ATTACHMENTS, start).status == TrackingStatus.UNDEFINED
    pose = np.array([0.5, 0.5, 0.0])  # attachment 1 on its anchor
    found = track_planar(
        planar_lengths(PLANAR_ANCHORS, PLANAR_ATTACHMENTS, pose), PLANAR_ANCHORS, PLANAR_ATTACHMENTS, start
    )
    np.testing.assert_allclose(found.pose, pose, atol=1e-6)


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(InputError, match="anchors"):
        track_planar(np.ones(2), PLANAR_ANCHORS[:2], PLANAR_ATTACHMENTS[:2], np.zeros(3))
    with pytest.raises(InputError, match="lengths"):
        track_planar(np.ones(3), PLANAR_ANCHORS, PLANAR_ATTACHMENTS, np.zeros(3))
    with pytest.raises(InputError, match="attachments"):
        track_spatial(np.ones(8), ANCHORS, ATTACHMENTS[:7], np.zeros(3), np.eye(3))
    with pytest.raises(InputError, match="axes"):
        track_spatial(np.ones(8), ANCHORS, ATTACHMENTS, np.zeros(3), np.eye(3), radii=0.1)
    with pytest.raises(InputError, match="finite"):
        track_spatial(np.ones(8), ANCHORS * np.nan, ATTACHMENTS, np.zeros(3), np.eye(3))
    for none in (2.0 * np.eye(3), np.diag([1.0, 1.0, -1.0]), np.eye(2)):
        with pytest.raises(InputError, match="rotation"):
            track_spatial(np.ones(8), ANCHORS, ATTACHMENTS, np.zeros(3), none)
