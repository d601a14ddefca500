"""The figure after Fig. 15: panels, means, and that its axes hold every curve."""

from __future__ import annotations

from anchor_questions import table_iii

from steeplejack.design.anchors import optimal_anchors
from steeplejack.design.charts import anchors_figure, save_figure


def test_every_panel_names_its_anchors_and_holds_its_curves(reference, tmp_path):
    problem = table_iii(reference, (1, 2, 3, 4))
    figure = anchors_figure(problem)
    panels = [axes for axes in figure.axes if axes.get_title("left")]
    assert [axes.get_title("left") for axes in panels] == [
        "(a) anchor 1", "(b) anchors 1, 2", "(c) anchors 1, 2, 4", "(d) anchors 1, 2, 3, 4",
    ]  # fmt: skip
    assert "mean 0.254 to 0.525" in panels[3].get_title("right")
    best = optimal_anchors(problem).tension_factor.max()
    assert all(axes.get_ylim()[1] > best and axes.get_ylim()[0] == 0.0 for axes in panels)
    for name in ("a.svg", "b.svg"):
        save_figure(anchors_figure(problem, [(3,)]), tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
