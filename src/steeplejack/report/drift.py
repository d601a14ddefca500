"""What drifting wheel odometry and inclinometers alone do to the platform.

The controller believes the winch exits stand where wheels and inclinometers say. In the plane of the cables it pulls
until the four measured lengths fit the planned pose as well as three freedoms allow; out of that plane the
platform hangs where the planned tensions balance it. With the true exits elsewhere by ``dA`` the platform comes to rest
elsewhere by x:

    P^T J^T (J x + u . dA) = 0        in the plane: translation along the platform's x and y, rotation about its z
    Q^T (K x - G dA) = 0              out of it

with J the derivative of the cable lengths, u the cable directions, K the stiffness that tension gives the platform and
``G dA = sum_i lever_i^T (1 - u_i u_i^T) dA_i t_i / l_i`` the wrench that moving the exits adds; all at the planned
pose, to first order in dA. Exits that all shift alike take the platform along: x = dA.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from steeplejack.mechanics.cable.rest.statics import directions, tension_stiffness

Array = NDArray[np.float64]


def drift_shift(
    actual: Array,
    measured: Array,
    attachments: Array,
    weight: Array,
    centre: Array,
    position: Array,
    rotation: Array,
    tension: Array,
) -> Array:
    """Shifts (n, 6) (rotation; translation) [rad; m] of a platform whose winch exits are not where they are measured.

    Args:
        actual: True winch exits (n, 4, 3) [m].
        measured: Measured winch exits (n, 4, 3) [m].
        attachments: Attachments (4, 3) [m], platform frame.
        weight: Gravity force on platform and payload (3,) [N].
        centre: Centre of mass (3,) [m], platform frame.
        position: Planned positions (n, 3) [m].
        rotation: Planned orientations (n, 3, 3); their first two columns span the plane of control.
        tension: Tensions (n, 4) [N].
    """
    n = len(position)
    u, lengths, hessian = np.empty((n, 4, 3)), np.empty((n, 4)), np.empty((n, 6, 6))
    for j in range(n):
        u[j], lengths[j] = directions(measured[j], attachments, position[j], rotation[j])
        hessian[j] = tension_stiffness(attachments, weight, centre, rotation[j], u[j], lengths[j], tension[j])
    arms = np.einsum("nij,kj->nki", rotation, attachments)
    moved = actual - measured
    grow = np.sum(u * moved, axis=2)
    force = (moved - grow[:, :, None] * u) * (tension / lengths)[:, :, None]
    wrench = np.concatenate([np.cross(arms, force).sum(axis=1), force.sum(axis=1)], axis=1)
    lengthen = -np.concatenate([np.cross(arms, u), u], axis=2)
    inside, outside = _freedoms(rotation)
    fit = inside @ lengthen.swapaxes(1, 2)
    rows = np.concatenate([fit @ lengthen, outside @ hessian], axis=1)
    right = np.concatenate([-fit @ grow[:, :, None], outside @ wrench[:, :, None]], axis=1)
    return (np.linalg.pinv(rows) @ right)[:, :, 0]


def _freedoms(rotation: Array) -> tuple[Array, Array]:
    """Unit twists (n, 3, 6) in and out of the plane spanned by the first two columns of rotations (n, 3, 3)."""
    inside, outside = np.zeros((2, len(rotation), 3, 6))
    x, y, z = rotation[:, :, 0], rotation[:, :, 1], rotation[:, :, 2]
    inside[:, 0, 3:], inside[:, 1, 3:], inside[:, 2, :3] = x, y, z
    outside[:, 0, :3], outside[:, 1, :3], outside[:, 2, 3:] = x, y, z
    return inside, outside
