"""Which of many good offsets: the nearest to where the anchors stand, to a proved distance.

A tension factor of 1 is three equations in four offsets and is reached on a whole curve; more generally, offsets that
keep a stated tension factor form a region. The one with the least total driving along the stays,
``sum_i |d_i| |v_i - start_i|``, is found by branch and bound over the same boxes as the optimum: a box goes where no
offsets in it keep the tension factor, by the twist bound, or where its nearest corner is no nearer than what is known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.design.anchors.boxes import PIECES, examine, pop, push, separate
from steeplejack.design.anchors.exact import AGREED, AnchorOptimum, check_budget, sightlines, tension_factors
from steeplejack.design.anchors.problem import Reconfiguration
from steeplejack.design.anchors.twists import columns, factor_of
from steeplejack.errors import InputError

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class NearestAnchors:
    """Offsets that keep a tension factor with the least driving, at each of k poses.

    Attributes:
        offsets: Along x, (k, 4) [m]; those of the optimum where it is infeasible.
        driving: Along the stays from the places given, (k,) [m].
        least: Proved lower bound of the driving that keeps the tension factor, (k,) [m].
    """

    offsets: Array
    driving: Array
    least: Array


def nearest_anchors(
    problem: Reconfiguration,
    optimum: AnchorOptimum,
    start: ArrayLike = 0.0,
    loss: float = 1e-6,
    within: float = 1e-4,
    most: int = 20_000,
) -> NearestAnchors:
    """The least driving at each pose that keeps the optimum but for a loss.

    Args:
        problem: Anchors, platform, windows and poses.
        optimum: Of the same problem, objective J.
        start: Offsets driven from, (4,) or one a pose (k, 4) [m]; by default the present places.
        loss: Tension factor that may be given up [1].
        within: Driving above its lower bound that ends the search [m].
        most: Boxes to look at before giving up, a pose; ``driving - least`` says what was proved by then.

    Returns:
        Offsets, driving and its bound.

    Raises:
        InputError: An optimum of another problem or objective, a loss or distance that is not positive, no boxes, or
            starts that are not four finite offsets a pose.
    """
    for name, number in (("loss", loss), ("within", within)):
        if not number > 0.0:
            raise InputError(name, f"{number:g}", "positive")
    check_budget(most)
    count = len(problem.poses)
    starts = np.asarray(start, dtype=np.float64)
    if starts.shape not in ((), (4,), (1, 4), (count, 4)) or not np.isfinite(starts).all():
        raise InputError("start", f"shape {starts.shape}", f"four finite offsets, or four for each of {count} poses")
    _check_optimum(problem, optimum)
    arms, roots, shortest, unit = sightlines(problem)
    offsets = optimum.offsets / unit
    driving, least = np.zeros(count), np.zeros(count)
    approach(
        arms, roots, problem.directions, shortest, problem.windows / unit,
        np.array(np.broadcast_to(starts / unit, (count, 4))),
        np.where(optimum.tension_factor > 0.0, np.maximum(optimum.tension_factor - loss, 0.0), np.inf),
        within / unit, int(most), offsets, driving, least,
    )  # fmt: skip
    return NearestAnchors(offsets * unit, driving * unit, least * unit)


def _check_optimum(problem: Reconfiguration, optimum: AnchorOptimum) -> None:
    """Refuse offsets that are not an optimum of this problem."""
    count, valid = len(problem.poses), "that of `optimal_anchors` for the same problem, objective J"
    if optimum.offsets.shape != (count, 4) or optimum.tension_factor.shape != (count,):
        raise InputError("optimum", f"{len(optimum.offsets)} poses, the problem has {count}", valid)
    inside = (optimum.offsets >= problem.windows[:, 0]) & (optimum.offsets <= problem.windows[:, 1])
    if not inside.all():
        pose = int(np.flatnonzero(~inside.all(axis=1))[0])
        raise InputError("optimum", f"offsets outside the windows at pose {pose}", valid)
    if not np.abs(optimum.value - optimum.tension_factor).max() <= AGREED:
        raise InputError("optimum", "its value is not the tension factor", valid)
    if not np.abs(tension_factors(problem, optimum.offsets) - optimum.tension_factor).max() <= AGREED:
        raise InputError("optimum", "its offsets have other tension factors in this problem", valid)


@njit(cache=True)
def approach(
    arms: Array, roots: Array, along: Array, shortest: Array, windows: Array, starts: Array, floors: Array,
    within: float, most: int, offsets: Array, driving: Array, least: Array,
) -> None:  # fmt: skip
    """Least driving that keeps a tension factor, pose by pose; the kernel of `nearest_anchors`.

    Args:
        arms: ``b_i`` at each pose, (k, 4, 2).
        roots: ``BA_i`` at no offset, (k, 4, 2).
        along: Change of ``BA_i`` with the offset, (4, 2) [1].
        shortest: Length at each pose from which a cable has a direction, (k,).
        windows: Least and largest offset, (4, 2).
        starts: Offsets driven from, (k, 4).
        floors: Tension factor to keep, (k,) [1]; infinite where nothing is asked.
        within: Driving above its bound that ends the search.
        most: Boxes to look at.
        offsets: In: offsets that keep it. Written with nearer ones, (k, 4).
        driving: Written, (k,).
        least: Written, (k,).
    """
    weights = np.sqrt(along[:, 0] ** 2 + along[:, 1] ** 2)
    room = most + PIECES
    corners, twists = np.empty((room, 2, 4)), np.empty((room, 3))
    keys, heap = np.empty(room), np.empty(room, np.int64)
    for k in range(len(arms)):
        driving[k] = _cost(offsets[k], starts[k], weights)
        least[k] = driving[k]
        if np.isfinite(floors[k]):
            driving[k], least[k] = _near(
                arms[k], roots[k], along, shortest[k], windows, starts[k], weights, floors[k], within, most, offsets[k],
                driving[k], corners, twists, keys, heap,
            )  # fmt: skip


@njit(cache=True)
def _near(
    arms: Array, roots: Array, along: Array, shortest: float, windows: Array, start: Array, weights: Array,
    floor: float, within: float, most: int, best: Array, cost: float, corners: Array, twists: Array, keys: Array,
    heap: Integers,
) -> tuple[float, float]:  # fmt: skip
    """One pose: driving and its lower bound; ``best`` gets the offsets. Keys are bounds of the driving, negative."""
    trial, wrenches = np.empty(4), np.empty((4, 4))
    filled = separate(roots, along, windows, shortest, corners)
    twists[:filled] = 0.0
    waiting, looked, fresh = 0, 0, np.arange(filled)
    while True:
        for at in range(len(fresh)):
            box = int(fresh[at])
            looked += 1
            low, high = corners[box, 0], corners[box, 1]
            bound, _, _ = examine(arms, roots, along, True, shortest, floor, low, high, twists[box], trial)
            if bound < floor:
                continue
            for turn in range(2):
                if turn == 1:  # the box's nearest point, after the offsets its chord problem suggests
                    trial[:] = np.minimum(np.maximum(start, low), high)
                price = _cost(trial, start, weights)
                if price < cost and columns(arms, roots, along, True, shortest, trial, 0.0, wrenches):
                    if factor_of(wrenches) >= floor:
                        cost, best[:] = price, trial
            keys[box] = -_cost(trial, start, weights)
            push(heap, waiting, keys, box)
            waiting += 1
        if waiting == 0 or -keys[heap[0]] >= cost - within or looked + 2 > most:
            break
        one, two = pop(heap, waiting, keys), filled
        fresh = np.array([one, two])
        waiting, filled = waiting - 1, filled + 1
        side = np.argmax(weights * (corners[one, 1] - corners[one, 0]))
        corners[two], twists[two] = corners[one], twists[one]
        corners[one, 1, side] = corners[two, 0, side] = 0.5 * (corners[one, 0, side] + corners[one, 1, side])
    return cost, min(-float(keys[heap[0]]), cost) if waiting > 0 else cost


@njit(cache=True)
def _cost(offsets: Array, start: Array, weights: Array) -> float:
    """Driving along the stays."""
    total = 0.0
    for i in range(4):
        total += weights[i] * abs(offsets[i] - start[i])
    return total
