"""Singularities of the pipe climber: the explicit surface, its cases, distances, slices and certified paths."""

from __future__ import annotations

import math

import numpy as np
import pytest
from climber_cases import LAYOUTS, REFERENCE, anywhere, layout, named

from steeplejack.errors import InfeasibleError, InputError
from steeplejack.robots.pipe_climber import Layout
from steeplejack.robots.pipe_climber.forward import home_determinant
from steeplejack.robots.pipe_climber.inverse import limb_lengths, limb_vectors
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.singular_path import check_polynomials, check_waypoints
from steeplejack.robots.pipe_climber.singular_slice import reachable_x, singular_slice
from steeplejack.robots.pipe_climber.singularity import (
    determinant,
    singular_case,
    singular_x,
    singularity_distance,
    singularity_turn,
    surface_value,
)


@pytest.mark.parametrize("mechanism", LAYOUTS, ids=named)
def test_the_formula_is_the_determinant(mechanism: Layout, rng: np.random.Generator) -> None:
    pose = anywhere(rng, 200)
    assert determinant(mechanism, pose) == pytest.approx(np.linalg.det(jacobian(mechanism, pose)), abs=1e-14)
    level = pose * [1.0, 1.0, 0.0]
    expected = -home_determinant(mechanism) * level[:, 1] ** 2 / limb_lengths(mechanism, level).prod(axis=1)
    assert determinant(mechanism, level) == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("mechanism", LAYOUTS, ids=named)
def test_the_surface_is_singular_and_both_sides_differ(mechanism: Layout, rng: np.random.Generator) -> None:
    _, w, alpha = anywhere(rng, 100).T
    x = singular_x(mechanism, w, alpha)
    near = np.abs(x) < 1.0
    on = np.stack((x, w, alpha), axis=-1)[near]
    assert determinant(mechanism, on) == pytest.approx(np.zeros(near.sum()), abs=1e-13)
    sides = [np.sign(surface_value(mechanism, on + [shift, 0.0, 0.0])) for shift in (-1e-4, 1e-4)]
    assert (sides[0] == -sides[1]).all()
    assert np.isnan(singular_x(mechanism, 0.16, 0.0))


@pytest.mark.parametrize("mechanism", LAYOUTS, ids=named)
def test_three_lines_meet_and_one_motion_is_free(mechanism: Layout, rng: np.random.Generator) -> None:
    for _, w, alpha in anywhere(rng, 20):
        pose = np.array([float(singular_x(mechanism, w, alpha)), w, alpha])
        case = singular_case(mechanism, pose)
        assert case.kind == "concurrent"
        assert case.point is not None
        vectors = limb_vectors(mechanism, pose)
        arms = case.point - np.stack((mechanism.base, np.zeros(3)), axis=-1)
        lever = (arms[:, 0] * vectors[:, 1] - arms[:, 1] * vectors[:, 0]) / np.linalg.norm(vectors, axis=1)
        assert np.abs(lever).max() < 1e-9 * max(1.0, np.abs(case.point).max() / 0.1)
        unit = mechanism.lengths[0]
        assert jacobian(mechanism, pose) @ (case.freedom * [unit, unit, 1.0]) == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.parametrize("alpha", [0.0, math.pi])
def test_parallel_limbs_lie_along_x(alpha: float) -> None:
    case = singular_case(layout(), [0.4, 0.0, alpha])
    assert (case.kind, case.point) == ("parallel", None)
    assert np.abs(limb_vectors(layout(), [0.4, 0.0, alpha])[:, 1]).max() < 1e-16
    with pytest.raises(InputError, match="limb 2 has no length"):
        singular_case(layout(), [-0.075, 0.0, 0.0])


@pytest.mark.parametrize("mechanism", LAYOUTS, ids=named)
def test_distances_against_a_fine_search(mechanism: Layout, rng: np.random.Generator) -> None:
    heights, turns = np.linspace(-0.6, 0.6, 240_001), np.linspace(0.0, math.pi, 20_001)
    for pose in anywhere(rng, 6):
        x, w, alpha = pose
        curve = np.hypot(singular_x(mechanism, heights, alpha) - x, heights - w)
        searched = float(np.nanmin(curve))
        sine = math.sin(alpha)
        if abs(mechanism.lengths[0] - mechanism.lengths[2]) < 1e-12:  # L1 = L3: a line w = -L4 sin a besides
            searched = min(searched, abs(w + mechanism.lengths[3] * sine))
        assert float(singularity_distance(mechanism, pose)) == pytest.approx(searched, abs=2e-4)
        assert float(singularity_distance(mechanism, pose)) <= searched + 1e-12
        both = np.concatenate((-turns[:0:-1], turns))
        values = surface_value(mechanism, pose + both[:, None] * [0.0, 0.0, 1.0])
        near = float(np.abs(both[np.flatnonzero(np.diff(np.sign(values)))]).min())
        assert float(singularity_turn(mechanism, pose)) == pytest.approx(near, abs=2e-4)


def test_distance_at_home_is_w(rng: np.random.Generator) -> None:
    assert singularity_distance(layout(), [[0.01, 0.16, 0.0], [0.0, -0.2, 0.0]]) == pytest.approx([0.16, 0.2])
    assert math.isnan(singularity_distance(layout(), [0.0, math.nan, 0.0]))


def test_least_determinant_within_30_degrees() -> None:
    found = {degrees: singular_slice(layout(), math.radians(degrees)) for degrees in range(-30, 31, 5)}
    least = min(one.least for one in found.values()) / layout().lengths[0]
    assert least == pytest.approx(REFERENCE["singularity"]["least_det_per_l1"], abs=0.005)
    assert all(one.crossings == 0 and one.signs == (-1,) for one in found.values())


@pytest.mark.parametrize("degrees", [-30.0, 0.0, 22.0])
def test_a_slice_against_a_grid(degrees: float) -> None:
    alpha = math.radians(degrees)
    found = singular_slice(layout(), alpha)
    x, w = np.meshgrid(np.linspace(-0.3, 0.3, 1201), np.linspace(1e-6, 0.3, 601))
    poses = np.stack((x, w, np.full(x.shape, alpha)), axis=-1)
    lengths = limb_lengths(layout(), poses)
    inside = ((lengths >= 0.12) & (lengths <= 0.24)).all(axis=-1)
    grid = float(np.abs(determinant(layout(), poses))[inside].min())
    assert found.least <= grid + 1e-12
    assert found.least == pytest.approx(grid, abs=4e-4)
    assert float(np.abs(determinant(layout(), [*found.least_at, alpha]))) == pytest.approx(found.least)
    row = next(k for k in range(300, 601) if inside[k].any())
    counted = sum(((x[row] >= low) & (x[row] <= high)).sum() for low, high in reachable_x(layout(), alpha, w[row, 0]))
    assert counted == inside[row].sum()
    assert (singular_x(layout(), found.curve[:, 0], alpha) == found.curve[:, 1]).all()


def test_a_slice_that_the_surface_cuts() -> None:
    found = singular_slice(layout(), math.radians(-70.0))
    assert found.least == 0.0
    assert found.signs == (-1, 1)
    assert found.crossings == 2
    assert abs(float(surface_value(layout(), [*found.least_at, math.radians(-70.0)]))) < 1e-15


def test_an_empty_slice_names_the_lengths() -> None:
    with pytest.raises(InfeasibleError, match=r"0\.12 to 0\.125 m"):
        singular_slice(layout(reach=(0.12, 0.125)), math.radians(60.0))
    with pytest.raises(InputError, match="finite angle"):
        singular_slice(layout(), math.inf)


def test_straight_paths_are_proved_free_or_crossing(rng: np.random.Generator) -> None:
    counts = {"free": 0, "crosses": 0}
    for _ in range(200):
        ends = anywhere(rng, 2)
        found = check_waypoints(layout(), ends)
        t = np.linspace(0.0, 1.0, 5001)[:, None]
        values = surface_value(layout(), ends[0] * (1.0 - t) + ends[1] * t)
        changes = np.flatnonzero(np.diff(np.sign(values)))
        counts[found.verdict] += 1
        assert found.pieces < 3000
        if found.between is None:
            assert changes.size == 0
        else:
            low, high = found.between
            assert high - low < 1e-9
            if changes.size:
                assert low <= t[changes[0] + 1, 0] + 1e-12
    assert min(counts.values()) > 20


def test_what_samples_miss_is_found() -> None:
    """Over the surface and back within a thousandth of the path."""
    w, alpha = 0.15, -0.9
    x = float(singular_x(layout(), w, alpha))
    # x(t) dips 1 um beyond the surface at t = 0.5 only.
    dip = np.polynomial.polynomial.polyfromroots([0.5, 0.5]) * 0.5
    for depth, verdict in ((1e-6, "crosses"), (-1e-6, "free")):
        for side in (1.0, -1.0):
            path = side * (dip - [depth, 0.0, 0.0]) + [x, 0.0, 0.0]
            assert check_polynomials(layout(), (path, [w], [alpha]), (0.0, 1.0)).verdict == verdict
    touching = side * dip + [x, 0.0, 0.0]
    assert check_polynomials(layout(), (touching, [w], [alpha]), (0.0, 1.0)).verdict != "free"


def test_waypoints_count_along_the_path() -> None:
    found = check_waypoints(layout(), [[0.0, 0.16, 0.0], [0.02, 0.2, 0.3], [0.0, 0.15, -2.4]])
    assert found.verdict == "crosses"
    assert found.between is not None
    assert 1.0 < found.between[0] < 2.0


def test_paths_that_are_none() -> None:
    with pytest.raises(InputError, match="at least 2"):
        check_waypoints(layout(), [[0.0, 0.16, 0.0]])
    with pytest.raises(InputError, match="smaller first"):
        check_polynomials(layout(), ([0.0], [0.16], [0.0]), (1.0, 0.0))
    with pytest.raises(InputError, match="finite"):
        check_polynomials(layout(), ([math.nan], [0.16], [0.0]), (0.0, 1.0))
