"""Wrench closure for any number of cables: linear programs, rational arithmetic, certificates, counts, degeneracies."""

from __future__ import annotations

from math import comb

import numpy as np
import oracles
import pytest
from published_robots import COGIRO, IPANEMA_2, PLANAR, PLANAR_4_4, SPATIAL, rotations
from scipy.spatial import ConvexHull

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    ClosureStatus,
    planar_structure_matrix,
    spatial_closure_map,
    spatial_structure_matrix,
    tension_factor,
    wrench_closure,
)
from steeplejack.mechanics.cable.wrench.hyperplanes import factors_each

pytestmark = pytest.mark.long


def structures_of(robot, rng, count):
    poses = robot.poses(rng, count)
    if robot.dimension == 2:
        return planar_structure_matrix(robot.anchors, robot.attachments, poses)
    return spatial_structure_matrix(robot.anchors, robot.attachments, *poses)


def random_structures(rng, count, n, m):
    """Cables around a platform: about half the poses in closure whatever n and m."""
    if n == 3:
        anchors, attachments = rng.normal(size=(count, m, 2)), 0.3 * rng.normal(size=(m, 2))
        anchors *= 2.0 / np.linalg.norm(anchors, axis=-1, keepdims=True)
        return planar_structure_matrix(anchors, attachments, rng.uniform(-0.5, 0.5, (count, 3)))
    if n == 6:
        anchors, attachments = rng.normal(size=(count, m, 3)), 0.5 * rng.normal(size=(m, 3))
        anchors *= 3.0 / np.linalg.norm(anchors, axis=-1, keepdims=True)
        positions, turns = rng.uniform(-0.5, 0.5, (count, 3)), rotations(rng.uniform(-0.5, 0.5, (count, 3)))
        return spatial_structure_matrix(anchors, attachments, positions, turns)
    return rng.normal(size=(count, n, m))


def by_hyperplanes(structures):
    """The general path alone."""
    count, n, m = structures.shape
    factors, proofs, status = np.empty(count), np.empty((count, n)), np.empty(count, np.int64)
    factors_each(structures, comb(m, n - 1), factors, proofs, status)
    return factors


@pytest.mark.parametrize("robot", PLANAR + SPATIAL, ids=lambda r: r.name)
def test_published_robots_agree_with_a_linear_program(robot, rng):
    structures = structures_of(robot, rng, 500)
    answer = wrench_closure(structures)
    if robot is not COGIRO:
        assert 50 < answer.inside.sum() < 450
    for structure, inside, factor in zip(structures, answer.inside, answer.factor, strict=True):
        margin = oracles.closure_margin(structure)
        assert factor == pytest.approx(max(margin, 0.0), abs=oracles.BAND)
        assert inside == (margin > oracles.BAND)
    for structure in structures[~answer.inside][:100]:  # no tensions at all is the best the program finds outside
        assert not oracles.closes_exactly(structure)
    for structure, z in zip(structures[~answer.inside], answer.certificate[~answer.inside], strict=True):
        assert oracles.separates(z, structure)


@pytest.mark.parametrize(("n", "m"), [(2, 3), (2, 6), (3, 5), (3, 6), (3, 9), (6, 7), (6, 8), (6, 9), (6, 11)])
def test_any_number_of_cables_agrees_with_a_linear_program(n, m, rng):
    structures = random_structures(rng, 60, n, m)
    answer = wrench_closure(structures)
    np.testing.assert_allclose(answer.factor, by_hyperplanes(structures), rtol=1e-9)
    for structure, factor in zip(structures, answer.factor, strict=True):
        assert factor == pytest.approx(max(oracles.closure_margin(structure), 0.0), abs=oracles.BAND)
    for structure, z in zip(structures[~answer.inside], answer.certificate[~answer.inside], strict=True):
        assert oracles.separates(z, structure)


def test_closure_is_zero_inside_the_hull_of_the_columns(rng):
    for n, m in ((3, 6), (6, 10)):
        for structure in random_structures(rng, 40, n, m):
            hull = ConvexHull(structure.T)
            assert wrench_closure(structure).inside == (hull.equations[:, -1].max() < 0.0)


def test_one_cable_too_many_is_eq_12(rng):
    structures = random_structures(rng, 2000, 3, 4)
    np.testing.assert_allclose(by_hyperplanes(structures), tension_factor(structures), rtol=1e-8)
    np.testing.assert_allclose(wrench_closure(structures).factor, tension_factor(structures), rtol=1e-8)


def test_counts_of_the_published_planar_robots(reference):
    for robot in reference["robot"]:
        xs, ys = np.linspace(*robot["x"][:2], int(robot["x"][2])), np.linspace(*robot["y"][:2], int(robot["y"][2]))
        for phi, inside in robot["inside"]:
            x, y = np.meshgrid(xs, ys)
            poses = np.stack((x, y, np.full_like(x, phi)), axis=-1)
            answer = wrench_closure(planar_structure_matrix(robot["anchors"], robot["attachments"], poses))
            assert answer.inside.sum() == inside
        for x, y, phi, factor in robot["factors"]:
            structure = planar_structure_matrix(robot["anchors"], robot["attachments"], [x, y, phi])
            assert wrench_closure(structure).factor == pytest.approx(factor, abs=5e-7)


def test_a_suspended_robot_is_nowhere_in_closure(rng):
    positions, turns = COGIRO.poses(rng, 20000)
    assert not spatial_closure_map(COGIRO.anchors, COGIRO.attachments, positions, turns).any()
    answer = wrench_closure(structures_of(COGIRO, rng, 200))
    assert (answer.status == ClosureStatus.OUTSIDE).all()


def test_map_from_poses_is_the_factor_of_the_structure_matrices(rng):
    extra = np.array([[0.3, 0.1, 5.5], [0.2, -3.4, 2.0]])
    anchors = np.vstack((IPANEMA_2.anchors, extra))
    attachments = np.vstack((IPANEMA_2.attachments, [[0.1, 0.2, 0.4], [-0.2, -0.1, 0.3]]))
    positions, turns = IPANEMA_2.poses(rng, 500)
    for cables, some in ((6, False), (8, True), (9, True), (10, True)):
        factors = spatial_closure_map(anchors[:cables], attachments[:cables], positions, turns)
        structures = spatial_structure_matrix(anchors[:cables], attachments[:cables], positions, turns)
        np.testing.assert_allclose(factors, by_hyperplanes(structures), rtol=1e-8)
        assert (factors > 0.0).any() == some


def test_map_broadcasts_positions_over_rotations(rng):
    positions, turns = IPANEMA_2.poses(rng, 6)
    grid = spatial_closure_map(IPANEMA_2.anchors, IPANEMA_2.attachments, positions[:, None], turns[:4])
    assert grid.shape == (6, 4)
    one = spatial_closure_map(IPANEMA_2.anchors, IPANEMA_2.attachments, positions[2], turns[3])
    assert grid[2, 3] == pytest.approx(float(one), rel=1e-12)


@pytest.mark.parametrize("unit", [1e-9, 1e-3, 1e9])
@pytest.mark.parametrize("robot", [PLANAR_4_4, IPANEMA_2], ids=lambda r: r.name)
def test_units_of_length_do_not_matter(robot, unit, rng):
    poses = robot.poses(rng, 400)
    if robot.dimension == 2:
        scaled = planar_structure_matrix(unit * robot.anchors, unit * robot.attachments, poses * [unit, unit, 1.0])
        plain = planar_structure_matrix(robot.anchors, robot.attachments, poses)
    else:
        scaled = spatial_structure_matrix(unit * robot.anchors, unit * robot.attachments, unit * poses[0], poses[1])
        plain = spatial_structure_matrix(robot.anchors, robot.attachments, *poses)
        maps = [
            spatial_closure_map(u * robot.anchors, u * robot.attachments, u * poses[0], poses[1]) for u in (unit, 1.0)
        ]
        np.testing.assert_allclose(*maps, rtol=1e-7)
    a, b = wrench_closure(scaled), wrench_closure(plain)
    np.testing.assert_array_equal(a.status, b.status)
    np.testing.assert_allclose(a.factor, b.factor, rtol=1e-7)


def test_leading_axes_are_kept(rng):
    structures = random_structures(rng, 12, 3, 5).reshape(2, 3, 2, 3, 5)
    answer = wrench_closure(structures)
    assert answer.inside.shape == (2, 3, 2)
    assert answer.certificate.shape == (2, 3, 2, 3)
    assert wrench_closure(structures[0, 1, 1]).factor == answer.factor[0, 1, 1]


def test_as_many_cables_as_freedoms_never_close(rng):
    answer = wrench_closure(random_structures(rng, 50, 6, 6))
    assert (answer.status == ClosureStatus.OUTSIDE).all()
    assert np.isfinite(answer.certificate).all()


@pytest.mark.parametrize("rank", [1, 2, 3, 4, 5])
def test_a_singular_pose_comes_with_a_wrench_no_cable_feels(rank, rng):
    for _ in range(20):
        structure = rng.normal(size=(6, rank)) @ rng.normal(size=(rank, 8))
        answer = wrench_closure(structure)
        assert answer.status == ClosureStatus.SINGULAR
        assert tension_factor(structure) == 0.0
        np.testing.assert_allclose(answer.certificate @ structure, 0.0, atol=1e-7 * np.abs(structure).max())


def test_fewer_cables_than_freedoms_are_singular(rng):
    answer = wrench_closure(rng.normal(size=(6, 4)))
    assert answer.status == ClosureStatus.SINGULAR


def test_spatial_cables_through_the_reference_point_resist_no_moment():
    anchors = np.array([[x, y, z] for x in (-1.1, 1.0) for y in (-1.3, 1.2) for z in (-0.9, 1.4)])
    position = np.array([0.1, 0.05, -0.02])
    assert spatial_closure_map(anchors, 0.2 * (anchors - position), position, np.eye(3)) == 0.0
    assert spatial_closure_map(anchors, np.zeros((8, 3)), position, np.eye(3)) == 0.0


def test_a_cable_of_no_length_is_undefined():
    structure = np.array([[1.0, -0.5, -0.5, 0.1, 0.0], [0.0, 0.8, -0.8, 0.2, 0.0], [0.1, 0.2, 0.3, -0.9, 0.0]])
    answer = wrench_closure(structure)
    assert answer.status == ClosureStatus.UNDEFINED
    assert not answer.inside and tension_factor(structure) == 0.0
    ends = IPANEMA_2.anchors.copy()
    ends[3] = IPANEMA_2.attachments[3] + [0.3, 0.2, 1.0]
    assert spatial_closure_map(ends, IPANEMA_2.attachments, [0.3, 0.2, 1.0], np.eye(3)) == 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_undefined(bad, rng):
    structure = random_structures(rng, 1, 6, 8)[0]
    structure[4, 2] = bad
    answer = wrench_closure(structure)
    assert answer.status == ClosureStatus.UNDEFINED
    assert np.isnan(answer.certificate).all()
    assert tension_factor(structure) == 0.0
    assert spatial_closure_map(IPANEMA_2.anchors, IPANEMA_2.attachments, [bad, 0.0, 2.0], np.eye(3)) == 0.0


def test_every_status_says_what_to_do():
    assert all(len(status.advice) > 20 for status in ClosureStatus)


@pytest.mark.parametrize("shape", [(3,), (1, 4), (7, 9), (6, 40), (3, 0)])
def test_shapes_that_are_no_structure_matrix_are_refused(shape):
    with pytest.raises(InputError, match="structure"):
        wrench_closure(np.ones(shape))


def test_anchors_that_do_not_match_attachments_are_refused():
    with pytest.raises(InputError, match="8 anchors and 7 attachments"):
        spatial_closure_map(np.ones((8, 3)), np.ones((7, 3)), np.zeros(3), np.eye(3))


def test_hostile_robots_never_get_a_wrong_answer(rng):
    """Coincident anchors and attachments, cables of no length, numbers that are none, tiny and huge units."""
    for trial in range(3000):
        n, m = (3, rng.integers(3, 7)) if trial % 2 else (6, rng.integers(5, 10))
        structure = hostile(rng, n, m)
        answer = wrench_closure(structure)
        factor, status = float(answer.factor), ClosureStatus(int(answer.status))
        if not np.isfinite(structure).all() or (structure == 0.0).all(axis=0).any():
            assert status is ClosureStatus.UNDEFINED
        elif status is ClosureStatus.INSIDE:
            assert 0.0 < factor <= 1.0
        else:
            assert factor == 0.0 and oracles.separates(answer.certificate, structure, 1e-7)
        if status is ClosureStatus.INSIDE and trial % 10 == 0:
            assert factor == pytest.approx(oracles.closure_margin(structure), abs=oracles.BAND)


def hostile(rng, n, m):
    d = 2 if n == 3 else 3
    anchors, attachments = rng.normal(size=(m, d)), 0.3 * rng.normal(size=(m, d))
    pose = np.zeros(3) if rng.random() < 0.3 else 0.4 * rng.normal(size=3)
    kind = rng.integers(7)
    if kind == 1:
        anchors[1] = anchors[0]
    if kind == 2:
        attachments[1], anchors[1] = attachments[0], anchors[0]
    if kind == 3:
        anchors, attachments = np.round(anchors), 0.5 * np.round(attachments * 4.0)
    if kind == 4:
        attachments[:] = attachments[0]
    if kind == 5:
        attachments[0], pose, anchors[0] = 0.0, np.zeros(3), 0.0
    scale = rng.choice([1e-9, 1.0, 1e9])
    anchors, attachments = scale * anchors, scale * attachments
    if d == 2:
        structure = planar_structure_matrix(anchors, attachments, pose * [scale, scale, 1.0])
    else:
        turn = rotations(rng.normal(size=(1, 3)) if rng.random() < 0.5 else np.zeros((1, 3)))[0]
        structure = spatial_structure_matrix(anchors, attachments, scale * pose, turn)
    if kind == 6:
        structure[rng.integers(n), rng.integers(m)] = rng.choice([np.nan, np.inf])
    return structure
