"""Machines, and a search by random sampling that knows nothing of the planner: the oracle of "cannot pass".

Run as a script it tries 500 random runs: every plan is replayed, every refusal is attacked.
"""

from __future__ import annotations

import math
import sys
import time

import msgspec
import numpy as np

from steeplejack.planning.climb import ClimbPlan, faults
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import passes, trouble
from steeplejack.planning.climb.planner import as_plan, climb
from steeplejack.robots.pipe_climber import Layout, PipeClimber, load_pipe_climber
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.singularity import determinant
from steeplejack.worksite.pipe_generate import random_pipes
from steeplejack.worksite.pipe_run import PipeRun, build_run

ROBOT = load_pipe_climber()
SPACING = 0.002  # [m] between places the sampling looks at on its way


def changed(robot: PipeClimber, table: str, **values: object) -> PipeClimber:
    return msgspec.structs.replace(robot, **{table: msgspec.structs.replace(getattr(robot, table), **values)})


def analysed(tilt_deg: float = 30.0, claw_offset: float = 0.0) -> PipeClimber:
    """The mechanism as the paper analyses it: every cylinder free over the reach of 120 to 240 mm."""
    robot = changed(ROBOT, "cylinders", retracted=(0.12, 0.12, 0.12), stroke=0.12)
    robot = changed(robot, "joints", limit=math.radians(tilt_deg) * (1.0 + 1e-9))
    return changed(robot, "linkage", claw_offset=claw_offset)


def random_run(seed: int) -> PipeRun:
    return build_run(random_pipes(np.random.default_rng(seed), f"random-{seed}"), f"random-{seed}")


class Sampler:
    """A tree of standings on the main pipe grown by random moves; clocks are any, of the upper gripper or the bend."""

    def __init__(self, run: PipeRun, robot: PipeClimber, rng: np.random.Generator) -> None:
        self.run, self.machine, self.rng = run, Machine.of(robot), rng
        self.robot, self.layout, self.pipe = robot, Layout.of(robot), run.pipes[0]
        self.low = np.array(robot.cylinders.retracted)
        self.high = self.low + robot.cylinders.stroke
        self.side = np.sign(determinant(self.layout, np.array(robot.joints.home)))

    def poses(self, lower: np.ndarray, upper: np.ndarray, clock: float) -> tuple[np.ndarray, np.ndarray]:
        """Poses that join places with the mechanism at a clock, and whether it can take them."""
        p0, f0 = self.pipe.centre_line(lower)
        p1, f1 = self.pipe.centre_line(upper)
        c, s = math.cos(clock), math.sin(clock)
        base = f0 @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        p = np.einsum("kji,kj->ki", base, p1 - p0)
        turn = np.einsum("kji,kjl->kil", base, f1)
        alpha = np.arctan2(turn[:, 0, 2], turn[:, 2, 2])
        hz = self.robot.linkage.claw_offset
        pose = np.stack((p[:, 0] - hz * np.sin(alpha), p[:, 2] - hz * np.cos(alpha), alpha), axis=-1)
        q = limb_lengths(self.layout, pose)
        good = (np.abs(p[:, 1]) < 1e-6) & (np.abs(turn[:, 1, 2]) < 1e-6)
        good &= ((q > self.low - 1e-9) & (q < self.high + 1e-9)).all(axis=1)
        good &= (np.abs(alpha) <= self.robot.joints.limit + 1e-9) & (pose[:, 1] > 0.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            good &= self.side * determinant(self.layout, pose) > 0.0
        return pose, good

    def holds(self, s: float) -> bool:
        """Whether a gripper may close at a place."""
        return not any(at[0] for _why, at in trouble(self.run, self.machine, self.pipe, np.array([s])))

    def moved(self, state: tuple[float, float, float, float]) -> tuple[float, float, float, float] | None:
        """A random move from (s_lower, s_upper, clock_lower, clock_upper), or None where it cannot be made."""
        low, high, lower, upper = state
        rng, limit = self.rng, self.robot.rcm.limit
        if rng.random() < 0.5:  # the upper gripper
            goal = low + rng.uniform(0.08, 0.28)
            clock = upper if rng.random() < 0.5 else lower + rng.uniform(-limit, limit)
            if rng.random() < 0.3:
                clock = self._useful(lower, limit, upper)
            new = (low, goal, lower, clock)
            way = np.linspace(high, goal, max(2, math.ceil(abs(goal - high) / SPACING)))
            fixed = np.full(len(way), low)
            if clock != upper:  # turning wants one straight
                if not (self.poses(fixed, way, lower + 0.3)[1].all() and self.poses(fixed, way, lower + 1.3)[1].all()):
                    return None
            elif not self.poses(fixed, way, upper)[1].all():
                return None
            first, last = upper, clock
        else:
            goal = high - rng.uniform(0.08, 0.28)
            clock = lower if rng.random() < 0.5 else upper + rng.uniform(-limit, limit)
            new = (goal, high, clock, upper)
            way = np.linspace(low, goal, max(2, math.ceil(abs(goal - low) / SPACING)))
            if not self.poses(way, np.full(len(way), high), upper)[1].all():
                return None
            first, last = lower, clock
        if not self.holds(goal) or abs(new[3] - new[2]) > limit + 1e-9:
            return None
        middle, spread = np.array([0.5 * (first + last)]), 0.5 * abs(last - first)
        return new if passes(self.run, self.machine, self.pipe, way, middle, spread).all() else None

    def _useful(self, lower: float, limit: float, otherwise: float) -> float:
        """A clock of a bend within the linkage's range."""
        clocks = [part.toward + half * math.pi for part in self.pipe.parts if not part.straight for half in (0, 1)]
        turns = [(clock - lower + math.pi) % (2.0 * math.pi) - math.pi for clock in clocks]
        near = [lower + turn for turn in turns if abs(turn) <= limit]
        return near[int(self.rng.integers(len(near)))] if near else otherwise

    def furthest(self, tries: int, states: list[tuple[float, float, float, float]]) -> float:
        """How far the lower gripper comes from given standings [m]."""
        best = max(state[0] for state in states)
        for _ in range(tries):
            order = sorted(range(len(states)), key=lambda k: -states[k][0] - states[k][1])
            pick = states[order[min(len(order) - 1, int(self.rng.exponential(6.0)))]]
            new = self.moved(pick)
            if new is not None:
                states.append(new)
                best = max(best, new[0])
                if len(states) > 200:
                    states.sort(key=lambda state: -state[0] - state[1])
                    del states[100 : len(states) - 50]
        return best


def attacked(run: PipeRun, robot: PipeClimber, plan: ClimbPlan, rng: np.random.Generator, tries: int) -> float:
    """How far sampling comes from every standing of a plan that was refused [m]."""
    sampler = Sampler(run, robot, rng)
    states = [
        (phase.s_lower, phase.s_upper, phase.clock, phase.clock + phase.start[3])
        for phase in plan.phases
        if phase.kind.startswith("release") and phase.pipe_lower == phase.pipe_upper == "main"
    ]
    if plan.phases and plan.phases[-1].pipe_lower == plan.phases[-1].pipe_upper == "main":
        last = plan.phases[-1]
        states.append((last.s_lower, last.s_upper, last.clock, last.clock + last.end[3]))
    if not states:
        # Not a step: any standing with the lower gripper at the start.
        for gap in np.linspace(0.1, 0.3, 201):
            start = (run.start_s, run.start_s + float(gap), run.start_clock, run.start_clock)
            good = sampler.poses(np.array([start[0]]), np.array([start[1]]), start[3])[1][0]
            if good and sampler.holds(start[0]) and sampler.holds(start[1]):
                states.append(start)
    return sampler.furthest(tries, states) if states else run.start_s


def trial(seed: int, tries: int) -> tuple[bool, list[str]]:
    """One random run: whether it was climbed, and what is wrong with the answer."""
    run = random_run(seed)
    machine = Machine.of(ROBOT)
    plan = as_plan(run, machine, climb(run, machine), None)
    wrong = faults(plan, run, ROBOT)
    if not plan.complete:
        far = attacked(run, ROBOT, plan, np.random.default_rng(seed), tries)
        if far > run.start_s + plan.reached_m + 0.003:
            wrong.append(f"sampling comes to {far:.4f} m, the plan to {run.start_s + plan.reached_m:.4f} m")
    return plan.complete, wrong


if __name__ == "__main__":
    first, count, most = (int(word) for word in sys.argv[1:4]) if len(sys.argv) > 3 else (0, 500, 1500)
    began, passed = time.perf_counter(), 0
    for number in range(first, first + count):
        complete, wrong = trial(number, most)
        passed += complete
        if wrong:
            print(number, complete, wrong, flush=True)
    print(f"{passed} of {count} climbed, the rest refused; {time.perf_counter() - began:.0f} s")
