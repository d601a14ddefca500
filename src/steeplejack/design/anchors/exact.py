"""Optimal anchors pose by pose: the largest tension factor over continuous offsets, with a proof that it is.

Branch and bound over boxes of offsets. A box is bounded by a twist of the platform (`twists`), and the same problem
that finds the twist suggests offsets (`chords`); both are off by a term of second order in the size of the box, so a
few boxes do. With the paper's un-normalised columns (J~, Eq. 22-24) chords and arcs are the same and one box is enough:
Eq. 24 as printed is a linear program.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.anchors import branch
from steeplejack.design.anchors.problem import Reconfiguration
from steeplejack.errors import InputError
from steeplejack.mechanics.cable.degeneracy import TOLERANCE
from steeplejack.mechanics.cable.structure import LENGTHLESS, planar_arms, planar_structure_matrix
from steeplejack.mechanics.cable.wrench.closure import tension_factor

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Objective = Literal["J", "J~"]

LEAST_GAP = 1e-12  # [1] above what the bound rounds up
AGREED = 1e-9  # [1] tension factors that are the same but for rounding
SHORTEST = 1e-5  # [1] cable length over the longest coordinate of arms and cables from which its direction is known
MOST_BOXES = 10_000_000  # [1] a pose; a gigabyte of boxes
FARTHEST = 1e6  # [1] spans of the robot to a pose, or longest cables to an offset: beyond is no question, and underflow


class AnchorStatus(IntEnum):
    """How the search ended at a pose; `advice` says what to do."""

    CERTIFIED = branch.CERTIFIED
    INFEASIBLE = branch.INFEASIBLE
    EXHAUSTED = branch.EXHAUSTED

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _ADVICE[self]


_ADVICE = {
    AnchorStatus.CERTIFIED: "no offsets inside the windows do better than the value by more than the gap",
    AnchorStatus.INFEASIBLE: "no offsets inside the windows hold the platform; widen a window or move the pose",
    AnchorStatus.EXHAUSTED: "the boxes were spent before the gap was reached; value and bound hold, ask for more boxes",
}


@dataclass(frozen=True, eq=False)
class AnchorOptimum:
    """Best offsets at each of k poses, and what is proved of them.

    Attributes:
        tension_factor: At the offsets, from J, (k,) [1]; 0 where no offsets hold the platform.
        offsets: Along x, inside the windows, (k, 4) [m]; nearest to the present places where infeasible.
        value: What was maximised, (k,) [1]: the tension factor, or with J~ the paper's ratio.
        upper: Proved bound of that value over the windows, (k,) [1].
        status: `AnchorStatus` by number, (k,).
        boxes: How many boxes of offsets were looked at, (k,).
    """

    tension_factor: Array
    offsets: Array
    value: Array
    upper: Array
    status: Integers
    boxes: Integers

    @property
    def gap(self) -> Array:
        """Bound less value, (k,) [1]."""
        return self.upper - self.value


def optimal_anchors(
    problem: Reconfiguration, gap: float = 1e-9, most: int = 100_000, objective: Objective = "J"
) -> AnchorOptimum:
    """Offsets with the largest tension factor at each pose, to a certified gap.

    The bound covers the rounding of its own evaluation; it is a bound for anchors, arms and poses as rounded once when
    cable vectors are formed, that is for places moved by about 1e-16 of the greatest coordinate. A tension factor of at
    most 1e-9 counts as none, as everywhere in this package, so ``INFEASIBLE`` is a proof that none above that exists.
    Where a stay passes through an attachment, offsets that leave its cable shorter than `SHORTEST` of the robot are not
    among the candidates: rounding would decide its direction.

    Args:
        problem: Anchors, platform, windows and poses.
        gap: Difference between bound and value to reach [1].
        most: Boxes to look at before giving up, a pose.
        objective: "J" for the tension factor; "J~" for the paper's Eq. 24 as printed, ``min n_i / l_i`` over its
            maximum, which is not the tension factor.

    Returns:
        The optimum at each pose.

    Raises:
        InputError: A gap under `LEAST_GAP`, no boxes or more than `MOST_BOXES`, an unknown objective, or a pose or
            window that is `FARTHEST` away.
    """
    if not gap >= LEAST_GAP:
        raise InputError("gap", f"{gap:g}", f"at least {LEAST_GAP:g}, above the rounding of the bound")
    check_budget(most)
    check_objective(objective)
    arms, roots, shortest, unit_length = sightlines(problem)
    count = len(arms)
    offsets, value, upper = np.empty((count, 4)), np.empty(count), np.empty(count)
    boxes, status = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    windows = problem.windows / unit_length
    start = np.clip(0.0, windows[:, 0], windows[:, 1])
    branch.optimise(
        arms, roots, problem.directions, shortest, windows, start, objective == "J", float(gap), int(most),
        offsets, value, upper, boxes, status,
    )  # fmt: skip
    offsets *= unit_length
    factors = tension_factors(problem, offsets)
    if objective == "J":  # a pose so nearly singular that the two evaluations differ is not certified
        apart = np.abs(value - factors) > AGREED
        value, status = np.where(apart, factors, value), np.where(apart, int(AnchorStatus.EXHAUSTED), status)
    return AnchorOptimum(factors, offsets, value, upper, status, boxes)


def tension_factors(problem: Reconfiguration, offsets: Array) -> Array:
    """Tension factor of each pose, 0 outside wrench closure.

    Args:
        problem: Anchors, platform and poses.
        offsets: One configuration a pose, (k, 4), or one for all, (4,) [m].

    Returns:
        TF, (k,) [1].
    """
    return tension_factor(planar_structure_matrix(problem.placed(offsets), problem.attachments, problem.poses))


def sightlines(problem: Reconfiguration) -> tuple[Array, Array, Array, float]:
    """Arms and cable vectors of every pose in a unit of length near that of the problem.

    The unit is a power of two, so that going there and back rounds nothing. Arms count from the mean attachment: about
    which point moments are taken changes no tension, and with cables all in one point none are left, wherever the
    platform's origin is.

    Args:
        problem: Anchors, platform and poses.

    Returns:
        ``b_i`` (k, 4, 2), ``BA_i`` at no offset (k, 4, 2) and the length from which a cable has a direction (k,), all
        in units, and the unit [m].

    Raises:
        InputError: A pose or window that is `FARTHEST` away.
    """
    _check_reach(problem)
    arms = planar_arms(problem.attachments, problem.poses[:, 2])
    roots = problem.anchors - arms - problem.poses[:, None, :2]
    local = problem.attachments - problem.attachments.mean(axis=0)
    if np.abs(local).max() <= TOLERANCE * np.abs(problem.attachments).max():
        local[:] = 0.0
    arms = planar_arms(local, problem.poses[:, 2])
    sizes = np.maximum(np.abs(arms).max(axis=(1, 2)), np.abs(roots).max(axis=(1, 2)))
    coordinates = np.maximum(np.abs(problem.anchors).max(), np.abs(problem.poses[:, :2]).max(axis=1))
    shortest = np.maximum(SHORTEST * sizes, 4.0 * LENGTHLESS * coordinates)
    size = float(max(sizes.max(), np.abs(problem.windows).max()))
    unit = 2.0 ** np.round(np.log2(size)) if size > 0.0 else 1.0
    return np.ascontiguousarray(arms / unit), np.ascontiguousarray(roots / unit), shortest / unit, float(unit)


def _check_reach(problem: Reconfiguration) -> None:
    """Refuse poses and offsets so far away that products of lengths would underflow beside them."""
    with np.errstate(over="ignore", invalid="ignore"):
        arm = float(np.linalg.norm(problem.attachments, axis=1).max())
        span = float(np.linalg.norm(np.ptp(problem.anchors, axis=0))) + 2.0 * arm
        far = np.linalg.norm(problem.anchors - problem.poses[:, None, :2], axis=2).max(axis=1)
        reach = np.abs(problem.windows).max(axis=1) * np.linalg.norm(problem.directions, axis=1)
    worst = int(np.argmax(far))
    if span > 0.0 and not far[worst] <= FARTHEST * span < np.inf:
        valid = f"at most {FARTHEST:.0e} times the robot's {span:.3g} m"
        raise InputError(f"pose {worst}", f"{far[worst]:.3g} m from an anchor", valid)
    longest, widest = float(far.max()) + arm, int(np.argmax(reach))
    if longest > 0.0 and not reach[widest] <= FARTHEST * longest:
        valid = f"at most {FARTHEST:.0e} times the longest cable of {longest:.3g} m"
        raise InputError(f"window of anchor {widest + 1}", f"up to {reach[widest]:.3g} m along its stay", valid)


def check_budget(most: int) -> None:
    """Refuse a number of boxes that is none, or that no memory holds."""
    if not 1 <= most <= MOST_BOXES:
        raise InputError("most", f"{most}", f"1 to {MOST_BOXES} boxes")


def check_objective(objective: str) -> None:
    """Refuse what is neither J nor J~."""
    if objective not in ("J", "J~"):
        raise InputError("objective", repr(objective), "J or J~")
