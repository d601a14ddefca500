"""The best grasp, exactly: the largest tension factor over a region, certified, and what nearness to the axis costs.

The tension factor over positions has several local maxima, kinks where the binding ratio changes, and mostly its
largest value on the border of the region. Branch and bound (`search`) with bounds that hold at every position of a box
(`bounds`) finds the largest and proves that nothing in the region exceeds it by more than the gap. Of positions that
are as good as each other, the one nearest to the axis is the answer.

The front asks the other question of Algorithm 1, whole: the largest tension factor at no more than a distance from the
axis, for every distance. A larger distance only adds two strips to a smaller one, and of those only what exceeds the
best so far is of interest, so the whole front costs little more than one search.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.design.grasps.bounds import LEAST_FACTOR
from steeplejack.design.grasps.cofactors import Cofactors, cofactors_of
from steeplejack.design.grasps.question import Grasp, GraspQuestion
from steeplejack.design.grasps.search import climb
from steeplejack.errors import InputError

Array = NDArray[np.float64]

GAP = 1e-8  # [1] of TF, reached also at positions that are nearly singular
FINEST = 1e-12  # [1] of TF, mostly reached too; TF nearer than that count as equal, being rounded themselves
MOST_BOXES = 400_000  # [1] to reach the gap, about half a second
MORE_BOXES = 5_000  # [1] to go beyond it
NEARER = 1e-9  # [1] difference of distances from the axis that matters, in scaled units


@dataclass(frozen=True, eq=False)
class GraspFront:
    """The largest tension factor at no more than a distance from the axis of the stay.

    Attributes:
        distances: Bounds of the distance, as asked, (k,) [m].
        tension_factor: Largest TF within each, 0 where no position is in wrench closure, (k,) [1].
        positions: Where, (k, 2) [m]; not a number where there is none.
        gap: By how much TF can exceed that, proved, (k,) [1].
        evaluations: Boxes looked at.
    """

    distances: Array
    tension_factor: Array
    positions: Array
    gap: Array
    evaluations: int


def best_grasp(question: GraspQuestion, gap: float = GAP) -> Grasp:
    """Position of the largest tension factor in the region, nearest to the axis where several are as good.

    Args:
        question: Robot, orientation and region.
        gap: Difference to the bound to reach [1].

    Returns:
        The grasp with its certified gap; mostly that is far below what was asked, and above it only where `MOST_BOXES`
        came first.

    Raises:
        InputError: A gap that is not positive.
        InfeasibleError: No position of the region is in wrench closure.
    """
    _check(gap)
    asked, question = question, question.trimmed()
    cofactors = cofactors_of(question)
    length, width = _sides(question, cofactors)
    whole = [(-length, length, -width, width)]
    best, upper, looked = _search(cofactors, whole, 0.0, gap)
    if np.isnan(best[0]):
        raise asked.no_grasp(_why(upper, looked))
    finer, least, more = _search(cofactors, whole, float(best[2]), FINEST, MORE_BOXES)
    best = best if np.isnan(finer[0]) else finer
    nearest, yet_more = _nearest(cofactors, best, length)
    position = question.region.placed(nearest[:2] * cofactors.unit)
    factor = float(question.tension_factor(position))
    distance = float(abs(nearest[1]) * cofactors.unit)
    return Grasp(position, factor, distance, looked + more + yet_more, max(min(upper, least) - factor, FINEST))


def grasp_front(question: GraspQuestion, distances: ArrayLike, gap: float = GAP) -> GraspFront:
    """The trade between tension factor and distance from the axis.

    Args:
        question: Robot, orientation and region; its half width is no bound here, the distances are.
        distances: Greatest distances from the axis, in any order, (k,) [m].
        gap: Difference to the bound to reach [1].

    Returns:
        The front; its tension factor never falls as the distance grows.

    Raises:
        InputError: A distance that is negative or not finite, none at all, or a gap that is not positive.
    """
    _check(gap)
    asked = np.array(distances, dtype=np.float64)
    if asked.ndim != 1 or not asked.size or not np.isfinite(asked).all() or asked.min() < 0.0:
        raise InputError("distances", f"{asked.tolist()}", "at least one, finite, 0 m or more")
    question = question.within(float(asked.max())).trimmed()
    cofactors = cofactors_of(question)
    length = question.region.half_length / cofactors.unit
    best, bound, looked, last = np.array([np.nan, np.nan, 0.0]), 0.0, 0, -1.0
    found = np.empty((asked.size, 4))
    for k in np.argsort(asked, kind="stable"):
        outer = min(float(asked[k]), question.region.half_width) / cofactors.unit
        if outer > last:
            strips = [(-length, length, last, outer), (-length, length, -outer, -last)]
            boxes = strips if last >= 0.0 else [(-length, length, -outer, outer)]
            better, upper, more = _search(cofactors, boxes, float(best[2]), gap)
            best = best if np.isnan(better[0]) else better
            bound, looked, last = max(bound, upper), looked + more, outer
        found[k] = *best, max(bound - float(best[2]), FINEST)
    closed = np.isfinite(found[:, 0])
    return GraspFront(
        distances=asked,
        tension_factor=np.where(closed, found[:, 2], 0.0),
        positions=question.region.placed(found[:, :2] * cofactors.unit),
        gap=found[:, 3],
        evaluations=looked,
    )


def _check(gap: float) -> None:
    if not 0.0 < gap < 1.0:
        raise InputError("gap", f"{gap:g}", "a number between 0 and 1")


def _sides(question: GraspQuestion, cofactors: Cofactors) -> tuple[float, float]:
    """Half sides of the region, scaled."""
    return question.region.half_length / cofactors.unit, question.region.half_width / cofactors.unit


def _search(
    cofactors: Cofactors,
    boxes: list[tuple[float, float, float, float]],
    floor: float,
    gap: float,
    most: int = MOST_BOXES,
    dive: bool = False,
) -> tuple[Array, float, int]:
    """Position and TF above the floor, not a number where there is none; upper bound of TF; boxes looked at."""
    best = np.empty(3)
    upper, looked = climb(
        np.array(boxes), floor, gap, most, dive,
        cofactors.roots, cofactors.polynomials, cofactors.slack, cofactors.off, cofactors.arm, best,
    )  # fmt: skip
    return best, upper, looked


def _nearest(cofactors: Cofactors, best: Array, length: float) -> tuple[Array, int]:
    """The position nearest to the axis among those as good as the best, and how many boxes that took.

    The first question, whether anything is nearer by a millionth, has the answer no unless maxima tie.
    """
    floor, looked = float(best[2]) - FINEST, 0
    near, far = 0.0, abs(float(best[1]))
    middle = far * (1.0 - 1e-6) - NEARER
    while far - near > NEARER and middle >= 0.0:
        found, _, more = _search(cofactors, [(-length, length, -middle, middle)], floor, 1.0, MORE_BOXES, dive=True)
        looked += more
        if not np.isnan(found[0]):
            best, far = found, abs(float(found[1]))
        elif looked == more:
            break
        else:
            near = middle
        middle = 0.5 * (near + far)
    return best, looked


def _why(upper: float, looked: int) -> str:
    """What rules a grasp out."""
    if upper <= LEAST_FACTOR:
        return f"no position of the region is in wrench closure, proved over {looked} box{'' if looked == 1 else 'es'}"
    return (
        f"no position in wrench closure was found among {looked} boxes; a tension factor above {upper:.2g} is ruled out"
    )
