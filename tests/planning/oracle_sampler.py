"""A search by random sampling that decides every rule by itself: the oracle of a planner's "cannot pass".

It shares with the planner the robot file, the geometry of runs and a few declared numbers; see `oracle_rules`.
"""

from __future__ import annotations

import math

import numpy as np
from oracle_bodies import Array
from oracle_clearance import PALM
from oracle_moves import Moves
from oracle_rules import Rules

from steeplejack.robots.pipe_climber import PipeClimber
from steeplejack.worksite.pipe_run import PipeRun

BATCH = 150  # moves tried at once


class Sampler:
    """A cloud of standings on the main pipe grown by random moves, many generations deep, to any place and clock.

    Half of the moves are as long as cylinders allow; others end just before or behind what stands on the pipe, or where
    the other gripper can then come to; turns go to the clear sides of obstacles and bends. Of standings with different
    clocks the furthest of each are grown, so that a way that begins with turning back is found as well.
    """

    def __init__(self, run: PipeRun, robot: PipeClimber, rng: np.random.Generator) -> None:
        self.run, self.robot, self.pipe, self.rng = run, robot, run.pipes[0], rng
        self.rules = Rules(run, robot)
        self.gaps = self.rules.bodies.straight_gaps
        self.useful = self._useful_clocks()
        self.marks = self._beside_everything()
        self.seen: set[tuple[int, ...]] = set()

    def _useful_clocks(self) -> Array:
        """With bends toward X, with the weight in the mechanism's plane, as at the start, with the palm clear [rad]."""
        gravity = np.array(self.run.gravity)
        bends = [part.toward for part in self.pipe.parts if not part.straight]
        falls = [math.atan2(*(part.frame.T @ gravity)[[1, 0]]) for part in self.pipe.parts if part.straight]
        away = [
            one.clock - PALM + sign * (one.beside + self.robot.gait.palm + more)
            for one in self.rules.hindrances for sign in (-1.0, 1.0) for more in (1e-3, 0.1, 0.3) if one.beside < 2.5
        ]  # fmt: skip
        either_way = [clock + turn for clock in (*bends, *falls) for turn in (0.0, math.pi)]
        return np.array([*either_way, self.run.start_clock, *away])

    def _beside_everything(self) -> Array:
        """Places of a gripper just before and behind what its jaws or rows of pads may not close on [m]."""
        edges = [end for one in (*self.run.obstacles, *self.rules.hindrances) for end in (one.start, one.end)]
        edges += [part.start for part in self.pipe.parts[1:]]
        offsets = [offset for row in self.rules.jaws.rows for offset in row]
        return np.array([edge + off + nudge for edge in edges for off in offsets for nudge in (-1e-5, 1e-5)] or [-1.0])

    def parents(self, cloud: Array, count: int) -> Array:
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

    def drawn(self, cloud: Array, count: int) -> Moves:
        """Moves from a cloud of standings."""
        rng, limit = self.rng, self.robot.rcm.limit
        start = self.parents(cloud, count)
        upper, end = rng.random(count) < 0.5, start.copy()
        least, most = self.gaps
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

    def made(self, moves: Moves) -> Array:
        """Standings at the ends of those moves that can be made and lead to new ones."""
        moved = np.where(moves.upper, moves.end[:, 1], moves.end[:, 0])
        moves = moves.only((moved > 0.0) & (moved < self.pipe.length) & self.new(moves.end))
        found = self.rules.made(moves).end
        self.seen.update(map(tuple, self.cells(found)))
        return found

    def cells(self, standings: Array) -> Array:
        """Standings as integers, those nearly the same alike."""
        return np.rint(standings / [1e-3, 1e-3, 0.03, 0.03]).astype(int)

    def new(self, standings: Array) -> Array:
        """Whether nothing near them has been found yet; the first of each."""
        cells = self.cells(standings)
        first = np.zeros(len(cells), dtype=bool)
        first[np.unique(cells, axis=0, return_index=True)[1]] = True
        return first & np.array([tuple(cell) not in self.seen for cell in cells])

    def furthest(self, tries: int, states: list[tuple[float, float, float, float]], enough: float = math.inf) -> float:
        """How far the lower gripper comes from given standings in some thousand random moves, or at least [m]."""
        cloud = np.array(states)
        for _ in range(math.ceil(tries / BATCH)):
            cloud = np.concatenate((cloud, self.made(self.drawn(cloud, BATCH))))
            if cloud[:, 0].max() > enough:
                break
        return float(cloud[:, 0].max())

    def begun(self) -> list[tuple[float, float, float, float]]:
        """Standings with the lower gripper at the start of the run."""
        start, clock = self.run.start_s, self.run.start_clock
        upper = start + np.linspace(self.gaps[0] - 0.03, self.gaps[1] + 0.03, 201)
        places = np.column_stack((np.full_like(upper, start), upper))
        good = self.rules.poses(places, np.full_like(upper, clock))[1]
        good &= self.rules.closes(places[:, 0]) & self.rules.closes(upper)
        found = [(start, float(s), clock, clock) for s in upper[good]]
        return found or [(start, start, clock, clock)]
