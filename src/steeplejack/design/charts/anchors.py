"""Figure of anchor reconfiguration, after Fig. 15: tension factor along a path, anchors fixed against optimised."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from steeplejack.design.anchors import Reconfiguration, optimal_anchors, tension_factors
from steeplejack.design.charts.style import ROPE, STEEL, STYLE

SUBSETS = ((1,), (1, 2), (1, 2, 4), (1, 2, 3, 4))
GAIN, BEST, PAPER = "#9ad0c2", "#1f7a68", "#c8553d"


def anchors_figure(problem: Reconfiguration, subsets: Sequence[Sequence[int]] = SUBSETS) -> Figure:
    """Tension factor at each pose with the anchors where they stand, optimised, and optimised for J~ as printed.

    Args:
        problem: Anchors, platform, windows and path; poses are numbered from 0.
        subsets: Movable anchors of each panel, numbered from 1; the windows of the others are taken away.

    Returns:
        The figure, a panel a subset.
    """
    steps = np.arange(len(problem.poses))
    fixed = tension_factors(problem, np.zeros(4))
    rows = -(-len(subsets) // 2)
    with matplotlib.rc_context(rc=STYLE):
        figure = Figure(figsize=(9.0, 0.6 + 2.7 * rows), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.subplots(rows, 2, sharex=True, sharey=True, squeeze=False)
        for index, (axes, subset) in enumerate(zip(grid.flat, subsets, strict=False)):
            movable = np.isin(np.arange(1, 5), subset)
            chosen = replace(problem, windows=np.where(movable[:, None], problem.windows, 0.0))
            best = optimal_anchors(chosen).tension_factor
            printed = optimal_anchors(chosen, objective="J~").tension_factor
            axes.fill_between(steps, fixed, best, color=GAIN, alpha=0.5, linewidth=0.0)
            axes.plot(steps, fixed, color=STEEL, linewidth=1.6, label="fixed")
            axes.plot(steps, printed, color=PAPER, linewidth=1.0, linestyle="dashed", label="Eq. 24 as printed (J~)")
            axes.plot(steps, best, color=BEST, linewidth=1.8, label="optimised")
            names = "anchor " if len(subset) == 1 else "anchors "
            axes.set_title(f"({chr(97 + index)}) {names}{', '.join(map(str, subset))}", loc="left", fontweight="bold")
            means = f"mean {fixed.mean():.3f} to {best.mean():.3f}, as printed {printed.mean():.3f}"
            axes.set_title(means, loc="right", fontsize=8, color=ROPE)
            axes.set(xlim=(steps[0], max(steps[-1], 1)))
            axes.grid(color="#e6eaed", linewidth=0.6)
            axes.spines[["top", "right"]].set_visible(False)
        for axes in grid.flat[len(subsets) :]:
            axes.set_visible(False)
        for axes in grid[:, 0]:
            axes.set_ylim(bottom=0.0)
            axes.set_ylabel("tension factor [1]")
        for axes in grid[-1]:
            axes.set_xlabel("pose along the path")
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure
