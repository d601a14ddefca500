"""Where both grippers are, as a pose of the mechanism: the four freedoms that join two places on the pipes.

Of the upper place's frame in the lower one's, the origin p and the tangent t have to lie in one plane through the
lower pipe's axis, for the mechanism's X-Z plane has to be that plane. Its clock is then phi = atan2(p_y, p_x), or
phi + pi with the same pose mirrored: toward +X or -X. On one straight pipe every clock will do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.limits import LIMITS, Machine, margins

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

IN_PLANE = 1e-6
"""How far the upper place may miss the plane, [m] and [1]."""
IN_LINE = 1e-9
"""How far it may miss the axis of the lower one to count as on the same straight, [m] and [1]."""
RESERVE = 5e-6
"""Kept from the limits of the cylinders off the straight, where they curve between two places looked at [m]."""


@dataclass(frozen=True)
class Joined:
    """Pairs of places and the poses that join them.

    Attributes:
        coaxial: Both on one straight, (k,).
        clocks: Of the mechanism's X axis about the lower pipe, toward either side, (k, 2) [rad]; 0 where coaxial.
        poses: (x, w, alpha) at these, (k, 2, 3) [m, m, rad].
        margins: Inside each limit, (k, 2, limits); see `limits.margins`.
        allowed: Whether all of them hold, (k, 2).
    """

    coaxial: Flags
    clocks: Array
    poses: Array
    margins: Array
    allowed: Flags

    def only(self, keep: Flags) -> Joined:
        """Some of the pairs."""
        return Joined(self.coaxial[keep], self.clocks[keep], self.poses[keep], self.margins[keep], self.allowed[keep])


def join(machine: Machine, lower: tuple[Array, Array], upper: tuple[Array, Array]) -> Joined:
    """Poses that join places of the lower gripper with places of the upper one.

    Args:
        machine: With its limits.
        lower: Points (k, 3) [m] and frames (k, 3, 3) of the pipe there.
        upper: The same.

    Returns:
        Poses and what they keep or pass.
    """
    back = np.swapaxes(lower[1], -1, -2)
    p = (back @ (upper[0] - lower[0])[..., None])[..., 0]
    turn = back @ upper[1]
    t = turn[..., :, 2]
    aside, lean = np.hypot(p[:, 0], p[:, 1]), np.hypot(t[:, 0], t[:, 1])
    coaxial = (aside < IN_LINE) & (lean < IN_LINE) & (p[:, 2] > 0.0) & (t[:, 2] > 0.0)
    from_place = aside > 0.05 * lean
    phi = np.where(from_place, np.arctan2(p[:, 1], p[:, 0]), np.arctan2(t[:, 1], t[:, 0]))
    phi = np.where(coaxial, 0.0, phi)
    clocks = np.stack((phi, phi + math.pi), axis=-1)
    cos, sin = np.cos(clocks), np.sin(clocks)
    out = p[:, None, 0] * cos + p[:, None, 1] * sin
    alpha = np.arctan2(t[:, None, 0] * cos + t[:, None, 1] * sin, np.broadcast_to(t[:, None, 2], cos.shape))
    hz = machine.claw_offset
    poses = np.stack((out - hz * np.sin(alpha), p[:, None, 2] - hz * np.cos(alpha), alpha), axis=-1)
    poses[coaxial, :, 0] = poses[coaxial, :, 2] = 0.0
    kept = margins(machine, poses.reshape(-1, 3)).reshape(len(p), 2, len(LIMITS))
    planar = _planar(p, t, turn, clocks[:, 0]) | coaxial
    kept[..., 0] = np.where(planar, 1.0, -1.0)[:, None]
    reserve = np.zeros((len(p), 1, kept.shape[-1]))
    reserve[~coaxial, :, 1:3] = RESERVE
    allowed = np.asarray((kept - reserve >= -1e-9).all(axis=-1))
    return Joined(coaxial, clocks, poses, kept, allowed)


def poses_at(machine: Machine, lower: tuple[Array, Array], upper: tuple[Array, Array], clocks: Array) -> Array:
    """Poses (k, 3) that bring the upper gripper to places near the mechanism's plane at clocks (k,); no limits kept.

    Args:
        machine: With its claw's offset.
        lower: Points (k, 3) [m] and frames (k, 3, 3) of the pipe.
        upper: The same.
        clocks: Of the mechanism's X axis about the lower pipe [rad].
    """
    back = np.swapaxes(lower[1], -1, -2)
    p, t = (back @ (upper[0] - lower[0])[..., None])[..., 0], (back @ upper[1][..., 2, None])[..., 0]
    cos, sin = np.cos(clocks), np.sin(clocks)
    alpha = np.arctan2(t[:, 0] * cos + t[:, 1] * sin, t[:, 2])
    hz = machine.claw_offset
    return np.stack((p[:, 0] * cos + p[:, 1] * sin - hz * np.sin(alpha), p[:, 2] - hz * np.cos(alpha), alpha), axis=-1)


def _planar(p: Array, t: Array, turn: Array, clock: Array) -> Flags:
    """Whether place and tangent lie in the plane at a clock, and the plane keeps its clock along the way."""
    cos, sin = np.cos(clock), np.sin(clock)
    off_place, off_tangent = -p[:, 0] * sin + p[:, 1] * cos, -t[:, 0] * sin + t[:, 1] * cos
    normal = np.stack((-sin, cos, np.zeros_like(cos)), axis=-1)
    seen = (np.swapaxes(turn, -1, -2) @ normal[..., None])[..., 0]
    kept = np.abs(np.hypot(seen[:, 0] + sin, seen[:, 1] - cos)) < 1e-5
    return (np.abs(off_place) < IN_PLANE) & (np.abs(off_tangent) < IN_PLANE) & kept
