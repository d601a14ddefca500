"""A run of pipes as solids, and where a plan puts the robot on it."""

from __future__ import annotations

import math

import numpy as np

from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import footing
from steeplejack.planning.climb.plan import Phase
from steeplejack.robots.pipe_climber import PipeClimber
from steeplejack.simulation.climber.solids import Array, Solid
from steeplejack.worksite.pipe_line import Part, Pipe
from steeplejack.worksite.pipe_run import PipeObstacle, PipeRun

SAGITTA = 1e-5  # [m] by which the chords of a bend may leave its arc
MARKS = 0.1  # [m] between rings painted on the pipe
RIDGES = math.radians(15.0)  # between the ridges that an obstacle over part of the clock is made of


def solids_of(run: PipeRun) -> list[Solid]:
    """Straights, flanges and the like as cylinders, bends as chords, what stands on part of the clock as ridges."""
    pipes = [solid for pipe in run.pipes for part in pipe.parts for solid in _part(part)]
    obstacles = [solid for obstacle in run.obstacles for solid in _obstacle(run, obstacle)]
    return pipes + obstacles + [mark for pipe in run.pipes for mark in _marks(pipe)]


def frame_at(pipe: Pipe, s: float, clock: float, row: float) -> Array:
    """Frame of a gripper that sits on a pipe: z through the middle at both rows of its pads, X at a clock (4, 4).

    Args:
        pipe: It is on.
        s: Its place along the pipe [m].
        clock: Of its X axis [rad].
        row: From its middle to either row of pads [m]. In a bend of radius R the chord between the rows lies
            ``row^2 / 2R`` inside the centre line.
    """
    (low, high), frames = pipe.centre_line(np.array([s - row, s + row]))
    cosine, sine = math.cos(clock), math.sin(clock)
    across = frames.mean(axis=0) @ np.array([cosine, sine, 0.0])
    along = (high - low) / np.linalg.norm(high - low)
    across -= (across @ along) * along
    across /= np.linalg.norm(across)
    out = np.eye(4)
    out[:3, :3] = np.stack((across, np.cross(along, across), along), axis=-1)
    out[:3, 3] = 0.5 * (low + high)
    return out


def lower_frame(run: PipeRun, phase: Phase, row: float) -> Array:
    """Frame of the lower gripper where a phase of a plan begins; rows of pads so far from its middle (4, 4)."""
    return frame_at(run.pipe(phase.pipe_lower), phase.s_lower, phase.clock, row)


def resting(run: PipeRun, phase: Phase, robot: PipeClimber) -> tuple[Array, tuple[int, int]]:
    """What the lower and the upper gripper rest on where a phase begins, by the planner's `footing`.

    Returns:
        Radii of the pipe under the rows of pads that touch it (2,) [m], and which rows those are.
    """
    machine, places = Machine.of(robot), ((phase.pipe_lower, phase.s_lower), (phase.pipe_upper, phase.s_upper))
    lower, upper = (footing(machine, run.pipe(pipe), np.array([s]))[0] for pipe, s in places)
    return np.array([lower[0], upper[0]]), (int(lower[1]), int(upper[1]))


def clearing(run: PipeRun, phase: Phase, following: Phase, half: float) -> float:
    """Radius that open jaws must clear while a gripper goes from one place to another along a pipe [m].

    Args:
        run: The pipes.
        phase: Where the grippers are when it begins.
        following: Where they are when it has ended.
        half: From a gripper's middle to the ends of its jaws [m].

    Returns:
        The largest radius of the pipe on the way, with the highest obstacle.
    """
    widest = 0.0
    for end in ("lower", "upper"):
        pipe, before, after = getattr(phase, f"pipe_{end}"), getattr(phase, f"s_{end}"), getattr(following, f"s_{end}")
        low, high = min(before, after), max(before, after)
        if pipe != getattr(following, f"pipe_{end}"):
            low, high = before, before
        first, last = low - half, high + half
        widest = max(widest, _widest(run.pipe(pipe), first, last))
        for one in run.obstacles:
            if one.pipe == pipe and one.start < last and one.end > first and high > low:
                widest = max(widest, float(run.radius(one.start, pipe)) + one.height)
    return widest


def _widest(pipe: Pipe, first: float, last: float) -> float:
    """Largest radius between two places along a pipe [m]; beyond its ends that of its ends."""
    first, last = np.clip((first, last), 0.0, pipe.length)
    return max(0.5 * part.diameter for part in pipe.parts if part.start <= last and part.start + part.length >= first)


def _part(part: Part) -> list[Solid]:
    """One cylinder for a straight, chords for a bend.

    Chords within a bend are capsules, whose round ends fill what flat ones would leave open on its outside. The first
    and the last one end flat, so that where the diameter changes there is a step and no dome.
    """
    chords = 1
    if not part.straight:
        most = 2.0 * math.sqrt(2.0 * part.radius * SAGITTA)
        chords = max(1, math.ceil(part.length / most))
    points, _ = part.at(part.start + np.linspace(0.0, part.length, chords + 1))
    radius, last = 0.5 * part.diameter, chords - 1
    return [
        Solid("pipe", "cylinder" if k in (0, last) else "capsule", a, b, radius)
        for k, (a, b) in enumerate(zip(points[:-1], points[1:], strict=True))
    ]


def _marks(pipe: Pipe) -> list[Solid]:
    """A painted ring every tenth of a metre."""
    places = np.arange(MARKS, pipe.length, MARKS)
    points, frames = pipe.centre_line(places)
    half = 0.002 * frames[:, :, 2]
    rings = zip(points - half, points + half, pipe.radius(places), strict=True)
    return [Solid("mark", "cylinder", a, b, float(radius) + 2e-4) for a, b, radius in rings]


def _obstacle(run: PipeRun, obstacle: PipeObstacle) -> list[Solid]:
    """A cylinder where it goes all round on a straight; else ridges of half its height's radius on the surface."""
    pipe = run.pipe(obstacle.pipe)
    ends, frames = pipe.centre_line(np.array([obstacle.start, obstacle.end]))
    middle = 0.5 * (obstacle.start + obstacle.end)
    reach = float(pipe.radius(middle)) + obstacle.height
    if obstacle.clock is None:
        return [Solid("obstacle", "cylinder", ends[0], ends[1], reach)]
    first, last = obstacle.clock
    half = 0.5 * obstacle.height
    count = max(2, math.ceil((last - first) / RIDGES) + 1)
    out: list[Solid] = []
    for clock in np.linspace(first, last, count):
        aside = (reach - half) * (math.cos(clock) * frames[:, :, 0] + math.sin(clock) * frames[:, :, 1])
        out.append(Solid("obstacle", "cylinder", ends[0] + aside[0], ends[1] + aside[1], half))
    return out
