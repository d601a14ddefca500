"""Compiled maps against the general functions, published node counts, and degenerate robots."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    best_node,
    distribute,
    grid_nodes,
    margin_grid,
    planar_structure_matrix,
    tension_factor,
    tension_factor_grid,
)


def poses(phi, xs, ys):
    x, y = np.meshgrid(xs, ys)
    return np.stack((x, y, np.full(x.shape, phi)), axis=-1)


def random_robot(rng):
    anchors = np.array([[-2.0, -1.5], [2.0, -1.2], [2.3, 1.4], [-1.6, 1.8]]) + rng.uniform(-0.8, 0.8, (4, 2))
    return anchors, np.array([[-0.4, -0.3], [0.5, -0.2], [0.3, 0.4], [-0.2, 0.5]]) + rng.uniform(-0.1, 0.1, (4, 2))


def test_nodes_are_multiples_of_the_step_with_both_ends():
    np.testing.assert_array_equal(grid_nodes(-0.6244, 0.4024, 0.01), np.arange(-62, 41) * 0.01)
    assert grid_nodes(0.3, 0.9, 0.1).size == 7
    assert grid_nodes(0.31, 0.39, 0.1).size == 0


@pytest.mark.parametrize("origin", [0.0, 1000.0])
def test_kernel_equals_the_general_tension_factor(rng, origin):
    xs, ys = np.linspace(-2.0, 2.0, 83), np.linspace(-1.5, 1.5, 61)
    for phi in (-0.2, 0.05, 0.3, 3.0):
        anchors, attachments = random_robot(rng)
        grid = tension_factor_grid(anchors + origin, attachments, phi, xs + origin, ys + origin)
        general = tension_factor(planar_structure_matrix(anchors, attachments, poses(phi, xs, ys)))
        np.testing.assert_allclose(grid, general, atol=1e-9)


def test_node_counts_and_factors_of_independent_robots(reference):
    for robot in reference["robot"]:
        anchors, attachments = np.array(robot["anchors"]), np.array(robot["attachments"])
        xs, ys = (np.linspace(low, high, int(count)) for low, high, count in (robot["x"], robot["y"]))
        for phi, inside in robot["inside"]:
            assert np.count_nonzero(tension_factor_grid(anchors, attachments, phi, xs, ys)) == inside
        for x, y, phi, factor in robot["factors"]:
            grid = tension_factor_grid(anchors, attachments, phi, [x], [y])
            assert grid[0, 0] == pytest.approx(factor, abs=5e-7)


def test_reference_maps_of_table_iii(reference):
    table = reference["table_iii"]
    xs, ys = grid_nodes(-0.6244, 0.4024, 0.01), grid_nodes(0.0, 0.8966, 0.01)
    for given in reference["map"]:
        phi = np.deg2rad(given["phi_deg"])
        factors = tension_factor_grid(table["anchors"], table["attachments"], phi, xs, ys)
        inside = factors[factors > 0.0]
        assert inside.size == given["inside"]
        assert inside.max() == pytest.approx(given["max"], rel=1e-6, abs=5e-7)
        assert inside.mean() == pytest.approx(given["mean"], rel=1e-6, abs=5e-7)


def test_structurally_singular_robots_are_nowhere_inside():
    xs = np.linspace(-0.9, 0.9, 37)
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    assert not tension_factor_grid(square, np.zeros((4, 2)), 0.3, xs, xs).any()
    assert not tension_factor_grid(square, np.tile([0.1, 0.05], (4, 1)), 0.3, xs, xs).any()


def test_a_symmetric_robot_at_exactly_zero_angle(reference):
    robot = next(robot for robot in reference["robot"] if robot["name"] == "KNTU planar")
    xs = np.linspace(-0.9, 0.9, 37)
    grid = tension_factor_grid(robot["anchors"], robot["attachments"], 0.0, xs, xs)
    general = tension_factor(planar_structure_matrix(robot["anchors"], robot["attachments"], poses(0.0, xs, xs)))
    np.testing.assert_allclose(grid, general, atol=1e-9)
    np.testing.assert_array_equal(grid > 0.0, general > 0.0)


def test_an_anchor_under_the_attachment_is_outside(reference):
    table = reference["table_iii"]
    assert tension_factor_grid(table["anchors"], table["attachments"], 0.0, [0.095], [0.095])[0, 0] == 0.0


def test_empty_grids():
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    assert tension_factor_grid(square, 0.1 * square, 0.1, [], [0.0, 0.1]).shape == (2, 0)
    assert tension_factor_grid(square, 0.1 * square, 0.1, [0.0], []).shape == (0, 1)


def test_margins_equal_the_general_distribution(rng):
    xs, ys = np.linspace(-1.5, 1.5, 25), np.linspace(-1.2, 1.2, 19)
    wrench, lower, upper = np.array([5.0, -90.0, 1.5]), np.array([5.0, 10.0, 20.0, 5.0]), np.array([200.0, 90, 150, 80])
    for phi in (-0.3, 0.1, 2.0):
        anchors, attachments = random_robot(rng)
        grid = margin_grid(anchors, attachments, phi, xs, ys, wrench, lower, upper)
        general = distribute(planar_structure_matrix(anchors, attachments, poses(phi, xs, ys)), wrench, lower, upper)
        np.testing.assert_allclose(grid, general.margin, rtol=1e-9, atol=1e-9)


def test_pull_limits_bound_the_component_along_the_stay(rng):
    xs, ys = np.linspace(-1.5, 1.5, 25), np.linspace(-1.2, 1.2, 19)
    anchors, attachments = random_robot(rng)
    slope = rng.uniform(-np.pi, np.pi, 4)
    stays = np.stack((np.cos(slope), np.sin(slope)), axis=-1)
    limit = np.array([80.0, 60.0, 100.0, np.inf])
    grid = margin_grid(anchors, attachments, 0.1, xs, ys, [0.0, -90.0, 0.0], 5.0, 200.0, stays, limit)
    structure = planar_structure_matrix(anchors, attachments, poses(0.1, xs, ys))
    along = np.abs(np.einsum("...ic,ci->...c", structure[..., :2, :], stays))
    upper = np.minimum(200.0, limit / along)
    answer = distribute(structure, [0.0, -90.0, 0.0], 5.0, upper)
    np.testing.assert_array_equal(grid >= 0.0, answer.feasible)
    pull = (answer.tensions * along)[answer.feasible]
    assert (pull <= limit + 1e-6).all()
    unlimited = margin_grid(anchors, attachments, 0.1, xs, ys, [0.0, -90.0, 0.0], 5.0, 200.0)
    assert (unlimited >= grid).all()
    assert 0 < np.count_nonzero(grid >= 0.0) < np.count_nonzero(unlimited >= 0.0)


def test_best_node_finds_the_neighbourhood_of_the_balanced_pose(reference):
    table, (x, y, phi) = reference["table_iii"], reference["balanced"]["x_y_phi_deg"]
    pose, factor = best_node(table["anchors"], table["attachments"], np.deg2rad(np.arange(-180.0, 180.0, 5.0)))
    assert factor > 0.9
    np.testing.assert_allclose(pose, [x, y, np.deg2rad(phi)], atol=0.1)


def test_best_node_of_a_robot_that_holds_nothing():
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    pose, factor = best_node(square, np.zeros((4, 2)), [0.3])
    assert factor == 0.0
    assert np.abs(pose[:2]).max() < 0.1


def test_a_far_anchor_or_a_far_row_does_not_flatten_the_others():
    anchors = np.array([[-3.0, -2.0], [3.0, -2.2], [2.5, 2.6], [-2.4e4, 2.2e4]])
    attachments = np.array([[-0.5, -0.4], [0.5, -0.5], [0.6, 0.5], [-0.5, 0.55]])
    general = tension_factor(planar_structure_matrix(anchors, attachments, [0.0, 0.0, 0.05]))
    assert general == pytest.approx(0.2369, abs=1e-4)
    for ys in ([0.0], [0.0, 1e6]):
        grid = tension_factor_grid(anchors, attachments, 0.05, [0.0], ys)
        assert grid[0, 0] == pytest.approx(general, rel=1e-7)


GRID = {"anchors": np.eye(4, 2), "attachments": 0.1 * np.eye(4, 2), "phi": 0.0, "xs": [0.0, 0.1], "ys": [0.2]}
HELD = {"wrench": [0.0, -9.81, 0.0], "lower": 1.0, "upper": 9.0}


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"anchors": np.eye(5, 2), "attachments": np.eye(5, 2)}, "cables"),
        ({"attachments": np.eye(3, 2)}, "cables"),
        ({"anchors": np.full((4, 2), np.nan)}, "anchors"),
        ({"anchors": "four"}, "anchors"),
        ({"phi": np.inf}, "phi"),
        ({"phi": [0.0, 0.1]}, "grid"),
        ({"xs": [0.0, np.nan]}, "xs"),
        ({"ys": [[0.0], [1.0]]}, "grid"),
    ],
)
def test_grids_that_mean_nothing_are_refused(changes, where):
    for question, more in ((tension_factor_grid, {}), (margin_grid, HELD)):
        with pytest.raises(InputError) as refused:
            question(**{**GRID, **more, **changes})
        assert refused.value.where == where


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"lower": 10.0}, "tension limits"),
        ({"upper": np.inf}, "tension limits"),
        ({"wrench": [0.0, 1.0]}, "wrench"),
        ({"pull_limit": 5.0}, "stays"),
        ({"pull_limit": -5.0, "stays": np.ones((4, 2))}, "pull limit"),
        ({"pull_limit": [1.0, 2.0], "stays": np.ones((4, 2))}, "pull limit"),
    ],
)
def test_margins_that_mean_nothing_are_refused(changes, where):
    with pytest.raises(InputError) as refused:
        margin_grid(**{**GRID, **HELD, **changes})
    assert refused.value.where == where


def test_what_no_grid_is_made_of_is_refused():
    for ends in ((0.0, np.inf, 0.1), (np.nan, 1.0, 0.1), (0.0, 1.0, 0.0), (0.0, 1.0, -0.1), (0.0, 1.0, np.nan)):
        with pytest.raises(InputError):
            grid_nodes(*ends)
    for out in (np.empty((2, 1)), np.empty((1, 2), np.float32), np.empty((1, 4))[:, ::2]):
        with pytest.raises(InputError):
            tension_factor_grid(**GRID, out=out)
