"""Figures of maps: they draw, they are reproducible, they say what they show."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from steeplejack.design import tension_map
from steeplejack.design.charts import map_figure, save_figure
from steeplejack.design.tension_map import Load

STAYS = {"1": (-1.0, 0.0), "2": (-0.65213, 0.66692)}


@pytest.fixture(scope="module")
def table(reference):
    return np.array(reference["table_iii"]["anchors"]), np.array(reference["table_iii"]["attachments"])


def words(figure):
    return " ".join(
        [text.get_text() for axes in figure.axes for text in axes.texts]
        + [axes.get_title(side) for axes in figure.axes for side in ("left", "right")]
        + [axes.get_ylabel() for axes in figure.axes]
    )


def test_one_orientation_names_stays_anchors_and_the_best_node(table):
    text = words(map_figure(tension_map(*table, np.deg2rad(50.0), 0.01), STAYS))
    for expected in ("stay 1", "stay 2", "φ = 50°", "1610 nodes", "best 0.977 at (-0.24, 0.56)", "tension factor [1]"):
        assert expected in text


def test_a_load_is_coloured_by_margin(table):
    load = Load(30.0, (10.0, 250.0), (0.0, -9.81))
    text = words(map_figure(tension_map(*table, np.deg2rad(50.0), 0.01, load), STAYS))
    assert "margin" in text
    assert "edge of wrench closure" in text


@pytest.mark.parametrize(("count", "panels"), [(1, 1), (2, 2), (7, 7), (13, 7), (40, 8)])
def test_a_range_shows_at_most_nine_panels(table, count, panels):
    figure = map_figure(tension_map(*table, np.deg2rad(np.linspace(44.0, 56.0, count)), 0.05))
    assert sum("φ" in axes.get_title("left") for axes in figure.axes if axes.get_visible()) == panels


def test_an_empty_map_says_so(table):
    assert "nothing inside" in words(map_figure(tension_map(*table, 0.0, 0.02)))


def test_files_are_reproducible(table, tmp_path):
    dataset = tension_map(*table, np.deg2rad(50.0), 0.02)
    for name in ("a.svg", "b.svg", "a.png"):
        save_figure(map_figure(dataset, STAYS), tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    with Image.open(tmp_path / "a.png") as image:
        assert min(image.size) > 1000
