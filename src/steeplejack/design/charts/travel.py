"""Figures of anchors along a path: what the places are worth, where the bases stand, and the price of driving."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from steeplejack.design.anchors.along import AnchorPath, anchor_path
from steeplejack.design.anchors.problem import Reconfiguration
from steeplejack.design.anchors.worth import Duty, Objective
from steeplejack.design.charts.style import INK, ROPE, STEEL, STYLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BASES = ("#0b6e99", "#c4541a", "#2c7a3f", "#7b4397")
MARKS = ("o", "s", "^", "D")
NAMES = {"tension-factor": "tension factor [1]", "slip-margin": "slip margin [1]"}


def path_figure(problem: Reconfiguration, path: AnchorPath, objective: Objective = "tension-factor") -> Figure:
    """Draw a path of configurations: the objective at every pose, and where each base stands.

    Args:
        problem: Anchors, platform and path.
        path: Configurations.
        objective: What the values of the path are.

    Returns:
        The figure; with the tension factor also that of the anchors left where they are.
    """
    poses = np.arange(1, len(path.value) + 1)
    with matplotlib.rc_context(rc=STYLE):
        figure = Figure(figsize=(7.6, 5.4), layout="constrained")
        FigureCanvasAgg(figure)
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1.0, 1.0])
        if objective == "tension-factor":
            fixed = anchor_path(problem, np.zeros_like(path.offsets), Duty())
            _line(top, poses, np.where(fixed.held, fixed.value, np.nan), STEEL, f"anchors left, mean {fixed.mean:.3f}")
        label = f"anchors moved, mean {path.mean:.3f}, {path.travel:.2f} m driven"
        _line(top, poses, np.where(path.held, path.value, np.nan), INK, label)
        _where_not_held(top, poses, path)
        top.set(ylabel=NAMES[objective], ylim=(min(0.0, float(path.value.min())), None))
        top.legend(frameon=False, loc="lower left")
        for base, (colour, mark) in enumerate(zip(BASES, MARKS, strict=True)):
            bottom.plot(
                poses, 100.0 * path.offsets[:, base], color=colour, marker=mark, markersize=3.5, linewidth=1.2,
                drawstyle="steps-mid", label=f"base {base + 1}",
            )  # fmt: skip
        bottom.set(xlabel="pose", ylabel="offset along x [cm]", xlim=(0.5, len(poses) + 0.5))
        bottom.legend(frameon=False, ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0))
        for axes in (top, bottom):
            _frame(axes)
    return figure


def trade_off_figure(paths: Sequence[AnchorPath], pointwise: float | None = None) -> Figure:
    """Draw what driving buys: the mean objective against the metres driven, a point a price.

    Args:
        paths: From `steeplejack.design.anchors.trade_off`.
        pointwise: Certified optimum pose by pose, drawn as the bound it is [1].

    Returns:
        The figure.
    """
    travel, mean = np.array([path.travel for path in paths]), np.array([path.mean for path in paths])
    order = np.argsort(travel)
    with matplotlib.rc_context(rc=STYLE):
        figure = Figure(figsize=(7.0, 4.4), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots()
        if pointwise is not None:
            axes.axhline(pointwise, color=STEEL, linestyle="dashed", linewidth=1.0)
            place = axes.get_yaxis_transform()
            axes.text(0.01, pointwise, "best pose by pose", transform=place, color=ROPE, fontsize=8, va="bottom")
        axes.plot(100.0 * travel[order], mean[order], "o-", color=INK, markersize=4.5, linewidth=1.0)
        shown = {round(path.travel, 6): path for path in reversed(paths)}  # the lowest price of equal paths
        for index, path in enumerate(sorted(shown.values(), key=lambda one: one.travel)):
            side, above = ("right", 6) if index % 2 else ("left", -12)
            place = (100.0 * path.travel, path.mean)
            axes.annotate(f"{path.price:.3g} /m", place, (4 if side == "left" else -4, above), color=ROPE, fontsize=7,
                          textcoords="offset points", ha=side)  # fmt: skip
        axes.set(xlabel="driven by all bases together [cm]", ylabel="mean over the path [1]")
        axes.margins(0.08, 0.18)
        _frame(axes)
    return figure


def _line(axes: Axes, poses: np.ndarray, values: np.ndarray, colour: str, label: str) -> None:
    axes.plot(poses, values, color=colour, linewidth=1.6, marker=".", markersize=4, label=label)


def _where_not_held(axes: Axes, poses: np.ndarray, path: AnchorPath) -> None:
    """Shade poses nothing holds."""
    for pose in poses[~path.held]:
        axes.axvspan(pose - 0.5, pose + 0.5, color="#f3d9d3", linewidth=0.0, zorder=0)


def _frame(axes: Axes) -> None:
    axes.grid(color="#e6eaed", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
