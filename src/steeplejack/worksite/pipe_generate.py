"""Runs of pipes drawn at random, for trials of planners, and written as the files they could have come from."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import numpy as np

from steeplejack.worksite.pipe_file import (
    MAIN,
    BendPart,
    CrossingEntry,
    GoalEntry,
    MainEntry,
    ObstacleEntry,
    PipeFile,
    Point,
    StartEntry,
    StraightPart,
)

START = 0.05
"""Where the lower gripper begins [m]."""
BEYOND = 0.25
"""Straight pipe left beyond the goal, for the upper gripper [m]."""


def random_pipes(rng: np.random.Generator, name: str = "random") -> PipeFile:
    """A run drawn at random: straights, up to two bends, changes of diameter, up to two obstacles, a crossing pipe.

    Args:
        rng: Where the numbers come from; the same state gives the same run.
        name: Of the run.

    Returns:
        The file of the run; many such runs cannot be climbed.
    """
    parts: list[StraightPart | BendPart] = [StraightPart(length=_drawn(rng, 0.30, 0.50))]
    for _ in range(int(rng.integers(0, 3))):
        if rng.random() < 0.6:
            toward = 180.0 * float(rng.integers(0, 2)) if rng.random() < 0.7 else 30.0 * float(rng.integers(0, 12))
            angle, radius = _drawn(rng, 20.0, 90.0), _drawn(rng, 0.25, 0.80)
            parts.append(BendPart(radius=radius, angle_deg=angle, toward_deg=toward))
        diameter = float(rng.choice([0.050, 0.060, 0.070, 0.086])) if rng.random() < 0.15 else None
        parts.append(StraightPart(length=_drawn(rng, 0.05, 0.35), diameter=diameter))
    parts.append(StraightPart(length=BEYOND))
    length = sum(
        one.length if isinstance(one, StraightPart) else one.radius * math.radians(one.angle_deg) for one in parts
    )
    direction, x_axis = _direction(rng)
    start = 180.0 * float(rng.integers(0, 2)) if rng.random() < 0.8 else 30.0 * float(rng.integers(0, 12))
    first = parts[0]
    crossings = (_crossing(rng, first.length),) if isinstance(first, StraightPart) and rng.random() < 0.1 else ()
    return PipeFile(
        name=name,
        description="a run of pipes drawn at random",
        source="generated",
        start=StartEntry(s=START, clock_deg=start),
        goal=GoalEntry(s=round(length - BEYOND, 4)),
        main=MainEntry(diameter=0.060, parts=tuple(parts), direction=direction, x_axis=x_axis),
        obstacles=tuple(_obstacle(rng, length) for _ in range(int(rng.integers(0, 3)))),
        crossings=crossings,
    )


def _drawn(rng: np.random.Generator, low: float, high: float) -> float:
    return round(float(rng.uniform(low, high)), 4)


def _direction(rng: np.random.Generator) -> tuple[Point, Point]:
    """A direction that leans by any angle from straight up, more often by little, and the sky's for clock 0."""
    lean, around = math.radians(90.0) * float(rng.random()) ** 2, 2.0 * math.pi * float(rng.random())
    aside, up = math.sin(lean), math.cos(lean)
    direction = (round(aside * math.cos(around), 4), round(aside * math.sin(around), 4), round(up, 4))
    return direction, (0.0, 0.0, 1.0) if aside > 0.01 else (1.0, 0.0, 0.0)


def _obstacle(rng: np.random.Generator, length: float) -> ObstacleEntry:
    """A collar or a lug, from below to above what palm, jaws and limbs pass over."""
    start = _drawn(rng, START + 0.2, length - BEYOND)
    first = 10.0 * float(rng.integers(-18, 18))
    clock = None if rng.random() < 0.3 else (first, first + _drawn(rng, 10.0, 120.0))
    return ObstacleEntry(
        start=start, end=round(start + _drawn(rng, 0.002, 0.012), 4), height=_drawn(rng, 0.004, 0.024), clock_deg=clock,
        note="drawn at random",
    )  # fmt: skip


def _crossing(rng: np.random.Generator, length: float) -> CrossingEntry:
    """A pipe across the first straight."""
    return CrossingEntry(
        name="crossing", at=round(0.8 * length, 4), angle_deg=_drawn(rng, 45.0, 135.0), diameter=0.050, before=0.2,
        after=0.4, toward_deg=30.0 * float(rng.integers(0, 12)),
    )  # fmt: skip


def encode_pipes(file: PipeFile) -> str:
    """A run as the text of a TOML file that `pipe_file.decode_pipes` reads back as the same run."""
    fields: dict[str, Any] = msgspec.to_builtins(file)
    main: dict[str, Any] = fields.pop(MAIN)
    lists = {name: fields.pop(name) for name in ("obstacles", "crossings")}
    parts: list[dict[str, Any]] = main.pop("parts")
    blocks = [_table(fields), f"[{MAIN}]\n{_table(main)}"]
    blocks += [f"[[{MAIN}.parts]]\n{_table(part)}" for part in parts]
    blocks += [f"[[{name}]]\n{_table(entry)}" for name, entries in lists.items() for entry in entries]
    return "\n".join(blocks)


def _table(fields: dict[str, Any]) -> str:
    return "".join(f"{name} = {_value(value)}\n" for name, value in fields.items() if value is not None)


def _value(value: Any) -> str:
    """A value in TOML: JSON but for tables, which stand inline with their names bare."""
    if isinstance(value, dict):
        items: dict[str, Any] = value  # pyright: ignore[reportUnknownVariableType]
        return "{ " + ", ".join(f"{name} = {_value(one)}" for name, one in items.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(one) for one in value) + "]"  # pyright: ignore[reportUnknownVariableType]
    return msgspec.json.encode(value).decode()
