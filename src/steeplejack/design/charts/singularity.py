"""Figures of the pipe climber's singularities: the two geometric cases (Fig. 7) and the surface (Fig. 8)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from steeplejack.design.charts.style import INK, ROPE, STEEL, STYLE
from steeplejack.errors import InfeasibleError
from steeplejack.robots.pipe_climber.inverse import limb_vectors
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.singular_slice import reachable_x
from steeplejack.robots.pipe_climber.singularity import determinant, singular_case, singular_x

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh
    from mpl_toolkits.mplot3d.axes3d import Axes3D

LIMBS = ("#0b6e99", "#c4541a", "#2c7a3f")
RED = "#b3202c"
MM = 1e3


def singularity_figure(layout: Layout, alpha: float, turn: float = 1.0) -> Figure:
    """Draw where the mechanism is singular: det J over the reachable set at one alpha, the surface, both cases.

    Args:
        layout: Hinges and reach.
        alpha: Of the map [rad].
        turn: The surface is drawn for alpha within this either way [rad].

    Returns:
        The figure.

    Raises:
        InfeasibleError: No pose of that alpha within the reach.
    """
    with matplotlib.rc_context(rc=STYLE):
        figure = Figure(figsize=(9.6, 7.4), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(2, 2, height_ratios=[1.15, 1.0])
        drawn = _map(figure.add_subplot(grid[0, 0]), layout, alpha)
        bar = figure.colorbar(drawn, ax=figure.axes[0], shrink=0.85, label="|det J| / L1 [1]")
        bar.outline.set_visible(False)
        surface: Axes3D = figure.add_subplot(grid[0, 1], projection="3d")
        _surface(surface, layout, turn)
        _case(figure.add_subplot(grid[1, 0]), layout, _concurrent_pose(layout), "three forces through a point")
        _case(
            figure.add_subplot(grid[1, 1]),
            layout,
            (1.6 * layout.reach[1], 0.0, 0.0),
            "three parallel forces (drawn apart)",
        )
    return figure


def _map(axes: Axes, layout: Layout, alpha: float) -> QuadMesh:
    """|det J| over the reachable set of one alpha, and the singular curve."""
    reach = layout.reach[1]
    x, w = np.linspace(-1.2 * reach, 1.2 * reach, 361), np.linspace(1e-6, 1.2 * reach, 201)
    inside = np.zeros((w.size, x.size), dtype=np.bool_)
    for row, height in zip(inside, w.tolist(), strict=True):
        for low, high in reachable_x(layout, alpha, height):
            row |= (x >= low) & (x <= high)
    if not inside.any():
        raise InfeasibleError(f"a pose with alpha = {math.degrees(alpha):g} deg", f"lengths at most {reach:g} m")
    across, along = np.meshgrid(x, w)
    sizes = np.abs(determinant(layout, np.stack((across, along, np.full(across.shape, alpha)), axis=-1)))
    values = np.where(inside, sizes / layout.lengths[0], np.nan)
    drawn = axes.pcolormesh(MM * x, MM * w, values, cmap="viridis", vmin=0.0, shading="nearest", rasterized=True)
    heights = np.linspace(1e-6, 1.2 * reach, 2001)
    curve = singular_x(layout, heights, alpha)
    curve[np.abs(curve) > 2.0 * reach] = np.nan
    axes.plot(MM * curve, MM * heights, color=RED, lw=1.6, label="det J = 0")
    axes.set(xlim=(MM * x[0], MM * x[-1]), ylim=(0.0, MM * w[-1]), xlabel="x [mm]", ylabel="w [mm]", aspect="equal")
    axes.set_title(f"reachable poses, alpha = {math.degrees(alpha):.4g} deg", loc="left", fontweight="bold")
    if np.isfinite(curve).any():
        axes.legend(frameon=False, loc="upper right", fontsize=8)
    axes.spines[["top", "right"]].set_visible(False)
    return drawn


def _surface(axes: Axes3D, layout: Layout, turn: float) -> None:
    """The surface as its slices of constant alpha, on the side of the base the robot is built on."""
    reach = layout.reach[1]
    heights = np.linspace(1e-6, reach, 1201)
    colours = matplotlib.colormaps["coolwarm"]
    for alpha in np.linspace(-turn, turn, 42).tolist():
        x = singular_x(layout, heights, alpha)
        x[np.abs(x) > 1.5 * reach] = np.nan
        shade = colours(0.5 + 0.5 * alpha / turn)
        axes.plot(MM * x, MM * heights, np.full(x.shape, math.degrees(alpha)), color=shade, lw=0.9)
    axes.set(xlabel="x [mm]", ylabel="w [mm]")
    axes.set_box_aspect(None, zoom=0.88)  # pyright: ignore[reportArgumentType]
    axes.view_init(elev=24.0, azim=-58.0)
    axes.set_title("singular surface, slices of alpha [deg]", loc="left", fontweight="bold")
    axes.tick_params(labelsize=7)


def _case(axes: Axes, layout: Layout, pose: tuple[float, float, float], title: str) -> None:
    """One singular pose: base, platform, limbs, the lines of the forces and where they meet."""
    base = np.stack((layout.base, np.zeros(3)), axis=-1)
    joints = base + limb_vectors(layout, pose)
    case = singular_case(layout, pose)
    meet = case.point
    for limb, colour in enumerate(LIMBS):
        apart = np.array([0.0, 0.0 if meet is not None else 0.006 * (limb + 1)])  # lines in one line are drawn apart
        ends = np.stack((base[limb], joints[limb])) + apart
        axes.plot(*(MM * ends).T, color=colour, lw=2.2, label=f"limb {limb + 1}", zorder=3)
        if meet is not None:
            ends = np.stack((base[limb], joints[limb], meet))
            order = np.argsort(ends @ (joints[limb] - base[limb]))
            axes.plot(*(MM * ends[order][[0, -1]]).T, color=colour, lw=0.9, ls="--", zorder=1)
    axes.plot(*(MM * base).T, "-o", color=STEEL, lw=3.0, ms=5, label="base")
    axes.plot(*(MM * joints).T, "-o", color=INK, lw=3.0, ms=5, label="platform")
    if meet is not None:
        axes.plot(*(MM * meet), "o", color=RED, ms=7, zorder=5)
        place = (MM * meet[0], MM * meet[1])
        axes.annotate("all lines meet", place, (9, 0), textcoords="offset points", color=RED, fontsize=8, va="center")
    for row, (place, names) in enumerate(((base, "B"), (joints, "P"))):
        for limb in range(3):
            text = (0, -13) if row == 0 or meet is None else (-11, -3)
            axes.annotate(f"{names}{limb + 1}", MM * place[limb], text, textcoords="offset points", fontsize=8,
                          ha="center", color=ROPE)  # fmt: skip
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12, 0.25)
    x, w, alpha = pose
    axes.set_title(title, loc="left", fontweight="bold")
    where = f"x {MM * x:.0f} mm, w {MM * w:.0f} mm, alpha {math.degrees(alpha):.0f} deg"
    axes.text(0.02, 0.03, where, transform=axes.transAxes, fontsize=8, color=ROPE)
    axes.set(xlabel="x [mm]", ylabel="z [mm]")
    axes.legend(frameon=False, fontsize=7, loc="best", ncols=2)
    axes.spines[["top", "right"]].set_visible(False)


def _concurrent_pose(layout: Layout) -> tuple[float, float, float]:
    """A singular pose that can be seen: of ordinary lengths, the one whose limbs differ most in direction."""
    middle = sum(layout.reach) / 2.0
    angles, heights = np.meshgrid(np.radians(np.arange(-85.0, 86.0)), np.linspace(0.3 * middle, middle, 61))
    x = singular_x(layout, heights, angles)
    poses = np.stack((x, heights, angles), axis=-1).reshape(-1, 3)
    poses = poses[np.isfinite(poses[:, 0])]
    vectors = limb_vectors(layout, poses)
    lengths = np.linalg.norm(vectors, axis=-1)
    n = vectors / lengths[..., None]
    sines = [np.abs(n[:, i, 0] * n[:, j, 1] - n[:, i, 1] * n[:, j, 0]) for i, j in ((0, 1), (1, 2), (0, 2))]
    ordinary = (lengths > 0.6 * layout.reach[0]).all(axis=-1) & (lengths < 1.2 * layout.reach[1]).all(axis=-1)
    x, w, alpha = poses[int(np.argmax(np.where(ordinary, np.min(sines, axis=0), -1.0)))].tolist()
    return x, w, alpha
