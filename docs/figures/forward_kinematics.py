"""Draws docs/forward_kinematics.svg: every pose that explains three lengths over pulleys, and the one of four.

python docs/forward_kinematics.py
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt

from steeplejack.mechanics.cable import every_planar_pose, pulley_runs

ANCHORS = np.array([[-1.0, 0.9], [1.0, 1.0], [0.9, -0.9], [-0.9, -1.0]])
ATTACHMENTS = np.array([[-0.45, 0.25], [0.5, 0.35], [0.4, -0.35], [-0.35, -0.4]])
AXES = np.array([[0.0, 1.0], [0.0, 1.0], [0.0, -1.0], [0.0, -1.0]])
RADII = np.full(4, 0.06)
POSE = np.array([0.12, -0.08, 0.35])
COLOURS = ("#1f4e79", "#d1495b", "#3a7d44", "#e09f3e", "#7b5ea7", "#2aa198", "#8c564b", "#444444")


def turned(phi: float) -> np.ndarray:
    """Rotation by an angle."""
    return np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]])


def draw(axes, count: int, lengths: np.ndarray) -> None:
    """All poses that the first cables allow, proved."""
    answer = every_planar_pose(
        lengths[:count], ANCHORS[:count], ATTACHMENTS[:count], radii=RADII[:count], axes=AXES[:count]
    )
    for number, pose in enumerate(answer.pose):
        ends = pose[:2] + ATTACHMENTS @ turned(pose[2]).T
        axes.fill(*ends.T, fc=COLOURS[number], ec=COLOURS[number], alpha=0.25, lw=1.6)
        axes.fill(*ends.T, fc="none", ec=COLOURS[number], lw=1.6)
        for anchor, end in zip(ANCHORS[:count], ends, strict=False):
            axes.plot(*np.array([anchor, end]).T, color=COLOURS[number], lw=0.8)
    for i, anchor in enumerate(ANCHORS):
        used = i < count
        axes.plot(*anchor, "o", color="black" if used else "#c3cad0", ms=7, mfc="white", mew=1.6)
        axes.annotate(
            f"A{i + 1}",
            anchor,
            xytext=(0, 9 if anchor[1] > 0 else -16),
            textcoords="offset points",
            fontsize=8,
            ha="center",
        )
    verdict = "unique, proved" if answer.unique else f"{len(answer.pose)} poses, proved to be all"
    axes.set_title(f"{count} cables: {verdict} ({answer.examined} boxes)", fontsize=10)
    axes.set_aspect("equal")
    axes.set_xlim(-1.6, 1.7)
    axes.set_ylim(-1.6, 1.7)


def main() -> None:
    """Draw both."""
    mpl.rcParams["svg.hashsalt"] = "steeplejack"
    lengths, _along = pulley_runs(ANCHORS, AXES, RADII, POSE[:2] + ATTACHMENTS @ turned(POSE[2]).T)
    figure, panels = plt.subplots(1, 2, figsize=(9.4, 4.9), sharey=True, layout="constrained")
    for axes, count in zip(panels, (3, 4), strict=True):
        draw(axes, count, lengths)
    figure.supxlabel("x [m]", fontsize=9)
    figure.supylabel("y [m]", fontsize=9)
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "forward_kinematics.svg"
    figure.savefig(target, metadata={"Date": None} if target.suffix == ".svg" else None, dpi=110)


if __name__ == "__main__":
    main()
