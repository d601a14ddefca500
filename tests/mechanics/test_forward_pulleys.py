"""Every pose over pulleys: bounds against samples, known poses proved, none missed, none invented."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    every_planar_pose,
    every_spatial_pose,
    pulley_runs,
    spatial_lengths,
    track_planar,
)
from steeplejack.mechanics.cable.pose.bounds import enclose
from steeplejack.mechanics.cable.pose.every_pose import _rotations
from steeplejack.spatial import from_vector

pytestmark = pytest.mark.long

CORNERS = np.array([[-1, 1], [1, 1], [1, -1], [-1, -1]])
ANCHORS = np.array([[4.0 * x, 3.0 * y, z] for z in (5.0, 1.0) for x, y in CORNERS])  # IPAnema 2
UPPER, LOWER = ((0.65, 0.125, 0.25), (0.75, 0.1, 0.75))
ATTACHMENTS = np.array([[a * x, b * y, z] for a, b, z in (UPPER, LOWER) for x, y in CORNERS])
AXES = np.repeat([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], 4, axis=0)  # cables arrive from the middle of the frame's height


def planar_lengths(anchors, attachments, pose, radii, axes):
    """Lengths over pulleys in the plane."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return pulley_runs(anchors, axes, radii, pose[:2] + attachments @ np.array([[c, s], [-s, c]]))[0]


@pytest.mark.parametrize("radius", [0.05, 0.5, 1.5])
def test_bounds_hold_for_every_sample(rng, radius):
    """Squared lengths and derivatives at random poses of random boxes, the derivatives by finite differences."""
    squares, slopes, radii, regular = np.empty((8, 2)), np.empty((8, 6, 2)), np.full(8, radius), 0
    for _ in range(40):
        axes = rng.normal(size=(8, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        middle, half = rng.normal(size=6) * [1, 1, 1, 0.5, 0.5, 1.5], rng.uniform(0.0, rng.choice([0.4, 0.05]), 6)
        enclose(middle - half, middle + half, ANCHORS, axes, radii, ATTACHMENTS, squares, slopes)
        used = np.any(slopes != 0.0, axis=(1, 2))
        regular += used.sum()
        for _ in range(10):
            at = middle + half * rng.uniform(-1.0, 1.0, 6)

            def value(x, axes=axes):
                return pulley_runs(ANCHORS, axes, radii, x[:3] + ATTACHMENTS @ _rotations(x[None, 3:])[0].T)[0] ** 2

            exact = value(at)
            there = np.isfinite(exact)
            off = 1e-14 * exact[there]  # of the formula compared with, which rounds
            assert np.all((squares[there, 0] <= exact[there] + off) & (exact[there] - off <= squares[there, 1]))
            numeric = np.stack([(value(at + d) - value(at - d)) / 2e-5 for d in 1e-5 * np.eye(6)], axis=-1)[used]
            assert np.all((slopes[used, :, 0] <= numeric + 1e-5) & (numeric - 1e-5 <= slopes[used, :, 1]))
    assert regular > 100


def test_bounds_shrink_to_the_value(rng):
    """At a single pose the enclosure is as narrow as rounding lets it be."""
    squares, slopes, radii = np.empty((8, 2)), np.empty((8, 6, 2)), np.full(8, 0.06)
    for at in rng.normal(size=(10, 6)) * [1, 1, 0.5, 0.3, 0.3, 0.3] + [0, 0, 2.5, 0, 0, 0]:
        enclose(at, at, ANCHORS, AXES, radii, ATTACHMENTS, squares, slopes)
        assert np.all(squares[:, 1] - squares[:, 0] < 1e-12 * squares[:, 1])
        assert np.all(slopes[:, :, 1] - slopes[:, :, 0] < 1e-11)


def test_a_platform_inside_a_pulley_has_no_length():
    squares, slopes = np.empty((1, 2)), np.empty((1, 6, 2))
    low = np.array([0.9, -0.05, -0.05, 0.0, 0.0, 0.0])
    robot = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.ones(1), np.zeros((1, 3))
    enclose(low, low + [0.1, 0.1, 0.1, 0.0, 0.0, 0.0], *robot, squares, slopes)
    assert squares[0, 0] > 1e100 and not slopes.any()


def test_spatial_poses_are_proved_unique_in_a_box(rng):
    for radius in (0.03, 0.06, 0.2):
        position, rotation = rng.uniform([-1.5, -1.0, 1.5], [1.5, 1.0, 3.0]), from_vector(rng.normal(size=3) * 0.1)
        lengths, _along = pulley_runs(ANCHORS, AXES, radius, position + ATTACHMENTS @ rotation.T)
        middle = position + rng.uniform(-0.2, 0.2, 3)
        box = (middle, np.eye(3), 0.3, 0.4)
        answer = every_spatial_pose(lengths, ANCHORS, ATTACHMENTS, *box, radii=radius, axes=AXES)
        assert answer.unique
        np.testing.assert_allclose(answer.position[0], position, atol=1e-10)
        np.testing.assert_allclose(answer.rotation[0], rotation, atol=1e-10)
        straight = every_spatial_pose(lengths, ANCHORS, ATTACHMENTS, *box)
        assert straight.complete and not len(straight.position)  # the pulleys matter


def test_radius_0_is_the_straight_cable():
    lengths = spatial_lengths(ANCHORS, ATTACHMENTS, [0.3, -0.2, 2.4], np.eye(3))
    box = ([0.2, -0.1, 2.3], np.eye(3), 0.3, 0.3)
    one = every_spatial_pose(lengths, ANCHORS, ATTACHMENTS, *box)
    two = every_spatial_pose(lengths, ANCHORS, ATTACHMENTS, *box, radii=0.0, axes=AXES)
    np.testing.assert_array_equal(one.position, two.position)
    assert one.examined == two.examined


def test_three_cables_have_what_a_thousand_starts_find(rng):
    """Planar, three cables over pulleys, all poses there are: none is missed and none invented."""
    counts = []
    for _ in range(8):
        anchors, attachments = rng.uniform(-1.0, 1.0, (3, 2)), rng.uniform(-0.7, 0.7, (3, 2))
        radii, axes = rng.uniform(0.01, 0.05, 3), rng.normal(size=(3, 2))
        lengths = planar_lengths(anchors, attachments, rng.uniform(-0.5, 0.5, 3), radii, axes)
        answer = every_planar_pose(lengths, anchors, attachments, radii=radii, axes=axes)
        starts = rng.uniform([-3.0, -3.0, -np.pi], [3.0, 3.0, np.pi], (1000, 3))
        many = np.broadcast_to(lengths, (1000, 3))
        ends = track_planar(many, anchors, attachments, starts, radii=radii, axes=axes)
        found = ends.pose[(ends.residual < 1e-9) & (ends.status == 0)]
        distance = np.abs(np.exp(1j * found[:, None, 2]) - np.exp(1j * answer.pose[None, :, 2]))
        distance += np.linalg.norm(found[:, None, :2] - answer.pose[None, :, :2], axis=-1)
        assert distance.min(axis=1).max() < 1e-6
        for pose in answer.pose:
            np.testing.assert_allclose(planar_lengths(anchors, attachments, pose, radii, axes), lengths, atol=1e-9)
        assert answer.complete
        counts.append(len(answer.pose))
    assert max(counts) <= 12 and len(set(counts)) > 1


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_units_do_not_matter(reference, scale):
    anchors, attachments = (scale * np.array(reference["table_iii"][name]) for name in ("anchors", "attachments"))
    pose, radii = np.array([-0.1 * scale, 0.45 * scale, 0.87]), np.full(4, 0.03 * scale)
    middle = anchors.mean(axis=0)
    axes = np.column_stack((middle[1] - anchors[:, 1], anchors[:, 0] - middle[0]))
    lengths = planar_lengths(anchors, attachments, pose, radii, axes)
    answer = every_planar_pose(lengths, anchors, attachments, radii=radii, axes=axes)
    assert answer.unique
    np.testing.assert_allclose(answer.pose[0] / [scale, scale, 1.0], pose / [scale, scale, 1.0], atol=1e-11)


def test_lengths_no_pose_explains_are_proved_so():
    lengths, _along = pulley_runs(ANCHORS, AXES, 0.06, np.array([0.3, -0.2, 2.4]) + ATTACHMENTS)
    lengths = lengths + 0.02 * np.array([1, -1, 1, -1, 1, -1, 1, -1])
    answer = every_spatial_pose(lengths, ANCHORS, ATTACHMENTS, [0.3, -0.2, 2.4], np.eye(3), 0.3, 0.3, radii=0.06,
                                axes=AXES)  # fmt: skip
    assert answer.complete and not len(answer.position)


@pytest.mark.parametrize(
    ("pulleys", "words"),
    [
        ({"radii": 0.1}, "axes"),
        ({"radii": -0.1, "axes": AXES}, "radii"),
        ({"radii": [0.1, np.nan, 0, 0, 0, 0, 0, 0], "axes": AXES}, "radii"),
        ({"radii": [0.1, 0.1], "axes": AXES}, "radii"),
        ({"radii": 0.1, "axes": np.zeros((8, 3))}, "axes"),
        ({"radii": 0.1, "axes": AXES[:, :2]}, "axes"),
        ({"radii": "wide", "axes": AXES}, "radii"),
    ],
)
def test_pulleys_that_are_none_are_refused(pulleys, words):
    with pytest.raises(InputError, match=words):
        every_spatial_pose(np.ones(8), ANCHORS, ATTACHMENTS, np.zeros(3), np.eye(3), 0.3, 0.3, **pulleys)
