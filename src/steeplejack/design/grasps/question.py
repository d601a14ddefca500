"""A grasp as a question: which robot, at which orientation, in which region; and what an answer is."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.grasps.region import GraspRegion
from steeplejack.errors import InfeasibleError, InputError
from steeplejack.mechanics.cable.structure import planar_arms, planar_structure_matrix
from steeplejack.mechanics.cable.wrench.closure import tension_factor

Array = NDArray[np.float64]

FARTHEST = 1e6  # [1] spans of the robot to the region, and sides of the region: beyond is no question, and underflow
ROUNDING = 1e-12  # [1] of the box about the places, over how far it reaches from the region's point


@dataclass(frozen=True, eq=False)
class GraspQuestion:
    """A planar four-cable robot that is to grasp a stay without turning.

    Attributes:
        anchors: ``A_i``, (4, 2) [m].
        attachments: ``lB_i`` in the platform frame, (4, 2) [m].
        phi: Orientation [rad].
        region: Where it may grasp.
    """

    anchors: Array
    attachments: Array
    phi: float
    region: GraspRegion

    def __post_init__(self) -> None:
        """Refuse what is not four cables and an angle."""
        for name in ("anchors", "attachments"):
            values = np.array(getattr(self, name), dtype=np.float64)
            if values.shape != (4, 2) or not np.isfinite(values).all():
                raise InputError(name, f"shape {values.shape}", "four finite points, (4, 2) in metres")
            object.__setattr__(self, name, values)
        if not math.isfinite(self.phi):
            raise InputError("phi", f"{self.phi:g} rad", "a finite angle")
        self._check_reach()

    def _check_reach(self) -> None:
        """Refuse a region so large or far away that products of lengths would underflow in it."""
        with np.errstate(over="ignore", invalid="ignore"):
            arm = float(np.linalg.norm(self.attachments, axis=1).max())
            span = float(np.linalg.norm(np.ptp(self.anchors, axis=0))) + 2.0 * arm
            away = float(np.linalg.norm(self.region.point - self.anchors, axis=1).max())
        sizes = {"half_width": self.region.half_width, "half_length": self.region.half_length, "distance": away}
        for name, size in sizes.items():
            if span > 0.0 and not size <= FARTHEST * span < math.inf:
                valid = f"at most {FARTHEST:.0e} times the robot's {span:.3g} m"
                raise InputError(f"{name} of the grasp region", f"{size:.3g} m", valid)

    @property
    def places(self) -> Array:
        """``A_i - b_i``: where the platform would be with cable ``i`` at no length, (4, 2) [m].

        Forces along the cables balance only inside their convex hull: ``sum f_i (A_i - b_i - p) / l_i = 0`` with
        ``f > 0`` makes ``p`` a mean of them with positive weights. So outside it no position is in wrench closure.
        """
        return self.anchors - planar_arms(self.attachments, self.phi)

    def tension_factor(self, positions: Array) -> Array:
        """TF (Eq. 12) at positions (..., 2) [m], 0 outside wrench closure, (...) [1]."""
        poses = np.concatenate((positions, np.full((*positions.shape[:-1], 1), self.phi)), axis=-1)
        return tension_factor(planar_structure_matrix(self.anchors, self.attachments, poses))

    def within(self, half_width: float) -> GraspQuestion:
        """The same question in a region of another half width [m]."""
        return replace(self, region=replace(self.region, half_width=half_width))

    def trimmed(self) -> GraspQuestion:
        """The same question in what of the region can be in wrench closure: the box about the hull of `places`.

        The region stays a rectangle about the axis. Where the box has no part of it, what is left is its side or corner
        nearest to the box, which is not in wrench closure either.
        """
        region = self.region
        along, across = region.coordinates(self.places).T
        room = ROUNDING * float(np.abs(region.coordinates(self.places)).max())
        ends = np.clip((along.min() - room, along.max() + room), -region.half_length, region.half_length)
        width = min(region.half_width, float(np.abs(across).max()) + room)
        middle, half = float(0.5 * ends.sum()), float(0.5 * np.ptp(ends))
        point = region.placed((middle, 0.0)) if middle else region.point
        return replace(self, region=replace(region, point=point, half_width=width, half_length=half))

    def no_grasp(self, binding: str) -> InfeasibleError:
        """The error that says why there is none."""
        x, y = self.region.point
        return InfeasibleError(f"grasp about ({x:.6g}, {y:.6g}) m at phi = {math.degrees(self.phi):.6g} deg", binding)


@dataclass(frozen=True, eq=False)
class Grasp:
    """Where the platform should grasp.

    Attributes:
        position: Of the platform, (2,) [m].
        tension_factor: TF there [1].
        distance: From the axis of the stay, perpendicular [m].
        evaluations: Nodes or boxes looked at.
        gap: By how much TF anywhere in the region can exceed this one, proved [1]; None where nothing is proved.
    """

    position: Array
    tension_factor: float
    distance: float
    evaluations: int
    gap: float | None
