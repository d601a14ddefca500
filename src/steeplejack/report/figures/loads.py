"""Loads over the run: cable tensions, pull margins of the bases, tension factor."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patches import Patch

from steeplejack.report.analysis import ACTIVITIES, Analysis
from steeplejack.report.figures.style import (
    ACTIVITY,
    CABLES,
    INK,
    MUTED,
    VERMILION,
    bare,
    canvas,
    spells,
    svg,
    thin,
)
from steeplejack.report.log import Log

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def loads_figure(log: Log, analysis: Analysis) -> str:
    """What the squad was doing, four tensions and their window, four pull margins, the tension factor."""
    with canvas(7.0) as figure:
        strip, tension, margin, factor = figure.subplots(4, 1, sharex=True, height_ratios=(0.22, 2.2, 1.8, 1.2))
        _strip(strip, log, analysis)
        _tensions(tension, log)
        _margins(margin, log)
        time, values = thin(log.states.time / 60.0, log.states.tension_factor)
        factor.plot(time, values, color=INK, lw=0.8)
        factor.set(ylim=(0.0, 1.0), xlabel="time [min]", ylabel="[1]")
        factor.set_title("tension factor: least over largest tension in the plane of the cables without load")
        used = np.flatnonzero(analysis.time_by_activity > 0.0)
        handles = [Patch(color=ACTIVITY[i], label=ACTIVITIES[i]) for i in used]
        figure.legend(handles=handles, loc="outside upper left", ncols=3)
        return svg(figure, "loads")


def _strip(axes: Axes, log: Log, analysis: Analysis) -> None:
    time = log.states.time / 60.0
    for kind, colour in enumerate(ACTIVITY):
        for first, last in spells(analysis.activity == kind):
            axes.axvspan(time[first], time[min(last + 1, len(time) - 1)], color=colour, lw=0.0)
    bare(axes)
    axes.set_xlim(time[0], time[-1] if time[-1] > time[0] else time[0] + 1.0)


def _tensions(axes: Axes, log: Log) -> None:
    states, (low, high) = log.states, log.mission.request.tension_n
    for i, colour in enumerate(CABLES):
        axes.plot(*thin(states.time / 60.0, states.actual_tension[:, i]), color=colour, lw=0.8, label=f"cable {i + 1}")
    top = max(1.12 * high, 1.05 * float(states.actual_tension.max()))
    for limit in (low, high):
        axes.axhline(limit, color=VERMILION, lw=0.9, ls=(0, (5, 2)))
    axes.axhspan(high, top, color=VERMILION, alpha=0.06, lw=0.0)
    axes.axhspan(0.0, low, color=VERMILION, alpha=0.06, lw=0.0)
    axes.set(ylim=(0.0, top), ylabel="[N]")
    axes.set_title(f"tension of the driving cables, window {low:.0f}-{high:.0f} N")
    axes.legend(ncols=4, loc="upper right", bbox_to_anchor=(1.0, 1.16), borderaxespad=0.0)


def _margins(axes: Axes, log: Log) -> None:
    states = log.states
    for i, colour in enumerate(CABLES):
        moving = states.base_moving == i + 1
        for first, last in spells(moving):
            time = states.time[[first, last]] / 60.0
            axes.axvspan(time[0], time[1], color=colour, alpha=0.13, lw=0.0)
        axes.plot(*thin(states.time / 60.0, states.slip_margin[:, i]), color=colour, lw=0.8, label=f"base {i + 1}")
    low = min(0.0, 1.1 * float(states.slip_margin.min()))
    axes.axhline(0.0, color=VERMILION, lw=0.9, ls=(0, (5, 2)))
    axes.set(ylim=(low, 1.0), ylabel="[1]")
    axes.set_title("pull margin of the bases, 1 - pull / limit")
    axes.text(1.0, 1.04, "shaded: that base's palms are open, its limit the lower one", color=MUTED,
              transform=axes.transAxes, ha="right", va="bottom", fontsize=8.0)  # fmt: skip
