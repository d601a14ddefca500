"""Figures of the pipe climber's design: each is drawn, says its numbers, and the same question gives the same file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from steeplejack.design.charts import save_figure
from steeplejack.design.charts.climber import (
    chart_figure,
    front_figure,
    orientation_figure,
    reach_figure,
    transmission_figure,
)
from steeplejack.design.charts.climber_space import space_figure
from steeplejack.design.climber import (
    Comparison,
    design_plane,
    design_space,
    front,
    orientations,
    performance_chart,
    transmission_map,
)
from steeplejack.robots.pipe_climber import Layout

pytestmark = pytest.mark.long

LAYOUT = Layout((0.100, 0.100, 0.075, 0.075), neutral="home")


def test_reach_says_the_exact_area(tmp_path: Path) -> None:
    for name in ("one.svg", "two.svg"):
        figure = reach_figure(LAYOUT, 0.0, orientations(LAYOUT, 0.01))
        assert figure.axes[0].get_title(loc="right") == "14,930 mm²"
        save_figure(figure, tmp_path / name)
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()


def test_sections_have_a_panel_each() -> None:
    figure = orientation_figure({"home": LAYOUT, "none": replace(LAYOUT, neutral="none")}, 0.16, 31)
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["home", "none"]
    assert all(axes.collections[0].get_paths() for axes in figure.axes)


def test_maps_share_one_scale() -> None:
    figure = transmission_figure({f"{k}": transmission_map(LAYOUT, 0.01, 0.1 * k) for k in range(5)})
    limits = {axes.collections[0].get_clim() for axes in figure.axes[:5]}
    assert len(limits) == 1
    assert "GTI" in figure.axes[0].get_xlabel()


def test_a_chart_marks_three_designs() -> None:
    figure = chart_figure(performance_chart(design_plane(0.19), Comparison(step=0.01)))
    assert figure.legends[0].get_texts()[1].get_text() == "reported optimum"
    assert "best" in figure.axes[0].get_title(loc="left")


def test_the_space_has_its_nine_edges_and_marks_three_designs() -> None:
    figure = space_figure(performance_chart(design_space(0.19), Comparison(step=0.01)))
    space, flat = figure.axes[:2]
    assert len(space.lines) == 9
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["original", "reported optimum", "best"]
    assert all((line.get_xdata() <= 1.0).all() for line in flat.lines)


def test_a_front(tmp_path: Path) -> None:
    found = front(performance_chart(design_plane(0.19), Comparison(step=0.01)), 0.02)
    save_figure(front_figure(found), tmp_path / "front.png")
    assert (tmp_path / "front.png").stat().st_size > 10_000
