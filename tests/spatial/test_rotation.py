"""Rotations: round trips, also near no turn and near half a turn, and derivatives by finite differences."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from steeplejack.errors import InputError
from steeplejack.spatial import from_quaternion, from_vector, nearest_turn, to_quaternion, to_vector
from steeplejack.spatial.rotation import rotation_matrix, turned

Array = NDArray[np.float64]

# Angles drawn on purpose where formulas change or lose digits: none, the seam of the series, half a turn.
ANGLES = st.one_of(
    st.floats(0.0, math.pi),
    st.floats(0.0, 1e-6),
    st.floats(0.99e-4, 1.01e-4),
    st.floats(0.0, 1e-6).map(lambda x: math.pi - x),
)


@st.composite
def vectors(draw: st.DrawFn) -> Array:
    """Rotation vectors up to half a turn, also about an axis of the frame."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    axis = np.eye(3)[draw(st.integers(0, 2))] if draw(st.booleans()) else rng.normal(size=3)
    return draw(ANGLES) * draw(st.sampled_from([-1.0, 1.0])) * axis / np.linalg.norm(axis)


def skew(v: Array) -> Array:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


@given(vectors())
@settings(max_examples=200, deadline=None)
def test_matrix_is_the_exponential_and_orthogonal(vector: Array) -> None:
    rotation = from_vector(vector)
    np.testing.assert_allclose(rotation, expm(skew(vector)), atol=1e-13)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(rotation) == pytest.approx(1.0, abs=1e-14)


@given(vectors())
@settings(max_examples=200, deadline=None)
def test_vector_there_and_back(vector: Array) -> None:
    back = to_vector(from_vector(vector))
    assert np.linalg.norm(back) <= math.pi + 1e-12
    if math.pi - np.linalg.norm(vector) > 1e-5:
        np.testing.assert_allclose(back, vector, rtol=1e-8, atol=1e-14)
    # At half a turn v and -v are one rotation: compare what they do.
    np.testing.assert_allclose(from_vector(back), from_vector(vector), atol=1e-12)


@given(vectors())
@settings(max_examples=200, deadline=None)
def test_quaternion_there_and_back(vector: Array) -> None:
    rotation = from_vector(vector)
    quaternion = to_quaternion(rotation)
    assert np.linalg.norm(quaternion) == pytest.approx(1.0, abs=1e-14)
    assert quaternion[np.argmax(np.abs(quaternion))] > 0.0
    np.testing.assert_allclose(from_quaternion(quaternion), rotation, atol=1e-13)
    np.testing.assert_allclose(from_quaternion(-3.0 * quaternion), rotation, atol=1e-13)
    np.testing.assert_allclose(Rotation.from_matrix(rotation).as_matrix(), from_quaternion(quaternion), atol=1e-13)


@pytest.mark.parametrize("largest", range(4))
def test_quaternion_with_each_component_largest(largest: int) -> None:
    quaternion = np.array([0.2, -0.3, 0.25, 0.1])
    quaternion[largest] = 0.9
    quaternion /= np.linalg.norm(quaternion)
    np.testing.assert_allclose(to_quaternion(from_quaternion(quaternion)), quaternion, atol=1e-15)


@given(vectors(), st.integers(0, 2))
@settings(max_examples=100, deadline=None)
def test_derivative_by_finite_differences(vector: Array, axis: int) -> None:
    """D R = [J dv]x R with the left Jacobian J = I + (1 - cos a) / a2 [v]x + (a - sin a) / a3 [v]x2."""
    step, h = np.eye(3)[axis], 1e-5
    rate = (from_vector(vector + h * step) - from_vector(vector - h * step)) / (2.0 * h)
    a, cross = np.linalg.norm(vector), skew(vector)
    if a < 1e-3:
        jacobian = np.eye(3) + 0.5 * cross + cross @ cross / 6.0
    else:
        jacobian = np.eye(3) + (1.0 - np.cos(a)) / a**2 * cross + (a - np.sin(a)) / a**3 * cross @ cross
    np.testing.assert_allclose(rate @ from_vector(vector).T, skew(jacobian @ step), atol=1e-8)


def test_series_meets_the_closed_form() -> None:
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    below, above = from_vector(axis * 1e-4 * (1.0 - 1e-9)), from_vector(axis * 1e-4 * (1.0 + 1e-9))
    assert np.max(np.abs(above - below)) < 1e-12


def test_a_million_small_turns_stay_orthogonal() -> None:
    vector = np.array([1e-3, -2e-3, 0.5e-3])
    rotation = np.eye(3)
    for _ in range(100_000):
        rotation = turned(vector, rotation)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(rotation, expm(skew(vector) * 100_000), atol=1e-9)


@given(vectors(), vectors())
@settings(max_examples=50, deadline=None)
def test_turned_is_the_product_in_the_world(by: Array, start: Array) -> None:
    np.testing.assert_allclose(turned(by, from_vector(start)), from_vector(by) @ from_vector(start), atol=1e-13)


@given(st.integers(0, 2**32 - 1), st.integers(1, 30))
@settings(max_examples=100, deadline=None)
def test_nearest_turn_keeps_rotations_and_neighbours(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    quaternions = rng.normal(size=(count, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    chosen = nearest_turn(quaternions)
    np.testing.assert_array_equal(chosen[0], quaternions[0])
    np.testing.assert_array_equal(np.abs(chosen), np.abs(quaternions))
    assert np.all(np.sum(chosen[1:] * chosen[:-1], axis=1) >= 0.0)
    np.testing.assert_array_equal(nearest_turn(chosen), chosen)
    for before, after in zip(quaternions, chosen, strict=True):
        np.testing.assert_allclose(from_quaternion(after), from_quaternion(before), atol=1e-14)


def test_nearest_turn_follows_a_full_turn() -> None:
    """Shepperd's choice flips sign on the way round; after nearest_turn neighbours differ by the step alone."""
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    around = np.array([to_quaternion(from_vector(a * axis)) for a in np.linspace(0.0, 2.0 * np.pi, 200)])
    assert np.max(np.linalg.norm(np.diff(around, axis=0), axis=1)) > 1.0
    assert np.max(np.linalg.norm(np.diff(nearest_turn(around), axis=0), axis=1)) < 0.02


def test_rotations_pass_the_check_unchanged() -> None:
    several = np.array([from_vector(vector) for vector in np.linspace([-3.0, 0.1, 0.2], [2.0, -1.0, 3.0], 20)])
    np.testing.assert_array_equal(rotation_matrix(several, "rotation"), several)
    np.testing.assert_array_equal(rotation_matrix(several[0].tolist(), "rotation"), several[0])


@pytest.mark.parametrize(
    "value",
    [
        2.0 * np.eye(3), np.zeros((3, 3)), np.diag([1.0, 1.0, -1.0]), np.eye(3) + 1e-8, np.full((3, 3), np.nan),
        np.full((3, 3), 1e300), np.eye(2), 1.0, "north", [[1.0], [1.0, 2.0]], np.stack((np.eye(3), 1.1 * np.eye(3))),
    ],
)  # fmt: skip
def test_what_is_no_rotation_is_refused(value: object) -> None:
    with pytest.raises(InputError) as error:
        rotation_matrix(value, "start")  # pyright: ignore[reportArgumentType]
    assert error.value.where == "start"
