"""Draws docs/interference.png: gaps of cables to each other and to a stay, and boxes proved free.

python docs/interference_map.py
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.collections import PolyCollection

from steeplejack.mechanics.cable import Label, Surroundings, interference_gaps, interference_region
from steeplejack.robots.cable_robot import load_cable_robot

COLOURS = {Label.INSIDE: "#2f7f5f", Label.OUTSIDE: "#f3f1ec", Label.UNDECIDED: "#d1495b"}
HEIGHT, CLEARANCE = 2.0, 0.02
POLE = np.array([[[1.5, -3.0, 3.1], [1.5, 3.0, 3.3]]])


def draw_gaps(axes, surroundings: Surroundings) -> None:
    """Least gap on a grid."""
    x, y = np.linspace(-3.0, 3.0, 240), np.linspace(-2.0, 2.0, 160)
    across, along = np.meshgrid(x, y)
    gaps, _ = interference_gaps(surroundings, np.stack((across, along, np.full(across.shape, HEIGHT)), axis=-1))
    image = axes.pcolormesh(x, y, gaps, cmap="viridis", rasterized=True)
    axes.contour(x, y, gaps, levels=[CLEARANCE], colors="w", linewidths=1.0)
    axes.figure.colorbar(image, ax=axes, shrink=0.7, label="least gap [m]")
    axes.set_title("least gap; white: 2 cm", fontsize=10)


def draw_boxes(axes, surroundings: Surroundings) -> None:
    """What is proved of the same plane."""
    region = interference_region(surroundings, [[-3.0, 3.0], [-2.0, 2.0], [HEIGHT, HEIGHT]], CLEARANCE, 0.1, 200_000)
    for label in Label:
        (left, right), (low, high) = np.moveaxis(region.of(label)[:, :2], 0, -1)
        corners = [np.stack(corner, axis=-1) for corner in ((left, low), (right, low), (right, high), (left, high))]
        boxes = PolyCollection(np.stack(corners, axis=1), facecolor=COLOURS[label], edgecolor="#8a8a8a", linewidth=0.15)
        boxes.set_label({Label.INSIDE: "free", Label.OUTSIDE: "not free", Label.UNDECIDED: "undecided"}[label])
        axes.add_collection(boxes)
    axes.legend(loc="lower left", fontsize=8)
    axes.set_title(f"proved free: {region.inner:.2f} to {region.outer:.2f} m²", fontsize=10)


def main() -> None:
    """Two panels of one plane."""
    mpl.use("Agg")
    robot = load_cable_robot("ipanema-2")
    surroundings = Surroundings.of(robot.anchors, robot.attachments, np.eye(3), POLE, 0.05)
    figure, panels = plt.subplots(1, 2, figsize=(11.0, 3.8), layout="constrained", sharey=True)
    draw_gaps(panels[0], surroundings)
    draw_boxes(panels[1], surroundings)
    for axes in panels:
        axes.set_aspect("equal")
        axes.set_xlim(-3.0, 3.0)
        axes.set_ylim(-2.0, 2.0)
        axes.set_xlabel("x [m]")
    panels[0].set_ylabel("y [m]")
    figure.savefig(Path(__file__).parents[1] / "interference.png", dpi=110)


if __name__ == "__main__":
    main()
