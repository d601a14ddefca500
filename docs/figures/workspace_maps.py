"""Draws docs/workspace_maps.png: maps of closure, margin and certified boxes of spatial robots beside each other.

python docs/workspace_maps.py
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.collections import PolyCollection

from steeplejack.mechanics.cable import (
    Label,
    certify_orientations,
    gravity_wrench,
    pose_question,
    spatial_closure_map,
    spatial_feasibility_map,
)
from steeplejack.robots.cable_robot import load_cable_robot

COLOURS = {Label.INSIDE: "#2f7f5f", Label.OUTSIDE: "#f3f1ec", Label.UNDECIDED: "#d1495b"}
HEIGHT, TILT = 2.0, np.deg2rad(2.0)


def nodes(x, y):
    """Positions of a horizontal grid."""
    across, along = np.meshgrid(x, y)
    return np.stack((across, along, np.full(across.shape, HEIGHT)), axis=-1)


def frame(axes, robot, title: str) -> None:
    """Anchors seen from above, equal scales, labels."""
    axes.plot(*robot.anchors[:, :2].T, "k^", markersize=5.0)
    axes.set_aspect("equal")
    axes.set_title(title, fontsize=10)
    axes.set_xlabel("x [m]")


def draw_closure(axes) -> None:
    """Tension factor of IPAnema 2 in a horizontal plane."""
    robot = load_cable_robot("ipanema-2")
    x, y = np.linspace(-4.3, 4.3, 260), np.linspace(-3.3, 3.3, 200)
    turn = np.array([[np.cos(0.1), -np.sin(0.1), 0.0], [np.sin(0.1), np.cos(0.1), 0.0], [0.0, 0.0, 1.0]])
    factors = spatial_closure_map(robot.anchors, robot.attachments, nodes(x, y), turn)
    image = axes.pcolormesh(x, y, np.where(factors > 0.0, factors, np.nan), cmap="viridis", rasterized=True)
    axes.figure.colorbar(image, ax=axes, shrink=0.6, label="tension factor [1]")
    frame(axes, robot, "IPAnema 2, closure, heading 0.1 rad")
    axes.set_ylabel("y [m]")


def draw_margin(axes, robot, x, y) -> None:
    """Capacity margin of CoGiRo under its own weight in the same plane."""
    weight = gravity_wrench(robot.mass, [0.0, 0.0, -9.81], robot.centre_of_mass)
    found = spatial_feasibility_map(
        robot.anchors, robot.attachments, nodes(x, y), np.eye(3), robot.lower, robot.upper, weight
    )
    image = axes.pcolormesh(
        x, y, np.where(found.feasible, found.margin, np.nan), cmap="viridis", vmin=0.0, rasterized=True
    )
    axes.figure.colorbar(image, ax=axes, shrink=0.6, label="capacity margin [N]")
    frame(axes, robot, "CoGiRo, own weight, level")


def draw_boxes(axes, robot, x, y) -> None:
    """What is proved of the same plane for every tilt of two degrees."""
    weight = [0.0, 0.0, 0.0, 0.0, 0.0, -9.81 * robot.mass]
    question = pose_question(
        robot.anchors, robot.attachments, None, weight, robot.lower, robot.upper, robot.centre_of_mass
    )
    turns = [[-TILT, TILT], [-TILT, TILT], [0.0, 0.0]]
    region = certify_orientations(question, [[x[0], x[-1]], [y[0], y[-1]], [HEIGHT, HEIGHT]], turns, 0.05, 40_000)
    for label in Label:
        (left, right), (low, high) = np.moveaxis(region.of(label)[:, :2], 0, -1)
        corners = [np.stack(corner, axis=-1) for corner in ((left, low), (right, low), (right, high), (left, high))]
        boxes = PolyCollection(np.stack(corners, axis=1), facecolor=COLOURS[label], edgecolor="#8a8a8a", linewidth=0.15)
        boxes.set_label(label.name.lower())
        axes.add_collection(boxes)
    axes.legend(loc="center", fontsize=8)
    frame(axes, robot, f"proved for all tilts within 2°: {region.inner:.1f} to {region.outer:.1f} m²")


def main() -> None:
    """The three panels."""
    mpl.use("Agg")
    robot = load_cable_robot("cogiro")
    x, y = np.linspace(-8.0, 8.0, 200), np.linspace(-6.0, 6.0, 150)
    figure, panels = plt.subplots(1, 3, figsize=(14.0, 3.6), layout="constrained")
    draw_closure(panels[0])
    draw_margin(panels[1], robot, x, y)
    draw_boxes(panels[2], robot, x, y)
    for axes in panels[1:]:
        axes.set_xlim(-8.2, 8.2)
        axes.set_ylim(-6.2, 6.2)
    figure.savefig(Path(__file__).parents[1] / "workspace_maps.png", dpi=110)


if __name__ == "__main__":
    main()
