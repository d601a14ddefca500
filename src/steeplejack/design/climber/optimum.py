"""The best dimensions without a grid: differential evolution, then a search of the neighbourhood on finer cells.

The GTI counts cells, so it is piecewise constant in the dimensions: there is no gradient, and between equals any is as
good. Differential evolution needs neither; a pattern search on cells of half the side then settles what the coarser
cells leave equal. Nothing about the answer is proved. What speaks for it is that runs from different seeds agree, which
`Optimum.spread` states, and that a chart of the same comparison has nothing better.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.climber.dimensions import LEAST, Ratio, rating
from steeplejack.design.climber.ratings import Comparison, rate
from steeplejack.errors import InputError

Array = NDArray[np.float64]

POPULATION = 24
GENERATIONS = 60
FINEST = 1e-4  # [1] of ratios, below which the pattern search stops


@dataclass(frozen=True)
class Optimum:
    """Best dimensions found.

    Attributes:
        ratio: ``L_i / L1`` [1].
        gti: At the comparison's own cells [1].
        gti_fine: At cells of half the side, which the last search used [1].
        evaluations: Designs rated.
        spread: Greatest less least GTI among the answers from different seeds [1].
    """

    ratio: Ratio
    gti: float
    gti_fine: float
    evaluations: int
    spread: float


def optimise(
    comparison: Comparison, k: float | None = 1.0, rng: np.random.Generator | None = None, starts: int = 3
) -> Optimum:
    """Dimensions of the greatest GTI within the parameter design space.

    Args:
        comparison: Region, scale and the rest.
        k: ``L2 / L1``, or None to search it too.
        rng: Source of the seeds; seed 0 without one.
        starts: Runs of the evolution, from different seeds.

    Returns:
        The best of the runs.

    Raises:
        InputError: k out of range, or no run.
    """
    if k is not None and not LEAST <= k <= 1.0:
        raise InputError("k", f"{k:g}", f"L2 / L1 from {LEAST:g} to 1")
    if starts < 1:
        raise InputError("starts", f"{starts}", "1 or more")
    source, counted = rng or np.random.default_rng(0), [0]

    def worth(points: Array, conditions: Comparison) -> Array:
        counted[0] += len(points)
        gti = rate(_ratios(points, k), conditions).gti
        return np.where(np.isnan(gti), -1.0, gti)

    fine = replace(comparison, step=0.5 * comparison.step)
    found: list[tuple[float, Array]] = []
    for _ in range(starts):
        point = _evolve(lambda points: worth(points, comparison), 2 if k is not None else 3, source)
        found.append(_descend(lambda points: worth(points, fine), point))
    values = [value for value, _ in found]
    point = found[int(np.argmax(values))][1]
    r1, r2, r3, r4 = _ratios(point[None], k)[0].tolist()
    ratio = (r1, r2, r3, r4)
    return Optimum(ratio, rating(ratio, comparison), max(values), counted[0], max(values) - min(values))


def _ratios(points: Array, k: float | None) -> Array:
    """Designs of points (n, 2 or 3) in the unit square or cube; L4 runs up to L2, as Eq. 33 asks."""
    two = np.full(len(points), k) if k is not None else LEAST + (1.0 - LEAST) * points[:, 2]
    three = LEAST + (1.0 - LEAST) * points[:, 0]
    return np.stack((np.ones(len(points)), two, three, LEAST + (two - LEAST) * points[:, 1]), axis=-1)


def _evolve(worth: Callable[[Array], Array], dimensions: int, rng: np.random.Generator) -> Array:
    """Best point of a run of differential evolution in the unit cube; a generation is rated in one call."""
    from scipy.optimize import differential_evolution

    found = differential_evolution(
        lambda points: -worth(np.ascontiguousarray(points.T)),
        [(0.0, 1.0)] * dimensions,
        maxiter=GENERATIONS,
        popsize=POPULATION // dimensions,
        tol=0.0,
        mutation=(0.5, 1.0),
        rng=rng,
        polish=False,
        init="sobol",
        updating="deferred",
        vectorized=True,
    )
    return np.asarray(found.x)


def _descend(worth: Callable[[Array], Array], point: Array) -> tuple[float, Array]:
    """Pattern search: the best of the neighbours at a distance that halves where none is better."""
    corners = np.array(np.meshgrid(*[(-1.0, 0.0, 1.0)] * point.size)).reshape(point.size, -1).T
    value, reach = -math.inf, 0.02
    while reach > FINEST:
        around = np.clip(point + reach * corners, 0.0, 1.0)
        values = worth(around)
        best = int(np.argmax(values))
        if values[best] > value:
            value, point = float(values[best]), around[best]
        else:
            reach *= 0.5
    return value, point
