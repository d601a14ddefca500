"""Figures of grasps, after Fig. 14: the bands of tension factor a search passes through, and what distance buys."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.patheffects import Normal, withStroke
from numpy.typing import NDArray

from steeplejack.design.charts.style import INK, PAPER, ROPE, STEEL, STYLE
from steeplejack.mechanics.cable.region.grid import tension_factor_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from steeplejack.design.grasps import Grasp, GraspFront, GraspQuestion

Array = NDArray[np.float64]
Stays = Mapping[str, tuple[float, float]]

BANDS = (0.45, 0.6, 0.725, 0.85, 1.0)
"""Ends of the bands of Fig. 14 [1]."""

COLOURS = ("#cfe3ee", "#8fbfda", "#4a90bd", "#1c5f8f")
OUTSIDE, WEAK, GRASP = PAPER, "#f0f3f5", "#c8402f"
NODES = 500


def grasp_figure(question: GraspQuestion, grasp: Grasp, front: GraspFront, stays: Stays | None = None) -> Figure:
    """Draw the bands of tension factor with the region and the grasp in it, and beside them the front.

    Args:
        question: Robot, orientation and region.
        grasp: What was found.
        front: Largest TF by distance from the axis.
        stays: Lines ``y = slope x + intercept`` by stay id, slope [1] and intercept [m].

    Returns:
        The figure.
    """
    with matplotlib.rc_context(rc=STYLE):
        figure = Figure(figsize=(9.6, 4.6), layout="constrained")
        FigureCanvasAgg(figure)
        bands, trade = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
        _draw_bands(bands, question, grasp, stays or {})
        _draw_front(trade, grasp, front)
    return figure


def _draw_bands(axes: Axes, question: GraspQuestion, grasp: Grasp, stays: Stays) -> None:
    """Bands, stays, anchors, region and grasp."""
    points = np.concatenate((question.anchors, question.region.corners))
    low, high = points.min(axis=0), points.max(axis=0)
    room = 0.07 * float((high - low).max())
    (left, bottom), (right, top) = low - room, high + room
    x, y = np.linspace(left, right, NODES), np.linspace(bottom, top, NODES)
    factors = tension_factor_grid(question.anchors, question.attachments, question.phi, x, y)
    levels = [-1.0, 1e-9, *BANDS[:-1], BANDS[-1] + 1e-9]
    axes.contourf(x, y, factors, levels, colors=(OUTSIDE, WEAK, *COLOURS), zorder=1)
    axes.contour(x, y, factors, [1e-9], colors=STEEL, linewidths=0.8, zorder=2)
    axes.set(aspect="equal", xlim=(left, right), ylim=(bottom, top), xlabel="x along the bridge [m]", ylabel="y up [m]")
    for name, (slope, intercept) in stays.items():
        _draw_stay(axes, name, slope, intercept)
    halo = [withStroke(linewidth=3.0, foreground=PAPER, alpha=0.8), Normal()]
    axes.fill(*question.region.corners.T, facecolor="#e8a39a80", edgecolor=GRASP, linewidth=1.2, zorder=4)
    axes.plot(*grasp.position, "o", markersize=5.5, color=GRASP, markeredgecolor=PAPER, path_effects=halo, zorder=6)
    axes.plot(*question.anchors.T, "o", markersize=12.0, color=INK, markeredgecolor=PAPER, zorder=5)
    for number, (across, up) in enumerate(question.anchors, start=1):
        axes.text(across, up, f"{number}", color=PAPER, fontsize=7.5, ha="center", va="center_baseline", zorder=7)
    names = [f"{a:g} to {b:g}" for a, b in zip(BANDS[:-1], BANDS[1:], strict=True)]
    patches = [
        Patch(facecolor=c, label=n) for c, n in zip((WEAK, *COLOURS), (f"below {BANDS[0]:g}", *names), strict=True)
    ]
    axes.legend(handles=patches[::-1], title="tension factor", fontsize=7.5, title_fontsize=8, loc="lower left")
    axes.set_title(f"φ = {np.rad2deg(question.phi):.4g}°", loc="left", fontsize=11, fontweight="bold")
    text = f"TF {grasp.tension_factor:.4f} at ({grasp.position[0]:.4f}, {grasp.position[1]:.4f}) m"
    axes.set_title(text, loc="right", fontsize=8.5, color=ROPE)
    axes.spines[["top", "right"]].set_visible(False)


def _draw_stay(axes: Axes, name: str, slope: float, intercept: float) -> None:
    """A stay as a grey band, named where it enters from the left."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    ends = np.array([left, right])
    axes.plot(ends, slope * ends + intercept, color=STEEL, linewidth=3.0, alpha=0.6, zorder=3)
    edge = top if slope < 0.0 else bottom
    at = max(left, (edge - intercept) / slope if slope else left) + 0.03 * (right - left)
    if at < right:
        axes.annotate(
            f"stay {name}",
            (at, slope * at + intercept),
            (3, 8),
            textcoords="offset points",
            rotation=float(np.rad2deg(np.arctan(slope))),
            rotation_mode="anchor",
            fontsize=7.5,
            color=ROPE,
            zorder=3,
        )
    axes.set(xlim=(left, right), ylim=(bottom, top))


def _draw_front(axes: Axes, grasp: Grasp, front: GraspFront) -> None:
    """Largest tension factor by distance, and the grasp."""
    order = np.argsort(front.distances, kind="stable")
    held = order[front.tension_factor[order] > 0.0]
    axes.plot(1e3 * front.distances[held], front.tension_factor[held], color=COLOURS[-1], linewidth=1.8, zorder=2)
    axes.plot(1e3 * grasp.distance, grasp.tension_factor, "o", markersize=5.5, color=GRASP, zorder=3)
    axes.annotate(
        "this grasp",
        (1e3 * grasp.distance, grasp.tension_factor),
        (-8, -3),
        textcoords="offset points",
        ha="right",
        va="top",
        fontsize=8,
        color=GRASP,
    )
    axes.set(xlabel="greatest distance from the axis [mm]", ylabel="largest tension factor [1]")
    axes.set_title("what distance buys", loc="left", fontsize=11, fontweight="bold")
    axes.grid(color="#e6eaed", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
