"""Draw the figure of the heaviest load that climbs a vertical pipe: in physics, and by statics.

python docs/figures/climber_payload.py [file]

One stride is planned without a load and run in physics with loads on the upper gripper, at several coefficients of
friction; a load climbs if nothing slips and no cylinder lags. The heaviest one is found by halving. Takes some minutes.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
from matplotlib import pyplot as plt

from steeplejack.planning.climb import plan_climb
from steeplejack.planning.climb.alone import along_way, uses_alone
from steeplejack.planning.climb.limits import Machine
from steeplejack.robots.pipe_climber import Layout, PipeClimber, load_pipe_climber
from steeplejack.robots.pipe_climber.bearing import holding_forces
from steeplejack.robots.pipe_climber.pads import BOTH, STRAIGHT, grip_body, grip_use
from steeplejack.robots.pipe_climber.weights import grip_loads
from steeplejack.simulation.climber.run import ClimbRun
from steeplejack.simulation.climber.session import ClimbSession
from steeplejack.simulation.climber.watch import Watch
from steeplejack.worksite.pipe_builtin import load_pipe

OUT = Path(__file__).parents[1] / "climber-payload.png"
ROBOT = load_pipe_climber()
LAYOUT = Layout.of(ROBOT)
RUN = load_pipe("straight-vertical")
GRAVITY = np.array([0.0, 0.0, -9.81])
RADIUS = 0.5 * RUN.pipes[0].parts[0].diameter
FRICTION = (0.26, 0.3, 0.4, 0.5, 0.6, 0.8)
MOST = 8.0  # [kg]
FINE, COARSE = 16, 7  # halvings of it, by statics and in physics
INK, BLUE, ORANGE, VERMILION = "#1e2837", "#0072b2", "#e69f00", "#d55e00"


def heaviest(climbs, halvings: int = FINE) -> float:
    """The largest load from 0 to `MOST` for which ``climbs(load)`` holds [kg]; NaN if not even 0 does."""
    if not climbs(0.0):
        return np.nan
    low, high = 0.0, MOST
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if climbs(middle) else (low, middle)
    return 0.5 * (low + high)


def poses() -> np.ndarray:
    """Along the stroke, (k, 4)."""
    low = 0.150
    return np.array([[0.0, w, 0.0, 0.0] for w in np.linspace(low, low + ROBOT.cylinders.stroke, 6)])


def with_friction(mu: float) -> PipeClimber:
    """The robot with other pads."""
    return msgspec.structs.replace(ROBOT, gripper=msgspec.structs.replace(ROBOT.gripper, friction=mu))


def grip_holds(mu: float, load: float) -> bool:
    """By statics: force and moment of the weight within what the pads of either gripper give."""
    loads = grip_loads(ROBOT, LAYOUT, poses(), GRAVITY, load)
    return bool((grip_use(grip_body(with_friction(mu), RADIUS), loads) <= 1.0).all())


def planned_to_hold(mu: float, load: float) -> bool:
    """As the planner counts: with the inertia of a move's ramps, and within the reserve of the robot file."""
    machine, along = Machine.of(with_friction(mu), load), poses()
    feet = np.broadcast_to([RADIUS, float(BOTH)], (len(along), 2, 2))
    lines = np.broadcast_to(STRAIGHT, (len(along), 2, *STRAIGHT.shape))
    gravity = np.broadcast_to(GRAVITY, (len(along), 3))
    return bool((uses_alone(machine, along, gravity, feet, lines, along_way(machine, along)) <= 1.0).all())


def cylinders_hold(load: float) -> bool:
    """By statics: no cylinder beyond its force, whichever gripper holds."""
    forces = [holding_forces(ROBOT, LAYOUT, pose, GRAVITY, load) for pose in poses()]
    return bool(np.abs(forces).max() <= ROBOT.cylinders.force)


def runs(plan, mu: float, load: float) -> bool:
    """In physics: one stride without a slip."""
    session = ClimbSession(plan, RUN, ROBOT, LAYOUT, (mu, mu), load)
    plant = session.plant()
    end = ClimbRun(plan, RUN, ROBOT, LAYOUT, plant, Watch(plant, RUN, None)).run(lambda _time: None)
    print(
        f"  mu {mu:g}, {load:.3f} kg: {'climbs' if end.completed and not end.slips else end.why or 'slips'}", flush=True
    )
    return end.completed and end.slips == 0


def main() -> None:
    """Compute and draw."""
    whole = plan_climb(RUN, ROBOT)
    plan = replace(whole, phases=whole.phases[:6])
    friction = np.linspace(0.22, 0.85, 64)
    gripped = np.array([heaviest(lambda load, mu=mu: grip_holds(mu, load)) for mu in friction])
    planned = np.array([heaviest(lambda load, mu=mu: planned_to_hold(mu, load)) for mu in friction])
    pushed = heaviest(cylinders_hold)
    simulated = [heaviest(lambda load, mu=mu: runs(plan, mu, load), COARSE) for mu in FRICTION]
    for mu, there in zip(FRICTION, simulated, strict=True):
        said, meant = (
            min(heaviest(lambda load, mu=mu, holds=holds: holds(mu, load)), pushed)
            for holds in (grip_holds, planned_to_hold)
        )
        print(f"| {mu:.2f} | {there:.2f} kg | {said:.2f} kg | {meant:.2f} kg |")
    figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
    axes.plot(friction, gripped, color=BLUE, label="statics: the grip of one gripper")
    axes.plot(
        friction, planned, color=BLUE, lw=0.9, ls=(0, (2, 2)), label="the same with inertia and reserve, as planned"
    )
    axes.axhline(pushed, color=ORANGE, ls=(0, (5, 2)), label=f"statics: {ROBOT.cylinders.force:g} N of a cylinder")
    axes.plot(FRICTION, simulated, "o", color=VERMILION, label="physics: one stride without a slip")
    axes.axvline(ROBOT.gripper.friction, color=INK, lw=0.7, ls=":")
    axes.annotate("robot file", (ROBOT.gripper.friction, 0.97), xycoords=("data", "axes fraction"), va="top",
                  xytext=(4, 0), textcoords="offset points", color=INK, fontsize=8)  # fmt: skip
    axes.set(xlabel="friction of the pads [1]", ylabel="heaviest load on the upper gripper [kg]", ylim=(0.0, None))
    axes.set_xlim(friction[0], friction[-1])
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25)
    axes.legend(frameon=False, loc="lower right")
    figure.savefig(Path(sys.argv[1]) if len(sys.argv) > 1 else OUT, dpi=160)


if __name__ == "__main__":
    main()
