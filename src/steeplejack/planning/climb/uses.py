"""How much of grips and drives every state of the lattice takes: see `alone`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.alone import KINDS, Kind, either_way, uses_alone
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.pairs import Joined, poses_at
from steeplejack.planning.climb.places import Places
from steeplejack.worksite.pipe_run import PipeRun

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

GAPS = 7
"""Distances of the grippers on one straight between which the use of a grip is interpolated, from above."""
NUDGE = 1e-5
"""By how much a gripper goes on to see which way the mechanism moves [m]."""


def uses_of_states(
    run: PipeRun, machine: Machine, lower: Places, upper: Places, pairs: Indices, joined: Joined, sides: Indices,
    clocks: Array, near: Indices,
) -> tuple[NDArray[np.float32], set[Kind]]:  # fmt: skip
    """What the lower and the upper gripper's holding alone takes, by pair, upper clock and lower one near it.

    On one straight it is a convex function of the distance of the grippers, which the weight's moment follows, so
    that chords between a few distances bound it from above.

    Returns:
        (k, c, b, 2), the most of grip, force and torque; infinite where a pair has no pose at a clock. And of which
        some state takes more than there is.
    """
    uses = np.full((len(pairs), *near.shape, 2), np.inf, dtype=np.float32)
    scarce = _on_straights(run, machine, lower, upper, pairs, joined, clocks, near, uses)
    wide = near.shape[1]
    for side in range(2):
        rows = np.flatnonzero(~joined.coaxial & joined.allowed[:, side] & (sides[:, side] >= 0))
        if not len(rows):
            continue
        high = np.repeat(sides[rows, side], wide)
        low, many = near[sides[rows, side]].ravel(), np.repeat(np.arange(len(rows)), wide)
        have = np.flatnonzero(low >= 0)
        slot = np.tile(np.arange(wide), len(rows))[have]
        high, low, many = high[have], low[have], many[have]
        poses, ends = joined.poses[rows, side], (lower.only(pairs[rows, 0]), upper.only(pairs[rows, 1]))
        ways = directions(run, machine, *ends, clocks[sides[rows, side]])
        found = states(run, machine, *ends, poses, ways, many, clocks[high], clocks[low])
        uses[rows[many], high, slot] = found.max(axis=-1)
        scarce |= _scarce(found)
    return uses, scarce


def _scarce(uses: Array) -> set[Kind]:
    """Of what some of the uses (..., 3) take more than there is."""
    return {kind for kind, use in zip(KINDS, uses.reshape(-1, len(KINDS)).T, strict=True) if (use > 1.0).any()}


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
    run: PipeRun, machine: Machine, lower: Places, upper: Places, poses: Array, ways: Array, which: Indices,
    high: Array, low: Array,
) -> Array:  # fmt: skip
    """`alone.uses_alone` of states (k, 2, 3), whichever way the open gripper moves and turns.

    Args:
        run: Of pipes.
        machine: What climbs.
        lower: Places of the lower gripper, j of them.
        upper: Those of the upper one.
        poses: (j, 3) [m, m, rad].
        ways: See `directions`, (j, 2, 3).
        which: Places and pose of each state, (k,).
        high: Clocks of the upper gripper, (k,) [rad].
        low: Those of the lower one.
    """
    beta = (high - low + math.pi) % (2.0 * math.pi) - math.pi
    g = (np.swapaxes(lower.frames, -1, -2) @ np.array(run.gravity)[:, None])[which, :, 0]
    c, s = np.cos(low), np.sin(low)
    turned = np.stack((g[:, 0] * c + g[:, 1] * s, g[:, 1] * c - g[:, 0] * s, g[:, 2]), axis=-1)
    feet = np.stack((lower.footing, upper.footing), axis=1)[which]
    moving = either_way(machine, poses, ways, which, beta)
    return uses_alone(machine, np.append(poses[which], beta[:, None], axis=1), turned, feet, moving)


def _on_straights(
    run: PipeRun, machine: Machine, lower: Places, upper: Places, pairs: Indices, joined: Joined, clocks: Array,
    near: Indices, uses: NDArray[np.float32],
) -> set[Kind]:  # fmt: skip
    """Fill in the states of coaxial pairs, straight by straight and footing by footing; see `uses_of_states`."""
    scarce = set[Kind]()
    ends = (lower.only(pairs[:, 0]), upper.only(pairs[:, 1]))
    columns = [column for end in ends for column in (end.pipe, _part(run, end), *end.footing.T)]
    keys = np.stack(columns, axis=-1).astype(np.float64)
    high, slot = np.nonzero(near >= 0)
    low = near[high, slot]
    ways = np.zeros((GAPS, 2, 3))
    ways[:, 0, 1], ways[:, 1, 1] = 1.0, -1.0
    kinds, kind_of = np.unique(keys, axis=0, return_inverse=True)
    for number in range(len(kinds)):
        rows = np.flatnonzero(joined.coaxial & (kind_of.ravel() == number))
        if not len(rows):
            continue
        gaps = joined.poses[rows, 0, 1]
        knots = np.linspace(gaps.min(), gaps.max() + 1e-12, GAPS)
        poses = np.zeros((GAPS, 3))
        poses[:, 1] = knots
        count = len(high)
        pair = np.full(GAPS, rows[0])
        table = states(
            run, machine, ends[0].only(pair), ends[1].only(pair), poses, ways, np.repeat(np.arange(GAPS), count),
            np.tile(clocks[high], GAPS), np.tile(clocks[low], GAPS),
        ).reshape(GAPS, count, 2, len(KINDS))  # fmt: skip
        scarce |= _scarce(table)
        at = np.clip((gaps - knots[0]) / (knots[1] - knots[0]), 0.0, GAPS - 1.0)
        below = np.minimum(at.astype(np.int64), GAPS - 2)
        share = (at - below)[:, None, None]
        most = table.max(axis=-1)
        uses[rows[:, None], high[None], slot[None]] = (1.0 - share) * most[below] + share * most[below + 1]
    return scarce


def _part(run: PipeRun, places: Places) -> Indices:
    found = np.empty(len(places.s), dtype=np.int64)
    for index, pipe in enumerate(run.pipes):
        mine = places.pipe == index
        found[mine] = pipe.part_at(places.s[mine])
    return found
