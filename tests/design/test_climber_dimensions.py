"""Dimensions of the pipe climber: the chart against the reference and maps, the optimum, readings, the front."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from steeplejack.design.climber import (
    ORIGINAL,
    PAPER,
    PRESCRIBED,
    Comparison,
    Rectangle,
    design_plane,
    design_space,
    front,
    non_dominated,
    normalised,
    optimise,
    performance_chart,
    rate,
    rating,
    read,
    readings,
    transmission_map,
    workspace_cells,
)
from steeplejack.errors import InputError

pytestmark = pytest.mark.long

REFERENCE: dict[str, Any] = tomllib.loads(
    (Path(__file__).parents[1] / "reference" / "pipe_climber_design.toml").read_text()
)
ASKED = Comparison(Rectangle(*REFERENCE["dimensions"]["rectangle"]))


def test_reference_values() -> None:
    one = REFERENCE["dimensions"]
    assert rating(ORIGINAL, ASKED) == pytest.approx(one["original"], abs=5e-5)
    assert rating(PAPER, ASKED) == pytest.approx(one["paper"], abs=5e-5)
    chart = performance_chart(design_plane(0.01), ASKED)
    ratio, gti = chart.best()
    assert len(chart.ratios) == 96 * 96
    assert gti == pytest.approx(one["best"], abs=5e-5)
    assert ratio[2:] == pytest.approx((one["best_third"], one["best_fourth"]), abs=0.005)
    assert chart.share_above(rating(PAPER, ASKED)) > 0.25


@pytest.mark.parametrize("rectangle", [Rectangle(-0.06, 0.03, 0.1, 0.19), None])
@pytest.mark.parametrize("moving", ["platform", "base"])
def test_ratings_are_those_of_maps(rectangle: Rectangle | None, moving: Any) -> None:
    asked = Comparison(
        rectangle, (0.0, 0.3), 0.004, "sum", "equations", moving, "none" if rectangle else "home", (0.11, 0.25), 0.7
    )
    ratios = np.array([[1.0, 0.9, 0.6, 0.4], ORIGINAL, [1.0, 0.5, 0.2, 0.45]])
    found = rate(ratios, asked)
    for k, ratio in enumerate(ratios.tolist()):
        layout = asked.layout(tuple(ratio))
        assert sum(layout.lengths) == pytest.approx(0.350)
        maps = [transmission_map(layout, 0.004, alpha, rectangle, moving) for alpha in asked.alphas]
        values = np.concatenate([one.values[np.isfinite(one.values)] for one in maps])
        assert found.gti[k] == pytest.approx((values >= 0.5).mean(), abs=1e-12)
        assert found.mean[k] == pytest.approx(values.mean(), abs=1e-12)
        assert found.least[k] == pytest.approx(values.min(), abs=1e-12)
        if rectangle is None:
            assert found.area[k] == pytest.approx(workspace_cells(layout, asked.alphas, 0.004).sum() * 16e-6 / 2)


def test_the_design_space_holds_eq_33() -> None:
    space = normalised(design_space(0.95 / 11))
    assert len(space) == 12 * 12 * 13 // 2
    assert space.sum(axis=1) == pytest.approx(1.0)
    assert (space[:, 0] >= space[:, 2] - 1e-15).all()
    assert (space[:, 1] >= space[:, 3] - 1e-15).all()
    assert (space[:, 0] >= space[:, 1] - 1e-15).all()
    for step in (0.19, 0.0076, 0.07):  # the plane of a space is the chart of the same step
        whole = design_space(step)
        assert (whole[whole[:, 1] == 1.0] == design_plane(step)).all()
    assert design_plane(0.3)[-1] == pytest.approx([1.0, 1.0, 1.0, 1.0])  # also where the step does not divide
    assert (design_plane(0.05, 0.4)[:, 3] <= 0.4).all()


def test_the_continuous_optimum_is_no_worse_than_the_chart() -> None:
    found = optimise(ASKED, rng=np.random.default_rng(2), starts=2)
    assert found.gti >= REFERENCE["dimensions"]["best"] - 5e-5
    assert found.ratio[2:] == pytest.approx((1.0, 0.495), abs=0.01)
    assert found.spread < 1e-3
    assert found.gti_fine == pytest.approx(rating(found.ratio, replace(ASKED, step=0.0005)), abs=1e-12)


def test_the_reported_optimum_is_none_under_any_reading() -> None:
    asked = readings(0.005)
    assert len(asked) == len(set(asked)) == 64
    for one in asked:
        found = read(one, 0.1)
        assert found.best > found.paper + 0.1
        assert not found.paper_is_local


@pytest.mark.parametrize("neutral", ["none", "normal", "home"])
def test_exchanging_the_platforms_exchanges_l3_and_l4(neutral: Any) -> None:
    """Text, k = 1, parallel platforms: rated with the base moving a design is its mirror image with the platform."""
    ratios = design_plane(0.19)
    mirrored = ratios[:, [0, 1, 3, 2]]
    for rectangle in (PRESCRIBED, None):
        asked = Comparison(rectangle, step=0.002, neutral=neutral)
        here, there = rate(ratios, replace(asked, moving="base")), rate(mirrored, asked)
        assert here.mean == pytest.approx(there.mean, abs=1e-9)
        assert here.least == pytest.approx(there.least, abs=1e-9)
        assert here.area == pytest.approx(there.area)


def test_of_points_on_a_curve_none_beats_another() -> None:
    angle = np.linspace(0.0, 0.5 * math.pi, 50)
    curve = np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    inner = 0.9 * curve
    found = non_dominated(np.vstack((inner, curve, curve[:3])))
    assert found.tolist() == [False] * 50 + [True] * 53


def test_the_front_against_all_pairs() -> None:
    found = front(performance_chart(design_plane(0.1), Comparison(step=0.005)), 0.01)
    aims = np.stack((found.gti, found.area, found.distance, -found.size), axis=-1)
    beaten = (aims[:, None] <= aims).all(axis=-1) & (aims[:, None] < aims).any(axis=-1)
    assert (found.best == ~beaten.any(axis=-1)).all()
    assert 0 < found.best.sum() < len(found.best)


@pytest.mark.parametrize("ratios", [[[1.0, 1.0, 0.0, 0.5]], [[1.0, 1.0, math.nan, 0.5]], [1.0, 1.0, 0.5, 0.5]])
def test_ratios_that_are_none(ratios: Any) -> None:
    with pytest.raises(InputError, match="ratios"):
        rate(np.array(ratios), ASKED)


def test_questions_that_are_none() -> None:
    for step in (0.0, 1e-4, 0.96, math.nan):
        with pytest.raises(InputError, match="step"):
            design_plane(step)
    for k in (0.0, 1.1, math.nan):
        with pytest.raises(InputError, match="k: "):
            design_plane(0.1, k)
        with pytest.raises(InputError, match="k: "):
            optimise(ASKED, k)
    with pytest.raises(InputError, match="alphas"):
        Comparison(PRESCRIBED, ())
    with pytest.raises(InputError, match="step"):
        Comparison(None, step=0.1)
    for step in (0.001, 0.96, math.nan):
        with pytest.raises(InputError, match="step"):
            design_space(step)
