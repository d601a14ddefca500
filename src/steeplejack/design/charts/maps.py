"""Figures of workspace maps, after Fig. 8-9: what the platform can reach, and how well it is held there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import Normal, withStroke
from numpy.typing import NDArray

from steeplejack.design.charts.style import INK, PAPER, ROPE, STEEL, STYLE
from steeplejack.mechanics.cable.structure import planar_arms

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh

Array = NDArray[np.float64]
Stays = Mapping[str, tuple[float, float]]

MOST_PANELS = 9
MOST_NODES = 600  # along a side; finer maps are drawn thinned
LABELS = {"tension_factor": "tension factor [1]", "margin": "margin inside the tension window [1]"}
LEVELS = (0.2, 0.4, 0.6, 0.8)


@dataclass(frozen=True, eq=False)
class _Panel:
    """One orientation of a map, as arrays; values are not a number outside."""

    x: Array
    y: Array
    phi: float
    values: Array
    closure: NDArray[np.bool_]
    anchors: Array
    attachments: Array

    @property
    def best(self) -> tuple[Array, float] | None:
        """Pose and value of the best node."""
        if np.isnan(self.values).all():
            return None
        row, column = np.unravel_index(int(np.nanargmax(self.values)), self.values.shape)
        return np.array([self.x[column], self.y[row], self.phi]), float(self.values[row, column])


def map_figure(dataset: xr.Dataset, stays: Stays | None = None) -> Figure:
    """Draw a map with stays, anchors and the platform at its best, one panel an orientation and nine at most.

    The colour is the tension factor. With a load it is the margin of the bounded tensions, and a dashed line shows
    where wrench closure ends.

    Args:
        dataset: From `tension_map`.
        stays: Lines ``y = slope x + intercept`` by stay id, slope [1] and intercept [m].

    Returns:
        The figure, in metres.
    """
    quantity = "margin" if "margin" in dataset else "tension_factor"
    count = dataset.sizes["phi"]
    panels = [_panel(dataset, index, quantity) for index in range(0, count, -(-count // MOST_PANELS))]
    bests = [panel.best[1] for panel in panels if panel.best is not None]
    ceiling = max(max(bests), 1e-6) if quantity == "margin" and bests else 1.0
    rows = int(np.sqrt(len(panels)))
    columns = -(-len(panels) // rows)
    large = len(panels) == 1
    size = (7.6, 6.4) if large else (3.1 * columns + 0.9, 2.9 * rows + 0.5)
    with matplotlib.rc_context(rc=STYLE):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.subplots(rows, columns, squeeze=False)
        colours = [_draw(axes, panel, stays or {}, ceiling, large) for axes, panel in zip(grid.flat, panels)]  # noqa: B905
        for axes in grid.flat[len(panels) :]:
            axes.set_visible(False)
        bar = figure.colorbar(colours[0], ax=grid, shrink=0.92, aspect=34, pad=0.02, label=LABELS[quantity])
        bar.outline.set_visible(False)
    return figure


def _panel(dataset: xr.Dataset, index: int, quantity: str) -> _Panel:
    one = dataset.isel(phi=index)
    return _Panel(
        x=one["x"].to_numpy(),
        y=one["y"].to_numpy(),
        phi=float(one["phi"].to_numpy()),
        values=np.where(one["inside"].to_numpy() > 0, one[quantity].to_numpy(), np.nan),
        closure=one["tension_factor"].to_numpy() > 0.0,
        anchors=one["anchor"].to_numpy(),
        attachments=one["attachment"].to_numpy(),
    )


def _draw(axes: Axes, panel: _Panel, stays: Stays, ceiling: float, large: bool) -> QuadMesh:
    """Draw one panel; returns what the colour bar describes."""
    _frame(axes, panel.anchors)
    colours = _draw_map(axes, panel, ceiling, large)
    _draw_stays(axes, stays, large)
    best = panel.best
    if best is not None:
        _draw_platform(axes, panel, best[0])
    _draw_anchors(axes, panel.anchors, large)
    text = "nothing inside" if best is None else f"best {best[1]:.3f} at ({best[0][0]:.4g}, {best[0][1]:.4g}) m"
    if best is not None and large:
        text = f"{np.isfinite(panel.values).sum()} nodes inside, mean {np.nanmean(panel.values):.3f}, {text}"
    axes.set_title(f"φ = {np.rad2deg(panel.phi):.4g}°", loc="left", fontsize=12 if large else 9, fontweight="bold")
    axes.set_title(text, loc="right", fontsize=9 if large else 7, color=ROPE)
    if large:
        axes.set(xlabel="x along the bridge [m]", ylabel="y up [m]")
    return colours


def _frame(axes: Axes, anchors: Array) -> None:
    """Equal axes around the anchors with room for their discs."""
    low, high = anchors.min(axis=0), anchors.max(axis=0)
    room = 0.09 * float((high - low).max())
    axes.set(aspect="equal", xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room))
    axes.grid(color="#e6eaed", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(length=3)


def _draw_map(axes: Axes, panel: _Panel, ceiling: float, large: bool) -> QuadMesh:
    """Coloured nodes, their level lines, and the edge of wrench closure where it is not theirs."""
    thin = slice(None, None, -(-max(panel.values.shape) // MOST_NODES))
    x, y, closure = panel.x[thin], panel.y[thin], panel.closure[thin, thin]
    values = np.ma.masked_invalid(panel.values[thin, thin])
    colours = axes.pcolormesh(x, y, values, cmap="viridis", vmin=0.0, vmax=ceiling, zorder=2)
    colours.set_rasterized(True)
    if min(values.shape) < 2:
        return colours
    edge = closure & values.mask
    if edge.any():
        axes.contour(x, y, closure, [0.5], colors=INK, linewidths=0.9, linestyles="dashed", zorder=3)
        if large:
            axes.text(0.985, 0.02, "dashed: edge of wrench closure", transform=axes.transAxes, ha="right", fontsize=8)
    levels = [share * ceiling for share in LEVELS if values.max() > share * ceiling] if values.count() else []
    if large and levels:
        lines = axes.contour(x, y, values, levels, colors=PAPER, linewidths=0.7, zorder=3)
        axes.clabel(lines, fmt="%.2g", fontsize=7)
    return colours


def _draw_stays(axes: Axes, stays: Stays, large: bool) -> None:
    """Stays as grey bands across the panel, named where they enter it from the left."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    for name, (slope, intercept) in stays.items():
        ends = np.array([left, right])
        axes.plot(ends, slope * ends + intercept, color=STEEL, linewidth=4.0 if large else 2.5, alpha=0.55, zorder=1)
        edge = top if slope < 0.0 else bottom
        at = max(left, (edge - intercept) / slope if slope else left) + 0.02 * (right - left)
        if large and at < right:
            turn = float(np.rad2deg(np.arctan(slope)))
            axes.annotate(
                f"stay {name}",
                (at, slope * at + intercept),
                (3, 5),
                textcoords="offset points",
                rotation=turn,
                rotation_mode="anchor",
                fontsize=8,
                color=ROPE,
            )
    axes.set(xlim=(left, right), ylim=(bottom, top))


def _draw_platform(axes: Axes, panel: _Panel, pose: Array) -> None:
    """Outline of the platform at a pose, with a light edge that shows on any colour, and its driving cables."""
    corners = pose[:2] + planar_arms(panel.attachments, float(pose[2]))
    halo = [withStroke(linewidth=3.0, foreground=PAPER, alpha=0.75), Normal()]
    for corner, anchor in zip(corners, panel.anchors, strict=True):
        axes.plot(*np.stack((corner, anchor)).T, color=INK, linewidth=0.9, zorder=4)
    axes.fill(*corners.T, facecolor="none", edgecolor=INK, linewidth=1.3, path_effects=halo, zorder=5)
    axes.plot(*pose[:2], marker="+", markersize=9, color=INK, markeredgewidth=1.5, path_effects=halo, zorder=6)


def _draw_anchors(axes: Axes, anchors: Array, large: bool) -> None:
    """Anchor bases as numbered discs."""
    size = 13.0 if large else 8.5
    axes.plot(*anchors.T, "o", markersize=size, color=INK, markeredgecolor=PAPER, zorder=7)
    for number, (x, y) in enumerate(anchors, start=1):
        axes.text(x, y, f"{number}", color=PAPER, fontsize=0.6 * size, ha="center", va="center_baseline", zorder=8)
