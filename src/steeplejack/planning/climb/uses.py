"""How much of grips and drives every state of the lattice takes: see `alone`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from steeplejack.planning.climb.alone import KINDS, EitherWay, Kind, either_way, seen, uses_alone
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.pairs import Joined, poses_at
from steeplejack.planning.climb.places import Places
from steeplejack.planning.climb.turns import ALL, GRIPPER, Turns, exceeded, swing, turns_of
from steeplejack.robots.pipe_climber.grippers import free_gripper
from steeplejack.worksite.pipe_run import PipeRun

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

GAPS = 7
"""Distances of the grippers on one straight between which the use of a grip is interpolated, from above."""
FAR = 1e30
"""Use that stands for any larger one, finite so that shares of it are [1]."""
NUDGE = 1e-5
"""By how much a gripper goes on to see which way the mechanism moves [m]."""


@dataclass(frozen=True)
class Uses:
    """What holding alone takes in every state, and how many times that on the way from clock to clock.

    Attributes:
        of: Of the lower and of the upper gripper, the most of grip, force and torque, by pair, upper clock and lower
            one near it, (k, c, b, 2); infinite where a pair has no pose at a clock.
        kinds: Row of each pair on one straight in the next table, -1 for the others, (k,).
        swing_on: Of turns of the (upper, lower) gripper from upper and lower clock to the clocks near, see
            `turns.Turns`, (kinds, 2, c, b, b).
        swing_off: Of the lower gripper's turns of the other pairs, the most of any, (k,).
        scarce: Of what some state takes more than there is.
        least: Of the lower and of the upper gripper, what the state that takes least of each of `KINDS` does, (2, 3).
    """

    of: NDArray[np.float32]
    kinds: Indices
    swing_on: NDArray[np.float32]
    swing_off: NDArray[np.float32]
    scarce: set[Kind]
    least: Array


def uses_of_states(
    run: PipeRun, machine: Machine, lower: Places, upper: Places, pairs: Indices, joined: Joined, sides: Indices,
    clocks: Array, near: Indices,
) -> Uses:  # fmt: skip
    """`Uses` of a lattice.

    On one straight they are interpolated between a few distances of the grippers: from above for grips, whose use is
    convex in the weight's moment, and for forces within 1e-4 of what there is.
    """
    uses = np.full((len(pairs), *near.shape, 2), np.inf, dtype=np.float32)
    turns = turns_of(clocks, near)
    kinds, swing_on, scarce, least = _on_straights(run, machine, lower, upper, pairs, joined, clocks, near, turns, uses)
    swing_off, below = np.ones(len(pairs), dtype=np.float32), turns.only(turns.gripper == 1)
    for side in range(2):
        rows = np.flatnonzero(~joined.coaxial & joined.allowed[:, side] & (sides[:, side] >= 0))
        if not len(rows):
            continue
        at = sides[rows, side]
        poses, ends = joined.poses[rows, side], (lower.only(pairs[rows, 0]), upper.only(pairs[rows, 1]))
        ways = directions(run, machine, *ends, clocks[at])
        judge = partial(states, run, machine, *ends, poses, either_way(machine, poses, ways))
        which, slot = np.nonzero(near[at] >= 0)
        found = judge(which, clocks[at[which]], clocks[near[at[which], slot]])
        uses[rows[which], at[which], slot] = _most(found)
        scarce |= exceeded(found)
        least = np.fmin(least, np.fmin.reduce(found, axis=0, initial=np.inf))
        row, turn = np.nonzero(at[:, None] == below.start[:, 0])
        pair, one = rows[row], below.only(turn)
        taken = np.stack([uses[pair, *end.T, 1] for end in (one.start, one.end)], axis=-1).astype(np.float64)
        more, kinds_of_it = swing(one, row, taken, judge, GRIPPER, machine.robot.rcm.limit)
        np.maximum.at(swing_off, pair, more.astype(np.float32))
        scarce |= kinds_of_it
    return Uses(uses, kinds, swing_on, swing_off, scarce, least)


def directions(run: PipeRun, machine: Machine, lower: Places, upper: Places, clocks: Array) -> Array:
    """How poses change when the upper, and when the lower gripper goes on along its pipe, (k, 2, 3) [1, 1, rad/m].

    Args:
        run: Of pipes.
        machine: What climbs.
        lower: Places of the lower gripper, k of them.
        upper: Those of the upper one.
        clocks: Of the mechanism's X axis about the lower pipe, (k,) [rad].
    """
    ways = np.empty((len(clocks), 2, 3))
    for moves in range(2):  # 0 the upper one: the lower one holds
        poses: list[Array] = []
        for nudge in (NUDGE, -NUDGE):
            ends = [(lower.points, lower.frames), (upper.points, upper.frames)]
            ends[1 - moves] = (upper, lower)[moves].beside(run, machine, nudge)
            poses.append(poses_at(machine, ends[0], ends[1], clocks))
        ways[:, moves] = (poses[0] - poses[1]) / (2.0 * NUDGE)
    return ways


def states(
    run: PipeRun, machine: Machine, lower: Places, upper: Places, poses: Array, moving: EitherWay, which: Indices,
    high: Array, low: Array,
) -> Array:  # fmt: skip
    """`alone.uses_alone` of states (k, 2, 3), whichever way the open gripper moves and turns.

    Args:
        run: Of pipes.
        machine: What climbs.
        lower: Places of the lower gripper, j of them.
        upper: Those of the upper one.
        poses: (j, 3) [m, m, rad].
        moving: Inertia in them.
        which: Places and pose of each state, (k,).
        high: Clocks of the upper gripper, (k,) [rad].
        low: Those of the lower one.
    """
    beta = (high - low + math.pi) % (2.0 * math.pi) - math.pi
    freedoms = np.append(poses[which], beta[:, None], axis=1)
    frames = lower.frames[which] @ Rotation.from_euler("z", low[:, None]).as_matrix()
    both = np.stack((frames, frames @ free_gripper(freedoms, machine.claw_offset)[:, :3, :3]), axis=1)
    feet, lines = (np.stack((getattr(lower, one), getattr(upper, one)), axis=1)[which] for one in ("footing", "lines"))
    gravity = np.array(run.gravity) @ frames
    return uses_alone(machine, freedoms, gravity, feet, seen(lines, both), moving.at(which, beta))


def _on_straights(
    run: PipeRun, machine: Machine, lower: Places, upper: Places, pairs: Indices, joined: Joined, clocks: Array,
    near: Indices, turns: Turns, uses: NDArray[np.float32],
) -> tuple[Indices, NDArray[np.float32], set[Kind], Array]:  # fmt: skip
    """Fill in the states of coaxial pairs, straight by straight and footing by footing.

    Returns:
        ``kinds``, ``swing_on``, ``scarce`` and ``least`` of `Uses`.
    """
    scarce, least = set[Kind](), np.full((2, len(KINDS)), np.inf)
    ends = (lower.only(pairs[:, 0]), upper.only(pairs[:, 1]))
    columns = [column for end in ends for column in (end.pipe, _part(run, end), *end.footing.T)]
    keys = np.stack(columns, axis=-1).astype(np.float64)
    high, slot = np.nonzero(near >= 0)
    low = near[high, slot]
    ways = np.zeros((GAPS, 2, 3))
    ways[:, 0, 1], ways[:, 1, 1] = 1.0, -1.0
    each, kind_of = np.unique(keys[joined.coaxial], axis=0, return_inverse=True)
    kinds = np.full(len(pairs), -1, dtype=np.int64)
    kinds[joined.coaxial] = kind_of.ravel()
    swings = np.ones((len(each), 2, *near.shape, near.shape[1]), dtype=np.float32)
    for number in range(len(each)):
        rows = np.flatnonzero(kinds == number)
        gaps = joined.poses[rows, 0, 1]
        knots = np.linspace(gaps.min(), gaps.max() + 1e-12, GAPS)
        poses = np.zeros((GAPS, 3))
        poses[:, 1] = knots
        count = len(high)
        pair = np.full(GAPS, rows[0])
        judge = partial(
            states, run, machine, ends[0].only(pair), ends[1].only(pair), poses, either_way(machine, poses, ways)
        )
        every = np.repeat(np.arange(GAPS), count), np.tile(clocks[high], GAPS), np.tile(clocks[low], GAPS)
        table = judge(*every).reshape(GAPS, count, 2, len(KINDS))
        at = np.clip((gaps - knots[0]) / (knots[1] - knots[0]), 0.0, GAPS - 1.0)
        below = np.minimum(at.astype(np.int64), GAPS - 2)
        share = (at - below)[:, None, None]
        most, least = _most(table), np.fmin(least, np.fmin.reduce(table.reshape(-1, 2, len(KINDS)), axis=0))
        uses[rows[:, None], high[None], slot[None]] = (1.0 - share) * most[below] + share * most[below + 1]
        dense = np.full((GAPS, *near.shape, 2), np.inf)
        dense[:, high, slot] = most
        taken = np.stack([dense[:, *end.T, turns.gripper].ravel() for end in (turns.start, turns.end)], axis=-1)
        gap, turn = np.divmod(np.arange(len(taken)), max(len(turns.slot), 1))
        more, kinds_of_it = swing(turns.only(turn), gap, taken, judge, ALL, machine.robot.rcm.limit)
        where = number, turns.gripper, *turns.start.T, turns.slot
        swings[where] = more.reshape(GAPS, -1).max(axis=0)
        scarce |= exceeded(table) | kinds_of_it
    return kinds, swings, scarce, least


def _most(found: Array) -> Array:
    """Of grip, force and torque (..., kinds); `FAR` at a singular pose and for what is more than that."""
    most = found.max(axis=-1)
    return np.where(most < FAR, most, FAR)


def _part(run: PipeRun, places: Places) -> Indices:
    found = np.empty(len(places.s), dtype=np.int64)
    for index, pipe in enumerate(run.pipes):
        mine = places.pipe == index
        found[mine] = pipe.part_at(places.s[mine])
    return found
