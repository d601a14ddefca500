"""Wrench closure and tension factor: references, degenerate cases, the slips of the print, and a linear program."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from steeplejack.mechanics.cable import (
    in_wrench_closure,
    is_singular,
    null_vector,
    planar_lengths,
    planar_structure_matrix,
    tension_factor,
)


def eq37(matrix):
    """First three components of the null vector, term by term as Appendix A prints them."""
    (a1, a2, a3, a4), (b1, b2, b3, b4), (c1, c2, c3, c4) = matrix
    return np.array(
        [
            b2 * c3 * a4 - b3 * c2 * a4 + a3 * c2 * b4 - a2 * c3 * b4 + a2 * b3 * c4 - b2 * a3 * c4,
            b1 * c3 * a4 - b3 * c1 * a4 + a3 * c1 * b4 - a1 * c3 * b4 + b3 * a1 * c4 - a3 * b1 * c4,
            b2 * c2 * a4 - b2 * c1 * a4 + a2 * c1 * b4 - a1 * c2 * b4 + a1 * b2 * c4 - b1 * a2 * c4,
        ]
    )


def random_structures(rng, count):
    anchors = np.array([[-2.0, -1.5], [2.0, -1.2], [2.3, 1.4], [-1.6, 1.8]]) + rng.uniform(-1.0, 1.0, (count, 4, 2))
    attachments = np.array([[-0.4, -0.3], [0.5, -0.2], [0.3, 0.4], [-0.2, 0.5]])
    pose = rng.uniform([-1.0, -0.8, -0.3], [1.0, 0.8, 0.3], (count, 3))
    return planar_structure_matrix(anchors, attachments, pose)


def test_tension_factors_of_table_iii(reference):
    table, given = reference["table_iii"], reference["tension_factor"]
    poses = np.array(given["x_y_phi_deg"]) * [1.0, 1.0, np.pi / 180.0]
    factors = tension_factor(planar_structure_matrix(table["anchors"], table["attachments"], poses))
    np.testing.assert_allclose(factors, given["factors"], rtol=1e-6)


def test_every_cofactor_is_negative_at_table_iii_so_the_printed_ratio_is_upside_down(reference):
    table, given = reference["table_iii"], reference["tension_factor"]
    poses = np.array(given["x_y_phi_deg"]) * [1.0, 1.0, np.pi / 180.0]
    null = null_vector(planar_structure_matrix(table["anchors"], table["attachments"], poses))
    assert (null < 0.0).all()
    printed = null.min(axis=-1) / null.max(axis=-1)  # Eq. 12
    np.testing.assert_allclose(printed, 1.0 / np.array(given["factors"]), rtol=1e-6)


def test_null_vector_is_null_and_as_long_as_the_volume_of_the_rows(rng):
    matrix = rng.normal(size=(500, 3, 4))
    null = null_vector(matrix)
    np.testing.assert_allclose(np.einsum("kij,kj->ki", matrix, null), 0.0, atol=1e-12)
    volume = np.sqrt(np.linalg.det(matrix @ np.swapaxes(matrix, 1, 2)))
    np.testing.assert_allclose(np.linalg.norm(null, axis=-1), volume, rtol=1e-9)


def test_eq_37_as_printed_is_wrong_in_rows_2_and_3(rng):
    matrix = rng.normal(size=(3, 4))
    printed, null = eq37(matrix), null_vector(matrix)
    assert printed[0] == pytest.approx(null[0])
    assert printed[1] == pytest.approx(-null[1])
    (_, _, _, a4), (b1, b2, _, _), (_, c2, _, _) = matrix
    assert printed[2] != pytest.approx(null[2])
    assert printed[2] - b2 * c2 * a4 + b1 * c2 * a4 == pytest.approx(null[2])


def test_eq_5_and_6_as_printed_have_an_empty_workspace_at_every_orientation(reference):
    table = reference["table_iii"]
    anchors, local = np.array(table["anchors"]), np.array(table["attachments"])
    x, y, phi = np.meshgrid(np.arange(-62, 41) / 100, np.arange(0, 90) / 100, np.deg2rad(np.arange(-180.0, 180.0, 10)))
    printed = planar_structure_matrix(anchors, local, np.stack((x, y, phi), axis=-1))
    printed[..., 2, :] = local[:, 0] * printed[..., 1, :] - local[:, 1] * printed[..., 0, :]
    assert not in_wrench_closure(printed).any()


def test_closure_agrees_with_a_linear_program(rng):
    structures = random_structures(rng, 400)
    inside = in_wrench_closure(structures)
    assert 60 < inside.sum() < 340
    for structure, held in zip(structures, inside, strict=True):
        program = linprog(np.zeros(4), A_eq=structure, b_eq=np.zeros(3), bounds=(1.0, None))
        assert (program.status == 0) == held


def test_tension_factor_of_a_linear_program(rng):
    structures = random_structures(rng, 100)
    for structure, factor in zip(structures, tension_factor(structures), strict=True):
        if factor > 0.0:
            bounds = [(1.0, None)] * 4 + [(None, None)]
            below = np.hstack((np.eye(4), -np.ones((4, 1))))
            rows = np.hstack((structure, np.zeros((3, 1))))
            program = linprog([0, 0, 0, 0, 1], A_ub=below, b_ub=np.zeros(4), A_eq=rows, b_eq=np.zeros(3), bounds=bounds)
            assert 1.0 / program.fun == pytest.approx(factor, rel=1e-7)


@pytest.mark.parametrize("unit", [1e-9, 1e-3, 1e4])
def test_units_of_length_do_not_matter(rng, unit):
    structures = random_structures(rng, 300)
    scaled = structures * np.array([1.0, 1.0, unit])[:, None]
    np.testing.assert_allclose(tension_factor(scaled), tension_factor(structures), rtol=1e-12)
    np.testing.assert_array_equal(is_singular(scaled), is_singular(structures))


def test_columns_times_length_keep_the_sign_but_not_the_tension_factor(reference):
    table = reference["table_iii"]
    pose = np.array([-0.10, 0.45, np.deg2rad(50.0)])
    structure = planar_structure_matrix(table["anchors"], table["attachments"], pose)
    lengths = planar_lengths(table["anchors"], table["attachments"], pose)
    tilde = structure * lengths  # Eq. 22
    assert in_wrench_closure(tilde) and in_wrench_closure(structure)
    assert tension_factor(tilde) < 0.95 * tension_factor(structure)
    null = lengths * null_vector(tilde)
    assert np.abs(null).min() / np.abs(null).max() == pytest.approx(float(tension_factor(structure)))


def test_tension_factor_is_one_exactly_where_equal_tensions_balance(reference):
    table, (x, y, phi) = reference["table_iii"], reference["balanced"]["x_y_phi_deg"]
    structure = planar_structure_matrix(table["anchors"], table["attachments"], [x, y, np.deg2rad(phi)])
    np.testing.assert_allclose(structure @ np.ones(4), 0.0, atol=1e-7)
    assert tension_factor(structure) == pytest.approx(1.0, abs=1e-6)


def test_cables_through_one_point_are_singular():
    anchors = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    structure = planar_structure_matrix(anchors, 0.1 * anchors, [0.0, 0.0, 0.0])
    assert is_singular(structure)
    assert tension_factor(structure) == 0.0


def test_a_cable_that_does_nothing_is_not_wrench_closure():
    structure = np.array([[1.0, -0.5, -0.5, 0.0], [0.0, 0.8, -0.8, 0.0], [0.0, 0.0, 0.0, 1.0]])
    assert not is_singular(structure)
    assert tension_factor(structure) == 0.0


@pytest.mark.parametrize("tiny", [1e-12, -1e-12])
def test_a_component_below_tolerance_counts_as_zero(tiny):
    structure = np.array([[1.0, -0.5, -0.5, 0.0], [0.0, 0.8, -0.8, 0.0], [-tiny, 0.0, 0.0, 1.0]])
    assert not in_wrench_closure(structure)


def test_not_a_number_is_outside(rng):
    structure = random_structures(rng, 1)[0]
    structure[1, 2] = np.nan
    assert is_singular(structure)
    assert not in_wrench_closure(structure)
