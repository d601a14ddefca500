"""Draw the figure of the page on cable robots: what CoGiRo holds and how fast it vibrates, in a slice at 2 m."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from steeplejack.mechanics.cable import (
    capacity_margin_slope,
    distribute,
    gradient,
    natural_modes,
    spatial_structure_derivatives,
    spatial_weight_derivative,
)
from steeplejack.robots.cable_robot import load_cable_robot

HEIGHT, LENGTH = 2.0, 0.7  # [m] of the slice, and the characteristic length
OUT = Path(__file__).parents[1] / "cable-robots.png"


def main() -> None:
    """Write the figure beside the page."""
    robot, gravity, turn = load_cable_robot("cogiro"), np.array([0.0, 0.0, -9.81]), np.eye(3)
    x, y = np.meshgrid(np.linspace(-7.0, 7.0, 57), np.linspace(-5.2, 5.2, 43))
    places = np.stack((x, y, np.full_like(x, HEIGHT)), axis=-1)
    structure, weight = robot.structure(places, turn), robot.weight(gravity, places, turn)
    slope = capacity_margin_slope(structure, weight, robot.lower, robot.upper, LENGTH)
    derivatives = spatial_structure_derivatives(robot.anchors, robot.attachments, places, turn)
    rise = gradient(slope, derivatives, spatial_weight_derivative(robot.mass * gravity, robot.centre_of_mass, turn))
    held = distribute(structure, weight, robot.lower, robot.upper, "max-margin")
    stiffness = robot.stiffness(held.tensions, gravity, places, turn)
    slowest = natural_modes(stiffness, robot.mass_matrix(places, turn)).frequencies[..., 0]
    slowest = np.where(held.feasible, slowest, np.nan)

    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.4), layout="constrained", sharey=True)
    shades = left.contourf(x, y, slope.value, levels=np.arange(0.0, slope.value.max() + 40.0, 40.0), cmap="viridis")
    figure.colorbar(shades, ax=left, shrink=0.75, label="capacity margin [N]")
    some = (slice(2, None, 5), slice(2, None, 5))
    arrows = np.where(slope.value[..., None] >= 0.0, rise.pose[..., 3:5], np.nan)[some]
    left.quiver(x[some], y[some], arrows[..., 0], arrows[..., 1], color="white", width=0.004)
    shades = right.contourf(x, y, slowest, levels=12, cmap="magma")
    figure.colorbar(shades, ax=right, shrink=0.75, label="slowest natural frequency [Hz]")
    for axes, title in ((left, "what it can still hold, and where it gains"), (right, "how it vibrates")):
        axes.plot(*robot.anchors[:, :2].T, "s", color="black", markersize=4)
        axes.set(xlabel="x [m]", aspect="equal", title=title)
    left.set_ylabel("y [m]")
    figure.savefig(OUT, dpi=110)


if __name__ == "__main__":
    main()
