"""The one call for a pose from lengths, in space: six cables and more, pulleys, twins, hostile input."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    TrackingStatus,
    every_spatial_pose,
    forward_kinematics,
    pulley_runs,
    spatial_lengths,
    track_planar,
    track_spatial,
)
from steeplejack.spatial import from_vector
from steeplejack.spatial.rotation import to_vector

pytestmark = pytest.mark.long

CORNERS = np.array([[-1, 1], [1, 1], [1, -1], [-1, -1]])
ANCHORS = np.array([[4.0 * x, 3.0 * y, z] for z in (5.0, 1.0) for x, y in CORNERS])  # IPAnema 2
UPPER, LOWER = ((0.65, 0.125, 0.25), (0.75, 0.1, 0.75))
ATTACHMENTS = np.array([[a * x, b * y, z] for a, b, z in (UPPER, LOWER) for x, y in CORNERS])
AXES = np.tile([0.0, 0.0, 1.0], (8, 1))


def test_a_pose_is_found_and_unique_from_anywhere(rng):
    for _ in range(10):
        position, turn = rng.uniform([-1.5, -1.0, 1.5], [1.5, 1.0, 3.0]), rng.normal(size=3) * 0.3
        lengths = spatial_lengths(ANCHORS, ATTACHMENTS, position, from_vector(turn))
        start = np.concatenate((rng.uniform([-4, -3, 0], [4, 3, 5]), rng.normal(size=3)))
        answer = forward_kinematics(lengths, ANCHORS, ATTACHMENTS, start)
        np.testing.assert_allclose(answer.pose, [*position, *turn], atol=1e-9)
        np.testing.assert_allclose(answer.rotation, from_vector(turn), atol=1e-9)
        assert answer.unique and answer.converged and answer.residual < 1e-9
        proof = every_spatial_pose(lengths, ANCHORS, ATTACHMENTS, position, from_vector(turn), 0.3, 0.3)
        assert proof.unique


def test_pulleys(rng):
    position, turn = np.array([0.4, -0.3, 2.2]), np.array([0.1, -0.05, 0.2])
    lengths, _along = pulley_runs(ANCHORS, AXES, 0.06, position + ATTACHMENTS @ from_vector(turn).T)
    answer = forward_kinematics(lengths, ANCHORS, ATTACHMENTS, [0.0, 0.0, 2.0], radii=0.06, axes=AXES)
    np.testing.assert_allclose(answer.pose, [*position, *turn], atol=1e-9)
    assert answer.unique
    straight = forward_kinematics(lengths, ANCHORS, ATTACHMENTS, [0.0, 0.0, 2.0])
    assert straight.residual > 0.01


def test_six_cables_are_not_called_unique(rng):
    keep = [0, 1, 2, 3, 4, 6]
    position, turn = np.array([0.3, -0.2, 2.4]), np.array([0.05, -0.1, 0.08])
    lengths = spatial_lengths(ANCHORS[keep], ATTACHMENTS[keep], position, from_vector(turn))
    answer = forward_kinematics(lengths, ANCHORS[keep], ATTACHMENTS[keep], [*position, *turn])
    np.testing.assert_allclose(answer.pose, [*position, *turn], atol=1e-9)
    assert answer.converged and not answer.unique


def test_a_mirror_twin_is_reported(rng):
    """Anchors and attachments in one plane each: the platform hangs below as well as above."""
    anchors, attachments = ANCHORS.copy(), ATTACHMENTS.copy()
    anchors[:, 2] = attachments[:, 2] = 0.0
    anchors[4:, 0] *= 0.4
    position, turn = np.array([0.2, 0.1, -1.5]), np.array([0.05, 0.02, 0.3])
    lengths = spatial_lengths(anchors, attachments, position, from_vector(turn))
    answer = forward_kinematics(lengths, anchors, attachments, [0.0, 0.0, -1.0])
    np.testing.assert_allclose(answer.position, position, atol=1e-8)
    assert answer.converged and not answer.unique


def test_an_open_turn_is_singular():
    """All cables on one point of the platform leave its turn open."""
    attachments = np.tile([0.1, 0.0, 0.2], (8, 1))
    lengths = spatial_lengths(ANCHORS, attachments, [0.3, -0.2, 2.4], np.eye(3))
    answer = forward_kinematics(lengths, ANCHORS, attachments, [0.2, 0.0, 2.0])
    assert answer.status is TrackingStatus.SINGULAR
    assert not answer.unique and not answer.converged and answer.residual < 1e-9
    assert "undetermined" in answer.status.advice


def test_start_and_pose_have_one_form():
    position, turn = np.array([0.3, -0.2, 2.4]), np.array([2.0, 1.0, -1.5])
    lengths = spatial_lengths(ANCHORS, ATTACHMENTS, position, from_vector(turn))
    answer = forward_kinematics(lengths, ANCHORS, ATTACHMENTS, [*position, *turn])
    assert answer.iterations <= 2
    np.testing.assert_allclose(answer.pose[3:], to_vector(answer.rotation))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"lengths": np.ones(7)}, "lengths"),
        ({"lengths": np.ones((2, 8))}, "lengths"),
        ({"lengths": "long"}, "lengths"),
        ({"anchors": ANCHORS[:5], "attachments": ATTACHMENTS[:5], "lengths": np.ones(5)}, "anchors"),
        ({"anchors": ANCHORS[:, :1]}, "anchors"),
        ({"anchors": ANCHORS * np.nan}, "anchors"),
        ({"anchors": ANCHORS * 1e200}, "anchors"),
        ({"attachments": ATTACHMENTS[:7]}, "attachments"),
        ({"attachments": [[1.0, 2.0], [3.0]]}, "attachments"),
        ({"start": [0.0, 0.0]}, "start"),
        ({"start": [0.0, 0.0, np.nan]}, "start"),
        ({"tolerance": -1.0}, "tolerance"),
        ({"tolerance": np.nan}, "tolerance"),
        ({"radii": 0.1}, "axes"),
    ],
)
def test_what_is_no_question_is_refused(change, words):
    good = {"lengths": np.ones(8), "anchors": ANCHORS, "attachments": ATTACHMENTS, "start": np.zeros(3)}
    with pytest.raises(InputError, match=words) as refused:
        forward_kinematics(**(good | change))
    assert "\n" not in str(refused.value)


def test_a_bad_pose_in_a_batch_stops_no_other():
    position = np.array([0.3, -0.2, 2.4])
    lengths = np.tile(spatial_lengths(ANCHORS, ATTACHMENTS, position, np.eye(3)), (4, 1))
    lengths[1, 3], lengths[2] = np.nan, np.inf
    starts = np.array([position, position, position, [np.nan, 0.0, 0.0]])
    found = track_spatial(lengths, ANCHORS, ATTACHMENTS, starts, np.eye(3))
    assert found.status.tolist() == [0, 3, 3, 3]
    stream = track_spatial(lengths[[0, 1, 0]], ANCHORS, ATTACHMENTS, position, np.eye(3), follow=True)
    assert stream.status.tolist() == [0, 3, 0]
    planar = track_planar(np.ones((2, 3)), np.eye(3)[:, :2], np.zeros((3, 2)), [[0, 0, 0], [0, np.inf, 0]])
    assert planar.status[1] == TrackingStatus.UNDEFINED
    none = track_spatial(np.empty((0, 8)), ANCHORS, ATTACHMENTS, position, np.eye(3))
    assert none.position.shape == (0, 3) and none.status.shape == (0,)
    with pytest.raises(InputError, match="start"):
        track_spatial(lengths, ANCHORS, ATTACHMENTS, starts[:3], np.eye(3))
