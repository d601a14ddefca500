"""Condition number and dexterity: closed forms, units, singular and hostile matrices."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import characteristic_length
from steeplejack.mechanics.cable.measure.quality import condition_number, dexterity, normalised_structure
from steeplejack.robots.cable_robot import load_cable_robot

pytestmark = pytest.mark.long


def test_closed_form_of_a_symmetric_planar_robot():
    """Directions (+-1, +-1)/sqrt 2 at arms of length b, moments +-c: singular values sqrt 2, sqrt 2 and 2 c / L."""
    half, c = np.sqrt(0.5), 0.3
    structure = np.array([[half, -half, -half, half], [half, half, -half, -half], [c, -c, c, -c]])
    for length in (0.2, 0.3 * np.sqrt(2.0), 1.0):
        ratio = np.sqrt(2.0) / (2.0 * c / length)
        assert condition_number(structure, length) == pytest.approx(max(ratio, 1.0 / ratio))
    assert dexterity(structure, 0.3 * np.sqrt(2.0)) == pytest.approx(1.0)


@pytest.mark.parametrize("name", ("kntu-planar", "ccrobot-s-planar", "ipanema-2", "cogiro"))
def test_condition_number_is_numpys_and_does_not_see_units(name, rng):
    robot = load_cable_robot(name)
    length = characteristic_length(robot.attachments)
    middle = robot.anchors.mean(axis=0)
    pose = (np.append(middle, 0.3),) if robot.dimension == "planar" else (middle - [0.0, 0.0, 1.0], np.eye(3))
    structure = robot.structure(*pose)
    wanted = np.linalg.cond(normalised_structure(structure, length))
    assert condition_number(structure, length) == pytest.approx(wanted, rel=1e-9)
    moments = slice(2, 3) if robot.dimension == "planar" else slice(0, 3)
    for scale in (1e-9, 1e9):
        other = structure.copy()
        other[moments] *= scale
        assert condition_number(other, scale * length) == pytest.approx(wanted, rel=1e-9)


def test_dexterity_bounds_the_pose_error_from_length_errors(rng):
    """Largest over smallest |pose error| from unit length errors along the singular directions."""
    robot = load_cable_robot("planar-4-4")
    structure = normalised_structure(robot.structure([6.0, 2.5, 0.2]), 0.7)
    sizes = [np.linalg.norm(structure.T @ (v / np.linalg.norm(v))) for v in rng.normal(size=(20000, 3))]
    assert min(sizes) / max(sizes) == pytest.approx(dexterity(robot.structure([6.0, 2.5, 0.2]), 0.7), rel=0.02)


def test_singular_and_hostile_matrices():
    flat = np.array([[1.0, 1.0, -1.0, -1.0], [0.0, 0.0, 0.0, 0.0], [0.1, -0.1, 0.1, -0.1]])
    assert dexterity(flat, 1.0) == 0.0
    assert condition_number(flat, 1.0) == np.inf
    assert np.isnan(dexterity(np.zeros((6, 8)), 1.0))  # cables without length: undefined, not merely singular
    assert dexterity(np.ones((3, 2)), 1.0) == 0.0
    whole = np.array([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0], [0.1, -0.1, 0.1, 0.1]])
    batch = np.stack((whole, np.full((3, 4), np.nan)))
    np.testing.assert_array_equal(np.isnan(dexterity(batch, 1.0)), [False, True])
    for length in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="characteristic length"):
            dexterity(np.eye(3, 4), length)
    for bad in (np.ones(3), "matrix", np.ones((3, 4)) * 1j, [[1.0, 2.0], [1.0]]):
        with pytest.raises(InputError, match="structure"):
            condition_number(bad, 1.0)
    with pytest.raises(InputError, match="rows"):
        dexterity(np.eye(4, 5), 1.0)


def test_the_page_on_quality_prints_what_it_says(capsys):
    page = (Path(__file__).parents[2] / "docs" / "quality.md").read_text()
    code, said = (page.split(f"```{kind}\n")[1].split("```")[0] for kind in ("python", "text"))
    exec(compile(code, "quality.md", "exec"), {})
    assert capsys.readouterr().out == said
