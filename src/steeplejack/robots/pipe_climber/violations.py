"""What a motion asks of the machine beyond its limits: limb, what, when, value, limit, over the whole motion.

Checked are the lengths of the limbs against their reach, their travel over the motion against the stroke of one
cylinder, their speeds, the turns of the hinges where the layout limits them, the linkage's turn, and singularities.
The quantities are smooth; they are looked at in 4,001 moments, and where a limit is passed the moments of passing and
of the worst are found between these, the former to a nanosecond. A limit passed for less than a sample's spacing could
be missed, a singularity not: that is proved (`singular_path`), or said to be not excluded.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np

from steeplejack.robots.pipe_climber.inverse import ROUNDING, hinge_angles, limb_lengths
from steeplejack.robots.pipe_climber.joints import joint_rates
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.motion import Trajectory, states
from steeplejack.robots.pipe_climber.parameters import PipeClimber
from steeplejack.robots.pipe_climber.poses import Array
from steeplejack.robots.pipe_climber.singular_path import check_polynomials

SAMPLES = 4001
ZOOMS, FINE = 5, 65

What = Literal[
    "length",
    "stroke",
    "speed",
    "hinge at the base",
    "hinge at the platform",
    "linkage",
    "singularity",
    "singularity not excluded",
]
Curve = Callable[[Array], Array]


class Violation(NamedTuple):
    """A limit that a motion does not hold, from one moment to another."""

    limb: int | None  # 1 to 3; None where it is not a limb's
    what: What
    from_s: float
    to_s: float
    at_s: float  # of the worst
    value: float  # the worst
    limit: float
    unit: Literal["m", "m/s", "deg"]


def violations(robot: PipeClimber, layout: Layout, motion: Trajectory, claw_offset: float) -> list[Violation]:
    """Every limit a motion passes, in the order of time.

    Args:
        robot: Its speeds, stroke and linkage.
        layout: Hinges, reach, and the limit of the hinges.
        motion: Of the claw's centre.
        claw_offset: hz [m].

    Returns:
        One entry for every stretch of time beyond a limit.
    """

    def lengths(times: Array) -> Array:
        return limb_lengths(layout, states(motion, times, claw_offset).pose)

    def speeds(times: Array) -> Array:
        state = states(motion, times, claw_offset)
        return joint_rates(layout, state.pose, state.velocity)[..., 1]

    found = _singularities(layout, motion, claw_offset)
    least, largest = layout.reach
    for limb in range(3):
        found += _beyond(motion, limb + 1, "length", "m", _column(lengths, limb), largest)
        found += _beyond(motion, limb + 1, "length", "m", _column(lengths, limb), least, below=True)
        found += _beyond(motion, limb + 1, "speed", "m/s", _size(_column(speeds, limb)), robot.cylinders.speed)
        found += _travel(motion, limb + 1, _column(lengths, limb), robot.cylinders.stroke)
        found += _hinges(layout, motion, claw_offset, limb)
    turn = _size(lambda times: np.degrees(states(motion, times, claw_offset).beta[..., 0]))
    found += _beyond(motion, None, "linkage", "deg", turn, math.degrees(robot.rcm.limit))
    return sorted(found, key=lambda one: (one.from_s, one.limb or 0, one.what))


def _hinges(layout: Layout, motion: Trajectory, claw_offset: float, limb: int) -> list[Violation]:
    """Turns of the hinges of a limb beyond their limit."""
    if layout.neutral == "none":
        return []
    counted = layout.neutral

    def turns(times: Array) -> Array:
        return np.degrees(np.abs(hinge_angles(layout, states(motion, times, claw_offset).pose, counted)[..., limb, :]))

    bound = math.degrees(layout.joint_limit)
    ends: tuple[What, What] = ("hinge at the base", "hinge at the platform")
    found: list[Violation] = []
    for end, what in enumerate(ends):
        found += _beyond(motion, limb + 1, what, "deg", _column(turns, end), bound)
    return found


def _singularities(layout: Layout, motion: Trajectory, claw_offset: float) -> list[Violation]:
    """The first place where the motion crosses the singular surface; where that is open, one that says so."""
    turning = claw_offset if motion.offset == "turning" else 0.0
    for begin, end, (x, z, alpha) in motion.pieces():
        lowered = np.array(z, dtype=np.float64)
        lowered[0] -= claw_offset - turning
        check = check_polynomials(layout, (x, lowered, alpha), (0.0, end - begin), turning)
        if check.between is not None:
            low, high = check.between
            what: What = "singularity" if check.verdict == "crosses" else "singularity not excluded"
            return [Violation(None, what, begin + low, begin + high, begin + low, 0.0, 0.0, "m")]
    return []


def _beyond(
    motion: Trajectory,
    limb: int | None,
    what: What,
    unit: Literal["m", "m/s", "deg"],
    curve: Curve,
    limit: float,
    below: bool = False,
) -> list[Violation]:
    """Stretches of time in which a curve is above a limit, or below it."""
    sign = -1.0 if below else 1.0
    bound = sign * limit + ROUNDING * abs(limit)

    def excess(times: Array) -> Array:
        return sign * curve(times) - bound

    times = np.linspace(0.0, motion.duration, SAMPLES)
    outside = excess(times) > 0.0
    edges = np.flatnonzero(np.diff(outside.astype(np.int8), prepend=0, append=0))
    found: list[Violation] = []
    for first, after in zip(edges[::2], edges[1::2], strict=True):
        begin = _passing(excess, float(times[first - 1]), float(times[first])) if first else 0.0
        end = _passing(excess, float(times[after]), float(times[after - 1])) if after < SAMPLES else motion.duration
        at = _worst(excess, times[first:after], begin, end)
        value = float(curve(np.array([at]))[0])
        found.append(Violation(limb, what, begin, end, at, value, limit, unit))
    return found


def _travel(motion: Trajectory, limb: int, curve: Curve, stroke: float) -> list[Violation]:
    """Travel of a limb over the motion beyond the stroke of one cylinder, wherever that is mounted."""
    times = np.linspace(0.0, motion.duration, SAMPLES)
    longest = _worst(curve, times, 0.0, motion.duration)
    shortest = _worst(lambda t: -curve(t), times, 0.0, motion.duration)
    ends = curve(np.array([shortest, longest]))
    travel = float(ends[1] - ends[0])
    if travel <= stroke * (1.0 + ROUNDING):
        return []
    return [Violation(limb, "stroke", 0.0, motion.duration, max(shortest, longest), travel, stroke, "m")]


def _passing(excess: Curve, inside: float, outside: float) -> float:
    """Where an excess passes zero between a moment within the limit and one beyond it."""
    for _ in range(ZOOMS):
        times = np.linspace(inside, outside, FINE)
        first = int(np.argmax(excess(times) > 0.0))
        inside, outside = float(times[first - 1]), float(times[first])
    return outside


def _worst(excess: Curve, times: Array, begin: float, end: float) -> float:
    """Where a curve is greatest between two moments, from samples within."""
    step = times[1] - times[0] if len(times) > 1 else end - begin
    at = float(times[np.argmax(excess(times))])
    for _ in range(ZOOMS):
        fine = np.linspace(max(begin, at - step), min(end, at + step), FINE)
        at, step = float(fine[np.argmax(excess(fine))]), (fine[-1] - fine[0]) / (FINE - 1)
    return at


def _column(curves: Curve, index: int) -> Curve:
    return lambda times: curves(times)[..., index]


def _size(curve: Curve) -> Curve:
    return lambda times: np.abs(curve(times))
