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

Degeneracy. Neither units nor scale enter. A pose is *singular* where the rows of its structure matrix are dependent to
``TOLERANCE`` (three by four: ``|n| <= TOLERANCE * |row 1| |row 2| |row 3|``, both sides being the same volume for
perpendicular rows; else as `hyperplanes` says), and a tension factor of at most ``TOLERANCE`` is 0. Neither is in
wrench closure: an arbitrarily small wrench, or an arbitrarily large tension, decides there. A column of zeros belongs
to a cable without length or to an attachment that is nowhere; no pose with one is held. A matrix is taken at its word:
moments that are rounding only look like those of a small robot, so maps from poses (`spatial_closure_map`) compare
them with the arms.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.structure import spatial_lengths, spatial_structure_matrix
from steeplejack.mechanics.cable.wrench import hyperplanes, lanes, sectors
from steeplejack.mechanics.cable.wrench.hyperplanes import TOLERANCE

Array = NDArray[np.float64]

MOST_CABLES = 32
"""Cables for which the hyperplanes are still counted in hundred thousands."""


class ClosureStatus(IntEnum):
    """How a closure question ended; `advice` says what to do."""

    INSIDE = hyperplanes.INSIDE
    OUTSIDE = hyperplanes.OUTSIDE
    SINGULAR = hyperplanes.SINGULAR
    UNDEFINED = hyperplanes.UNDEFINED

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _ADVICE[self]


_ADVICE = {
    ClosureStatus.INSIDE: "the cables, tight enough, resist every wrench",
    ClosureStatus.OUTSIDE: "no cable pulls against the certificate's wrench; move the pose or the anchors",
    ClosureStatus.SINGULAR: "the cables cannot resist the certificate's wrench at all; move off the singular pose",
    ClosureStatus.UNDEFINED: "an entry is not finite or a cable has no length; check pose and anchors",
}


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
    matrices, shape = stacked(structure)
    count, n, m = matrices.shape
    room = math.comb(m, n - 1)
    factor, certificate = np.zeros(count), np.full((count, n), np.nan)
    status = np.full(count, int(ClosureStatus.INSIDE))
    sectors.structure_factors(matrices, room, factor)
    out = np.flatnonzero(factor == 0.0)
    proof, kind = np.empty((out.size, n)), np.empty(out.size, np.int64)
    hyperplanes.factors_each(matrices[out], room, np.empty(out.size), proof, kind)
    certificate[out] = proof / np.linalg.norm(proof, axis=-1, keepdims=True)
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
    matrix = np.asarray(structure, dtype=np.float64)
    if matrix.shape[-2:] == (3, 4):
        return _cofactor_ratio(matrix)
    matrices, shape = stacked(matrix)
    factors = np.empty(len(matrices))
    sectors.structure_factors(matrices, math.comb(matrices.shape[2], matrices.shape[1] - 1), factors)
    return factors.reshape(shape)


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


def spatial_closure_map(
    anchors: ArrayLike, attachments: ArrayLike, positions: ArrayLike, rotations: ArrayLike
) -> Array:
    """Tension factor of a spatial robot at many poses, 0 outside wrench closure; with eight cables one compiled pass.

    Args:
        anchors: (m, 3) [m].
        attachments: (m, 3) in the platform frame [m].
        positions: (..., 3) [m].
        rotations: From platform to world, (..., 3, 3); leading axes broadcast with those of the positions.

    Returns:
        TF, (...) [1]; 0 where a cable has no length or a pose is not finite.

    Raises:
        InputError: Anchors and attachments that do not match, or more cables than `MOST_CABLES`.
    """
    fixed, local = _own(anchors), _own(attachments)
    if fixed.ndim != 2 or fixed.shape != local.shape or fixed.shape[1] != 3 or len(fixed) > MOST_CABLES:
        raise InputError(
            "anchors and attachments", f"shapes {fixed.shape} and {local.shape}", f"(m, 3) both, m <= {MOST_CABLES}"
        )
    where, turn = np.asarray(positions, dtype=np.float64), np.asarray(rotations, dtype=np.float64)
    shape = np.broadcast_shapes(where.shape[:-1], turn.shape[:-2])
    poses = _own(np.broadcast_to(where, (*shape, 3))).reshape(-1, 3)
    turns = _own(np.broadcast_to(turn, (*shape, 3, 3))).reshape(-1, 3, 3)
    return _spatial_factors(fixed, local, poses, turns).reshape(shape)


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


def is_singular(structure: ArrayLike) -> NDArray[np.bool_]:
    """Whether the three rows of a 3x4 matrix are dependent: some wrench is resisted by no tensions of either sign.

    Args:
        structure: (..., 3, 4).

    Returns:
        True where singular, (...); also where an entry is not a number.
    """
    matrix = np.asarray(structure, dtype=np.float64)
    rows = np.linalg.norm(matrix, axis=-1).prod(axis=-1)
    return ~(np.linalg.norm(null_vector(matrix), axis=-1) > TOLERANCE * rows)


def stacked(structure: ArrayLike) -> tuple[Array, tuple[int, ...]]:
    """Structure matrices with their leading axes flattened to one, (k, n, m), and those axes.

    Raises:
        InputError: A shape that is no structure matrix.
    """
    matrix = np.asarray(structure, dtype=np.float64)
    if matrix.ndim < 2 or not 2 <= matrix.shape[-2] <= 6 or not 1 <= matrix.shape[-1] <= MOST_CABLES:
        raise InputError(
            "structure", f"shape {matrix.shape}", f"(..., n, m) with n from 2 to 6 and m from 1 to {MOST_CABLES}"
        )
    return _own(matrix).reshape(-1, *matrix.shape[-2:]), matrix.shape[:-2]


def _cofactor_ratio(matrix: Array) -> Array:
    """Tension factor of 3x4 matrices."""
    null = null_vector(matrix)
    least, most = null.min(axis=-1), null.max(axis=-1)
    small, large = np.maximum(least, -most), np.maximum(most, -least)
    held = (small > TOLERANCE * large) & ~is_singular(matrix)
    return np.divide(small, large, out=np.zeros_like(small), where=held)


def _spatial_factors(anchors: Array, attachments: Array, positions: Array, rotations: Array) -> Array:
    """Tension factors of flat batches of poses: eight cables abreast, and one by one what that leaves unsettled."""
    factors = np.full(len(positions), lanes.UNSETTLED)
    arm = np.linalg.norm(attachments, axis=-1).max(initial=0.0)
    if not (arm > 0.0 and np.isfinite(anchors).all() and np.isfinite(attachments).all()):
        return np.zeros(len(positions))
    if len(anchors) == 8:
        lanes.eight_cable_factors(anchors, attachments, positions, rotations, factors)
    left = np.flatnonzero(factors == lanes.UNSETTLED)
    left = left[np.isfinite(positions[left]).all(axis=-1) & np.isfinite(rotations[left]).all(axis=(-2, -1))]
    factors[factors == lanes.UNSETTLED] = 0.0
    if left.size:
        where, turn = positions[left], rotations[left]
        structures = spatial_structure_matrix(anchors, attachments, where, turn)
        size = np.abs(anchors).max() + arm + np.abs(where).max(axis=-1)
        long = spatial_lengths(anchors, attachments, where, turn).min(axis=-1) > lanes.LENGTHLESS * size
        resists = np.abs(structures[:, :3]).max(axis=(-2, -1)) > TOLERANCE * arm
        factors[left] = np.where(long & resists, tension_factor(structures), 0.0)
    return factors


def _own(values: ArrayLike) -> Array:
    """A contiguous copy: views and read-only arrays would each compile the kernels anew."""
    return np.array(values, dtype=np.float64, order="C")
