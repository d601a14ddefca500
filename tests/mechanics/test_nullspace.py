"""Rank, null space, least-norm tensions and what is carried back, against SciPy and NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import RankStatus, null_space
from steeplejack.mechanics.cable.degeneracy import decide, row_scales, unresisted
from steeplejack.mechanics.cable.tension.nullspace import carry_back, decompose, least_norm

SHAPES = [(1, 4), (3, 3), (3, 4), (3, 5), (3, 10), (6, 6), (6, 7), (6, 8), (6, 12)]


def matrices(rng, n, m, count=30):
    """Random matrices whose forces and moments are in wildly different units."""
    unit = np.repeat(10.0 ** rng.uniform(-9.0, 9.0, (count, 1, 1)), n, axis=1)
    unit[:, {3: 2, 6: 3}.get(n, n) :] = 10.0 ** rng.uniform(-9.0, 9.0, (count, 1, 1))
    return rng.normal(size=(count, n, m)) * unit


def factors(structure):
    n, m = structure.shape
    made = np.empty((n, m)), np.empty(n), np.empty(n), np.empty(n, np.int64)
    return decompose(structure, *made), made


@pytest.mark.parametrize(("n", "m"), SHAPES)
def test_null_space_is_scipys(rng, n, m):
    structures = matrices(rng, n, m)
    answer = null_space(structures)
    assert answer.basis.shape == (30, m, m - n)
    assert (answer.status == RankStatus.FULL).all()
    for structure, basis in zip(structures, answer.basis, strict=True):
        rows = structure / np.linalg.norm(structure, axis=1, keepdims=True)
        expected = linalg.null_space(rows)
        np.testing.assert_allclose(basis @ basis.T, expected @ expected.T, atol=1e-12)
        np.testing.assert_allclose(basis.T @ basis, np.eye(m - n), atol=1e-13)


@pytest.mark.parametrize(("n", "m"), SHAPES)
def test_least_norm_tensions_are_the_pseudo_inverse(rng, n, m):
    for structure in matrices(rng, n, m):
        volume, (left, tau, scale, order) = factors(structure)
        rows = structure / scale[:, None]
        assert volume == pytest.approx(np.sqrt(np.linalg.det(rows @ rows.T)) * scale.prod(), rel=1e-9)
        wrench, tensions = rng.normal(size=n) * scale, np.empty(m)
        least_norm(left, tau, scale, order, wrench, tensions)
        expected = -np.linalg.pinv(structure / scale[:, None]) @ (wrench / scale)
        np.testing.assert_allclose(tensions, expected, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize(("n", "m"), SHAPES)
def test_row_space_is_carried_back(rng, n, m):
    for structure in matrices(rng, n, m):
        _, (left, tau, scale, order) = factors(structure)
        motion, found = rng.normal(size=n) / scale, np.empty(n)
        carry_back(left, tau, scale, order, structure.T @ motion, found)
        np.testing.assert_allclose(found * scale, motion * scale, rtol=1e-7, atol=1e-8)


def motion_of(structure, wrench):
    """Rank and unresisted motion, as kernels ask for them."""
    n, m = structure.shape
    scale, motions, sizes, z = np.empty(n), np.empty((n, n)), np.empty(n), np.empty(n)
    assert row_scales(structure, scale) > 0.0
    rank = decide(structure, scale, np.empty((n, m)), motions, sizes)
    unresisted(scale, motions, sizes, wrench, z)
    return rank, z, scale


@pytest.mark.parametrize("rank", [1, 3, 4, 5])
def test_dependent_rows_are_counted_and_their_motion_found(rng, rank):
    for _ in range(20):
        unit = np.repeat(10.0 ** rng.uniform(-9.0, 9.0, 2), 3)[:, None]
        structure = rng.normal(size=(6, rank)) @ rng.normal(size=(rank, 8)) * unit
        wrench = rng.normal(size=6) * unit[:, 0]
        found, motion, _ = motion_of(structure, wrench)
        assert found == rank
        np.testing.assert_allclose(motion @ structure, 0.0, atol=1e-12 * np.abs(motion[:, None] * structure).max())
        assert motion @ wrench > 0.0
        assert np.linalg.norm(motion) == pytest.approx(1.0)


def test_a_load_the_cables_resist_still_gets_a_motion(rng):
    structure = np.vstack((rng.normal(size=(2, 5)), np.zeros((1, 5))))
    _, motion, _ = motion_of(structure, np.array([1.0, 2.0, 0.0]))
    np.testing.assert_allclose(np.abs(motion), [0.0, 0.0, 1.0], atol=1e-15)


@pytest.mark.parametrize(("share", "rank"), [(1e-3, 3), (1e-6, 3), (3e-9, 3), (3e-10, 2), (0.0, 2)])
def test_rank_is_decided_at_the_stated_share_of_the_greatest_singular_value(rng, share, rank):
    """Two unit forces and a moment that leaves their plane by so much; orthonormal rows have singular values of 1."""
    frame = np.linalg.qr(rng.normal(size=(6, 6)))[0][:3]
    for unit in (1e-9, 1.0, 1e9):
        structure = np.stack((frame[0], frame[1], unit * (frame[0] + frame[1] + share * np.sqrt(2.0) * frame[2])))
        sizes = np.linalg.svd(structure / scales_of(structure), compute_uv=False)
        assert (sizes[-1] > 1e-9 * sizes[0]) == (rank == 3)
        answer = null_space(structure)
        assert answer.rank == rank
        assert np.isnan(answer.basis).any() == (rank < 3)
        assert answer.status == (RankStatus.FULL if rank == 3 else RankStatus.SINGULAR)


def scales_of(structure):
    """Longest force part and longest lever of the columns of a planar matrix, row by row (3, 1)."""
    force = np.linalg.norm(structure[:2], axis=0).max()
    return np.array([[force], [force], [np.abs(structure[2]).max()]])


def test_a_nearly_singular_null_space_is_accurate(rng):
    frame = np.linalg.qr(rng.normal(size=(8, 8)))[0]
    structure = frame[:6].copy()
    structure[5] = structure[:5].sum(axis=0) + 1e-6 * frame[5]
    basis = null_space(structure).basis
    np.testing.assert_allclose(basis @ basis.T, frame[6:].T @ frame[6:], atol=1e-8)


def test_a_cable_without_length_is_undefined(rng):
    structure = rng.normal(size=(3, 5))
    structure[:, 1] = 0.0
    answer = null_space(structure)
    assert answer.status == RankStatus.UNDEFINED
    assert answer.rank == -1


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_undefined(rng, bad):
    structures = rng.normal(size=(2, 3, 6, 8))
    structures[1, 2, 4, 3] = bad
    answer = null_space(structures)
    assert answer.status[1, 2] == RankStatus.UNDEFINED
    assert answer.rank[1, 2] == -1
    assert np.isnan(answer.basis[1, 2]).all()
    assert np.count_nonzero(answer.status == RankStatus.FULL) == 5


@pytest.mark.parametrize("shape", [(4,), (4, 3), (0, 3), ()])
def test_other_shapes_are_refused(shape):
    with pytest.raises(InputError, match="structure"):
        null_space(np.zeros(shape))


def test_every_status_gives_advice():
    assert all(status.advice for status in RankStatus)
