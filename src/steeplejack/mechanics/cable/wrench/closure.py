"""Wrench closure and the tension factor of structure matrices with any number of cables.

A platform is in wrench closure where its cables, tight enough, resist every wrench: the structure matrix has full rank
and some tensions, all positive, balance each other. The *tension factor* says how evenly they can,
``TF = max min(f) / max(f)`` over positive ``f`` with ``structure @ f = 0``, and 0 outside. With one cable too many it
is the ratio of Eq. 12 of Zheng et al., CCRobot-S, IEEE T-RO.

- Three rows and four cables: the null vector in closed form from cofactors (Eq. 10-12, Appendices A-B), so a whole
  grid is one call. Two slips of the print are put right: row 2 of Eq. 37 has the opposite overall sign and row 3
  starts with ``j21 j32 j14``; and Eq. 12 takes the ratio without the sign, which gives 1/TF where every cofactor is
  negative.
- One or two cables too many: elimination, then the null vector or its sectors (`sectors`).
- Any other number: all hyperplanes spanned by columns (`hyperplanes`), which also gives the certificates.

Degeneracy. Which poses are singular or undefined is told by `degeneracy`, and a tension factor of at most its
``TOLERANCE`` is 0. None of them is in wrench closure: an arbitrarily small wrench, or an arbitrarily large tension,
decides there. A matrix is taken at its word: moments that are rounding only look like those of a small robot, which is
why `structure` writes them as zeros.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.mechanics.cable.arguments import MOST_CABLES, structures_of, vectors
from steeplejack.mechanics.cable.degeneracy import TOLERANCE, is_singular
from steeplejack.mechanics.cable.status import ClosureStatus
from steeplejack.mechanics.cable.wrench import hyperplanes, sectors

__all__ = [
    "MOST_CABLES",
    "Closure",
    "ClosureStatus",
    "in_wrench_closure",
    "is_singular",
    "null_vector",
    "tension_factor",
    "wrench_closure",
]

Array = NDArray[np.float64]

FEWEST_ROWS, MOST_ROWS = 2, 6
LEAST = 1e-80  # squared entry below which products of three rows may vanish


@dataclass(frozen=True)
class Closure:
    """Wrench closure and what is known about it; leading axes are those of the question.

    Attributes:
        inside: Whether the pose is in wrench closure, (...).
        factor: Tension factor, (...) [1]; 0 outside.
        certificate: ``z`` of unit length with ``z . column_i >= 0`` for every cable, all of them 0 where singular,
            (..., n); no tensions resist a wrench ``z``. Not a number inside or undefined.
        status: `ClosureStatus` by number, (...).
    """

    inside: NDArray[np.bool_]
    factor: Array
    certificate: Array
    status: NDArray[np.int64]


def wrench_closure(structure: ArrayLike) -> Closure:
    """Decide wrench closure, with the tension factor inside and a certificate outside.

    Args:
        structure: (..., n, m) with n from 2 to 6 and any m; (fx, fy, mz) or (moment; force) rows.

    Returns:
        Closure over the leading axes.

    Raises:
        InputError: A shape that is no structure matrix.
    """
    matrices, shape = structures_of(structure, FEWEST_ROWS, MOST_ROWS)
    count, n, m = matrices.shape
    room = math.comb(m, n - 1)
    factor, certificate = np.zeros(count), np.full((count, n), np.nan)
    status = np.full(count, int(ClosureStatus.INSIDE))
    sectors.structure_factors(matrices, room, factor)
    out = np.flatnonzero(factor == 0.0)
    proof, kind = np.empty((out.size, n)), np.empty(out.size, np.int64)
    hyperplanes.factors_each(matrices[out], room, np.empty(out.size), proof, kind)
    certificate[out] = proof
    status[out] = np.where(kind == ClosureStatus.INSIDE, ClosureStatus.OUTSIDE, kind)
    return Closure(
        inside=(factor > 0.0).reshape(shape),
        factor=factor.reshape(shape),
        certificate=certificate.reshape(*shape, n),
        status=status.reshape(shape),
    )


def tension_factor(structure: ArrayLike) -> Array:
    """Tension factor ``TF = max min(f) / max(f)`` over ``structure @ f = 0`` in wrench closure, 0 outside.

    With one cable too many it is ``min|n| / max|n|`` of the null vector (Eq. 11-12 with the sign kept). TF is the ratio
    of the actual tensions only where no external wrench acts; alone it is no go or no-go test.

    Args:
        structure: (..., n, m) with n from 2 to 6 and any m.

    Returns:
        TF in [0, 1], (...) [1].

    Raises:
        InputError: A shape that is no structure matrix.
    """
    matrices, shape = structures_of(structure, FEWEST_ROWS, MOST_ROWS)
    if matrices.shape[1:] == (3, 4):
        factors, left = _cofactor_ratios(matrices)
        if left.any():
            factors[left] = _factors(matrices[left])
        return factors.reshape(shape)
    return _factors(matrices).reshape(shape)


def in_wrench_closure(structure: ArrayLike) -> NDArray[np.bool_]:
    """Whether all cables can pull at once without an external wrench, in a pose that is not singular (Eq. 11).

    Args:
        structure: (..., n, m) with n from 2 to 6 and any m.

    Returns:
        True inside, (...).

    Raises:
        InputError: A shape that is no structure matrix.
    """
    return tension_factor(structure) > 0.0


@np.errstate(invalid="ignore", over="ignore")
def null_vector(structure: ArrayLike) -> Array:
    """Null vector of a 3x4 matrix by cofactors, ``n_i = (-1)^(i+1) det(J^T without column i)`` (Eq. 10).

    Args:
        structure: (..., 3, 4).

    Returns:
        ``n`` with ``structure @ n = 0``, not normalised, (..., 4); its length is the volume the three rows span.

    Raises:
        InputError: Not three rows of four numbers.
    """
    matrix = vectors("structure", structure, 3, 4)
    (x1, x2, x3, x4), (y1, y2, y3, y4), (z1, z2, z3, z4) = np.moveaxis(matrix, (-2, -1), (0, 1))
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


def _factors(matrices: Array) -> Array:
    """Tension factors of flat structure matrices, (k,)."""
    _, n, m = matrices.shape
    factors = np.empty(len(matrices))
    sectors.structure_factors(np.ascontiguousarray(matrices), math.comb(m, n - 1), factors)
    return factors


def _cofactor_ratios(matrices: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Tension factors of 3x4 matrices, (k,), and which of them are too close to call here.

    The rule is `degeneracy.surely_regular`: the length of the null vector is the volume of the rows.
    """
    with np.errstate(all="ignore"):
        null = null_vector(matrices)
        least, most = null.min(axis=-1), null.max(axis=-1)
        small, large = np.maximum(least, -most), np.maximum(most, -least)
        factors = np.where(small > 0.0, small / large, 0.0)
        squares = matrices**2
        forces, moments = squares[:, :2].sum(axis=1), squares[:, 2]
        longest, lever = forces.max(axis=-1), moments.max(axis=-1)
        total = forces.sum(axis=-1) / longest + moments.sum(axis=-1) / lever
        volume = (null**2).sum(axis=-1) / (longest**2 * lever)
        regular = volume * (2.0 / total) ** 2 > TOLERANCE**2 * total
        sure = regular & (np.abs(small) > sectors.NARROW * large) & (forces + moments).all(axis=-1)
    return factors, ~(sure & np.isfinite(volume) & (longest > LEAST) & (lever > LEAST))
