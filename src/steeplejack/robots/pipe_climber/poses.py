"""Poses of the parallel mechanism: what a row of numbers means, and the claw's pose against that of O2.

A pose is ``(x, w, alpha)``: place of the platform's origin O2 in the plane X-Z of the base frame O1 and rotation about
Y [m, m, rad]. The claw's centre O3 sits ``hz`` behind O2 on the platform's own z axis, so it turns with alpha:

    O3 = (x + hz sin(alpha), w + hz cos(alpha))        ("turning")

Eq. 8 of Ye et al. (Robotica 2024) subtracts hz along the fixed Z instead, ``w = z - hz`` ("along-z"). The two differ by
``2 hz sin(alpha/2)``, 39 mm at hz = 100 mm and 22.5 deg.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError

Array = NDArray[np.float64]
Offset = Literal["turning", "along-z"]


def triples(where: str, values: ArrayLike) -> Array:
    """Values as numbers with a last axis of three; rows that are not finite stay in and get NaN as an answer.

    Raises:
        InputError: Not real numbers, or another last axis.
    """
    try:
        given = np.asarray(values)
    except ValueError:
        raise InputError(where, "rows of unlike length", "an array of numbers") from None
    if given.dtype.kind not in "fiu":
        raise InputError(where, f"entries of type {given.dtype}", "real numbers")
    if given.ndim == 0 or given.shape[-1] != 3:
        raise InputError(where, f"shape {given.shape}", "(..., 3)")
    return given.astype(np.float64, copy=False)


def claw_pose(poses: ArrayLike, claw_offset: ArrayLike, offset: Offset = "turning") -> Array:
    """Pose of the claw's centre O3 from that of O2.

    Args:
        poses: (x, w, alpha) of O2, (..., 3) [m, m, rad].
        claw_offset: hz, distance from O2 to O3 (...) [m].
        offset: Whether hz turns with the platform, as it does, or lies along the fixed Z, as in Eq. 8.

    Returns:
        (x, z, alpha) of O3, (..., 3) [m, m, rad].
    """
    return _shifted(triples("poses", poses), np.asarray(claw_offset, dtype=np.float64), offset)


def platform_pose(claw_poses: ArrayLike, claw_offset: ArrayLike, offset: Offset = "turning") -> Array:
    """Pose of O2 from that of the claw's centre O3: the inverse of `claw_pose`, same arguments."""
    return _shifted(triples("claw poses", claw_poses), -np.asarray(claw_offset, dtype=np.float64), offset)


def _shifted(poses: Array, by: Array, offset: Offset) -> Array:
    """Poses moved along the platform's z axis, or along Z."""
    alpha = poses[..., 2]
    across, along = (np.sin(alpha), np.cos(alpha)) if offset == "turning" else (0.0, 1.0)
    x, w = np.broadcast_arrays(poses[..., 0] + by * across, poses[..., 1] + by * along)
    return np.stack((x, w, np.broadcast_to(alpha, x.shape)), axis=-1)
