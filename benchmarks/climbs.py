"""Climbs in physics against their plans and statics: every built-in run, the heaviest loads, the errors of sensors.

The first table climbs each built-in run of pipes once from end to end. Statics are the balance of the robot's weight
over the pads of the gripper that holds alone, at the beginnings and ends of the plan's moves. The second seeks the
heaviest load that climbs two strides, by the planner and in physics. The third varies what the sensors get wrong and
what the grippers take to close. The fourth plans random runs that the robot cannot climb, the reason included. Forty
minutes on one core.

    python benchmarks/climbs.py [runs] [loads] [changes] [refusals]
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from msgspec.structs import replace as changed

from steeplejack.planning.climb import ClimbPlan, plan_climb
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import footing, lines_under
from steeplejack.planning.climb.planner import climb as plan_of
from steeplejack.robots.pipe_climber import BUILT_IN, Layout, PipeClimber, load_pipe_climber
from steeplejack.robots.pipe_climber.grippers import free_gripper
from steeplejack.robots.pipe_climber.pads import grip_body, grip_use, pad_row
from steeplejack.robots.pipe_climber.weights import grip_loads
from steeplejack.runtime.climb_record import EndRecord
from steeplejack.simulation.climber.pipe import lower_frame, resting, solids_of
from steeplejack.simulation.climber.plant import ClimberPlant, Start
from steeplejack.simulation.climber.run import ClimbRun
from steeplejack.simulation.climber.sensors import SensorErrors
from steeplejack.simulation.climber.watch import Watch
from steeplejack.worksite.pipe_builtin import PIPES, load_pipe
from steeplejack.worksite.pipe_generate import random_pipes
from steeplejack.worksite.pipe_run import PipeRun, build_run

SEED = 0  # of the sensors' errors, as `steeplejack climb` has it
FRICTION = (0.3, 0.6, 0.8)
MOST, HALVINGS = 8.0, 7  # [kg], and how often it is halved
REFUSED = (5, 25, 47, 77, 110, 141, 169, 221, 277)  # seeds of random runs
STRIDES = 3  # of the vertical pipe that the third table climbs


@dataclass(frozen=True)
class Climb:
    """A climb and what was seen of it."""

    end: EndRecord
    watch: Watch

    def pose_error(self) -> tuple[float, float]:
        """Largest at the moments of gripping [mm, deg]."""
        grips = self.watch.grips
        away, turned = (
            max((getattr(one, name) for one in grips), default=math.nan) for name in ("error_m", "error_rad")
        )
        return 1e3 * away, math.degrees(turned)

    def place_errors(self) -> tuple[float, float]:
        """Of grippers on their pipes: the largest, and that at the end [mm]."""
        errors = [1e3 * one.place_error_m for one in self.watch.grips] or [math.nan]
        return max(errors), max(errors[-2:])

    def passed(self) -> float:
        """How far a pipe has passed through a closed gripper at most [mm]."""
        return 1e3 * max(max(one.slip_m) for one in self.watch.samples)

    def force(self) -> float:
        """Largest force of a cylinder, moments between samples included [N]."""
        return max(one.max_force_n for one in self.watch.samples)

    def least_left(self, moving: bool) -> float:
        """Friction left while one gripper holds and the robot moves, or as grips change."""
        samples = [one for one in self.watch.samples if (one.act == "move") is moving]
        return min((one for sample in samples for one in sample.margin if one is not None), default=math.nan)


def climb(
    plan: ClimbPlan,
    run: PipeRun,
    robot: PipeClimber,
    mu: float,
    load: float = 0.0,
    times: float = 1.0,
    seed: int = SEED,
) -> Climb:
    """Run a plan in physics, the sensors' errors so many times their tolerances."""
    first = plan.phases[0]
    under, _rows = resting(run, first, robot)
    start = Start(lower_frame(run, first, pad_row(robot)), np.array(first.start), under)
    errors, layout = SensorErrors.drawn(np.random.default_rng(seed), times), Layout.of(robot)
    plant = ClimberPlant(robot, layout, solids_of(run), np.array(run.gravity), start, (mu, mu), load, errors)
    watch = Watch(plant, run, None)
    return Climb(ClimbRun(plan, run, robot, layout, plant, watch).run(lambda _time: None), watch)


def gripping(robot: PipeClimber, mu: float) -> PipeClimber:
    """The robot with pads of another friction."""
    return changed(robot, gripper=changed(robot.gripper, friction=mu))


def statics(plan: ClimbPlan, run: PipeRun, robot: PipeClimber) -> float:
    """Least friction that the weight leaves to the gripper that holds alone where moves begin and end."""
    machine, layout, left = Machine.of(robot), Layout.of(robot), 1.0
    for phase, after in zip(plan.phases[:-1], plan.phases[1:], strict=True):
        if phase.kind != "move":
            continue
        for at, pose in ((phase, phase.start), (after, phase.end)):
            end = 0 if phase.hold.value == "lower" else 1
            frame = lower_frame(run, at, machine.row)
            loads = grip_loads(robot, layout, np.array(pose), np.array(run.gravity) @ frame[:3, :3])
            name, s = ((at.pipe_lower, at.s_lower), (at.pipe_upper, at.s_upper))[end]
            pipe, place = run.pipe(name), np.array([s])
            radius, rows = footing(machine, pipe, place)[0]
            held = frame @ free_gripper(np.array(pose), machine.claw_offset) if end else frame
            lines = lines_under(machine, pipe, place)[0] @ held[:3, :3]
            left = min(left, 1.0 - float(grip_use(grip_body(robot, float(radius), int(rows), lines), loads[end])))
    return left


def runs_table() -> None:
    """Every built-in run that the robot climbs, from end to end."""
    print("| run | way | time planned, taken | speed | pose at gripping | place, worst and last | through a closed "
          "grip | largest force | friction left: statics | moving | changing |")  # fmt: skip
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |", flush=True)
    for name in PIPES:
        run_row(name)
    run_row("reducer", mu=0.7)
    run_row("planar-cross", "pipe-climber-cross")
    run_row("planar-cross", "pipe-climber-cross", clock=0.0)


def run_row(name: str, machine: str = BUILT_IN, mu: float | None = None, clock: float | None = None) -> None:
    """One run, planned and climbed, on the friction of the robot file or another one, from its clock or another one."""
    run, robot = load_pipe(name), load_pipe_climber(machine)
    what = f"`{name}`" + ("" if machine == BUILT_IN else f", `{machine}`")
    what += ("" if mu is None else f", friction {mu:g}") + ("" if clock is None else f", begun at clock {clock:g}")
    run = run if clock is None else replace(run, start_clock=clock)
    robot = robot if mu is None else gripping(robot, mu)
    plan = plan_climb(run, robot)
    if not plan.complete:
        print(f"| {what} | refused: {plan.blocked} |", flush=True)
        return
    one = climb(plan, run, robot, robot.gripper.friction)
    end, (away, turned), (worst, last) = one.end, one.pose_error(), one.place_errors()
    ended = "" if end.completed else f" {end.why}"
    trouble = f" {end.slips} slips, {end.collisions} touched" if end.slips or end.collisions else ""
    print(
        f"| {what}{ended}{trouble} | {end.travelled_m:.3f} m | {plan.duration:.1f} s, {end.duration_s:.1f} s | "
        f"{1e3 * end.travelled_m / end.duration_s:.2f} mm/s | {away:.2f} mm, {turned:.2f} deg | "
        f"{worst:.2f} mm, {last:.2f} mm | {one.passed():.2f} mm | {one.force():.1f} N | "
        f"{statics(plan, run, robot):.2f} | {one.least_left(True):.2f} | {one.least_left(False):.2f} |",
        flush=True,
    )


def heaviest(climbs: Callable[[float], bool]) -> float:
    """The largest load from 0 to `MOST` that climbs [kg]; NaN if not even 0 does."""
    if not climbs(0.0):
        return math.nan
    low, high = 0.0, MOST
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if climbs(middle) else (low, middle)
    return low


def loads_table() -> None:
    """The heaviest load up two strides of a vertical pipe, in which either gripper holds: planned and in physics."""
    print(f"\nHeaviest load, to {MOST / 2**HALVINGS:.2f} kg:\n")
    print("| friction | as planned | in physics |\n| ---: | ---: | ---: |", flush=True)
    robot = load_pipe_climber()
    whole = load_pipe("straight-vertical")
    run = replace(whole, goal_s=whole.start_s + 2.0 * robot.cylinders.stroke)
    plan = plan_climb(run, robot)
    for mu in FRICTION:
        machine = gripping(robot, mu)
        planned = heaviest(lambda load, machine=machine: plan_of(run, Machine.of(machine, load)).complete)

        def climbs(load: float, mu: float = mu) -> bool:
            end = climb(plan, run, robot, mu, load).end
            return end.completed and end.slips == 0

        print(f"| {mu:g} | {planned:.2f} kg | {heaviest(climbs):.2f} kg |", flush=True)


def changes_table() -> None:
    """A vertical pipe with other errors of the sensors, and with slower grippers."""
    print("\n| what | speed | pose at gripping | place at the end | friction left moving | changing |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    plain = load_pipe_climber()
    whole = load_pipe("straight-vertical")
    run = replace(whole, goal_s=whole.start_s + STRIDES * plain.cylinders.stroke)
    cases = [(f"sensors' errors {times:g} times, seed {seed}", plain, times, seed)
             for times, seed in ((0.0, 0), (1.0, 0), (1.0, 1), (2.0, 1), (2.0, 0))]  # fmt: skip
    for close in (0.1, 0.2):
        slow = changed(plain, gripper=changed(plain.gripper, close_time=close))
        cases.append((f"grippers that take {close:g} s", slow, 1.0, 0))
    for what, robot, times, seed in cases:
        one = climb(plan_climb(run, robot), run, robot, robot.gripper.friction, times=times, seed=seed)
        away, turned = one.pose_error()
        ended = "" if one.end.completed and not one.end.slips else f": {one.end.slips} slips {one.end.why}"
        print(f"| {what}{ended} | {1e3 * one.end.travelled_m / one.end.duration_s:.2f} mm/s | {away:.2f} mm, "
              f"{turned:.2f} deg | {one.place_errors()[1]:.2f} mm | {one.least_left(True):.2f} | "
              f"{one.least_left(False):.2f} |", flush=True)  # fmt: skip


def refusals_table() -> None:
    """What plan and reason take of one core on random runs with bends and obstacles."""
    print("\n| random run | time | answer |")
    print("| --- | ---: | --- |", flush=True)
    for seed in REFUSED:
        name = f"random-{seed}"
        run = build_run(random_pipes(np.random.default_rng(seed), name), name)
        began = time.process_time()
        plan = plan_climb(run, load_pipe_climber())
        print(f"| {seed} | {time.process_time() - began:.0f} s | {plan.blocked or 'climbed'} |", flush=True)


TABLES = {"runs": runs_table, "loads": loads_table, "changes": changes_table, "refusals": refusals_table}


if __name__ == "__main__":
    for wanted in sys.argv[1:] or TABLES:
        TABLES[wanted]()
