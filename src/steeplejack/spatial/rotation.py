"""Rotations of space: matrices, rotation vectors and unit quaternions (w, x, y, z)."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True)
def from_vector(vector: Array) -> Array:
    """Rotation matrix (3, 3) of a rotation vector (3,) [rad], by Rodrigues' formula."""
    angle = np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    # Series below 1e-4 rad: the closed forms lose digits to cancellation, the next term is 1e-17.
    if angle < 1e-4:
        a, b = 1.0 - angle**2 / 6.0, 0.5 - angle**2 / 24.0
    else:
        a, b = np.sin(angle) / angle, (1.0 - np.cos(angle)) / angle**2
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + a * cross + b * (cross @ cross)


@njit(cache=True)
def from_quaternion(quaternion: Array) -> Array:
    """Rotation matrix (3, 3) of a quaternion (4,) of any length but zero."""
    w, x, y, z = quaternion / np.sqrt(np.sum(quaternion * quaternion))
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


@njit(cache=True)
def to_quaternion(rotation: Array) -> Array:
    """Unit quaternion (4,) of a rotation matrix (3, 3); its largest component is positive (Shepperd's choice)."""
    trace = rotation[0, 0] + rotation[1, 1] + rotation[2, 2]
    squares = np.array([trace, rotation[0, 0], rotation[1, 1], rotation[2, 2]])
    largest = np.argmax(squares)
    q = np.empty(4)
    if largest == 0:
        q[0] = 1.0 + trace
        q[1] = rotation[2, 1] - rotation[1, 2]
        q[2] = rotation[0, 2] - rotation[2, 0]
        q[3] = rotation[1, 0] - rotation[0, 1]
    else:
        i = largest - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        q[0] = rotation[k, j] - rotation[j, k]
        q[1 + i] = 1.0 + 2.0 * rotation[i, i] - trace
        q[1 + j] = rotation[i, j] + rotation[j, i]
        q[1 + k] = rotation[i, k] + rotation[k, i]
    return q / np.sqrt(np.sum(q * q))


@njit(cache=True)
def to_vector(rotation: Array) -> Array:
    """Rotation vector (3,) [rad] of a rotation matrix (3, 3), of length at most pi."""
    q = to_quaternion(rotation)
    if q[0] < 0.0:
        q = -q
    sine = np.sqrt(q[1] ** 2 + q[2] ** 2 + q[3] ** 2)
    if sine < 1e-9:
        return 2.0 * q[1:]
    return q[1:] * (2.0 * np.arctan2(sine, q[0]) / sine)


def nearest_turn(quaternions: Array) -> Array:
    """The same rotations (n, 4) with signs chosen so that neighbours lie in one half space, fit for interpolation."""
    signs = np.where(np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0, -1.0, 1.0)
    return quaternions * np.concatenate([[1.0], np.cumprod(signs)])[:, None]
