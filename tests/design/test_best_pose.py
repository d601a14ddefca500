"""The continuous maximum of the tension factor."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from steeplejack.design import best_pose
from steeplejack.errors import InfeasibleError
from steeplejack.mechanics.cable import planar_structure_matrix, tension_factor


@pytest.fixture(scope="module")
def table(reference):
    return np.array(reference["table_iii"]["anchors"]), np.array(reference["table_iii"]["attachments"])


def test_continuous_maximum_at_fifty_degrees(table, reference):
    answer = best_pose(*table, np.deg2rad(50.0))
    assert answer.tension_factor == pytest.approx(reference["best"]["factor"], rel=1e-9)
    np.testing.assert_allclose(answer.pose, [*reference["best"]["at"], np.deg2rad(50.0)], rtol=1e-6)


def test_over_all_orientations_the_maximum_is_one(table, reference):
    answer = best_pose(*table)
    x, y, phi = reference["balanced"]["x_y_phi_deg"]
    assert answer.tension_factor == pytest.approx(1.0, abs=1e-9)
    np.testing.assert_allclose(answer.pose, [x, y, np.deg2rad(phi)], rtol=1e-6)


def test_a_search_without_gradients_ends_no_higher(table):
    def loss(position):
        return -float(tension_factor(planar_structure_matrix(*table, [*position, np.deg2rad(50.0)])))

    start = np.array([-0.24, 0.56])
    for _ in range(3):
        start = minimize(loss, start, method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-13}).x
    answer = best_pose(*table, np.deg2rad(50.0))
    assert -loss(start) <= answer.tension_factor + 1e-12
    np.testing.assert_allclose(start, answer.pose[:2], atol=1e-5)


@pytest.mark.parametrize("phi", [44.0, 47.0, 53.0, 56.0])
def test_the_maximum_is_above_every_node(table, phi):
    answer = best_pose(*table, np.deg2rad(phi))
    x, y = np.meshgrid(np.arange(-0.62, 0.41, 0.01), np.arange(0.0, 0.9, 0.01))
    poses = np.stack((x, y, np.full(x.shape, np.deg2rad(phi))), axis=-1)
    assert answer.tension_factor >= tension_factor(planar_structure_matrix(*table, poses)).max()


def test_an_empty_workspace_is_named(table):
    with pytest.raises(InfeasibleError, match="phi = 0 deg"):
        best_pose(*table, 0.0)
