"""Clocks worth standing at, and which the linkage takes to which."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.around import blocked_clocks
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import PALM, bumps
from steeplejack.planning.climb.solids import AIR, Solids, sector
from steeplejack.robots.pipe_climber.bars import mechanism_bars
from steeplejack.worksite.pipe_line import Part
from steeplejack.worksite.pipe_run import PipeObstacle, PipeRun

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SAME = 1e-6
"""Clocks closer than this are one [rad]."""
LEAST_TURN = math.radians(5.0)
"""A linkage of less range than this is not used to go round a pipe [rad]."""
CELLS = 144
"""Clocks all round at which the mechanism is held against what stands out."""
BEYOND = 0.05
"""How far parts of the mechanism go beyond the grippers' middles [m]."""
EVERY = 0.005
"""Between places along the mechanism at which it is [m]; thinner than any of its bars with the air about them."""
NARROW = math.radians(60.0)
"""In a range of clocks as wide as this two steps of the linkage lie well inside [rad]."""
LEVEL = 0.05
"""Gravity across a pipe, in parts of all of it, that makes its clock worth standing at [1]."""


def wanted_clocks(run: PipeRun, machine: Machine) -> Array:
    """Clocks worth standing at: the start's, both sides of bends and crossings, edges of what stands out, up and down.

    All of them, what the linkage reaches at most from where the mechanism just passes what stands out, and steps of the
    linkage's range between them, (c,) in [0, 2 pi).
    """
    limit = machine.robot.rcm.limit
    anchors, edges = [run.start_clock], list[float]()
    for pipe in run.pipes:
        for part in pipe.parts:
            anchors += _falls(run, part) if part.straight else [part.toward, part.toward + math.pi]
        for one in bumps(run, machine, pipe):
            away = one.clock[1] + machine.robot.gait.palm
            if one.height > machine.robot.gait.clearance and away < math.pi:
                anchors += [one.clock[0] - PALM - away, one.clock[0] - PALM + away]
    for one in run.obstacles:
        if one.clock is not None and one.height + float(run.radius(one.start, one.pipe)) > machine.lowest_bar:
            edges += _clear(run, machine, one)
    for one in run.crossings:
        anchors += [one.toward, one.toward + math.pi]
    anchors = _distinct(np.array([*anchors, *edges]))
    if len(anchors) == 1 or limit < LEAST_TURN:
        return anchors
    turns = math.ceil(2.0 * math.pi / limit - 1e-9)
    grid = run.start_clock + 2.0 * math.pi * np.arange(turns) / turns
    return _distinct(np.concatenate((anchors, grid, np.add.outer((-limit, limit), edges).ravel())))


def _falls(run: PipeRun, part: Part) -> list[float]:
    """Clocks at which a leaning straight has the ground and the sky: a grip holds most in their plane."""
    down = part.frame.T @ np.array(run.gravity)
    if math.hypot(down[0], down[1]) < LEVEL * float(np.linalg.norm(down)):
        return []
    clock = math.atan2(down[1], down[0])
    return [clock, clock + math.pi]


def _clear(run: PipeRun, machine: Machine, one: PipeObstacle) -> list[float]:
    """Both ends of every range of clocks at which the mechanism passes an obstacle without turning, and its middle.

    What else may bind (weight, palm) leaves part of a range. The obstacle is held against all of the mechanism,
    stretched as far as it goes on a straight, on the tangent of its pipe at the obstacle.
    """
    least, gap = machine.straight_gaps
    if gap < least:
        return []
    reach = 0.5 * (one.end - one.start) + BEYOND
    along = np.arange(-reach, gap + reach, EVERY)
    point, frame = run.centre_line(0.5 * (one.start + one.end), one.pipe)
    bars, radii = mechanism_bars(machine.robot, machine.layout, np.array([[0.0, gap, 0.0]] * len(along)))
    points, frames = point - along[:, None] * frame[:, 2], np.broadcast_to(frame, (len(along), 3, 3))
    solids = Solids(np.empty((0, 7)), sector(run, one)[None])
    blocked = np.asarray(blocked_clocks(solids, points, frames, bars, radii, AIR, CELLS).any(axis=0))
    begins = np.flatnonzero(~blocked & np.roll(blocked, 1))
    ends = np.flatnonzero(~blocked & np.roll(blocked, -1))
    if not len(begins):
        return []
    cell, found = 2.0 * math.pi / CELLS, list[float]()
    for first, last in zip(begins, np.roll(ends, -int(np.argmax(ends >= begins[0]))), strict=True):
        width = int(last - first) % CELLS
        inset = min(1, width // 2)  # a table is not as fine as the bars
        found += [cell * (first + inset), cell * (first + width - inset)]
        found += [cell * (first + 0.5 * width)] if cell * width < NARROW else []
    return found


def _distinct(clocks: Array) -> Array:
    """Clocks in [0, 2 pi), each once, rising."""
    turned = np.sort(np.mod(clocks, 2.0 * math.pi))
    turned = turned[np.append(True, np.diff(turned) > SAME)]
    return turned[:-1] if len(turned) > 1 and turned[0] + 2.0 * math.pi - turned[-1] < SAME else turned


def near_clocks(clocks: Array, limit: float) -> Indices:
    """For each clock those within the linkage's range, itself first."""
    apart = np.abs((clocks[:, None] - clocks + math.pi) % (2.0 * math.pi) - math.pi)
    order = np.argsort(apart, axis=1, kind="stable")
    count = (apart <= limit * (1.0 + 1e-9)).sum(axis=1)
    near = order[:, : int(count.max())].astype(np.int64)
    near[np.arange(near.shape[1]) >= count[:, None]] = -1
    return near


def turned(clocks: Array, start: Indices | int, end: Indices | int) -> Array:
    """The short way from clocks to others, each by its number [rad]."""
    return (clocks[end] - clocks[start] + math.pi) % (2.0 * math.pi) - math.pi
