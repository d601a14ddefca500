"""The parameter design space of the pipe climber in three dimensions (Ye et al., Robotica 2024, Fig. 13 and 14)."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from steeplejack.design.charts.climber import NAMES, WARM
from steeplejack.design.charts.style import INK, PAPER, STYLE
from steeplejack.design.climber.dimensions import ORIGINAL, Chart, Index, normalised
from steeplejack.design.climber.dimensions import PAPER as REPORTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

POINTS = 4000  # drawn of a chart
CORNERS = ((1, 0, 0, 0), (1, 0, 1, 0), (1, 1, 0, 0), (1, 1, 1, 0), (1, 1, 0, 1), (1, 1, 1, 1))
"""Ratios at the corners of the space that ``r1 >= r3``, ``r2 >= r4``, ``r1 >= r2`` and r of at least 0 enclose."""


def space_figure(chart: Chart, index: Index = "gti") -> Figure:
    """The whole design space, coloured by an index, and what its planes of fixed k = L2 / L1 come to.

    Args:
        chart: Over `design_space`.
        index: What is drawn.

    Returns:
        The figure; axes are the normalised parameters r1, r2, r3 of Eq. 32, the plane k = 1 is outlined.
    """
    best, value = chart.best(index)
    with matplotlib.rc_context(rc=STYLE):
        figure = Figure(figsize=(9.6, 4.4), layout="constrained")
        FigureCanvasAgg(figure)
        space: Any = figure.add_subplot(1, 2, 1, projection="3d")
        flat = figure.add_subplot(1, 2, 2)
        values = chart.values(index)
        drawn = np.flatnonzero(np.isfinite(values))[:: max(1, len(values) // POINTS)]
        points = normalised(chart.ratios[drawn])
        colours = space.scatter(
            *points[:, :3].T, c=values[drawn], s=5, cmap="viridis", vmin=0.0, linewidth=0, depthshade=False
        )
        _edges(space)
        for name, ratio, marker in (
            ("original", ORIGINAL, "s"),
            ("reported optimum", REPORTED, "^"),
            ("best", best, "*"),
        ):
            place = normalised(ratio)
            size = 140 if marker == "*" else 50
            space.scatter(*place[:3], marker=marker, s=size, color=WARM, edgecolor=PAPER, label=name, depthshade=False)
        space.set(xlabel="r1", ylabel="r2", zlabel="r3", xlim=(0.2, 1.0), ylim=(0.0, 0.5), zlim=(0.0, 0.5))
        space.set_box_aspect((0.8, 0.5, 0.5))
        space.computed_zorder = False  # the marks stay in front
        space.view_init(elev=24.0, azim=118.0)
        space.set_title(
            f"best {value:.4f} at L2/L1, L3/L1, L4/L1 = {best[1]:.3g}, {best[2]:.3g}, {best[3]:.3g}", fontsize=9
        )
        bar = figure.colorbar(colours, ax=space, shrink=0.75, aspect=28, pad=0.12, label=NAMES[index])
        bar.outline.set_visible(False)
        _planes(flat, chart, values)
        flat.set_ylabel(NAMES[index])
        handles, labels = space.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    return figure


def _edges(space: Any) -> None:
    """Edges of the space: corners are neighbours where two of the five conditions hold as equations at both."""
    corners = np.array(CORNERS, dtype=np.float64)
    r1, r2, r3, r4 = corners.T
    held = np.stack((r1 == r3, r2 == r4, r1 == r2, r3 == 0.0, r4 == 0.0), axis=-1)
    places = normalised(corners)[:, :3]
    for one, other in combinations(range(len(corners)), 2):
        if (held[one] & held[other]).sum() == 2:
            on_plane = bool(held[one, 2] and held[other, 2])
            line = np.stack((places[one], places[other]), axis=-1)
            space.plot(*line, color=WARM if on_plane else INK, linewidth=1.6 if on_plane else 0.8)


def _planes(axes: Axes, chart: Chart, values: Array) -> None:
    """Median, best tenth and best value in each plane of fixed k."""
    k, plane = np.unique(chart.ratios[:, 1], return_inverse=True)
    rows = [values[(plane == number) & np.isfinite(values)] for number in range(k.size)]
    shares = np.array([np.quantile(row, (0.5, 0.9, 1.0)) if row.size else np.full(3, np.nan) for row in rows])
    for share, name, width in zip(shares.T, ("median", "best tenth", "best"), (1.0, 1.0, 2.2), strict=True):
        axes.plot(k, share, color=INK, linewidth=width)
        axes.annotate(name, (k[-1], share[-1]), (4, 0), textcoords="offset points", fontsize=8, va="center")
    axes.set(xlabel="k = L2 / L1", xlim=(0.0, 1.18), ylim=(0.0, None))
    axes.grid(color="#e6eaed", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
