"""Algorithm 1 against a literal transcription of its pseudo-code, and its ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from grasp_questions import GRASP, random_question, track_question

from steeplejack.design.grasps import GraspQuestion, GraspRegion, grasp_on_grid
from steeplejack.errors import InfeasibleError, InputError


def literal(question: GraspQuestion, step: float, kappa: float) -> tuple[np.ndarray, float] | None:
    """The nearest distance and the node of the pseudo-code, line by line; None where C is empty."""
    region = question.region
    reach = int(np.ceil((np.abs(region.point).max() + region.half_length + region.half_width) / step)) + 1
    ticks = step * np.arange(-reach, reach + 1)
    nodes = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    within = np.abs(region.coordinates(nodes)) <= np.array([region.half_length, region.half_width]) + 1e-9 * step
    nodes = nodes[within.all(axis=1)]
    factors = question.tension_factor(nodes)
    nodes, factors = nodes[factors > 0.0], factors[factors > 0.0]
    if not len(nodes):
        return None
    threshold = 1.0
    while True:
        threshold -= kappa
        chosen = np.flatnonzero(factors >= threshold)
        if chosen.size:
            distances = region.distance(nodes[chosen])
            return nodes[chosen[np.argmin(distances)]], float(distances.min())


def test_the_reference(reference):
    given = GRASP["algorithm_1"]
    found = grasp_on_grid(track_question(reference), given["step"], given["kappa"])
    np.testing.assert_allclose(found.position, given["position"], atol=1e-12)
    assert found.tension_factor == pytest.approx(given["factor"], abs=5e-7)
    assert found.evaluations == 29
    assert found.gap is None


@pytest.mark.parametrize("kappa", [0.003, 0.01, 0.07, 0.3, 5.0])
@pytest.mark.parametrize("step", [0.01, 0.004])
def test_the_pseudo_code(reference, step, kappa):
    question = track_question(reference, 2.0)
    node, distance = literal(question, step, kappa)
    found = grasp_on_grid(question, step, kappa)
    assert found.distance == pytest.approx(distance, abs=1e-12)
    np.testing.assert_allclose(found.position, node, atol=1e-12)


def test_the_pseudo_code_on_random_robots(rng):
    held = 0
    for _ in range(90):
        question, kappa = random_question(rng), rng.uniform(0.02, 0.2)
        expected = literal(question, 0.05, kappa)
        if expected is None:
            with pytest.raises(InfeasibleError):
                grasp_on_grid(question, 0.05, kappa)
            continue
        held += 1
        assert grasp_on_grid(question, 0.05, kappa).distance == pytest.approx(expected[1], abs=1e-12)
    assert held > 12


def test_a_threshold_that_hardly_falls_gives_the_largest_factor(reference):
    """Also where its steps could not be counted one by one."""
    question = track_question(reference)
    best = grasp_on_grid(question, 0.001, 1e-15)
    assert best.tension_factor == grasp_on_grid(question, 0.001, 1e-320).tension_factor
    assert best.tension_factor >= grasp_on_grid(question, 0.001, 0.2).tension_factor
    assert best.distance > grasp_on_grid(question, 0.001, 0.2).distance


def test_what_rules_a_grasp_out_is_named(reference):
    question = track_question(reference)
    with pytest.raises(InfeasibleError, match="no node of the grid of 0.5 m"):
        grasp_on_grid(question, 0.5, 0.1)
    away = replace(question, region=GraspRegion((3.0, 3.0), (1.0, -1.0), 0.05, 0.05))
    with pytest.raises(InfeasibleError, match="none of the .* nodes in the region is in wrench closure"):
        grasp_on_grid(away, 0.01, 0.1)


@pytest.mark.parametrize(("step", "kappa", "where"), [
    (0.0, 0.1, "step"), (np.nan, 0.1, "step"), (-0.1, 0.1, "step"), (1e-7, 0.1, "step"), (1e-320, 0.1, "step"),
    (0.01, 0.0, "kappa"), (0.01, -0.1, "kappa"), (0.01, np.nan, "kappa"), (0.01, np.inf, "kappa"),
])  # fmt: skip
def test_bad_steps_are_refused(reference, step, kappa, where):
    with pytest.raises(InputError) as error:
        grasp_on_grid(track_question(reference), step, kappa)
    assert error.value.where == where
