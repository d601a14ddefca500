"""A run of pipes to climb: pipes in space, what stands on them, where they cross, gravity, start and goal."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from steeplejack.errors import InputError
from steeplejack.worksite.pipe_file import MAIN, BendPart, CrossingEntry, MainEntry, ObstacleEntry, PipeFile
from steeplejack.worksite.pipe_line import Array, Part, Piece, Pipe, laid

LONGEST = 1000.0
"""[m] of a pipe; more is a mistaken unit."""


@dataclass(frozen=True)
class PipeObstacle:
    """Something standing on a pipe.

    Attributes:
        pipe: On which one.
        start: Where it begins along the pipe [m].
        end: Where it ends [m].
        height: Above the pipe's surface [m].
        clock: From and to, the second not before the first [rad]; None for all round.
        note: What it is.
    """

    pipe: str
    start: float
    end: float
    height: float
    clock: tuple[float, float] | None
    note: str


@dataclass(frozen=True)
class Crossing:
    """Where the axis of a second pipe meets that of the main one.

    Attributes:
        pipe: The second pipe.
        at: Where, along the main pipe [m].
        at_other: Where, along the second pipe [m].
        angle: Between their directions [rad].
        toward: Clock of the second pipe's direction about the main one [rad].
        through: Whether the second pipe goes on to both sides.
    """

    pipe: str
    at: float
    at_other: float
    angle: float
    toward: float
    through: bool


@dataclass(frozen=True)
class PipeRun:
    """Pipes and what a climb over them begins with.

    Attributes:
        name: Of the run.
        description: What it is.
        source: Where its numbers come from.
        notes: What else is to be known.
        pipes: The main one first.
        obstacles: On all of them.
        crossings: Of the main one with others.
        gravity: In the world's frame, (3,) [m/s2].
        start_s: Where the lower gripper begins on the main pipe [m].
        start_clock: Angle of its X axis about the pipe [rad].
        goal_pipe: Where the lower gripper has to come.
        goal_s: How far along it [m].
    """

    name: str
    description: str
    source: str
    notes: tuple[str, ...]
    pipes: tuple[Pipe, ...]
    obstacles: tuple[PipeObstacle, ...]
    crossings: tuple[Crossing, ...]
    gravity: tuple[float, float, float]
    start_s: float
    start_clock: float
    goal_pipe: str
    goal_s: float

    def pipe(self, name: str = MAIN) -> Pipe:
        """A pipe by its name."""
        return next(pipe for pipe in self.pipes if pipe.name == name)

    def centre_line(self, s: ArrayLike, pipe: str = MAIN) -> tuple[Array, Array]:
        """Points (..., 3) [m] and frames (..., 3, 3), z the tangent, at places (...) along a pipe [m]."""
        return self.pipe(pipe).centre_line(s)

    def radius(self, s: ArrayLike, pipe: str = MAIN) -> Array:
        """Of a pipe's outside at places along it (...) [m]."""
        return self.pipe(pipe).radius(s)


def with_bends(run: PipeRun, factor: float) -> PipeRun:
    """The same run with every bend's radius multiplied by a factor; what is on the main pipe or crosses it moves along.

    Args:
        run: Of pipes.
        factor: Above 0 [1].
    """
    main, first = run.pipes[0], run.pipes[0].parts[0]

    def moved(s: float) -> float:
        return place_with_bends(run, factor, s)

    stretched = ((part, 1.0 if part.straight else factor) for part in main.parts)
    parts: list[Piece] = [(part.length * by, part.radius * by, part.toward, part.diameter) for part, by in stretched]
    pipe = laid(main.name, first.diameter, parts, first.point, first.frame)
    obstacles = tuple(
        replace(one, start=moved(one.start), end=moved(one.end)) if one.pipe == main.name else one
        for one in run.obstacles
    )
    crossings = tuple(replace(one, at=moved(one.at)) for one in run.crossings)
    others = [
        _carried(run.pipe(one.pipe), main.centre_line(one.at), pipe.centre_line(there.at))
        for one, there in zip(run.crossings, crossings, strict=True)
    ]
    goal = moved(run.goal_s) if run.goal_pipe == main.name else run.goal_s
    return replace(
        run, pipes=(pipe, *others), obstacles=obstacles, crossings=crossings, start_s=moved(run.start_s), goal_s=goal
    )


def place_with_bends(run: PipeRun, factor: float, s: float) -> float:
    """Where a place of the main pipe [m], or beyond its end, is `with_bends`; with 1 / factor the way back."""
    lengths = np.array([part.length for part in run.pipes[0].parts])
    bent = np.array([not part.straight for part in run.pipes[0].parts])
    old, new = (np.append(0.0, np.cumsum(each)) for each in (lengths, np.where(bent, factor, 1.0) * lengths))
    return float(np.interp(s, old, new)) + max(s - old[-1], 0.0)


def _carried(pipe: Pipe, start: tuple[Array, Array], end: tuple[Array, Array]) -> Pipe:
    """A pipe carried along with a point (3,) and a frame (3, 3)."""
    turn = end[1] @ start[1].T
    return replace(
        pipe,
        parts=tuple(
            replace(part, point=end[0] + turn @ (part.point - start[0]), frame=turn @ part.frame) for part in pipe.parts
        ),
    )


def with_end(run: PipeRun, extra: float) -> PipeRun:
    """The same run with its goal's pipe going straight on at its end by a length [m]."""
    pipe = run.pipe(run.goal_pipe)
    last = pipe.parts[-1]
    point, frame = pipe.centre_line(last.end)
    longer = replace(pipe, parts=(*pipe.parts, Part(last.end, extra, math.inf, 0.0, last.diameter, point, frame)))
    return replace(run, pipes=tuple(longer if one is pipe else one for one in run.pipes))


def build_run(file: PipeFile, where: str) -> PipeRun:
    """The run a file describes.

    Args:
        file: As decoded.
        where: Its name, for messages.

    Returns:
        Pipes laid in space.

    Raises:
        InputError: An entry that cannot be; the message names it.
    """
    _check_numbers(file, where)
    main = _main(file.main, where)
    pipes, crossings = [main], list[Crossing]()
    for number, entry in enumerate(file.crossings):
        pipe, crossing = _crossing(entry, main, f"{where}, crossings[{number}]")
        if any(pipe.name == other.name for other in pipes):
            raise InputError(f"{where}, crossings[{number}].name", f"{entry.name!r} stands twice", "each name once")
        pipes.append(pipe)
        crossings.append(crossing)
    lengths = {pipe.name: pipe.length for pipe in pipes}
    obstacles = tuple(
        _obstacle(entry, lengths, f"{where}, obstacles[{number}]") for number, entry in enumerate(file.obstacles)
    )
    if file.start.s > main.length:
        raise InputError(f"{where}, start.s", f"{file.start.s:g} m", f"on the main pipe, 0 to {main.length:g} m")
    if file.goal.pipe not in lengths:
        raise InputError(f"{where}, goal.pipe", f"no pipe {file.goal.pipe!r}", f"one of {', '.join(lengths)}")
    if not 0.0 <= file.goal.s <= lengths[file.goal.pipe]:
        valid = f"on the pipe, 0 to {lengths[file.goal.pipe]:g} m"
        raise InputError(f"{where}, goal.s", f"{file.goal.s:g} m", valid)
    if file.goal.pipe == MAIN and file.goal.s <= file.start.s:
        raise InputError(f"{where}, goal.s", f"{file.goal.s:g} m", f"beyond the start at {file.start.s:g} m")
    return PipeRun(
        file.name, file.description, file.source, file.notes, tuple(pipes), obstacles, tuple(crossings),
        file.gravity, file.start.s, math.radians(file.start.clock_deg), file.goal.pipe, file.goal.s,
    )  # fmt: skip


def _check_numbers(file: PipeFile, where: str) -> None:
    """Refuse numbers that are not finite, wherever they stand."""
    for path, value in _numbers("", file):
        if not math.isfinite(value):
            raise InputError(f"{where}, {path}", f"{value:g}", "a finite number")


def _numbers(path: str, value: object) -> list[tuple[str, float]]:
    """Every number of a structure with its path."""
    if isinstance(value, float | int):
        return [(path, float(value))]
    if isinstance(value, tuple):
        items: tuple[object, ...] = value  # pyright: ignore[reportUnknownVariableType]
        return [found for number, item in enumerate(items) for found in _numbers(f"{path}[{number}]", item)]
    names: tuple[str, ...] = getattr(value, "__struct_fields__", ())
    return [found for name in names for found in _numbers(f"{path}.{name}".lstrip("."), getattr(value, name))]


def _main(entry: MainEntry, where: str) -> Pipe:
    """The main pipe, laid from its point."""
    diameter = entry.diameter
    parts: list[Piece] = []
    for number, part in enumerate(entry.parts):
        here = f"{where}, main.parts[{number}]"
        diameter = diameter if part.diameter is None else part.diameter
        if isinstance(part, BendPart):
            if part.radius <= 0.5 * diameter:
                raise InputError(f"{here}.radius", f"{part.radius:g} m", f"over the pipe's own {0.5 * diameter:g} m")
            length = part.radius * math.radians(part.angle_deg)
            parts.append((length, part.radius, math.radians(part.toward_deg), diameter))
        else:
            parts.append((part.length, math.inf, 0.0, diameter))
    if sum(length for length, *_ in parts) > LONGEST:
        raise InputError(f"{where}, main.parts", "over 1 km together", "lengths in metres")
    frame = _frame(np.array(entry.direction), entry.x_axis, where)
    return laid(MAIN, entry.diameter, parts, np.array(entry.point), frame)


def _frame(direction: Array, x_axis: tuple[float, float, float] | None, where: str) -> Array:
    """A frame with z along a direction and x near a given axis, or near the world's axis least along it."""
    size = float(np.linalg.norm(direction))
    if size < 1e-9:
        raise InputError(f"{where}, main.direction", "no length", "a vector along the pipe")
    z = direction / size
    x = np.eye(3)[int(np.argmin(np.abs(z)))] if x_axis is None else np.array(x_axis)
    x = x - (x @ z) * z
    if np.linalg.norm(x) < 1e-9:
        raise InputError(f"{where}, main.x_axis", "along the pipe or of no length", "a vector across the pipe")
    x = x / np.linalg.norm(x)
    return np.stack((x, np.cross(z, x), z), axis=-1)


def _crossing(entry: CrossingEntry, main: Pipe, where: str) -> tuple[Pipe, Crossing]:
    """A crossing pipe; its frame is the main one's turned by the angle between them, within their plane."""
    if not 0.0 < entry.at < main.length:
        raise InputError(f"{where}.at", f"{entry.at:g} m", f"on the main pipe, 0 to {main.length:g} m")
    if not main.parts[int(main.part_at(entry.at))].straight:
        raise InputError(f"{where}.at", f"{entry.at:g} m, in a bend", "a place on a straight")
    if entry.before + entry.after > LONGEST:
        raise InputError(where, "over 1 km long", "lengths in metres")
    point, frame = main.centre_line(entry.at)
    angle, toward = math.radians(entry.angle_deg), math.radians(entry.toward_deg)
    aside = math.cos(toward) * frame[:, 0] + math.sin(toward) * frame[:, 1]
    turned = laid("", 1.0, [(angle, 1.0, toward, None)], np.zeros(3), frame).centre_line(angle)[1]
    along = math.cos(angle) * frame[:, 2] + math.sin(angle) * aside
    parts: list[Piece] = [(entry.before + entry.after, math.inf, 0.0, None)]
    pipe = laid(entry.name, entry.diameter, parts, point - entry.before * along, turned)
    return pipe, Crossing(entry.name, entry.at, entry.before, angle, toward, entry.before > 0.0)


def _obstacle(entry: ObstacleEntry, lengths: dict[str, float], where: str) -> PipeObstacle:
    if entry.pipe not in lengths:
        raise InputError(f"{where}.pipe", f"no pipe {entry.pipe!r}", f"one of {', '.join(lengths)}")
    if not 0.0 <= entry.start < entry.end <= lengths[entry.pipe]:
        what = f"from {entry.start:g} to {entry.end:g} m"
        raise InputError(where, what, f"rising, within the pipe's {lengths[entry.pipe]:g} m")
    clock = None
    if entry.clock_deg is not None:
        first, last = entry.clock_deg
        if not first < last < first + 360.0:
            raise InputError(f"{where}.clock_deg", f"{first:g} to {last:g}", "rising by less than 360")
        clock = (math.radians(first), math.radians(last))
    return PipeObstacle(entry.pipe, entry.start, entry.end, entry.height, clock, entry.note)
