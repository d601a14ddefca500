"""Algorithm 2: published means, a plain transcription, Eq. 24 as printed, and what the difference costs."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from anchor_questions import random_problem, table_iii

from steeplejack.design.anchors import algorithm_2, optimal_anchors, tension_factors
from steeplejack.errors import InputError
from steeplejack.mechanics.cable import planar_structure_matrix


@pytest.mark.parametrize(
    ("movable", "mean"), [((), 0.253634), ((1,), 0.294374), ((1, 2, 3, 4), 0.517095)], ids=["fixed", "one", "all"]
)
def test_the_means_of_the_design_notes(reference, movable, mean):
    answer = algorithm_2(table_iii(reference, movable), 0.01)
    assert answer.tension_factor.mean() == pytest.approx(mean, abs=1e-6)
    assert answer.configurations == 11 ** len(movable)


@pytest.mark.parametrize("objective", ["J", "J~"])
def test_a_plain_search_agrees(rng, objective):
    for _ in range(5):
        problem = random_problem(rng, poses=2)
        problem = replace(problem, windows=np.sort(np.round(problem.windows, 1)))
        answer = algorithm_2(problem, 0.1, objective)
        for k, pose in enumerate(problem.poses):
            best = 0.0
            axes = [np.arange(round(low * 10), round(high * 10) + 1) * 0.1 for low, high in problem.windows]
            for offsets in product(*axes):
                structure = planar_structure_matrix(problem.placed(offsets), problem.attachments, pose)
                null = np.linalg.svd(structure)[2][-1]
                if objective == "J~":
                    arm = problem.placed(offsets) - pose[:2]
                    turn = np.array([[np.cos(pose[2]), -np.sin(pose[2])], [np.sin(pose[2]), np.cos(pose[2])]])
                    null = null / np.linalg.norm(arm - problem.attachments @ turn.T, axis=1)
                null = null * np.sign(null.sum())
                best = max(best, null.min() / null.max())
            assert answer.value[k] == pytest.approx(best, abs=1e-9)
            if best > 0.0:
                assert answer.tension_factor[k] == pytest.approx(tension_factors(problem, answer.offsets)[k], abs=1e-12)


def test_poses_without_any_closure_are_infeasible_and_not_an_error(reference):
    answer = algorithm_2(table_iii(reference, (1,)), 0.01)
    out = answer.tension_factor == 0.0
    np.testing.assert_array_equal(np.flatnonzero(out), np.arange(44, 51))
    assert np.isnan(answer.offsets[out]).all()


def test_eq_24_as_printed_loses_a_quarter_and_is_a_linear_program(reference):
    problem = table_iii(reference, (1, 2, 3, 4))
    grid, printed = algorithm_2(problem, 0.01), algorithm_2(problem, 0.01, "J~")
    assert 0.22 < 1.0 - printed.tension_factor.mean() / grid.tension_factor.mean() < 0.28
    exact = optimal_anchors(problem, objective="J~")
    assert (exact.boxes == 1).all()
    assert (exact.value >= printed.value - 1e-12).all()
    fixed = tension_factors(problem, np.zeros(4)).mean()
    for movable in ((1,), (1, 2)):
        assert algorithm_2(table_iii(reference, movable), 0.01, "J~").tension_factor.mean() < fixed


@pytest.mark.parametrize(("step", "where"), [(0.0, "step"), (float("nan"), "step"), (0.3, "window of anchor 2")])
def test_steps_that_make_no_grid_are_refused(reference, step, where):
    problem = table_iii(reference, (1,))
    windows = problem.windows.copy()
    windows[1] = (0.01, 0.02)
    with pytest.raises(InputError, match=where):
        algorithm_2(replace(problem, windows=windows), step)


@pytest.mark.parametrize(
    ("step", "windows", "what"),
    [
        (1e-7, [0.5, 0.5, 0.5, 0.5], "of anchor 1"),
        (1e-300, [0.5, 0.0, 0.0, 0.0], "of anchor 1"),
        (5e-4, [0.5, 0.5, 0.5, 0.5], r"1.6e\+13 combinations at 51 poses"),
        (5e-4, [0.0, 0.0, 0.5, 0.5], "pairs of anchors 3 and 4"),
    ],
)
def test_a_grid_that_nobody_waits_for_is_refused(reference, step, windows, what):
    problem = replace(table_iii(reference, ()), windows=np.outer(windows, [-1.0, 1.0]))
    with pytest.raises(InputError, match=f"^step: .*{what}"):
        algorithm_2(problem, step)
