"""Dexterity in the plane of the cables: against the singular values, and 0 where a freedom is lost."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.mechanics.cable.rest.statics import directions
from steeplejack.robots.squad.in_plane import dexterity, plane_matrix
from steeplejack.spatial import from_vector

ATTACHMENTS = np.array([[-0.1, -0.08, 0.0], [0.09, -0.1, 0.02], [0.1, 0.11, 0.0], [-0.08, 0.1, 0.01]])


def test_is_the_ratio_of_the_singular_values(rng: np.random.Generator) -> None:
    for _ in range(100):
        rotation = from_vector(rng.normal(size=3))
        u, _lengths = directions(rng.normal(0.0, 20.0, (4, 3)), ATTACHMENTS, rng.normal(size=3), rotation)
        matrix, _scale = plane_matrix(u, rotation, ATTACHMENTS)
        values = np.linalg.svd(matrix)[1]
        assert dexterity(matrix) == pytest.approx(values[2] / values[0], abs=1e-12)


def test_cables_that_meet_in_one_point_do_not_turn_the_platform() -> None:
    """Every line of action passes through the reference point: no moment about it."""
    rotation, position = from_vector(np.array([0.2, -0.1, 0.7])), np.array([1.0, 2.0, 3.0])
    flat = ATTACHMENTS * np.array([1.0, 1.0, 0.0])
    anchors = position + 50.0 * (flat @ rotation.T)
    u, _lengths = directions(anchors, flat, position, rotation)
    matrix, _scale = plane_matrix(u, rotation, flat)
    assert dexterity(matrix) < 1e-7


def test_does_not_depend_on_the_size_of_the_platform(rng: np.random.Generator) -> None:
    rotation = from_vector(np.array([0.3, 0.1, -0.4]))
    u, _lengths = directions(rng.normal(0.0, 20.0, (4, 3)), ATTACHMENTS, np.zeros(3), rotation)
    small, large = (dexterity(plane_matrix(u, rotation, scale * ATTACHMENTS)[0]) for scale in (1e-6, 1e6))
    assert small == pytest.approx(large, rel=1e-9)
