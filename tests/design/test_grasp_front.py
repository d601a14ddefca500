"""The front of tension factor against distance: point by point the exact optimum, monotone, in any order."""

from __future__ import annotations

import numpy as np
import pytest
from grasp_questions import random_question, track_question

from steeplejack.design.charts import grasp_figure, save_figure
from steeplejack.design.grasps import GraspRegion, best_grasp, grasp_front
from steeplejack.errors import InfeasibleError, InputError

pytestmark = pytest.mark.long


def test_every_point_is_the_exact_optimum_within_its_distance(reference):
    question = track_question(reference)
    distances = np.linspace(0.0, 0.06, 13)
    front = grasp_front(question, distances)
    for k, distance in enumerate(distances):
        alone = best_grasp(question.within(float(distance)))
        assert front.tension_factor[k] == pytest.approx(alone.tension_factor, abs=2e-8)
        assert question.region.distance(front.positions[k]) <= distance + 1e-12
    at = question.tension_factor(front.positions)
    np.testing.assert_allclose(at, front.tension_factor, atol=1e-12)
    assert (np.diff(front.tension_factor) > 0.0).all()
    assert (front.gap <= 1e-8 * (1.0 + 1e-6)).all()


def test_random_fronts_never_fall_and_take_any_order(rng):
    for _ in range(40):
        question = random_question(rng)
        distances = rng.permutation(np.append(rng.uniform(0.0, question.region.half_width, 6), 0.0))
        front = grasp_front(question, distances)
        order = np.argsort(distances)
        assert (np.diff(front.tension_factor[order]) >= 0.0).all()
        np.testing.assert_array_equal(np.isnan(front.positions[:, 0]), front.tension_factor == 0.0)
        last = question.within(float(distances.max()))
        try:
            best = best_grasp(last).tension_factor
        except InfeasibleError:
            best = 0.0
        assert front.tension_factor.max() == pytest.approx(best, abs=1e-6)


def test_equal_distances_have_equal_answers(reference):
    front = grasp_front(track_question(reference), [0.02, 0.01, 0.02])
    assert front.tension_factor[0] == front.tension_factor[2]
    np.testing.assert_array_equal(front.positions[0], front.positions[2])


@pytest.mark.parametrize("distances", [[], [-0.1, 0.1], [np.nan], 0.1])
def test_bad_distances_are_refused(reference, distances):
    with pytest.raises(InputError, match="distances"):
        grasp_front(track_question(reference), distances)


def test_the_figure_says_what_it_shows(reference, tmp_path):
    question = track_question(reference)
    front = grasp_front(question, np.linspace(0.0, 0.03, 7))
    for name in ("a.svg", "b.svg"):
        figure = grasp_figure(question, best_grasp(question), front, {"3": (-0.8693, 0.254493), "flat": (0.0, 0.5)})
        save_figure(figure, tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    bands, trade = figure.axes
    legend = bands.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == [
        "0.85 to 1", "0.725 to 0.85", "0.6 to 0.725", "0.45 to 0.6", "below 0.45",
    ]  # fmt: skip
    assert "TF 0.5465 at (-0.0947, 0.3668) m" in bands.get_title("right")
    assert {"stay 3", "stay flat"} <= {text.get_text() for text in bands.texts}
    assert trade.get_xlabel() == "greatest distance from the axis [mm]"


def test_a_figure_without_a_front_to_draw(reference):
    question = track_question(reference)
    nowhere = grasp_front(question.within(0.0), [0.0])
    empty = type(nowhere)(nowhere.distances, np.zeros(1), np.full((1, 2), np.nan), nowhere.gap, 1)
    assert grasp_figure(question, best_grasp(question), empty).axes
    assert GraspRegion((0.0, 0.0), (1.0, 0.0), 0.0, 0.0).corners.shape == (4, 2)
