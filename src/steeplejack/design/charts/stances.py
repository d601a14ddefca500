"""Figure of a stance chart: along each stay, the margin that the best stance near by leaves for a payload."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from steeplejack.design.charts.style import INK, PAPER, ROPE, STEEL, STYLE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh

FEW = 4
"""Stays up to which each gets a panel of curves; more are drawn as rows of one map."""


def stance_chart_figure(chart: xr.Dataset) -> Figure:
    """Draw a chart: curves along up to four stays, or a map with a row a stay.

    Args:
        chart: From `stance_chart`.

    Returns:
        The figure.
    """
    with matplotlib.rc_context(rc=STYLE):
        return _curves(chart) if chart.sizes["stay"] <= FEW else _map(chart)


def _title(chart: xr.Dataset) -> str:
    low, high = chart.attrs["tension_n"]
    how = "point on chords" if chart.attrs["statics"] == "chords" else "equilibria in space"
    return f"{chart.attrs['mass_kg']:g} kg, {low:g}-{high:g} N, stances within {chart.attrs['within_m']:g} m, {how}"


def _curves(chart: xr.Dataset) -> Figure:
    """A panel a stay: the best stance gripped, the worst of the phases, the fixed stance."""
    count = chart.sizes["stay"]
    figure = Figure(figsize=(8.0, 1.2 + 1.75 * count), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    s = chart["s"].to_numpy()
    for i, axes in enumerate(panels):
        one = chart.isel(stay=i)
        margin = np.where(one["asked"].to_numpy(), one["margin"].to_numpy(), np.nan)
        fixed = np.where(one["asked"].to_numpy(), one["fixed_margin"].to_numpy(), np.nan)[0]
        axes.axhspan(-0.25, 0.0, color="#f3e3df", zorder=0)
        axes.plot(s, fixed, color=STEEL, linewidth=1.2, label="fixed stance, gripped", zorder=2)
        if len(margin) > 1:
            # fmin skips what is not a number, and the worst of the phases holds only where all of them do.
            worst = np.where(np.isnan(margin).any(axis=0), np.nan, margin.min(axis=0))
            axes.plot(
                s, worst, color="#2a788e", linewidth=1.1, linestyle="dashed", label="worst base driving", zorder=3
            )
        axes.plot(s, margin[0], color=INK, linewidth=1.6, label="best stance, gripped", zorder=4)
        lost = np.isnan(margin[0]) & one["asked"].to_numpy()
        axes.plot(s[lost], np.full(lost.sum(), -0.2), "|", color="#b5532f", markersize=5, label="no stance", zorder=5)
        axes.set(ylim=(-0.25, 1.0), xlim=(0.0, float(chart["length"].max())))
        axes.set_ylabel("slip margin [1]")
        axes.set_title(str(one["stay"].item()), loc="left", fontsize=9, fontweight="bold")
        axes.grid(color="#e6eaed", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].set_title(_title(chart), loc="right", fontsize=8, color=ROPE)
    panels[-1].set_xlabel("s along the stay from its lower anchorage [m]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False, fontsize=8)
    return figure


def _map(chart: xr.Dataset) -> Figure:
    """A row a stay: the best margin gripped, and under it the fixed stance's."""
    figure = Figure(figsize=(9.0, 1.4 + 2 * max(1.6, 0.09 * chart.sizes["stay"])), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, 1, sharex=True)
    names = ("best stance", "fixed stance of each cell")
    colours = [
        _rows(axes, chart, quantity, name)
        for axes, quantity, name in zip(panels, ("margin", "fixed_margin"), names, strict=True)
    ]
    panels[0].set_title(_title(chart), loc="right", fontsize=8, color=ROPE)
    panels[1].set_xlabel("s along the stay from its lower anchorage [m]")
    bar = figure.colorbar(colours[0], ax=panels, shrink=0.9, aspect=34, pad=0.02, label="slip margin, gripped [1]")
    bar.outline.set_visible(False)
    return figure


def _rows(axes: Axes, chart: xr.Dataset, quantity: str, name: str) -> QuadMesh:
    asked = chart["asked"].to_numpy()
    values = chart[quantity].isel(phase=0).to_numpy()
    s, rows = chart["s"].to_numpy(), np.arange(len(asked))
    axes.pcolormesh(s, rows, np.ma.masked_where(~asked, np.zeros(asked.shape)), cmap="Greys", vmin=-0.25, vmax=1.0)
    held = np.ma.masked_where(~asked | ~(values >= 0.0), values)
    colours = axes.pcolormesh(s, rows, held, cmap="viridis", vmin=0.0, vmax=1.0)
    for mesh in axes.collections:
        mesh.set_rasterized(True)
    fans = [str(stay).rsplit("-", 1) for stay in chart["stay"].to_numpy()]
    starts = [i for i, fan in enumerate(fans) if i == 0 or (fan[0], fan[1][:1]) != (fans[i - 1][0], fans[i - 1][1][:1])]
    for start in starts[1:]:
        axes.axhline(start - 0.5, color=PAPER, linewidth=1.5)
    few = len(starts) < 3
    ticks = list(rows[:: max(1, len(rows) // 12)]) if few else starts
    axes.set_yticks(ticks, [str(chart["stay"].to_numpy()[i]) for i in ticks], fontsize=7)
    axes.set_title(f"{name}: {np.mean(values[asked] >= 0.0):.0%} held", loc="left", fontsize=10, fontweight="bold")
    axes.invert_yaxis()
    axes.spines[["top", "right"]].set_visible(False)
    return colours
