"""Situations for the safety monitor: one that is well on every count, and each way to leave it, with what it must say.

Cables run along x and stays too, so that the pull along a stay is the tension itself and limits can be met exactly.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from steeplejack.safety import Limits

LIMITS = Limits(
    commanded=(8.0, 262.0),
    tension=(5.0, 275.0),
    hold=240.0,
    drive=140.0,
    winch_speed=1.0,
    base_speed=0.75,
    fence=0.5,
    creep=0.02,
    palm=520.0,
    turn_rate=0.3,
    turn=0.05,
    allowance=12.0,
    imbalance=1e9,
)
WIDE = replace(LIMITS, hold=1e6, drive=1e6)  # the pull along the stay never binds
WIND = replace(LIMITS, creep=1e6)  # gripped bases may move
FRAME = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # a quarter turn about z
FLAT = {"limits": replace(LIMITS, imbalance=0.0)}
ALONG = np.array([1.0, 0.0, 0.0])
LENGTHS = (8.0, 16.0, 32.0, 4.0)
COMMANDS = ("pull", "traction", "turn")


class Case(NamedTuple):
    """Arguments of ``check``, by name, and the answer it must give."""

    name: str
    arguments: dict[str, Any]
    answer: tuple[int, int]


def well() -> dict[str, Any]:
    """A squad at rest with every quantity inside its limits; one base is under way."""
    attachments = np.array([[-0.25, -0.25, 0.0], [0.25, -0.25, 0.0], [0.25, 0.25, 0.0], [-0.25, 0.25, 0.0]])
    position = np.array([2.0, 3.0, 4.0])
    ends = position + attachments @ FRAME.T
    return {
        "command": np.array([[60.0, 70.0, 80.0, 90.0], [0.0, 40.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0]]),
        "tension": np.array([61.0, 71.0, 81.0, 91.0]),
        "pay_rate": np.zeros(4),
        "s_rate": np.zeros(4),
        "palm": np.array([600.0, 0.0, 605.0, 590.0]),
        "grip": np.array([True, False, True, True]),
        "turned": np.array([0.01, 0.7, -0.01, 0.0]),
        "moving": np.array([False, True, False, False]),
        "exits": ends + np.array([[-8.0], [16.0], [32.0], [-4.0]]) * ALONG,
        "tangents": np.tile(ALONG, (4, 1)) * np.array([[1.0], [1.0], [-1.0], [-1.0]]),
        "attachments": attachments,
        "lengths": np.array(LENGTHS),
        "weight": np.array([3.0, 4.0, -12.0]),  # the tensions alone balance
        "goal": position,
        "goal_rotation": FRAME.copy(),
        "limits": LIMITS,
    }


def standing() -> dict[str, Any]:
    """Arguments in which all four bases stand, gripped."""
    command = well()["command"]
    command[1:] = 0.0
    return {
        "command": command,
        "moving": np.zeros(4, bool),
        "palm": np.full(4, 600.0),
        "grip": np.ones(4, bool),
        "turned": np.zeros(4),
    }


def driving(base: int) -> dict[str, Any]:
    """Arguments in which one base is under way, palms open, and the others stand."""
    arguments = standing()
    arguments["moving"][base], arguments["palm"][base], arguments["grip"][base] = True, 0.0, False
    return arguments


def changed(name: str, index: Any, value: Any, **others: Any) -> dict[str, Any]:
    """The well situation with one entry of one argument set, and whole arguments replaced.

    ``pull``, ``traction`` and ``turn`` are the rows of the command.
    """
    arguments = well() | others
    if name in COMMANDS:
        name, index = "command", (COMMANDS.index(name), index)
    array = arguments[name].copy()
    array[index] = value
    return arguments | {name: array}


def _above(limit: float) -> float:
    return math.nextafter(limit, math.inf)


def _below(limit: float) -> float:
    return math.nextafter(limit, -math.inf)


def edges() -> Iterator[Case]:
    """Every limit exactly met, and missed by the least number, on every cable and base."""
    none = (0, -1)
    low, high = LIMITS.commanded
    slack, tight = LIMITS.tension
    for i in range(4):
        gripped, free = standing(), driving(i)
        for name, array, code, limit, beyond, others in (
            ("least pull", "pull", 2, low, _below(low), {}),
            ("largest pull", "pull", 2, high, _above(high), {"limits": WIDE}),
            ("slack", "tension", 4, slack, _below(slack), {}),
            ("tight", "tension", 3, tight, _above(tight), {"limits": WIDE}),
            ("hold", "tension", 5, LIMITS.hold, _above(LIMITS.hold), gripped),
            ("drive", "tension", 6, LIMITS.drive, _above(LIMITS.drive), free),
            ("told to hold", "pull", 17, 252.0, 252.0 + 1e-9, gripped),
            ("told to drive", "pull", 17, 152.0, 152.0 + 1e-9, free),
            ("hauling", "pay_rate", 7, -1.0, _below(-1.0), {}),
            ("paying out", "pay_rate", 7, 1.0, _above(1.0), {}),
            ("driving up", "s_rate", 8, 0.75, _above(0.75), free),
            ("driving down", "s_rate", 8, -0.75, _below(-0.75), free),
            ("gripped and fast", "s_rate", 8, 0.75, _above(0.75), gripped | {"limits": WIND}),
            ("creeping up", "s_rate", 10, 0.02, _above(0.02), gripped),
            ("creeping down", "s_rate", 10, -0.02, _below(-0.02), gripped),
            ("palms", "palm", 11, 520.0, _below(520.0), gripped),
            ("turned by wind", "turned", 14, 0.05, _above(0.05), gripped),
            ("turned back", "turned", 14, -0.05, _below(-0.05), gripped),
            ("traction up", "traction", 12, 140.0, _above(140.0), free),
            ("traction down", "traction", 12, -140.0, _below(-140.0), free),
            ("traction on a standing base", "traction", 12, 0.0, _above(0.0), gripped),
            ("turning", "turn", 13, 0.3, _above(0.3), free),
            ("turning back", "turn", 13, -0.3, _below(-0.3), free),
            ("turning a standing base", "turn", 13, 0.0, _below(0.0), gripped),
            ("cable too long", "lengths", 9, LENGTHS[i] + 0.5, _above(LENGTHS[i] + 0.5), {}),
            ("cable too short", "lengths", 9, LENGTHS[i] - 0.5, _below(LENGTHS[i] - 0.5), {}),
        ):
            yield Case(f"{name} at the limit, {i}", changed(array, i, limit, **others), none)
            yield Case(f"{name} beyond it, {i}", changed(array, i, beyond, **others), (code, i))
        yield Case(f"a base under way may move, {i}", changed("s_rate", i, 0.5, **free), none)
        yield Case(f"a gripped base may not, {i}", changed("s_rate", i, 0.5, **gripped), (10, i))
        yield Case(f"and may turn, {i}", changed("turned", i, 1.0, **free), none)
        yield Case(f"closing its palms again, {i}", changed("grip", i, True, **free), none)
        yield Case(f"a standing base told to let go, {i}", changed("grip", i, False, **gripped), (15, i))
        other = (i + 1) % 4
        two = changed("moving", other, True, **free)
        yield Case(f"two bases under way, {i}", two, (16, -1))
        slipping = two | {"lengths": np.full(4, 1.0)}
        yield Case(f"two bases under way come after a fence, {i}", slipping, (9, 0))
    behind = np.array([1.4, 3.0, 4.0])
    yield Case("a goal far along the cables", well() | {"goal": behind}, (9, 0))
    for limit, answer in ((13.0, none), (13.0 - 1e-9, (18, -1))):
        yield Case(f"unbalanced by {limit} N", well() | {"limits": replace(LIMITS, imbalance=limit)}, answer)
    for i, share in ((0, -1.0), (1, 1.0)):
        pulled = changed("tension", i, well()["tension"][i] + 21.0, weight=np.array([0.0, 0.0, 20.0]))
        for limit, answer in ((29.0, none), (29.0 - 1e-9, (18, -1))):
            case = pulled | {"limits": replace(LIMITS, imbalance=limit)}
            yield Case(f"21 N along {share:+g} x and 20 N along z against {limit} N, {i}", case, answer)


def oblique() -> Iterator[Case]:
    """A stay across its cable carries no pull along itself; one at an angle the share of its cosine."""
    limits = replace(WIDE, hold=100.0)
    for axis in (1, 2):
        across = np.zeros((4, 3))
        across[:, axis] = 1.0
        arguments = changed("tension", 0, 270.0, tangents=across, limits=limits, **standing())
        yield Case(f"stay across its cable, axis {axis}", arguments, (0, -1))
    for axis, sign in ((0, 1.0), (1, -1.0), (2, 1.0)):
        for i in range(4):
            stay = np.zeros((4, 3))
            stay[:, axis] = 1.0
            exits = well()["goal"] + well()["attachments"] @ FRAME.T
            exits = exits + 8.0 * (0.6 * np.roll(ALONG, axis) + sign * 0.8 * np.roll(ALONG, axis + 1))
            arguments = {
                "tangents": stay,
                "exits": exits,
                "lengths": np.full(4, 8.0),
                "limits": limits,
                **standing(),
            }
            yield Case(f"share 0.6 under, {axis} {i}", changed("tension", i, 166.0, **arguments), (0, -1))
            yield Case(f"share 0.6 over, {axis} {i}", changed("tension", i, 167.0, **arguments), (5, i))
    exits = well()["goal"] + well()["attachments"] @ FRAME.T + 8.0 * np.array([1.0, 2.0, 2.0]) / 3.0
    stay = np.tile([2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0], (4, 1))
    arguments = {
        "tangents": stay,
        "exits": exits,
        "lengths": np.full(4, 8.0),
        "limits": limits,
        **standing(),
    }
    for i in range(4):
        yield Case(f"share 8/9 under, {i}", changed("tension", i, 112.0, **arguments), (0, -1))
        yield Case(f"share 8/9 over, {i}", changed("tension", i, 113.0, **arguments), (5, i))


def not_numbers() -> Iterator[Case]:
    """Nan and infinities in everything measured and commanded."""
    for value in (math.nan, math.inf, -math.inf):
        for i in range(4):
            for name in (*COMMANDS, "tension", "pay_rate", "s_rate", "palm", "turned", "lengths"):
                yield Case(f"{name} {value}, {i}", changed(name, i, value), (1, i))
        for axis in range(3):
            yield Case(f"goal {value}, {axis}", changed("goal", axis, value), (1, 0))
    for i in range(4):
        for name in ("exits", "tangents", "attachments"):
            yield Case(f"{name} nan, {i}", changed(name, (i, 0), math.nan), (1, i))
    yield Case("rotation nan", changed("goal_rotation", (0, 0), math.nan), (1, 0))


def order() -> Iterator[Case]:
    """The first cable in trouble is named, its first trouble first."""
    yield Case("lower index first", changed("tension", slice(1, 4), 1.0), (4, 1))
    yield Case("cable before cable", changed("pull", 2, 1.0, tension=np.full(4, 1e3)), (3, 0))
    yield Case("command before measurement", changed("pull", 0, 1.0, tension=np.full(4, 1e3)), (2, 0))
    tiny = {"limits": replace(LIMITS, drive=1.0)}
    yield Case("pull before traction", changed("pull", 1, 1.0) | tiny, (2, 1))
    yield Case("traction before turn", changed("turn", 1, 1.0) | tiny, (12, 1))
    yield Case("turn before palms", changed("turn", 0, 1.0, grip=np.zeros(4, bool)), (13, 0))
    yield Case("palms before tension", changed("grip", 0, False, tension=np.full(4, 1.0)), (15, 0))
    yield Case(
        "crowd before imbalance", well() | driving(0) | {"moving": np.array([1, 1, 0, 0], bool), **FLAT}, (16, -1)
    )
    yield Case("tension before pull along the stay", changed("tension", 0, 300.0), (3, 0))
    yield Case("speed before creep", changed("s_rate", 0, 0.8), (8, 0))
    yield Case("winch before base", changed("s_rate", 0, 0.8, pay_rate=np.full(4, 2.0)), (7, 0))
    yield Case("palms before creep", changed("palm", 0, 1.0, s_rate=np.full(4, 0.1)), (11, 0))
    yield Case("creep before fence", changed("s_rate", 0, 0.1, lengths=np.full(4, 1.0)), (10, 0))


CASES = (Case("all well", well(), (0, -1)), *edges(), *oblique(), *not_numbers(), *order())
