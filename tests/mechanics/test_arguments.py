"""One policy for arguments: rotations one by one and in batches, whole numbers, limits, overflow, messages."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    FeasibilityStatus,
    LockedPlatform,
    Surroundings,
    best_node,
    distribute,
    grid_nodes,
    inertial_wrench,
    interference_gaps,
    loaded_lengths,
    lost_cable,
    lost_cable_map,
    margin_grid,
    planar_inertial_wrench,
    planar_structure_matrix,
    platform_overlap,
    pose_rates,
    spatial_closure_map,
    spatial_feasibility_map,
    spatial_lengths,
    spatial_mass_matrix,
    spatial_stiffness,
    spatial_structure_derivatives,
    spatial_structure_matrix,
    spatial_vectors,
    spatial_weight_derivative,
    tension_factor_grid,
    wrench_feasible,
)
from steeplejack.mechanics.cable.arguments import finite_limits, limits, positive, rotation_matrices, whole
from steeplejack.robots.cable_robot import CableRobot, load_cable_robot

NO_ROTATIONS = [2.0 * np.eye(3), np.diag([1.0, 1.0, -1.0]), np.zeros((3, 3)), np.ones((3, 3)), 1e200 * np.eye(3)]
SQUARE = {
    "anchors": [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
    "attachments": [[0.1, -0.1], [-0.1, -0.1], [-0.1, 0.1], [0.1, 0.1]],
}
GRID = {**SQUARE, "phi": 0.1, "xs": [-0.3, 0.0, 0.4], "ys": [0.0, 0.2]}


@pytest.fixture(scope="module")
def cogiro():
    return load_cable_robot("cogiro")


@pytest.fixture(scope="module")
def questions(cogiro):
    """Functions of a rotation (..., 3, 3), each with the number of its result's own last axes."""
    robot, place = (cogiro.anchors, cogiro.attachments), [1.0, 0.5, 2.0]
    elastic = CableRobot(**{**vars(cogiro), "axial_stiffness": np.full(8, 1e5)})
    faces = np.vstack((np.eye(3), -np.eye(3)))
    return {
        "vectors": (lambda turn: spatial_vectors(*robot, place, turn), 2),
        "lengths": (lambda turn: spatial_lengths(*robot, place, turn), 1),
        "structure": (lambda turn: spatial_structure_matrix(*robot, place, turn), 2),
        "derivatives": (lambda turn: spatial_structure_derivatives(*robot, place, turn).pose, 3),
        "stiffness": (lambda turn: spatial_stiffness(*robot, place, turn, np.ones(8), 1e4), 2),
        "mass": (lambda turn: spatial_mass_matrix(5.0, np.eye(3), [0.1, 0.0, 0.0], turn)[..., :3, :], 2),
        "weight": (lambda turn: spatial_weight_derivative([0.0, 0.0, -9.0], [0.1, 0.0, 0.2], turn)[..., :3, :3], 2),
        "inertia": (lambda turn: inertial_wrench(5.0, np.eye(3), np.ones(3), turn, np.ones(3), np.ones(6)), 1),
        "overlap": (lambda turn: platform_overlap(*robot, place, turn, faces, np.full(6, 0.5)), 1),
        "robot lengths": (lambda turn: cogiro.lengths(place, turn), 1),
        "robot structure": (lambda turn: cogiro.structure(place, turn), 2),
        "robot weight": (lambda turn: cogiro.weight([0.0, 0.0, -9.81], place, turn)[..., :3], 1),
        "robot mass": (lambda turn: cogiro.mass_matrix(place, turn)[..., :3, :], 2),
        "robot stiffness": (lambda turn: elastic.stiffness(np.ones(8), [0.0, 0.0, -9.81], place, turn), 2),
    }


def test_one_matrix_that_is_no_rotation_is_refused_everywhere(questions):
    for name, (question, _) in questions.items():
        for matrix in NO_ROTATIONS:
            with pytest.raises(InputError) as refused:
                question(matrix)
            assert refused.value.where in ("rotation", "rotations"), name


def test_a_matrix_among_many_that_is_no_rotation_stops_no_other(questions):
    unknown = np.full((3, 3), np.nan)
    for name, (question, own) in questions.items():
        answers = question(np.stack((np.eye(3), *NO_ROTATIONS, unknown)))
        axes = tuple(range(1, 1 + own))
        assert np.isfinite(answers[0]).all(), name
        assert np.isnan(answers[1:]).any(axis=axes).all(), name
        np.testing.assert_allclose(answers[0], question(np.eye(3)), err_msg=name)
        assert np.isnan(question(unknown)).any(), name


def test_maps_leave_out_the_poses_whose_matrix_is_no_rotation(cogiro):
    robot, place = (cogiro.anchors, cogiro.attachments), [1.0, 0.5, 2.0]
    turns = np.stack((np.eye(3), *NO_ROTATIONS))
    weight = cogiro.weight([0.0, 0.0, -9.81], place, np.eye(3))
    held = spatial_feasibility_map(*robot, place, turns, cogiro.lower, cogiro.upper, weight)
    np.testing.assert_array_equal(held.feasible, [True, *[False] * len(NO_ROTATIONS)])
    assert (held.status[1:] == FeasibilityStatus.UNDEFINED).all()
    np.testing.assert_array_equal(spatial_closure_map(*robot, place, turns)[1:], 0.0)
    for matrix in NO_ROTATIONS:
        with pytest.raises(InputError, match="rotations"):
            spatial_closure_map(*robot, place, matrix)


def test_rotations_within_rounding_are_rotations():
    given = np.eye(3)
    given[0, 0] += 1e-10
    np.testing.assert_array_equal(rotation_matrices("rotation", given), given)
    given[0, 0] += 1e-8
    with pytest.raises(InputError, match="rotation"):
        rotation_matrices("rotation", given)
    assert rotation_matrices("rotation", np.empty((0, 3, 3))).shape == (0, 3, 3)
    mine = np.stack((np.eye(3), 2.0 * np.eye(3)))
    rotation_matrices("rotation", mine)
    np.testing.assert_array_equal(mine[1], 2.0 * np.eye(3))


def test_an_interference_gap_at_no_position_is_none(cogiro):
    around = Surroundings.of(cogiro.anchors, cogiro.attachments, np.eye(3))
    gaps, causes = interference_gaps(around, [[1.0, 0.5, 2.0], [np.nan, 0.0, 2.0], [np.inf, 0.0, 2.0]])
    assert np.isfinite(gaps[0]) and np.isnan(gaps[1:]).all()
    assert causes[0] >= 0 and (causes[1:] == -1).all()


def test_whole_numbers_are_neither_truth_values_nor_have_a_point():
    assert whole("n", 3, 0, 3) == whole("n", np.int64(3), 0, 3) == whole("n", np.array(3), 0, 3) == 3
    for value in (True, np.True_, 1.0, np.float64(1.0), "1", None, [1], np.array([1]), -1, 4, 10**400):
        with pytest.raises(InputError) as refused:
            whole("n", value, 0, 3)
        assert refused.value.where == "n"


def test_a_lost_cable_is_one_of_those_that_are_there():
    platform = LockedPlatform.planar(**SQUARE, unstressed=np.full(4, 1.5), weight=[0.0, -9.81])
    for cable in (True, np.True_, 1.0, "1", None, -1, 4, np.arange(2), np.array([1.0]), [[1, 2], [3]]):
        with pytest.raises(InputError) as refused:
            lost_cable(platform, cable, [0.0, 0.0], 0.0)
        assert refused.value.where == "cable" and "\n" not in str(refused.value)
        with pytest.raises(InputError, match="cable"):
            lost_cable_map(platform, [[0.0, 0.0]], [0.0], cables=[cable])
    for cables in (2, 2.0, True, np.array(2), "12"):
        with pytest.raises(InputError, match="cable"):
            lost_cable_map(platform, [[0.0, 0.0]], [0.0], cables=cables)
    for stride in ("a", None, [0.1], 0.0, 2.0, np.nan):
        with pytest.raises(InputError, match="stride"):
            lost_cable(platform, 1, [0.0, 0.0], 0.0, stride=stride)
        with pytest.raises(InputError, match="stride"):
            lost_cable_map(platform, [[0.0, 0.0]], [0.0], stride=stride)


def test_a_positive_number_is_one_number():
    assert positive("step", np.array(0.5)) == positive("step", 0.5) == 0.5
    for value in ("0.5", None, [0.5], np.array([0.5]), 0.0, -1.0, np.nan, np.inf, 1j):
        with pytest.raises(InputError, match="step"):
            positive("step", value)


def test_limits_name_the_first_cable_that_is_wrong():
    with pytest.raises(InputError) as refused:
        limits(np.full(500, 1.23456789), np.r_[np.full(2, 9.0), -np.pi, np.full(497, 0.5)], 500)
    assert str(refused.value) == "tension limits: 1.23457 to -3.14159 N of cable 3; numbers, least not above greatest"
    for window in ((1.0, np.inf), (-1e308, 1e308)):
        low, high = limits(*window, 4)
        assert low.shape == high.shape == (4,)
        with pytest.raises(InputError, match="finite windows"):
            finite_limits(*window, 4)
    for window in (("1", "2"), (None, 2.0), ([1.0, 2.0], 3.0), (np.nan, 2.0), (np.inf, np.inf)):
        with pytest.raises(InputError, match="tension limits"):
            limits(*window, 4)


@pytest.mark.parametrize(("lower", "upper"), [(0.0, 0.0), (5.0, 5.0), ([1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 4.0])])
def test_a_grid_and_a_pose_agree_where_no_window_has_a_width(lower, upper):
    x, y = np.meshgrid(GRID["xs"], GRID["ys"])
    structure = planar_structure_matrix(**SQUARE, pose=np.stack((x, y, np.full_like(x, 0.1)), axis=-1))
    tensions = np.broadcast_to(np.asarray(lower, dtype=np.float64), 4)
    for wrench in (-structure[0, 0] @ tensions, np.array([0.0, -9.81, 0.0]), np.zeros(3)):
        grid = margin_grid(**GRID, wrench=wrench, lower=lower, upper=upper)
        pose = distribute(structure, wrench, lower, upper)
        np.testing.assert_array_equal(grid >= 0.0, pose.feasible)
        np.testing.assert_allclose(grid, pose.margin, rtol=1e-9, atol=1e-12)
    assert margin_grid(**GRID, wrench=-structure[0, 0] @ tensions, lower=lower, upper=upper)[0, 0] == 0.0


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"stays": np.zeros((4, 2))}, "stays"),
        ({"stays": np.full((4, 2), 1.0)}, "stays"),
        ({"stays": np.full((4, 2), 1e200)}, "stays"),
        ({"stays": [[0.0, 1.0]] * 3}, "stays"),
        ({"wrench": [[0.0, 1.0, 0.0]]}, "wrench"),
        ({"lower": -1e308, "upper": 1e308}, "tension limits"),
        ({"pull_limit": np.ones((1, 4)), "stays": [[0.0, 1.0]] * 4}, "pull limit"),
    ],
)
def test_margins_refuse(changes, where):
    with pytest.raises(InputError) as refused:
        margin_grid(**{**GRID, "wrench": [0.0, -9.81, 0.0], "lower": 1.0, "upper": 9.0, **changes})
    assert refused.value.where == where


def test_grids_that_fit_in_no_memory_are_refused():
    for arguments in ((0.0, 1e300, 1.0), (0.0, 1.0, 1e-300), (0.0, 1.0, 1e-9), (1e300, 1e300, 1.0), (0.0, 1.0, "0.1")):
        with pytest.raises(InputError, match="step"):
            grid_nodes(*arguments)
    for changes in ({"phis": []}, {"nodes": 0}, {"nodes": -1}, {"nodes": 2.5}, {"nodes": True}, {"phis": "x"}):
        with pytest.raises(InputError, match=next(iter(changes))):
            best_node(**{**SQUARE, "phis": [0.0], **changes})
    sealed = np.empty((2, 3))
    sealed.flags.writeable = False
    for out in (sealed, sealed.tolist(), "out"):
        with pytest.raises(InputError, match="out"):
            tension_factor_grid(**GRID, out=out)


def test_loaded_lengths_refuse_cables_that_are_none():
    np.testing.assert_allclose(loaded_lengths([1.0, 2.0], [50.0, -5.0], 100.0), [1.5, 2.0])
    np.testing.assert_allclose(loaded_lengths([1.0, 2.0], [50.0, 5.0], np.inf), [1.0, 2.0])
    for changes in ({"axial_stiffness": 0.0}, {"axial_stiffness": [1.0, -1.0]}, {"tensions": [1.0] * 3}):
        with pytest.raises(InputError):
            loaded_lengths(**{"unstretched": [1.0, 2.0], "tensions": [1.0, 1.0], "axial_stiffness": 1e5, **changes})


def test_pose_rates_of_a_singular_or_unknown_pose_are_none(rng):
    good = rng.normal(size=(3, 4))
    flat = good * [[1.0], [1.0], [0.0]]
    structures = np.stack((good, np.zeros((3, 4)), flat, np.full((3, 4), np.nan), 1e250 * good))
    velocity = np.array([0.2, -0.4, 0.1])
    rates = -np.swapaxes(good, -1, -2) @ velocity
    found = pose_rates(structures, rates)
    np.testing.assert_allclose(found[0], velocity)
    np.testing.assert_allclose(found[4] * 1e250, velocity)
    assert np.isnan(found[1:4]).all()
    assert np.isnan(pose_rates(good, [1.0, 2.0, np.nan, 0.0])).all()
    assert np.isnan(pose_rates(good[:, :2], [1.0, 2.0])).all()


@pytest.mark.parametrize("scale", [1e-250, 1e-100, 1e100, 1e250])
def test_the_capacity_margin_grows_with_the_structure_at_any_scale(scale):
    structure = planar_structure_matrix(**SQUARE, pose=[0.1, 0.2, 0.1])
    one, other = (wrench_feasible(s * structure, 1.0, 9.0, np.zeros(3)) for s in (1.0, scale))
    assert one.status == other.status == FeasibilityStatus.FEASIBLE
    assert other.margin == pytest.approx(scale * one.margin, rel=1e-9)


def test_an_inertial_wrench_of_many_bodies_at_once():
    many = planar_inertial_wrench(5.0, [0.3, 0.4], [0.1, 0.0], 0.2, 0.1, [1.0, 0.0, 2.0])
    for k, inertia in enumerate((0.3, 0.4)):
        np.testing.assert_allclose(many[k], planar_inertial_wrench(5.0, inertia, [0.1, 0.0], 0.2, 0.1, [1.0, 0.0, 2.0]))
    with pytest.raises(InputError):
        planar_inertial_wrench(5.0, [[0.3], []], [0.1, 0.0], 0.2, 0.1, [1.0, 0.0, 2.0])
