"""Where both grippers are in the world while one of them holds and the mechanism goes through poses."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.alone import along_way, seen, uses_alone
from steeplejack.planning.climb.collide import meets
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import footing, lines_under
from steeplejack.planning.climb.plan import Hold
from steeplejack.planning.climb.solids import Solids
from steeplejack.robots.pipe_climber.bars import linkage_bars, mechanism_bars
from steeplejack.robots.pipe_climber.grippers import free_gripper
from steeplejack.worksite.pipe_run import PipeRun

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


def gripper_frames(
    run: PipeRun, machine: Machine, lower: tuple[str, float, float], start: Array, freedoms: Array, closed: Hold
) -> tuple[Array, Array]:
    """World frames (k, 4, 4) of the lower and the upper gripper.

    Args:
        run: Of pipes.
        machine: What climbs.
        lower: Pipe, place [m] and clock [rad] of the lower gripper when the mechanism is at ``start``.
        start: (x, w, alpha, beta) then, (4,).
        freedoms: Since, (k, 4) [m, m, rad, rad].
        closed: The gripper that stays.
    """
    name, s, clock = lower
    point, frame = run.pipe(name).chord(s, machine.row)
    still = np.eye(4)
    c, d = math.cos(clock), math.sin(clock)
    still[:3, :3] = frame @ np.array([[c, -d, 0.0], [d, c, 0.0], [0.0, 0.0, 1.0]])
    still[:3, 3] = point
    chain = free_gripper(freedoms, machine.claw_offset)
    if closed is not Hold.UPPER:
        return np.broadcast_to(still, chain.shape), still @ chain
    upper = still @ free_gripper(start, machine.claw_offset)
    return upper @ np.linalg.inv(chain), np.broadcast_to(upper, chain.shape)


def touching(solids: Solids, machine: Machine, lowers: Array, freedoms: Array, air: float, linkage: bool) -> Flags:
    """Whether bars come nearer than ``air`` [m] to a solid, at frames (k, 4, 4) of the lower gripper, (k,).

    Args:
        solids: Of the run.
        machine: What climbs.
        lowers: Frames of the lower gripper.
        freedoms: (k, 4) [m, m, rad, rad].
        air: [m].
        linkage: Whether the linkage's bars count; they swing open when the lower gripper changes pipes.
    """
    points, frames = lowers[:, :3, 3], lowers[:, :3, :3]
    bars, radii = mechanism_bars(machine.robot, machine.layout, freedoms[:, :3])
    found = meets(solids, points, frames, freedoms[:, 3:], bars, radii, air)[:, 0]
    if linkage:
        bars, radii = linkage_bars(machine.robot, freedoms[:, 3])
        found |= meets(solids, points, frames, np.zeros((len(points), 1)), bars, radii, air)[:, 0]
    return found


def worst_uses(
    run: PipeRun, machine: Machine, frames: tuple[Array, Array], freedoms: Array, at: Sequence[tuple[str, float]],
    holds: Hold,
) -> Array:  # fmt: skip
    """The most that holding alone takes on the way of grip, force and torque, (3,); see `alone.uses_alone`.

    Args:
        run: Of pipes.
        machine: What climbs.
        frames: Of the lower and the upper gripper, (k, 4, 4) each.
        freedoms: Along the way, (k, 4) [m, m, rad, rad].
        at: Pipe and place [m] of the lower and the upper gripper; only that of the one that holds counts.
        holds: Which one.
    """
    pipes, s = [run.pipe(name) for name, _s in at], [np.array([one]) for _name, one in at]
    feet = np.array([footing(machine, *one)[0] for one in zip(pipes, s, strict=True)])
    lines = np.array([lines_under(machine, *one)[0] for one in zip(pipes, s, strict=True)])
    rests = seen(lines[None], np.stack([each[:1, :3, :3] for each in frames], axis=1))  # the one that holds stays
    count = len(freedoms)
    every = (np.broadcast_to(feet, (count, *feet.shape)), np.broadcast_to(rests, (count, *rests.shape[1:])))
    gravity = np.array(run.gravity) @ frames[0][:, :3, :3]
    uses = uses_alone(machine, freedoms, gravity, *every, along_way(machine, freedoms))
    return uses[:, int(holds is Hold.UPPER)].max(axis=0)
