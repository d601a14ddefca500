"""References from a plan: the sampled poses of a move as lengths of the limbs and turn of the linkage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from steeplejack.planning.climb.plan import Phase
from steeplejack.robots.pipe_climber import Layout
from steeplejack.robots.pipe_climber.inverse import limb_lengths

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MoveReference:
    """One phase, ready to be sampled in time.

    Attributes:
        duration: Of the move, 0 for a phase without one [s].
        poses: (x, w, alpha, beta) over time.
        joints: Lengths of the limbs and turn of the linkage over time.
        rates: Their derivatives.
    """

    duration: float
    poses: PchipInterpolator
    joints: PchipInterpolator
    rates: PchipInterpolator

    @classmethod
    def of(cls, layout: Layout, phase: Phase) -> MoveReference:
        """Interpolate a phase: monotone between its samples, so that no length overshoots a limit the plan holds."""
        moving = phase.kind == "move" and len(phase.times) > 1
        times = phase.times if moving else np.array([0.0, 1.0])
        poses = phase.poses if moving else np.array([phase.start, phase.start])
        joints = np.column_stack([limb_lengths(layout, poses[:, :3]), poses[:, 3]])
        curve = PchipInterpolator(times, joints)
        duration = float(times[-1]) if moving else 0.0
        return cls(duration, PchipInterpolator(times, poses), curve, curve.derivative())

    def at(self, time: float) -> tuple[Array, Array, Array]:
        """Pose (4,), joints (4,) and rates (4,) at a time [s]; at rest beyond the ends."""
        inside = min(max(time, 0.0), self.duration)
        rates = self.rates(inside) if 0.0 <= time < self.duration else np.zeros(4)
        return self.poses(inside), self.joints(inside), rates
