"""What it takes while one gripper holds alone: of its grip, of the cylinders' force and of the servo's torque.

See `robots.pipe_climber.pads` for what a grip holds and `robots.pipe_climber.bearing` for what the drives bear. On top
of the weight comes the inertia of what moves (`robots.pipe_climber.inertia`): in a ramp the fastest cylinder
accelerates by ``pi v / (2 T)`` along the open gripper's way, forward or back, and the linkage by ``pi omega / (2 T)``
to either side. A plan leaves the reserve of the robot file unused: uses of a grip are in parts of what it may use.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.limits import ROUNDING, Machine
from steeplejack.robots.pipe_climber.bearing import holding_forces, servo_torques
from steeplejack.robots.pipe_climber.inertia import inertia
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.pads import grip_body, grip_use, least_bend, tightest
from steeplejack.robots.pipe_climber.weights import grip_loads

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Inertia = tuple[Array, Array]
"""Inertia to try on top of the weight, the worst counts: loads on the grips (m, k, 2, 6) [N m, N], and what cylinders
and servo have to add (m, k, 2, 4) [N, N m]."""

STRAIGHT = 1e-8
"""Least x [m] or alpha [rad] of a pose off the straight."""
Kind = Literal["grip", "force", "servo"]
KINDS: tuple[Kind, ...] = ("grip", "force", "servo")
DIGITS = 9
"""Of tangents and curvatures that count as one, for grips to be judged together."""


def uses_alone(machine: Machine, freedoms: Array, gravity: Array, feet: Array, lines: Array, moving: Inertia) -> Array:
    """What holding alone takes of the lower and of the upper gripper, in parts of what there is.

    Args:
        machine: With its pads, masses, payload and reserve.
        freedoms: (x, w, alpha, beta), (k, 4) [m, m, rad, rad].
        gravity: In the lower gripper's frame, (k, 3) [m/s2].
        feet: Radius of the pipe [m] and touching rows at the lower and the upper gripper, (k, 2, 2); see
            `places.footing`.
        lines: Tangent and curvature of the pipe under each gripper's rows, in its frame, (k, 2, 2, 2, 3) [1, 1/m].
        moving: Inertia to try.

    Returns:
        (k, 2, 3) in the order of `KINDS`: above 1 where the grip slips or tilts, or comes too near to that, where a
        cylinder or the servo is too weak; NaN at a singular pose.
    """
    return np.append(
        _grips(machine, freedoms, gravity, feet, lines, moving[0]),
        _drives(machine, freedoms, gravity, moving[1]),
        axis=-1,
    )


def seen(lines: Array, frames: Array) -> Array:
    """Tangents and curvatures of pipes in the frames of the grippers on them.

    Args:
        lines: Under each gripper's rows, in the world (k, 2, 2, 2, 3) [1, 1/m].
        frames: Of the grippers (k, 2, 3, 3).
    """
    return np.einsum("kgrvi,kgij->kgrvj", lines, frames)


def _grips(machine: Machine, freedoms: Array, gravity: Array, feet: Array, lines: Array, pushes: Array) -> Array:
    """Of the grips, (k, 2, 1); infinite on a pipe that grippers are not for, or a bend that jaws do not close in."""
    loads = grip_loads(machine.robot, machine.layout, freedoms, gravity, machine.payload)
    tried = np.moveaxis(loads + pushes, 0, 1)  # those of one state together: each is near the last one
    use = np.zeros((len(freedoms), 2, 1))
    thinnest, thickest = (0.5 * one for one in machine.robot.gripper.pipe_diameter)
    for end in range(2):
        rests = np.column_stack((feet[:, end], np.round(lines[:, end].reshape(-1, lines[0, end].size), DIGITS)))
        for (radius, rows, *rest), mine in _alike(rests):
            line = np.reshape(rest, lines.shape[2:])
            fits = thinnest - ROUNDING <= radius <= thickest + ROUNDING
            if not fits or tightest(line) <= least_bend(machine.robot, radius):
                use[mine, end, 0] = np.inf
                continue
            body = grip_body(machine.robot, radius, int(rows), line)
            use[mine, end, 0] = grip_use(body, tried[mine, :, end]).max(axis=1)
    return use / (1.0 - machine.robot.gait.reserve)


def _alike(rows: Array) -> Iterator[tuple[list[float], Indices]]:
    """The different rows of a table (k, n), k at least 1, and where each stands."""
    order = np.lexsort(rows.T)
    ahead = rows[order]
    begin = np.flatnonzero(np.append(True, (ahead[1:] != ahead[:-1]).any(axis=1)))
    for first, mine in zip(begin, np.split(order, begin[1:]), strict=True):
        yield ahead[first].tolist(), mine


def _drives(machine: Machine, freedoms: Array, gravity: Array, added: Array) -> Array:
    """Of the strongest cylinder's force and of the servo's torque, (k, 2, 2)."""
    robot, layout, payload = machine.robot, machine.layout, machine.payload
    forces = holding_forces(robot, layout, freedoms, gravity, payload) + added[..., :3]
    torques = added[..., 3] - servo_torques(robot, layout, freedoms, gravity, payload)
    force = np.abs(forces).max(axis=(0, -1)) / robot.cylinders.force
    torque = np.abs(torques).max(axis=0) / robot.build.servo_torque
    return np.stack((force, torque), axis=-1)


def ramps(machine: Machine, poses: Array, ways: Array) -> Array:
    """Peak accelerations of the mechanism where a gripper moves along its pipe, (k, m, 4).

    Args:
        machine: With its speeds and ramp.
        poses: (x, w, alpha), (k, 3) [m, m, rad].
        ways: How poses change on the way, to any scale, (k, m, 3).

    Returns:
        Of (x, w, alpha, beta), such that the fastest cylinder has its peak [m/s2, m/s2, rad/s2, rad/s2].
    """
    rates = np.abs(np.einsum("kij,kmj->kmi", jacobian(machine.layout, poses), ways)).max(axis=-1)
    scale = np.where(rates > 0.0, machine.peaks[0] / np.where(rates > 0.0, rates, 1.0), 0.0)
    return np.append(ways * scale[..., None], np.zeros((*ways.shape[:2], 1)), axis=-1)


@dataclass(frozen=True)
class EitherWay:
    """Inertia of moves that begin or end in poses and turn, along and turning for each, at any turn of the linkage.

    Attributes:
        lower: `inertia` with the lower gripper holding and beta = 0, (2, j, 6) and (2, j, 4): all that moves turns with
            the mechanism, and so does the load.
        upper: With the upper gripper holding and the linkage at 0, a quarter and half a turn: that of the lower
            gripper, which turns, is ``a + b cos(beta) + c sin(beta)``.
    """

    lower: Inertia
    upper: tuple[Inertia, Inertia, Inertia]

    def at(self, which: Indices, beta: Array) -> Inertia:
        """Either way both, four to try, in states: their poses and turns of the linkage, (k,) [rad]."""
        ends = self._lower_holds(which, beta), self._upper_holds(which, beta)
        loads, drives = (np.stack(both, axis=-2) for both in zip(*ends, strict=True))
        return _signed(*loads), _signed(*drives)

    def _lower_holds(self, which: Indices, beta: Array) -> Inertia:
        loads, drives = self.lower[0][:, which], self.lower[1][:, which]
        c, s = np.cos(beta)[:, None], np.sin(beta)[:, None]
        x, y = loads[..., [0, 3]], loads[..., [1, 4]]
        loads[..., [0, 3]], loads[..., [1, 4]] = x * c - y * s, x * s + y * c
        return loads, drives

    def _upper_holds(self, which: Indices, beta: Array) -> Inertia:
        c, s = np.cos(beta)[:, None], np.sin(beta)[:, None]
        middles = ((0.5 * (none + half), none, quarter) for none, quarter, half in zip(*self.upper, strict=True))
        loads, drives = (
            middle[:, which] + c * (none - middle)[:, which] + s * (quarter - middle)[:, which]
            for middle, none, quarter in middles
        )
        return loads, drives


def either_way(machine: Machine, poses: Array, ways: Array) -> EitherWay:
    """Inertia of moves that begin or end in poses.

    The upper gripper turns with both grippers on one straight only, where x and alpha are 0.

    Args:
        machine: With its speeds and ramp.
        poses: (x, w, alpha), (j, 3) [m, m, rad].
        ways: How poses change when the upper, and when the lower gripper goes on, (j, 2, 3).
    """
    turn = np.zeros((len(poses), 2, 4))
    turn[:, :, 3] = machine.peaks[1]
    turn[np.abs(poses[:, [0, 2]]).max(axis=1) > STRAIGHT, 0] = 0.0
    rates = np.stack((ramps(machine, poses, ways), turn))
    none, quarter, half = (_turned_by(machine, poses, rates[:, :, 1], beta, 1) for beta in (0.0, 0.5 * np.pi, np.pi))
    return EitherWay(_turned_by(machine, poses, rates[:, :, 0], 0.0, 0), (none, quarter, half))


def _turned_by(machine: Machine, poses: Array, rates: Array, turn: float, end: int) -> Inertia:
    """`inertia` of poses with the linkage at one turn [rad]."""
    freedoms = np.append(poses, np.full((len(poses), 1), turn), axis=-1)
    return inertia(machine.robot, machine.layout, freedoms, rates, end, machine.payload)


def _signed(along: Array, turning: Array) -> Array:
    """Both ways of both, (4, ...)."""
    return np.stack((along + turning, along - turning, -along - turning, -along + turning))


def along_way(machine: Machine, freedoms: Array) -> Inertia:
    """Inertia of one move, if it began or ended at any place on its way: two to try.

    Args:
        machine: With its speeds and ramp.
        freedoms: (x, w, alpha, beta) along the way, (k, 4) [m, m, rad, rad].
    """
    if len(freedoms) < 2:
        return np.zeros((1, len(freedoms), 2, 6)), np.zeros((1, len(freedoms), 2, 4))
    ways = np.gradient(freedoms, axis=0)
    lengths = np.gradient(limb_lengths(machine.layout, freedoms[:, :3]), axis=0)
    peak, turning = machine.peaks
    part = np.maximum(np.abs(lengths).max(axis=1) / peak, np.abs(ways[:, 3]) / turning)
    rates = np.stack((ways, -ways)) / np.where(part > 0.0, part, 1.0)[:, None]
    ends = (inertia(machine.robot, machine.layout, freedoms, rates, end, machine.payload) for end in range(2))
    loads, drives = (np.stack(both, axis=-2) for both in zip(*ends, strict=True))
    return loads, drives
