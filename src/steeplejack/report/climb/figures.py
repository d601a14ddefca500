"""Figures of a climb: where it went, forces, margins, transmission, speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from steeplejack.report.climb.analysis import ClimbAnalysis
from steeplejack.report.climb.log import ClimbLog
from steeplejack.report.figures.style import BLUE, GREEN, INK, MUTED, ORANGE, VERMILION, canvas, svg, thin

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

GRIPPERS = (("lower gripper", BLUE), ("upper gripper", ORANGE))
LIMBS = (("cylinder 1", BLUE), ("cylinder 2", ORANGE), ("cylinder 3", GREEN))
DASHES = (0, (5, 2))


def progress_figure(log: ClimbLog, analysis: ClimbAnalysis) -> str:
    """How far along the pipe over time, against what the actuators bound; which grippers hold."""
    samples = log.samples
    with canvas(3.6) as figure:
        way, grips = figure.subplots(2, 1, sharex=True, height_ratios=(3.0, 0.7))
        way.plot(*thin(samples.time, samples.travelled), color=INK, label="the robot's middle")
        end = float(samples.time[-1])
        way.plot([0.0, end], [0.0, end * analysis.bound], color=VERMILION, ls=DASHES, lw=0.9,
                 label=f"bound of stroke, speed and grip times, {1e3 * analysis.bound:.2f} mm/s")  # fmt: skip
        way.set(ylabel="[m]")
        way.set_title("way along the pipe")
        way.legend(loc="upper left")
        for row, (_name, colour) in enumerate(GRIPPERS):
            grips.fill_between(samples.time, row + 0.1, row + 0.9, where=samples.closed[:, row], color=colour, lw=0.0)
        grips.set(yticks=(0.5, 1.5), yticklabels=[name for name, _ in GRIPPERS], ylim=(0, 2), xlabel="time [s]")
        grips.grid(False)
        grips.set_title("closed")
        grips.set_xlim(0.0, max(end, 1e-9))
        return svg(figure, "progress")


def loads_figure(log: ClimbLog, analysis: ClimbAnalysis) -> str:
    """Cylinder forces, gripper forces and friction margins over time, and where the margin is least."""
    samples, robot = log.samples, log.robot
    with canvas(6.4) as figure:
        force, grip, margin = figure.subplots(3, 1, sharex=True)
        _lines(force, samples.time, samples.forces, LIMBS)
        reach = max(1.15 * float(np.abs(samples.forces).max()), 1.0)
        limit = robot.cylinders.force
        if reach > 0.7 * limit:
            for sign in (-1.0, 1.0):
                force.axhline(sign * limit, color=VERMILION, lw=0.9, ls=DASHES)
        force.set(ylim=(-reach, reach), ylabel="[N]")
        force.set_title(f"forces of the cylinders, positive when pushing; limit {limit:g} N")
        _lines(grip, samples.time, samples.grip, GRIPPERS)
        grip.axhline(robot.gripper.force, color=VERMILION, lw=0.9, ls=DASHES)
        grip.set(ylabel="[N]", ylim=(0.0, 1.25 * robot.gripper.force))
        grip.set_title(f"force of a jaw, by its sensor; declared {robot.gripper.force:g} N")
        for row, (name, colour) in enumerate(GRIPPERS):
            margin.plot(samples.time, samples.margin[:, row], color=colour, lw=0.8, label=name)
        _legend(margin)
        margin.axhline(0.0, color=VERMILION, lw=0.9, ls=DASHES)
        margin.set(ylabel="[1]", ylim=(min(-0.05, 1.1 * _least(samples.margin)), 1.0), xlabel="time [s]")
        margin.set_xlim(0.0, max(float(samples.time[-1]), 1e-9))
        marks = {one: name for name, one in (("least", analysis.least), ("least moving", analysis.least_moving)) if one}
        for row, (one, name) in enumerate(marks.items()):
            margin.plot(one.time, one.margin, "o", ms=7.0, mfc="none", mec=INK, mew=1.1)
            right = one.time > 0.8 * float(samples.time[-1])
            margin.annotate(
                f"{name}: {one.margin:z.2f}, {GRIPPERS[one.gripper][0]}", (one.time, one.margin),
                xytext=(-8 if right else 8, 14 + 14 * row), textcoords="offset points", ha="right" if right else "left",
                color=INK, fontsize=8.0,
                bbox={"boxstyle": "square,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.8},
            )  # fmt: skip
        margin.set_title("friction left to the grippers that hold, force and moment together")
        return svg(figure, "loads")


def mechanism_figure(log: ClimbLog, analysis: ClimbAnalysis) -> str:
    """Transmission index and speeds of the cylinders over time, and tracking at every sample."""
    samples, robot = log.samples, log.robot
    with canvas(6.4) as figure:
        index, speed, error = figure.subplots(3, 1, sharex=True)
        index.plot(*thin(samples.time, analysis.transmission), color=INK, lw=0.9)
        index.axhline(0.5, color=MUTED, lw=0.8, ls=DASHES)
        index.set(ylim=(0.0, 1.0), ylabel="[1]")
        index.set_title("local transmission index; 0.5 is the threshold of good transmission")
        _lines(speed, samples.time, 1e3 * samples.speeds, LIMBS)
        for sign in (-1.0, 1.0):
            speed.axhline(sign * 1e3 * robot.cylinders.speed, color=VERMILION, lw=0.9, ls=DASHES)
        speed.set(ylabel="[mm/s]")
        speed.set_title(f"speeds of the cylinders; limit {1e3 * robot.cylinders.speed:g} mm/s")
        away = 1e3 * np.hypot(*(samples.actual - samples.reference)[:, :2].T)
        turned = np.degrees(np.abs((samples.actual - samples.reference)[:, 2:]).max(axis=1))
        error.plot(*thin(samples.time, away), color=BLUE, lw=0.8, label="place [mm]")
        error.plot(*thin(samples.time, turned), color=ORANGE, lw=0.8, label="turn [deg]")
        error.set(xlabel="time [s]", ylabel="[mm], [deg]", ylim=(0.0, None))
        error.set_xlim(0.0, max(float(samples.time[-1]), 1e-9))
        error.set_title("pose of the mechanism, achieved against commanded")
        _legend(error)
        return svg(figure, "mechanism")


def _lines(axes: Axes, time: Array, values: Array, names: tuple[tuple[str, str], ...]) -> None:
    """Lines over time; the first is the widest, for lines may lie on one another."""
    for column, (name, colour) in enumerate(names):
        axes.plot(*thin(time, values[:, column]), color=colour, lw=0.8 if column else 2.0, label=name)
    _legend(axes)


def _legend(axes: Axes) -> None:
    """Names of the lines beside the title."""
    axes.legend(ncols=3, loc="upper right", bbox_to_anchor=(1.0, 1.2), borderaxespad=0.0)


def _least(values: Array) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.min()) if finite.size else 0.0
