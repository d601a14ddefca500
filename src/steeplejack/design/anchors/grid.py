"""Algorithm 2: anchor offsets on a grid, the largest tension factor of every combination at each pose.

Source: Zheng et al., CCRobot-S, IEEE T-RO, Algorithm 2 and Eq. 22-25. What is put right: the tension factor comes from
J and not from J~ (the paper's variant is offered under its name), it keeps the sign of the null vector, and where no
combination is in wrench closure, so that the printed maximum is over an empty set, the pose is infeasible and its
tension factor 0. The text moves one anchor at a time; this is the four-fold loop of the pseudo-code.

With un-normalised columns component ``i`` of the null vector is a determinant of the other three columns, and ``n_i``
of J is ``l_i`` times that. Vector products of columns 1 and 2, and of columns 3 and 4, are shared by all combinations
they occur in, squares are compared, and the innermost loop runs over all pairs of offsets 3 and 4 without a branch. One
root remains a pose.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.design.anchors.exact import Objective, check_objective, sightlines, tension_factors
from steeplejack.design.anchors.problem import Reconfiguration
from steeplejack.design.anchors.twists import ROUNDING
from steeplejack.errors import InputError
from steeplejack.mechanics.cable.wrench.hyperplanes import TOLERANCE

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

MOST_NODES = 1_000_000  # [1] of one window
MOST_PAIRS = 2_000_000  # [1] nodes of window 3 times those of window 4; eleven numbers are held for each
MOST_EVALUATIONS = 2_000_000_000  # [1] combinations times poses, about half a minute
FINEST = 1e-15  # [1] step over the farthest offset, below which multiples of the step are no distinct numbers


@dataclass(frozen=True, eq=False)
class GridOptimum:
    """Best combination of grid offsets at each of k poses.

    Attributes:
        tension_factor: At the offsets, from J, (k,) [1]; 0 where no combination is in wrench closure.
        offsets: Along x, (k, 4) [m]; not a number where infeasible.
        value: What was maximised, (k,) [1]: the tension factor, or with J~ the paper's ratio.
        configurations: Combinations looked at, a pose.
    """

    tension_factor: Array
    offsets: Array
    value: Array
    configurations: int


def algorithm_2(problem: Reconfiguration, step: float, objective: Objective = "J") -> GridOptimum:
    """Best offsets on a grid at each pose, by looking at all combinations.

    Args:
        problem: Anchors, platform, windows and poses.
        step: Of the grid [m]; its nodes are the integer multiples inside each window, so that not moving is among them.
        objective: "J" for the tension factor, "J~" for the paper's Eq. 24 as printed.

    Returns:
        The best combination at each pose; of equal ones the first in the order of the loops.

    Raises:
        InputError: A step that is not positive or makes too many combinations, a window without a node, or an unknown
            objective.
    """
    check_objective(objective)
    axes = grid_axes(problem, step)
    _check_effort(step, [len(axis) for axis in axes], len(problem.poses))
    arms, roots, shortest, unit = sightlines(problem)
    count = len(arms)
    chosen, value = np.empty((count, 4), dtype=np.int64), np.empty(count)
    v1, v2, v3, v4 = (axis / unit for axis in axes)
    search_grid(arms, roots, problem.directions, shortest, v1, v2, v3, v4, objective == "J", chosen, value)
    offsets = np.stack([axis[chosen[:, i]] for i, axis in enumerate(axes)], axis=-1)
    held = value > 0.0
    factors = np.where(held, tension_factors(problem, offsets), 0.0)
    return GridOptimum(factors, np.where(held[:, None], offsets, np.nan), value, math.prod(len(axis) for axis in axes))


def grid_axes(problem: Reconfiguration, step: float) -> tuple[Array, Array, Array, Array]:
    """Grid offsets of each anchor: the integer multiples of the step inside its window [m].

    Raises:
        InputError: A step that is not positive and finite or is too fine, or a window without a multiple.
    """
    if not (step > 0.0 and math.isfinite(step)):
        raise InputError("step", f"{step:g} m", "positive")
    axes: list[Array] = []
    for index, (low, high) in enumerate(problem.windows):
        size = max(abs(low), abs(high))
        if not ((high - low) / step < MOST_NODES and step >= FINEST * size):
            valid = f"a step with at most {MOST_NODES} multiples inside"
            raise InputError("step", f"{step:g} m for {low:g} to {high:g} m of anchor {index + 1}", valid)
        first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
        if first > last:
            valid = "a step of which a multiple lies inside"
            raise InputError(f"window of anchor {index + 1}", f"{low:g} to {high:g} m, step {step:g} m", valid)
        axes.append(np.clip(np.arange(first, last + 1) * step, low, high))
    return axes[0], axes[1], axes[2], axes[3]


def _check_effort(step: float, nodes: list[int], poses: int) -> None:
    """Refuse a grid that no memory holds or nobody waits for."""
    evaluations, pairs = math.prod(nodes) * poses, nodes[2] * nodes[3]
    if evaluations > MOST_EVALUATIONS:
        what = f"{step:g} m makes {math.prod(nodes):.3g} combinations at {poses} poses"
        raise InputError("step", what, f"a step that makes at most {MOST_EVALUATIONS:.0e} in all")
    if pairs > MOST_PAIRS:
        what = f"{step:g} m makes {pairs:.3g} pairs of anchors 3 and 4"
        raise InputError("step", what, f"a step that makes at most {MOST_PAIRS:.0e}")


@njit(cache=True)
def search_grid(
    arms: Array, roots: Array, along: Array, shortest: Array, v1: Array, v2: Array, v3: Array, v4: Array, unit: bool,
    chosen: Integers, values: Array,
) -> None:  # fmt: skip
    """Look at all combinations of four offsets at every pose; the kernel of `algorithm_2`.

    Args:
        arms: ``b_i`` at each pose, (k, 4, 2).
        roots: ``BA_i`` at no offset, (k, 4, 2).
        along: Change of ``BA_i`` with the offset, (4, 2) [1].
        shortest: Length at each pose from which a cable has a direction, (k,).
        v1: Offsets of anchor 1.
        v2: Offsets of anchor 2.
        v3: Offsets of anchor 3.
        v4: Offsets of anchor 4.
        unit: Whether the null vector is that of J, else of J~.
        chosen: Written, indices of the best offsets, (k, 4); 0 where infeasible.
        values: Written, min over max of the null vector, (k,) [1]; 0 where infeasible.
    """
    c1, c2, c3, c4 = np.empty((len(v1), 4)), np.empty((len(v2), 4)), np.empty((len(v3), 4)), np.empty((len(v4), 4))
    pairs, ratios = np.empty((11, len(v3) * len(v4))), np.empty(len(v3) * len(v4))
    for k in range(len(arms)):
        least = shortest[k] if unit else 0.0
        far = _columns(arms[k, 0], roots[k, 0], along[0], v1, least, unit, c1)
        far *= _columns(arms[k, 1], roots[k, 1], along[1], v2, least, unit, c2)
        far *= _columns(arms[k, 2], roots[k, 2], along[2], v3, least, unit, c3)
        far *= _columns(arms[k, 3], roots[k, 3], along[3], v4, least, unit, c4)
        flat = (ROUNDING * np.abs(arms[k]).max()) ** 2 * far
        _pair(c3, c4, pairs)
        best, first, second, rest = 0.0, 0, 0, 0
        for a in range(len(v1)):
            for b in range(len(v2)):
                _ratios(c1[a], c2[b], pairs, flat, ratios)
                for e in range(len(ratios)):
                    if ratios[e] > best:
                        best, first, second, rest = ratios[e], a, b, e
        chosen[k, 0], chosen[k, 1], chosen[k, 2], chosen[k, 3] = first, second, rest // len(v4), rest % len(v4)
        values[k] = math.sqrt(best)


@njit(cache=True)
def _columns(
    arm: Array, root: Array, along: Array, offsets: Array, least: float, unit: bool, columns: Array
) -> float:  # fmt: skip
    """Un-normalised column of one cable at each offset, and the square of what its component is multiplied with.

    The column of a cable shorter than ``least`` is zero, which leaves no combination with it in wrench closure.

    Returns:
        The largest squared length, or for J~ 1: what a component rounds with.
    """
    far = 0.0
    for at in range(len(offsets)):
        x, y = root[0] + offsets[at] * along[0], root[1] + offsets[at] * along[1]
        if x * x + y * y < least * least:
            x = y = 0.0
        columns[at, 0], columns[at, 1], columns[at, 2] = x, y, arm[0] * y - arm[1] * x
        columns[at, 3] = x * x + y * y if unit else 1.0
        far = max(far, columns[at, 3])
    return far


@njit(cache=True)
def _pair(c3: Array, c4: Array, pairs: Array) -> None:
    """Every pair of columns 3 and 4: their vector product, then both columns."""
    at = 0
    for c in range(len(c3)):
        for d in range(len(c4)):
            pairs[0, at] = c3[c, 1] * c4[d, 2] - c3[c, 2] * c4[d, 1]
            pairs[1, at] = c3[c, 2] * c4[d, 0] - c3[c, 0] * c4[d, 2]
            pairs[2, at] = c3[c, 0] * c4[d, 1] - c3[c, 1] * c4[d, 0]
            for k in range(4):
                pairs[3 + k, at], pairs[7 + k, at] = c3[c, k], c4[d, k]
            at += 1


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz", "nnan", "ninf"})
def _ratios(one: Array, two: Array, pairs: Array, flat: float, ratios: Array) -> None:
    """Squared ratio of least to largest component for every pair; written and not compared, so that it vectorises."""
    x1, y1, m1, s1 = one[0], one[1], one[2], one[3]
    x2, y2, m2, s2 = two[0], two[1], two[2], two[3]
    x, y, m = y1 * m2 - m1 * y2, m1 * x2 - x1 * m2, x1 * y2 - y1 * x2
    for e in range(pairs.shape[1]):
        n1 = x2 * pairs[0, e] + y2 * pairs[1, e] + m2 * pairs[2, e]
        n2 = -(x1 * pairs[0, e] + y1 * pairs[1, e] + m1 * pairs[2, e])
        n3 = x * pairs[7, e] + y * pairs[8, e] + m * pairs[9, e]
        n4 = -(x * pairs[3, e] + y * pairs[4, e] + m * pairs[5, e])
        t1, t2 = n1 * abs(n1) * s1, n2 * abs(n2) * s2
        t3, t4 = n3 * abs(n3) * pairs[6, e], n4 * abs(n4) * pairs[10, e]
        low, high = min(min(t1, t2), min(t3, t4)), max(max(t1, t2), max(t3, t4))
        small, large = max(low, -high), max(high, -low)
        ratios[e] = small / large if small > TOLERANCE**2 * large + flat else 0.0
