"""Draw the figure of the page on wrench closure: who holds what at which pose, and why a load is too much."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from steeplejack.mechanics.cable import TaskWrenches, available_wrench_set, wrench_closure, wrench_feasible
from steeplejack.robots.cable_robot import load_cable_robot

OUT = Path(__file__).parents[1] / "wrench_closure.svg"
PHI = np.deg2rad(50.0)
GRAVITY = [0.0, -9.81]
WIND, TORQUE = 20.0, 0.5  # [N], [N m] either way
POSE = [-0.10, 0.45, PHI]


def poses(axes, robot):
    """Where every wrench, the weight, and the weight with wind are held."""
    x, y = np.meshgrid(np.linspace(-0.65, 0.45, 331), np.linspace(-0.2, 0.95, 346))
    pose = np.stack((x, y, np.full_like(x, PHI)), axis=-1)
    structure, weight = robot.structure(pose), robot.weight(GRAVITY, pose)
    gusts = np.array([WIND, WIND, TORQUE])
    windy = TaskWrenches.box(weight - gusts, weight + gusts)
    still = wrench_feasible(structure, robot.lower, robot.upper, weight).feasible
    blown = wrench_feasible(structure, robot.lower, robot.upper, windy).feasible
    axes.contourf(x, y, still.astype(float) + blown, levels=[0.5, 1.5, 2.5], colors=["#c6dbef", "#6baed6"])
    axes.contour(x, y, wrench_closure(structure).inside, levels=[0.5], colors="black", linewidths=1.2)
    axes.plot(*robot.anchors.T, "s", color="black", markersize=5)
    axes.plot(*POSE[:2], "x", color="#cb181d", markersize=8, markeredgewidth=2)
    arrow = {"arrowstyle": "-", "linewidth": 0.7}
    for text, place, at in (
        ("every wrench, if\ntight enough", (0.06, 0.66), (-0.05, 0.59)),
        ("30 kg within\n10 to 250 N", (-0.6, 0.02), (-0.25, 0.1)),
        ("30 kg and gusts", (0.08, -0.12), (-0.12, 0.05)),
    ):
        axes.annotate(text, at, place, fontsize=8, arrowprops=arrow)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="poses at 50 degrees")


def loads(axes, robot):
    """The forces the cables can balance at one pose without a moment, two loads, and the certificate of one."""
    structure = robot.structure(POSE)
    able = available_wrench_set(structure, robot.lower, robot.upper)
    x, y = np.meshgrid(np.linspace(-420.0, 420.0, 421), np.linspace(-420.0, 420.0, 421))
    load = np.stack((x, y, np.zeros_like(x)), axis=-1)
    room = (able.reaches + load @ able.normals.T).min(axis=-1)
    axes.contourf(x, y, room, levels=[0.0, 1e9], colors=["#c6dbef"])
    for mass, colour in ((8.0, "#238b45"), (30.0, "#cb181d")):
        weight = np.array([0.0, -9.81 * mass, 0.0])
        answer = wrench_feasible(structure, robot.lower, robot.upper, weight)
        axes.plot(*weight[:2], "o", color=colour, markersize=5)
        axes.annotate(f"  {mass:.0f} kg, margin {answer.margin:.0f} N", weight[:2], color=colour, fontsize=8)
        if not answer.feasible:
            z = answer.certificate
            reach = -np.where(z @ structure > 0.0, robot.lower, robot.upper) @ (z @ structure)
            axes.contour(x, y, load @ z, levels=[reach], colors=colour, linewidths=1.2, linestyles="dashed")
            axes.annotate("", weight[:2] + 70.0 * z[:2], weight[:2], arrowprops={"arrowstyle": "->", "color": colour})
    axes.set(xlabel="fx [N]", ylabel="fy [N]", aspect="equal", title="loads held at the cross, no moment")


def main() -> None:
    """Write the figure beside the page."""
    plt.rcParams["svg.hashsalt"] = "wrench closure"
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.8), layout="constrained")
    robot = load_cable_robot("ccrobot-s-planar")
    poses(left, robot)
    loads(right, robot)
    figure.savefig(OUT, metadata={"Date": None})


if __name__ == "__main__":
    main()
