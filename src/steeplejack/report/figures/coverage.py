"""What was seen, metre by metre and around the clock, one map per stay."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from steeplejack.planning.coverage import Seen
from steeplejack.report.analysis import Analysis
from steeplejack.report.figures.style import BLUE, INK, VERMILION, Array, canvas, svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NOT_ASKED, UNSEEN, SEEN, MISSED, FACED = range(5)
COLOURS = ("#ffffff", "#e3e8ec", "#9ecae1", "#f6c8a8", BLUE)
HOURS = (0, 3, 6, 9, 12)


def coverage_figure(analysis: Analysis) -> str:
    """A map for every interior stay: metre along it by position on the clock, the faced sector outlined."""
    seen = analysis.seen
    with canvas(0.75 + 1.45 * len(seen)) as figure:
        grid = figure.subplots(len(seen), 1, squeeze=False, sharex=True)
        for axes, stay in zip(grid[:, 0], seen, strict=True):
            _map(axes, stay)
            _hatch(axes, stay, analysis)
        grid[-1, 0].set_xlabel("along the stay from its lower anchorage [m]")
        figure.supylabel("clock position, 12 on top, looking up the stay", fontsize=8.5)
        figure.legend(handles=_legend(), loc="outside lower center", ncols=5)
        return svg(figure, "coverage")


def _map(axes: Axes, stay: Seen) -> None:
    kind = np.where(stay.faced, np.where(stay.seen, FACED, MISSED), np.where(stay.seen, SEEN, UNSEEN))
    kind[stay.weight <= 0.0] = NOT_ASKED
    half = 6.0 / len(stay.clock)
    # Samples stand in the middle of their row: the one at 12 fills half a row at either end.
    rows = np.vstack([kind.T, kind.T[:1]])
    axes.imshow(
        rows,
        cmap=ListedColormap(COLOURS),
        vmin=-0.5,
        vmax=len(COLOURS) - 0.5,
        aspect="auto",
        interpolation="none",
        extent=(float(stay.edges[0]), float(stay.edges[-1]), 12.0 + half, -half),
    )
    for edge in (stay.facing - stay.half_sector, stay.facing + stay.half_sector):
        axes.plot(stay.stations, _hours(edge), color=INK, lw=0.9, ls=(0, (4, 2)))
    axes.set_ylim(12.0, 0.0)
    axes.set_yticks(HOURS, ["12", "3", "6", "9", "12"])
    axes.grid(False)
    share = stay.covered_length / stay.asked_length if stay.asked_length > 0.0 else 0.0
    axes.set_title(f"{stay.stay}: {stay.covered_length:.1f} of {stay.asked_length:.1f} m ({100.0 * share:.1f} %)")


def _hours(angle: Array) -> Array:
    """Clock angles as hours 0 to 12, with a gap where they pass 12."""
    hours = (angle % (2.0 * math.pi)) * 6.0 / math.pi
    hours[1:][np.abs(np.diff(hours)) > 6.0] = np.nan
    return hours


def _hatch(axes: Axes, stay: Seen, analysis: Analysis) -> None:
    """Hatch what was not covered on the faced sector."""
    for gap in analysis.summary.not_covered:
        if gap.stay == stay.stay:
            axes.axvspan(gap.from_m, gap.to_m, fill=False, hatch="////", ec=VERMILION, lw=0.0, zorder=3)
            axes.axvspan(gap.from_m, gap.to_m, fill=False, ec=VERMILION, lw=0.9, zorder=4)


def _legend() -> list[Patch | Line2D]:
    return [
        Patch(color=COLOURS[FACED], label="seen, faced sector"),
        Patch(color=COLOURS[SEEN], label="seen beyond it"),
        Patch(color=COLOURS[UNSEEN], label="not seen, away from the face"),
        Patch(fc=COLOURS[MISSED], ec=VERMILION, hatch="////", lw=0.9, label="not covered"),
        Line2D([], [], color=INK, lw=0.9, ls=(0, (4, 2)), label="faced sector"),
    ]
