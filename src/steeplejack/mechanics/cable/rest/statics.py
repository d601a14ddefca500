"""Compiled statics of one pose on any number of straight cables, for loops that ask thousands of times a second.

The same formulas as `structure` and `stiffness` have for batches (tests hold them together), without their checks.
Shapes are for m cables: anchors (m, 3) [m], attachments (m, 3) [m] in the platform's frame, tensions (m,) [N], weight
(3,) [N] the gravity force, centre (3,) [m] the centre of mass in the platform's frame. Cables are taut and massless. A
cable of no length has no direction: not a number, and so is all that follows from it.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.rest.curvature import add_cable, add_turn, arm_of
from steeplejack.spatial.rotation import turned

Array = NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def directions(anchors: Array, attachments: Array, position: Array, rotation: Array) -> tuple[Array, Array]:
    """Unit vectors (m, 3) from attachment to anchor in the world's frame, and lengths (m,) [m]."""
    m = anchors.shape[0]
    u, lengths = np.empty((m, 3)), np.empty(m)
    for i in range(m):
        square = 0.0
        for k in range(3):
            offset = position[k]
            for j in range(3):
                offset += rotation[k, j] * attachments[i, j]
            u[i, k] = anchors[i, k] - offset
            square += u[i, k] * u[i, k]
        lengths[i] = np.sqrt(square)
        for k in range(3):
            u[i, k] /= lengths[i]
    return u, lengths


@njit(cache=True, error_model="numpy")
def residual(attachments: Array, weight: Array, centre: Array, rotation: Array, u: Array, tensions: Array) -> Array:
    """What is missing to equilibrium: moment about the platform's origin [N m] and force [N] (6,), world frame.

    Args:
        attachments: (m, 3) [m].
        weight: Gravity force (3,) [N].
        centre: Centre of mass (3,) [m].
        rotation: Platform orientation (3, 3).
        u: Cable directions (m, 3), see :func:`directions`.
        tensions: (m,) [N].
    """
    out, arm = np.zeros(6), np.empty(3)
    for i in range(attachments.shape[0]):
        arm_of(rotation, attachments, i, arm)
        add_wrench(tensions[i], u[i], arm, out)
    arm_of(rotation, centre.reshape(1, 3), 0, arm)
    add_wrench(1.0, weight, arm, out)
    return out


@njit(cache=True, error_model="numpy")
def add_wrench(size: float, force: Array, arm: Array, out: Array) -> None:
    """Add the wrench (moment; force) of ``size force`` at an arm to ``out`` (6,)."""
    x, y, z = size * force[0], size * force[1], size * force[2]
    out[0] += arm[1] * z - arm[2] * y
    out[1] += arm[2] * x - arm[0] * z
    out[2] += arm[0] * y - arm[1] * x
    out[3] += x
    out[4] += y
    out[5] += z


@njit(cache=True, error_model="numpy")
def stiffness(
    attachments: Array, weight: Array, centre: Array, rotation: Array, u: Array, lengths: Array, tensions: Array,
    rates: Array,
) -> Array:  # fmt: skip
    """Stiffness (6, 6) with locked winches, as `stiffness.spatial_stiffness` defines it: slack cables add nothing.

    Args:
        attachments: (m, 3) [m].
        weight: Gravity force (3,) [N].
        centre: Centre of mass (3,) [m].
        rotation: Platform orientation (3, 3).
        u: Cable directions (m, 3), see :func:`directions`.
        lengths: (m,) [m].
        tensions: (m,) [N].
        rates: k_i = EA / L_i (m,) [N/m].
    """
    pulls = np.maximum(tensions, 0.0)
    return _stiffness(attachments, weight, centre, rotation, u, lengths, pulls, np.where(tensions > 0.0, rates, 0.0))


@njit(cache=True, error_model="numpy")
def tension_stiffness(
    attachments: Array, weight: Array, centre: Array, rotation: Array, u: Array, lengths: Array, tensions: Array
) -> Array:
    """Minus the symmetric part of the derivative (6, 6) of `residual` in a twist, at constant tensions of any sign.

    Args:
        attachments: (m, 3) [m].
        weight: Gravity force (3,) [N].
        centre: Centre of mass (3,) [m].
        rotation: Platform orientation (3, 3).
        u: Cable directions (m, 3), see :func:`directions`.
        lengths: (m,) [m].
        tensions: (m,) [N]; as measured, so that noise about 0 may make them negative.
    """
    return _stiffness(attachments, weight, centre, rotation, u, lengths, tensions, np.zeros(tensions.size))


@njit(cache=True, error_model="numpy")
def _stiffness(
    attachments: Array, weight: Array, centre: Array, rotation: Array, u: Array, lengths: Array, tensions: Array,
    rates: Array,
) -> Array:  # fmt: skip
    """Sum of what the cables and the weight add to the stiffness."""
    out, arm, bend = np.zeros((6, 6)), np.empty(3), np.empty((3, 3))
    for i in range(attachments.shape[0]):
        arm_of(rotation, attachments, i, arm)
        bent = 1.0 / lengths[i]
        add_cable(arm, u[i], u[i], bent, bent, tensions[i], rates[i], bend, out)
    arm_of(rotation, centre.reshape(1, 3), 0, arm)
    add_turn(1.0, weight, arm, out)
    return out


@njit(cache=True, error_model="numpy")
def least_pivot(matrix: Array) -> float:
    """Least pivot of L D L^T of a symmetric matrix (n, n): above 0 exactly where it is positive definite."""
    n = matrix.shape[0]
    work = matrix.copy()
    least = np.inf
    for k in range(n):
        least = min(least, work[k, k])
        if not work[k, k] > 0.0:
            return work[k, k]
        for i in range(k + 1, n):
            factor = work[i, k] / work[k, k]
            for j in range(k + 1, n):
                work[i, j] -= factor * work[k, j]
    return least


@njit(cache=True, error_model="numpy")
def determinant(a: Array, b: Array, c: Array) -> float:
    """Of the matrix with these three rows."""
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])


@njit(cache=True, error_model="numpy")
def balanced_rotation(forces: Array, attachments: Array, weight: Array, centre: Array, guess: Array) -> Array:
    """The rotation of least potential under given cable forces: Wahba's problem, by Newton's method on the rotations.

    With ``M = sum_i f_i b_i^T + w c^T`` and ``S = M R^T`` the moment left over is the axial vector of ``S - S^T`` and
    the Hessian is ``tr(S) I - (S + S^T) / 2``. The potential has one minimum over the rotations, one maximum and two
    saddles for a general M, so a minimum found is the minimum; where the Hessian is not positive the step follows the
    moment.

    Args:
        forces: Cable forces on the platform (m, 3) [N], world frame.
        attachments: Attachments (m, 3) [m], platform frame.
        weight: Gravity force (3,) [N].
        centre: Centre of mass (3,) [m], platform frame.
        guess: Rotation to start from (3, 3).

    Returns:
        Rotation (3, 3) platform to world.
    """
    moment, turn = np.zeros((3, 3)), np.zeros((3, 3))
    size = 0.0
    for k in range(3):
        for j in range(3):
            moment[k, j] = weight[k] * centre[j]
            for i in range(forces.shape[0]):
                moment[k, j] += forces[i, k] * attachments[i, j]
            size += moment[k, j] ** 2
    size = np.sqrt(size)
    rotation = guess.copy()
    step = np.zeros(3)
    for _ in range(60):
        for k in range(3):
            for j in range(3):
                turn[k, j] = 0.0
                for i in range(3):
                    turn[k, j] += moment[k, i] * rotation[j, i]
        trace = turn[0, 0] + turn[1, 1] + turn[2, 2]
        left = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        hessian = np.empty((3, 3))
        for k in range(3):
            for j in range(3):
                hessian[k, j] = -0.5 * (turn[k, j] + turn[j, k])
            hessian[k, k] += trace
        whole = determinant(hessian[0], hessian[1], hessian[2])
        minor = hessian[0, 0] * hessian[1, 1] - hessian[0, 1] * hessian[1, 0]
        if hessian[0, 0] > 0.0 and minor > 0.0 and whole > 1e-9 * size**3:
            step[0] = determinant(left, hessian[1], hessian[2]) / whole
            step[1] = determinant(hessian[0], left, hessian[2]) / whole
            step[2] = determinant(hessian[0], hessian[1], left) / whole
        else:
            for k in range(3):
                step[k] = left[k] / size
        angle = np.sqrt(step[0] ** 2 + step[1] ** 2 + step[2] ** 2)
        if angle > 1.0:
            step /= angle
        rotation = turned(step, rotation)
        if angle < 1e-13:
            break
    return rotation
