"""From standings to phases: what opens, moves and closes, and what each step is for."""

from __future__ import annotations

from typing import Literal

import numpy as np

from steeplejack.planning.climb.gait import BEARS, acts, after
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.moves import Standing, lower_moves, timed, way
from steeplejack.planning.climb.plan import Hold, Phase, Pose
from steeplejack.worksite.pipe_run import PipeRun


def phases(run: PipeRun, machine: Machine, standings: tuple[Standing, ...]) -> tuple[Phase, ...]:
    """Release, move and grip between standings."""
    found: list[Phase] = []
    hold = Hold.BOTH
    for start, end in zip(standings, standings[1:], strict=False):
        poses = way(run, machine, start, end)
        assert poses is not None  # the search has looked
        beta = (start.freedoms[3], end.freedoms[3])
        times, freedoms = timed(machine, poses, beta)
        first: Pose = start.freedoms
        last: Pose = end.freedoms
        for kind in acts(Hold.LOWER if lower_moves(start, end) else Hold.UPPER):
            bears, hold = BEARS[hold, kind], after(hold, kind)
            at = end if kind.startswith("grip") else start
            moving = kind == "move"
            found.append(
                Phase(
                    kind, bears, float(times[-1]) if moving else machine.robot.gripper.close_time,
                    last if kind.startswith("grip") else first, first if kind.startswith("release") else last,
                    at.lower[1], at.upper[1], at.lower_clock, _why(run, start, end),
                    *((times, freedoms) if moving else ()),
                    pipe_lower=run.pipes[at.lower[0]].name, pipe_upper=run.pipes[at.upper[0]].name,
                    crosses=(start.lower[0], start.upper[0]) != (end.lower[0], end.upper[0]),
                )
            )  # fmt: skip
    return tuple(found)


def _why(run: PipeRun, start: Standing, end: Standing) -> str:
    """What a step is for, in words."""
    lower = lower_moves(start, end)
    which: Literal["lower", "upper"] = "lower" if lower else "upper"
    before, then = (start.lower, end.lower) if lower else (start.upper, end.upper)
    turn = np.degrees(end.lower_clock - start.lower_clock if lower else end.upper_clock - start.upper_clock)
    if before[0] != then[0]:
        return f"{which} gripper crosses from {run.pipes[before[0]].name} to {run.pipes[then[0]].name}"
    said: list[str] = []
    if abs(then[1] - before[1]) > 1e-9:
        part = "round the bend" if end.pose[2] or start.pose[2] else "along the pipe"
        said.append(f"{1e3 * (then[1] - before[1]):+.1f} mm {part}")
    if abs(turn) > 1e-6:
        said.append(f"{turn:+.0f} deg about the pipe")
    return f"{which} gripper " + (", ".join(said) or "takes another grip")
