"""Figures of lost cables: how far the platform sinks and what the others carry, over a grid or along a mission."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from steeplejack.design.charts.style import INK, ROPE, STEEL, STYLE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh

Array = NDArray[np.float64]

CABLES = ("#1f4e79", "#d1495b", "#3a7d44", "#e09f3e", "#7b5ea7", "#2aa198", "#8c564b", "#444444")
ROWS = {"drop": ("sinks by [m]", "viridis"), "greatest_tension": ("greatest tension left [N]", "magma")}


def lost_cable_figure(dataset: xr.Dataset) -> Figure:
    """Draw a dataset of lost cables.

    Over a grid: two panels a cable, drop above and greatest surviving tension below, the worst over the orientations.
    Along a mission: drop, tension and lowest point against the number of the waypoint, a line for each cable.

    Args:
        dataset: From `steeplejack.design.lost_cable.lost_cable_dataset`.

    Returns:
        The figure.
    """
    with matplotlib.rc_context(rc=STYLE):
        return _along(dataset) if "leg" in dataset.coords else _grid(dataset)


def _grid(dataset: xr.Dataset) -> Figure:
    """Colours over x and y."""
    count = dataset.sizes["cable"]
    figure = Figure(figsize=(2.9 * count + 1.0, 6.0), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, count, squeeze=False, sharex=True, sharey=True)
    for row, (name, (label, colours)) in zip(panels, ROWS.items(), strict=True):
        least, greatest = float(dataset[name].min()), float(dataset[name].max())
        # Tensions grow without bound towards singular poses: only their order of magnitude can be seen.
        scale = Normalize(min(0.0, least), greatest) if name == "drop" else LogNorm(max(least, 1e-9), greatest)
        drawn = [_panel(axes, dataset, k, name, colours, scale) for k, axes in enumerate(row)]
        bar = figure.colorbar(drawn[0], ax=list(row), shrink=0.9, aspect=24, pad=0.02, label=label)
        bar.outline.set_visible(False)
    for k, axes in enumerate(panels[0]):
        axes.set_title(f"cable {int(dataset['cable'][k])} lost", loc="left", fontweight="bold")
    figure.supxlabel("x [m]", fontsize=9)
    figure.supylabel("y [m]", fontsize=9)
    return figure


def _panel(axes: Axes, dataset: xr.Dataset, cable: int, name: str, colours: str, scale: Normalize) -> QuadMesh:
    """One quantity for one cable lost; the title says the worst, a cross marks where."""
    x, y, table = _table(dataset, dataset[name].to_numpy()[:, cable])
    drawn = axes.pcolormesh(x, y, table, cmap=colours, norm=scale, shading="nearest", rasterized=True)
    anchors = dataset["anchor"].to_numpy()
    axes.plot(anchors[:, 0], anchors[:, 1], "o", color=STEEL, ms=4)
    axes.plot(*anchors[int(dataset["cable"][cable]) - 1], "x", color="#d1495b", ms=9, mew=2)
    axes.set_aspect("equal")
    if not np.isnan(table).all():
        row, column = np.unravel_index(int(np.nanargmax(table)), table.shape)
        axes.plot(x[column], y[row], "+", color="#d1495b", ms=8, mew=1.4)
        worst = float(table[row, column])
        text = f"at most {100.0 * worst:.1f} cm" if name == "drop" else f"at most {worst:,.0f} N"
        axes.set_title(text, loc="right", fontsize=8, color=ROPE)
    return drawn


def _table(dataset: xr.Dataset, values: Array) -> tuple[Array, Array, Array]:
    """Nodes along x and y, and the greatest value at each over orientations, (y, x)."""
    step = float(dataset.attrs["step"])
    columns, rows = (np.rint(dataset[name].to_numpy() / step).astype(np.int64) for name in ("x", "y"))
    table = np.full((np.ptp(rows) + 1, np.ptp(columns) + 1), -np.inf)
    np.fmax.at(table, (rows - rows.min(), columns - columns.min()), values)
    table[np.isinf(table)] = np.nan
    x, y = (step * np.arange(cells.min(), cells.max() + 1) for cells in (columns, rows))
    return x, y, table


def _along(dataset: xr.Dataset) -> Figure:
    """Lines along the waypoints, legs that inspect shaded."""
    rows = {"drop": "sinks by [m]", "greatest_tension": "greatest tension\nleft [N]", "lowest": "lowest corner [m]"}
    figure = Figure(figsize=(8.6, 6.4), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(rows), 1, sharex=True)
    kinds, legs = dataset["kind"].to_numpy(), dataset["leg"].to_numpy()
    edges = np.flatnonzero(np.diff(legs)) + 1
    for axes, (name, label) in zip(panels, rows.items(), strict=True):
        for begin, end in zip((0, *edges), (*edges, len(legs)), strict=True):
            if kinds[begin] == "inspect":
                axes.axvspan(begin, end, color="#eef1f4", lw=0)
        for k in range(dataset.sizes["cable"]):
            number = int(dataset["cable"][k])
            colour = CABLES[(number - 1) % len(CABLES)]
            axes.plot(dataset[name].to_numpy()[:, k], color=colour, lw=1.2, label=f"cable {number} lost")
        axes.set_ylabel(label)
        axes.set_xlim(0, max(len(legs) - 1, 1))
        axes.spines[["top", "right"]].set_visible(False)
    if "floor" in dataset.attrs:
        panels[-1].axhline(float(dataset.attrs["floor"]), color=INK, lw=0.9, ls="--")
    panels[-1].plot(dataset["z"].to_numpy(), color=STEEL, lw=1.0, ls=":", label="platform before")
    panels[-1].set_xlabel("waypoint of the mission (shaded: inspecting)")
    handles, labels = panels[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=5, frameon=False)
    return figure
