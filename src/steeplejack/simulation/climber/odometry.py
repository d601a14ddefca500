"""How far grippers are off their places by what the robot's sensors say, and moves that bring them back.

Pads give under load and what has slipped stays slipped, so places drift from the plan's by some hundredths of a
millimetre a step. A gripper that is closed counts the pipe that passes through it: little, so that the sensor's scale
matters little. Where a move has brought the other one follows from the lengths of the limbs: off is what the one that
held is off, and by how much the two are further apart than planned. The next move of the other one makes up for it, as
far as the cylinders' windows let it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from steeplejack.control.climber.signals import Flags
from steeplejack.planning.climb.plan import Hold, Phase
from steeplejack.robots.pipe_climber import Layout, PipeClimber
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.simulation.climber.reference import Array, MoveReference

SHARES = (1.0, 0.5, 0.25)
"""Of a correction, the largest of which that stays within the windows is made [1]."""
ROUNDING = 1e-9  # [m]
NEWTON = 3  # steps of Newton's method from a pose to one some millimetres away


class Odometer:
    """How far both grippers are ahead of their places along their pipes.

    Args:
        robot: The machine.
        layout: Hinges of its limbs.
        passed: What the sensors have counted at the start, where both grippers are in their places (2,) [m].

    Attributes:
        off: How far the lower and the upper gripper are ahead (2,) [m].
    """

    def __init__(self, robot: PipeClimber, layout: Layout, passed: Array) -> None:
        self._layout, self._speed = layout, robot.cylinders.speed
        retracted = np.array(robot.cylinders.retracted)
        self._windows = retracted, retracted + robot.cylinders.stroke
        self._passed, self._closed = passed, np.ones(2, dtype=bool)
        self.off = np.zeros(2)

    def count(self, closed: Flags, passed: Array) -> None:
        """Add what has passed through grippers that are and were closed.

        Args:
            closed: Which are told to be (2,).
            passed: Sums of the sensors (2,) [m].
        """
        self.off = self.off + np.where(closed & self._closed, passed - self._passed, 0.0)
        self._closed, self._passed = closed, passed

    def moved(self, phase: Phase, made: MoveReference, lengths: Array, together: bool) -> None:
        """Take over where a move has brought the gripper that moved.

        Args:
            phase: As planned.
            made: The move as it was told.
            lengths: Of the limbs at its end, measured (3,) [m].
            together: Whether both grippers are then on one pipe; if not, the one that moved is taken to be in place.
        """
        further = self._further(made.poses[-1], lengths)
        further += _along(made.poses[-1] - np.array(phase.end), phase.end)
        holds, moves, sign = (0, 1, 1.0) if phase.hold is Hold.LOWER else (1, 0, -1.0)
        off = self.off.copy()
        off[moves] = off[holds] + sign * further if together else 0.0
        self.off = off

    def corrected(self, reference: MoveReference, phase: Phase, lengths: Array, together: bool = True) -> MoveReference:
        """A move that begins where the grippers are and ends where the plan wants the one that moves.

        Args:
            reference: The move as planned.
            phase: Of the plan, about to begin.
            lengths: Of the limbs, measured (3,) [m].
            together: Whether both grippers are on one pipe at its end; if not, nothing is made up for.
        """
        before = self._further(reference.poses[0], lengths)
        after = float(self.off[1] if phase.hold is Hold.UPPER else -self.off[0]) * together
        for share in SHARES:
            poses = _apart(reference.poses, np.linspace(before, share * after, len(reference.poses)))
            if self._within(limb_lengths(self._layout, poses[-1, :3]), reference.joints[-1, :3]):
                break
        else:
            poses = _apart(reference.poses, np.linspace(before, 0.0, len(reference.poses)))
        limbs = limb_lengths(self._layout, poses[:, :3])
        joints = np.column_stack([np.clip(limbs, *self._windows), reference.joints[:, 3]])
        fastest = max(self._speed, float(np.abs(reference.rates[:, :3]).max()))
        return MoveReference.through(reference.duration, reference.step, poses, joints).slowed(fastest)

    def _further(self, pose: Array, lengths: Array) -> float:
        """How much further apart than in a pose near by limbs of these lengths hold the grippers [m]."""
        found = pose[:3]
        for _ in range(NEWTON):
            missed = lengths - limb_lengths(self._layout, found)
            found = found + np.linalg.solve(jacobian(self._layout, found), missed)
        return _along(found - pose[:3], pose)

    def _within(self, lengths: Array, planned: Array) -> bool:
        """Whether lengths are within the windows, or at least not beyond what was planned."""
        low, high = self._windows
        low, high = np.minimum(low, planned) - ROUNDING, np.maximum(high, planned) + ROUNDING
        return bool(((lengths >= low) & (lengths <= high)).all())


def _along(change: Array, pose: ArrayLike) -> float:
    """Part of a small change of pose that goes along the upper gripper's pipe [m]."""
    alpha = float(np.asarray(pose)[2])
    return float(change[0] * math.sin(alpha) + change[1] * math.cos(alpha))


def _apart(poses: Array, further: Array) -> Array:
    """Poses with the grippers further apart (n,) [m], along the upper one's pipe."""
    out = poses.copy()
    out[:, 0] += further * np.sin(poses[:, 2])
    out[:, 1] += further * np.cos(poses[:, 2])
    return out
