"""What four cables do to a hanging platform in the plane they roughly share: its own x and y, and the turn about its z.

Those three freedoms are what the winches steer. Where the structure matrix in the plane comes near to losing its rank,
lengths no longer tell where the platform is and tensions no longer push it back, stable though its equilibrium may be.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.measure.quality import evenness

Array = NDArray[np.float64]


@njit(cache=True)
def plane_matrix(u: Array, rotation: Array, attachments: Array) -> tuple[Array, float]:
    """Transposed structure matrix (4, 3) in the platform's x, y and about its z, and the arm that scales it [m].

    Args:
        u: Cable directions (4, 3).
        rotation: Platform orientation (3, 3).
        attachments: Attachments (4, 3) [m], platform frame.
    """
    scale = 0.0
    for i in range(4):
        scale += 0.25 * np.sqrt(attachments[i, 0] ** 2 + attachments[i, 1] ** 2 + attachments[i, 2] ** 2)
    matrix = np.empty((4, 3))
    for i in range(4):
        x = rotation[0, 0] * u[i, 0] + rotation[1, 0] * u[i, 1] + rotation[2, 0] * u[i, 2]
        y = rotation[0, 1] * u[i, 0] + rotation[1, 1] * u[i, 1] + rotation[2, 1] * u[i, 2]
        matrix[i, 0], matrix[i, 1] = x, y
        matrix[i, 2] = (attachments[i, 0] * y - attachments[i, 1] * x) / scale
    return matrix, scale


@njit(cache=True)
def dexterity(matrix: Array) -> float:
    """Least over largest singular value [1] of a (4, 3) from :func:`plane_matrix`; not a number where an entry is."""
    if not np.isfinite(matrix.sum()):
        return np.nan
    rows = np.empty((3, 4))
    for i in range(4):
        for k in range(3):
            rows[k, i] = matrix[i, k]
    return evenness(rows, np.ones(3))
