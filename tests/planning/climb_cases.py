"""Machines, and a search by random sampling that knows nothing of the planner: the oracle of "cannot pass".

Run as a script it tries 500 random runs: every plan is replayed, every refusal is attacked.
"""

from __future__ import annotations

import math
import sys
import time
from dataclasses import dataclass

import msgspec
import numpy as np

from steeplejack.planning.climb import ClimbPlan, faults
from steeplejack.planning.climb.collide import AIR, solids_of
from steeplejack.planning.climb.frames import touching
from steeplejack.planning.climb.grip import alone
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import passes, trouble
from steeplejack.planning.climb.planner import as_plan, climb
from steeplejack.planning.climb.search import SWING
from steeplejack.robots.pipe_climber import Layout, PipeClimber, load_pipe_climber
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.singularity import determinant
from steeplejack.worksite.pipe_generate import random_pipes
from steeplejack.worksite.pipe_run import PipeRun, build_run

ROBOT = load_pipe_climber()
SPACING = 0.002  # [m] between places the sampling looks at on its way
NEAR = 0.12  # [m] beyond the grippers, where bars can meet something
BATCH = 400  # moves tried at once
PARTS = (5, 10)  # of the stroke; the planner's finer lattice costs four times as much: where this is beaten
FURTHER = 0.003  # [m] by which sampling may come further: what a cell of the finest lattice is


def changed(robot: PipeClimber, table: str, **values: object) -> PipeClimber:
    return msgspec.structs.replace(robot, **{table: msgspec.structs.replace(getattr(robot, table), **values)})


def analysed(tilt_deg: float = 30.0, claw_offset: float = 0.0) -> PipeClimber:
    """The mechanism as the paper analyses it: every cylinder free over the reach of 120 to 240 mm."""
    robot = changed(ROBOT, "cylinders", retracted=(0.12, 0.12, 0.12), stroke=0.12)
    robot = changed(robot, "joints", limit=math.radians(tilt_deg) * (1.0 + 1e-9))
    return changed(robot, "linkage", claw_offset=claw_offset)


def random_run(seed: int) -> PipeRun:
    return build_run(random_pipes(np.random.default_rng(seed), f"random-{seed}"), f"random-{seed}")


@dataclass
class Moves:
    """Candidate moves as columns: states they begin at, where they end, and whether the upper gripper moves."""

    start: np.ndarray  # (n, 4) s_lower, s_upper, clock_lower, clock_upper
    end: np.ndarray  # (n, 4)
    upper: np.ndarray  # (n,)

    def only(self, keep: np.ndarray) -> Moves:
        """Some of the moves."""
        return Moves(self.start[keep], self.end[keep], self.upper[keep])


class Sampler:
    """A cloud of standings on the main pipe grown by random moves, some hundred at a time, to any place and clock."""

    def __init__(self, run: PipeRun, robot: PipeClimber, rng: np.random.Generator) -> None:
        self.run, self.machine, self.rng = run, Machine.of(robot), rng
        self.robot, self.layout, self.pipe = robot, Layout.of(robot), run.pipes[0]
        self.low = np.array(robot.cylinders.retracted)
        self.high = self.low + robot.cylinders.stroke
        self.side = np.sign(determinant(self.layout, np.array(robot.joints.home)))
        self.solids = solids_of(run)
        low = 0.9 * self.machine.lowest_bar - 0.5 * self.pipe.parts[0].diameter
        tall = [one for one in run.obstacles if one.height > low]
        places = [0.5 * (one.start + one.end) for one in tall] + [one.at for one in run.crossings]
        self.beside = np.array(places)  # where bars can meet something
        bends = [part.toward + k * math.pi for part in self.pipe.parts if not part.straight for k in (0, 1)]
        self.useful = np.array([*bends, run.start_clock])

    def poses(self, lower: np.ndarray, upper: np.ndarray, clock: np.ndarray) -> tuple[np.ndarray, ...]:
        """Poses that join places at clocks of the mechanism, whether it can take them, whether every clock would do."""
        p0, f0 = self.pipe.chord(lower, self.machine.row)
        p1, f1 = self.pipe.chord(upper, self.machine.row)
        base = turned(f0, clock)
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
        in_line = (np.hypot(p[:, 0], p[:, 1]) < 1e-8) & (np.hypot(turn[:, 0, 2], turn[:, 1, 2]) < 1e-8)
        return pose, good, in_line

    def uses(self, low: np.ndarray, high: np.ndarray, pose: np.ndarray, clocks: np.ndarray) -> np.ndarray:
        """Use of both grips, (k, 2), at clocks (k, 2) of the lower and the upper gripper."""
        frames = turned(self.pipe.chord(low, self.machine.row)[1], clocks[:, 0])
        gravity = np.swapaxes(frames, -1, -2) @ np.array(self.run.gravity)
        freedoms = np.column_stack((pose, clocks[:, 1] - clocks[:, 0]))
        radii = np.stack((self.pipe.radius(low), self.pipe.radius(high)), axis=-1)
        return alone(self.machine, freedoms, gravity, radii)

    def drawn(self, states: np.ndarray, count: int) -> Moves:
        """Random moves, more of them from states far on."""
        rng, limit = self.rng, self.robot.rcm.limit
        order = np.argsort(-states[:, 0] - states[:, 1], kind="stable")
        start = states[order[np.minimum(len(order) - 1, rng.exponential(8.0, count).astype(int))]]
        upper, end = rng.random(count) < 0.5, start.copy()
        least, most = self.machine.straight_gaps
        gap = rng.uniform(least - 0.02, most + 0.02, count)
        still = rng.random(count) < 0.15  # only turns
        gap = np.where(still, start[:, 1] - start[:, 0], gap)
        end[:, 0] = np.where(upper, start[:, 0], start[:, 1] - gap)
        end[:, 1] = np.where(upper, start[:, 0] + gap, start[:, 1])
        other = np.where(upper, start[:, 2], start[:, 3])
        own = np.where(upper, start[:, 3], start[:, 2])
        useful = rng.choice(self.useful, count)
        useful = own + (useful - own + math.pi) % (2.0 * math.pi) - math.pi
        how = rng.random(count)
        clock = np.where(how < 0.4, own, np.where(how < 0.6, useful, other + rng.uniform(-limit, limit, count)))
        clock = np.where(np.abs(clock - other) <= limit + 1e-9, clock, own)
        end[:, 2] = np.where(upper, start[:, 2], clock)
        end[:, 3] = np.where(upper, clock, start[:, 3])
        return Moves(start, end, upper)

    def made(self, moves: Moves) -> np.ndarray:
        """Standings at the ends of those moves that can be made, the cheap questions first."""
        pose, good, _line = self.poses(moves.end[:, 0], moves.end[:, 1], moves.end[:, 3])
        moved = np.where(moves.upper, moves.end[:, 1], moves.end[:, 0])
        good &= (moved > 0.0) & (moved < self.pipe.length)
        good &= ~np.any([at for _why, at in trouble(self.run, self.machine, self.pipe, moved)], axis=0)
        moves = moves.only(good)
        if not len(moves.end):
            return moves.end
        moves = moves.only(self._bears(moves))
        free = [self._passes(moves.only(np.array([k]))) for k in range(len(moves.end))]
        return moves.end[np.array(free, dtype=bool)]

    def _bears(self, moves: Moves) -> np.ndarray:
        """Whether every pose on the way can be taken and the other grip bears the robot there."""
        span = np.abs(moves.end[:, :2] - moves.start[:, :2]).max(axis=1)
        counts = np.maximum(2, np.ceil(span / SPACING).astype(int) + 1)
        which = np.repeat(np.arange(len(counts)), counts)
        first = np.concatenate(([0], np.cumsum(counts)[:-1]))
        share = (np.arange(len(which)) - first[which]) / (counts[which] - 1.0)
        at = moves.start[which] + share[:, None] * (moves.end - moves.start)[which]
        before, after = moves.start[which, 2:], moves.end[which, 2:]
        pose, good, in_line = self.poses(at[:, 0], at[:, 1], before[:, 1])
        turns = np.abs(after - before).max(axis=1) > 0.0
        good &= ~turns | ~moves.upper[which] | in_line  # turning the upper gripper wants one straight
        holder = np.where(moves.upper[which], 0, 1)
        share_of = np.where(turns, 1.0 / SWING, 1.0) + 1e-6
        rows = np.flatnonzero(good)
        for clocks in (before, after):
            use = self.uses(at[rows, 0], at[rows, 1], pose[rows], clocks[rows])
            good[rows] &= use[np.arange(len(rows)), holder[rows]] <= share_of[rows]
        return np.logical_and.reduceat(good, first)

    def _passes(self, move: Moves) -> bool:
        """Whether palm and bars of one move clear everything, turning at any time on the way."""
        start, end, upper = move.start[0], move.end[0], bool(move.upper[0])
        column = 1 if upper else 0
        way = np.linspace(start[column], end[column], max(2, math.ceil(abs(end[column] - start[column]) / SPACING)))
        middle = np.array([0.5 * (start[2 + column] + end[2 + column])])
        spread = 0.5 * abs(end[2 + column] - start[2 + column])
        if not passes(self.run, self.machine, self.pipe, way, middle, spread).all():
            return False
        low_end, high_end = min(start[0], end[0]) - NEAR, max(start[1], end[1]) + NEAR
        if not ((self.beside > low_end) & (self.beside < high_end)).any():
            return True
        clocks = np.linspace(start[2 + column], end[2 + column], max(1, math.ceil(spread / math.radians(2.5)) + 1))
        at, turn = (one.ravel() for one in np.meshgrid(way, clocks))
        lower, higher = (np.full_like(at, start[0]), at) if upper else (at, np.full_like(at, start[1]))
        low, high = (np.full_like(at, start[2]), turn) if upper else (turn, np.full_like(at, start[3]))
        pose = self.poses(lower, higher, high)[0]
        points, frames = self.pipe.chord(lower, self.machine.row)
        lowers = np.broadcast_to(np.eye(4), (len(at), 4, 4)).copy()
        lowers[:, :3, :3], lowers[:, :3, 3] = turned(frames, low), points
        return not touching(self.solids, self.machine, lowers, np.column_stack((pose, high - low)), AIR, True).any()

    def furthest(self, tries: int, states: list[tuple[float, float, float, float]]) -> float:
        """How far the lower gripper comes from given standings in some thousand random moves [m]."""
        cloud = np.array(states)
        for _ in range(math.ceil(tries / BATCH)):
            cloud = np.concatenate((cloud, self.made(self.drawn(cloud, BATCH))))
            if len(cloud) > 400:
                order = np.argsort(-cloud[:, 0] - cloud[:, 1], kind="stable")
                cloud = cloud[np.concatenate((order[:300], self.rng.choice(order[300:], 50)))]
        return float(cloud[:, 0].max())


def turned(frames: np.ndarray, clocks: np.ndarray) -> np.ndarray:
    """Frames (k, 3, 3) turned about their z axes."""
    c, s = np.cos(clocks)[:, None], np.sin(clocks)[:, None]
    x, y = frames[..., 0], frames[..., 1]
    return np.stack((c * x + s * y, c * y - s * x, frames[..., 2]), axis=-1)


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
    return sampler.furthest(tries, states + begun(sampler))


def begun(sampler: Sampler) -> list[tuple[float, float, float, float]]:
    """Standings with the lower gripper at the start."""
    run = sampler.run
    gaps = np.linspace(*(end + off for end, off in zip(sampler.machine.straight_gaps, (-0.03, 0.03), strict=True)), 201)
    low, clock = np.full_like(gaps, run.start_s), np.full_like(gaps, run.start_clock)
    good = sampler.poses(low, low + gaps, clock)[1]
    for s in (low, low + gaps):
        good &= ~np.any([at for _why, at in trouble(run, sampler.machine, sampler.pipe, s)], axis=0)
    found = [(run.start_s, run.start_s + float(gap), run.start_clock, run.start_clock) for gap in gaps[good]]
    return found or [(run.start_s, run.start_s, run.start_clock, run.start_clock)]


def trial(seed: int, tries: int) -> tuple[bool, list[str]]:
    """One random run: whether it was climbed, and what is wrong with the answer."""
    run = random_run(seed)
    machine = Machine.of(ROBOT)
    plan = as_plan(run, machine, climb(run, machine, PARTS), None)
    far = -math.inf
    if not plan.complete:
        far = attacked(run, ROBOT, plan, np.random.default_rng(seed), tries)
        if far > run.start_s + plan.reached_m + FURTHER:
            plan = as_plan(run, machine, climb(run, machine), None)
    wrong = faults(plan, run, ROBOT)
    if not plan.complete and far > run.start_s + plan.reached_m + FURTHER:
        wrong.append(f"sampling comes to {far:.4f} m, the plan to {run.start_s + plan.reached_m:.4f} m")
    return plan.complete, wrong


if __name__ == "__main__":
    first, count, most = (int(word) for word in sys.argv[1:4]) if len(sys.argv) > 3 else (0, 500, 2000)
    began, passed, sound = time.process_time(), 0, 0
    for number in range(first, first + count):
        complete, wrong = trial(number, most)
        passed += complete
        sound += not wrong
        if wrong or number % 25 == 24:
            print(number, complete, wrong, f"{time.process_time() - began:.0f} s", flush=True)
    spent = time.process_time() - began
    print(f"{passed} of {count} climbed, the rest refused, {sound} answers confirmed; {spent:.0f} s of one core")
