"""Feasible polygons of robots with two cables too many, against Qhull and linear programs, and degenerate ones."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import DistributionStatus, certificate_gap, distribute, null_space, tension_polygon
from steeplejack.mechanics.cable.tension.polygon import centroid


def questions(rng, n, count, outside=20.0):
    m = n + 2
    structures = rng.normal(size=(count, n, m))
    lower = rng.uniform(0.0, 50.0, (count, m))
    upper = lower + rng.uniform(20.0, 100.0, (count, m))
    inside = rng.uniform(lower - outside, upper + outside)
    return structures, -np.einsum("kij,kj->ki", structures, inside), lower, upper


def half_planes(structure, wrench, lower, upper):
    """Sides ``G x <= h`` in the plane of a null basis, with the basis and the least-norm tensions."""
    basis, start = null_space(structure).basis, -np.linalg.pinv(structure) @ wrench
    return np.vstack((-basis, basis)), np.concatenate((start - lower, upper - start)), basis, start


def inner_circle(sides, limits):
    """Centre and radius of the largest circle by HiGHS."""
    rows = np.column_stack((sides, np.linalg.norm(sides, axis=1)))
    return linprog([0, 0, -1], A_ub=rows, b_ub=limits, bounds=[(None, None)] * 3).x


@pytest.mark.parametrize("n", [1, 3, 6])
def test_polygons_are_those_of_qhull(rng, n):
    asked = questions(rng, n, 150, outside=0.0)
    answer = tension_polygon(*asked)
    assert np.count_nonzero(answer.count) > 30
    for k, count in enumerate(answer.count):
        question = [array[k] for array in asked]
        sides, limits, basis, start = half_planes(*question)
        *centre, radius = inner_circle(sides, limits)
        assert (count > 0) == (radius > 0.0)
        if count == 0:
            continue
        corners = answer.corners[k, :count]
        np.testing.assert_allclose(question[0] @ corners.T, -question[1][:, None] + np.zeros(count), atol=1e-9)
        expected = ConvexHull(HalfspaceIntersection(np.column_stack((sides, -limits)), np.array(centre)).intersections)
        found = ConvexHull((corners - start) @ basis)
        assert len(found.vertices) == len(expected.vertices) == count
        assert found.volume == pytest.approx(expected.volume, rel=1e-9)
        order = np.diff(np.append(found.vertices, found.vertices[0])) % count
        assert set(order) in ({1}, {count - 1})


def test_sides_name_the_bound_that_is_met(rng):
    asked = questions(rng, 6, 100, outside=-5.0)
    answer = tension_polygon(*asked)
    assert (answer.count >= 3).all()
    for k, count in enumerate(answer.count):
        for corner in range(count):
            cable, upper = answer.sides[k, corner] % 8, answer.sides[k, corner] >= 8
            both = answer.corners[k, [corner, (corner + 1) % count], cable]
            np.testing.assert_allclose(both, asked[3 if upper else 2][k, cable], atol=1e-8)
        assert (answer.sides[k, count:] == -1).all()


@pytest.mark.parametrize("n", [1, 3, 6])
def test_every_empty_polygon_proves_itself(rng, n):
    asked = questions(rng, n, 400, outside=60.0)
    answer = tension_polygon(*asked)
    empty = answer.count == 0
    assert np.count_nonzero(empty) > 100
    assert (certificate_gap(answer.certificate, *asked)[empty] > 0.0).all()
    assert np.isnan(answer.certificate[~empty]).all()


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_units_do_not_matter(rng, scale):
    structures, wrenches, lower, upper = questions(rng, 6, 100)
    answer = tension_polygon(structures, wrenches, lower, upper)
    forces = tension_polygon(structures, scale * wrenches, scale * lower, scale * upper)
    lengths = np.array([scale] * 3 + [1.0] * 3)
    moments = tension_polygon(structures * lengths[:, None], wrenches * lengths, lower, upper)
    for other, unit in ((forces, scale), (moments, 1.0)):
        np.testing.assert_array_equal(other.count, answer.count)
        full = answer.count > 0
        np.testing.assert_allclose(
            np.nanmax(other.corners[full], axis=1) / unit, np.nanmax(answer.corners[full], axis=1), rtol=1e-7
        )


def square(n_rows=1):
    """One equation, three cables: f1 + f2 + f3 = 100, with room to spare on the first two."""
    return np.ones((n_rows, 3)), np.full(n_rows, -100.0)


def test_a_triangle_by_hand():
    answer = tension_polygon(*square(), 0.0, 1000.0)
    assert answer.count == 3
    assert {tuple(np.round(corner, 9)) for corner in answer.corners[:3]} == {(100, 0, 0), (0, 100, 0), (0, 0, 100)}
    assert set(answer.sides[:3]) == {0, 1, 2}


def test_a_point_and_a_segment():
    point = tension_polygon(*square(), [20.0, 30.0, 50.0], [120.0, 130.0, 150.0])
    assert point.count == 1
    np.testing.assert_allclose(point.corners[0], [20.0, 30.0, 50.0], atol=1e-9)
    segment = tension_polygon(*square(), [0.0, 0.0, 40.0], [100.0, 100.0, 40.0])
    assert segment.count == 2
    ends = {tuple(np.round(corner, 9)) for corner in segment.corners[:2]}
    assert ends == {(60.0, 0.0, 40.0), (0.0, 60.0, 40.0)}


def test_parallel_sides_and_a_tension_the_load_fixes():
    structure = np.array([[1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 2.0]])
    wrench = np.array([-100.0, -80.0])
    held = tension_polygon(structure, wrench, 0.0, [30.0, 100.0, 100.0, 40.0])
    assert held.count == 4
    np.testing.assert_allclose(held.corners[:4, 3], 40.0)
    for upper in (39.0, 40.0 - 1e-5):
        empty = tension_polygon(structure, wrench, 0.0, [30.0, 100.0, 100.0, upper])
        assert empty.count == 0
        assert certificate_gap(empty.certificate, structure, wrench, 0.0, [30.0, 100.0, 100.0, upper]) > 0.0
    alike = np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])
    box = tension_polygon(alike, [-60.0, 0.0], [10.0, 20.0, 5.0, 0.0], [100.0, 100.0, 50.0, 40.0])
    assert box.count == 4
    np.testing.assert_allclose(np.sort(box.corners[:4, 0]), [10.0, 10.0, 40.0, 40.0])
    np.testing.assert_allclose(np.sort(box.corners[:4, 2]), [5.0, 5.0, 40.0, 40.0])


def test_a_window_upside_down_is_empty():
    answer = tension_polygon(*square(), [0.0, 0.0, 50.0], [100.0, 100.0, 40.0])
    assert answer.count == 0
    assert np.isnan(answer.certificate).all()


def test_singular_and_undefined_have_no_corners(rng):
    structure = rng.normal(size=(6, 8))
    structure[5] = structure[:5].sum(axis=0)
    wrench = rng.normal(size=6)
    answer = tension_polygon(structure, wrench, 0.0, 100.0)
    assert answer.count == 0
    assert certificate_gap(answer.certificate, structure, wrench, 0.0, 100.0) > 0.0
    structure[2, 2] = np.nan
    undefined = tension_polygon(structure, wrench, 0.0, 100.0)
    assert undefined.count == 0
    assert np.isnan(undefined.certificate).all()


@pytest.mark.parametrize(
    ("points", "expected"),
    [
        ([[0, 0], [3, 0], [0, 3]], (1.0, 1.0)),
        ([[0, 0], [4, 0], [4, 2], [0, 2]], (2.0, 1.0)),
        ([[0, 0], [2, 0], [2, 1], [1, 2], [0, 2]], (19.0 / 21.0, 19.0 / 21.0)),  # a square less a corner
        ([[0, 0], [3, 4]], (1.5, 2.0)),
        ([[5, 6]], (5.0, 6.0)),
    ],
)
def test_centroids_of_shapes_one_can_do_by_hand(points, expected):
    corners = np.array(points, dtype=np.float64)
    np.testing.assert_allclose(centroid(corners, len(corners)), expected, atol=1e-14)
    np.testing.assert_allclose(np.array(centroid(corners + 1e6, len(corners))) - 1e6, expected, atol=1e-9)


@pytest.mark.parametrize("shape", [(3, 4), (6, 9)])
def test_other_redundancies_are_refused(shape):
    with pytest.raises(InputError, match="two cables too many"):
        tension_polygon(np.zeros(shape), np.zeros(shape[0]), 0.0, 1.0)


def test_a_cable_without_length_leaves_no_polygon_as_it_leaves_no_distribution():
    structure = np.array([[1.0, 1.0, 0.0, 1.0], [0.0, 0.0, 0.0, 2.0]])
    answer = tension_polygon(structure, [-1.0, -1.0], 0.0, 10.0)
    assert answer.count == 0
    assert np.isnan(answer.certificate).all()
    assert distribute(structure, [-1.0, -1.0], 0.0, 10.0).status == DistributionStatus.UNDEFINED


def test_a_wide_window_does_not_soften_the_sides_of_others():
    structure, wrench = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]]), np.array([0.0, -1.0])
    assert tension_polygon(structure, wrench, 0.0, [1e9, 1e9, 1.0, 1.0]).count > 0
    for upper in (0.9, 1.0 - 1e-4):
        asked = structure, wrench, 0.0, [1e9, 1e9, upper, 1.0]
        empty = tension_polygon(*asked)
        assert empty.count == 0
        assert certificate_gap(empty.certificate, *asked) > 0.0
