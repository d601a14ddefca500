"""Desired against actual trajectory and the statistics of its errors, in the form of Fig. 18-19 of the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D

from steeplejack.report.accuracy import AXES, Accuracy
from steeplejack.report.analysis import Spread
from steeplejack.report.figures.style import (
    BLUE,
    INK,
    MUTED,
    ORANGE,
    STEEL,
    VERMILION,
    Array,
    canvas,
    middle_stay,
    spells,
    svg,
    thin,
)
from steeplejack.report.log import Log
from steeplejack.report.notation import spread

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NARROW = 1.0 / 12.0  # [1] width over length of a drawing below which both directions have scales of their own
LEAST_HALF_WIDTH = 0.05  # [m] drawn to either side: errors of a centimetre show, those of a millimetre do not jump
# Mean and standard deviation [mm] of the paper's zigzag test on a replica (Section VI-C, Fig. 19): its X and Y.
PAPER = {"along": (1.4, 9.0), "across": (-3.9, 10.4)}


def path_figure(log: Log) -> str:
    """The planned zigzag and the one flown, unrolled: along the stays by across them (Fig. 18)."""
    states = log.states
    stay = middle_stay(log)
    flown = ~states.stopped & (states.base_moving == 0)
    with canvas(3.1) as figure:
        axes = figure.add_subplot()
        for k in log.bay.interior:
            s = np.linspace(max(0.0, log.mission.request.from_m - 2.0), log.mission.request.to_m + 2.0, 30)
            along, across = _unrolled(log, log.bay.stays[k].position(s))
            axes.plot(along, across, color=STEEL, lw=5.0, alpha=0.35)
            axes.text(along[-1], across[-1], f"  {log.bay.stays[k].id}", fontsize=8.0, color=MUTED, va="center")
        for positions, colour, width in (
            (states.desired_position, ORANGE, 2.6),
            (states.actual_position, BLUE, 0.9),
        ):
            for first, last in spells(flown):
                step = max(1, (last - first) // 1500)
                axes.plot(*_unrolled(log, positions[first : last + 1 : step]), color=colour, lw=width)
        axes.margins(x=0.08)
        axes.set_xlabel(f"along the stays [m], from the lower anchorage of {stay.id}")
        axes.set_ylabel("across [m]" if _to_scale(axes) else "across [m], to a larger scale")
        handles = [
            Line2D([], [], color=ORANGE, lw=2.6, label="desired"),
            Line2D([], [], color=BLUE, lw=0.9, label="actual"),
            Line2D([], [], color=STEEL, lw=5.0, alpha=0.35, label="interior stays"),
        ]
        figure.legend(handles=handles, loc="outside upper right", ncols=3)
        return svg(figure, "path")


def _to_scale(axes: Axes) -> bool:
    """One scale for both directions, unless the bay is too narrow for its length to be told from a line."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    if high - low >= NARROW * (right - left):
        axes.set_aspect("equal")
        return True
    middle, half = 0.5 * (low + high), max(0.5 * (high - low), LEAST_HALF_WIDTH)
    axes.set_ylim(middle - half, middle + half)
    return False


def _unrolled(log: Log, positions: Array) -> tuple[Array, Array]:
    """Places along and across the middle stay (n,) [m] of world positions (n, 3)."""
    stay, k = middle_stay(log), float(len(log.bay.stays) // 2)
    s, _distance = stay.nearest(positions)
    across = np.cross(log.bay.normal(np.full(len(s), k), s), stay.tangent(s))
    return s, np.sum((positions - stay.position(s)) * across, axis=1) / np.linalg.norm(across, axis=1)


def accuracy_figure(log: Log, accuracy: Accuracy) -> str:
    """Relative errors along, across and off the inspected stay over the distance inspected, and their histograms."""
    errors = 1e3 * accuracy.relative
    with canvas(6.2) as figure:
        grid = figure.subplots(3, 2, sharex="col", sharey="row", width_ratios=(3.6, 1.0), squeeze=False)
        for i, name in enumerate(AXES):
            _strip(grid[i, 0], accuracy, errors[:, i], name)
            _histogram(grid[i, 1], errors[:, i], name)
        most = max(bar.get_width() for axes in grid[:, 1] for bar in axes.patches)
        grid[2, 1].set_xlim(0.0, 1.4 * most)
        grid[2, 0].set_xlabel("distance inspected [m]")
        grid[2, 1].set_xlabel("share of samples [%]")
        _name_stays(grid[0, 0], log, accuracy)
        return svg(figure, "accuracy")


def _strip(axes: Axes, accuracy: Accuracy, error: Array, name: str) -> None:
    mean, std = float(np.mean(error)), float(np.std(error))
    axes.axhspan(mean - std, mean + std, color=BLUE, alpha=0.10, lw=0.0)
    axes.axhline(mean, color=INK, lw=0.8)
    axes.plot(*thin(accuracy.travel, error), color=BLUE, lw=0.6)
    axes.set_ylabel(f"{name} [mm]")
    axes.text(
        0.995, 0.97, spread(Spread(mean, std)) + " mm", transform=axes.transAxes, ha="right", va="top", weight="bold"
    )
    paper_mean, paper_std = PAPER.get(name, (0.0, 0.0))
    reach = 1.15 * max(1.0, float(np.max(np.abs(error))), abs(paper_mean) + paper_std)
    axes.set_ylim(-reach, reach)


def _histogram(axes: Axes, error: Array, name: str) -> None:
    low, high = axes.get_ylim()
    weights = np.full(len(error), 100.0 / len(error))
    axes.hist(
        error,
        bins=np.linspace(low, high, 41).tolist(),
        weights=weights,
        orientation="horizontal",
        color=BLUE,
        alpha=0.55,
    )
    _whisker(axes, 0.84, float(error.mean()), float(error.std()), BLUE)
    if name in PAPER:
        _whisker(axes, 0.94, *PAPER[name], VERMILION)
    if name == AXES[0]:
        handles = [
            Line2D([], [], color=BLUE, marker="o", ms=4, label="this run"),
            Line2D([], [], color=VERMILION, marker="o", ms=4, label="paper"),
        ]
        axes.legend(
            handles=handles, loc="lower right", bbox_to_anchor=(1.02, 1.0), ncols=2, handlelength=1.2, borderaxespad=0.0
        )


def _whisker(axes: Axes, x: float, mean: float, std: float, colour: str) -> None:
    """Mean and standard deviation at a share of the width."""
    place = axes.get_yaxis_transform()
    axes.errorbar(x, mean, yerr=std, color=colour, marker="o", ms=4, capsize=3, lw=1.4, transform=place)


def _name_stays(axes: Axes, log: Log, accuracy: Accuracy) -> None:
    """Which stay was inspected over which stretch of the axis, above it."""
    flown = log.states.leg[accuracy.sample]
    for leg in np.unique(flown):
        travel = accuracy.travel[flown == leg]
        name = log.mission.legs[leg].stay or ""
        axes.text(0.5 * (travel[0] + travel[-1]), 1.02, name, transform=axes.get_xaxis_transform(),
                  ha="center", va="bottom", fontsize=6.5, color=MUTED)  # fmt: skip
        axes.axvline(travel[0], color=STEEL, lw=0.5, ls=":")
