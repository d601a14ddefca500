"""Singularities of the pipe climber: the explicit surface, its cases, distances, slices and certified paths."""

from __future__ import annotations

import math

import numpy as np
import pytest
from climber_cases import LAYOUTS, REFERENCE, Array, anywhere, layout, named

from steeplejack.errors import InfeasibleError, InputError
from steeplejack.robots.pipe_climber import BUILT_IN, Layout, load_pipe_climber
from steeplejack.robots.pipe_climber.forward import home_determinant
from steeplejack.robots.pipe_climber.inverse import limb_lengths, limb_vectors
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.motion import Motion
from steeplejack.robots.pipe_climber.singular_path import check_polynomials, check_waypoints
from steeplejack.robots.pipe_climber.singular_slice import reachable_x, singular_slice
from steeplejack.robots.pipe_climber.singularity import (
    determinant,
    is_degenerate,
    singular_case,
    singular_x,
    singularity_distance,
    singularity_turn,
    surface_value,
)
from steeplejack.robots.pipe_climber.violations import violations


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


def searched_distance(mechanism: Layout, pose: Array) -> float:
    """Radius of the largest circle about a pose whose points all have its sign, by bisection."""
    around = np.linspace(0.0, 2.0 * math.pi, 20_001)
    circle = np.stack((np.cos(around), np.sin(around), np.zeros(around.size)), axis=-1)
    sign = np.sign(surface_value(mechanism, pose))
    low, high = 0.0, 10.0
    for _ in range(36):
        middle = 0.5 * (low + high)
        if (np.sign(surface_value(mechanism, pose + middle * circle)) == sign).all():
            low = middle
        else:
            high = middle
    return high


NEARLY = [
    ((0.1, 0.1, 0.09999999, 0.05), (0.19696, -0.03724, 2.79613)),  # almost two lines
    ((0.1, 0.0750001, 0.08, 0.075), (0.03888, 0.05937, -1.00749)),  # three stationary points almost in one
    ((0.1, 0.1, 0.1, 0.05), (0.05, 0.12, 1.0)),  # two lines
    ((0.1, 0.1, 0.2, 0.2), (0.0, 0.15, 0.4)),  # K = 0: one line
    ((0.1, 0.1, 0.2, 0.2000001), (0.0, 0.15, 0.4)),
]


@pytest.mark.parametrize(("lengths", "pose"), NEARLY)
def test_distances_near_degeneracy(lengths: tuple[float, ...], pose: tuple[float, ...]) -> None:
    mechanism = Layout(lengths)  # pyright: ignore
    found = float(singularity_distance(mechanism, pose))
    assert found == pytest.approx(searched_distance(mechanism, np.array(pose)), rel=1e-5)


def test_distances_of_layouts_that_are_almost_two_lines(rng: np.random.Generator) -> None:
    for turn in range(40):
        l1, l2, l3, l4 = rng.uniform(0.03, 0.2, 4)
        off = 1.0 + rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-12.0, -3.0)
        lengths = (l1, l2, l1 * off, l4) if turn % 2 else (l1, l2, l3, l2 * off)
        mechanism, (pose,) = Layout(lengths), anywhere(rng, 1)
        expected = searched_distance(mechanism, pose)
        assert float(singularity_distance(mechanism, pose)) == pytest.approx(expected, rel=1e-5, abs=1e-6)


def test_distance_with_parallel_platforms() -> None:
    """There w = 0, pi in double precision too. Beside pi two branches leave a gap, here x from -0.2 to -0.12 m."""
    pose = np.array([-0.1377, 0.01397, math.pi])
    assert float(singularity_distance(layout(), pose)) == 0.01397
    for off in (1e-12, 1e-11, -1e-9):
        beside = float(singularity_distance(layout(), pose + [0.0, 0.0, off]))
        assert beside == pytest.approx(math.hypot(0.1377 - 0.12, 0.01397), rel=5e-4)
        level = float(singularity_distance(layout(), [-0.1377, 0.01397, off]))
        assert level == pytest.approx(0.01397, rel=1e-6)
    similar = Layout((0.1, 0.1, 0.2, 0.2))
    assert is_degenerate(similar)
    assert singularity_distance(similar, [[0.0, 0.15, 0.0], [0.0, 0.15, math.pi]]).tolist() == [0.0, 0.0]


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
    assert found.crossings == 3  # one of them 0.2 mm high, where the curve is steep
    assert abs(float(surface_value(layout(), [*found.least_at, math.radians(-70.0)]))) < 1e-15


def test_lines_and_thin_pieces_are_counted() -> None:
    """L1 = L3 and a line of constant w within reach; a piece of the curve that lies between two rows."""
    lines = Layout((0.05, 0.05, 0.05, 0.015), reach=(0.03, 0.08))
    thin = Layout((0.1161616047, 0.1008565329, 0.0964334901, 0.1498102877))
    for mechanism, degrees in ((lines, -90.0), (thin, -169.234)):
        alpha = math.radians(degrees)
        found = singular_slice(mechanism, alpha)
        assert (found.least, found.signs) == (0.0, (-1, 1))
        assert found.crossings >= 1
        at = np.array([*found.least_at, alpha])
        assert abs(float(surface_value(mechanism, at))) < 1e-12 * max(mechanism.lengths) ** 4
        within = limb_lengths(mechanism, at)
        assert (within >= mechanism.reach[0] - 1e-12).all()
        assert (within <= mechanism.reach[1] + 1e-12).all()
    drawn = singular_slice(lines, -0.5 * math.pi).curve
    line = drawn[np.abs(drawn[:, 0] - 0.015) < 1e-12]
    for low, high in reachable_x(lines, -0.5 * math.pi, 0.015):
        assert np.abs(line[:, 1] - low).min() < 1e-9
        assert np.abs(line[:, 1] - high).min() < 1e-9
    assert singular_slice(layout(), math.pi).curve.size == 0


@pytest.mark.parametrize("degrees", [-169.0, -110.0, -60.0, 45.0, 130.0])
def test_no_sign_changes_unseen(degrees: float, rng: np.random.Generator) -> None:
    """Neighbours of unlike signs on a grid of reachable poses: the surface lies between them, and is found."""
    alpha = math.radians(degrees)
    for _ in range(6):
        mechanism = Layout(tuple(rng.uniform(0.04, 0.15, 4)))  # pyright: ignore
        x, w = np.meshgrid(np.linspace(-0.4, 0.4, 801), np.linspace(1e-3, 0.4, 400))
        poses = np.stack((x, w, np.full(x.shape, alpha)), axis=-1)
        lengths = limb_lengths(mechanism, poses)
        inside = ((lengths >= 0.12) & (lengths <= 0.24)).all(axis=-1)
        if not inside.any():
            continue
        signs = np.where(inside, np.sign(surface_value(mechanism, poses)), 0.0)
        changes = (signs[:, 1:] * signs[:, :-1] < 0.0).any() or (signs[1:] * signs[:-1] < 0.0).any()
        found = singular_slice(mechanism, alpha)
        if changes:
            assert found.least == 0.0
            assert found.crossings >= 1
        assert (found.least == 0.0) == (found.crossings > 0)


def test_an_empty_slice_names_the_lengths() -> None:
    with pytest.raises(InfeasibleError, match=r"0\.12 to 0\.125 m"):
        singular_slice(layout(reach=(0.12, 0.125)), math.radians(60.0))
    with pytest.raises(InputError, match="finite angle"):
        singular_slice(layout(), math.inf)
    with pytest.raises(InfeasibleError, match="like proportions"):
        singular_slice(Layout((0.1, 0.1, 0.2, 0.2)), -0.5)


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


def test_a_motion_on_the_surface_is_not_said_to_cross_it() -> None:
    x = float(singular_x(layout(), 0.15, -0.9))
    still = Motion("still", 1.0, (x,), (0.15,), (-0.9,))
    found = {one.what for one in violations(load_pipe_climber(BUILT_IN), layout(), still, 0.0)}
    assert "singularity not excluded" in found
    assert "singularity" not in found
