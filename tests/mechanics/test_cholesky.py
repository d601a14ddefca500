"""The compiled Cholesky factor against numpy's: damping, matrices that have none, factors in place."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.mechanics.cable.cholesky import cholesky, substitute


def definite(rng, n):
    """A symmetric positive definite matrix whose eigenvalues span four decades."""
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    return turn @ np.diag(10.0 ** rng.uniform(-2.0, 2.0, n)) @ turn.T


@pytest.mark.parametrize("n", [1, 2, 3, 6])
@pytest.mark.parametrize("damping", [0.0, 0.7, 1e3])
def test_the_factor_of_a_damped_matrix_is_that_of_numpy(n, damping, rng):
    matrix, factor = definite(rng, n), np.zeros((n, n))
    least = cholesky(matrix, damping, factor)
    expected = np.linalg.cholesky(matrix + damping * np.eye(n))
    np.testing.assert_allclose(factor, expected, rtol=1e-9, atol=1e-12)
    pivots = (np.diag(expected) ** 2 - damping) / np.diag(matrix + damping * np.eye(n))
    assert least == pytest.approx(max(pivots.min(), 1e-300), rel=1e-6, abs=1e-9)
    assert least > 0.0


def test_the_upper_half_is_neither_read_nor_written(rng):
    matrix, factor = definite(rng, 4), np.full((4, 4), 7.0)
    expected = np.linalg.cholesky(matrix)
    matrix[np.triu_indices(4, 1)] = np.nan
    assert cholesky(matrix, 0.0, factor) > 0.0
    np.testing.assert_allclose(np.tril(factor), expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(factor[np.triu_indices(4, 1)], 7.0)


def test_a_factor_may_be_written_over_its_matrix(rng):
    matrix = definite(rng, 6)
    apart, place = np.zeros((6, 6)), matrix.copy()
    assert cholesky(matrix, 0.1, apart) == cholesky(place, 0.1, place)
    np.testing.assert_array_equal(np.tril(place), np.tril(apart))


@pytest.mark.parametrize(
    "matrix",
    [
        np.zeros((3, 3)),
        np.diag([1.0, -1.0, 1.0]),
        np.array([[1.0, 2.0], [2.0, 1.0]]),
        np.full((2, 2), np.nan),
        np.diag([1.0, np.nan]),
    ],
)
def test_a_matrix_without_a_factor_gives_exactly_nothing(matrix):
    assert cholesky(matrix, 0.0, np.zeros_like(matrix)) == 0.0


def test_damping_makes_a_factor_of_an_indefinite_matrix():
    matrix, factor = np.diag([1.0, -1.0, 0.0]), np.zeros((3, 3))
    assert cholesky(matrix, 0.5, factor) == 0.0
    assert cholesky(matrix, 1.5, factor) > 0.0
    np.testing.assert_allclose(factor @ factor.T, matrix + 1.5 * np.eye(3))


def test_a_singular_matrix_has_damping_alone_for_its_last_pivot():
    ones, factor = np.ones((2, 2)), np.zeros((2, 2))
    least = cholesky(ones, 1e-3, factor)
    assert 0.0 < least < 3e-3
    assert cholesky(np.zeros((2, 2)), 1.0, factor) > 0.0
    np.testing.assert_allclose(factor, np.eye(2))


def test_substitution_solves_and_may_write_over_the_right_side(rng):
    matrix, right, factor, out = definite(rng, 5), rng.normal(size=5), np.zeros((5, 5)), np.empty(5)
    cholesky(matrix, 0.3, factor)
    substitute(factor, right, out)
    np.testing.assert_allclose(out, np.linalg.solve(matrix + 0.3 * np.eye(5), right), rtol=1e-9)
    substitute(factor, right, right)
    np.testing.assert_array_equal(right, out)
