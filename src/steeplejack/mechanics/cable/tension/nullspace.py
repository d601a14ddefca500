"""Rank, least-norm solution and null space of structure matrices with at least as many cables as rows.

One factorisation answers all three: the rows of the structure matrix, each divided by its length, are turned into a
triangle by Householder reflections, the longest remaining row first (Golub and Van Loan, Matrix Computations, 5.4.2):

    P D^-1 structure = L Q^T

with ``D`` the row lengths, ``P`` a permutation, ``L`` lower triangular and ``Q`` orthogonal. The last columns of ``Q``
are the null space, ``f = -Q L^-1 P D^-1 wrench`` the least-norm tensions, and ``z = D^-1 P^T L^-T Q^T v`` carries a
vector ``v`` of the row space back to the platform, ``structure^T z = v``.

Degeneracy. A row counts as dependent on the others where less than `TOLERANCE` of its length is left when they are
taken away; rows may be in any units, and their scale does not matter. The columns are taken as they come: unit forces,
with moments about a point on the platform (about a point a billion platform sizes away every robot is singular). A
cable of zero length has a zero column; it moves no platform, so here it is one more null direction.

The kernels write to arrays of the caller and trust finite input; `null_space` is for NumPy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError

Array = NDArray[np.float64]

TOLERANCE = 1e-9
"""Share of a row's length below which it counts as dependent on the others [1]."""

DOUBTFUL = 1e-4  # [1] length of a row's rest below which rests are measured anew, as differences of squares lose digits

FULL, DEFICIENT, UNDEFINED = range(3)


class RankStatus(IntEnum):
    """What the rows of a structure matrix span; `advice` says what to do."""

    FULL = FULL
    DEFICIENT = DEFICIENT
    UNDEFINED = UNDEFINED

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _ADVICE[self]


_ADVICE = {
    RankStatus.FULL: "the cables resist every wrench if they may push and pull",
    RankStatus.DEFICIENT: "some wrench is resisted by no cable; move off the singular pose",
    RankStatus.UNDEFINED: "an entry is not finite; check the pose and the geometry",
}


@dataclass(frozen=True)
class NullSpace:
    """Tensions that exert no wrench; leading axes are those of the question.

    Attributes:
        basis: Orthonormal columns ``N`` with ``structure @ N = 0``, (..., m, m - n) [1]; not a number where the rank
            is below n (the null space is then wider) or undefined. Neighbouring poses may get bases turned against
            each other: only the space is continuous.
        rank: Independent rows, (...); -1 where undefined.
        status: `RankStatus` by number, (...).
    """

    basis: Array
    rank: NDArray[np.int64]
    status: NDArray[np.int64]


def null_space(structure: ArrayLike) -> NullSpace:
    """Orthonormal null space of structure matrices.

    Args:
        structure: (..., n, m) with n <= m; rows in any units.

    Returns:
        Basis, rank and status over the leading axes.

    Raises:
        InputError: Not a matrix, or more rows than cables.
    """
    matrix = np.asarray(structure, dtype=np.float64)
    if matrix.ndim < 2 or not 0 < matrix.shape[-2] <= matrix.shape[-1]:
        raise InputError(
            "structure matrix", f"shape {matrix.shape}", "(..., n, m) with at least as many cables as rows"
        )
    (n, m), shape = matrix.shape[-2:], matrix.shape[:-2]
    flat = np.array(matrix, order="C").reshape(-1, n, m)
    basis, rank = np.full((len(flat), m, m - n), np.nan), np.full(len(flat), -1)
    null_space_each(flat, basis, rank)
    status = np.where(rank < 0, RankStatus.UNDEFINED, np.where(rank < n, RankStatus.DEFICIENT, RankStatus.FULL))
    return NullSpace(basis.reshape(*shape, m, m - n), rank.reshape(shape), status.reshape(shape))


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def null_space_each(structures: Array, basis: Array, rank: NDArray[np.int64]) -> None:
    """Null space of every matrix of a batch; the kernel of `null_space`.

    Args:
        structures: (k, n, m).
        basis: Written where the rank is n, (k, m, m - n).
        rank: Written where the matrix is finite, (k,).
    """
    n, m = structures.shape[1], structures.shape[2]
    left, tau, scale, order = np.empty((n, m)), np.empty(n), np.empty(n), np.empty(n, np.int64)
    for k in range(structures.shape[0]):
        if math.isfinite(structures[k].sum()):
            rank[k] = decompose(structures[k], left, tau, scale, order)
            if rank[k] == n:
                null_columns(left, tau, basis[k])


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def decompose(structure: Array, left: Array, tau: Array, scale: Array, order: NDArray[np.int64]) -> int:
    """Factorise one matrix, ``P D^-1 structure = L Q^T``.

    Args:
        structure: (n, m), finite, n <= m.
        left: Written, (n, m): ``L`` on and below the diagonal, the reflections' vectors above it, each with a one on
            the diagonal left out.
        tau: Written, factor of each reflection ``I - tau v v^T``, (n,).
        scale: Written, lengths of the rows, (n,); one for a row of zeros.
        order: Written, which row each row of ``left`` was, (n,).

    Returns:
        The rank; what ``left`` and ``tau`` hold from there on is not to be used as a reflection.
    """
    n, m = structure.shape
    for i in range(n):
        size = 0.0
        for j in range(m):
            size += structure[i, j] * structure[i, j]
        scale[i] = math.sqrt(size) if size > 0.0 else 1.0
        order[i], tau[i] = i, 1.0  # tau keeps what is left of the squared lengths of the rows to come
        share = 1.0 / scale[i]
        for j in range(m):
            left[i, j] = share * structure[i, j]
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if tau[i] > tau[best]:
                best = i
        size = _remains(left[best], k)
        if size < DOUBTFUL:
            for i in range(k, n):
                tau[i] = _remains(left[i], k)
                if tau[i] > size:
                    best, size = i, tau[i]
                tau[i] = tau[i] * tau[i]
        if not size > TOLERANCE:
            return k
        if best != k:
            order[k], order[best] = order[best], order[k]
            tau[k], tau[best] = tau[best], tau[k]
            for j in range(m):
                left[k, j], left[best, j] = left[best, j], left[k, j]
        head = left[k, k]
        turned = -size if head > 0.0 else size
        tau[k] = (turned - head) / turned
        share = 1.0 / (head - turned)
        for j in range(k + 1, m):
            left[k, j] *= share
        left[k, k] = turned
        for i in range(k + 1, n):
            dot = left[i, k]
            for j in range(k + 1, m):
                dot += left[k, j] * left[i, j]
            dot *= tau[k]
            left[i, k] -= dot
            tau[i] -= left[i, k] * left[i, k]
            for j in range(k + 1, m):
                left[i, j] -= dot * left[k, j]
    return n


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def _remains(row: Array, first: int) -> float:
    """Length of a row from an entry on."""
    total = 0.0
    for j in range(first, row.size):
        total += row[j] * row[j]
    return math.sqrt(total)


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def null_columns(left: Array, tau: Array, basis: Array) -> None:
    """Write the null space of a factorised matrix of full rank.

    Args:
        left: From `decompose`, (n, m).
        tau: From `decompose`, (n,).
        basis: Written, orthonormal columns, (m, m - n).
    """
    n, m = left.shape
    for c in range(m - n):
        for j in range(m):
            basis[j, c] = 0.0
        basis[n + c, c] = 1.0
        for k in range(n - 1, -1, -1):
            dot = 0.0
            for j in range(k + 1, m):
                dot += left[k, j] * basis[j, c]
            dot *= tau[k]
            basis[k, c] -= dot
            for j in range(k + 1, m):
                basis[j, c] -= dot * left[k, j]


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def least_norm(left: Array, tau: Array, scale: Array, order: NDArray[np.int64], wrench: Array, tensions: Array) -> None:
    """Write the tensions of least norm with ``structure @ f + wrench = 0``; they are perpendicular to the null space.

    Args:
        left: From `decompose`, of full rank, (n, m).
        tau: From `decompose`, (n,).
        scale: From `decompose`, (n,).
        order: From `decompose`, (n,).
        wrench: (n,).
        tensions: Written, (m,).
    """
    n, m = left.shape
    for k in range(n):
        value = -wrench[order[k]] / scale[order[k]]
        for j in range(k):
            value -= left[k, j] * tensions[j]
        tensions[k] = value / left[k, k]
    for j in range(n, m):
        tensions[j] = 0.0
    for k in range(n - 1, -1, -1):
        dot = tensions[k]
        for j in range(k + 1, m):
            dot += left[k, j] * tensions[j]
        dot *= tau[k]
        tensions[k] -= dot
        for j in range(k + 1, m):
            tensions[j] -= dot * left[k, j]


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def carry_back(left: Array, tau: Array, scale: Array, order: NDArray[np.int64], v: Array, z: Array) -> None:
    """Write ``z`` with ``structure^T z = v`` for a ``v`` perpendicular to the null space.

    Args:
        left: From `decompose`, of full rank, (n, m).
        tau: From `decompose`, (n,).
        scale: From `decompose`, (n,).
        order: From `decompose`, (n,).
        v: (m,); overwritten.
        z: Written, (n,).
    """
    n, m = left.shape
    for k in range(n):
        dot = v[k]
        for j in range(k + 1, m):
            dot += left[k, j] * v[j]
        dot *= tau[k]
        v[k] -= dot
        for j in range(k + 1, m):
            v[j] -= dot * left[k, j]
    for k in range(n - 1, -1, -1):
        for i in range(k + 1, n):
            v[k] -= left[i, k] * v[i]
        v[k] /= left[k, k]
        z[order[k]] = v[k] / scale[order[k]]


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def unresisted(
    left: Array, scale: Array, order: NDArray[np.int64], rank: int, wrench: Array, v: Array, z: Array
) -> None:
    """Write a unit motion ``z`` of a matrix of lower rank that no cable resists, ``structure^T z = 0``.

    Of all such motions one along which the wrench does positive work, if there is one.

    Args:
        left: From `decompose`, (n, m).
        scale: From `decompose`, (n,).
        order: From `decompose`, (n,).
        rank: From `decompose`, below n.
        wrench: (n,).
        v: Overwritten, at least (n,).
        z: Written, (n,).
    """
    n = left.shape[0]
    load = 0.0
    for i in range(n):
        z[i] = 0.0
        load += (wrench[i] / scale[i]) ** 2
    threshold = TOLERANCE * math.sqrt(load)
    found = False
    for row in range(n - 1, rank - 1, -1):
        for i in range(n):
            v[i] = 0.0
        v[row] = 1.0
        for k in range(rank - 1, -1, -1):
            v[k] = -left[row, k]
            for i in range(k + 1, rank):
                v[k] -= left[i, k] * v[i]
            v[k] /= left[k, k]
        work = 0.0
        for i in range(n):
            work += v[i] * wrench[order[i]] / scale[order[i]]
        if abs(work) > threshold:
            found = True
        elif found or row > rank:
            continue
        else:
            work = 1.0
        for i in range(n):
            z[order[i]] += work * v[i] / scale[order[i]]
    size = 0.0
    for i in range(n):
        size += z[i] * z[i]
    for i in range(n):
        z[i] /= math.sqrt(size)
