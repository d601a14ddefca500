"""What a move has to hold, for the oracle: poses, closing, passing, bars and grip, each decided by code of its own.

See `oracle_bodies`, `oracle_clearance`, `oracle_bars` and `oracle_grips`. Forces of cylinders and the torque of the
servo are not asked for: what the planner refuses for them alone the oracle would not refuse.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import oracle_bends
from oracle_bars import met, solids_of
from oracle_bodies import Array, Bodies, gap_to_axis, moved
from oracle_clearance import Jaws, closes, footing, hindrances, passes
from oracle_grips import Pads, facets, used
from oracle_loads import loads
from oracle_moves import Moves

from steeplejack.planning.climb.solids import AIR
from steeplejack.robots.pipe_climber import PipeClimber
from steeplejack.worksite.pipe_run import PipeRun

TURNING = (0.0, 1.0, 0.5, 0.25, 0.75)  # parts of a turn at which the grip is asked
SPACING = 0.002  # [m] between places looked at on a way
COARSE = 0.01  # [m] between those where the grip is asked for
TURN = math.radians(5.0)  # between clocks at which bars are looked at
NEAR = 0.12  # [m] beyond the grippers, where bars can meet something
NUDGE = 1e-5  # [m] by which a gripper goes on to see how the mechanism moves
STRAIGHT = 1e-8  # [m] and [rad] off the straight


@dataclass
class Asked:
    """Standings with one gripper open for which the use of the other's grip was asked, and what it was."""

    standings: Array  # (n, 4) s_lower, s_upper, clock_lower, clock_upper
    upper: Array  # (n,) whether it is the upper gripper that holds
    use: Array  # (n,) in parts of what a plan may use


class Rules:
    """The rules on the main pipe of a run."""

    def __init__(self, run: PipeRun, robot: PipeClimber) -> None:
        self.run, self.robot, self.pipe = run, robot, run.pipes[0]
        self.bodies, self.jaws, self.pads = Bodies.of(robot), Jaws.of(robot), Pads.of(robot)
        self.solids = solids_of(run)
        self.hindrances = hindrances(run, robot)
        home = np.array([robot.joints.home])
        self.side = np.sign(self.bodies.determinant(home)[0])
        self._bent = np.array([not part.straight for part in self.pipe.parts])
        self.asked: list[Asked] = []

    @cached_property
    def beside(self) -> Array:
        """Stretches of the main pipe where bars can meet something: all but straights that nothing high stands on."""
        room = gap_to_axis(self.bodies) - AIR
        found = [(part.start, part.end) for part in self.pipe.parts if not part.straight or 0.5 * part.diameter > room]
        found += [(one.at, one.at) for one in self.run.crossings]
        found += [
            (one.start, one.end)
            for one in self.run.obstacles
            if one.pipe == self.pipe.name and one.height > room - float(self.pipe.radius(one.start))
        ]
        return np.array(found).reshape(-1, 2)

    def poses(self, places: Array, clock: Array) -> tuple[Array, Array, Array]:
        """Poses that join places (k, 2) at clocks of the mechanism, whether they can be taken, and at any clock."""
        (p0, f0), (p1, f1) = (self.pipe.chord(places[:, end], self.jaws.row) for end in range(2))
        base = f0 @ moved("z", clock)[:, :3, :3]
        p = np.einsum("kji,kj->ki", base, p1 - p0)
        turn = np.einsum("kji,kjl->kil", base, f1)
        alpha, hz = np.arctan2(turn[:, 0, 2], turn[:, 2, 2]), self.robot.linkage.claw_offset
        pose = np.stack((p[:, 0] - hz * np.sin(alpha), p[:, 2] - hz * np.cos(alpha), alpha), axis=-1)
        good = (np.abs(p[:, 1]) < 1e-6) & (np.abs(turn[:, 1, 2]) < 1e-6)
        in_line = (np.hypot(p[:, 0], p[:, 1]) < STRAIGHT) & (np.hypot(turn[:, 0, 2], turn[:, 1, 2]) < STRAIGHT)
        return pose, good & self._taken(pose), in_line

    def lower_frames(self, standings: Array) -> tuple[Array, Array]:
        """Middle (k, 3) [m] and axes (k, 3, 3) of the lower gripper in the world."""
        point, frames = self.pipe.chord(standings[:, 0], self.jaws.row)
        return point, frames @ moved("z", standings[:, 2])[:, :3, :3]

    def frames(self, standings: Array, upper: bool) -> tuple[Array, Array]:
        """Middle (k, 3) [m] and axes (k, 3, 3) of the upper or of the lower gripper in the world."""
        if not upper:
            return self.lower_frames(standings)
        alpha = self.poses(standings[:, :2], standings[:, 3])[0][:, 2]
        turned = np.column_stack((standings[:, :2], standings[:, [3, 3]]))  # the mechanism and the lower gripper alike
        axes = self.lower_frames(turned)[1] @ moved("y", alpha)[:, :3, :3]
        return self.pipe.chord(standings[:, 1], self.jaws.row)[0], axes

    def _taken(self, pose: Array) -> Array:
        """Whether cylinders, tilt and the side of the singularity allow poses."""
        (least, largest), lengths = self.bodies.windows, self.bodies.lengths(pose)
        good = ((lengths > least - 1e-9) & (lengths < largest + 1e-9)).all(axis=1)
        good &= (np.abs(pose[:, 2]) <= self.robot.joints.limit + 1e-9) & (pose[:, 1] > 0.0)
        with np.errstate(invalid="ignore", divide="ignore"):  # where a limb has no length
            return good & (self.side * self.bodies.determinant(pose) > 0.0)

    def closes(self, s: Array) -> Array:
        """Whether a gripper may close at places (k,) [m]."""
        return closes(self.run, self.robot, s)

    def made(self, moves: Moves) -> Moves:
        """Those moves that can be made, the cheap questions first."""
        for question in (self._reaches, self._ends, self._passes, self._goes, self._clears, self._bears):
            if not len(moves.end):
                break
            moves = moves.only(question(moves))
        return moves

    def _reaches(self, moves: Moves) -> Array:
        return self.poses(moves.end[:, :2], moves.end[:, 3])[1]

    def _ends(self, moves: Moves) -> Array:
        return self.closes(moves.moving()[0][:, 1])

    def _passes(self, moves: Moves) -> Array:
        """Whether the palm passes everything on the way, turning at any time."""
        places, clocks = moves.moving()
        ends = (places.min(axis=1), places.max(axis=1))
        return passes(self.hindrances, self.robot, ends, clocks.mean(axis=1), 0.5 * np.ptp(clocks, axis=1))

    def _goes(self, moves: Moves) -> Array:
        """Whether every pose on the way can be taken; turning the upper gripper wants one straight."""
        which, at, first = moves.ways(SPACING)
        _pose, good, in_line = self.poses(at, moves.start[which, 3])
        return np.logical_and.reduceat(good & (~(moves.turns & moves.upper)[which] | in_line), first)

    def _bears(self, moves: Moves) -> Array:
        """Whether the other grip bears the robot on the way, at the clocks before, while it turns and after."""
        which, at, first = moves.ways(COARSE)
        good = np.ones(len(which), dtype=bool)
        for share in TURNING:
            rows = np.flatnonzero(good & (moves.turns[which] | (share == 0.0)))
            clocks = moves.start[:, 2:] + share * (moves.end - moves.start)[:, 2:]
            standings = np.append(at[rows], clocks[which[rows]], axis=1)
            good[rows] &= self.use(standings, ~moves.upper[which[rows]]) <= 1.0 + 1e-6
        return np.logical_and.reduceat(good, first)

    def use(self, standings: Array, upper: Array) -> Array:
        """Use of the upper or the lower grip alone, whichever way the other gripper moves and turns, (k,).

        Args:
            standings: s_lower, s_upper, clock_lower, clock_upper, (k, 4).
            upper: Whether the upper one holds, (k,).
        """
        found = np.empty(len(standings))
        for end in (False, True):
            rows = np.flatnonzero(upper == end)
            if not len(rows):
                continue
            weight, pushes = loads(self.bodies, *self.motions(standings[rows], end), end)
            s = standings[rows, int(end)]
            radii, which = footing(self.robot, self.pipe, s)
            leans = np.any([self._bent[self.pipe.part_at(s + row)] for row in (-self.jaws.row, self.jaws.row)], axis=0)
            for radius, touching, bent in set(zip(radii.tolist(), which.tolist(), leans.tolist(), strict=True)):
                mine = (radii == radius) & (which == touching) & (leans == bent)
                if bent:
                    axes = self.frames(standings[rows[mine]], end)
                    corners = oracle_bends.wrenches(self.pads, self.pipe, s[mine], axes, radius, touching)
                    found[rows[mine]] = oracle_bends.used(corners, weight[mine], pushes[mine])
                else:
                    found[rows[mine]] = used(facets(self.pads, radius, touching), weight[mine], pushes[mine])
        found /= 1.0 - self.robot.gait.reserve
        self.asked.append(Asked(standings, upper, found))
        return found

    def motions(self, standings: Array, upper: bool) -> tuple[Array, Array, Array]:
        """Freedoms (k, 4), gravity in the lower gripper's frame (k, 3), and accelerations in a ramp (k, 2, 4).

        These are of the other gripper's way along its pipe, and of its turn.
        """
        clock = standings[:, 3]
        step = NUDGE * np.array([1.0, 0.0] if upper else [0.0, 1.0])
        pose, ahead, back = (self.poses(standings[:, :2] + by * step, clock)[0] for by in (0.0, 1.0, -1.0))
        faster = np.abs(self.bodies.lengths(ahead) - self.bodies.lengths(back)).max(axis=1, keepdims=True)
        gait, rise = self.robot.gait, 0.5 * math.pi / self.robot.gait.ramp
        rates = np.zeros((len(pose), 2, 4))
        rates[:, 0, :3] = rise * self.robot.cylinders.speed * (ahead - back) / faster
        rates[:, 1, 3] = rise * gait.turn_speed
        if not upper:  # the upper gripper turns with both on one straight only
            rates[np.abs(pose[:, [0, 2]]).max(axis=1) > STRAIGHT, 1] = 0.0
        _point, frames = self.lower_frames(standings)
        gravity = np.einsum("kji,j->ki", frames, np.array(self.run.gravity))
        return np.column_stack((pose, clock - standings[:, 2])), gravity, rates

    def _clears(self, moves: Moves) -> Array:
        """Whether the bars of each move clear everything, turning at any time on the way."""
        low = np.minimum(moves.start[:, 0], moves.end[:, 0])[:, None] - NEAR
        high = np.maximum(moves.start[:, 1], moves.end[:, 1])[:, None] + NEAR
        near = np.flatnonzero(((self.beside[:, 1] > low) & (self.beside[:, 0] < high)).any(axis=1))
        free = np.ones(len(moves.upper), dtype=bool)
        if len(near):
            free[near] = self._clear(moves.only(near))
        return free

    def _clear(self, moves: Moves) -> Array:
        """`_clears` for moves near something: every place of a way at every clock of its turn."""
        column = moves.upper.astype(int)
        places, clocks = moves.moving()
        samples, numbers = list[Array](), list[Array]()
        for number, start in enumerate(moves.start):
            (first, last), (begin, end) = places[number].tolist(), clocks[number].tolist()
            way = np.linspace(first, last, max(2, math.ceil(abs(last - first) / SPACING)))
            turn = np.linspace(begin, end, math.ceil(abs(end - begin) / TURN) + 1)
            sample = np.tile(start, (len(way) * len(turn), 1))
            sample[:, column[number]] = np.repeat(way, len(turn))
            sample[:, 2 + column[number]] = np.tile(turn, len(way))
            samples.append(sample)
            numbers.append(np.full(len(sample), number))
        hits = self.meets(np.concatenate(samples))
        return ~np.bincount(np.concatenate(numbers), weights=hits, minlength=len(moves.upper)).astype(bool)

    def meets(self, standings: Array) -> Array:
        """Whether bars come too near to anything with the grippers at standings (k, 4), (k,)."""
        pose = self.poses(standings[:, :2], standings[:, 3])[0]
        point, frames = self.lower_frames(standings)
        bars = self.bodies.bars_at(np.column_stack((pose, standings[:, 3] - standings[:, 2])))
        bars = np.einsum("kij,kmej->kmei", frames, bars) + point[:, None, None]
        return met(self.solids, bars, self.bodies.radii, AIR)
