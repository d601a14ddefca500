"""The whole robot: the free gripper's pipe axis from the fixed one's, in four freedoms, whichever gripper holds.

The chain is lower gripper, linkage, lower platform with O1 on the pipe's axis, 3-RPR mechanism, upper platform with O2,
offset hz along its z, upper gripper:

    T_lower_upper = Rot_z(beta) Trans(x, 0, w) Rot_y(alpha) Trans(0, 0, hz)

The frame of a gripper has z along its pipe; that of the lower one has its origin at O1 when beta = 0. With the upper
gripper fixed the lower one moves by the inverse. Ye et al. (Robotica 2024) put beta into Eq. 8 of the limbs, which
cannot turn about Z; it belongs beneath them.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from steeplejack.errors import InfeasibleError, InputError
from steeplejack.robots.pipe_climber.poses import Array

End = Literal["lower", "upper"]

RIGID = 1e-6
"""By how much a rotation may miss orthonormality, and a last row 0 0 0 1, and still be taken for rigid [1]."""


def free_gripper(freedoms: ArrayLike, claw_offset: float, fixed: End = "lower") -> Array:
    """Pose of the free gripper in the frame of the fixed one.

    Args:
        freedoms: (x, w, alpha, beta), (..., 4) [m, m, rad, rad].
        claw_offset: hz [m].
        fixed: Which gripper holds the pipe.

    Returns:
        Homogeneous transforms (..., 4, 4), z along the pipe at each.
    """
    x, w, alpha, beta = np.moveaxis(_fours(freedoms), -1, 0)
    ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    zero, one, out = np.zeros_like(x), np.ones_like(x), x + claw_offset * sa
    rows = (
        (ca * cb, -sb, sa * cb, out * cb),
        (ca * sb, cb, sa * sb, out * sb),
        (-sa, zero, ca, w + claw_offset * ca),
        (zero, zero, zero, one),
    )
    upper = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    return upper if fixed == "lower" else _inverse(upper)


def freedoms_of(transform: ArrayLike, claw_offset: float, fixed: End = "lower", tolerance: float = 1e-9) -> Array:
    """The four freedoms that bring the free gripper to a pose: inverse of `free_gripper`.

    Args:
        transform: One homogeneous transform of the free gripper in the fixed one's frame, (4, 4).
        claw_offset: hz [m].
        fixed: Which gripper holds the pipe.
        tolerance: By how much the pose may miss the four freedoms, [m] and [1].

    Returns:
        (x, w, alpha, beta), (4,) [m, m, rad, rad].

    Raises:
        InputError: No homogeneous transform of a rigid body: not finite, a mirror image, a last row beside 0 0 0 1.
        InfeasibleError: A pose off the robot's four freedoms; it names the one that is missing.
    """
    given = _rigid(transform)
    upper = given if fixed == "lower" else _inverse(given)
    beta = math.atan2(-upper[0, 1], upper[1, 1])
    if abs(upper[2, 1]) > tolerance:
        raise InfeasibleError("pose of the free gripper", "its y axis leaves the plane across the pipe: no such turn")
    aside = upper[1, 3] * math.cos(beta) - upper[0, 3] * math.sin(beta)
    if abs(aside) > tolerance:
        raise InfeasibleError("pose of the free gripper", f"{aside:g} m beside the plane of the limbs: no such travel")
    alpha = math.atan2(-upper[2, 0], upper[2, 2])
    out = upper[0, 3] * math.cos(beta) + upper[1, 3] * math.sin(beta)
    return np.array([out - claw_offset * math.sin(alpha), upper[2, 3] - claw_offset * math.cos(alpha), alpha, beta])


def free_gripper_jacobian(freedoms: ArrayLike, claw_offset: float, fixed: End = "lower") -> Array:
    """Twist of the free gripper, at its own origin and expressed in the fixed frame, per rate of each freedom.

    Args:
        freedoms: (..., 4) [m, m, rad, rad].
        claw_offset: hz [m].
        fixed: Which gripper holds the pipe.

    Returns:
        (..., 6, 4), rows (angular; linear); rank 4 everywhere.
    """
    _x, _w, alpha, beta = np.moveaxis(_fours(freedoms), -1, 0)
    upper = free_gripper(freedoms, claw_offset)
    turn, place = upper[..., :3, :3], upper[..., :3, 3]
    cb, sb = np.cos(beta), np.sin(beta)
    angular, linear = np.zeros((*alpha.shape, 3, 4)), np.zeros((*alpha.shape, 3, 4))
    linear[..., 0, 0], linear[..., 1, 0], linear[..., 2, 1] = cb, sb, 1.0
    angular[..., 0, 2], angular[..., 1, 2] = -sb, cb
    linear[..., :, 2] = claw_offset * turn[..., :, 0]
    angular[..., 2, 3] = 1.0
    linear[..., 0, 3], linear[..., 1, 3] = -place[..., 1], place[..., 0]
    if fixed == "lower":
        return np.concatenate((angular, linear), axis=-2)
    # Seen from the upper gripper the lower one turns by -omega and its origin moves by -(v + omega x (0 - place)).
    at_origin = linear - np.cross(angular, place[..., :, None], axis=-2)
    back = np.swapaxes(turn, -1, -2)
    return -np.concatenate((back @ angular, back @ at_origin), axis=-2)


def _fours(freedoms: ArrayLike) -> Array:
    given = np.asarray(freedoms, dtype=np.float64)
    if given.ndim == 0 or given.shape[-1] != 4:
        raise InputError("freedoms", f"shape {given.shape}", "(..., 4): x, w, alpha, beta")
    return given


def _rigid(transform: ArrayLike) -> Array:
    """One homogeneous transform, (4, 4), or an InputError that says what is wrong with it."""
    valid = "(4, 4) with a rotation, a place and the last row 0 0 0 1"
    try:
        given = np.asarray(transform, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("transform", "not an array of numbers", valid) from None
    if given.shape != (4, 4):
        raise InputError("transform", f"shape {given.shape}", valid)
    if not np.isfinite(given).all():
        raise InputError("transform", "an entry that is not finite", valid)
    if np.abs(given[3] - [0.0, 0.0, 0.0, 1.0]).max() > RIGID:
        raise InputError("transform", f"last row {given[3].tolist()}", valid)
    turn = given[:3, :3]
    # Entries of a rotation are at most 1; larger ones might overflow in the product.
    if np.abs(turn).max() > 1.0 + RIGID or np.abs(turn @ turn.T - np.eye(3)).max() > RIGID:
        raise InputError("transform", "columns that are not orthonormal", valid)
    if np.linalg.det(turn) < 0.0:
        raise InputError("transform", "a mirror image", valid)
    return given


def _inverse(transform: Array) -> Array:
    """Inverse of homogeneous transforms."""
    turn = np.swapaxes(transform[..., :3, :3], -1, -2)
    inverse = np.zeros_like(transform)
    inverse[..., :3, :3] = turn
    inverse[..., :3, 3] = -(turn @ transform[..., :3, 3, None])[..., 0]
    inverse[..., 3, 3] = 1.0
    return inverse
