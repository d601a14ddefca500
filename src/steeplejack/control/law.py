"""The control law: PD in the plane of the cables, bounded tensions, winch torques, wheel tractions.

Pose error and wrench use one structure matrix G (3x4: two forces in the plane, the moment about its normal) at the
reference: lengths give the error by least squares, ``e = -(G G^T)^-1 G (l - l_d)``, and the wrench
``w = -K e - D de/dt`` is spread with the least change of tension, ``G^T (G G^T)^-1 w``. From length to tension that is
``-P K P^T`` with ``P = G^T (G G^T)^-1``: symmetric, so at the winches the controller is a passive spring and damper
whatever the gains. Any other way from lengths to pose, such as the full estimate with its balance of moments, lets
motions out of the plane leak into the wrench and can drive the yaw and tilt modes.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.control.allocation import allocate
from steeplejack.mechanics.cable.rest.statics import directions
from steeplejack.robots.squad.in_plane import plane_matrix

Array = NDArray[np.float64]

TURN_RATE = 2.0  # [1/s] at which a base under way corrects its clock angle
SLOW = 0.01  # [m/s] of reference rate below which friction compensation fades, so that a resting winch does not buzz


@njit(cache=True)
def least_squares(matrix: Array, errors: Array) -> Array:
    """``(G G^T)^-1 G errors`` for G^T = matrix (4, 3), by Cramer's rule; zeros where G has lost its rank."""
    gram, right = np.zeros((3, 3)), np.zeros(3)
    for i in range(4):
        for j in range(3):
            right[j] += matrix[i, j] * errors[i]
            for k in range(3):
                gram[j, k] += matrix[i, j] * matrix[i, k]
    out = np.zeros(3)
    whole = np.linalg.det(gram)
    if whole > 1e-12:
        for j in range(3):
            swapped = gram.copy()
            swapped[:, j] = right
            out[j] = np.linalg.det(swapped) / whole
    return out


@njit(cache=True)
def law(
    exits: Array,
    tangents: Array,
    attachments: Array,
    lengths: Array,
    rates: Array,
    goal: Array,
    goal_rotation: Array,
    goal_velocity: Array,
    goal_acceleration: Array,
    planned: Array,
    bases: Array,
    tension: Array,
    moving: NDArray[np.bool_],
    mass: float,
    gains: Array,
    window: Array,
) -> tuple[Array, Array, Array, int]:
    """Winch pulls (4,) [N], wheel tractions (4,) [N], turning rates (4,) [rad/s] and the allocation's status.

    Args:
        exits: Winch exits as measured (4, 3) [m].
        tangents: Stay tangents there (4, 3).
        attachments: Attachments (4, 3) [m], platform frame.
        lengths: Loaded cable lengths as measured (4,) [m].
        rates: Their rates (4,) [m/s].
        goal: Reference position (3,) [m].
        goal_rotation: Reference orientation (3, 3).
        goal_velocity: (3,) [m/s].
        goal_acceleration: (3,) [m/s2].
        planned: Planned tensions (4,) [N].
        bases: Rows of the bases (8, 4): place, rate, acceleration, clock angle and its rate of the reference; measured
            place, rate and clock angle [m, m/s, m/s2, rad, rad/s].
        tension: Measured tensions (4,) [N].
        moving: Bases with open palms (4,).
        mass: Platform and payload [kg].
        gains: Stiffness, damping [N/m, N s/m], the same about the normal [N m/rad, N m s/rad], stiffness and damping of
            a base [N/m, N s/m], its mass [kg], winch friction [N], reflected rotor mass [kg], largest turning rate of a
            base [rad/s].
        window: Least and largest tension [N], largest pull along the stay gripped and driving [N].
    """
    u, wanted_lengths = directions(exits, attachments, goal, goal_rotation)
    matrix, scale = plane_matrix(u, goal_rotation, attachments)
    along, goal_rates, goal_seconds = np.zeros(4), np.zeros(4), np.zeros(4)
    for i in range(4):
        for k in range(3):
            along[i] += u[i, k] * tangents[i, k]
            goal_rates[i] -= u[i, k] * goal_velocity[k]
            goal_seconds[i] -= u[i, k] * goal_acceleration[k]
    error = -least_squares(matrix, lengths - wanted_lengths)
    speed = -least_squares(matrix, rates - goal_rates - along * bases[6])
    wrench = np.empty(3)
    for axis in range(2):
        ahead = 0.0
        for k in range(3):
            ahead += goal_rotation[k, axis] * goal_acceleration[k]
        wrench[axis] = mass * ahead - gains[0] * error[axis] - gains[1] * speed[axis]
    wrench[2] = -(gains[2] * error[2] + gains[3] * speed[2]) / scale**2
    lower, upper = np.full(4, window[0]), np.full(4, window[1])
    for i in range(4):
        limit = window[3] if moving[i] else window[2]
        if abs(along[i]) * upper[i] > limit:
            upper[i] = limit / abs(along[i])
    wanted, status = allocate(matrix, wrench, planned, lower, upper)
    pull, drive, turn = np.empty(4), np.zeros(4), np.zeros(4)
    for i in range(4):
        rate = goal_rates[i] + along[i] * bases[1, i]
        second = goal_seconds[i] + along[i] * bases[2, i]
        pull[i] = wanted[i] - gains[7] * np.tanh(rate / SLOW) - gains[8] * second
        if moving[i]:
            traction = (
                gains[6] * bases[2, i]
                + gains[4] * (bases[0, i] - bases[5, i])
                + gains[5] * (bases[1, i] - bases[6, i])
                + tension[i] * along[i]
            )
            drive[i] = min(max(traction, -window[3]), window[3])
            rate = bases[4, i] + TURN_RATE * (bases[3, i] - bases[7, i])
            turn[i] = min(max(rate, -gains[9]), gains[9])
    return pull, drive, turn, status
