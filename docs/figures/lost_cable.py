"""Draws docs/lost_cable.svg: what the platform of Table III does when each of its cables is lost.

python docs/lost_cable.py
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt

from steeplejack.mechanics.cable import LockedPlatform, locked_at, lost_cable

ANCHORS = np.array([[0.0, 0.0], [0.4024, 0.4045], [-0.3522, 0.8966], [-0.6244, 0.6244]])
ATTACHMENTS = np.array([[-0.095, -0.095], [0.095, -0.095], [0.095, 0.095], [-0.095, 0.095]])
WEIGHT = (0.0, -30.0 * 9.81)
PLACE, PHI = (-0.23074604, 0.55283179), np.deg2rad(50.0)
START, PATH, END, LOST = "#9aa3ad", "#7fb2e5", "#1f4e79", "#d1495b"


def outline(position, rotation):
    """The attachments in the world, closed."""
    corners = position[:2] + ATTACHMENTS @ rotation[:2, :2].T
    return np.vstack((corners, corners[:1]))


def draw(axes, cable: int) -> None:
    """One panel: from where it was (dashed) to where it settles."""
    platform = locked_at(LockedPlatform.planar(ANCHORS, ATTACHMENTS, 1.0, WEIGHT), PLACE, PHI)
    lost = lost_cable(platform, cable, PLACE, PHI)
    for k in np.linspace(0, len(lost.positions) - 1, 7).astype(int)[1:-1]:
        axes.plot(*outline(lost.positions[k], lost.rotations[k]).T, color=PATH, lw=0.7)
    axes.plot(*outline(lost.positions[0], lost.rotations[0]).T, color=START, lw=1.6, ls="--")
    axes.plot(*outline(lost.rest.position, lost.rest.rotation).T, color=END, lw=2.0)
    axes.plot(*lost.positions[:, :2].T, color=LOST, lw=1.4)
    ends = outline(lost.rest.position, lost.rest.rotation)
    for i, (anchor, end) in enumerate(zip(ANCHORS, ends, strict=False)):
        axes.plot(*anchor, "o", color="black", ms=4)
        axes.annotate(f"A{i + 1}", anchor, xytext=(5, 4), textcoords="offset points", fontsize=8)
        if i == cable:
            start = outline(lost.positions[0], lost.rotations[0])[i]
            axes.plot(*np.array([anchor, start]).T, color=LOST, lw=1.0, ls=":")
            continue
        style = "-" if lost.rest.taut[i] else (0, (1, 4))
        axes.plot(*np.array([anchor, end]).T, color=END, lw=1.1, ls=style)
        middle = 0.5 * (anchor + end)
        text = f"{lost.rest.tensions[i]:.0f} N" if lost.rest.taut[i] else "slack"
        axes.annotate(
            text, middle, fontsize=8, ha="center", bbox={"fc": "white", "ec": "none", "pad": 0.8, "alpha": 0.85}
        )
    axes.set_title(f"cable {cable + 1} lost: {100.0 * lost.drop:.1f} cm down", fontsize=10)
    axes.set_aspect("equal")
    axes.set_xlim(-0.72, 0.5)
    axes.set_ylim(-0.08, 0.98)


def main() -> None:
    """Draw all four."""
    mpl.rcParams["svg.hashsalt"] = "steeplejack"
    figure, grid = plt.subplots(2, 2, figsize=(9.0, 8.2), sharex=True, sharey=True, layout="constrained")
    for cable, axes in enumerate(grid.ravel()):
        draw(axes, cable)
    figure.supxlabel("x [m]", fontsize=9)
    figure.supylabel("y [m]", fontsize=9)
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "lost_cable.svg"
    figure.savefig(target, metadata={"Date": None} if target.suffix == ".svg" else None, dpi=110)


if __name__ == "__main__":
    main()
