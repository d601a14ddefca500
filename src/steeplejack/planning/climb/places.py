"""Where along a run a gripper may close, and what an open one passes over: rules of clearance, all of them estimates.

- A closed gripper covers its jaws' length. There it wants no junction; no obstacle under its two rows of pads, and
  between them none higher than the relief of its jaws. Under either row it wants one diameter. If they are two, the row
  on the larger one holds alone (`footing`); it has to be within the grippers' range. Where a row leans against the
  chord between both, the pipe is thicker across by ``r (1 / cos(lean) - 1)``, which may be no more than `GIVE`.
- An open gripper keeps only its palm near the pipe, on the side of the robot's -Y; the jaws swing clear of the rest.
  The palm passes whatever is lower than its clearance, and anything at clocks it does not cover.
- Two pipes whose axes cross under the angle g cover each other over (r_other + r |cos g|) / sin g to either side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.limits import ROUNDING, Machine
from steeplejack.robots.pipe_climber.pads import BOTH, FIRST, INSET, LAST
from steeplejack.worksite.pipe_line import Pipe
from steeplejack.worksite.pipe_run import PipeObstacle, PipeRun

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]
Trouble = Literal["end of the pipe", "obstacle", "junction", "diameter", "bend"]
PALM = -0.5 * math.pi
"""Clock of the palm's middle from the robot's X axis [rad]."""

GIVE = 5e-4
"""How far a gripper may give until pads of both its rows touch [m]: more is taken for a slip, see
`control.climber.controller`; an estimate."""

COLUMNS = ("pipe", "s", "points", "frames", "holds", "footing", "lines")


@dataclass(frozen=True)
class Places:
    """Places of one gripper, by pipe and along it.

    Attributes:
        pipe: Index of the pipe, (n,).
        s: Along it, (n,) [m].
        points: Where the gripper's middle is, (n, 3) [m]; see `worksite.pipe_line.Pipe.chord`.
        frames: Its frame at clock 0, (n, 3, 3).
        holds: Whether the gripper may close there, (n,).
        footing: What its pads then rest on, (n, 2); see `footing`.
        lines: Tangent and curvature of the pipe under its first and its last row, in the world, (n, 2, 2, 3) [1, 1/m].
    """

    pipe: Indices
    s: Array
    points: Array
    frames: Array
    holds: Flags
    footing: Array
    lines: Array

    def only(self, which: Indices) -> Places:
        """Some of the places."""
        return Places(*(getattr(self, name)[which] for name in COLUMNS))

    def beside(self, run: PipeRun, machine: Machine, ahead: float | Array) -> tuple[Array, Array]:
        """Points and frames of a gripper that is further on along the pipes, by one or by (n,) [m]."""
        s, points, frames = self.s + ahead, np.empty_like(self.points), np.empty_like(self.frames)
        for index, pipe in enumerate(run.pipes):
            mine = self.pipe == index
            points[mine], frames[mine] = pipe.chord(s[mine], machine.row)
        return points, frames


def places_on(run: PipeRun, machine: Machine, index: int, s: Array) -> Places:
    """Places (k,) [m] of a gripper along one pipe of a run."""
    pipe = run.pipes[index]
    holds = ~np.any([flags for _why, flags in trouble(run, machine, pipe, s)], axis=0)
    which = np.full(len(s), index, dtype=np.int64)
    rests = footing(machine, pipe, s), lines_under(machine, pipe, s)
    return Places(which, s, *pipe.chord(s, machine.row), holds, *rests)


def joined_places(parts: list[Places]) -> Places:
    """Places of several pipes, one after the other."""
    columns = ([getattr(part, name) for part in parts] for name in COLUMNS)
    return Places(*(np.concatenate(column) for column in columns))


@dataclass(frozen=True)
class Bump:
    """Something an open gripper may meet.

    Attributes:
        start: Along the pipe [m].
        end: Along the pipe [m].
        height: Above the pipe [m].
        clock: Middle and half of its extent [rad]; half is pi or more for all round.
        what: For messages.
    """

    start: float
    end: float
    height: float
    clock: tuple[float, float]
    what: str


def bumps(run: PipeRun, machine: Machine, pipe: Pipe) -> list[Bump]:
    """All that stands out of one pipe: obstacles, other pipes, larger diameters than the grippers open for."""
    found: list[Bump] = []
    for one in run.obstacles:
        if one.pipe == pipe.name:
            first, last = one.clock if one.clock is not None else (-math.pi, math.pi)
            middle, half = 0.5 * (first + last), 0.5 * (last - first)
            found.append(Bump(one.start, one.end, one.height, (middle, half), one.note))
    largest = machine.robot.gripper.pipe_diameter[1]
    for part in pipe.parts:
        if part.diameter > largest:
            height = 0.5 * (part.diameter - largest)
            what = f"diameter {1e3 * part.diameter:.0f} mm"
            found.append(Bump(part.start, part.end, height, (0.0, math.pi), what))
    for at, half, clocks, other in junctions(run, pipe):
        own = float(pipe.radius(at)) + machine.robot.gait.clearance
        beside = math.asin(min(1.0, float(other.radius(0.0)) / own))
        found += [Bump(at - half, at + half, math.inf, (clock, beside), f"pipe {other.name}") for clock in clocks]
    return found


def junctions(run: PipeRun, pipe: Pipe) -> list[tuple[float, float, list[float], Pipe]]:
    """Where other pipes meet one: place, half of the length they cover [m], clocks they leave at [rad], which."""
    found: list[tuple[float, float, list[float], Pipe]] = []
    main = run.pipes[0]
    for one in run.crossings:
        second = run.pipe(one.pipe)
        on_main = pipe is main
        if not on_main and pipe is not second:
            continue
        at, other = (one.at, second) if on_main else (one.at_other, main)
        own, theirs = (
            float(pipe.radius(at)),
            float((second if on_main else main).radius(one.at_other if on_main else one.at)),
        )
        half = (theirs + own * abs(math.cos(one.angle))) / math.sin(one.angle)
        clocks = [one.toward] + [one.toward + math.pi] * (one.through or not on_main)
        found.append((at, half, clocks, other))
    return found


def trouble(run: PipeRun, machine: Machine, pipe: Pipe, s: Array) -> list[tuple[Trouble, Flags]]:
    """Where a gripper may not close and why, each (k,), at places (k,) along a pipe [m]."""
    half = 0.5 * machine.robot.build.jaw_length
    first, last = s - half, s + half
    outside = (first < -ROUNDING) | (last > pipe.length + ROUNDING)
    standing = np.zeros(len(s), dtype=np.bool_)
    for one in run.obstacles:
        if one.pipe == pipe.name:
            for begin, end in _covered(machine, one):
                standing |= (s + end > one.start + ROUNDING) & (s + begin < one.end - ROUNDING)
    meeting = np.zeros(len(s), dtype=np.bool_)
    for at, reach, _clocks, _other in junctions(run, pipe):
        meeting |= (last > at - reach + ROUNDING) & (first < at + reach - ROUNDING)
    foot, size = _standing(machine, pipe, s)
    along = pipe.chord(s, machine.row)[1][:, None, :, 2]
    level = (lines_under(machine, pipe, s)[:, :, 0] * along).sum(axis=-1).min(axis=1)  # cos(lean)
    leaning = foot[:, 0] * (1.0 - level) > (GIVE + ROUNDING) * level
    barred: list[tuple[Trouble, Flags]] = [("end of the pipe", outside), ("obstacle", standing), ("junction", meeting)]
    return [*barred, ("diameter", size), ("bend", leaning)]


def _covered(machine: Machine, one: PipeObstacle) -> list[tuple[float, float]]:
    """Stretches about a closed gripper's middle that an obstacle must keep out of [m]."""
    half = 0.5 * machine.robot.build.jaw_length
    return [(-half, half)] if one.height > machine.robot.gait.relief * (1.0 + ROUNDING) else _rows(machine)


def _rows(machine: Machine) -> list[tuple[float, float]]:
    """Stretches about a closed gripper's middle that its rows of pads cover, all of it where they meet [m]."""
    half, pads = 0.5 * machine.robot.build.jaw_length, 2.0 * INSET * machine.robot.build.pad_radius
    return [(-half, half)] if pads >= half else [(-half, -half + pads), (half - pads, half)]


def footing(machine: Machine, pipe: Pipe, s: Array) -> Array:
    """Radius of the pipe [m] under the rows of pads that touch it, and which do (`pads.BOTH` ...), (k, 2)."""
    return _standing(machine, pipe, s)[0]


def lines_under(machine: Machine, pipe: Pipe, s: Array) -> Array:
    """Tangent and curvature under the rows of pads, see `worksite.pipe_line.Pipe.lines`, (k, 2, 2, 3)."""
    return pipe.lines(s[:, None] + machine.row * np.array([-1.0, 1.0]))


def _standing(machine: Machine, pipe: Pipe, s: Array) -> tuple[Array, Flags]:
    """`footing` of a gripper at places (k,) along a pipe [m], and whether diameters do not let it close there, (k,)."""
    least, largest = (0.5 * one for one in machine.robot.gripper.pipe_diameter)
    rows = [_radii(pipe, s + begin + ROUNDING, s + end - ROUNDING) for begin, end in _rows(machine)]
    uneven = np.any([high > low + ROUNDING for low, high in rows], axis=0)
    first, last = rows[0][1], rows[-1][1]
    touching = np.maximum(first, last)
    which = np.where(first > last + ROUNDING, FIRST, np.where(last > first + ROUNDING, LAST, BOTH))
    half = 0.5 * machine.robot.build.jaw_length
    _low, between = _radii(pipe, s - half, s + half)
    wrong = (touching < least - ROUNDING) | (touching > largest + ROUNDING) | uneven
    wrong |= between > touching + machine.robot.gait.relief + ROUNDING
    return np.stack((touching, which.astype(np.float64)), axis=-1), wrong


def edges(run: PipeRun, machine: Machine, pipe: Pipe) -> Array:
    """Places along a pipe where closing, passing or a straight begins or ends, (k,) [m]."""
    half = 0.5 * machine.robot.build.jaw_length
    stretches = [(0.0, 0.0), (pipe.length, pipe.length)]
    stretches += [(at - reach, at + reach) for at, reach, _clocks, _other in junctions(run, pipe)]
    beside = [place for start, end in stretches for place in (start - half, end + half)]
    for one in run.obstacles:
        if one.pipe == pipe.name:
            covered = [(-half, half), *_covered(machine, one)]
            beside += [place for begin, end in covered for place in (one.start - end, one.end - begin)]
    steps = [part.start for part in pipe.parts[1:]]
    rows = [end for row in _rows(machine) for end in row]
    offsets = (-half, -machine.row, 0.0, machine.row, half, *rows)
    return np.unique(np.array(beside + [step + offset for step in steps for offset in offsets]))


def _radii(pipe: Pipe, first: Array, last: Array) -> tuple[Array, Array]:
    """Least and largest radius of a pipe between places, each (k,) [m]."""
    low, high = np.full(len(first), np.inf), np.zeros(len(first))
    for number, part in enumerate(pipe.parts):
        begin = -math.inf if number == 0 else part.start
        end = math.inf if number == len(pipe.parts) - 1 else part.end
        over = (last > begin) & (first < end)
        low[over] = np.minimum(low[over], 0.5 * part.diameter)
        high[over] = np.maximum(high[over], 0.5 * part.diameter)
    return low, high


def passes(run: PipeRun, machine: Machine, pipe: Pipe, s: Array, clocks: Array, spread: float = 0.0) -> Flags:
    """Where an open gripper can be.

    Args:
        run: Of pipes.
        machine: With its palm and clearance.
        pipe: It is on.
        s: Places (k,) along it [m].
        clocks: Of the gripper's X axis, (c,) [rad]; the middle of a turn.
        spread: Half of the turn [rad].

    Returns:
        (k, c).
    """
    half, gait = 0.5 * machine.robot.build.jaw_length, machine.robot.gait
    free = np.ones((len(s), len(clocks)), dtype=np.bool_)
    for one in bumps(run, machine, pipe):
        if one.height <= gait.clearance * (1.0 + ROUNDING):
            continue
        there = (s + half > one.start + ROUNDING) & (s - half < one.end - ROUNDING)
        away = np.abs((clocks + PALM - one.clock[0] + np.pi) % (2.0 * np.pi) - np.pi)
        under = away < one.clock[1] + gait.palm + spread - ROUNDING
        free &= ~(there[:, None] & under[None, :])
    return free
