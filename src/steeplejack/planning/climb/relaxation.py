"""A limit given way to: what a run and its climber become when a share of a limit is taken away.

A relaxation takes a problem from what it is (share 0) to as far as is worth asking (share 1), by equal factors for
equal steps of the share, ``value = now (far / now)**share``, or by equal amounts. Amounts are said rounded to the side
further relaxed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgspec

from steeplejack.robots.pipe_climber.parameters import PipeClimber
from steeplejack.worksite.pipe_run import PipeRun

Problem = tuple[PipeRun, PipeClimber]


@dataclass(frozen=True)
class Relaxation:
    """One limit, given way to.

    Attributes:
        limit: Its name, with its value.
        change: The problem with a share of the relaxation, 0 to 1; `SteeplejackError` where it makes no sense.
        amount: How to say that share.
        graded: Whether shares between 0 and 1 mean anything.
        place: With a share, where a place of the changed main pipe is on the pipe as it is [m].
    """

    limit: str
    change: Callable[[float], Problem]
    amount: Callable[[float], str]
    graded: bool = True
    place: Callable[[float, float], float] = lambda _share, s: s


def number(
    run: PipeRun, robot: PipeClimber, field: tuple[str, str], values: Callable[[float], float], limit: str,
    amount: Callable[[float], str],
) -> Relaxation:  # fmt: skip
    """One number of one table of the robot file, as it goes with the share."""
    table, name = field
    return Relaxation(limit, lambda k: (run, changed(robot, table, **{name: values(k)})), lambda k: amount(values(k)))


def changed(robot: PipeClimber, table: str, **values: Any) -> PipeClimber:
    """The machine with other values in one table of its file."""
    part = getattr(robot, table)
    return msgspec.structs.replace(robot, **{table: msgspec.structs.replace(part, **values)})


def evenly(now: float, far: float) -> Callable[[float], float]:
    """From one value to another by equal amounts."""
    return lambda share: now + share * (far - now)


def by_factors(now: float, far: float) -> Callable[[float], float]:
    """From one positive value to another by equal factors."""
    return lambda share: now * (far / now) ** share


def rounded_up(value: float, digits: int = 0) -> str:
    """Rounded up, but for what is rounding already."""
    scale = 10.0**digits
    return f"{math.ceil(value * scale - 1e-6) / scale:.{digits}f}"


def rounded_down(value: float, digits: int = 0) -> str:
    """Rounded toward zero, but for what is rounding already."""
    scale = 10.0**digits
    return f"{math.trunc(value * scale + math.copysign(1e-6, value)) / scale:.{digits}f}"


def in_mm(length: float) -> str:
    """A length [m] in whole mm, rounded up."""
    return rounded_up(1e3 * length)
