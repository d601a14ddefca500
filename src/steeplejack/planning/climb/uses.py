"""How much of a grip every state of the lattice takes: see `grip`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.grip import alone
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.pairs import Joined
from steeplejack.planning.climb.places import Places
from steeplejack.worksite.pipe_run import PipeRun

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

GAPS = 7
"""Distances of the grippers on one straight between which the use of a grip is interpolated, from above."""


def uses_of_grips(
    run: PipeRun, machine: Machine, lower: Places, upper: Places, pairs: Indices, joined: Joined, sides: Indices,
    clocks: Array, near: Indices,
) -> NDArray[np.float32]:  # fmt: skip
    """Use of the lower and of the upper grip, either alone, by pair, upper clock and lower one near it.

    Returns:
        (k, c, b, 2); infinite where a pair has no pose at a clock.
    """
    uses = np.full((len(pairs), *near.shape, 2), np.inf, dtype=np.float32)
    _on_straights(run, machine, lower, upper, pairs, joined, clocks, near, uses)
    wide = near.shape[1]
    for side in range(2):
        rows = np.flatnonzero(~joined.coaxial & joined.allowed[:, side] & (sides[:, side] >= 0))
        if not len(rows):
            continue
        high = np.repeat(sides[rows, side], wide)
        low, many = near[sides[rows, side]].ravel(), np.repeat(rows, wide)
        have = np.flatnonzero(low >= 0)
        slot = np.tile(np.arange(wide), len(rows))[have]
        high, low, many = high[have], low[have], many[have]
        found = _states(run, machine, lower, upper, pairs[many], joined.poses[many, side], clocks[high], clocks[low])
        uses[many, high, slot] = found
    return uses


def _states(
    run: PipeRun, machine: Machine, lower: Places, upper: Places, pairs: Indices, poses: Array, high: Array, low: Array
) -> Array:
    """`grip.alone` of states: pairs (k, 2), poses (k, 3), clocks of both grippers (k,)."""
    beta = (high - low + math.pi) % (2.0 * math.pi) - math.pi
    g = (np.swapaxes(lower.frames[pairs[:, 0]], -1, -2) @ np.array(run.gravity)[:, None])[..., 0]
    c, s = np.cos(low), np.sin(low)
    turned = np.stack((g[:, 0] * c + g[:, 1] * s, g[:, 1] * c - g[:, 0] * s, g[:, 2]), axis=-1)
    radii = np.stack((_radius(run, lower, pairs[:, 0]), _radius(run, upper, pairs[:, 1])), axis=-1)
    return alone(machine, np.append(poses, beta[:, None], axis=1), turned, radii)


def _radius(run: PipeRun, places: Places, which: Indices) -> Array:
    found = np.empty(len(which))
    for index, pipe in enumerate(run.pipes):
        mine = places.pipe[which] == index
        found[mine] = pipe.radius(places.s[which[mine]])
    return found


def _on_straights(
    run: PipeRun, machine: Machine, lower: Places, upper: Places, pairs: Indices, joined: Joined, clocks: Array,
    near: Indices, uses: NDArray[np.float32],
) -> None:  # fmt: skip
    """Fill in the states of coaxial pairs, straight by straight."""
    parts = np.stack([_part(run, lower, pairs[:, 0]), _part(run, upper, pairs[:, 1])], axis=-1)
    own = lower.pipe[pairs[:, 0]]
    keys = np.stack((own, parts[:, 0], parts[:, 1]), axis=-1)
    high, slot = np.nonzero(near >= 0)
    low = near[high, slot]
    for key in np.unique(keys[joined.coaxial], axis=0):
        rows = np.flatnonzero(joined.coaxial & (keys == key).all(axis=1))
        gaps = joined.poses[rows, 0, 1]
        knots = np.linspace(gaps.min(), gaps.max() + 1e-12, GAPS)
        poses = np.zeros((GAPS, 3))
        poses[:, 1] = knots
        count = len(high)
        pair = np.broadcast_to(pairs[rows[0]], (GAPS * count, 2))
        table = _states(
            run, machine, lower, upper, pair, np.repeat(poses, count, axis=0), np.tile(clocks[high], GAPS),
            np.tile(clocks[low], GAPS),
        ).reshape(GAPS, count, 2)  # fmt: skip
        at = np.clip((gaps - knots[0]) / (knots[1] - knots[0]), 0.0, GAPS - 1.0)
        below = np.minimum(at.astype(np.int64), GAPS - 2)
        share = (at - below)[:, None, None]
        values = (1.0 - share) * table[below] + share * table[below + 1]
        uses[rows[:, None], high[None], slot[None]] = values


def _part(run: PipeRun, places: Places, which: Indices) -> Indices:
    found = np.empty(len(which), dtype=np.int64)
    for index, pipe in enumerate(run.pipes):
        mine = places.pipe[which] == index
        found[mine] = pipe.part_at(places.s[which[mine]])
    return found
