"""Certified workspaces of spatial robots over ranges of orientation, for any number of cables.

Orientations are rotation vectors in a box: ``R = exp(w) R_0`` with ``w`` in world axes, each component between two ends
[rad]. A component with equal ends is fixed, so ``w = (0, 0, -a..a)`` is a range of headings and
``(-a..a, -a..a, 0)`` one of tilts. Two regions:

- `certify_poses`: boxes of poses, up to six coordinates, each proved to hold at all of its poses or at none.
- `certify_orientations`: boxes of positions, proved to hold at *every* orientation of the range (the total orientation
  workspace), or not to at one orientation, which is named, whatever the position in the box.

Both ask wrench closure or, with limits, wrench feasibility of several wrenches; a weight turns with the platform about
its centre of mass. Proofs are those of `witness`. Boxes are cut until the undecided volume is the stated share. A
region of six dimensions has a large surface: over positions and all three turns at once expect bounds, not a small gap;
what was reached stands in the answer. Where a cable may have no length nothing is decided.

Source of the questions: Gouttefarde, Daney, Merlet, Interval-Analysis-Based Determination of the Wrench-Feasible
Workspace of Parallel Cable-Driven Robots, IEEE T-RO 27(1), 2011.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import cables, finite, kind, open_limits, whole
from steeplejack.mechanics.cable.region import witness
from steeplejack.mechanics.cable.region.certified import CertifiedRegion, branch, search_box
from steeplejack.spatial.rotation import rotation_matrix

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

WIDEST = math.pi
"""Longest rotation vector of a range [rad]."""


@dataclass(frozen=True, eq=False)
class PoseQuestion:
    """Wrench closure or feasibility of a spatial robot that turns, in scaled units.

    Attributes:
        length: One scaled unit of length [m].
        origin: Position that scaled ones count from, (3,) [m].
        anchors: Scaled, (m, 3).
        arms: Attachments turned by the reference rotation, scaled, (m, 3).
        wrenches: (moment; force), scaled, (k, 6); none for wrench closure.
        centre: Where the forces act, turned by the reference rotation, scaled, (3,).
        lower: Least tensions, scaled, (m,); none for wrench closure.
        upper: Greatest tensions, scaled, (m,); none for wrench closure.
    """

    length: float
    origin: Array
    anchors: Array
    arms: Array
    wrenches: Array
    centre: Array
    lower: Array
    upper: Array

    @property
    def arguments(self) -> tuple[Array, Array, Array, Array, Array, Array]:
        """What the kernels take first."""
        return self.anchors, self.arms, self.wrenches, self.centre, self.lower, self.upper


def pose_question(
    anchors: ArrayLike,
    attachments: ArrayLike,
    rotation: ArrayLike | None = None,
    wrenches: ArrayLike | None = None,
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
    centre: ArrayLike = (0.0, 0.0, 0.0),
) -> PoseQuestion:
    """Wrench closure of a spatial robot at poses of any orientation, or with limits its feasibility.

    Args:
        anchors: (m, 3), m >= 7; with limits m >= 6 [m].
        attachments: In the platform frame, (m, 3) [m].
        rotation: Reference ``R_0``, from platform to world, (3, 3); level if None.
        wrenches: (moment; force) that must each be balanced, (k, 6) or (6,) [N m, N]; with limits, zero if None.
            Moments and forces keep their directions in the world while the platform turns. Forces act at ``centre``,
            so a weight is given without the moment it has about the reference point.
        lower: Least tensions, (m,) or a scalar [N].
        upper: Greatest tensions, (m,) or a scalar, above the least [N].
        centre: Point of the platform frame at which the forces act, (3,) [m].

    Returns:
        The question, for `certify_poses` and `certify_orientations`.

    Raises:
        InputError: Shapes or numbers that cannot be meant.
    """
    limited = lower is not None or upper is not None
    fixed, local = cables(anchors, attachments, 3, 6 if limited else 7)
    turn = rotation_matrix(np.eye(3) if rotation is None else rotation, "rotation")
    point = finite("centre", centre, 3)
    if turn.shape != (3, 3) or point.shape != (3,):
        raise InputError("pose", f"rotation {turn.shape} and centre {point.shape}", "one rotation and one point")
    origin = fixed.min(axis=0) + 0.5 * np.ptp(fixed, axis=0)
    reach = max(float(np.abs(fixed - origin).max()), float(np.abs(local).max()))
    if not 0.0 < reach < math.inf or not local.any():
        raise InputError("cables", "anchors or attachments all at one point", "a robot with some size")
    length = _power(reach)
    low, high, given = np.empty(0), np.empty(0), np.empty((0, 6))
    if limited:
        if lower is None or upper is None:
            raise InputError("tension limits", "one of the two", "least and greatest, or neither")
        low, high = open_limits(lower, upper, len(fixed))
        given = np.atleast_2d(finite("wrenches", np.zeros(6) if wrenches is None else wrenches, 6))
        if given.ndim != 2 or not len(given):
            raise InputError("wrenches", f"shape {given.shape}", "shape (k, 6)")
        force = _power(float(max(np.abs(low).max(), np.abs(high).max())))
        low, high, given = low / force, high / force, given / force
        given[:, :3] /= length
    return PoseQuestion(
        length=length,
        origin=origin,
        anchors=(fixed - origin) / length,
        arms=np.ascontiguousarray(local @ turn.T) / length,
        wrenches=np.ascontiguousarray(given),
        centre=turn @ point / length,
        lower=low,
        upper=high,
    )


@np.errstate(invalid="ignore", over="ignore")
def certify_poses(question: PoseQuestion, box: ArrayLike, gap: float = 0.1, most: int = 1_000_000) -> CertifiedRegion:
    """Enclose the poses of a search box, orientations included, that have the property asked for.

    Args:
        question: From `pose_question`.
        box: Lower and upper end of position and rotation vector, (6, 2) [m, rad]; equal ends fix a coordinate.
        gap: Undecided volume to reach, as a share of the volume not proved outside [1].
        most: Boxes to look at before giving up.

    Returns:
        Boxes (k, 6, 2), and bounds of the volume over the coordinates with width [m3 rad3]; ``reached`` is False where
        ``most`` came first. ``facets`` holds the wrench that is not balanced in each box outside.

    Raises:
        InputError: A search box without volume, not finite or with turns above pi, or a gap that is not positive.
    """
    kind("question", question, PoseQuestion)
    low, high = search_box(box, 6)
    _turns(np.stack((low[3:], high[3:]), axis=1))
    units, origin = np.repeat([question.length, 1.0], 3), np.append(question.origin, np.zeros(3))
    first, last = (low - origin) / units, (high - origin) / units
    root = 0.5 * (last - first)
    slop = witness.ROUNDING * (np.abs(first) + np.abs(last) + np.abs(origin) / units) * (last > first)

    def decide(lows: Array, highs: Array) -> tuple[Integers, Integers, Integers]:
        middles = lows + 0.5 * (highs - lows)
        halves = np.maximum(highs - middles, middles - lows) + slop
        labels, proofs, cuts = (np.empty(len(lows), dtype=np.int64) for _ in range(3))
        witness.classify_poses(*question.arguments, middles, halves, root, labels, proofs, cuts)
        return labels, proofs, cuts

    return branch(decide, first, last, units, origin, gap, most)


@np.errstate(invalid="ignore", over="ignore")
def certify_orientations(
    question: PoseQuestion, box: ArrayLike, turns: ArrayLike, gap: float = 0.05, most: int = 1_000_000
) -> CertifiedRegion:
    """Enclose the positions of a search box that have the property asked for at every orientation of a range.

    Args:
        question: From `pose_question`.
        box: Lower and upper end of the position, (3, 2) [m]; equal ends fix a coordinate.
        turns: Lower and upper end of each component of the rotation vector, (3, 2) [rad]; equal ends fix it.
        gap: Undecided volume to reach, as a share of the volume not proved outside [1].
        most: Boxes to look at before giving up.

    Returns:
        Boxes of positions (k, 3, 2): inside at every orientation, outside at one at least (`failing_turn` gives it for
        the numbers in ``facets``), undecided; and bounds of the volume.

    Raises:
        InputError: A search box without volume or not finite, turns above pi, or a gap that is not positive.
    """
    kind("question", question, PoseQuestion)
    low, high = search_box(box, 3)
    ends = _turns(finite("turns", turns, 3, 2))
    first, last = ((end - question.origin) / question.length for end in (low, high))
    root = 0.5 * np.concatenate((last - first, ends[:, 1] - ends[:, 0]))
    slop = witness.ROUNDING * (np.abs(first) + np.abs(last) + np.abs(question.origin) / question.length)
    slop *= last > first

    def decide(lows: Array, highs: Array) -> tuple[Integers, Integers, Integers]:
        middles = lows + 0.5 * (highs - lows)
        halves = np.maximum(highs - middles, middles - lows) + slop
        labels, proofs, cuts = (np.empty(len(lows), dtype=np.int64) for _ in range(3))
        witness.classify_positions(*question.arguments, middles, halves, ends, root, labels, proofs, cuts)
        return labels, proofs, cuts

    return branch(decide, first, last, np.full(3, question.length), question.origin, gap, most)


@np.errstate(invalid="ignore", over="ignore")
def failing_turn(turns: ArrayLike, number: int) -> Array:
    """The orientation at which a box of `certify_orientations` is proved outside.

    Args:
        turns: The range asked about, (3, 2) [rad].
        number: Of the box, from ``facets``.

    Returns:
        Rotation vector, (3,) [rad].

    Raises:
        InputError: No such range, or a number that belongs to no orientation.
    """
    ends, side = _turns(finite("turns", turns, 3, 2)), witness.LATTICE + 1
    number = whole("number", number, 0, side**3 - 1)
    place = np.array([number // side**2, number // side % side, number % side])
    return ends[:, 0] + (ends[:, 1] - ends[:, 0]) / witness.LATTICE * place


def _turns(ends: Array) -> Array:
    """A box of rotation vectors, (3, 2), none longer than `WIDEST`."""
    if ends.shape != (3, 2) or not (ends[:, 0] <= ends[:, 1]).all():
        raise InputError("turns", f"{ends.tolist()}", "lower and upper end of three components, (3, 2)")
    longest = float(np.linalg.norm(np.abs(ends).max(axis=1)))
    if longest > WIDEST:
        raise InputError("turns", f"rotation vectors up to {longest:g} rad", "at most pi")
    return ends


def _power(size: float) -> float:
    """The power of two at or below a positive number, 1 for zero."""
    return math.ldexp(1.0, math.frexp(size)[1] - 1) if size > 0.0 else 1.0
