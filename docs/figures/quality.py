"""Draw the figure of the page on quality: six measures of the robot of Table III over its poses at 50 deg.

python docs/figures/quality.py [file]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

from steeplejack.mechanics.cable import (
    cable_rates,
    capacity_margin,
    characteristic_length,
    condition_number,
    dexterity,
    distribute,
    gradient,
    natural_modes,
    planar_stiffness,
    planar_structure_derivatives,
    tension_factor,
    tension_factor_slope,
)
from steeplejack.robots.cable_robot import load_cable_robot

PHI = np.deg2rad(50.0)
GRAVITY = np.array([0.0, -9.81])  # [m/s2]
AXIAL = 1e5  # [N] EA of the cables, an assumption
POSE = np.array([-0.1, 0.42, PHI])  # where the arrows are drawn
OUT = Path(__file__).parents[1] / "quality.png"


def measures(robot, poses):
    """Values over the grid by title; not a number where the measure has no meaning."""
    structure, length = robot.structure(poses), characteristic_length(robot.attachments)
    factor, load = tension_factor(structure), robot.weight(GRAVITY, poses)
    margin = capacity_margin(structure, robot.lower, robot.upper, load, length)
    held = distribute(structure, load, robot.lower, robot.upper, "max-margin")
    rates = cable_rates(AXIAL, robot.lengths(poses), held.tensions)
    stiffness = planar_stiffness(robot.anchors, robot.attachments, poses, held.tensions, rates, robot.mass * GRAVITY)
    slowest = natural_modes(stiffness, robot.mass_matrix(poses)).frequencies[..., 0]
    least = np.linalg.eigvalsh(stiffness[..., :2, :2])[..., 0]
    return {
        "tension factor [1]": np.where(factor > 0.0, factor, np.nan),
        "capacity margin [N]": np.where(margin >= 0.0, margin, np.nan),
        "condition number [1]": np.minimum(condition_number(structure, length), 20.0),
        "dexterity [1]": dexterity(structure, length),
        "least translational stiffness [kN/m]": np.where(held.feasible, least / 1e3, np.nan),
        "slowest natural frequency [Hz]": np.where(held.feasible, slowest, np.nan),
    }


def main() -> None:
    """Draw the six panels, and on the first how moving each anchor would change the tension factor."""
    robot = load_cable_robot("ccrobot-s-planar")
    x, y = np.meshgrid(np.linspace(-0.62, 0.4, 69), np.linspace(-0.12, 0.9, 69))
    shown = measures(robot, np.stack((x, y, np.full_like(x, PHI)), axis=-1))
    figure, grid = plt.subplots(2, 3, figsize=(12.5, 7.6), sharex=True, sharey=True, layout="constrained")
    for axes, (title, values) in zip(grid.ravel(), shown.items(), strict=True):
        shades = axes.contourf(x, y, values, levels=14, cmap="viridis")
        figure.colorbar(shades, ax=axes, shrink=0.85)
        axes.plot(*robot.anchors.T, "s", color="black", ms=5)
        axes.set(title=title, aspect="equal")
    slope = tension_factor_slope(robot.structure(POSE))
    rise = gradient(slope, planar_structure_derivatives(robot.anchors, robot.attachments, POSE))
    first = grid[0, 0]
    first.plot(*POSE[:2], "o", color="white", mec="black", ms=6)
    steps = 0.3 * rise.anchors / np.linalg.norm(rise.anchors, axis=1).max()
    first.quiver(*robot.anchors.T, *steps.T, angles="xy", scale_units="xy", scale=1.0, color="#d1495b", width=0.012)
    first.set(xlim=(-0.78, 0.6), ylim=(-0.16, 1.06))
    figure.supxlabel("x [m]", fontsize=10)
    figure.supylabel("y [m]", fontsize=10)
    figure.savefig(Path(sys.argv[1]) if len(sys.argv) > 1 else OUT, dpi=100)


if __name__ == "__main__":
    main()
