"""Figures of the pipe climber's design: workspaces, transmission, performance charts (after Fig. 5-6, 12-16)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from steeplejack.design.charts.style import INK, PAPER, ROPE, STYLE
from steeplejack.design.climber.dimensions import ORIGINAL, Chart, Index, Ratio
from steeplejack.design.climber.dimensions import PAPER as REPORTED
from steeplejack.design.climber.front import Front
from steeplejack.design.climber.quality import GOOD, TransmissionMap
from steeplejack.design.climber.reach import Places, strips, workspace_area
from steeplejack.robots.pipe_climber import Layout

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh

Array = NDArray[np.float64]

MM = 1e3
WARM = "#d1495b"
FILL = "#cfe0ea"
ROWS = 400  # strips drawn
NAMES: dict[Index, str] = {"gti": "GTI [1]", "mean": "mean LTI [1]", "least": "least LTI [1]"}


def reach_figure(layout: Layout, alpha: float, places: Places) -> Figure:
    """The translational workspace at one orientation, and how far the platform can turn at each place.

    Args:
        layout: Hinges and limits.
        alpha: Orientation of the left panel [rad].
        places: From `orientations`.

    Returns:
        The figure, in millimetres and degrees.
    """
    with matplotlib.rc_context(rc=STYLE):
        figure = Figure(figsize=(10.0, 3.5), layout="constrained")
        FigureCanvasAgg(figure)
        left, right = figure.subplots(1, 2)
        _strips(left, layout, alpha)
        _mechanism(left, layout, (layout.home[0], layout.home[1], alpha))
        left.set_title(f"α = {math.degrees(alpha):.4g}°", loc="left", fontweight="bold")
        left.set_title(f"{workspace_area(layout, alpha) * 1e6:,.0f} mm²", loc="right", fontsize=9, color=ROPE)
        turn = np.ma.masked_equal(np.rad2deg(places.turn), 0.0)
        colours = right.pcolormesh(places.x * MM, places.w * MM, turn, cmap="viridis", vmin=0.0, rasterized=True)
        right.set_title("orientations at each place", loc="left", fontweight="bold")
        right.set_title(f"{places.volume:.4g} m² rad", loc="right", fontsize=9, color=ROPE)
        bar = figure.colorbar(colours, ax=right, shrink=0.9, aspect=28, pad=0.02, label="turn of α [deg]")
        bar.outline.set_visible(False)
        for axes in (left, right):
            _frame(axes)
        figure.suptitle(_limits(layout), fontsize=8, color=ROPE, x=0.99, ha="right")
    return figure


def orientation_figure(layouts: Mapping[str, Layout], w: float, count: int = 361) -> Figure:
    """Sections of the orientation workspace at one w: what is reached of x at each orientation (after Fig. 5).

    Args:
        layouts: By the name of their panel.
        w: Height of the section [m].
        count: Orientations drawn.

    Returns:
        The figure, in millimetres and degrees.
    """
    with matplotlib.rc_context(rc=STYLE):
        figure = Figure(figsize=(3.3 * len(layouts) + 0.4, 3.6), layout="constrained")
        FigureCanvasAgg(figure)
        panels = figure.subplots(1, len(layouts), squeeze=False, sharex=True, sharey=True)[0]
        degrees = np.linspace(-150.0, 150.0, count)
        half = 0.5 * (degrees[1] - degrees[0])
        for axes, (name, layout) in zip(panels, layouts.items(), strict=True):
            boxes: list[list[tuple[float, float]]] = []
            for angle in degrees.tolist():
                boxes += [
                    _box((low * MM, high * MM), (angle - half, angle + half))
                    for low, high in strips(layout, [w], math.radians(angle))[0].tolist()
                ]
            axes.add_collection(PolyCollection(boxes, facecolor="#4a86a8", edgecolor="none", rasterized=True))
            axes.set_title(name, loc="left", fontweight="bold")
            axes.set(xlim=(-290.0, 190.0), ylim=(-150.0, 150.0), xlabel="x [mm]", yticks=range(-150, 151, 50))
            axes.grid(color="#e6eaed", linewidth=0.6)
            axes.set_axisbelow(True)
            axes.spines[["top", "right"]].set_visible(False)
        panels[0].set_ylabel("α [deg]")
        panels[-1].set_title(f"w = {w * MM:g} mm", loc="right", fontsize=9, color=ROPE)
    return figure


def transmission_figure(maps: Mapping[str, TransmissionMap]) -> Figure:
    """Maps of the local transmission index side by side; a dark line where it is 0.5 (Fig. 12 and 16).

    Args:
        maps: By the name of their panel.

    Returns:
        The figure, in millimetres.
    """
    columns = min(len(maps), 4)
    rows = -(-len(maps) // columns)
    with matplotlib.rc_context(rc=STYLE):
        figure = Figure(
            figsize=(6.4, 4.6) if len(maps) == 1 else (3.1 * columns + 0.8, 2.4 * rows + 0.5), layout="constrained"
        )
        FigureCanvasAgg(figure)
        panels = figure.subplots(rows, columns, squeeze=False)
        top = min(1.0, math.ceil(10.0 * max(one.largest[0] for one in maps.values())) / 10.0)
        drawn = [_transmission(axes, name, one, top) for axes, (name, one) in zip(panels.flat, maps.items())]  # noqa: B905
        for axes in panels.flat[len(maps) :]:
            axes.set_visible(False)
        bar = figure.colorbar(drawn[0], ax=panels, shrink=0.9, aspect=30, pad=0.02, label="LTI [1]")
        bar.outline.set_visible(False)
    return figure


def chart_figure(chart: Chart, index: Index = "gti") -> Figure:
    """A performance chart of a plane of the design space, in ratios to L1 and in normalised parameters (Fig. 14-15).

    Args:
        chart: Over a plane with L2 / L1 fixed.
        index: What is drawn.

    Returns:
        The figure.
    """
    best, value = chart.best(index)
    with matplotlib.rc_context(rc=STYLE):
        figure = Figure(figsize=(9.6, 4.3), layout="constrained")
        FigureCanvasAgg(figure)
        left, right = figure.subplots(1, 2)
        values = np.ma.masked_invalid(chart.values(index))
        total = chart.ratios.sum(axis=1)
        third, fourth = chart.ratios[:, 2], chart.ratios[:, 3]
        colours = None
        for axes, scale in ((left, np.ones_like(total)), (right, total)):
            colours = axes.tripcolor(
                third / scale, fourth / scale, values.filled(0.0), cmap="viridis", vmin=0.0, shading="gouraud"
            )
            colours.set_rasterized(True)
            lines = axes.tricontour(
                third / scale, fourth / scale, values.filled(0.0), 8, colors=PAPER, linewidths=0.5, alpha=0.8
            )
            axes.clabel(lines, fmt="%.2g", fontsize=6)
            _marks(axes, {"original": ORIGINAL, "reported optimum": REPORTED, "best": best}, scale is total)
            axes.spines[["top", "right"]].set_visible(False)
        left.set(xlabel="L3 / L1", ylabel="L4 / L1", aspect="equal")
        right.set(xlabel="r3 = L3 / (L1 + L2 + L3 + L4)", ylabel="r4", aspect="equal")
        left.set_title(f"best {value:.4f} at L3/L1 = {best[2]:.3g}, L4/L1 = {best[3]:.3g}", loc="left", fontsize=9)
        handles, labels = left.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize=8)
        assert colours is not None
        bar = figure.colorbar(colours, ax=[left, right], shrink=0.9, aspect=28, pad=0.02, label=NAMES[index])
        bar.outline.set_visible(False)
    return figure


def front_figure(front: Front) -> Figure:
    """Designs that no other beats: transmission against workspace, coloured by the distance to singularity.

    Args:
        front: From `steeplejack.design.climber.front`.

    Returns:
        The figure.
    """
    with matplotlib.rc_context(rc=STYLE):
        figure = Figure(figsize=(6.8, 4.4), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots()
        axes.scatter(front.area * 1e6, front.gti, s=4, color="#dde3e8", label="beaten by another design")
        best = front.best
        points = axes.scatter(
            front.area[best] * 1e6,
            front.gti[best],
            s=10.0 + 60.0 * (front.size[best].max() - front.size[best]) / max(float(np.ptp(front.size[best])), 1e-12),
            c=front.distance[best],
            cmap="viridis",
            edgecolor=PAPER,
            linewidth=0.3,
            label="not beaten; larger is more compact",
        )
        for name, ratio, marker in (("original", ORIGINAL, "s"), ("reported optimum", REPORTED, "^")):
            at = int(np.argmin(np.abs(front.ratios - np.array(ratio)).max(axis=1)))
            axes.plot(
                front.area[at] * 1e6, front.gti[at], marker, color=WARM, markersize=8, markeredgecolor=PAPER, label=name
            )
        axes.set(xlabel="area of the workspace at α = 0 [mm²]", ylabel="GTI [1]")
        axes.grid(color="#e6eaed", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=8)
        bar = figure.colorbar(points, ax=axes, shrink=0.9, aspect=28, pad=0.02, label="least |det J| / L1 [1]")
        bar.outline.set_visible(False)
    return figure


def _strips(axes: Axes, layout: Layout, alpha: float) -> None:
    """Fill the translational workspace strip by strip."""
    height = (layout.reach[1] + max(layout.lengths)) / ROWS
    rows = height * (np.arange(ROWS, dtype=np.float64) + 0.5)
    boxes = [
        _box((low * MM, high * MM), ((w - 0.5 * height) * MM, (w + 0.5 * height) * MM))
        for w, pieces in zip(rows.tolist(), strips(layout, rows, alpha), strict=True)
        for low, high in pieces.tolist()
    ]
    axes.add_collection(PolyCollection(boxes, facecolor=FILL, edgecolor=FILL, linewidth=0.3))


def _box(x: tuple[float, float], y: tuple[float, float]) -> list[tuple[float, float]]:
    return [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]


def _mechanism(axes: Axes, layout: Layout, pose: tuple[float, float, float]) -> None:
    """Base, platform and limbs at a pose, O2 marked."""
    x, w, alpha = pose
    ends = np.stack((x + layout.platform * math.cos(alpha), w - layout.platform * math.sin(alpha)), axis=-1) * MM
    base = layout.base * MM
    for b, end in zip(base, ends, strict=True):
        axes.plot([b, end[0]], [0.0, end[1]], color=ROPE, linewidth=1.4, solid_capstyle="round")
    axes.plot(base, np.zeros(3), "-o", color=INK, linewidth=2.6, markersize=4)
    axes.plot(*ends.T, "-o", color=INK, linewidth=2.6, markersize=4)
    axes.plot(x * MM, w * MM, "o", color=WARM, markersize=5, zorder=5)


def _frame(axes: Axes) -> None:
    axes.set(aspect="equal", xlabel="x [mm]", ylabel="w [mm]", xlim=(-250.0, 250.0), ylim=(-15.0, 260.0))
    axes.grid(color="#e6eaed", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _limits(layout: Layout) -> str:
    """The limits in words."""
    low, high = layout.reach
    joints = "no joint limits"
    if layout.neutral != "none":
        joints = f"joints ±{math.degrees(layout.joint_limit):.4g}° from {layout.neutral}"
    size = ", ".join(f"{length * MM:g}" for length in layout.lengths)
    return f"L1..L4 {size} mm ({layout.convention}), limbs {low * MM:g}-{high * MM:g} mm, {joints}"


def _transmission(axes: Axes, name: str, one: TransmissionMap, top: float) -> QuadMesh:
    """One map, with its numbers."""
    values = np.ma.masked_invalid(one.values)
    x, w = one.x * MM, one.w * MM
    drawn = axes.pcolormesh(x, w, values, cmap="viridis", vmin=0.0, vmax=top, rasterized=True)
    if min(values.shape) > 1 and values.min() < GOOD < values.max():
        axes.contour(x, w, values, [GOOD], colors=INK, linewidths=1.0)
    _value, best_x, best_w = one.largest
    axes.plot(best_x * MM, best_w * MM, "+", color=WARM, markersize=8, markeredgewidth=1.5)
    axes.set_title(name, loc="left", fontsize=9, fontweight="bold")
    axes.set_xlabel(f"x [mm]\nGTI {one.gti:.3f}, mean {one.mean:.3f}, max {one.largest[0]:.3f}", fontsize=8)
    axes.set_ylabel("w [mm]", fontsize=8)
    axes.set_aspect("equal")
    axes.spines[["top", "right"]].set_visible(False)
    return drawn


def _marks(axes: Axes, designs: Mapping[str, Ratio], normalise: bool) -> None:
    """Named designs on a chart."""
    for (name, ratio), marker in zip(designs.items(), ("s", "^", "*"), strict=True):
        total = sum(ratio) if normalise else 1.0
        axes.plot(
            ratio[2] / total,
            ratio[3] / total,
            marker,
            color=WARM,
            markersize=11 if marker == "*" else 7,
            markeredgecolor=PAPER,
            linestyle="none",
            clip_on=False,
            label=name,
            zorder=5,
        )
