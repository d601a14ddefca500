"""What the robot's bars must not meet: pipes, and what stands on them.

Pipes are capsules: one to a straight, chords with the sagitta added to their radius to a bend. Obstacles are sectors of
a cylinder about their pipe's axis: up to a radius, between two places and two clocks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.worksite.pipe_line import Part
from steeplejack.worksite.pipe_run import PipeObstacle, PipeRun

Array = NDArray[np.float64]

AIR = 0.003
"""Least distance kept between bars and what they pass when a climb is planned [m]."""
SAGITTA = 2e-4
"""By how much the chords of a bend may leave its arc [m]."""


@dataclass(frozen=True)
class Solids:
    """What the bars must not meet.

    Attributes:
        capsules: Both ends and radius, (m, 7) [m].
        sectors: Middle (3), axes x, y, z (9), half length, outer radius, middle and half of the clock,
            (n, 16) [m, rad].
    """

    capsules: Array
    sectors: Array


def obstacles_of(run: PipeRun) -> Solids:
    """All pipes and obstacles of a run."""
    capsules = [capsule for pipe in run.pipes for part in pipe.parts for capsule in _chords(part)]
    sectors = [sector(run, one) for one in run.obstacles]
    return Solids(np.array(capsules).reshape(-1, 7), np.array(sectors).reshape(-1, 16))


def _chords(part: Part) -> list[Array]:
    count, extra = 1, 0.0
    if not part.straight:
        count = max(1, math.ceil(part.length / (2.0 * math.sqrt(2.0 * part.radius * SAGITTA))))
        extra = SAGITTA
    points, _frames = part.at(part.start + np.linspace(0.0, part.length, count + 1))
    size = [0.5 * part.diameter + extra]
    return [np.concatenate((a, b, size)) for a, b in zip(points[:-1], points[1:], strict=True)]


def sector(run: PipeRun, one: PipeObstacle) -> Array:
    """What stands on a pipe as a row of `Solids.sectors`, (16,)."""
    middle = 0.5 * (one.start + one.end)
    point, frame = run.centre_line(middle, one.pipe)
    first, last = one.clock if one.clock is not None else (-math.pi, math.pi)
    reach = float(run.radius(middle, one.pipe)) + one.height
    tail = [0.5 * (one.end - one.start), reach, 0.5 * (first + last), 0.5 * (last - first)]
    return np.concatenate((point, frame.T.ravel(), tail))
