"""Wrench feasibility: linear programs, rational arithmetic, certificates, sets of wrenches, loads of motion."""

from __future__ import annotations

import numpy as np
import oracles
import pytest
from published_robots import COGIRO, GRAVITY, IPANEMA_2, KNTU, PLANAR, PLANAR_4_4, SPATIAL, TABLE_III
from scipy.spatial import ConvexHull

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    FeasibilityStatus,
    TaskWrenches,
    capacity_margin,
    certificate_gap,
    characteristic_length,
    gravity_wrench,
    planar_structure_matrix,
    spatial_structure_matrix,
    wrench_closure,
    wrench_feasible,
)


def loaded(robot, rng, count):
    """Structure matrices at random poses and the wrench of gravity there."""
    poses = robot.poses(rng, count)
    if robot.dimension == 2:
        cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        x, y = robot.centre
        arms = np.stack((cos * x - sin * y, sin * x + cos * y), axis=-1)
        return (
            planar_structure_matrix(robot.anchors, robot.attachments, poses),
            gravity_wrench(robot.mass, [0.0, -GRAVITY], arms),
        )
    return (
        spatial_structure_matrix(robot.anchors, robot.attachments, *poses),
        gravity_wrench(robot.mass, [0.0, 0.0, -GRAVITY], poses[1] @ robot.centre),
    )


def window(robot):
    """Tension bounds, not alike for all cables."""
    m = len(robot.anchors)
    return robot.window[0] + np.linspace(0.0, 1.0, m), robot.window[1] * np.linspace(1.0, 0.9, m)


@pytest.mark.parametrize("robot", PLANAR + SPATIAL, ids=lambda r: r.name)
def test_published_robots_agree_with_a_linear_program(robot, rng):
    structures, wrenches = loaded(robot, rng, 500)
    low, high = window(robot)
    answer = wrench_feasible(structures, low, high, wrenches, characteristic_length(robot.attachments))
    assert 25 < answer.feasible.sum() < 475
    for k, (structure, wrench) in enumerate(zip(structures, wrenches, strict=True)):
        margin = oracles.window_margin(structure, wrench, low, high)
        if abs(margin) > oracles.BAND:
            assert answer.feasible[k] == (margin > 0.0)
        else:
            assert answer.feasible[k] == oracles.holds_exactly(structure, wrench, low, high)
        if not answer.feasible[k]:
            assert oracles.certified_gap(answer.certificate[k], structure, wrench, low, high) > 0.0


def test_rational_arithmetic_agrees_beside_the_surface(rng):
    """Loads pushed a little inside and a little outside a facet, where a linear program is not believed."""
    for robot in (PLANAR_4_4, KNTU):
        structures, wrenches = loaded(robot, rng, 12)
        low, high = window(robot)
        for structure, wrench in zip(structures, wrenches, strict=True):
            inside = -(structure @ (0.5 * (low + high)))
            for share in (-1e-7, 1e-7):
                scale = surface(structure, low, high, inside, wrench - inside) * (1.0 + share)
                load = inside + scale * (wrench - inside)
                answer = wrench_feasible(structure, low, high, load)
                assert abs(answer.margin) < 1e-4 * high.max()
                assert answer.feasible == oracles.holds_exactly(structure, load, low, high) == (share < 0.0)


def surface(structure, low, high, start, direction):
    """How far along a direction wrenches stay available, by the hull of the images of the box's corners."""
    hull = ConvexHull(corner_images(structure, low, high))
    rate, left = hull.equations[:, :-1] @ -direction, -hull.equations[:, -1] - hull.equations[:, :-1] @ -start
    return (left[rate > 0.0] / rate[rate > 0.0]).min()


def corner_images(structure, low, high):
    m = structure.shape[1]
    bits = (np.arange(2**m)[:, None] >> np.arange(m)) & 1
    return (low + bits * (high - low)) @ structure.T


@pytest.mark.parametrize("robot", [PLANAR_4_4, KNTU, TABLE_III, IPANEMA_2, COGIRO], ids=lambda r: r.name)
def test_capacity_margin_is_the_distance_to_the_convex_hull_of_the_corners(robot, rng):
    structures, wrenches = loaded(robot, rng, 3 if robot.dimension == 3 else 25)
    low, high = window(robot)
    length = characteristic_length(robot.attachments)
    unit = np.array([1.0, 1.0, 1.0 / length] if robot.dimension == 2 else [1.0 / length] * 3 + [1.0] * 3)
    for structure, wrench in zip(structures, wrenches, strict=True):
        hull = ConvexHull(unit * corner_images(structure, low, high))
        distances = -hull.equations[:, -1] - hull.equations[:, :-1] @ (-wrench * unit)
        margin = capacity_margin(structure, low, high, wrench, length)
        assert margin == pytest.approx(distances.min(), abs=1e-7 * high.max())


def test_pycapacity_has_the_same_margin_on_planar_robots(rng):
    pycapacity = pytest.importorskip("pycapacity.algorithms", reason="pycapacity is not installed")
    for robot in PLANAR:
        structures, wrenches = loaded(robot, rng, 20)
        low, high = window(robot)
        for structure, wrench in zip(structures, wrenches, strict=True):
            h, d = pycapacity.hyper_plane_shift_method(structure, low, high)
            theirs = np.min((np.ravel(d) - h @ -wrench) / np.linalg.norm(h, axis=1))
            assert capacity_margin(structure, low, high, wrench) == pytest.approx(theirs, abs=1e-6)


def test_a_box_is_as_hard_as_its_worst_corner(rng):
    for robot in (TABLE_III, IPANEMA_2):
        structures, wrenches = loaded(robot, rng, 40)
        low, high = window(robot)
        n = wrenches.shape[-1]
        half = np.abs(rng.normal(size=n)) * 0.1 * np.abs(wrenches).max()
        corners = wrenches[:, None] + half * (1 - 2 * ((np.arange(2**n)[:, None] >> np.arange(n)) & 1))
        box = wrench_feasible(structures, low, high, TaskWrenches.box(wrenches - half, wrenches + half), 0.2)
        hull = wrench_feasible(structures, low, high, TaskWrenches.polytope(corners), 0.2)
        each = wrench_feasible(structures[:, None], low, high, corners, 0.2)
        np.testing.assert_allclose(box.margin, each.margin.min(axis=1), rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(hull.margin, box.margin, rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(box.feasible, each.feasible.all(axis=1))
        np.testing.assert_allclose(box.worst, hull.worst, rtol=1e-9, atol=1e-9)
        for k in np.flatnonzero(~box.feasible):
            assert oracles.certified_gap(box.certificate[k], structures[k], box.worst[k], low, high) > 0.0


def test_a_margin_is_room_for_any_wrench_of_that_size(rng):
    structures, wrenches = loaded(TABLE_III, rng, 200)
    low, high = window(TABLE_III)
    length = characteristic_length(TABLE_III.attachments)
    margin = capacity_margin(structures, low, high, wrenches, length)
    direction = rng.normal(size=(len(margin), 50, 3))
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    direction *= [1.0, 1.0, length]
    held = margin > 0.0
    added = wrenches[:, None] + direction * 0.999 * margin[:, None, None]
    assert wrench_feasible(structures[:, None], low, high, added).feasible[held].all()


def test_nodes_of_table_iii_that_hold_30_kg(reference):
    table, given = reference["table_iii"], reference["workspace"]
    x, y = np.meshgrid(np.arange(-70, 50) / 100.0, np.arange(-10, 100) / 100.0)
    poses = np.stack((x, y, np.full_like(x, np.deg2rad(50.0))), axis=-1)
    structures = planar_structure_matrix(table["anchors"], table["attachments"], poses)
    load = gravity_wrench(given["mass"], table["gravity"], [0.0, 0.0])
    inside = wrench_closure(structures).inside
    assert inside.sum() == reference["map"][0]["inside"]
    assert (wrench_feasible(structures, *given["window"], load).feasible & inside).sum() == given["feasible"]


def test_unbounded_tensions_hold_everything_in_closure_and_a_half_space_outside(rng):
    for robot in (TABLE_III, IPANEMA_2, COGIRO):
        structures, wrenches = loaded(robot, rng, 150)
        closed = wrench_closure(structures)
        answer = wrench_feasible(structures, 1.0, np.inf, wrenches)
        assert (answer.margin[closed.inside] == np.inf).all()
        assert answer.feasible[closed.inside].all()
        out = np.flatnonzero(~closed.inside)
        assert np.isfinite(answer.margin[out]).all()
        pushed = wrenches[out] + 1e4 * closed.certificate[out]
        assert not wrench_feasible(structures[out], 0.0, np.inf, pushed).feasible.any()


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_units_of_force_and_length_do_not_matter(unit, rng):
    for robot in (TABLE_III, IPANEMA_2):
        structures, wrenches = loaded(robot, rng, 200)
        low, high = window(robot)
        plain = wrench_feasible(structures, low, high, wrenches, 0.3)
        forces = wrench_feasible(structures, unit * low, unit * high, unit * wrenches, 0.3)
        moments = np.array([1.0, 1.0, unit] if robot.dimension == 2 else [unit] * 3 + [1.0] * 3)
        lengths = wrench_feasible(structures * moments[:, None], low, high, wrenches * moments, 0.3 * unit)
        np.testing.assert_array_equal(forces.feasible, plain.feasible)
        np.testing.assert_array_equal(lengths.feasible, plain.feasible)
        np.testing.assert_allclose(forces.margin, unit * plain.margin, rtol=1e-6)
        np.testing.assert_allclose(lengths.margin, plain.margin, rtol=1e-6)


def test_a_singular_pose_is_never_feasible():
    structure = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0], [0.0, 0.0, 0.0, 0.0]])
    answer = wrench_feasible(structure, 1.0, 10.0, [0.0, 0.0, -2.0])
    assert answer.status == FeasibilityStatus.SINGULAR and not answer.feasible
    assert answer.margin == -np.inf
    assert oracles.certified_gap(answer.certificate, structure, answer.worst, 1.0, 10.0) == pytest.approx(2.0)
    spatial = wrench_feasible(np.vstack((structure, structure))[:, :3], 1.0, 10.0, np.ones(6))
    assert spatial.status == FeasibilityStatus.SINGULAR
    assert spatial.certificate @ np.ones(6) >= 0.0


def test_what_is_no_number_is_undefined(rng):
    structures, wrenches = loaded(TABLE_III, rng, 1)
    for bad in (np.nan, np.inf):
        broken = structures.copy()
        broken[0, 1, 2] = bad
        assert wrench_feasible(broken, 10.0, 200.0, wrenches).status == FeasibilityStatus.UNDEFINED
        task = wrench_feasible(structures, 10.0, 200.0, [0.0, bad, 0.0])
        assert task.status == FeasibilityStatus.UNDEFINED and np.isnan(task.worst).all()
    for low, high in ((np.nan, 200.0), (10.0, np.nan), (np.inf, np.inf), (-np.inf, -np.inf)):
        answer = wrench_feasible(structures, low, high, wrenches)
        assert answer.status == FeasibilityStatus.UNDEFINED and not answer.feasible.any()


def test_bad_questions_are_refused(rng):
    structures, wrenches = loaded(TABLE_III, rng, 2)
    with pytest.raises(InputError, match="characteristic length"):
        wrench_feasible(structures, 1.0, 2.0, wrenches, 0.0)
    with pytest.raises(InputError, match="task"):
        wrench_feasible(structures, 1.0, 2.0, np.zeros(6))
    with pytest.raises(InputError, match="lower"):
        wrench_feasible(structures, np.ones(3), 2.0, wrenches)
    with pytest.raises(InputError, match="task box"):
        TaskWrenches.box([1.0], [0.0])
    with pytest.raises(InputError, match="task polytope"):
        TaskWrenches.polytope(np.empty((0, 3)))
    with pytest.raises(InputError, match="attachments"):
        characteristic_length(np.zeros((4, 2)))


def test_every_status_says_what_to_do():
    assert all(len(status.advice) > 20 for status in FeasibilityStatus)


def test_hostile_robots_never_get_a_wrong_answer(rng):
    for trial in range(3000):
        n, m = ((3, 4), (3, 6), (6, 8), (6, 9))[trial % 4]
        structure = np.round(rng.normal(size=(n, m)) * 2.0) / 2.0 if trial % 3 else rng.normal(size=(n, m))
        if trial % 5 == 0:
            structure[:, 1] = structure[:, 0] * rng.choice([1.0, -1.0, 0.5])
        if trial % 7 == 0:
            structure[-1] = structure[0]
        low, high = rng.uniform(0.0, 5.0, m), rng.uniform(5.0, 50.0, m)
        high[0] = low[0] if trial % 11 == 0 else high[0]
        load = rng.normal(size=n) * 10.0
        length, force = rng.choice([1e-9, 1.0, 1e9], 2)
        moments = np.array([1.0, 1.0, length] if n == 3 else [length] * 3 + [1.0] * 3)
        scaled, low, high, load = structure * moments[:, None], low * force, high * force, load * moments * force
        answer = wrench_feasible(scaled, low, high, load, length)
        if (structure == 0.0).all(axis=0).any():
            assert answer.status == FeasibilityStatus.UNDEFINED
        elif answer.status == FeasibilityStatus.INFEASIBLE:
            assert oracles.certified_gap(answer.certificate, scaled, load, low, high) > 0.0
        elif answer.status == FeasibilityStatus.SINGULAR:
            assert np.linalg.matrix_rank(structure, tol=1e-6) < n
        else:
            assert answer.status == FeasibilityStatus.FEASIBLE
            if trial % 10 == 0:
                assert np.linalg.matrix_rank(structure) == n
                if (high > low).all():
                    assert oracles.window_margin(structure, load / moments, low, high) > -oracles.BAND


@pytest.mark.parametrize(("n", "m"), [(2, 4), (3, 4), (3, 5), (6, 7), (6, 8)])
def test_certificates_against_unbounded_tensions_pass_the_checker(n, m, rng):
    structures, wrenches = rng.normal(size=(600, n, m)), rng.normal(size=(600, n))
    structures[:300, 0] = np.abs(structures[:300, 0])
    wrenches[:300, 0] = np.abs(wrenches[:300, 0])
    structures[300:, :, 1] = structures[300:, :, 0]  # coincident cables: components that are zero but for rounding
    upper = np.full(m, np.inf)
    for limit in (np.inf, 5.0):
        upper[0] = limit
        answer = wrench_feasible(structures, 1.0, upper, wrenches)
        refused = answer.status == FeasibilityStatus.INFEASIBLE
        assert np.count_nonzero(refused) > 200
        gap = certificate_gap(answer.certificate, structures, wrenches, 1.0, upper)
        assert (gap[refused] > 0.0).all()
        assert np.isnan(gap[answer.feasible]).all()
    assert certificate_gap([1.0, 0.0], [[-1.0, 1.0], [0.0, 1.0]], [5.0, 0.0], 0.0, np.inf) == -np.inf
    assert certificate_gap([1.0, 0.0], [[0.0, 1.0], [1.0, 1.0]], [5.0, 0.0], 0.0, np.inf) == 5.0


def test_an_empty_window_holds_nothing_and_needs_no_proof(rng):
    structures, wrenches = loaded(TABLE_III, rng, 3)
    upper = np.full((3, 4), 200.0)
    upper[1, 2] = 5.0
    answer = wrench_feasible(structures, 10.0, upper, wrenches)
    assert answer.status[1] == FeasibilityStatus.INFEASIBLE
    assert answer.margin[1] == -np.inf
    assert np.isnan(answer.certificate[1]).all()
    alone = wrench_feasible(structures, 10.0, 200.0, wrenches)
    np.testing.assert_array_equal(answer.margin[[0, 2]], alone.margin[[0, 2]])
