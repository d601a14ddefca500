"""One definition of singular: poses swept through singular ones, on which no two questions contradict each other."""

from __future__ import annotations

import numpy as np
import pytest
from one_pose import assert_consistent

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    ClosureStatus,
    in_wrench_closure,
    is_singular,
    planar_structure_matrix,
    rank,
    spatial_structure_matrix,
    wrench_closure,
)
from steeplejack.mechanics.cable.degeneracy import TOLERANCE

pytestmark = pytest.mark.long

SWEEP = np.concatenate((-(10.0 ** np.linspace(-1, -14, 105)), [0.0], 10.0 ** np.linspace(-14, -1, 105)))
"""Distances from the singular pose, both sides of it; eight a decade."""
SHAPES = [(3, 4), (3, 5), (3, 6), (6, 7), (6, 8), (6, 9)]


def kinds(n):
    """Which rows are moments, (n, 1)."""
    return (np.arange(n) == 2 if n == 3 else np.arange(n) < 3)[:, None]


def windows(rng, structures):
    """Loads of three sizes in turn, and windows, for every pose."""
    k, n, m = structures.shape
    lower = rng.uniform(0.0, 2.0, (k, m))
    load = rng.normal(size=(k, n)) * np.array([0.0, 1.0, 1e3])[np.arange(k) % 3, None]
    size = np.abs(structures).max(axis=-1)
    return load * np.where(size > 0.0, size, 1.0), lower, lower + rng.uniform(1.0, 50.0, (k, m))


@pytest.mark.parametrize(("n", "m"), SHAPES)
@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_matrix_swept_through_a_singular_one(n, m, unit, rng):
    """Least singular value from a tenth of the others through zero, with equal tensions that balance."""
    frame, turn = np.linalg.qr(rng.normal(size=(m, m)))[0], np.linalg.qr(rng.normal(size=(n, n)))[0]
    even = np.ones(m) / np.sqrt(m)
    frame = np.linalg.qr(np.column_stack((even, frame)))[0][:, 1 : n + 1]
    sizes = np.repeat(rng.uniform(0.5, 1.0, (1, n)), SWEEP.size, axis=0)
    sizes[:, -1] = SWEEP
    structures = np.einsum("ij,kj,mj->kim", turn, sizes, frame) * np.where(kinds(n), unit, 1.0)
    status = assert_consistent(structures, *windows(rng, structures))
    assert (status[np.abs(SWEEP) < 0.1 * TOLERANCE] == ClosureStatus.SINGULAR).all()
    assert (status[np.abs(SWEEP) > 10.0 * TOLERANCE] != ClosureStatus.SINGULAR).all()


@pytest.mark.parametrize("m", [4, 5, 6])
@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_planar_robot_swept_through_cables_that_meet_in_a_point(m, unit, rng):
    angle = 2.0 * np.pi * (np.arange(m) + rng.uniform(-0.2, 0.2, m)) / m
    anchors = 2.0 * np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    for meet in (np.zeros(2), np.array([0.3, -0.1])):
        local = meet + 0.2 * (anchors - meet)
        structures = np.array([planar_structure_matrix(unit * anchors, unit * local, [0, 0, s]) for s in SWEEP])
        wrenches, lower, upper = windows(rng, structures)
        status = assert_consistent(structures, wrenches, lower, upper)
        forces = assert_consistent(structures, 1e9 * wrenches, 1e9 * lower, 1e9 * upper)
        np.testing.assert_array_equal(forces, status)
        assert (status[np.abs(SWEEP) < 0.01 * TOLERANCE] == ClosureStatus.SINGULAR).all()
        assert (status[np.abs(SWEEP) > 100.0 * TOLERANCE] != ClosureStatus.SINGULAR).all()


@pytest.mark.parametrize("m", [7, 8, 9])
@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_spatial_robot_swept_through_cables_that_meet_a_line(m, unit, rng):
    anchors = rng.uniform(-2.0, 2.0, (m, 3))
    line = rng.normal(size=3)
    axis = rng.uniform(-0.4, 0.4, (m, 1)) * line / np.linalg.norm(line)
    local, aside = axis + 0.2 * (anchors - axis), rng.normal(size=(m, 3))
    structures = np.array(
        [
            spatial_structure_matrix(unit * anchors, unit * (local + s * aside), unit * np.full(3, 1e-2) * s, np.eye(3))
            for s in SWEEP
        ]
    )
    status = assert_consistent(structures, *windows(rng, structures))
    assert (status[np.abs(SWEEP) < 0.01 * TOLERANCE] == ClosureStatus.SINGULAR).all()
    assert (status[np.abs(SWEEP) > 100.0 * TOLERANCE] != ClosureStatus.SINGULAR).all()


@pytest.mark.parametrize(("n", "m"), SHAPES)
def test_the_frame_and_the_order_of_cables_do_not_matter(n, m, rng):
    structures = rng.normal(size=(SWEEP.size, n, m))
    structures[:, -2] = structures[:, -3] + SWEEP[:, None] * structures[:, -2]
    turn = np.linalg.qr(rng.normal(size=(2, 2) if n == 3 else (3, 3)))[0]
    whole = np.eye(n)
    whole[: len(turn), : len(turn)] = turn
    if n == 6:
        whole[3:, 3:] = turn
    far = np.abs(np.abs(SWEEP) - TOLERANCE) > 0.95 * TOLERANCE
    for same in (whole @ structures, structures[..., rng.permutation(m)], structures * np.where(kinds(n), 1e9, 1e-9)):
        np.testing.assert_array_equal(is_singular(same)[far], is_singular(structures)[far])


@pytest.mark.parametrize(("n", "m"), [*SHAPES, (2, 3), (3, 3), (6, 5), (6, 32)])
def test_rank_is_that_of_the_singular_values(n, m, rng):
    structures = rng.normal(size=(200, n, m)) * 10.0 ** rng.uniform(-0.5, 0.5, (200, 1, m))
    for k, least in enumerate(range(0, min(n, m) - 1, 2)):
        rows = structures[40 * k : 40 * k + 40]
        rows[:] = np.einsum("kij,kjm->kim", rng.normal(size=(40, n, n - least)), rng.normal(size=(40, n - least, m)))
    scaled = structures.copy()
    for block in (kinds(n)[:, 0], ~kinds(n)[:, 0]) if n in (3, 6) else (np.ones(n, bool),):
        scaled[:, block] /= np.linalg.norm(scaled[:, block], axis=1).max(axis=-1)[:, None, None]
    values = np.linalg.svd(scaled, compute_uv=False)
    expected = np.count_nonzero(values > TOLERANCE * values[:, :1], axis=-1)
    np.testing.assert_array_equal(rank(structures), expected)


def test_what_the_cables_do_not_resist_is_the_certificate(rng):
    structures = rng.normal(size=(50, 6, 8)) * np.where(kinds(6), 1e6, 1.0)
    structures[:, 4] = 2.0 * structures[:, 3] - 0.5 * structures[:, 5]
    answer = wrench_closure(structures)
    assert (answer.status == ClosureStatus.SINGULAR).all()
    work = np.einsum("ki,kim->km", answer.certificate, structures)
    np.testing.assert_allclose(work, 0.0, atol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(answer.certificate, axis=-1), 1.0)


def test_cables_through_the_reference_point_resist_no_moment_however_they_round(rng):
    anchors = rng.normal(size=(8, 3))
    structure = spatial_structure_matrix(anchors, 0.1 * anchors, np.zeros(3), np.eye(3))
    assert not structure[:3].any()
    assert rank(structure) == 3


def test_a_cable_shorter_than_rounding_has_no_column(rng):
    anchors = 1e6 + rng.normal(size=(4, 2))
    arms = 0.1 * rng.normal(size=(4, 2))
    pose = np.array([*(anchors[1] - arms[1]), 0.0])
    structure = planar_structure_matrix(anchors, arms, pose)
    assert not structure[:, 1].any()
    assert rank(structure) == -1
    assert not in_wrench_closure(structure)


@pytest.mark.parametrize("bad", [np.zeros(3), np.zeros((0, 4)), np.zeros((3, 0)), "abc", [[1.0, 2.0], [3.0]], 1j])
def test_what_is_no_matrix_is_refused(bad):
    with pytest.raises(InputError, match="structure"):
        rank(bad)
