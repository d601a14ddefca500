"""Certified regions over ranges of orientation: sampling, certificates, second routes, models against exact values."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import holds_exactly, window_margin
from published_robots import COGIRO, IPANEMA_2, rotations

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    Label,
    certify,
    gravity_wrench,
    spatial_closure_map,
    spatial_facets,
    spatial_feasibility_map,
    spatial_structure_matrix,
)
from steeplejack.mechanics.cable.region import models
from steeplejack.mechanics.cable.region.oriented import (
    certify_orientations,
    certify_poses,
    failing_turn,
    pose_question,
)

pytestmark = pytest.mark.long

LEANING = rotations(np.array([[0.1, -0.2, 0.3]]))[0]
HALL = np.array([[2.5, 7.5], [1.0, 5.0], [1.0, 3.0]])
ROOM = np.array([[-3.5, 3.5], [-2.5, 2.5], [0.5, 4.5]])
WEIGHT = np.array([0.0, 0.0, 0.0, 0.0, 0.0, -9.81 * COGIRO.mass])


def cogiro(rotation=None):
    given = (WEIGHT, *COGIRO.window, COGIRO.centre)
    return pose_question(COGIRO.anchors, COGIRO.attachments, rotation, *given)


def cogiro_holds(positions, turns):
    weight = gravity_wrench(COGIRO.mass, [0.0, 0.0, -9.81], turns @ COGIRO.centre)
    return spatial_feasibility_map(COGIRO.anchors, COGIRO.attachments, positions, turns, *COGIRO.window, weight)


def ipanema_closes(positions, turns):
    return spatial_closure_map(IPANEMA_2.anchors, IPANEMA_2.attachments, positions, turns)


def drawn(region, rng, count):
    """Poses in random boxes and their labels."""
    box = rng.integers(0, len(region.labels), count)
    low, high = region.boxes[box, :, 0], region.boxes[box, :, 1]
    return low + rng.random(low.shape) * (high - low), region.labels[box], box


def test_no_pose_is_in_a_box_of_the_other_kind(rng):
    tilts = np.array([[-0.02, 0.02], [0.01, 0.01], [0.0, 0.1]])
    for reference in (np.eye(3), LEANING):
        region = certify_poses(cogiro(reference), np.vstack((HALL, tilts)), 0.05, 20_000)
        poses, labels, _ = drawn(region, rng, 4000)
        found = cogiro_holds(poses[:, :3], rotations(poses[:, 3:]) @ reference)
        assert found.feasible[labels == Label.INSIDE].all()
        assert not found.feasible[labels == Label.OUTSIDE].any()
        assert not region.reached and 0.0 < region.inner < region.outer
        assert (labels == Label.INSIDE).sum() > 100 and (labels == Label.OUTSIDE).sum() > 100


def test_no_pose_is_in_a_box_of_the_other_kind_for_closure(rng):
    question = pose_question(IPANEMA_2.anchors, IPANEMA_2.attachments, LEANING)
    box = np.vstack((ROOM[:2], [[2.0, 2.0]], [[0.0, 0.0], [0.0, 0.0], [-0.4, 0.4]]))
    region = certify_poses(question, box, 0.05, 8000)
    poses, labels, _ = drawn(region, rng, 4000)
    factors = ipanema_closes(poses[:, :3], rotations(poses[:, 3:]) @ LEANING)
    assert (factors[labels == Label.INSIDE] > 0.0).all()
    assert (factors[labels == Label.OUTSIDE] == 0.0).all()
    assert 0.0 < region.inner < region.outer < 7.0 * 5.0 * 0.8
    assert (labels == Label.OUTSIDE).sum() > 100


def test_inside_at_every_orientation_and_outside_at_the_one_named(rng):
    turns = np.deg2rad([[-2.0, 2.0], [-2.0, 2.0], [1.0, 1.0]])
    region = certify_orientations(cogiro(), HALL, turns, 0.1, 4000)
    positions, labels, box = drawn(region, rng, 3000)
    vectors = turns[:, 0] + rng.random((3000, 3)) * np.ptp(turns, axis=1)
    corner = rng.random(3000) < 0.5
    vectors[corner] = np.where(rng.random((3000, 3)) < 0.5, turns[:, 0], turns[:, 1])[corner]
    assert cogiro_holds(positions, rotations(vectors)).feasible[labels == Label.INSIDE].all()
    out = labels == Label.OUTSIDE
    named = np.array([failing_turn(turns, number) for number in region.facets[box[out]]])
    assert not cogiro_holds(positions[out], rotations(named)).feasible.any()
    assert (region.facets[region.labels != Label.OUTSIDE] == -1).all()
    assert 0.0 < region.inner < region.outer and out.sum() > 50 and (labels == Label.INSIDE).sum() > 50


def test_at_one_orientation_both_routes_enclose_the_same_volume():
    still = np.zeros((3, 2))
    weight = gravity_wrench(COGIRO.mass, [0.0, 0.0, -9.81], LEANING @ COGIRO.centre)
    exact = certify(spatial_facets(COGIRO.anchors, COGIRO.attachments, LEANING, weight, *COGIRO.window), HALL, 0.1)
    one = certify_poses(cogiro(LEANING), np.vstack((HALL, still)), 0.3, 60_000)
    same = certify_orientations(cogiro(LEANING), HALL, still, 0.3, 60_000)
    for region in (one, same):
        assert region.reached
        assert region.inner <= exact.outer and exact.inner <= region.outer


def test_boxes_agree_with_linear_programs(rng):
    region = certify_poses(cogiro(), np.vstack((HALL, [[0.0, 0.0], [0.05, 0.05], [-0.1, 0.1]])), 0.05, 8000)
    poses, labels, _ = drawn(region, rng, 60)
    low, high = np.full(8, COGIRO.window[0]), np.full(8, COGIRO.window[1])
    for pose, label in zip(poses[labels != Label.UNDECIDED], labels[labels != Label.UNDECIDED], strict=True):
        turn = rotations(pose[None, 3:])[0]
        structure = spatial_structure_matrix(COGIRO.anchors, COGIRO.attachments, pose[:3], turn)
        weight = gravity_wrench(COGIRO.mass, [0.0, 0.0, -9.81], turn @ COGIRO.centre)
        margin = window_margin(structure, weight, low, high)
        held = margin > 0.0 if abs(margin) > 1e-6 else holds_exactly(structure, weight, low, high)
        assert held == (label == Label.INSIDE)


def test_models_hold_all_over_their_boxes(rng):
    question = cogiro(LEANING)
    count = len(question.anchors)
    for scale in (1e-3, 0.03, 0.3):
        middle = np.concatenate((rng.uniform(-0.2, 0.2, 3), rng.uniform(-0.6, 0.6, 3)))
        half = scale * rng.random(6)
        columns, inverse, load, turned = (
            np.empty((count, 6, 8)),
            np.empty((count, 8)),
            np.zeros((6, 8)),
            np.empty((4, 3)),
        )
        lever = models.frame(middle, question.arms, turned)
        assert models.column_models(question.anchors, question.arms, turned, lever, middle, half, columns, inverse)
        models.load_models(question.wrenches[0], question.centre, turned, lever, half, load)
        at = middle[:3], rotations(middle[None, 3:])[0]
        lengths = np.linalg.norm(question.anchors - question.arms @ at[1].T - at[0], axis=1)
        for _ in range(200):
            d = half * rng.choice([-1.0, 1.0, rng.uniform(-1.0, 1.0)], 6)
            turn, where = rotations((middle + d)[None, 3:])[0], (middle + d)[:3]
            arms = question.arms @ turn.T
            runs = question.anchors - arms - where
            exact = np.concatenate((np.cross(arms, runs) / lever, runs), axis=1) / lengths[:, None]
            assert (np.abs(exact - columns[..., 0] - columns[..., 1:7] @ d) <= columns[..., 7]).all()
            ratio = lengths / np.linalg.norm(runs, axis=1)
            assert (np.abs(ratio - inverse[:, 0] - inverse[:, 1:7] @ d) <= inverse[:, 7]).all()
            force = question.wrenches[0, 3:]
            wrench = np.concatenate((np.cross(turn @ question.centre, force) / lever, force))
            assert (np.abs(wrench - load[:, 0] - load[:, 1:7] @ d) <= load[:, 7]).all()


def test_several_wrenches_are_met_together(rng):
    wrenches = WEIGHT + np.array([[0.0] * 6, [0, 0, 0, 150.0, 0, 0], [0, 0, 0, -150.0, 0, 0], [0, 0, 40.0, 0, 0, 0]])
    question = pose_question(COGIRO.anchors, COGIRO.attachments, None, wrenches, *COGIRO.window)
    box = np.vstack((HALL, [[0.0, 0.0], [0.0, 0.0], [0.0, 0.1]]))
    region = certify_poses(question, box, 0.05, 3000)
    poses, labels, number = drawn(region, rng, 1500)
    held = np.stack(
        [
            spatial_feasibility_map(
                COGIRO.anchors, COGIRO.attachments, poses[:, :3], rotations(poses[:, 3:]), *COGIRO.window, wrench
            ).feasible
            for wrench in wrenches
        ]
    )
    assert held[:, labels == Label.INSIDE].all()
    out = labels == Label.OUTSIDE
    assert not held[region.facets[number[out]], np.flatnonzero(out)].any()


@pytest.mark.parametrize(("length", "force"), [(1e-9, 1e9), (1e9, 1e-9)])
def test_units_do_not_matter(length, force):
    scale = np.repeat([force * length, force], 3)
    low, high = (force * bound for bound in COGIRO.window)
    question = pose_question(
        COGIRO.anchors * length, COGIRO.attachments * length, None, WEIGHT * scale, low, high, COGIRO.centre * length
    )
    turns = np.array([[0.0, 0.0], [0.0, 0.0], [-0.05, 0.05]])
    near = certify_poses(cogiro(), np.vstack((HALL, turns)), 0.3, 2000)
    far = certify_poses(question, np.vstack((HALL * length, turns)), 0.3, 2000)
    assert far.inner / length**3 == pytest.approx(near.inner, rel=0.1)
    assert far.outer / length**3 == pytest.approx(near.outer, rel=0.1)


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"anchors": np.ones((8, 3))}, None),
        ({"anchors": IPANEMA_2.anchors[:5], "attachments": IPANEMA_2.attachments[:5]}, "cables"),
        ({"attachments": np.zeros((8, 3))}, "cables"),
        ({"attachments": np.full((8, 3), np.nan)}, "attachments"),
        ({"rotation": 1.1 * np.eye(3)}, "rotation"),
        ({"lower": 1.0}, "tension limits"),
        ({"lower": 2.0, "upper": 1.0}, "tension limits"),
        ({"lower": 1.0, "upper": np.inf}, "tension limits"),
        ({"lower": 1.0, "upper": 2.0, "wrenches": [0.0, 1.0]}, "wrenches"),
        ({"centre": [0.0, np.nan, 0.0]}, "centre"),
    ],
)
def test_questions_that_mean_nothing_are_refused(changes, where):
    given = {"anchors": IPANEMA_2.anchors, "attachments": IPANEMA_2.attachments} | changes
    if where is None:  # one point that is no robot, yet a shape: nothing in it is ever proved inside
        region = certify_poses(pose_question(**given), np.vstack((ROOM, np.zeros((3, 2)))), 0.5, 50)
        assert region.inner == 0.0
        return
    with pytest.raises(InputError) as error:
        pose_question(**given)
    assert error.value.where == where


def test_ranges_that_mean_nothing_are_refused():
    question = pose_question(IPANEMA_2.anchors, IPANEMA_2.attachments)
    with pytest.raises(InputError, match="box"):
        certify_poses(question, ROOM)
    with pytest.raises(InputError, match="turns"):
        certify_poses(question, np.vstack((ROOM, [[-4.0, 4.0]] * 3)))
    with pytest.raises(InputError, match="turns"):
        certify_orientations(question, ROOM, [[0.1, -0.1]] * 3)
    with pytest.raises(InputError, match="gap"):
        certify_orientations(question, ROOM, [[-0.1, 0.1]] * 3, np.nan)
    with pytest.raises(InputError, match="number"):
        failing_turn([[-0.1, 0.1]] * 3, -1)
