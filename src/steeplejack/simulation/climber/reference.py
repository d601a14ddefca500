"""References from a plan: the sampled poses of a move as lengths of the limbs and turn of the linkage."""

from __future__ import annotations

import math
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
    """One phase at every control step, at rest beyond its end; a phase without a move has one step.

    Attributes:
        duration: Of the move, 0 for a phase without one [s].
        step: Of the control [s].
        poses: (x, w, alpha, beta), (n, 4) [m, m, rad, rad].
        joints: Lengths of the limbs and turn of the linkage (n, 4) [m, rad].
        rates: Held for a step, they bring the joints where the next step wants them (n, 4). The rate at the step
            itself would pass the end of every ramp by half a step's way.
    """

    duration: float
    step: float
    poses: Array
    joints: Array
    rates: Array

    @classmethod
    def of(cls, layout: Layout, phase: Phase, step: float) -> MoveReference:
        """Interpolate a phase: monotone between its samples, so that no length overshoots a limit the plan holds.

        Args:
            layout: Hinges of the limbs.
            phase: Of a plan.
            step: Of the control [s].
        """
        if phase.kind != "move" or len(phase.times) < 2:
            pose = np.array([phase.start])
            joints = np.column_stack([limb_lengths(layout, pose[:, :3]), pose[:, 3]])
            return cls.through(0.0, step, pose, joints)
        duration = float(phase.times[-1])
        times = np.minimum(step * np.arange(math.ceil(duration / step) + 1), duration)
        sampled = np.column_stack([limb_lengths(layout, phase.poses[:, :3]), phase.poses[:, 3]])
        joints = PchipInterpolator(phase.times, sampled)(times)
        return cls.through(duration, step, PchipInterpolator(phase.times, phase.poses)(times), joints)

    @classmethod
    def through(cls, duration: float, step: float, poses: Array, joints: Array) -> MoveReference:
        """The move through these joints, one row a step."""
        rates = np.zeros_like(joints)
        rates[:-1] = np.diff(joints, axis=0) / step
        return cls(duration, step, poses, joints, rates)

    def slowed(self, fastest: float) -> MoveReference:
        """The same way with no limb faster than ``fastest`` [m/s]; itself where none is."""
        factor = float(np.abs(self.rates[:, :3]).max()) / fastest
        if factor <= 1.0:
            return self
        now = np.arange(len(self.poses)) / (len(self.poses) - 1)
        then = np.linspace(0.0, 1.0, math.ceil((len(self.poses) - 1) * factor) + 1)
        poses, joints = (
            np.column_stack([np.interp(then, now, column) for column in rows.T]) for rows in (self.poses, self.joints)
        )
        return MoveReference.through(self.step * (len(then) - 1), self.step, poses, joints)

    @property
    def last(self) -> int:
        """Index of the last step."""
        return len(self.joints) - 1
