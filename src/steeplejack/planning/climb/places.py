"""Where along a run a gripper may close, and what an open one passes over: rules of clearance, all of them estimates.

- A closed gripper covers its jaws' length. There it wants pipe of one diameter within its range and no junction; no
  obstacle under its two rows of pads, and between them none higher than the relief of its jaws.
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
from steeplejack.robots.pipe_climber.pads import INSET
from steeplejack.worksite.pipe_line import Pipe
from steeplejack.worksite.pipe_run import PipeObstacle, PipeRun

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]
Trouble = Literal["end of the pipe", "obstacle", "junction", "diameter"]
PALM = -0.5 * math.pi
"""Clock of the palm's middle from the robot's X axis [rad]."""


@dataclass(frozen=True)
class Places:
    """Places of one gripper, by pipe and along it.

    Attributes:
        pipe: Index of the pipe, (n,).
        s: Along it, (n,) [m].
        points: Where the gripper's middle is, (n, 3) [m]; see `worksite.pipe_line.Pipe.chord`.
        frames: Its frame at clock 0, (n, 3, 3).
        holds: Whether the gripper may close there, (n,).
    """

    pipe: Indices
    s: Array
    points: Array
    frames: Array
    holds: Flags


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
    gripper = machine.robot.gripper
    least, largest = (0.5 * one for one in gripper.pipe_diameter)
    outside = (first < -ROUNDING) | (last > pipe.length + ROUNDING)
    standing = np.zeros(len(s), dtype=np.bool_)
    for one in run.obstacles:
        if one.pipe == pipe.name:
            for begin, end in _covered(machine, one):
                standing |= (s + end > one.start + ROUNDING) & (s + begin < one.end - ROUNDING)
    meeting = np.zeros(len(s), dtype=np.bool_)
    for at, reach, _clocks, _other in junctions(run, pipe):
        meeting |= (last > at - reach + ROUNDING) & (first < at + reach - ROUNDING)
    low, high = _radii(pipe, first + ROUNDING, last - ROUNDING)
    size = (low < least - ROUNDING) | (high > largest + ROUNDING) | (high > low + ROUNDING)
    return [("end of the pipe", outside), ("obstacle", standing), ("junction", meeting), ("diameter", size)]


def _covered(machine: Machine, one: PipeObstacle) -> list[tuple[float, float]]:
    """Stretches about a closed gripper's middle that an obstacle must keep out of [m]."""
    half, pads = 0.5 * machine.robot.build.jaw_length, 2.0 * INSET * machine.robot.build.pad_radius
    if one.height > machine.robot.gait.relief * (1.0 + ROUNDING) or 2.0 * pads >= 2.0 * half:
        return [(-half, half)]
    return [(-half, -half + pads), (half - pads, half)]


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
    offsets = (-half, -machine.row, 0.0, machine.row, half)
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
