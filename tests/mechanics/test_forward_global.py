"""Every pose that explains cable lengths: against known counts, many random starts, and intervals against samples."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    every_planar_pose,
    every_spatial_pose,
    planar_lengths,
    spatial_lengths,
    track_planar,
    track_spatial,
)
from steeplejack.mechanics.cable.pose.bounds import enclose
from steeplejack.mechanics.cable.pose.every_pose import _angles, _rotations
from steeplejack.spatial import from_vector

pytestmark = pytest.mark.long

CORNERS = np.array([[-1, 1], [1, 1], [1, -1], [-1, -1]])
ANCHORS = np.array([[4.0 * x, 3.0 * y, z] for z in (5.0, 1.0) for x, y in CORNERS])  # IPAnema 2
UPPER, LOWER = ((0.65, 0.125, 0.25), (0.75, 0.1, 0.75))
ATTACHMENTS = np.array([[a * x, b * y, z] for a, b, z in (UPPER, LOWER) for x, y in CORNERS])

UP = np.tile([0.0, 0.0, 1.0], (8, 1))


@pytest.fixture(scope="module")
def table(reference):
    return np.array(reference["table_iii"]["anchors"]), np.array(reference["table_iii"]["attachments"])


def test_bounds_hold_for_every_sample(rng):
    """Squared lengths and derivatives at random poses of random boxes, the derivatives by finite differences."""
    squares, slopes = np.empty((8, 2)), np.empty((8, 6, 2))
    for _ in range(30):
        middle, half = rng.normal(size=6) * [1, 1, 1, 0.5, 0.5, 1.5], rng.uniform(0.0, 0.4, 6)
        enclose(middle - half, middle + half, ANCHORS, UP, np.zeros(8), ATTACHMENTS, squares, slopes)
        for _ in range(20):
            at = middle + half * rng.uniform(-1.0, 1.0, 6)

            def value(x):
                return spatial_lengths(ANCHORS, ATTACHMENTS, x[:3], _rotations(x[None, 3:])[0]) ** 2

            exact = value(at)
            assert np.all((squares[:, 0] <= exact) & (exact <= squares[:, 1]))
            numeric = np.stack([(value(at + d) - value(at - d)) / 2e-5 for d in 1e-5 * np.eye(6)], axis=-1)
            assert np.all((slopes[:, :, 0] <= numeric + 1e-6) & (numeric - 1e-6 <= slopes[:, :, 1]))


def test_angles_undo_rotations(rng):
    for _ in range(20):
        angles = rng.uniform(-1.4, 1.4, 3)
        np.testing.assert_allclose(_angles(_rotations(angles[None])[0]), angles, atol=1e-14)


def test_workspace_poses_are_proved_unique_over_all_angles(table, rng):
    for pose in rng.uniform([-0.4, 0.2, 0.6], [0.1, 0.7, 1.1], (20, 3)):
        answer = every_planar_pose(planar_lengths(*table, pose), *table)
        assert answer.unique
        np.testing.assert_allclose(answer.pose[0], pose, atol=1e-12)
        assert answer.residual[0] < 1e-12
        low, high = answer.boxes[0]
        assert np.all((low < pose) & (pose < high))


def test_three_cables_have_what_a_thousand_starts_find(rng):
    """A planar 3-RPR platform has up to six poses; none is missed and none invented."""
    counts = set()
    for _ in range(12):
        anchors, attachments = rng.uniform(-1.0, 1.0, (3, 2)), rng.uniform(-0.7, 0.7, (3, 2))
        lengths = planar_lengths(anchors, attachments, rng.uniform(-0.5, 0.5, 3))
        low, high = np.array([-3.0, -3.0, -3.0]), np.array([3.0, 3.0, -3.0 + 2.0 * np.pi])
        answer = every_planar_pose(lengths, anchors, attachments, low=low, high=high)
        starts = rng.uniform(low, high, (1000, 3))
        ends = track_planar(np.broadcast_to(lengths, (1000, 3)), anchors, attachments, starts)
        found = ends.pose[(ends.residual < 1e-9) & (ends.status == 0)]
        distance = np.abs(np.exp(1j * found[:, None, 2]) - np.exp(1j * answer.pose[None, :, 2]))
        distance += np.linalg.norm(found[:, None, :2] - answer.pose[None, :, :2], axis=-1)
        assert answer.complete
        assert distance.min(axis=1).max() < 1e-6
        assert len(answer.pose) % 2 == 0
        np.testing.assert_allclose(
            planar_lengths(anchors, attachments, answer.pose), lengths[None].repeat(len(answer.pose), 0), atol=1e-9
        )
        counts.add(len(answer.pose))
    assert max(counts) <= 6 and len(counts) > 1


def test_a_mirror_twin_is_found():
    anchors = np.array([[-2.0, 0.0], [-0.5, 0.0], [0.7, 0.0], [2.0, 0.0]])
    attachments = np.array([[-0.3, 0.0], [-0.1, 0.0], [0.1, 0.0], [0.3, 0.0]])
    pose = np.array([0.2, -0.8, 0.15])
    lengths = planar_lengths(anchors, attachments, pose)
    answer = every_planar_pose(lengths, anchors, attachments, low=[-2, -2, -3], high=[2, 2, 3.2])
    order = np.argsort(answer.pose[:, 1])
    assert answer.complete and not answer.unique
    np.testing.assert_allclose(answer.pose[order], [pose, pose * [1, -1, -1]], atol=1e-9)


def test_a_platform_that_hangs_below_its_anchors_is_found():
    anchors, attachments = [[0, 0], [4, 0.5], [2, 1.0], [1, 0.8]], [[-0.3, 0], [0.3, 0], [0.2, 0.2], [-0.2, 0.2]]
    pose = np.array([1.5, -2.0, 0.1])
    answer = every_planar_pose(planar_lengths(anchors, attachments, pose), anchors, attachments)
    assert answer.unique
    np.testing.assert_allclose(answer.pose, [pose], atol=1e-9)


def test_the_default_box_holds_every_explanation(table, rng):
    for pose in rng.uniform([-3.0, -3.0, -3.0], [3.0, 3.0, 3.0], (20, 3)):
        lengths = planar_lengths(*table, pose)
        answer = every_planar_pose(lengths, *table, tolerance=1e-3, budget=1)
        low, high = answer.box
        assert np.all((low[:2] < pose[:2]) & (pose[:2] < high[:2]))
        assert high[2] - low[2] == pytest.approx(2.0 * np.pi)


def test_reaches_without_a_point_in_common_prove_that_there_is_no_pose():
    answer = every_planar_pose([0.1] * 3, [[0, 0], [4, 0], [2, 3]], [[-0.1, 0], [0.1, 0], [0, 0.1]])
    assert answer.complete and len(answer.position) == 0 and answer.examined == 0
    assert answer.box[0, 0] > answer.box[1, 0]


def test_lengths_no_pose_explains_are_proved_so(table):
    lengths = planar_lengths(*table, [-0.1, 0.45, 0.87]) + np.array([0.02, -0.02, 0.02, 0.0])
    answer = every_planar_pose(lengths, *table)
    assert answer.complete and len(answer.pose) == 0
    wide = every_planar_pose(lengths, *table, tolerance=0.02, budget=2000)
    assert len(wide.pose) == 1 and 0.0 < wide.residual[0] <= 0.02


def test_a_double_solution_is_not_claimed():
    """All cables in one line with the platform: to first order nothing holds it across, two mirror poses meet."""
    anchors = np.array([[-2.0, 0.0], [-2.0, 0.0], [2.0, 0.0], [2.0, 0.0]])
    attachments = np.array([[-0.3, 0.0], [-0.2, 0.0], [0.2, 0.0], [0.3, 0.0]])
    lengths = planar_lengths(anchors, attachments, np.zeros(3))
    answer = every_planar_pose(lengths, anchors, attachments, low=[-1, -1, -0.5], high=[1, 1, 0.5], budget=3000)
    assert not answer.complete and not answer.unique
    assert len(answer.undecided) > 0


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_units_do_not_matter(table, scale):
    pose = np.array([-0.1, 0.45, 0.87])
    answer = every_planar_pose(scale * planar_lengths(*table, pose), scale * table[0], scale * table[1])
    assert answer.unique
    np.testing.assert_allclose(answer.pose[0] / [scale, scale, 1.0], pose, atol=1e-12)


def test_spatial_poses_are_proved_unique_in_a_box(rng):
    for _ in range(5):
        position, rotation = rng.uniform([-1.5, -1.0, 1.5], [1.5, 1.0, 3.0]), from_vector(rng.normal(size=3) * 0.1)
        lengths = spatial_lengths(ANCHORS, ATTACHMENTS, position, rotation)
        middle = position + rng.uniform(-0.2, 0.2, 3)
        answer = every_spatial_pose(lengths, ANCHORS, ATTACHMENTS, middle, np.eye(3), 0.3, 0.4)
        assert answer.unique
        np.testing.assert_allclose(answer.position[0], position, atol=1e-10)
        np.testing.assert_allclose(answer.rotation[0], rotation, atol=1e-10)


def test_six_cables_have_what_many_starts_find(rng):
    """Six cables of IPAnema 2: several poses in a larger box, the ones that random starts reach."""
    keep = [0, 1, 2, 3, 4, 6]
    anchors, attachments = ANCHORS[keep], ATTACHMENTS[keep]
    position, rotation = np.array([0.3, -0.2, 2.4]), from_vector(np.array([0.05, -0.1, 0.08]))
    lengths = spatial_lengths(anchors, attachments, position, rotation)
    answer = every_spatial_pose(lengths, anchors, attachments, position, np.eye(3), 0.3, 0.5)
    turns = np.array([_rotations(rng.uniform(-0.5, 0.5, (1, 3)))[0] for _ in range(500)])
    starts = position + rng.uniform(-0.3, 0.3, (500, 3))
    ends = track_spatial(np.broadcast_to(lengths, (500, 6)), anchors, attachments, starts, turns)
    inside = np.all(np.abs(ends.position - position) < 0.3, axis=1) & (ends.residual < 1e-9) & (ends.status == 0)
    inside &= np.array([np.abs(_angles(turn)).max() < 0.5 for turn in ends.rotation])
    gap = np.linalg.norm(ends.position[inside][:, None] - answer.position[None], axis=-1)
    assert answer.complete and inside.sum() > 50
    assert gap.min(axis=1).max() < 1e-6


def test_bad_input_is_refused(table):
    lengths = planar_lengths(*table, [-0.1, 0.45, 0.87])
    with pytest.raises(InputError, match="lengths"):
        every_planar_pose(lengths * np.nan, *table)
    with pytest.raises(InputError, match="tolerance"):
        every_planar_pose(lengths, *table, tolerance=0.0)
    with pytest.raises(InputError, match="search box"):
        every_planar_pose(lengths, *table, low=[0, 0, 1], high=[1, 1, 0])
    with pytest.raises(InputError, match="anchors"):
        every_planar_pose(lengths[:2], table[0][:2], table[1][:2])
    for none in (2.0 * np.eye(3), np.diag([1.0, 1.0, -1.0]), np.zeros((3, 3))):
        with pytest.raises(InputError, match="rotation"):
            every_spatial_pose(np.ones(8), ANCHORS, ATTACHMENTS, np.zeros(3), none, 0.3, 0.3)
    with pytest.raises(InputError, match="right angle"):
        every_spatial_pose(np.ones(8), ANCHORS, ATTACHMENTS, np.zeros(3), np.eye(3), 1.0, 2.0)
