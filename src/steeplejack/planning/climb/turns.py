"""Turns of one gripper from clock to clock, and what holding alone takes on the way of one.

What grip and drives bear between two clocks may be more than at either. How many times more is looked at every few
degrees of the turns for which it can matter.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.alone import KINDS, Kind
from steeplejack.planning.climb.clocks import turned

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]
Judge = Callable[[Indices, Array, Array], Array]
"""Uses (n, 2, kinds) of states: the pose of each, and the clocks of its upper and of its lower gripper (n,) [rad]."""

APART = math.radians(5.0)
"""Of the places of a turn that are looked at; between them a sinusoid rises by 0.1 % at most [rad]."""
ALL, GRIPPER = 2.0, 0.5
"""What the part of a load that turns takes at most, where the robot turns about the lower gripper, and where the lower
gripper turns alone; estimates, in parts of what there is [1]. Between its ends a turn takes at most tan^2 of its half
times that more than they do: an arc lies within its chord and the tangents at its ends."""


@dataclass(frozen=True)
class Turns:
    """Turns of either gripper with the other one in place.

    Attributes:
        gripper: 0 where the upper one turns and the lower one holds, 1 the other way round, (t,).
        start: Upper clock and slot of the lower one near it, (t, 2).
        end: The same when it has turned, (t, 2).
        slot: Of the new clock among those near: the old upper clock where that turns, else the upper clock, (t,).
        clocks: Of the upper and the lower gripper at the start, (t, 2) [rad].
        by: How far they turn, (t, 2) [rad].
    """

    gripper: Indices
    start: Indices
    end: Indices
    slot: Indices
    clocks: Array
    by: Array

    def only(self, keep: Flags | Indices) -> Turns:
        """Some of the turns."""
        return Turns(
            self.gripper[keep], self.start[keep], self.end[keep], self.slot[keep], self.clocks[keep], self.by[keep]
        )


def turns_of(clocks: Array, near: Indices) -> Turns:
    """All turns between clocks (c,) [rad] within the linkage's range, ``near`` (c, b) naming those, -1 for none."""
    have = near >= 0
    upper, slot, to = np.nonzero(have[:, :, None] & have[:, None, :])
    low = near[upper, slot]
    reached = near[upper, to]
    same = near[reached] == low[:, None]  # of the upper clock turned to, which slot is the lower one's
    ends = np.stack((reached, same.argmax(axis=1)), axis=-1)
    up, down = (to > 0) & same.any(axis=1), (to != slot) & (near[low] == reached[:, None]).any(axis=1)
    start, zero = np.stack((upper, slot), axis=-1), np.zeros(len(upper))
    begun = np.stack((clocks[upper], clocks[low]), axis=-1)
    first, second = np.zeros(len(upper), dtype=np.int64), np.ones(len(upper), dtype=np.int64)
    there = np.stack((upper, to), axis=-1)
    upwards = Turns(first, start, ends, to, begun, np.stack((turned(clocks, upper, reached), zero), axis=-1))
    downwards = Turns(second, start, there, to, begun, np.stack((zero, turned(clocks, low, reached)), axis=-1))
    both = upwards.only(up), downwards.only(down)
    return Turns(*(np.concatenate([getattr(one, name) for one in both]) for name in Turns.__dataclass_fields__))


def swing(
    turns: Turns, which: Indices, ends: Array, judge: Judge, moving: float, limit: float
) -> tuple[Array, set[Kind]]:  # fmt: skip
    """How many times what their ends take turns take on the way.

    Turns about one gripper at one clock share the places that are looked at: all that the linkage reaches from there.

    Args:
        turns: t of them.
        which: Pose that each is made in, (t,).
        ends: What start and end take of the gripper that holds, (t, 2).
        judge: Of states.
        moving: `ALL` or `GRIPPER`.
        limit: Of the linkage to either side [rad].

    Returns:
        At least 1, and 1 where either end is too much or both so little that it cannot matter, (t,); and of what some
        state that was looked at takes more than there is.
    """
    most, found, far = ends.max(axis=1), np.ones(len(ends)), np.abs(turns.by).max(axis=1, initial=0.0)
    near = np.flatnonzero((most <= 1.0) & (most > 1.0 - moving * np.tan(0.5 * far) ** 2))
    if not len(near):
        return found, set()
    some, rows = turns.only(near), np.arange(len(near))
    held = some.clocks[rows, 1 - some.gripper]
    columns = np.column_stack((which[near], some.gripper, held)).astype(np.float64)
    about, of = np.unique(columns, axis=0, return_inverse=True)
    uses, steps = _around(about, judge, limit)
    start = (some.clocks[rows, some.gripper] - held + math.pi) % (2.0 * math.pi) - math.pi
    end = start + some.by[rows, some.gripper]
    low, high = np.minimum(start, end)[:, None], np.maximum(start, end)[:, None]
    on_the_way = np.where((steps > low) & (steps < high), uses.max(axis=-1)[of.ravel()], 0.0).max(axis=1)
    found[near] = np.maximum(1.0, on_the_way / most[near])
    return found, exceeded(uses)


def _around(about: Array, judge: Judge, limit: float) -> tuple[Array, Array]:
    """What the gripper that holds takes while the other one turns about it as far as the linkage goes.

    Args:
        about: Pose, gripper that turns, clock of the one that holds [rad], (m, 3).
        judge: Of states.
        limit: Of the linkage to either side [rad].

    Returns:
        (m, j, kinds), and the turns of the linkage (j,) [rad].
    """
    half = max(1, math.ceil(limit / APART))
    steps = limit * np.arange(-half, half + 1) / half
    one = np.repeat(about, len(steps), axis=0)
    pose, turns, held = one[:, 0].astype(np.int64), one[:, 1].astype(np.int64), one[:, 2]
    away = held + np.tile(steps, len(about))
    upper = turns == 0
    uses = judge(pose, np.where(upper, away, held), np.where(upper, held, away))[np.arange(len(one)), turns]
    return uses.reshape(len(about), len(steps), -1), steps


def exceeded(uses: Array) -> set[Kind]:
    """Of what some uses (..., kinds) take more than there is; grips on pipes that grippers are not for do not count."""
    some = (uses > 1.0) & (uses < np.inf)
    return {kind for kind, use in zip(KINDS, some.reshape(-1, len(KINDS)).T, strict=True) if use.any()}
