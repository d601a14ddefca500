"""What many designs are worth over one region: the kernels of the performance charts.

Each design is rated over the same question (`Comparison`): how many cells of the region have a local transmission index
of at least 0.5 (GTI), its mean and its least, and how many cells the region has, which differs between designs where
the region is each design's own workspace.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from steeplejack.design.climber.limits import Limits
from steeplejack.design.climber.quality import GOOD
from steeplejack.design.climber.reach import checked_step
from steeplejack.design.climber.region import Rectangle
from steeplejack.design.climber.strips import MOST_ENDS, cell_span, intervals
from steeplejack.design.climber.transmission import Moving, line_values
from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber import Layout
from steeplejack.robots.pipe_climber.parameters import Convention, Neutral

Array = NDArray[np.float64]
Scale = Literal["l1", "sum"]

TOTALS: dict[Scale, float] = {"l1": 0.100, "sum": 0.350}
"""What the normalisation holds fixed: L1, or L1 + L2 + L3 + L4 [m]."""


@dataclass(frozen=True)
class Comparison:
    """Under which conditions designs are compared: one reading of what the paper leaves open.

    Attributes:
        rectangle: Prescribed workspace, of limits regardless; without one each design's own workspace.
        alphas: Orientations that are pooled [rad].
        step: Side of a cell [m].
        scale: What is fixed as ratios change: L1 = 100 mm or L1 + L2 + L3 + L4 = 350 mm.
        convention: Where the base joints sit.
        moving: Which body's joints are the characteristic points.
        neutral: What joint limits count from; matters for own workspaces only.
        reach: Least and largest limb length; matters for own workspaces only [m].
        joint_limit: [rad].
    """

    rectangle: Rectangle | None = None
    alphas: tuple[float, ...] = (0.0,)
    step: float = 0.001
    scale: Scale = "l1"
    convention: Convention = "text"
    moving: Moving = "platform"
    neutral: Neutral = "none"
    reach: tuple[float, float] = (0.120, 0.240)
    joint_limit: float = math.pi / 6

    def __post_init__(self) -> None:
        """Refuse what cannot be compared."""
        if not (self.alphas and all(map(math.isfinite, self.alphas))):
            raise InputError("alphas", f"{list(self.alphas)} rad", "one or more finite orientations")
        if self.rectangle is not None:
            self.rectangle.cells(self.step)
        else:
            checked_step(self.layout((1.0, 1.0, 1.0, 1.0)), self.step)

    def lengths(self, ratios: Array) -> Array:
        """L1..L4 of ratios ``L_i / L1``, at the scale compared at, (..., 4) [m]."""
        total = 1.0 if self.scale == "l1" else ratios.sum(axis=-1, keepdims=True)
        return TOTALS[self.scale] * ratios / total

    def layout(self, ratios: tuple[float, float, float, float]) -> Layout:
        """The mechanism of ratios ``L_i / L1``."""
        l1, l2, l3, l4 = self.lengths(np.asarray(ratios, dtype=np.float64)).tolist()
        return Layout((l1, l2, l3, l4), self.convention, self.reach, self.joint_limit, self.neutral)


@dataclass(frozen=True, eq=False)
class Ratings:
    """What designs are worth, in the order they were given.

    Attributes:
        gti: Share of the region with a local index of at least 0.5, (n,) [1]; NaN where the region is empty.
        mean: Of the local index over the region, (n,) [1].
        least: Of the local index over the region, (n,) [1].
        area: Of the region, averaged over the orientations, (n,) [m2].
    """

    gti: Array
    mean: Array
    least: Array
    area: Array


def rate(ratios: Array, comparison: Comparison) -> Ratings:
    """Rate designs, on all cores that numba may use.

    Args:
        ratios: ``L_i / L1``, (n, 4) [1].
        comparison: Over which region, at which scale.

    Returns:
        Their ratings.

    Raises:
        InputError: Ratios that are not positive numbers, (n, 4).
    """
    designs = np.ascontiguousarray(ratios, dtype=np.float64)
    if designs.ndim != 2 or designs.shape[1] != 4:
        raise InputError("ratios", f"shape {designs.shape}", "(n, 4)")
    if not (np.isfinite(designs) & (designs > 0.0)).all():
        raise InputError("ratios", "an entry that is not above 0", "L1..L4 relative to L1, all above 0")
    base, platform = _hinges(comparison.lengths(designs), comparison.convention)
    sums, alphas = np.zeros((len(designs), 4)), np.asarray(comparison.alphas)
    moves = comparison.moving == "platform"
    if comparison.rectangle is not None:
        x, w = comparison.rectangle.cells(comparison.step)
        _over_rectangle(x, w, alphas, base, platform, moves, sums)
        cell = (x[1] - x[0] if x.size > 1 else comparison.rectangle.x1 - comparison.rectangle.x0) * (
            w[1] - w[0] if w.size > 1 else comparison.rectangle.w1 - comparison.rectangle.w0
        )
    else:
        limits = [Limits.of(comparison.layout(tuple(one))) for one in designs.tolist()]
        bounds, neutral = np.array([one.bounds for one in limits]), np.array([one.neutral for one in limits])
        _over_workspaces(comparison.step, alphas, base, platform, bounds, neutral, moves, sums)
        cell = comparison.step**2
    with np.errstate(invalid="ignore"):
        shares = sums[:, :2] / sums[:, 3:]
    least = np.where(sums[:, 3] > 0.0, sums[:, 2], np.nan)
    return Ratings(shares[:, 0], shares[:, 1], least, sums[:, 3] * cell / alphas.size)


def _hinges(lengths: Array, convention: Convention) -> tuple[Array, Array]:
    """``b`` and ``p`` of many designs, (n, 3) each [m]; see `Layout`."""
    l1, l2, l3, l4 = lengths.T
    zero = np.zeros_like(l1)
    base = (zero, -l3, -l1) if convention == "text" else (zero, -l1, -l3)
    return np.stack(base, axis=-1), np.stack((-l4, zero, -l2), axis=-1)


@njit(cache=True, parallel=True, error_model="numpy")
def _over_rectangle(
    xs: Array, ws: Array, alphas: Array, base: Array, platform: Array, platform_moves: bool, sums: Array
) -> None:
    """For each design: good cells, sum and least of the index, cells; fills ``sums``, (n, 4)."""
    for design in prange(base.shape[0]):
        line = np.empty(xs.size)
        good, total, least = 0, 0.0, np.inf
        for a in range(alphas.size):
            cos, sin = math.cos(alphas[a]), math.sin(alphas[a])
            for r in range(ws.size):
                line_values(xs, ws[r], cos, sin, base[design], platform[design], platform_moves, line)
                for k in range(xs.size):
                    good += line[k] >= GOOD
                    total += line[k]
                    least = min(least, line[k])
        sums[design, 0], sums[design, 1], sums[design, 2] = good, total, least
        sums[design, 3] = alphas.size * ws.size * xs.size


@njit(cache=True, parallel=True, error_model="numpy")
def _over_workspaces(
    step: float,
    alphas: Array,
    base: Array,
    platform: Array,
    bounds: Array,
    neutral: Array,
    platform_moves: bool,
    sums: Array,
) -> None:
    """The same over the cells that each design reaches."""
    for design in prange(base.shape[0]):
        ends = np.empty(MOST_ENDS)
        good, total, least, cells = 0, 0.0, np.inf, 0
        for a in range(alphas.size):
            alpha = alphas[a]
            cos, sin = math.cos(alpha), math.sin(alpha)
            lowest = min(platform[design, 0] * sin, platform[design, 1] * sin, platform[design, 2] * sin)
            for r in range(max(0, math.ceil((bounds[design, 1] + lowest) / step - 0.5))):
                w = (r + 0.5) * step
                limits = (base[design], platform[design], bounds[design], neutral[design])
                pieces = intervals(w, (alpha, cos, sin), limits, ends)
                for piece in range(pieces):
                    first, past = cell_span(ends[2 * piece], ends[2 * piece + 1], step)
                    if past <= first:
                        continue
                    line = np.empty(past - first)
                    xs = np.empty(past - first)
                    for k in range(xs.size):
                        xs[k] = (first + k + 0.5) * step
                    line_values(xs, w, cos, sin, base[design], platform[design], platform_moves, line)
                    cells += line.size
                    for k in range(line.size):
                        good += line[k] >= GOOD
                        total += line[k]
                        least = min(least, line[k])
        sums[design, 0], sums[design, 1], sums[design, 2], sums[design, 3] = good, total, least, cells
