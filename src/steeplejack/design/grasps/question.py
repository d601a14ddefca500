"""A grasp as a question: which robot, at which orientation, in which region; and what an answer is."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.grasps.region import GraspRegion
from steeplejack.errors import InfeasibleError, InputError
from steeplejack.mechanics.cable.structure import planar_structure_matrix
from steeplejack.mechanics.cable.wrench.closure import tension_factor

Array = NDArray[np.float64]


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

    def tension_factor(self, positions: Array) -> Array:
        """TF (Eq. 12) at positions (..., 2) [m], 0 outside wrench closure, (...) [1]."""
        poses = np.concatenate((positions, np.full((*positions.shape[:-1], 1), self.phi)), axis=-1)
        return tension_factor(planar_structure_matrix(self.anchors, self.attachments, poses))

    def within(self, half_width: float) -> GraspQuestion:
        """The same question in a region of another half width [m]."""
        return replace(self, region=replace(self.region, half_width=half_width))

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
