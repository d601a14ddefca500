"""Where grippers are along their pipes by their own sensors, and moves that bring them where the plan wants them.

Pads give under load and what has slipped stays slipped, so places drift from the plan's by some hundredths of a
millimetre a step. Each gripper's sensor counts the pipe that passes through it: in a bend a little less than the
centre line is long, as a gripper's middle goes along the chords between its rows of pads. What the gripper that holds
is off its place by, the other one's next move makes up for, as far as the cylinders' windows let it.
"""

from __future__ import annotations

import numpy as np

from steeplejack.planning.climb.plan import Hold, Phase
from steeplejack.robots.pipe_climber import Layout, PipeClimber
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.pads import pad_row
from steeplejack.simulation.climber.reference import Array, MoveReference
from steeplejack.worksite.pipe_line import Pipe
from steeplejack.worksite.pipe_run import PipeRun

GRAIN = 2e-3
"""Between places of a pipe that the way of a gripper is summed over [m]."""
SHARES = (1.0, 0.5, 0.25)
"""Of a correction, the largest of which that stays within the windows is made [1]."""
ROUNDING = 1e-9  # [m]


class Odometer:
    """Places of both grippers along their pipes.

    Args:
        robot: The machine.
        layout: Hinges of its limbs.
        run: The pipes.
        passed: What the sensors have counted when the first phase begins (2,) [m].
        first: The first phase of a plan, in whose places the grippers are.
    """

    def __init__(self, robot: PipeClimber, layout: Layout, run: PipeRun, passed: Array, first: Phase) -> None:
        self._layout, self._speed = layout, robot.cylinders.speed
        self._ways = {pipe.name: _way(pipe, pad_row(robot)) for pipe in run.pipes}
        self._windows = (
            np.array(robot.cylinders.retracted),
            np.array(robot.cylinders.retracted) + robot.cylinders.stroke,
        )
        self._pipes = (first.pipe_lower, first.pipe_upper)
        self._zero = passed - self._wanted(first)

    def off(self, phase: Phase, passed: Array) -> Array:
        """How far both grippers are ahead of where a phase has them when it begins (2,) [m].

        A gripper that has crossed to another pipe is taken to be where it should be.
        """
        wanted, pipes = self._wanted(phase), (phase.pipe_lower, phase.pipe_upper)
        crossed = np.array([pipe != before for pipe, before in zip(pipes, self._pipes, strict=True)])
        self._zero, self._pipes = np.where(crossed, passed - wanted, self._zero), pipes
        return passed - self._zero - wanted

    def corrected(self, reference: MoveReference, phase: Phase, passed: Array) -> MoveReference:
        """A move that begins where the grippers are and ends where the plan wants the one that moves.

        Args:
            reference: The move as planned.
            phase: Of the plan, about to begin.
            passed: What the sensors have counted (2,) [m].
        """
        lower, upper = self.off(phase, passed)
        before, after = upper - lower, upper if phase.hold is Hold.UPPER else -lower
        for share in SHARES:
            poses = _apart(reference.poses, np.linspace(before, share * after, len(reference.poses)))
            lengths = limb_lengths(self._layout, poses[:, :3])
            if self._within(lengths[-1], reference.joints[-1, :3]):
                break
        else:
            poses = _apart(reference.poses, np.linspace(before, 0.0, len(reference.poses)))
            lengths = limb_lengths(self._layout, poses[:, :3])
        joints = np.column_stack([np.clip(lengths, *self._windows), reference.joints[:, 3]])
        fastest = max(self._speed, float(np.abs(reference.rates[:, :3]).max()))
        return MoveReference.through(reference.duration, reference.step, poses, joints).slowed(fastest)

    def _wanted(self, phase: Phase) -> Array:
        """What the sensors would have counted from the beginnings of the pipes to where a phase begins (2,) [m]."""
        ways = self._ways[phase.pipe_lower], self._ways[phase.pipe_upper]
        return np.array([np.interp(s, *way) for s, way in zip((phase.s_lower, phase.s_upper), ways, strict=True)])

    def _within(self, lengths: Array, planned: Array) -> bool:
        """Whether lengths are within the windows, or at least not beyond what was planned."""
        low, high = self._windows
        low, high = np.minimum(low, planned) - ROUNDING, np.maximum(high, planned) + ROUNDING
        return bool(((lengths >= low) & (lengths <= high)).all())


def _way(pipe: Pipe, row: float) -> tuple[Array, Array]:
    """Places along a pipe, and how far the middle of a gripper has come there (k,) [m]."""
    places = np.linspace(0.0, pipe.length, max(2, round(pipe.length / GRAIN) + 1))
    middles = 0.5 * (pipe.centre_line(places - row)[0] + pipe.centre_line(places + row)[0])
    steps = np.linalg.norm(np.diff(middles, axis=0), axis=1)
    return places, np.concatenate(([0.0], np.cumsum(steps)))


def _apart(poses: Array, further: Array) -> Array:
    """Poses with the grippers further apart (n,) [m], along the upper one's pipe."""
    out = poses.copy()
    out[:, 0] += further * np.sin(poses[:, 2])
    out[:, 1] += further * np.cos(poses[:, 2])
    return out
