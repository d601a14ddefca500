"""Bars against pipes and what stands on them, for the oracle: exact distances of points, and halving of bars.

A pipe is its round body with flat ends, straight or an arc, without the capsules that planning makes of it. An
obstacle is a sector of a cylinder about the pipe's axis. A distance changes by no more than a point moves: a bar whose
middle is further from a solid than its own half length, radius and air is clear of it, and any other is cut in two.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from steeplejack.worksite.pipe_line import Part
from steeplejack.worksite.pipe_run import PipeObstacle, PipeRun

Array = np.ndarray
FINEST = 2.5e-4  # [m] half of a piece of bar that is not cut again: counts as clear


class Solid(Protocol):
    """Something with a distance."""

    def distance(self, points: Array) -> Array:
        """From points (k, 3), 0 within, (k,) [m]."""
        ...


@dataclass(frozen=True)
class Tube:
    """One part of a pipe."""

    part: Part

    def distance(self, points: Array) -> Array:
        """From points (k, 3), 0 within, (k,) [m]."""
        part = self.part
        x, y, z = ((points - part.point) @ part.frame).T
        if part.straight:
            beyond = np.maximum(np.maximum(-z, z - part.length), 0.0)
            return np.hypot(np.maximum(np.hypot(x, y) - 0.5 * part.diameter, 0.0), beyond)
        c, s = math.cos(part.toward), math.sin(part.toward)
        inward, aside = part.radius - (c * x + s * y), c * y - s * x
        angle = np.clip(np.arctan2(z, inward), 0.0, part.length / part.radius)
        outward = inward * np.cos(angle) + z * np.sin(angle) - part.radius
        along = z * np.cos(angle) - inward * np.sin(angle)
        return np.hypot(np.maximum(np.hypot(outward, aside) - 0.5 * part.diameter, 0.0), along)


@dataclass(frozen=True)
class Sector:
    """An obstacle: about a frame's z axis as far as a radius, half a length and half a clock to either side."""

    point: Array
    frame: Array
    half: float
    outer: float
    middle: float
    spread: float

    @classmethod
    def of(cls, run: PipeRun, one: PipeObstacle) -> Sector:
        """Of something that stands on a pipe."""
        at = 0.5 * (one.start + one.end)
        first, last = one.clock if one.clock is not None else (-math.pi, math.pi)
        outer = float(run.radius(at, one.pipe)) + one.height
        half, middle, spread = 0.5 * (one.end - one.start), 0.5 * (first + last), 0.5 * (last - first)
        return cls(*run.centre_line(at, one.pipe), half, outer, middle, spread)

    def distance(self, points: Array) -> Array:
        """From points (k, 3), 0 within, (k,) [m]; across the pipe to the arc, or to the nearer of two radii."""
        x, y, z = ((points - self.point) @ self.frame).T
        rho = np.hypot(x, y)
        off = np.abs((np.arctan2(y, x) - self.middle + math.pi) % (2.0 * math.pi) - math.pi) - self.spread
        foot = np.clip(rho * np.cos(off), 0.0, self.outer)
        to_side = np.sqrt(np.maximum(rho**2 + foot**2 - 2.0 * rho * foot * np.cos(off), 0.0))
        across = np.where(off > 0.0, to_side, np.maximum(rho - self.outer, 0.0))
        return np.hypot(across, np.maximum(np.abs(z) - self.half, 0.0))


def solids_of(run: PipeRun) -> list[Solid]:
    """All pipes of a run and what stands on them."""
    tubes = [Tube(part) for pipe in run.pipes for part in pipe.parts]
    return [*tubes, *(Sector.of(run, one) for one in run.obstacles)]


def met(solids: Sequence[Solid], bars: Array, radii: Array, air: float) -> Array:
    """Which of k sets of bars come nearer than ``air`` to a solid.

    Args:
        solids: Of the run.
        bars: Ends in the world's frame, (k, m, 2, 3) [m].
        radii: (m,) [m].
        air: [m].

    Returns:
        (k,).
    """
    found = np.zeros(len(bars), dtype=bool)
    for solid in solids:
        which = np.repeat(np.arange(len(bars)), len(radii))
        first, last = bars[:, :, 0].reshape(-1, 3), bars[:, :, 1].reshape(-1, 3)
        reach = np.tile(radii + air, len(bars))
        while len(which):
            middle, half = 0.5 * (first + last), 0.5 * np.linalg.norm(last - first, axis=1)
            away = solid.distance(middle)
            found[which[away < reach]] = True
            cut = (away - half < reach) & (half > FINEST) & ~found[which]
            first, middle, last = first[cut], middle[cut], last[cut]
            which, reach = np.tile(which[cut], 2), np.tile(reach[cut], 2)
            first, last = np.concatenate((first, middle)), np.concatenate((middle, last))
    return found
