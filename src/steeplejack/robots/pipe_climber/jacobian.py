"""Velocity of the 3-RPR mechanism in closed form: the 3x3 Jacobian between platform and actuators.

``qd = J (xd, wd, alphad)`` with row i ``(n_x, n_z, r_z n_x - r_x n_z)``: n the unit vector along limb i from B_i to P_i
and r from O2 to P_i. It is Eq. 17 of Ye et al. (Robotica 2024) after these corrections: Eq. 14 takes moments of the
transmission wrenches about O1 while the twist is that at O2, Eq. 16 repeats the wrench of limb 1 in every row, and the
diagonal of Eq. 18 must hold ``S_Ti o S_i2``, the wrench on the twist of the actuated joint, which is 1 for unit
screws; as printed, on ``S_i1``, it is 0. `screws` builds the same matrix from joint screws.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.poses import Array, triples


def jacobian(layout: Layout, poses: ArrayLike) -> Array:
    """Jacobian of the limb lengths with respect to the pose.

    Args:
        layout: Hinges.
        poses: (x, w, alpha) of O2, (..., 3) [m, m, rad].

    Returns:
        ``d q_i / d (x, w, alpha)``, (..., 3, 3) [1, 1, m]; its inverse is the forward one. NaN where a limb has no
        length, where the lengths have no derivative, and where a pose is not finite.

    Raises:
        InputError: Not (..., 3) numbers.
    """
    given = triples("poses", poses)
    rows = np.empty((given.size // 3, 3, 3))
    _rows(np.ascontiguousarray(given).reshape(-1, 3), layout.base, layout.platform, rows)
    return rows.reshape(*given.shape[:-1], 3, 3)


@njit(cache=True, error_model="numpy")
def _rows(poses: Array, base: Array, platform: Array, rows: Array) -> None:
    """``jacobian`` over (k, 3) poses; fills ``rows``."""
    for k in range(poses.shape[0]):
        x, w, alpha = poses[k, 0], poses[k, 1], poses[k, 2]
        c, s = math.cos(alpha), math.sin(alpha)
        for i in range(3):
            r_x, r_z = platform[i] * c, -platform[i] * s
            d_x, d_z = x + r_x - base[i], w + r_z
            per_length = 1.0 / math.sqrt(d_x * d_x + d_z * d_z)
            rows[k, i, 0] = d_x * per_length
            rows[k, i, 1] = d_z * per_length
            rows[k, i, 2] = (r_z * d_x - r_x * d_z) * per_length
