"""Cables over pulleys against a string drawn by hand, finite differences and the limit of no pulley."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.mechanics.cable import pulley_runs, spatial_vectors
from steeplejack.mechanics.cable.pulleys import cable_run
from steeplejack.spatial import from_vector

UP = np.array([[0.0, 0.0, 1.0]])


def scene(rng, count=40):
    """Anchors, unit axes, radii and points outside the pulleys, all in general position."""
    anchors, points = rng.normal(size=(count, 3)), rng.normal(size=(count, 3)) * 3.0
    axes = rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    return anchors, axes, rng.uniform(0.02, 0.2, count), points


def drawn(anchor, axis, radius, point):
    """Length by a search for the wrap angle whose tangent hits the point, in coordinates made from scratch."""
    v = point - anchor
    h = v @ axis
    outward = v - h * axis
    rho = np.linalg.norm(outward)
    wraps = np.linspace(0.0, 2.0 * np.pi, 200_001)
    leave = np.stack((radius * (1.0 - np.cos(wraps)), radius * np.sin(wraps)), axis=-1)
    tangent = np.stack((np.sin(wraps), np.cos(wraps)), axis=-1)
    gap = np.array([rho, h]) - leave
    miss = np.abs(gap[:, 0] * tangent[:, 1] - gap[:, 1] * tangent[:, 0])
    miss[np.sum(gap * tangent, axis=1) < 0.0] = np.inf
    best = int(np.argmin(miss))
    return radius * wraps[best] + np.linalg.norm(gap[best])


def test_length_is_that_of_the_string_around_the_wheel(rng):
    anchors, axes, radii, points = scene(rng)
    lengths, _along = pulley_runs(anchors, axes, radii, points)
    expected = [drawn(*case) for case in zip(anchors, axes, radii, points, strict=True)]
    np.testing.assert_allclose(lengths, expected, rtol=1e-7)


def test_a_quarter_and_a_half_turn():
    lengths, along = pulley_runs(np.zeros((2, 3)), np.tile(UP, (2, 1)), 0.1, [[3.0, 0.0, 0.1], [0.2, 0.0, -2.0]])
    np.testing.assert_allclose(lengths, [0.1 * np.pi / 2 + 2.9, 0.1 * np.pi + 2.0], atol=1e-15)
    np.testing.assert_allclose(along, [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], atol=1e-15)


def test_first_and_second_derivatives_by_finite_differences(rng):
    anchors, axes, radii, points = scene(rng)
    along, across = np.empty(3), np.empty(3)
    step, unit = 1e-5, np.eye(3)
    for i in range(len(points)):
        _length, bent, swung = cable_run(anchors, axes, radii, i, points[i], along, across)
        hessian = bent * (np.eye(3) - np.outer(along, along)) + (swung - bent) * np.outer(across, across)

        def value(at, i=i):
            lengths, slopes = pulley_runs(anchors[i : i + 1], axes[i : i + 1], radii[i], at[None])
            return lengths[0], -slopes[0]

        ends = [[value(points[i] + s * step * unit[k]) for s in (1, -1)] for k in range(3)]
        np.testing.assert_allclose([(a[0] - b[0]) / (2 * step) for a, b in ends], -along, atol=1e-8)
        numeric = np.array([(a[1] - b[1]) / (2 * step) for a, b in ends])
        np.testing.assert_allclose(numeric, hessian, atol=1e-6 * max(1.0, np.abs(hessian).max()))


def test_no_radius_is_the_straight_cable_and_a_small_one_tends_to_it(rng):
    anchors, axes, _radii, points = scene(rng)
    vectors = spatial_vectors(anchors, points, np.zeros(3), np.eye(3))
    straight = np.linalg.norm(vectors, axis=1)
    lengths, along = pulley_runs(anchors, axes, 0.0, points)
    np.testing.assert_allclose(lengths, straight, rtol=1e-15)
    np.testing.assert_allclose(along, vectors / straight[:, None], atol=1e-15)
    near = [np.abs(pulley_runs(anchors, axes, r, points)[0] - straight).max() for r in (1e-3, 1e-4)]
    assert near[1] < 0.11 * near[0]


def test_turning_the_world_changes_nothing(rng):
    anchors, axes, radii, points = scene(rng)
    turn = from_vector(np.array([0.4, -1.1, 0.7]))
    lengths, along = pulley_runs(anchors, axes, radii, points)
    turned, turned_along = pulley_runs(anchors @ turn.T, axes @ turn.T * 5.0, radii, points @ turn.T)
    np.testing.assert_allclose(turned, lengths, rtol=1e-13)
    np.testing.assert_allclose(turned_along, along @ turn.T, atol=1e-13)


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_units_do_not_matter(rng, scale):
    anchors, axes, radii, points = scene(rng)
    np.testing.assert_allclose(
        pulley_runs(scale * anchors, axes, scale * radii, scale * points)[0],
        scale * pulley_runs(anchors, axes, radii, points)[0],
        rtol=1e-12,
    )


def test_what_has_no_course_is_not_a_number():
    inside, on_axis, nowhere = [0.1, 0.0, 0.05], [0.0, 0.0, -3.0], [np.nan, 0.0, 0.0]
    lengths, along = pulley_runs(np.zeros((3, 3)), np.tile(UP, (3, 1)), 0.1, [inside, on_axis, nowhere])
    assert np.isnan(lengths).all() and np.isnan(along).all()
    lengths, along = pulley_runs(np.zeros((1, 3)), UP, 0.0, np.zeros((1, 3)))
    assert lengths[0] == 0.0 and not along.any()
