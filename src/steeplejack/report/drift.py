"""What drifting wheel odometry alone does to the platform.

The controller believes the winch exits stand where the wheels say, and flies the platform so that lengths, tensions
and those exits agree. Where the true exits stand elsewhere by ``dA``, the same lengths and tensions put the platform
elsewhere by ``x``. To first order the estimate of ``control.estimator`` moves by the x that minimises

    |J x + u . dA|^2 / sigma_l^2  +  |K x - G dA|^2 / sigma_W^2

with J the derivative of the cable lengths, u the cable directions, K the stiffness that tension gives the platform and
``G dA = sum_i lever_i^T (1 - u_i u_i^T) dA_i t_i / l_i`` the wrench that moving the exits adds. If all four exits
shift alike, so does the platform: x = dA.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.suspension import directions, stiffness

Array = NDArray[np.float64]


@njit(cache=True)
def drift_shift(
    actual: Array,
    measured: Array,
    attachments: Array,
    weight: Array,
    centre: Array,
    position: Array,
    rotation: Array,
    tension: Array,
    weights: Array,
) -> Array:
    """Shifts (n, 6) (rotation; translation) [rad; m] of a platform whose winch exits are not where they are measured.

    Args:
        actual: True winch exits (n, 4, 3) [m].
        measured: Measured winch exits (n, 4, 3) [m].
        attachments: Attachments (4, 3) [m], platform frame.
        weight: Gravity force on platform and payload (3,) [N].
        centre: Centre of mass (3,) [m], platform frame.
        position: True platform positions (n, 3) [m].
        rotation: True orientations (n, 3, 3).
        tension: Tensions (n, 4) [N].
        weights: sigma of a length [m], of a force [N], of a moment [N m].
    """
    n = position.shape[0]
    out = np.empty((n, 6))
    no_stretch = np.zeros(4)
    rows, right, lever = np.empty((10, 6)), np.empty(10), np.zeros((3, 6))
    for j in range(n):
        u, lengths = directions(actual[j], attachments, position[j], rotation[j])
        rows[4:] = stiffness(attachments, weight, centre, rotation[j], u, lengths, tension[j], no_stretch)
        right[4:] = 0.0
        for i in range(4):
            arm = rotation[j] @ attachments[i]
            lever[:, :3] = np.array([[0.0, arm[2], -arm[1]], [-arm[2], 0.0, arm[0]], [arm[1], -arm[0], 0.0]])
            lever[:, 3:] = np.eye(3)
            moved = actual[j, i] - measured[j, i]
            along = np.sum(u[i] * moved)
            rows[i] = -(u[i] @ lever) / weights[0]
            right[i] = -along / weights[0]
            right[4:] += ((moved - along * u[i]) @ lever) * (tension[j, i] / lengths[i])
        for k in range(6):
            sigma = weights[2] if k < 3 else weights[1]
            rows[4 + k] /= sigma
            right[4 + k] /= sigma
        out[j] = np.linalg.solve(rows.T @ rows, rows.T @ right)
    return out
