"""Clocks worth standing at, and which the linkage takes to which."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import PALM, bumps
from steeplejack.worksite.pipe_line import Part
from steeplejack.worksite.pipe_run import PipeRun

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SAME = 1e-6
"""Clocks closer than this are one [rad]."""
LEAST_TURN = math.radians(5.0)
"""A linkage of less range than this is not used to go round a pipe [rad]."""
BETWEEN_LIMBS = (0.0, 0.75 * math.pi, -0.75 * math.pi)
"""Clocks of the mechanism from what stands in the middle of a gap between two limbs [rad]."""
LEVEL = 0.05
"""Gravity across a pipe, in parts of all of it, that makes its clock worth standing at [1]."""


def wanted_clocks(run: PipeRun, machine: Machine) -> Array:
    """Clocks worth standing at: the start's, both sides of bends and crossings, edges of what stands out, up and down.

    All of them, and steps of the linkage's range between them, (c,) in [0, 2 pi).
    """
    anchors = [run.start_clock]
    for pipe in run.pipes:
        for part in pipe.parts:
            anchors += _falls(run, part) if part.straight else [part.toward, part.toward + math.pi]
        for one in bumps(run, machine, pipe):
            away = one.clock[1] + machine.robot.gait.palm
            if one.height > machine.robot.gait.clearance and away < math.pi:
                anchors += [one.clock[0] - PALM - away, one.clock[0] - PALM + away]
    for one in run.obstacles:  # in one of the gaps between limbs: ahead of them, or to either side of the third
        if one.clock is not None and one.height + float(run.radius(one.start, one.pipe)) > machine.lowest_bar:
            anchors += [0.5 * (one.clock[0] + one.clock[1]) + gap for gap in BETWEEN_LIMBS]
    for one in run.crossings:
        anchors += [one.toward, one.toward + math.pi]
    anchors = _distinct(np.array(anchors))
    if len(anchors) == 1:
        return anchors
    if machine.robot.rcm.limit < LEAST_TURN:
        return anchors
    turns = max(1, math.ceil(2.0 * math.pi / min(machine.robot.rcm.limit, math.pi) - 1e-9))
    grid = run.start_clock + 2.0 * math.pi * np.arange(turns) / turns
    return _distinct(np.concatenate((anchors, grid)))


def _falls(run: PipeRun, part: Part) -> list[float]:
    """Clocks at which a leaning straight has the ground and the sky: a grip holds most in their plane."""
    down = part.frame.T @ np.array(run.gravity)
    if math.hypot(down[0], down[1]) < LEVEL * float(np.linalg.norm(down)):
        return []
    clock = math.atan2(down[1], down[0])
    return [clock, clock + math.pi]


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
