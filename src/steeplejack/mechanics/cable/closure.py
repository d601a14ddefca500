"""Wrench closure and the tension factor of three-row structure matrices with four cables (one cable too many).

The null vector comes in closed form from cofactors, so a whole grid is one call. Source: Zheng et al., CCRobot-S, IEEE
T-RO, Eq. 10-12 and Appendices A-B. Two slips of the print are put right: row 2 of Eq. 37 has the opposite overall sign
and row 3 starts with ``j21 j32 j14``; and Eq. 12 takes the ratio without the sign, which gives 1/TF where every
cofactor is negative.

Degeneracy. Neither units nor scale enter: a pose is *singular* where the rows of its structure matrix are dependent,
``|n| <= tolerance * |row 1| |row 2| |row 3|`` (both sides are the same volume for perpendicular rows), and a component
of ``n`` is *zero* below ``tolerance`` times the largest. Neither is in wrench closure: an arbitrarily small wrench, or
an arbitrarily large tension, decides there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

TOLERANCE = 1e-9
"""Relative size below which a volume or a null vector component counts as zero [1]."""


def null_vector(structure: ArrayLike) -> Array:
    """Null vector of a 3x4 matrix by cofactors, ``n_i = (-1)^(i+1) det(J^T without column i)`` (Eq. 10).

    Args:
        structure: (..., 3, 4).

    Returns:
        ``n`` with ``structure @ n = 0``, not normalised, (..., 4); its length is the volume the three rows span.
    """
    (x1, x2, x3, x4), (y1, y2, y3, y4), (z1, z2, z3, z4) = np.moveaxis(
        np.asarray(structure, dtype=np.float64), (-2, -1), (0, 1)
    )
    d12, d13, d14 = x1 * y2 - x2 * y1, x1 * y3 - x3 * y1, x1 * y4 - x4 * y1
    d23, d24, d34 = x2 * y3 - x3 * y2, x2 * y4 - x4 * y2, x3 * y4 - x4 * y3
    return np.stack(
        (
            z2 * d34 - z3 * d24 + z4 * d23,
            -z1 * d34 + z3 * d14 - z4 * d13,
            z1 * d24 - z2 * d14 + z4 * d12,
            -z1 * d23 + z2 * d13 - z3 * d12,
        ),
        axis=-1,
    )


def is_singular(structure: ArrayLike, tolerance: float = TOLERANCE) -> NDArray[np.bool_]:
    """Whether the three rows are dependent: some wrench can be resisted by no tensions of either sign.

    Args:
        structure: (..., 3, 4).
        tolerance: Relative volume at which rows count as dependent [1].

    Returns:
        True where singular, (...); also where an entry is not a number.
    """
    matrix = np.asarray(structure, dtype=np.float64)
    rows = np.linalg.norm(matrix, axis=-1).prod(axis=-1)
    return ~(np.linalg.norm(null_vector(matrix), axis=-1) > tolerance * rows)


def tension_factor(structure: ArrayLike, tolerance: float = TOLERANCE) -> Array:
    """Tension factor ``TF = min|n| / max|n|`` in wrench closure, 0 outside (Eq. 11-12 with the sign kept).

    TF is the ratio of the actual tensions only where no external wrench acts; alone it is no go or no-go test.

    Args:
        structure: (..., 3, 4).
        tolerance: Scale-free threshold of singularity and of closure [1].

    Returns:
        TF in [0, 1], (...) [1].
    """
    matrix = np.asarray(structure, dtype=np.float64)
    null = null_vector(matrix)
    least, most = null.min(axis=-1), null.max(axis=-1)
    small, large = np.maximum(least, -most), np.maximum(most, -least)
    held = (small > tolerance * large) & ~is_singular(matrix, tolerance)
    return np.divide(small, large, out=np.zeros_like(small), where=held)


def in_wrench_closure(structure: ArrayLike, tolerance: float = TOLERANCE) -> NDArray[np.bool_]:
    """Whether all cables can pull at once without an external wrench: all ``n_i`` of one strict sign (Eq. 11).

    Args:
        structure: (..., 3, 4).
        tolerance: Scale-free threshold of singularity and of closure [1].

    Returns:
        True inside, (...).
    """
    return tension_factor(structure, tolerance) > 0.0
