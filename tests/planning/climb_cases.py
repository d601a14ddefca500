"""Machines, and a search by random sampling that knows nothing of the planner: the oracle of "cannot pass".

`python tests/planning/climb_cases.py trials.jsonl` tries 500 random runs: every plan is replayed, every refusal is
attacked. Begun again it goes on with the runs that the file does not have.
"""

from __future__ import annotations

import json
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from steeplejack.planning.climb import ClimbPlan, faults
from steeplejack.planning.climb.collide import AIR, obstacles_of
from steeplejack.planning.climb.frames import touching
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import PALM, bumps, places_on, trouble
from steeplejack.planning.climb.planner import as_plan, climb
from steeplejack.planning.climb.search import SWING
from steeplejack.planning.climb.uses import directions, states
from steeplejack.robots.pipe_climber import Layout, PipeClimber, load_pipe_climber
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.singularity import determinant
from steeplejack.worksite.pipe_generate import random_pipes
from steeplejack.worksite.pipe_run import PipeRun, build_run

ROBOT = load_pipe_climber()
SPACING = 0.002  # [m] between places the sampling looks at on its way
NEAR = 0.12  # [m] beyond the grippers, where bars can meet something
COARSE = 0.01  # [m] between those where it asks for the grip
BATCH = 150  # moves tried at once
PARTS = (5,)  # of the stroke; the planner's finer lattices cost several times as much: where this is beaten
FINER = (10, 20)
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
    """A cloud of standings on the main pipe grown by random moves, many generations deep, to any place and clock.

    Half of the moves are as long as cylinders allow; others end just before or behind what stands on the pipe, or where
    the other gripper can then come to; turns go to the clear sides of obstacles and bends. Of standings with different
    clocks the furthest of each are grown, so that a way that begins with turning back is found as well.
    """

    def __init__(self, run: PipeRun, robot: PipeClimber, rng: np.random.Generator) -> None:
        self.run, self.machine, self.rng = run, Machine.of(robot), rng
        self.robot, self.layout, self.pipe = robot, Layout.of(robot), run.pipes[0]
        self.low = np.array(robot.cylinders.retracted)
        self.high = self.low + robot.cylinders.stroke
        self.side = np.sign(determinant(self.layout, np.array(robot.joints.home)))
        self.solids = obstacles_of(run)
        low = 0.9 * self.machine.lowest_bar - 0.5 * max(part.diameter for part in self.pipe.parts)
        tall = [one for one in run.obstacles if one.height > low]
        places = [0.5 * (one.start + one.end) for one in tall] + [one.at for one in run.crossings]
        self.beside = np.array(places)  # where bars can meet something
        self.bumps = [one for one in bumps(run, self.machine, self.pipe) if one.height > robot.gait.clearance]
        bends = [part.toward + k * math.pi for part in self.pipe.parts if not part.straight for k in (0, 1)]
        falls = [
            math.atan2(*(part.frame.T @ np.array(run.gravity))[[1, 0]]) for part in self.pipe.parts if part.straight
        ]
        away = [
            one.clock[0] - PALM + sign * (one.clock[1] + robot.gait.palm + more)
            for one in self.bumps for sign in (-1.0, 1.0) for more in (1e-3, 0.1, 0.3) if one.clock[1] < 2.5
        ]  # fmt: skip
        self.useful = np.array([*bends, *falls, *(fall + math.pi for fall in falls), run.start_clock, *away])
        self.marks = self.beside_everything()
        self.seen: set[tuple[int, ...]] = set()

    def beside_everything(self) -> np.ndarray:
        """Places of a gripper just before and behind what its jaws or rows of pads may not close on [m]."""
        half, pads = 0.5 * self.robot.build.jaw_length, 3.0 * self.robot.build.pad_radius
        edges = [end for one in self.run.obstacles for end in (one.start, one.end)]
        edges += [end for one in self.bumps if math.isfinite(one.start) for end in (one.start, one.end)]
        edges += [part.start for part in self.pipe.parts[1:]]
        offsets = (-half, pads - half, half - pads, half)
        return np.array([edge + off + nudge for edge in edges for off in offsets for nudge in (-1e-5, 1e-5)] or [-1.0])

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
        ends = (places_on(self.run, self.machine, 0, low), places_on(self.run, self.machine, 0, high))
        ways = directions(self.run, self.machine, *ends, clocks[:, 1])
        return states(self.run, self.machine, *ends, pose, ways, np.arange(len(low)), clocks[:, 1], clocks[:, 0])

    def parents(self, cloud: np.ndarray, count: int) -> np.ndarray:
        """Standings to go on from: the furthest of each clock, and some anywhere."""
        rng = self.rng
        bins = np.rint(cloud[:, 3] / math.radians(15.0)).astype(int) % 24
        kinds = np.unique(bins)
        wanted, rank = rng.choice(kinds, count), rng.exponential(4.0, count).astype(int)
        order = np.argsort(-cloud[:, 0] - cloud[:, 1], kind="stable")
        by_kind = {kind: order[bins[order] == kind] for kind in kinds}
        found = np.array(
            [by_kind[kind][min(place, len(by_kind[kind]) - 1)] for kind, place in zip(wanted, rank, strict=True)]
        )
        found = np.where(rng.random(count) < 0.4, order[np.minimum(rank, len(order) - 1)], found)
        return cloud[np.where(rng.random(count) < 0.15, rng.integers(0, len(cloud), count), found)]

    def drawn(self, cloud: np.ndarray, count: int) -> Moves:
        """Moves from a cloud of standings."""
        rng, limit = self.rng, self.robot.rcm.limit
        start = self.parents(cloud, count)
        upper, end = rng.random(count) < 0.5, start.copy()
        least, most = self.machine.straight_gaps
        short = np.where(rng.random(count) < 0.5, 0.0, rng.exponential(0.006, count))
        how = rng.random(count)
        gap = np.where(upper, most - short, least + short)
        gap = np.where(how < 0.15, rng.uniform(least - 0.02, most + 0.02, count), gap)
        target = np.where(upper, start[:, 0] + gap, start[:, 1] - gap)
        mark = rng.choice(self.marks, count)
        shift = rng.choice([0.0, 0.0, least, most, most - least], count) * rng.choice([-1.0, 1.0], count)
        target = np.where((how > 0.15) & (how < 0.5), mark + shift, target)
        still = how > 0.8  # only turns
        target = np.where(still, np.where(upper, start[:, 1], start[:, 0]), target)
        end[:, 0], end[:, 1] = np.where(upper, start[:, 0], target), np.where(upper, target, start[:, 1])
        other = np.where(upper, start[:, 2], start[:, 3])
        own = np.where(upper, start[:, 3], start[:, 2])
        useful = rng.choice(self.useful, count)
        useful = own + (useful - own + math.pi) % (2.0 * math.pi) - math.pi
        useful = other + np.clip(useful - other, -limit, limit)
        free = other + np.where(
            rng.random(count) < 0.5, rng.choice([-limit, 0.0, limit], count), rng.uniform(-limit, limit, count)
        )
        kind = np.where(still, 0.45 + 0.55 * rng.random(count), rng.random(count))
        clock = np.where(kind < 0.45, own, np.where(kind < 0.75, useful, free))
        clock = np.where(np.abs(clock - other) <= limit + 1e-9, clock, own)
        end[:, 2] = np.where(upper, start[:, 2], clock)
        end[:, 3] = np.where(upper, clock, start[:, 3])
        return Moves(start, end, upper)

    def made(self, moves: Moves) -> np.ndarray:
        """Standings at the ends of those moves that can be made and lead to new ones, the cheap questions first."""
        moved = np.where(moves.upper, moves.end[:, 1], moves.end[:, 0])
        moves = moves.only((moved > 0.0) & (moved < self.pipe.length) & self.new(moves.end))
        for question in (self._reaches, self._closes, self._passes, self._goes, self._clears, self._bears):
            if not len(moves.end):
                return moves.end
            moves = moves.only(question(moves))
        self.seen.update(map(tuple, self.cells(moves.end)))
        return moves.end

    def cells(self, standings: np.ndarray) -> np.ndarray:
        """Standings as integers, those nearly the same alike."""
        return np.rint(standings / [1e-3, 1e-3, 0.03, 0.03]).astype(int)

    def new(self, standings: np.ndarray) -> np.ndarray:
        """Whether nothing near them has been found yet; the first of each."""
        cells = self.cells(standings)
        first = np.zeros(len(cells), dtype=bool)
        first[np.unique(cells, axis=0, return_index=True)[1]] = True
        return first & np.array([tuple(cell) not in self.seen for cell in cells])

    def _reaches(self, moves: Moves) -> np.ndarray:
        return self.poses(moves.end[:, 0], moves.end[:, 1], moves.end[:, 3])[1]

    def _closes(self, moves: Moves) -> np.ndarray:
        moved = np.where(moves.upper, moves.end[:, 1], moves.end[:, 0])
        return ~np.any([at for _why, at in trouble(self.run, self.machine, self.pipe, moved)], axis=0)

    def _passes(self, moves: Moves) -> np.ndarray:
        """Whether the palm passes everything on the way, turning at any time."""
        column = moves.upper.astype(int)
        every, half = np.arange(len(column)), 0.5 * self.robot.build.jaw_length
        ends = np.sort(np.stack((moves.start[every, column], moves.end[every, column]), axis=-1), axis=1)
        clocks = np.stack((moves.start[every, 2 + column], moves.end[every, 2 + column]), axis=-1)
        middle, spread = clocks.mean(axis=1) + PALM, 0.5 * np.abs(np.diff(clocks, axis=1)[:, 0])
        free = np.ones(len(column), dtype=bool)
        for one in self.bumps:
            away = np.abs((middle - one.clock[0] + math.pi) % (2.0 * math.pi) - math.pi)
            under = away < one.clock[1] + self.robot.gait.palm + spread - 1e-9
            free &= ~(under & (ends[:, 1] + half > one.start + 1e-9) & (ends[:, 0] - half < one.end - 1e-9))
        return free

    def _way(self, moves: Moves, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Which move, places of both grippers (n, 2) along it, and where each begins."""
        span = np.abs(moves.end[:, :2] - moves.start[:, :2]).max(axis=1)
        counts = np.maximum(2, np.ceil(span / spacing).astype(int) + 1)
        which = np.repeat(np.arange(len(counts)), counts)
        first = np.concatenate(([0], np.cumsum(counts)[:-1]))
        share = (np.arange(len(which)) - first[which]) / (counts[which] - 1.0)
        return which, (moves.start[which] + share[:, None] * (moves.end - moves.start)[which])[:, :2], first

    def _goes(self, moves: Moves) -> np.ndarray:
        """Whether every pose on the way can be taken; turning the upper gripper wants one straight."""
        which, at, first = self._way(moves, SPACING)
        _pose, good, in_line = self.poses(at[:, 0], at[:, 1], moves.start[which, 3])
        turns = np.abs(moves.end[:, 2:] - moves.start[:, 2:]).max(axis=1) > 0.0
        return np.logical_and.reduceat(good & (~(turns & moves.upper)[which] | in_line), first)

    def _bears(self, moves: Moves) -> np.ndarray:
        """Whether the other grip bears the robot on the way, at the clocks before and after."""
        which, at, first = self._way(moves, COARSE)
        good = np.ones(len(which), dtype=bool)
        turns = np.abs(moves.end[:, 2:] - moves.start[:, 2:]).max(axis=1) > 0.0
        holder = np.where(moves.upper, 0, 1)[which]
        share_of = np.where(turns, 1.0 / SWING, 1.0)[which] + 1e-6
        for clocks in (moves.start[which, 2:], moves.end[which, 2:]):
            rows = np.flatnonzero(good)
            pose = self.poses(at[rows, 0], at[rows, 1], clocks[rows, 1])[0]
            use = self.uses(at[rows, 0], at[rows, 1], pose, clocks[rows])
            good[rows] &= use[np.arange(len(rows)), holder[rows]] <= share_of[rows]
            if not turns.any():
                break
        return np.logical_and.reduceat(good, first)

    def _clears(self, moves: Moves) -> np.ndarray:
        """Whether the bars of each move clear everything, turning at any time on the way."""
        low_end = np.minimum(moves.start[:, 0], moves.end[:, 0])[:, None] - NEAR
        high_end = np.maximum(moves.start[:, 1], moves.end[:, 1])[:, None] + NEAR
        near = ((self.beside > low_end) & (self.beside < high_end)).any(axis=1)
        free = np.ones(len(near), dtype=bool)
        if near.any():
            free[near] = self._clear(moves.only(near))
        return free

    def _clear(self, moves: Moves) -> np.ndarray:
        """`_clears` for moves near something: every place of a way at every clock of its turn."""
        samples, numbers = list[np.ndarray](), list[np.ndarray]()
        for number, (start, end, upper) in enumerate(zip(moves.start, moves.end, moves.upper, strict=True)):
            column = 1 if upper else 0
            way = np.linspace(start[column], end[column], max(2, math.ceil(abs(end[column] - start[column]) / SPACING)))
            turn = abs(end[2 + column] - start[2 + column])
            clocks = np.linspace(start[2 + column], end[2 + column], max(1, math.ceil(turn / math.radians(5.0)) + 1))
            sample = np.tile(start, (len(way) * len(clocks), 1))
            sample[:, column], sample[:, 2 + column] = np.repeat(way, len(clocks)), np.tile(clocks, len(way))
            samples.append(sample)
            numbers.append(np.full(len(sample), number))
        at, which = np.concatenate(samples), np.concatenate(numbers)
        pose = self.poses(at[:, 0], at[:, 1], at[:, 3])[0]
        points, frames = self.pipe.chord(at[:, 0], self.machine.row)
        lowers = np.broadcast_to(np.eye(4), (len(at), 4, 4)).copy()
        lowers[:, :3, :3], lowers[:, :3, 3] = turned(frames, at[:, 2]), points
        freedoms = np.column_stack((pose, at[:, 3] - at[:, 2]))
        met = touching(self.solids, self.machine, lowers, freedoms, AIR, True)
        return ~np.bincount(which, weights=met, minlength=len(moves.end)).astype(bool)

    def furthest(self, tries: int, states: list[tuple[float, float, float, float]], enough: float = math.inf) -> float:
        """How far the lower gripper comes from given standings in some thousand random moves, or at least [m]."""
        cloud = np.array(states)
        for _ in range(math.ceil(tries / BATCH)):
            cloud = np.concatenate((cloud, self.made(self.drawn(cloud, BATCH))))
            if cloud[:, 0].max() > enough:
                break
        return float(cloud[:, 0].max())


def turned(frames: np.ndarray, clocks: np.ndarray) -> np.ndarray:
    """Frames (k, 3, 3) turned about their z axes."""
    c, s = np.cos(clocks)[:, None], np.sin(clocks)[:, None]
    x, y = frames[..., 0], frames[..., 1]
    return np.stack((c * x + s * y, c * y - s * x, frames[..., 2]), axis=-1)


def attacked(
    run: PipeRun, robot: PipeClimber, plan: ClimbPlan, rng: np.random.Generator, tries: int, enough: float = math.inf
) -> float:
    """How far sampling comes from every standing of a plan that was refused, or at least [m]."""
    sampler = Sampler(run, robot, rng)
    states = [
        (phase.s_lower, phase.s_upper, phase.clock, phase.clock + phase.start[3])
        for phase in plan.phases
        if phase.kind.startswith("release") and phase.pipe_lower == phase.pipe_upper == "main"
    ]
    if plan.phases and plan.phases[-1].pipe_lower == plan.phases[-1].pipe_upper == "main":
        last = plan.phases[-1]
        states.append((last.s_lower, last.s_upper, last.clock, last.clock + last.end[3]))
    return sampler.furthest(tries, states + begun(sampler), enough)


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


def trial(seed: int, tries: int) -> dict[str, Any]:
    """One random run: whether it is climbed, how far plan and sampling come, and what is wrong with the answer."""
    run = random_run(seed)
    machine = Machine.of(ROBOT)
    plan = as_plan(run, machine, climb(run, machine, PARTS), None)
    far, reached = -math.inf, run.start_s + plan.reached_m
    if not plan.complete:
        far = attacked(run, ROBOT, plan, np.random.default_rng(seed), tries, reached + FURTHER)
        if far > reached + FURTHER:
            best = max((climb(run, machine, (parts,)) for parts in FINER), key=lambda found: found.progress)
            plan = as_plan(run, machine, best, None)
            reached = run.start_s + plan.reached_m
    wrong = faults(plan, run, ROBOT)
    if not plan.complete and far > reached + FURTHER:
        wrong.append(f"sampling comes to {far:.4f} m, the plan to {reached:.4f} m")
    return {
        "seed": seed,
        "climbed": plan.complete,
        "reached_m": reached,
        "sampled_m": max(far, reached),
        "wrong": wrong,
    }


CRIPPLED = {
    "does not turn": changed(ROBOT, "rcm", limit=1e-3),
    "steps over nothing": changed(ROBOT, "gait", clearance=1e-3, relief=1e-3),
    "short steps": changed(ROBOT, "cylinders", stroke=0.035),
    "wrong clearance": changed(ROBOT, "gait", clearance=0.008, relief=0.012),
}
"""Machines that plan less than the real one can do: what they refuse wrongly the sampling has to notice."""


def noticed(seed: int, crippled: PipeClimber, tries: int) -> bool | None:
    """Whether sampling comes further on a random run than a crippled planner; None if that refuses nothing wrongly."""
    run = random_run(seed)
    able, less = (climb(run, Machine.of(robot), PARTS) for robot in (ROBOT, crippled))
    if less.complete or able.progress < less.progress + FURTHER:
        return None
    plan = as_plan(run, Machine.of(crippled), less, None)
    enough = less.progress + FURTHER
    return attacked(run, ROBOT, plan, np.random.default_rng(seed), tries, enough) > enough


def run_trials(path: Path, first: int, count: int, tries: int) -> None:
    """Trials of a range of seeds, one line of JSON each; those that a file has already are not run again."""
    lines = path.read_text().splitlines() if path.exists() else []
    done = {found["seed"]: found for found in map(json.loads, lines)}
    for seed in range(first, first + count):
        if seed in done:
            continue
        began = time.process_time()
        done[seed] = trial(seed, tries) | {"seconds": time.process_time() - began}
        with path.open("a") as file:
            file.write(json.dumps(done[seed]) + "\n")
        if done[seed]["wrong"]:
            print(done[seed], flush=True)
    found = [done[seed] for seed in range(first, first + count)]
    climbed, sound = (
        sum(map(bool, column)) for column in zip(*((one["climbed"], not one["wrong"]) for one in found), strict=True)
    )
    spent = sum(one["seconds"] for one in found)
    print(f"{climbed} of {count} climbed, the rest refused, {sound} answers confirmed; {spent:.0f} s of one core")


if __name__ == "__main__":
    run_trials(Path(sys.argv[1]), *(int(word) for word in sys.argv[2:5] or (0, 500, 1800)))
