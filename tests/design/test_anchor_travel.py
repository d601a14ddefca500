"""Anchors along a path: worth against linear programs, the search against every path there is, drives that hold."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations, product

import numpy as np
import pytest
from scipy.optimize import linprog

from steeplejack.design.anchors import (
    Duty,
    Reconfiguration,
    anchor_path,
    anchors_along,
    eq28,
    optimal_anchors,
    trade_off,
)
from steeplejack.design.anchors.drives import drive_orders, driven
from steeplejack.design.anchors.refine import _columns, net_worth, refine
from steeplejack.design.anchors.travel import best_travel
from steeplejack.design.anchors.worth import GRIPPED, worth, worth_of
from steeplejack.errors import InputError
from steeplejack.mechanics.cable import planar_structure_matrix, tension_factor

pytestmark = pytest.mark.long

TENSION_FACTOR = Duty()
SLIP = Duty("slip-margin", 8.0, (10.0, 250.0), (0.0, -9.81), 245.25, 147.15)


@pytest.fixture(scope="module")
def table(reference):
    anchors = np.array(reference["table_iii"]["anchors"])
    low, high = anchors[[0, 1]], anchors[[3, 2]]
    slopes = ((high - low)[:, 1] / (high - low)[:, 0])[[0, 1, 1, 0]]
    return Reconfiguration(
        anchors,
        np.stack([np.ones(4), slopes], -1),
        np.array(reference["table_iii"]["attachments"]),
        np.tile([-0.05, 0.05], (4, 1)),
        eq28(),
    )


def shaken(problem, rng, poses):
    """The same four stays somewhat elsewhere, and a path of few poses."""
    return replace(
        problem,
        anchors=problem.anchors + rng.normal(0.0, 0.03, (4, 2)),
        poses=problem.poses[10:30:3][:poses] + rng.normal(0.0, [0.02, 0.02, 0.05], (poses, 3)),
    )


def loaded_program(problem, offsets, pose, duty, driving):
    """Largest least margin by linear programming; None where nothing is allowed."""
    structure = planar_structure_matrix(problem.placed(offsets), problem.attachments, pose)
    along = problem.directions / np.linalg.norm(problem.directions, axis=1, keepdims=True)
    share = np.abs(np.sum(structure[:2].T * along, axis=1))
    limits = np.full(4, duty.hold)
    if driving is not None:
        limits[driving] = duty.drive
    weight = np.array([*(duty.mass * np.array(duty.gravity)), 0.0])
    top = np.minimum(duty.window[1], limits / share)
    if np.any(top < duty.window[0]):
        return None
    found = linprog(
        [0, 0, 0, 0, -1],
        A_ub=np.column_stack([np.diag(share / duty.hold), np.ones(4)]),
        b_ub=np.ones(4),
        A_eq=np.column_stack([structure, np.zeros(3)]),
        b_eq=-weight,
        bounds=[*zip(np.full(4, duty.window[0]), top, strict=True), (None, None)],
    )
    return None if found.x is None else -found.fun


def test_worth_without_a_load_is_the_tension_factor(table):
    rng = np.random.default_rng(1)
    poses = np.column_stack([rng.uniform(-0.5, 0.3, 200), rng.uniform(0.1, 0.8, 200), rng.uniform(0.6, 1.1, 200)])
    offsets = rng.uniform(-0.05, 0.05, (200, 4))
    problem = replace(table, poses=poses)
    value, flags = worth_of(problem, offsets, TENSION_FACTOR)
    expected = tension_factor(planar_structure_matrix(problem.placed(offsets), problem.attachments, poses))
    np.testing.assert_allclose(value, expected, atol=1e-12)
    assert 20 < np.count_nonzero(flags == 31) < 180
    np.testing.assert_array_equal(flags == 31, expected > 0.0)


def test_worth_under_a_load_is_what_linear_programs_say(table):
    rng = np.random.default_rng(2)
    poses = np.column_stack([rng.uniform(-0.5, 0.2, 60), rng.uniform(0.1, 0.7, 60), rng.uniform(0.6, 1.1, 60)])
    offsets = rng.uniform(-0.05, 0.05, (60, 4))
    problem = replace(table, poses=poses)
    value, flags = worth_of(problem, offsets, SLIP)
    answers = 0
    for k in range(60):
        truth = loaded_program(problem, offsets[k], poses[k], SLIP, None)
        assert (truth is not None) == bool(flags[k] & GRIPPED), k
        if truth is None:
            continue
        answers += 1
        assert value[k] == pytest.approx(truth, abs=1e-9)
        for base in range(4):
            driving = loaded_program(problem, offsets[k], poses[k], SLIP, base)
            assert (driving is not None) == bool(flags[k] >> base & 1), (k, base)
    assert 10 < answers < 55


def test_grid_and_single_configurations_are_one_calculation(table):
    rng = np.random.default_rng(3)
    problem = replace(table, poses=table.poses[5:7])
    axes = tuple(np.sort(rng.uniform(-0.05, 0.05, n)) for n in (2, 3, 1, 2))
    value, flags = worth(problem, axes, SLIP)
    for index in np.ndindex(value.shape[1:]):
        one = np.array([axis[i] for axis, i in zip(axes, index, strict=True)])
        alone, held = worth_of(problem, np.tile(one, (2, 1)), SLIP)
        np.testing.assert_array_equal(value[(slice(None), *index)], alone)
        np.testing.assert_array_equal(flags[(slice(None), *index)], held)


def every_path(problem, axes, duty, price, most_step, start):
    """Best net worth over every sequence of configurations and every order of drives, by plain enumeration."""
    value, flags = worth(problem, axes, duty)
    stretch = np.hypot(*problem.directions.T)
    nodes = list(np.ndindex(value.shape[1:]))
    if start is not None:
        best = {
            node: 0.0 if all(a[i] == s for a, i, s in zip(axes, node, start, strict=True)) else -np.inf
            for node in nodes
        }
    else:
        best = dict.fromkeys(nodes, 0.0)
    best = {node: best[node] + value[(0, *node)] if flags[(0, *node)] & GRIPPED else -np.inf for node in nodes}
    for k in range(1, len(problem.poses)):
        arrived = {}
        for after in nodes:
            costs = {n: drive_cost(n, after, flags[k - 1], axes, price * stretch, most_step / stretch) for n in nodes}
            arrived[after] = max((best[n] - cost for n, cost in costs.items() if cost is not None), default=-np.inf)
        best = {n: arrived[n] + value[(k, *n)] if flags[(k, *n)] & GRIPPED else -np.inf for n in nodes}
    return max(best.values())


def drive_cost(before, after, flags, axes, price, reach):
    """Price of the cheapest (any) order of drives that holds at every place passed; None where none does."""
    moving = [i for i in range(4) if before[i] != after[i]]
    cost = sum(price[i] * abs(axes[i][before[i]] - axes[i][after[i]]) for i in moving)
    if any(abs(axes[i][before[i]] - axes[i][after[i]]) > reach[i] + 1e-12 for i in moving):
        return None
    for order in permutations(moving):
        at = list(before)
        for base in order:
            way = 1 if after[base] > at[base] else -1
            places = [(*at[:base], j, *at[base + 1 :]) for j in range(at[base], after[base] + way, way)]
            if not all(flags[p] & GRIPPED and flags[p] >> base & 1 for p in places):
                break
            at[base] = after[base]
        else:
            return cost
    return None


@pytest.mark.parametrize(
    ("seed", "duty", "price", "most_step", "begin"),
    [
        (0, TENSION_FACTOR, 0.3, np.inf, False),
        (1, TENSION_FACTOR, 3.0, np.inf, True),
        (2, TENSION_FACTOR, 0.5, 0.05, False),
        (3, SLIP, 0.3, np.inf, False),
        (4, SLIP, 1.0, 0.06, True),
        (5, replace(SLIP, drive=60.0), 0.1, np.inf, False),
    ],
)
def test_search_is_as_good_as_every_path_there_is(table, seed, duty, price, most_step, begin):
    rng = np.random.default_rng(seed)
    problem = shaken(table, rng, 3)
    axes = tuple(np.sort(rng.uniform(-0.08, 0.08, n)) for n in (3, 2, 3, 2))
    start = np.array([axis[1] for axis in axes]) if begin else None
    truth = every_path(problem, axes, duty, price, most_step, start)
    found = best_travel(problem, axes, duty, price, most_step, start)
    value, flags = worth_of(problem, found.offsets, duty)
    assert np.isfinite(truth), "the case asks nothing"
    assert np.all(flags & GRIPPED)
    assert value.sum() - price * driven(problem, found.offsets).sum() == pytest.approx(truth, abs=1e-12)
    assert np.all(driven(problem, found.offsets) <= most_step + 1e-12)
    assert start is None or np.all(found.offsets[0] == start)


def test_derivatives_of_columns_along_the_stays(table):
    rng = np.random.default_rng(7)
    offsets, h = rng.uniform(-0.05, 0.05, (51, 4)), 1e-6
    columns, share, by_columns, by_share = _columns(table, offsets)
    up, down = _columns(table, offsets + h), _columns(table, offsets - h)
    np.testing.assert_allclose(by_columns, (up[0] - down[0]) / (2 * h), atol=1e-6)
    np.testing.assert_allclose(by_share, (up[1] - down[1]) / (2 * h), atol=1e-6)
    structure = planar_structure_matrix(table.placed(offsets), table.attachments, table.poses)
    np.testing.assert_allclose(np.swapaxes(columns, 1, 2), structure, atol=1e-14)
    assert np.all(share >= 0.0)


@pytest.mark.parametrize("duty", [TENSION_FACTOR, SLIP])
def test_refinement_never_loses_and_ends_where_no_stop_wants_to_move(table, duty):
    problem = replace(table, poses=table.poses[:40:3])
    axes = tuple(np.linspace(-0.05, 0.05, 5) for _ in range(4))
    coarse = best_travel(problem, axes, duty, 0.02 * 14).offsets
    fine = refine(problem, coarse, duty, 0.02, 0.02)
    before, after = net_worth(problem, coarse, duty, 0.02), net_worth(problem, fine, duty, 0.02)
    assert after >= before
    again = refine(problem, fine, duty, 0.02, 0.02)
    assert net_worth(problem, again, duty, 0.02) <= after + 1e-5
    rng = np.random.default_rng(8)
    for _ in range(200):  # no shift of whole stretches by up to 1 mm is worth more
        shift = rng.uniform(-1e-3, 1e-3, 4) * (rng.random(4) < 0.5)
        moved = np.clip(fine + shift, problem.windows[:, 0], problem.windows[:, 1])
        assert net_worth(problem, moved, duty, 0.02) <= after + 2e-5


def test_little_driving_keeps_nearly_all_of_the_tension_factor(table, reference):
    path = anchors_along(table, TENSION_FACTOR, 0.02)
    pointwise = reference["eq28"]["movable"]
    assert path.held.all()
    assert None not in path.orders
    assert path.travel < 0.25
    assert path.mean >= 0.98 * pointwise["all_grid_1_cm"]
    assert path.mean <= pointwise["all_continuous"] + 1e-6


def test_drives_hold_the_platform_all_the_way(table):
    path = anchors_along(table, TENSION_FACTOR, 0.002)
    drives = 0
    for k, order in enumerate(path.orders):
        at = path.offsets[k].copy()
        for base in order:
            way = np.tile(at, (50, 1))
            way[:, base] = np.linspace(at[base], path.offsets[k + 1, base], 50)
            structure = planar_structure_matrix(table.placed(way), table.attachments, table.poses[k])
            assert np.all(tension_factor(structure) > 0.0)
            at[base] = path.offsets[k + 1, base]
            drives += 1
    assert drives >= 3


def test_higher_prices_never_mean_more_driving_or_a_better_mean(table):
    problem = replace(table, poses=table.poses[::5], windows=np.array([[-0.05, 0.05], [0, 0], [-0.05, 0.05], [0, 0]]))
    paths = trade_off(problem, TENSION_FACTOR, [0.0, 0.01, 0.1, 10.0], 0.01)
    travel, mean = [p.travel for p in paths], [p.mean for p in paths]
    assert travel == sorted(travel, reverse=True)
    assert mean == sorted(mean, reverse=True)
    assert travel[-1] == 0.0 < travel[0]
    assert all(np.all(p.offsets[:, [1, 3]] == 0.0) for p in paths)


def test_start_and_rate_are_kept(table):
    problem = replace(table, poses=table.poses[:8])
    start = np.array([0.0, 0.013, 0.0, 0.0])
    path = anchors_along(problem, TENSION_FACTOR, 1e-4, 0.02, 0.015, start)
    np.testing.assert_allclose(path.offsets[0], start, atol=1e-12)
    assert 0.014 < driven(problem, path.offsets).max() <= 0.015 + 1e-9
    assert anchor_path(problem, path.offsets, TENSION_FACTOR).mean == path.mean


def test_poses_nobody_can_hold_count_nothing_and_are_said(table):
    lost = replace(table, poses=np.vstack([table.poses[:5], [[3.0, 3.0, 0.5]], table.poses[5:10]]))
    path = anchors_along(lost, TENSION_FACTOR, 0.01, 0.02)
    assert path.held.tolist() == [True] * 5 + [False] + [True] * 5
    assert path.value[5] == 0.0


def test_orders_say_where_the_platform_would_be_let_go(table):
    problem = replace(table, poses=np.array([[-0.1, 0.45, np.deg2rad(50.0)]] * 2))
    tiny = replace(SLIP, mass=8.0, drive=1.0)
    assert drive_orders(problem, np.array([np.zeros(4), [0.01, 0, 0, 0]]), TENSION_FACTOR) == [(0,)]
    assert drive_orders(problem, np.array([np.zeros(4), [0.01, 0, 0, 0]]), tiny) == [None]
    assert drive_orders(problem, np.zeros((2, 4)), tiny) == [()]


@pytest.mark.parametrize(
    ("call", "where"),
    [
        (lambda p: anchors_along(p, TENSION_FACTOR, -1.0), "travel price"),
        (lambda p: anchors_along(p, TENSION_FACTOR, np.nan), "travel price"),
        (lambda p: anchors_along(p, TENSION_FACTOR, 0.1, 0.0), "step"),
        (lambda p: anchors_along(p, TENSION_FACTOR, 0.1, 1e-6), "step"),
        (lambda p: anchors_along(p, TENSION_FACTOR, 0.1, most_step=0.0), "most step"),
        (lambda p: anchors_along(p, TENSION_FACTOR, 0.1, start=np.full(4, 0.2)), "start of anchor 1"),
        (lambda p: anchors_along(p, TENSION_FACTOR, 1e9), "travel price"),
        (lambda p: anchors_along(p, TENSION_FACTOR, 0.1, start=np.zeros(3)), "start"),
        (lambda p: Duty("slip-margin"), "objective slip-margin"),
        (lambda p: Duty("least-effort"), "objective"),
        (lambda p: replace(SLIP, gravity=(np.nan, 0.0)), "gravity"),
        (lambda p: replace(SLIP, window=(250.0, 10.0)), "tension window"),
        (lambda p: replace(SLIP, mass=-1.0), "mass"),
        (lambda p: replace(SLIP, drive=300.0), "pull limits"),
    ],
)
def test_bad_questions_are_named(table, call, where):
    with pytest.raises(InputError, match=where):
        call(table)


def test_all_products_of_the_candidates_are_looked_at(table):
    axes = tuple(np.array(values) for values in ([-0.05, 0.0, 0.02], [0.0], [0.0, 0.05], [-0.01, 0.03]))
    problem = replace(table, poses=table.poses[:1])
    found = best_travel(problem, axes, TENSION_FACTOR, 0.0)
    truth = max(worth_of(problem, np.array([v]), TENSION_FACTOR)[0][0] for v in product(*axes))
    assert worth_of(problem, found.offsets, TENSION_FACTOR)[0][0] == truth


def test_cables_through_one_point_hold_nothing(table):
    """Every tension factor is 0 there, and rounding is not taken for one."""
    for turn in (0.0, 0.3, 1.0):
        problem = replace(table, attachments=np.tile([[0.1, 0.07]], (4, 1)), poses=table.poses + [0.0, 0.0, turn])
        value, flags = worth_of(problem, np.zeros((51, 4)), TENSION_FACTOR)
        assert not value.any() and not flags.any()
        assert not (worth_of(problem, np.zeros((51, 4)), SLIP)[1] & GRIPPED).any()


@pytest.mark.parametrize("price", [0.0, 1.0])
def test_a_path_of_one_pose(table, price):
    problem = replace(table, poses=table.poses[:1])
    path = anchors_along(problem, TENSION_FACTOR, price)
    assert path.orders == ()
    assert path.travel == 0.0
    assert path.mean == pytest.approx(optimal_anchors(problem).tension_factor[0], abs=1e-4)


def test_holding_comes_before_any_price(table):
    # One configuration of this grid holds the first pose, another the second.
    axes = (np.array([-0.05, 0.05]), np.zeros(1), np.array([-0.05, 0.05]), np.zeros(1))
    problem = replace(table, poses=table.poses[[0, 48]])
    held = worth(problem, axes, TENSION_FACTOR)[1] & GRIPPED > 0
    assert held.any(axis=(1, 2, 3, 4)).all()
    for price in (1.0, 1e6):
        offsets = best_travel(problem, axes, TENSION_FACTOR, price).offsets
        assert np.all(worth_of(problem, offsets, TENSION_FACTOR)[1] & GRIPPED)


def test_wide_windows_get_a_coarser_first_grid(table):
    wide = replace(table, windows=np.tile([-0.4, 0.3], (4, 1)), poses=table.poses[:3])
    assert (
        anchors_along(wide, TENSION_FACTOR, 0.1).mean
        > anchors_along(replace(table, poses=table.poses[:3]), TENSION_FACTOR, 0.1).mean
    )
