"""Workspaces of the pipe climber: strips against single poses, against the reference, and what empties them."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from steeplejack.design.climber import (
    Comparison,
    least_determinant,
    orientations,
    require_poses,
    strips,
    workspace_area,
    workspace_cells,
    workspace_volume,
)
from steeplejack.errors import InfeasibleError, InputError
from steeplejack.robots.pipe_climber import Layout
from steeplejack.robots.pipe_climber.inverse import hinge_angles, limb_lengths
from steeplejack.robots.pipe_climber.jacobian import jacobian

pytestmark = pytest.mark.long

FOLDER = Path(__file__).parents[1] / "reference"
REFERENCE: dict[str, Any] = tomllib.loads((FOLDER / "pipe_climber_design.toml").read_text())
SINGULARITY: dict[str, Any] = tomllib.loads((FOLDER / "pipe_climber.toml").read_text())["singularity"]
TEXT = Layout((0.100, 0.100, 0.075, 0.075))
NAMES = ["text_none", "text_home", "equations_none", "equations_home"]


def named(name: str) -> Layout:
    convention, neutral = name.split("_")
    return replace(TEXT, convention=convention, neutral=neutral)


def taken(layout: Layout, poses: np.ndarray) -> np.ndarray:
    """Which poses the mechanism can take, from kinematics alone."""
    lengths = limb_lengths(layout, poses)
    fits = (poses[..., 1] > 0.0) & ((lengths >= layout.reach[0]) & (lengths <= layout.reach[1])).all(axis=-1)
    if layout.neutral != "none":
        fits &= (np.abs(hinge_angles(layout, poses, layout.neutral)) <= layout.joint_limit).all(axis=(-1, -2))
    home = np.sign(np.linalg.det(jacobian(layout, [0.0, 0.16, 0.0])))
    return fits & (home * np.linalg.det(jacobian(layout, poses)) > 0.0)


@pytest.mark.parametrize("name", NAMES)
def test_reference_areas(name: str) -> None:
    cell, layout = REFERENCE["area"]["cell"], named(name)
    by_cells = int(workspace_cells(layout, 0.0, cell)[0]) * cell**2
    assert by_cells == pytest.approx(REFERENCE["area"][name], abs=0.6e-6)
    assert workspace_area(layout) == pytest.approx(REFERENCE["area"]["exact"][name], abs=2e-9)
    fine = int(workspace_cells(layout, 0.0, 1e-4)[0]) * 1e-8
    assert workspace_area(layout) == pytest.approx(fine, abs=0.1e-6)


@pytest.mark.parametrize("alpha", [0.0, 0.35, -0.6, 1.3, -2.0])
@pytest.mark.parametrize(
    "layout",
    [
        TEXT,
        replace(TEXT, convention="equations", neutral="home"),
        replace(TEXT, neutral="normal", joint_limit=0.9),
        Layout((0.03, 0.10, 0.09, 0.06), neutral="home", joint_limit=1.0),
        Layout((0.10, 0.05, 0.30, 0.22), reach=(0.01, 0.24)),
    ],
)
def test_strips_against_single_poses(layout: Layout, alpha: float) -> None:
    """Random poses are in the strips exactly when kinematics says that they can be taken."""
    rng = np.random.default_rng(11)
    heights = rng.uniform(0.0, 0.35, 60)
    for w, pieces in zip(heights, strips(layout, heights, alpha), strict=True):
        x = rng.uniform(-0.45, 0.35, 200)
        inside = ((x[:, None] >= pieces[:, 0]) & (x[:, None] <= pieces[:, 1])).any(axis=1)
        near = (np.abs(x[:, None] - pieces.ravel()) < 1e-9).any(axis=1)
        poses = np.stack((x, np.full_like(x, w), np.full_like(x, alpha)), axis=-1)
        assert (inside == taken(layout, poses))[~near].all()
        assert (np.diff(pieces.ravel()) > 0.0).all()


def test_cells_against_single_poses() -> None:
    layout, step, alpha = named("text_home"), 0.004, 0.2
    axis = (np.arange(-80, 80) + 0.5) * step
    grid = np.stack((*np.meshgrid(axis, axis), np.full((160, 160), alpha)), axis=-1)
    assert workspace_cells(layout, [alpha, 0.0], step)[0] == np.count_nonzero(taken(layout, grid))


def test_the_area_in_closed_form() -> None:
    """One point for a base and one for a platform: the ring between two circles, its upper half."""
    tiny = Layout((3e-9, 2e-9, 2e-9, 1e-9), reach=(0.1, 0.2))
    assert workspace_area(tiny) == pytest.approx(0.5 * math.pi * (0.2**2 - 0.1**2), rel=1e-7)


def test_orientation_and_reachable_sets() -> None:
    layout, step = named("text_home"), 0.004
    span = (-0.3, 0.5)
    places = orientations(layout, step, span)
    assert places.volume == pytest.approx(workspace_volume(layout, step, span), rel=1e-12)
    assert places.common_area < workspace_area(layout, 0.1) < places.reachable_area
    # Orientations sampled finely at one place.
    row, column = np.argwhere(places.turn > 0.5 * places.turn.max())[7]
    angles = np.linspace(*span, 20_001)
    poses = np.stack(np.broadcast_arrays(places.x[column], places.w[row], angles), axis=-1)
    width = (span[1] - span[0]) / round((span[1] - span[0]) / math.radians(1.0))
    assert places.turn[row, column] == pytest.approx(taken(layout, poses).mean() * (span[1] - span[0]), abs=2 * width)


def test_the_volume_adds_up_areas() -> None:
    layout = named("text_home")
    alphas = np.linspace(-1.2, 1.2, 241)
    areas = [workspace_area(layout, alpha) for alpha in alphas]
    assert workspace_volume(layout, 0.001) == pytest.approx(np.trapezoid(areas, alphas), rel=2e-3)


def test_nothing_within_thirty_degrees_is_singular() -> None:
    least = least_determinant(np.array([[1.0, 1.0, 0.75, 0.75]]), Comparison(step=0.002), 0.001)
    assert least == pytest.approx(SINGULARITY["least_det_per_l1"], abs=0.005)
    for alpha in np.radians([-30.0, 0.0, 30.0]):
        single = workspace_area(TEXT, alpha)
        assert single == pytest.approx(require_poses(TEXT, alpha), rel=1e-12)


@pytest.mark.parametrize("alpha", [-math.pi / 6, math.pi / 6])
def test_limits_from_the_normals_empty_the_outer_slices(alpha: float) -> None:
    assert workspace_area(replace(TEXT, neutral="normal"), alpha) == 0.0
    assert workspace_area(replace(TEXT, neutral="home"), alpha) > 0.005
    with pytest.raises(InfeasibleError) as told:
        require_poses(replace(TEXT, neutral="normal"), alpha)
    assert told.value.binding == "joint limits of 30 deg counted from 'normal'"


@pytest.mark.parametrize("step", [0.0, -0.001, 0.03, 1e-6, math.nan, math.inf])
def test_steps_out_of_range(step: float) -> None:
    with pytest.raises(InputError, match="step"):
        workspace_cells(TEXT, 0.0, step)


@pytest.mark.parametrize("largest", [100.0, 1e6])
def test_no_step_suits_limbs_far_shorter_than_the_platforms(largest: float) -> None:
    """The range of steps would be upside down; the dimensions are named instead."""
    huge = Layout((0.5 * largest, 0.5 * largest, largest, largest))
    with pytest.raises(InputError, match=r"dimensions: .*; lengths of up to 92\.7 m"):
        workspace_cells(huge, 0.0, 0.001)
    assert workspace_cells(Layout((46.0, 46.0, 92.0, 92.0)), 0.0, 0.024).tolist() == [0]


@pytest.mark.parametrize("alpha", [math.nan, math.inf])
def test_orientations_that_are_none(alpha: float) -> None:
    for ask in (workspace_area, require_poses):
        with pytest.raises(InputError, match="alpha"):
            ask(TEXT, alpha)
    with pytest.raises(InputError, match="alpha"):
        workspace_cells(TEXT, [0.0, alpha], 0.01)
    with pytest.raises(InputError, match="orientations"):
        orientations(TEXT, 0.01, (0.0, alpha))
