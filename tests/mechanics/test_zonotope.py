"""The available wrench set: its facets against the hull of the corners of the tension box."""

from __future__ import annotations

import numpy as np
import pytest
from published_robots import COGIRO, PLANAR_4_4, TABLE_III
from scipy.spatial import ConvexHull

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    WrenchSetStatus,
    available_wrench_set,
    planar_structure_matrix,
    spatial_structure_matrix,
)


def corner_images(structure, low, high):
    m = structure.shape[1]
    bits = (np.arange(2**m)[:, None] >> np.arange(m)) & 1
    return (low + bits * (high - low)) @ structure.T


def planes(hull):
    """Distinct facets of a hull that Qhull has cut into simplices."""
    return np.unique(np.round(hull.equations, 7) + 0.0, axis=0)


@pytest.mark.parametrize("robot", [PLANAR_4_4, TABLE_III], ids=lambda r: r.name)
def test_facets_are_those_of_the_convex_hull_of_the_corners(robot, rng):
    for pose in robot.poses(rng, 20):
        structure = planar_structure_matrix(robot.anchors, robot.attachments, pose)
        low, high = np.array([0.1, 0.2, 0.1, 0.3]), np.array([1.0, 1.2, 0.9, 1.1])
        available = available_wrench_set(structure, low, high)
        hull = planes(ConvexHull(corner_images(structure, low, high)))
        ours = np.column_stack((available.normals, -available.reaches))
        assert available.status is WrenchSetStatus.SOLID
        assert len(ours) == len(hull) == 12
        np.testing.assert_allclose(
            ours[np.lexsort(np.round(ours, 5).T)], hull[np.lexsort(np.round(hull, 5).T)], atol=2e-7
        )


def test_facets_touch_the_set_and_contain_it_in_space(rng):
    position, turn = COGIRO.poses(rng, 1)
    structure = spatial_structure_matrix(COGIRO.anchors, COGIRO.attachments, position[0], turn[0])
    available = available_wrench_set(structure, 100.0, 5000.0, 0.9)
    images = corner_images(structure, 100.0, np.full(8, 5000.0))
    reach = (images @ available.normals.T).max(axis=0)
    np.testing.assert_allclose(reach, available.reaches, rtol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(available.normals * ([0.9] * 3 + [1.0] * 3), axis=1), 1.0)
    assert len(available.reaches) == 2 * 56


def test_facets_shared_by_several_column_pairs_come_once():
    structure = np.array([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 0.0]])
    available = available_wrench_set(structure, 0.0, 1.0)
    assert len(available.reaches) == 2 * 4  # three columns in the plane z = 0: a hexagonal prism
    assert len(np.unique(available.normals, axis=0)) == 8


def test_unbounded_tensions_leave_a_cone_or_the_whole_space():
    cone = available_wrench_set(np.eye(3), 0.0, np.inf)
    assert sorted(map(tuple, cone.normals)) == sorted(map(tuple, -np.eye(3)))
    np.testing.assert_allclose(cone.reaches, 0.0)
    whole = available_wrench_set(np.hstack((np.eye(3), -np.ones((3, 1)))), 0.0, np.inf)
    assert whole.status is WrenchSetStatus.SOLID and len(whole.reaches) == 0


def test_a_singular_pose_has_a_flat_set():
    flat = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0], [1.0, -1.0, 1.0, -1.0]])
    whole = np.hstack((np.eye(3), -np.ones((3, 1))))
    assert available_wrench_set(flat, 0.0, 1.0).status is WrenchSetStatus.SINGULAR
    assert available_wrench_set(flat[:, :1], 0.0, 1.0).status is WrenchSetStatus.SINGULAR
    assert available_wrench_set(np.full((3, 4), np.nan), 0.0, 1.0).status is WrenchSetStatus.UNDEFINED
    assert available_wrench_set(whole, 2.0, 1.0).status is WrenchSetStatus.EMPTY
    assert available_wrench_set(whole, 2.0, np.nan).status is WrenchSetStatus.UNDEFINED
    assert all(len(status.advice) > 20 for status in WrenchSetStatus)


def test_bad_questions_are_refused():
    with pytest.raises(InputError, match="structure"):
        available_wrench_set(np.ones((2, 3, 4)), 0.0, 1.0)
    with pytest.raises(InputError, match="upper"):
        available_wrench_set(np.ones((3, 4)), 0.0, [1.0, 2.0, 3.0])
    with pytest.raises(InputError, match="characteristic length"):
        available_wrench_set(np.ones((3, 4)), 0.0, 1.0, -1.0)
