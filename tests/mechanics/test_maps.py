"""Maps of any number of cables against the answers pose by pose, linear programs and rational arithmetic."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import BAND, closes_exactly, closure_margin, holds_exactly, window_margin
from published_robots import COGIRO, IPANEMA_2, KNTU, PLANAR_4_4, TABLE_III, rotations

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    FeasibilityStatus,
    TaskWrenches,
    gravity_wrench,
    margin_grid,
    planar_closure_map,
    planar_feasibility_map,
    planar_structure_matrix,
    spatial_closure_map,
    spatial_feasibility_map,
    spatial_structure_matrix,
    tension_factor,
    tension_factor_grid,
    wrench_closure,
    wrench_feasible,
)

pytestmark = pytest.mark.long


def planar_robot(rng, cables):
    turn = np.sort(rng.uniform(0.0, 2.0 * np.pi, cables))
    anchors = np.stack((2.0 * np.cos(turn), 1.5 * np.sin(turn)), axis=1) + rng.uniform(-0.2, 0.2, (cables, 2))
    return anchors, rng.uniform(-0.4, 0.4, (cables, 2))


def spatial_robot(rng, cables):
    """IPAnema 2 with its last cable left out or random ones beside it."""
    anchors = np.vstack((IPANEMA_2.anchors, rng.uniform([-4.0, -3.0, 0.0], [4.0, 3.0, 6.0], (4, 3))))
    return anchors[:cables] + rng.uniform(-0.3, 0.3, (cables, 3)), rng.uniform(-0.6, 0.6, (cables, 3))


@pytest.mark.parametrize("cables", [4, 5, 6, 8])
def test_planar_maps_are_the_answers_pose_by_pose(rng, cables):
    anchors, attachments = planar_robot(rng, cables)
    poses = rng.uniform([-1.5, -1.2, -0.8], [1.5, 1.2, 0.8], (4, 200, 3))
    structures = planar_structure_matrix(anchors, attachments, poses)
    factors = planar_closure_map(anchors, attachments, poses)
    np.testing.assert_allclose(factors, tension_factor(structures), atol=1e-9)
    assert factors.shape == (4, 200)
    task = TaskWrenches.box([-20.0, -90.0, -3.0], [20.0, -70.0, 3.0])
    found = planar_feasibility_map(anchors, attachments, poses, 5.0, 300.0, task, 0.3)
    each = wrench_feasible(structures, 5.0, 300.0, task, 0.3)
    np.testing.assert_array_equal(found.feasible, each.feasible)
    np.testing.assert_allclose(found.margin, each.margin, atol=1e-8)
    for k in rng.integers(0, 200, 15):
        margin = closure_margin(structures[1, k])
        inside = margin > 0.0 if abs(margin) > BAND else closes_exactly(structures[1, k])
        assert (factors[1, k] > 0.0) == inside
        weight = np.array([3.0, -80.0, 1.0])
        margin = window_margin(structures[1, k], weight, np.full(cables, 5.0), np.full(cables, 300.0))
        held = (
            margin > 0.0
            if abs(margin) > BAND
            else holds_exactly(structures[1, k], weight, np.full(cables, 5.0), np.full(cables, 300.0))
        )
        assert planar_feasibility_map(anchors, attachments, poses[1, k], 5.0, 300.0, weight).feasible == held


@pytest.mark.parametrize("cables", [7, 8, 9, 10])
def test_spatial_maps_are_the_answers_pose_by_pose(rng, cables):
    anchors, attachments = spatial_robot(rng, cables)
    positions, turns = IPANEMA_2.poses(rng, 120)
    structures = spatial_structure_matrix(anchors, attachments, positions, turns)
    factors = spatial_closure_map(anchors, attachments, positions, turns)
    np.testing.assert_allclose(factors, tension_factor(structures), atol=1e-9)
    weights = gravity_wrench(10.0, [0.0, 0.0, -9.81], turns @ np.array([0.05, -0.02, 0.1]))
    found = spatial_feasibility_map(anchors, attachments, positions, turns, 1.0, 200.0, weights, 0.5)
    each = wrench_feasible(structures, 1.0, 200.0, weights, 0.5)
    np.testing.assert_array_equal(found.status, each.status)
    np.testing.assert_allclose(found.margin, each.margin, atol=1e-7)
    low, high = np.full(cables, 1.0), np.full(cables, 200.0)
    for k in range(12):
        margin = closure_margin(structures[k])
        assert (factors[k] > 0.0) == (margin > 0.0 if abs(margin) > BAND else closes_exactly(structures[k]))
        margin = window_margin(structures[k], weights[k], low, high)
        held = margin > 0.0 if abs(margin) > BAND else holds_exactly(structures[k], weights[k], low, high)
        assert found.feasible[k] == held


def test_maps_larger_than_a_block_and_broadcast_axes(rng):
    x, y = np.meshgrid(np.linspace(-6.0, 6.0, 40), np.linspace(-4.0, 4.0, 30))
    positions = np.stack((x, y, np.full(x.shape, 2.0)), axis=-1)
    turns = rotations(np.array([[0.0, 0.0, 0.1], [0.1, 0.0, 0.0], [0.0, -0.1, 0.0], [0.05, 0.05, 0.2]]))
    weights = gravity_wrench(COGIRO.mass, [0.0, 0.0, -9.81], turns @ COGIRO.centre)
    found = spatial_feasibility_map(
        COGIRO.anchors, COGIRO.attachments, positions[:, :, None], turns, 100.0, 5000.0, weights
    )
    assert found.margin.shape == (30, 40, 4)
    structure = spatial_structure_matrix(COGIRO.anchors, COGIRO.attachments, positions[17, 30], turns[3])
    one = wrench_feasible(structure, 100.0, 5000.0, weights[3])
    assert found.margin[17, 30, 3] == pytest.approx(float(one.margin), rel=1e-9)


def test_planar_maps_agree_with_the_grid_kernels(rng):
    for robot in (PLANAR_4_4, KNTU, TABLE_III):
        xs = np.linspace(robot.low[0], robot.high[0], 31)
        ys = np.linspace(robot.low[1], robot.high[1], 23)
        phi = 0.5 * (robot.low[2] + robot.high[2]) + 0.04
        x, y = np.meshgrid(xs, ys)
        poses = np.stack((x, y, np.full(x.shape, phi)), axis=-1)
        grid = tension_factor_grid(robot.anchors, robot.attachments, phi, xs, ys)
        np.testing.assert_allclose(planar_closure_map(robot.anchors, robot.attachments, poses), grid, atol=1e-8)
        wrench = np.array([1.0, -9.81 * robot.mass, 0.1])
        margins = margin_grid(robot.anchors, robot.attachments, phi, xs, ys, wrench, *robot.window)
        found = planar_feasibility_map(robot.anchors, robot.attachments, poses, *robot.window, wrench)
        np.testing.assert_array_equal(found.feasible, margins >= -1e-9)


def singular_sweeps():
    """Poses that pass through singular ones: a symmetric robot at zero angle, a parallel one, a cable's end."""
    steps = np.concatenate([[0.0], *(sign * np.logspace(-16.1, -2.1, 57) for sign in (1.0, -1.0))])
    yield KNTU.anchors, KNTU.attachments, np.stack((0.0 * steps, 0.2 + 0.0 * steps, steps), axis=-1)
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    turned = np.stack((0.1 + 0.0 * steps, 0.05 + 0.0 * steps, steps), axis=-1)
    yield square, 0.2 * square, turned
    yield square, 0.2 * square, turned + [0.0, 0.0, np.pi / 2.0]
    yield square, 0.2 * square, np.stack((-0.8 + steps, -0.8 + 0.0 * steps, 0.0 * steps), axis=-1)


def test_maps_grids_and_closure_do_not_contradict_each_other_across_singular_poses():
    for anchors, attachments, poses in singular_sweeps():
        structures = planar_structure_matrix(anchors, attachments, poses)
        each = wrench_closure(structures)
        found = planar_closure_map(anchors, attachments, poses)
        held = planar_feasibility_map(anchors, attachments, poses, 1.0, 1e6, [0.0, -5.0, 0.0])
        np.testing.assert_array_equal(found > 0.0, each.inside)
        singular = held.status == FeasibilityStatus.SINGULAR
        assert not (found[singular] > 0.0).any()
        for pose, factor in zip(poses, found, strict=True):
            grid = tension_factor_grid(anchors, attachments, pose[2], [pose[0]], [pose[1]])[0, 0]
            margin = margin_grid(anchors, attachments, pose[2], [pose[0]], [pose[1]], [0.0, -5.0, 0.0], 1.0, 1e6)
            assert (grid > 0.0) == (factor > 0.0), (pose, grid, factor)
            assert grid == pytest.approx(factor, abs=1e-7)
            if grid > 0.0:
                assert np.isfinite(margin).all()


def test_spatial_maps_and_closure_do_not_contradict_each_other_across_singular_poses():
    steps = np.concatenate([[0.0], np.logspace(-16.1, -2.1, 29), -np.logspace(-16.1, -2.1, 29)])
    turns = rotations(steps[:, None] * np.array([0.3, 0.2, 1.0]))
    position = np.array([0.0, 0.0, 2.5])
    each = wrench_closure(spatial_structure_matrix(IPANEMA_2.anchors, IPANEMA_2.attachments, position, turns))
    factors = spatial_closure_map(IPANEMA_2.anchors, IPANEMA_2.attachments, position, turns)
    np.testing.assert_array_equal(factors > 0.0, each.inside)


def test_cables_through_one_point_are_singular_whatever_the_rounding(rng):
    turns = rotations(rng.normal(size=(50, 3)))
    attachments = np.tile([0.3, 0.1, -0.2], (9, 1))
    anchors = rng.normal(size=(9, 3)) + turns[7] @ attachments[0]
    assert not spatial_closure_map(anchors, 1e-9 * attachments, np.zeros(3), turns).any()
    through = anchors - 0.3 * anchors  # every cable's line passes through the reference point
    found = spatial_feasibility_map(anchors, through, np.zeros(3), np.eye(3), 1.0, 1e3, np.zeros(6))
    assert found.status == FeasibilityStatus.SINGULAR and not found.feasible


GOOD = {"anchors": IPANEMA_2.anchors, "attachments": IPANEMA_2.attachments, "positions": [0.0, 0.0, 2.0]} | {
    "rotations": np.eye(3), "lower": 1.0, "upper": 200.0, "task": np.zeros(6),
}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"anchors": "here"}, "anchors"),
        ({"anchors": IPANEMA_2.anchors[:7]}, "cables"),
        ({"anchors": np.full((8, 3), np.nan)}, "anchors"),
        ({"anchors": np.ones((40, 3)), "attachments": np.ones((40, 3))}, "cables"),
        ({"positions": [0.0, 0.0]}, "positions"),
        ({"positions": [[0.0, 0.0], [0.0]]}, "positions"),
        ({"positions": np.zeros((3, 3)), "rotations": np.tile(np.eye(3), (2, 1, 1))}, "rotations"),
        ({"rotations": 2.0 * np.eye(3)}, "rotations"),
        ({"rotations": np.diag([1.0, 1.0, -1.0])}, "rotations"),
        ({"lower": 300.0}, "tension limits"),
        ({"lower": [1.0, 2.0]}, "tension limits"),
        ({"upper": np.nan}, "tension limits"),
        ({"task": np.zeros(3)}, "task"),
        ({"task": np.full(6, np.inf)}, "task"),
        ({"task": np.zeros((5, 6))}, "task"),
        ({"length": 0.0}, "characteristic length"),
    ],
)
def test_questions_that_mean_nothing_are_refused(changes, where):
    with pytest.raises(InputError) as error:
        spatial_feasibility_map(**(GOOD | changes))
    assert error.value.where == where


def test_poses_that_are_not_finite_are_outside():
    found = spatial_feasibility_map(**(GOOD | {"positions": [[np.nan, 0.0, 2.0], [np.inf, 0.0, 2.0]]}))
    assert (found.status == FeasibilityStatus.UNDEFINED).all() and (found.margin == -np.inf).all()
    assert planar_closure_map(KNTU.anchors, KNTU.attachments, [np.nan, 0.0, 0.0]) == 0.0
