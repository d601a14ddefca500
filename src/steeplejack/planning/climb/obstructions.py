"""Where on the lattice the robot's bars meet a pipe or what stands on it.

In a bend, and with grippers on two pipes, the mechanism's clock follows from the pair of places, and a pair that is
obstructed is not allowed. On one straight the clock is free: near obstacles and other pipes a fine grid of clocks is
looked at, once for all that turns with the mechanism and once for the linkage, by the lower gripper's clock and the
turn between them; from it come tables over the lattice's clocks and every turn between two of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.around import blocked_clocks
from steeplejack.planning.climb.collide import meets
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.pairs import Joined
from steeplejack.planning.climb.places import Places
from steeplejack.planning.climb.solids import AIR, Solids
from steeplejack.robots.pipe_climber.bars import limb_room, linkage_bars, mechanism_bars, ring_radius
from steeplejack.robots.pipe_climber.weights import linkage_height
from steeplejack.worksite.pipe_line import Pipe
from steeplejack.worksite.pipe_run import PipeRun

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]

CLOCKS = 144
"""Clocks of the tables; half a cell turns the furthest bar by less than `solids.AIR`."""
ALONG = 0.006
"""Half of what the linkage's bars take up along the pipe, with its air [m]."""
REACH = 0.15
"""How far beyond a gripper's middle, along and off the pipe, the robot's parts go [m]."""


@dataclass(frozen=True)
class Obstructions:
    """Clocks and turns at which bars meet something; b counts the clocks near one, the first of them itself.

    Attributes:
        row_of_pair: Row of a pair in the table of the mechanism, -1 where it meets nothing, (k,).
        mechanism: The mechanism turning from a clock to one near it, (r, c, b).
        row_of_place: Row of a lower place in the tables of the linkage, -1 where it meets nothing, (n,).
        by_upper: The linkage at an upper clock and a lower one near it while the upper one turns, (q, c, b, b).
        by_lower: The same while the lower one turns.
    """

    row_of_pair: Indices
    mechanism: Flags
    row_of_place: Indices
    by_upper: Flags
    by_lower: Flags


def unobstructed(machine: Machine, solids: Solids, joined: Joined, lower: Places, pairs: Indices) -> Flags:
    """Which allowed poses keep clear, (k, 2); coaxial ones are left to the tables."""
    free = joined.allowed.copy()
    for side in range(2):
        rows = np.flatnonzero(joined.allowed[:, side] & ~joined.coaxial)
        if not len(rows):
            continue
        bars, radii = mechanism_bars(machine.robot, machine.layout, joined.poses[rows, side])
        at = pairs[rows, 0]
        clocks = joined.clocks[rows, side, None]
        free[rows, side] = ~meets(solids, lower.points[at], lower.frames[at], clocks, bars, radii, AIR)[:, 0]
    return free


def obstructions(
    run: PipeRun, machine: Machine, solids: Solids, lower: Places, pairs: Indices, joined: Joined, clocks: Array,
    near: Indices,
) -> Obstructions:  # fmt: skip
    """The tables of a lattice."""
    thick = _thick_for_limbs(run, machine, lower, pairs, joined)
    rows = np.flatnonzero(joined.coaxial & (thick | _near(run, lower, pairs[:, 0], machine)))
    tight, own = _own_pipe(run, machine, lower)
    places = np.flatnonzero(tight | _near(run, lower, np.arange(len(lower.s)), machine, short=True))
    turns = (clocks[np.maximum(near, 0)] - clocks[:, None] + math.pi) % (2.0 * math.pi) - math.pi
    mechanism = _mechanism(machine, solids, lower, pairs[rows, 0], joined.poses[rows, 0]) | thick[rows, None]
    swept = np.ones((len(rows), *near.shape), dtype=np.bool_)
    for c, b in zip(*np.nonzero(near >= 0), strict=True):
        swept[:, c, b] = mechanism[:, _cells(_sweep(float(clocks[c]), float(turns[c, b])))].any(axis=1)
    by_upper, by_lower = _linkage(machine, solids, lower, places, own[places], clocks, near, turns)
    return Obstructions(_rows(rows, len(pairs)), swept, _rows(places, len(lower.s)), by_upper, by_lower)


def _rows(which: Indices, count: int) -> Indices:
    found = np.full(count, -1, dtype=np.int64)
    found[which] = np.arange(len(which))
    return found


def _sweep(start: float, turn: float) -> Array:
    """Angles of a turn, no further apart than the grid's."""
    count = math.ceil(abs(turn) * CLOCKS / (2.0 * math.pi) - 1e-9) + 1
    return start + np.linspace(0.0, turn, count)


def _cells(angles: Array) -> Indices:
    return np.rint(angles * (CLOCKS / (2.0 * math.pi))).astype(np.int64) % CLOCKS


def _mechanism(machine: Machine, solids: Solids, lower: Places, at: Indices, poses: Array) -> Flags:
    """Where the mechanism meets something, (r, `CLOCKS`)."""
    bars, radii = mechanism_bars(machine.robot, machine.layout, poses)
    return blocked_clocks(solids, lower.points[at], lower.frames[at], bars, radii, AIR, CLOCKS)


def _linkage(
    machine: Machine, solids: Solids, lower: Places, places: Indices, own: Array, clocks: Array, near: Indices,
    turns: Array,
) -> tuple[Flags, Flags]:  # fmt: skip
    """Where the linkage meets something, also its own pipe of radii ``own`` (q,), turned by either gripper."""
    limit = machine.robot.rcm.limit
    half = max(1, math.ceil(limit * CLOCKS / (2.0 * math.pi)))
    betas = np.linspace(-limit, limit, 2 * half + 1)
    bars, radii = linkage_bars(machine.robot, betas)
    table = np.empty((len(places), CLOCKS, len(betas)), dtype=np.bool_)
    for k in range(len(betas)):
        same = np.broadcast_to(bars[k], (len(places), *bars[k].shape))
        table[:, :, k] = blocked_clocks(solids, lower.points[places], lower.frames[places], same, radii, AIR, CLOCKS)
        table[own + AIR > ring_radius(machine.robot, betas[k]) + 1e-9, :, k] = True

    def column(beta: Array) -> Indices:
        return np.clip(np.rint(beta / limit * half).astype(np.int64) + half, 0, 2 * half)

    wide = near.shape[1]
    by_upper, by_lower = (np.ones((len(places), *near.shape, wide), dtype=np.bool_) for _ in range(2))
    for c, slot in zip(*np.nonzero(near >= 0), strict=True):
        low = near[c, slot]
        beta = -float(turns[c, slot])
        for b in range(wide):
            if near[c, b] >= 0:
                there = column(_sweep(beta, float(turns[c, b])))
                by_upper[:, c, slot, b] = table[:, _cells(clocks[low : low + 1]), there].any(axis=1)
            if near[low, b] >= 0:
                angles = _sweep(float(clocks[low]), float(turns[low, b]))
                by_lower[:, c, slot, b] = table[:, _cells(angles), column(beta + clocks[low] - angles)].any(axis=1)
    return by_upper, by_lower


def _own_pipe(run: PipeRun, machine: Machine, lower: Places) -> tuple[Flags, Array]:
    """Lower places where the linkage's largest turn may bring it to its own pipe, and the pipe's radius, each (n,).

    The radius is 0 where the pipe is not coaxial with the gripper at the linkage: its bends are among the solids.
    """
    height, room = linkage_height(machine.robot), float(ring_radius(machine.robot, machine.robot.rcm.limit))
    tight, own = np.zeros(len(lower.s), dtype=np.bool_), np.zeros(len(lower.s))
    for index, pipe in enumerate(run.pipes):
        mine = np.flatnonzero(lower.pipe == index)
        thick = _thickest(pipe, lower.s[mine] + height - ALONG, lower.s[mine] + height + ALONG)
        offset = pipe.centre_line(lower.s[mine] + height)[0] - lower.points[mine]
        aside = np.linalg.norm(np.cross(offset, lower.frames[mine, :, 2]), axis=-1)
        tight[mine] = aside + thick + AIR > room + 1e-9
        own[mine] = np.where(aside < 1e-7, thick, 0.0)
    return tight, own


def _thick_for_limbs(run: PipeRun, machine: Machine, lower: Places, pairs: Indices, joined: Joined) -> Flags:
    """Coaxial pairs where the pipe between the grippers is too thick for the limbs, (k,)."""
    thick = np.zeros(len(pairs))
    for index, pipe in enumerate(run.pipes):
        mine = joined.coaxial & (lower.pipe[pairs[:, 0]] == index)
        first = lower.s[pairs[mine, 0]]
        thick[mine] = _thickest(pipe, first, first + joined.poses[mine, 0, 1])
    return thick + AIR > limb_room(machine.robot) + 1e-9


def _thickest(pipe: Pipe, first: Array, last: Array) -> Array:
    """Largest radius of a pipe between places, (k,) [m]."""
    found = np.zeros(len(first))
    for part in pipe.parts:
        over = (last > part.start) & (first < part.end)
        found[over] = np.maximum(found[over], 0.5 * part.diameter)
    return found


def _near(run: PipeRun, lower: Places, which: Indices, machine: Machine, short: bool = False) -> Flags:
    """Lower places from which bars, or the linkage's alone, may meet an obstacle or a second pipe."""
    ahead = REACH if short else REACH + float(machine.longest.max()) + abs(machine.claw_offset)
    close = np.zeros(len(which), dtype=np.bool_)
    for one in run.obstacles:
        pipe = run.pipe(one.pipe)
        middle, _frame = pipe.centre_line(0.5 * (one.start + one.end))
        tall = one.height > machine.lowest_bar - float(pipe.radius(one.start)) + 1e-9
        if tall:
            close |= np.linalg.norm(lower.points[which] - middle, axis=1) < ahead + 0.5 * (one.end - one.start)
    for one in run.crossings:
        middle, _frame = run.pipes[0].centre_line(one.at)
        far = max(run.pipe(one.pipe).length, 0.0)
        close |= np.linalg.norm(lower.points[which] - middle, axis=1) < ahead + min(far, REACH)
    return close
