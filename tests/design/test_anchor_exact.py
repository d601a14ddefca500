"""Exact anchors: published values, certificates, monotony, an independent optimiser, infeasible, degenerate cases."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from anchor_questions import random_problem, table_iii, through_an_attachment
from scipy.optimize import minimize

from steeplejack.design.anchors import (
    AnchorStatus,
    algorithm_2,
    binding_limits,
    nearest_anchors,
    optimal_anchors,
    tension_factors,
)
from steeplejack.design.anchors import limits as limits_module
from steeplejack.errors import InputError
from steeplejack.mechanics.cable import planar_lengths

SUBSETS = [subset for count in range(1, 5) for subset in combinations((1, 2, 3, 4), count)]


@pytest.mark.parametrize(
    ("movable", "mean"), [((), 0.253634), ((1,), 0.296699), ((1, 2, 3, 4), 0.524766)], ids=["fixed", "one", "all"]
)
def test_the_values_of_the_design_notes(reference, movable, mean):
    answer = optimal_anchors(table_iii(reference, movable), gap=1e-8)
    assert answer.tension_factor.mean() == pytest.approx(mean, abs=1e-6)
    assert set(answer.status) <= {AnchorStatus.CERTIFIED, AnchorStatus.INFEASIBLE}
    assert answer.gap[answer.status == AnchorStatus.CERTIFIED].max() <= 1e-8


@pytest.mark.parametrize("movable", SUBSETS, ids=str)
def test_no_subset_does_worse_than_the_grid(reference, movable):
    problem = table_iii(reference, movable)
    exact, grid = optimal_anchors(problem), algorithm_2(problem, 0.01)
    assert (exact.tension_factor >= grid.tension_factor - 1e-9).all()
    assert (exact.upper >= grid.tension_factor - 1e-13).all()
    assert (exact.offsets >= problem.windows[:, 0]).all()
    assert (exact.offsets <= problem.windows[:, 1]).all()
    np.testing.assert_allclose(exact.value, exact.tension_factor, atol=1e-12)
    assert exact.gap.max() <= 1e-6
    assert set(exact.status) <= {AnchorStatus.CERTIFIED, AnchorStatus.INFEASIBLE}


def test_more_freedom_is_never_worse(rng):
    for _ in range(25):
        problem = random_problem(rng)
        narrow = problem.windows.copy()
        anchor = rng.integers(4)
        fixed = problem.windows[anchor].mean()
        narrow[anchor] = fixed + rng.choice([0.0, 0.5]) * (narrow[anchor] - fixed)
        less, more = optimal_anchors(replace(problem, windows=narrow)), optimal_anchors(problem)
        assert (more.upper >= less.tension_factor).all()
        assert (more.tension_factor >= less.tension_factor - 1e-6).all()
        assert (more.status != AnchorStatus.EXHAUSTED).all()


def test_a_multistart_search_reaches_the_value_and_never_beats_the_bound(rng):
    reached = compared = 0
    for _ in range(15):
        problem = random_problem(rng, poses=1)
        answer = optimal_anchors(problem)
        low, span = problem.windows[:, 0], np.ptp(problem.windows, axis=1)

        def loss(share, problem=problem, low=low, span=span):
            return -tension_factors(problem, low + np.clip(share, 0.0, 1.0) * span)[0]

        shares = rng.random((200, 4))
        factors = np.array([-loss(share) for share in shares])
        best = factors.max()
        for start in np.argsort(factors)[-2:] if best > 0.0 else ():
            found = minimize(loss, shares[start], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-10})
            best = max(best, -found.fun)
        assert best <= answer.upper[0] + 1e-12
        if answer.status[0] == AnchorStatus.CERTIFIED:
            compared += 1
            reached += best >= answer.value[0] - 2e-3
    assert compared >= 4
    assert reached >= compared - 1


def test_units_and_place_do_not_matter(reference):
    problem = table_iii(reference, (1, 2, 3, 4))
    scale, shift = 1000.0, np.array([3.0, -7.0])
    poses = problem.poses.copy()
    poses[:, :2] = (poses[:, :2] + shift) * scale
    moved = replace(
        problem,
        anchors=(problem.anchors + shift) * scale,
        attachments=problem.attachments * scale,
        windows=problem.windows * scale,
        poses=poses,
    )
    np.testing.assert_allclose(optimal_anchors(moved).value, optimal_anchors(problem).value, atol=1e-6)


def test_infeasible_windows_say_which_limit_binds(reference):
    problem = table_iii(reference, (1, 2))
    answer = optimal_anchors(problem)
    none = np.flatnonzero(answer.status == AnchorStatus.INFEASIBLE)
    np.testing.assert_array_equal(none, np.arange(44, 51))
    assert (answer.upper[none] < 1e-9).all()
    limits = binding_limits(replace(problem, poses=problem.poses[44:45]))
    assert [limit.cables for limit in limits] == [(1,)]
    assert "cable 2 would have to push" in limits[0].text
    widened = problem.windows.copy()
    widened[2, 0] -= limits[0].widening[2, 0]
    one = replace(problem, poses=problem.poses[44], windows=widened)
    assert optimal_anchors(one).tension_factor[0] > 0.0
    widened[2, 0] += 1e-6
    assert optimal_anchors(replace(one, windows=widened)).status[0] == AnchorStatus.INFEASIBLE


@pytest.mark.long
def test_a_curve_of_optima_is_resolved_by_the_least_driving(reference):
    problem = replace(table_iii(reference, (1, 2, 3, 4), 0.2), poses=[[-0.23, 0.55, np.deg2rad(50.0)]])
    answer = optimal_anchors(problem)
    assert answer.tension_factor[0] > 1.0 - 1e-6
    near = nearest_anchors(problem, answer)
    assert tension_factors(problem, near.offsets)[0] >= answer.tension_factor[0] - 1e-6
    assert near.driving[0] - near.least[0] <= 1e-4
    lengths = np.linalg.norm(problem.directions, axis=1)
    assert near.driving[0] == pytest.approx(np.abs(near.offsets[0]) @ lengths)
    assert near.driving[0] < 0.02
    again = nearest_anchors(problem, answer, start=near.offsets)
    assert again.driving[0] <= 1e-4


def test_a_platform_that_is_a_point_is_proved_infeasible_at_once(reference):
    problem = replace(table_iii(reference, (1, 2, 3, 4)), attachments=np.zeros((4, 2)))
    answer = optimal_anchors(problem)
    assert (answer.status == AnchorStatus.INFEASIBLE).all()
    assert (answer.boxes == 1).all()


@pytest.mark.parametrize("origin", [(0.1, 0.07), (-3.0, 0.02), (1e-3, 1e3)])
def test_the_origin_of_the_platform_does_not_matter(reference, origin):
    problem = table_iii(reference, (1, 2, 3, 4))
    answer = optimal_anchors(replace(problem, attachments=np.tile(origin, (4, 1))))
    assert (answer.status == AnchorStatus.INFEASIBLE).all()
    assert (answer.boxes == 1).all()
    few = replace(problem, poses=problem.poses[::10])
    turns = np.stack((np.cos(few.poses[:, 2]), np.sin(few.poses[:, 2]), -np.sin(few.poses[:, 2])), axis=1)
    poses, (x, y) = few.poses.copy(), np.array(origin) / max(1.0, np.abs(origin).max())
    poses[:, 0] -= turns[:, 0] * x + turns[:, 2] * y
    poses[:, 1] -= turns[:, 1] * x + turns[:, 0] * y
    moved = replace(few, attachments=few.attachments + (x, y), poses=poses)
    np.testing.assert_allclose(optimal_anchors(moved).value, optimal_anchors(few).value, atol=1e-8)
    np.testing.assert_array_equal(optimal_anchors(moved).status, optimal_anchors(few).status)


def test_an_anchor_whose_stay_passes_through_its_attachment(reference):
    problem = table_iii(reference, (1, 2, 3, 4), 0.1)
    pose = problem.poses[0].copy()
    turn = np.array([[np.cos(pose[2]), -np.sin(pose[2])], [np.sin(pose[2]), np.cos(pose[2])]])
    pose[:2] = problem.anchors[0] - turn @ problem.attachments[0]
    answer = optimal_anchors(replace(problem, poses=pose), most=3000)
    assert answer.value[0] <= answer.upper[0] <= 1.0


def test_a_cable_without_a_direction_is_no_candidate(rng):
    """Rounding would give it any direction, and the search would find the best one."""
    held = 0
    for _ in range(60):
        problem = through_an_attachment(rng, random_problem(rng, poses=1), rng.integers(4), rng.choice([0.0, 0.1]))
        answer = optimal_anchors(problem, gap=1e-6, most=20_000)
        assert answer.status[0] != AnchorStatus.EXHAUSTED
        assert answer.value[0] == pytest.approx(answer.tension_factor[0], abs=1e-9)
        shortest = planar_lengths(problem.placed(answer.offsets[0]), problem.attachments, problem.poses[0]).min()
        assert shortest > 1e-6 or answer.value[0] == 0.0
        tried = rng.uniform(problem.windows[:, 0], problem.windows[:, 1], (2000, 4))
        many = replace(problem, poses=np.repeat(problem.poses, len(tried), axis=0))
        assert tension_factors(many, tried).max() <= answer.upper[0]
        grid = algorithm_2(replace(problem, windows=np.round(problem.windows, 1)), 0.1)
        assert grid.value[0] == pytest.approx(grid.tension_factor[0], abs=1e-9)
        near = nearest_anchors(problem, answer, most=2000)
        assert tension_factors(problem, near.offsets)[0] >= answer.tension_factor[0] - 1e-6
        held += answer.value[0] > 0.0
    assert held > 5


def test_a_fixed_cable_without_a_direction_is_infeasible(reference):
    problem = table_iii(reference, ())
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    where = problem.anchors[0] - turn @ problem.attachments[0]
    problem = replace(problem, poses=[*where, np.arctan2(0.6, 0.8)])
    answer = optimal_anchors(problem)
    assert (answer.status[0], answer.value[0], answer.upper[0]) == (AnchorStatus.INFEASIBLE, 0.0, 0.0)
    assert np.isnan(algorithm_2(problem, 0.01).offsets).all()


def test_a_small_budget_is_admitted(reference):
    answer = optimal_anchors(table_iii(reference, (1, 2, 3, 4)), gap=1e-10, most=3)
    assert (answer.status == AnchorStatus.EXHAUSTED).any()
    assert (answer.upper >= optimal_anchors(table_iii(reference, (1, 2, 3, 4))).tension_factor).all()
    assert "boxes" in AnchorStatus.EXHAUSTED.advice


@pytest.mark.parametrize(
    ("given", "where"),
    [
        ({"gap": 0.0}, "gap"),
        ({"gap": float("nan")}, "gap"),
        ({"most": 0}, "most"),
        ({"most": 10**12}, "most"),
        ({"objective": "K"}, "objective"),
    ],
)
def test_impossible_questions_are_refused(reference, given, where):
    with pytest.raises(InputError, match=where):
        optimal_anchors(table_iii(reference, (1,)), **given)


def test_places_so_far_away_that_lengths_underflow_are_refused(reference):
    problem = table_iii(reference, (1,))
    wide = replace(problem, windows=[[0.0, 0.0], [0.0, 0.0], [-1e4, 1e4], [-1e200, 1e200]])
    for ask in (optimal_anchors, lambda question: algorithm_2(question, 1e199)):
        with pytest.raises(InputError, match=r"window of anchor 4: up to .* longest cable"):
            ask(wide)
    with pytest.raises(InputError, match=r"pose 1: .* from an anchor"):
        optimal_anchors(replace(problem, poses=[[0.0, 0.5, 0.0], [0.0, 1e300, 0.0]]))
    narrow = optimal_anchors(replace(problem, windows=np.clip(wide.windows, -0.05, 0.05)))
    wide = optimal_anchors(replace(wide, windows=np.clip(wide.windows, -1e4, 1e4)), most=500)
    assert (wide.upper >= narrow.tension_factor).all()


def test_the_nearest_take_only_an_optimum_of_the_same_problem(reference):
    problem = table_iii(reference, (1, 2, 3, 4))
    few = replace(problem, poses=problem.poses[:2])
    answer = optimal_anchors(few)
    wrong = {
        "2 poses, the problem has 51": (problem, answer),
        "not the tension factor": (few, optimal_anchors(few, objective="J~")),
        "outside the windows at pose 0": (replace(few, windows=0.1 * few.windows), answer),
        "other tension factors": (replace(few, poses=problem.poses[20:22]), answer),
    }
    for what, (question, optimum) in wrong.items():
        with pytest.raises(InputError, match=f"optimum: .*{what}"):
            nearest_anchors(question, optimum)
    for name, value in {"most": 0, "within": 0.0, "loss": -1.0, "start": np.zeros((3, 4))}.items():
        with pytest.raises(InputError, match=name):
            nearest_anchors(few, answer, **{name: value})
    assert nearest_anchors(few, answer, most=1).driving.shape == (2,)


def test_a_limit_is_worked_out_only_when_asked_for(reference, monkeypatch):
    problem = table_iii(reference, (1,))
    many = replace(problem, poses=np.repeat(problem.poses[44:45], 300, axis=0))
    solved = []

    def counted(question, **given):
        solved.append(len(question.poses))
        return optimal_anchors(question, **given)

    monkeypatch.setattr(limits_module, "optimal_anchors", counted)
    limits = binding_limits(many)
    assert (len(limits), solved) == (300, [300])
    assert "anchor" in limits[0].text
    assert 1 < len(solved) < 300
