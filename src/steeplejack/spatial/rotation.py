"""Rotations of space: matrices, rotation vectors and unit quaternions (w, x, y, z)."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError

Array = NDArray[np.float64]

ORTHONORMAL = 1e-9
"""How far from orthonormal a matrix may be and still count as a rotation [1]."""


def rotation_matrix(value: ArrayLike, where: str) -> Array:
    """Check that something is a rotation matrix, or an array of them.

    Args:
        value: (..., 3, 3).
        where: What to call it in a complaint.

    Returns:
        A contiguous copy, (..., 3, 3).

    Raises:
        InputError: Not of that shape, not finite, not orthonormal to `ORTHONORMAL`, or a mirror image.
    """
    try:
        given = np.asarray(value)
    except ValueError:
        raise InputError(where, "rows of unlike length", "a rotation matrix (3, 3)") from None
    if given.dtype.kind not in "fiub":
        raise InputError(where, f"entries of type {given.dtype}", "a rotation matrix (3, 3)")
    matrix = np.array(given, dtype=np.float64, order="C")
    if matrix.shape[-2:] != (3, 3):
        raise InputError(where, f"shape {matrix.shape}", "a rotation matrix (3, 3)")
    if not np.isfinite(matrix).all():
        raise InputError(where, "a number that is not finite", "a rotation matrix (3, 3)")
    if not np.all(np.abs(matrix) <= 1.0 + ORTHONORMAL):
        raise InputError(where, "not orthonormal", "a rotation matrix (3, 3)")
    if np.abs(matrix @ np.swapaxes(matrix, -1, -2) - np.eye(3)).max(initial=0.0) > ORTHONORMAL:
        raise InputError(where, "not orthonormal", "a rotation matrix (3, 3)")
    if not np.all(np.linalg.det(matrix) > 0.0):
        raise InputError(where, "a mirror image", "a rotation matrix (3, 3)")
    return matrix


@njit(cache=True)
def from_vector(vector: Array) -> Array:
    """Rotation matrix (3, 3) of a rotation vector (3,) [rad], by Rodrigues' formula."""
    x, y, z = vector
    square = x * x + y * y + z * z
    angle = np.sqrt(square)
    # Series below 1e-4 rad: the closed forms lose digits to cancellation, the next term is 1e-17.
    if angle < 1e-4:
        a, b = 1.0 - square / 6.0, 0.5 - square / 24.0
    else:
        a, b = np.sin(angle) / angle, (1.0 - np.cos(angle)) / square
    out = np.empty((3, 3))
    out[0, 0], out[0, 1], out[0, 2] = 1.0 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y
    out[1, 0], out[1, 1], out[1, 2] = b * x * y + a * z, 1.0 - b * (x * x + z * z), b * y * z - a * x
    out[2, 0], out[2, 1], out[2, 2] = b * x * z - a * y, b * y * z + a * x, 1.0 - b * (x * x + y * y)
    return out


@njit(cache=True)
def turned(vector: Array, rotation: Array) -> Array:
    """The rotation (3, 3) turned further by a rotation vector (3,) [rad] in the world's frame, kept orthogonal.

    One Newton step towards orthogonality keeps rounding from growing over millions of turns.
    """
    by = from_vector(vector)
    product, gram, out = np.zeros((3, 3)), np.zeros((3, 3)), np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                product[i, j] += by[i, k] * rotation[k, j]
    for i in range(3):
        for j in range(3):
            for k in range(3):
                gram[i, j] += product[k, i] * product[k, j]
    for i in range(3):
        for j in range(3):
            out[i, j] = 1.5 * product[i, j]
            for k in range(3):
                out[i, j] -= 0.5 * product[i, k] * gram[k, j]
    return out


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
