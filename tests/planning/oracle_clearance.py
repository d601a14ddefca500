"""Where grippers close and what a palm passes, for the oracle: docs/climbing.md as stretches of a gripper's middle.

Every rule that something at ``a`` to ``b`` along the pipe may not be under what covers ``c`` to ``d`` about a gripper's
middle is the open stretch ``(a - d, b - c)`` that the middle must keep out of.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from steeplejack.planning.climb.places import GIVE
from steeplejack.robots.pipe_climber import PipeClimber
from steeplejack.robots.pipe_climber.pads import BOTH, FIRST, INSET, LAST
from steeplejack.worksite.pipe_line import Pipe
from steeplejack.worksite.pipe_run import PipeRun

Array = np.ndarray
STEP = 1e-7  # [m] of the differences that are tangents
EXACT = 1e-9  # [m] by which something may reach into a stretch
PALM = -0.5 * math.pi  # [rad] clock of the palm's middle from the robot's X


@dataclass(frozen=True)
class Jaws:
    """What a gripper covers about its middle: its jaws, and a row of pads at either end."""

    half: float  # [m]
    pads: float  # [m]

    @classmethod
    def of(cls, robot: PipeClimber) -> Jaws:
        """A robot's."""
        return cls(0.5 * robot.build.jaw_length, 2.0 * INSET * robot.build.pad_radius)

    @property
    def row(self) -> float:
        """From the middle to that of a row of pads [m]."""
        return self.half - 0.5 * self.pads

    @property
    def rows(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """What the two rows of pads cover."""
        return (-self.half, -self.half + self.pads), (self.half - self.pads, self.half)


def _within(s: Array, start: float, end: float) -> Array:
    return (s > start + EXACT) & (s < end - EXACT)


def _junctions(run: PipeRun) -> Iterator[tuple[float, float]]:
    """What other pipes cover of the main one: ``(r_other + r |cos g|) / sin g`` to either side [m]."""
    for one in run.crossings:
        own, other = float(run.radius(one.at)), float(run.radius(one.at_other, one.pipe))
        reach = (other + own * abs(math.cos(one.angle))) / math.sin(one.angle)
        yield one.at - reach, one.at + reach


def closes(run: PipeRun, robot: PipeClimber, s: Array) -> Array:
    """Whether a gripper may close at places (k,) along the main pipe [m]."""
    jaws, pipe = Jaws.of(robot), run.pipes[0]
    whole = (-jaws.half, jaws.half)
    free = (s >= jaws.half - EXACT) & (s <= pipe.length - jaws.half + EXACT)
    barred = [(start, end, *whole) for start, end in _junctions(run)]
    for one in run.obstacles:
        if one.pipe == pipe.name:
            low = one.height <= robot.gait.relief + EXACT
            barred += [(one.start, one.end, *covered) for covered in (jaws.rows if low else (whole,))]
    changes = [b.start for a, b in zip(pipe.parts, pipe.parts[1:], strict=False) if a.diameter != b.diameter]
    barred += [(step, step, *row) for step in changes for row in jaws.rows]
    for start, end, begin, last in barred:
        free &= ~_within(s, start - last, end - begin)
    return free & _fits(robot, pipe, jaws, s) & _level(robot, pipe, jaws, s)


def _level(robot: PipeClimber, pipe: Pipe, jaws: Jaws, s: Array) -> Array:
    """Whether the pipe leans so little under the rows that it is no thicker across than a gripper gives."""
    first, last = (pipe.centre_line(s + row)[0] for row in (-jaws.row, jaws.row))
    chord = (last - first) / np.linalg.norm(last - first, axis=1)[:, None]
    radius, _rows = footing(robot, pipe, s)
    thicker = np.zeros(len(s))
    for row in (-jaws.row, jaws.row):
        step = pipe.centre_line(s + row + STEP)[0] - pipe.centre_line(s + row - STEP)[0]
        lean = np.arcsin(np.linalg.norm(np.cross(step, chord), axis=1) / np.linalg.norm(step, axis=1))
        thicker = np.maximum(thicker, radius / np.cos(lean) - radius)
    return thicker <= GIVE


def _fits(robot: PipeClimber, pipe: Pipe, jaws: Jaws, s: Array) -> Array:
    """Whether the diameter is one that grippers take, and none between the rows of pads stands out too far."""
    radius, _rows = footing(robot, pipe, s)
    least, most = (0.5 * one for one in robot.gripper.pipe_diameter)
    thickest = np.zeros(len(s))
    for part in pipe.parts:
        over = _within(s, part.start - jaws.half, part.end + jaws.half)
        thickest[over] = np.maximum(thickest[over], 0.5 * part.diameter)
    fits = (radius >= least - EXACT) & (radius <= most + EXACT)
    return fits & (thickest <= radius + robot.gait.relief + EXACT)


def footing(robot: PipeClimber, pipe: Pipe, s: Array) -> tuple[Array, Array]:
    """Radius under the rows of pads that touch the pipe, the larger one, (k,) [m], and which rows do, (k,)."""
    row = Jaws.of(robot).row
    first, last = pipe.radius(s - row), pipe.radius(s + row)
    return np.maximum(first, last), np.where(first > last, FIRST, np.where(last > first, LAST, BOTH))


@dataclass(frozen=True)
class Hindrance:
    """What a palm does not pass: along the main pipe [m], and about it to both sides of a clock [rad]."""

    start: float
    end: float
    clock: float
    beside: float


def hindrances(run: PipeRun, robot: PipeClimber) -> list[Hindrance]:
    """All that an open gripper's palm may not be over."""
    pipe, gait = run.pipes[0], robot.gait
    found: list[Hindrance] = []
    for one in run.obstacles:
        if one.pipe == pipe.name and one.height > gait.clearance + EXACT:
            first, last = one.clock if one.clock is not None else (-math.pi, math.pi)
            found.append(Hindrance(one.start, one.end, 0.5 * (first + last), 0.5 * (last - first)))
    widest = robot.gripper.pipe_diameter[1] + 2.0 * gait.clearance
    found += [Hindrance(part.start, part.end, 0.0, math.pi) for part in pipe.parts if part.diameter > widest + EXACT]
    for one, (start, end) in zip(run.crossings, _junctions(run), strict=True):
        palm = float(run.radius(one.at)) + gait.clearance
        beside = math.asin(min(1.0, float(run.radius(0.0, one.pipe)) / palm))
        found += [Hindrance(start, end, one.toward + k * math.pi, beside) for k in range(1 + one.through)]
    return found


def passes(
    hindrances: list[Hindrance], robot: PipeClimber, ends: tuple[Array, Array], clock: Array, spread: Array
) -> Array:
    """Whether an open gripper's palm passes.

    Args:
        hindrances: On the pipe.
        robot: The machine.
        ends: First and last place of its middle, (k,) each [m].
        clock: Of its X axis in the middle of its turn, (k,) [rad].
        spread: Half of the turn, (k,) [rad].
    """
    free = np.ones(len(clock), dtype=bool)
    half = Jaws.of(robot).half
    for one in hindrances:
        away = np.abs((clock + PALM - one.clock + math.pi) % (2.0 * math.pi) - math.pi)
        under = away < one.beside + robot.gait.palm + spread - EXACT
        free &= ~(under & (ends[1] > one.start - half + EXACT) & (ends[0] < one.end + half - EXACT))
    return free
