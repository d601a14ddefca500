"""Transmission indices of the pipe climber against screws, against locked limbs moved by hand, and the reference."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import fsolve

from steeplejack.design.climber import (
    Rectangle,
    local_transmission,
    output_transmission,
    transmission_grid,
    transmission_map,
)
from steeplejack.errors import InfeasibleError, InputError
from steeplejack.robots.pipe_climber import Layout
from steeplejack.robots.pipe_climber.inverse import limb_lengths, limb_vectors

Array = NDArray[np.float64]

REFERENCE: dict[str, Any] = tomllib.loads(
    (Path(__file__).parents[1] / "reference" / "pipe_climber_design.toml").read_text()
)
TEXT = Layout((0.100, 0.100, 0.075, 0.075))
LAYOUTS = [TEXT, replace(TEXT, convention="equations"), Layout((0.10, 0.04, 0.09, 0.031), "equations")]


def poses(rng: np.random.Generator, count: int) -> Array:
    return np.stack(
        (rng.uniform(-0.15, 0.15, count), rng.uniform(0.06, 0.24, count), rng.uniform(-1.2, 1.2, count)), axis=-1
    )


def by_screws(layout: Layout, pose: Array, moving: str) -> Array:
    """OTI from reciprocal screws: the output twist is the null vector of the wrenches of the two locked limbs.

    Planar twists (omega, vx, vz) at the origin, wrenches (m, fx, fz); their largest product is |f| |v_P|.
    """
    vectors = limb_vectors(layout, pose)
    directions = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    base = np.stack((layout.base, np.zeros(3)), axis=-1)
    points = base + vectors if moving == "platform" else base
    # About Y: v = omega x r has components (omega r_z, -omega r_x), so f does work at the moment r_z f_x - r_x f_z.
    moments = points[:, 1] * directions[:, 0] - points[:, 0] * directions[:, 1]
    wrenches = np.column_stack((moments, directions))
    found = []
    for i in range(3):
        locked = np.delete(wrenches, i, axis=0)
        omega, v_x, v_z = np.linalg.svd(locked)[2][-1]
        velocity = np.array([v_x + omega * points[i, 1], v_z - omega * points[i, 0]])
        found.append(abs(wrenches[i] @ (omega, v_x, v_z)) / np.linalg.norm(velocity))
    return np.array(found)


def by_moving(layout: Layout, pose: Array, limb: int, by: float = 1e-5) -> float:
    """OTI of a limb by lengthening it while the others keep theirs: dq_i over the way of P_i, central difference."""
    lengths, ends = limb_lengths(layout, pose), []
    for side in (-1.0, 1.0):
        wanted = lengths.copy()
        wanted[limb] += side * by
        moved = fsolve(lambda guess, wanted=wanted: limb_lengths(layout, guess) - wanted, pose, xtol=1e-12)
        x, w, alpha = moved
        p = layout.platform[limb]
        ends.append(np.array([x + p * np.cos(alpha), w - p * np.sin(alpha)]))
    return float(2.0 * by / np.linalg.norm(ends[1] - ends[0]))


@pytest.mark.parametrize("moving", ["platform", "base"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_against_reciprocal_screws(layout: Layout, moving: Any) -> None:
    given = poses(np.random.default_rng(5), 200)
    expected = np.array([by_screws(layout, pose, moving) for pose in given])
    assert output_transmission(layout, given, moving) == pytest.approx(expected, abs=1e-9)
    assert local_transmission(layout, given, moving) == pytest.approx(expected.min(axis=1), abs=1e-9)


def test_against_limbs_that_are_held() -> None:
    for pose in poses(np.random.default_rng(6), 8):
        if local_transmission(TEXT, pose) < 0.1:  # the equations of three lengths become ill-conditioned
            continue
        expected = [by_moving(TEXT, pose, limb) for limb in range(3)]
        assert output_transmission(TEXT, pose) == pytest.approx(expected, rel=1e-5)


def test_the_index_depends_on_which_body_moves() -> None:
    one = REFERENCE["index"]
    assert local_transmission(TEXT, one["pose"]) == pytest.approx(one["platform"], abs=5e-5)
    assert local_transmission(TEXT, one["pose"], "base") == pytest.approx(one["base"], abs=5e-5)


def test_exchanging_the_bodies_exchanges_the_choice() -> None:
    """Seen from the platform the base is a platform of the mechanism with L1, L2 and L3, L4 exchanged (text)."""
    layout = Layout((0.10, 0.09, 0.07, 0.06))
    other = Layout((0.09, 0.10, 0.06, 0.07))
    given = poses(np.random.default_rng(7), 100)
    x, w, alpha = given.T
    # O1 from O2 in the platform's frame, turned by half a turn about Y's normal so that w stays above 0.
    seen = np.stack((-(x * np.cos(alpha) - w * np.sin(alpha)), x * np.sin(alpha) + w * np.cos(alpha), alpha), axis=-1)
    assert local_transmission(layout, given, "base") == pytest.approx(local_transmission(other, seen), abs=1e-12)


@pytest.mark.parametrize("moving", ["platform", "base"])
def test_grid_and_poses_agree(moving: Any) -> None:
    x, w = np.linspace(-0.1, 0.1, 23), np.linspace(0.05, 0.24, 17)
    grid = transmission_grid(TEXT, x, w, 0.4, moving)
    across, along = np.meshgrid(x, w)
    given = np.stack((across, along, np.full_like(across, 0.4)), axis=-1)
    assert grid == pytest.approx(local_transmission(TEXT, given, moving), abs=1e-13)


def test_parallel_lines_of_locked_limbs_are_a_translation() -> None:
    """With L3 = L1 - L2 limbs 2 and 3 are parallel at alpha = 0, and the platform moves straight across them."""
    layout = Layout((0.100, 0.025, 0.075, 0.060))
    given = np.array([0.03, 0.15, 0.0])
    vectors = limb_vectors(layout, given)
    one, two = vectors[:2] / np.linalg.norm(vectors[:2], axis=1, keepdims=True)
    assert output_transmission(layout, given)[0] == pytest.approx(abs(one[0] * two[1] - one[1] * two[0]), abs=1e-14)
    assert output_transmission(layout, given) == pytest.approx(by_screws(layout, given, "platform"), abs=1e-9)


def test_singular_poses_are_zero_and_nothing_else_is_made_of_nan() -> None:
    flat = [[0.05, 0.0, 0.0], [0.0, 0.0, 0.0], [0.075, 0.0, 0.0]]  # all joints on one line; the last without a limb
    assert (local_transmission(TEXT, flat) == 0.0).all()
    values = local_transmission(TEXT, [[np.nan, 0.15, 0.0], [0.0, np.inf, 0.0], [0.0, 0.15, 0.0]])
    assert np.isnan(values[:2]).all()
    assert values[2] > 0.0


def test_scale_does_not_matter() -> None:
    given = poses(np.random.default_rng(8), 50)
    for factor in (1e-6, 1e3):
        l1, l2, l3, l4 = (factor * length for length in TEXT.lengths)
        grown = Layout((l1, l2, l3, l4))
        scaled = given * (factor, factor, 1.0)
        assert local_transmission(grown, scaled) == pytest.approx(local_transmission(TEXT, given), abs=1e-9)


def test_the_map_of_the_workspace() -> None:
    one = REFERENCE["workspace"]
    found = transmission_map(TEXT, 5e-4)
    assert found.gti == pytest.approx(one["gti"], abs=5e-4)
    assert found.mean == pytest.approx(one["mean"], abs=5e-4)
    assert found.largest == pytest.approx((one["max"], *one["max_at"]), abs=5e-4)
    assert found.within_limits == 1.0
    assert found.least[0] == np.nanmin(found.values)


def test_the_map_of_a_rectangle() -> None:
    one = REFERENCE["dimensions"]
    found = transmission_map(TEXT, 1e-3, rectangle=Rectangle(*one["rectangle"]))
    assert found.cells == 7000
    assert found.gti == pytest.approx(one["original"], abs=5e-5)
    assert found.within_limits == 1.0
    beyond = transmission_map(TEXT, 1e-3, rectangle=Rectangle(-0.2, 0.2, 0.0, 0.3))
    assert 0.1 < beyond.within_limits < 0.2


def test_an_empty_workspace_names_its_limit() -> None:
    with pytest.raises(InfeasibleError, match="joint limits of 30 deg counted from 'normal'"):
        transmission_map(replace(TEXT, neutral="normal"), 1e-3, np.pi / 6)
    with pytest.raises(InfeasibleError, match="assembly mode"):
        transmission_map(TEXT, 1e-3, np.pi)
    for lengths in ((0.7, 0.1, 0.3, 0.1), (1e6, 1e6, 1e5, 1e5)):
        with pytest.raises(InfeasibleError, match="limb lengths of 0.12 to 0.24 m"):
            transmission_map(Layout(lengths), 1e-3)
    singular = Layout((0.05, 0.03, 0.10, 0.06))  # K = L3 (L2 - L4) + L1 L4 = 0
    with pytest.raises(InfeasibleError, match="no working mode"):
        transmission_map(singular, 1e-3)


@pytest.mark.parametrize(
    "sides",
    [(0.05, -0.05, 0.13, 0.2), (-0.05, 0.05, 0.2, 0.13), (-0.05, 0.05, -0.1, 0.2), (np.nan, 0.05, 0.13, 0.2)],
)
def test_rectangles_that_are_none(sides: tuple[float, float, float, float]) -> None:
    with pytest.raises(InputError, match="X0 < X1|finite"):
        Rectangle(*sides)


@pytest.mark.parametrize("step", [0.0, -1e-3, 0.08, 1e-8, np.nan, np.inf])
def test_steps_that_do_not_cut_a_rectangle(step: float) -> None:
    with pytest.raises(InputError, match="step"):
        Rectangle(-0.05, 0.05, 0.13, 0.2).cells(step)
