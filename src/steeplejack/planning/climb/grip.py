"""How much of a gripper's grip the robot takes when that gripper holds alone: force and moment over its pads.

See `robots.pipe_climber.pads` for what a grip holds. On top of the weight comes the inertia of what moves
(`robots.pipe_climber.inertia`): in a ramp the fastest cylinder accelerates by ``pi v / (2 T)`` along the open gripper's
way, forward or back, and the linkage by ``pi omega / (2 T)`` to either side. A plan leaves the reserve of the robot
file unused: uses are in parts of what it may use.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.limits import Machine
from steeplejack.robots.pipe_climber.inertia import inertia_loads
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.pads import grip_body, grip_use
from steeplejack.robots.pipe_climber.weights import grip_loads

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

STRAIGHT = 1e-8
"""Least x [m] or alpha [rad] of a pose off the straight."""


def alone(machine: Machine, freedoms: Array, gravity: Array, feet: Array, pushes: Array) -> Array:
    """Use of the lower and of the upper gripper's grip, each holding alone, in parts of what a plan may use.

    Args:
        machine: With its pads, masses, payload and reserve.
        freedoms: (x, w, alpha, beta), (k, 4) [m, m, rad, rad].
        gravity: In the lower gripper's frame, (k, 3) [m/s2].
        feet: Radius of the pipe [m] and touching rows at the lower and the upper gripper, (k, 2, 2); see
            `places.footing`.
        pushes: Inertia to try on top of the weight, the worst counts, (m, k, 2, 6) [N m, N].

    Returns:
        (k, 2), above 1 where it slips or tilts, or comes too near to that.
    """
    loads = grip_loads(machine.robot, machine.layout, freedoms, gravity, machine.payload)
    tried = np.moveaxis(loads + pushes, 0, 1)  # those of one state together: each is near the last one
    use = np.zeros((len(freedoms), 2))
    for end in range(2):
        for radius, rows in np.unique(feet[:, end], axis=0):
            mine = (feet[:, end, 0] == radius) & (feet[:, end, 1] == rows)
            body = grip_body(machine.robot, float(radius), int(rows))
            use[mine, end] = grip_use(body, tried[mine, :, end]).max(axis=1)
    return use / (1.0 - machine.robot.gait.reserve)


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


def either_way(machine: Machine, poses: Array, ways: Array, which: Indices, beta: Array) -> Array:
    """Inertia of moves that begin or end in poses and turn, either way both: `alone`'s pushes (4, k, 2, 6).

    The upper gripper turns with both grippers on one straight only, where x and alpha are 0.

    Args:
        machine: With its speeds and ramp.
        poses: (x, w, alpha), (j, 3) [m, m, rad].
        ways: How poses change when the upper, and when the lower gripper goes on, (j, 2, 3).
        which: Pose of each state, (k,).
        beta: Turn of the linkage in each, (k,) [rad]; for the load on the upper gripper, of which it moves less than
            1e-3 N m, it is left out.
    """
    still = np.append(poses, np.zeros((len(poses), 1)), axis=-1)
    turn = np.zeros((len(poses), 2, 4))
    turn[:, :, 3] = machine.peaks[1]
    turn[np.abs(poses[:, [0, 2]]).max(axis=1) > STRAIGHT, 0] = 0.0
    along, turning = (
        _carried(inertia_loads(machine.robot, machine.layout, still, rates, machine.payload)[which], beta)
        for rates in (ramps(machine, poses, ways), turn)
    )
    return np.stack((along + turning, along - turning, -along - turning, -along + turning))


def _carried(loads: Array, beta: Array) -> Array:
    """Loads (k, 2, 6), those on the lower gripper turned from the mechanism's frame into its own."""
    c, s = np.cos(beta)[:, None], np.sin(beta)[:, None]
    out = loads.copy()
    x, y = loads[:, 0, [0, 3]], loads[:, 0, [1, 4]]
    out[:, 0, [0, 3]], out[:, 0, [1, 4]] = x * c - y * s, x * s + y * c
    return out


def along_way(machine: Machine, freedoms: Array) -> Array:
    """Inertia of one move, if it began or ended at any place on its way: `alone`'s pushes (2, k, 2, 6).

    Args:
        machine: With its speeds and ramp.
        freedoms: (x, w, alpha, beta) along the way, (k, 4) [m, m, rad, rad].
    """
    if len(freedoms) < 2:
        return np.zeros((1, len(freedoms), 2, 6))
    ways = np.gradient(freedoms, axis=0)
    lengths = np.gradient(limb_lengths(machine.layout, freedoms[:, :3]), axis=0)
    peak, turning = machine.peaks
    part = np.maximum(np.abs(lengths).max(axis=1) / peak, np.abs(ways[:, 3]) / turning)
    rates = ways / np.where(part > 0.0, part, 1.0)[:, None]
    loads = inertia_loads(machine.robot, machine.layout, freedoms, rates, machine.payload)
    return np.stack((loads, -loads))
