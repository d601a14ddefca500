"""Situations for the safety monitor: one that is well on every count, and each way to leave it, with what it must say.

Cables run along x and stays too, so that the pull along a stay is the tension itself and limits can be met exactly.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from steeplejack.safety import Limits

LIMITS = Limits(
    commanded=np.array([8.0, 262.0]),
    tension=np.array([5.0, 275.0]),
    hold=240.0,
    drive=140.0,
    winch_speed=1.0,
    base_speed=0.75,
    fence=0.5,
    creep=0.02,
)
WIDE = LIMITS._replace(hold=1e6, drive=1e6)  # the pull along the stay never binds
WIND = LIMITS._replace(creep=1e6)  # gripped bases may move
FRAME = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # a quarter turn about z
ALONG = np.array([1.0, 0.0, 0.0])


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
        "pull": np.array([60.0, 70.0, 80.0, 90.0]),
        "tension": np.array([61.0, 71.0, 81.0, 91.0]),
        "pay_rate": np.zeros(4),
        "s_rate": np.zeros(4),
        "moving": np.array([False, True, False, False]),
        "exits": ends + np.array([[-8.0], [16.0], [32.0], [-4.0]]) * ALONG,
        "tangents": np.tile(ALONG, (4, 1)) * np.array([[1.0], [1.0], [-1.0], [-1.0]]),
        "attachments": attachments,
        "position": position,
        "rotation": FRAME.copy(),
        "goal": position.copy(),
        "limits": LIMITS,
    }


def changed(name: str, index: Any, value: Any, **others: Any) -> dict[str, Any]:
    """The well situation with one entry of one argument set, and whole arguments replaced."""
    arguments = well() | others
    array = arguments[name].copy()
    array[index] = value
    return arguments | {name: array}


def _above(limit: float) -> float:
    return math.nextafter(limit, math.inf)


def _below(limit: float) -> float:
    return math.nextafter(limit, -math.inf)


def edges() -> Iterator[Case]:
    """Every limit exactly met, and missed by the least number, on every cable and base."""
    none, still, moving = (0, -1), np.zeros(4, bool), np.ones(4, bool)
    low, high = LIMITS.commanded
    slack, tight = LIMITS.tension
    for i in range(4):
        for name, array, code, limit, beyond, others in (
            ("least pull", "pull", 2, low, _below(low), {}),
            ("largest pull", "pull", 2, high, _above(high), {}),
            ("slack", "tension", 4, slack, _below(slack), {}),
            ("tight", "tension", 3, tight, _above(tight), {"limits": WIDE}),
            ("hold", "tension", 5, LIMITS.hold, _above(LIMITS.hold), {"moving": still}),
            ("drive", "tension", 6, LIMITS.drive, _above(LIMITS.drive), {"moving": moving}),
            ("hauling", "pay_rate", 7, -1.0, _below(-1.0), {}),
            ("paying out", "pay_rate", 7, 1.0, _above(1.0), {}),
            ("driving up", "s_rate", 8, 0.75, _above(0.75), {"moving": moving}),
            ("driving down", "s_rate", 8, -0.75, _below(-0.75), {"moving": moving}),
            ("gripped and fast", "s_rate", 8, 0.75, _above(0.75), {"moving": still, "limits": WIND}),
            ("creeping up", "s_rate", 10, 0.02, _above(0.02), {"moving": still}),
            ("creeping down", "s_rate", 10, -0.02, _below(-0.02), {"moving": still}),
        ):
            yield Case(f"{name} at the limit, {i}", changed(array, i, limit, **others), none)
            yield Case(f"{name} beyond it, {i}", changed(array, i, beyond, **others), (code, i))
        free = changed("s_rate", i, 0.5, moving=moving)
        yield Case(f"a base under way may move, {i}", free, none)
        yield Case(f"a gripped base may not, {i}", free | {"moving": still}, (10, i))
    for axis in range(3):
        for sign in (-1.0, 1.0):
            away = np.array([2.0, 3.0, 4.0])
            away[axis] += sign * LIMITS.fence
            over = away.copy()
            over[axis] += sign * 1e-9
            yield Case(f"fence met, {sign:+g} {axis}", well() | {"goal": away}, none)
            yield Case(f"fence left, {sign:+g} {axis}", well() | {"goal": over}, (9, -1))
    both = np.array([2.4, 3.4, 4.0])
    yield Case("fence is a sphere, not a box", well() | {"goal": both}, (9, -1))


def oblique() -> Iterator[Case]:
    """A stay across its cable carries no pull along itself; one at an angle the share of its cosine."""
    still = np.zeros(4, bool)
    limits = WIDE._replace(hold=100.0)
    for axis in (1, 2):
        across = np.zeros((4, 3))
        across[:, axis] = 1.0
        arguments = changed("tension", 0, 270.0, tangents=across, moving=still, limits=limits)
        yield Case(f"stay across its cable, axis {axis}", arguments, (0, -1))
    for axis, sign in ((0, 1.0), (1, -1.0), (2, 1.0)):
        for i in range(4):
            stay = np.zeros((4, 3))
            stay[:, axis] = 1.0
            exits = well()["position"] + well()["attachments"] @ FRAME.T
            exits = exits + 8.0 * (0.6 * np.roll(ALONG, axis) + sign * 0.8 * np.roll(ALONG, axis + 1))
            arguments = {"tangents": stay, "exits": exits, "moving": still, "limits": limits}
            yield Case(f"share 0.6 under, {axis} {i}", changed("tension", i, 166.0, **arguments), (0, -1))
            yield Case(f"share 0.6 over, {axis} {i}", changed("tension", i, 167.0, **arguments), (5, i))
    exits = well()["position"] + well()["attachments"] @ FRAME.T + 8.0 * np.array([1.0, 2.0, 2.0]) / 3.0
    stay = np.tile([2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0], (4, 1))
    arguments = {"tangents": stay, "exits": exits, "moving": still, "limits": limits}
    for i in range(4):
        yield Case(f"share 8/9 under, {i}", changed("tension", i, 112.0, **arguments), (0, -1))
        yield Case(f"share 8/9 over, {i}", changed("tension", i, 113.0, **arguments), (5, i))


def not_numbers() -> Iterator[Case]:
    """Nan and infinities in everything measured and commanded."""
    for value in (math.nan, math.inf, -math.inf):
        for i in range(4):
            for name in ("pull", "tension", "pay_rate", "s_rate"):
                yield Case(f"{name} {value}, {i}", changed(name, i, value), (1, i))
        for axis in range(3):
            for name in ("position", "goal"):
                yield Case(f"{name} {value}, {axis}", changed(name, axis, value), (1, -1))
    for i in range(4):
        for name in ("exits", "tangents", "attachments"):
            yield Case(f"{name} nan, {i}", changed(name, (i, 0), math.nan), (1, i))
    yield Case("rotation nan", changed("rotation", (0, 0), math.nan), (1, 0))


def order() -> Iterator[Case]:
    """The first cable in trouble is named, its first trouble first, the fence last."""
    far = np.array([9.0, 9.0, 9.0])
    yield Case("cable before fence", changed("tension", 3, 1.0, goal=far), (4, 3))
    yield Case("lower index first", changed("tension", slice(1, 4), 1.0), (4, 1))
    yield Case("command before measurement", changed("pull", 2, 1.0, tension=np.full(4, 1e3)), (3, 0))
    yield Case("and on one cable", changed("pull", 0, 1.0, tension=np.full(4, 1e3)), (2, 0))
    yield Case("tension before pull along the stay", changed("tension", 0, 300.0), (3, 0))
    yield Case("speed before creep", changed("s_rate", 0, 0.8), (8, 0))
    yield Case("winch before base", changed("s_rate", 0, 0.8, pay_rate=np.full(4, 2.0)), (7, 0))


CASES = (Case("all well", well(), (0, -1)), *edges(), *oblique(), *not_numbers(), *order())
