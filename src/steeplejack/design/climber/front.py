"""Several aims at once: designs that no other beats in transmission, workspace, distance to singularity and size.

The aims, each over the poses that a design reaches:

- GTI, and the area of the workspace, under the comparison's own orientations;
- distance to singularity: least ``|det J| / L1`` [1] at the orientations within 30 degrees. With rotation made
  dimensionless by L1 a row of J is a unit force and its moment, so it is 0 where the three lines meet or are parallel;
- size: L1 + L2 + L3 + L4 [m], the less the better.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from steeplejack.design.climber.dimensions import Chart
from steeplejack.design.climber.limits import Limits, determinant
from steeplejack.design.climber.ratings import Comparison
from steeplejack.design.climber.readings import WITHIN
from steeplejack.design.climber.strips import MOST_ENDS, cell_span, intervals

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Front:
    """Aims of the designs of a chart, and which of them no other design beats.

    Attributes:
        ratios: ``L_i / L1``, (n, 4) [1].
        gti: (n,) [1].
        area: (n,) [m2].
        distance: To singularity, (n,) [1].
        size: (n,) [m].
        best: Whether no other design is as good in every aim and better in one, (n,).
    """

    ratios: Array
    gti: Array
    area: Array
    distance: Array
    size: Array
    best: Flags


def front(chart: Chart, step: float = 0.005) -> Front:
    """The non-dominated designs of a chart.

    Args:
        chart: From `performance_chart` over each design's own workspace.
        step: Side of the cells over which the distance to singularity is sought [m].

    Returns:
        All designs that reach something, with their aims.
    """
    rated = np.isfinite(chart.ratings.gti)
    ratios = chart.ratios[rated]
    distance = least_determinant(ratios, chart.comparison, step)
    size = chart.comparison.lengths(ratios).sum(axis=1)
    gti, area = chart.ratings.gti[rated], chart.ratings.area[rated]
    return Front(ratios, gti, area, distance, size, non_dominated(np.stack((gti, area, distance, -size), axis=-1)))


def least_determinant(ratios: Array, comparison: Comparison, step: float) -> Array:
    """Least ``|det J| / L1`` over the poses that each design reaches within 30 degrees.

    Args:
        ratios: ``L_i / L1``, (n, 4) [1].
        comparison: Scale, convention and limits.
        step: Side of a cell [m].

    Returns:
        (n,) [1]; infinite where a design reaches nothing.
    """
    layouts = [comparison.layout(tuple(one)) for one in ratios.tolist()]
    limits = [Limits.of(layout) for layout in layouts]
    least = np.empty(len(ratios))
    _least_determinant(
        step,
        np.array(WITHIN),
        np.array([one.base for one in limits]),
        np.array([one.platform for one in limits]),
        np.array([one.bounds for one in limits]),
        np.array([one.neutral for one in limits]),
        least,
    )
    return least / np.array([layout.lengths[0] for layout in layouts])


def non_dominated(aims: Array) -> Flags:
    """Which rows no other row dominates: as great in every column and greater in one.

    Args:
        aims: (n, m), the greater the better, finite or infinite.

    Returns:
        (n,). Of equal rows all stay.
    """
    best = np.ones(len(aims), dtype=np.bool_)
    # In descending lexicographic order a row can be dominated by rows before it only.
    order = np.lexsort(aims.T[::-1])[::-1]
    kept = np.empty((0, aims.shape[1]))
    for index in order.tolist():
        one = aims[index]
        beaten = (kept >= one).all(axis=1) & (kept > one).any(axis=1)
        best[index] = not beaten.any()
        if best[index]:
            kept = np.vstack((kept, one))
    return best


@njit(cache=True, parallel=True, error_model="numpy")
def _least_determinant(
    step: float, alphas: Array, base: Array, platform: Array, bounds: Array, neutral: Array, least: Array
) -> None:
    """Least ``|det J|`` of each design; fills ``least``, (n,) [m]."""
    for design in prange(base.shape[0]):
        ends, found = np.empty(MOST_ENDS), np.inf
        b, p = base[design], platform[design]
        for a in range(alphas.size):
            alpha = alphas[a]
            cos, sin = math.cos(alpha), math.sin(alpha)
            top = bounds[design, 1] + min(p[0] * sin, p[1] * sin, p[2] * sin)
            for r in range(max(0, math.ceil(top / step - 0.5))):
                w = (r + 0.5) * step
                pieces = intervals(w, (alpha, cos, sin), (b, p, bounds[design], neutral[design]), ends)
                for piece in range(pieces):
                    first, past = cell_span(ends[2 * piece], ends[2 * piece + 1], step)
                    for k in range(first, past):
                        x, square = (k + 0.5) * step, 1.0
                        for i in range(3):
                            u, v = x + p[i] * cos - b[i], w - p[i] * sin
                            square *= u * u + v * v
                        found = min(found, abs(determinant(x, w, cos, sin, b, p)) / math.sqrt(square))
        least[design] = found
