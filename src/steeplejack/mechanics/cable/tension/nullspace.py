"""Rank, least-norm solution and null space of structure matrices with at least as many cables as rows.

One factorisation answers all three: the rows of the structure matrix, each divided by its length, are turned into a
triangle by Householder reflections, the longest remaining row first (Golub and Van Loan, Matrix Computations, 5.4.2):

    P D^-1 structure = L Q^T

with ``D`` the row lengths, ``P`` a permutation, ``L`` lower triangular and ``Q`` orthogonal. The last columns of ``Q``
are the null space, ``f = -Q L^-1 P D^-1 wrench`` the least-norm tensions, and ``z = D^-1 P^T L^-T Q^T v`` carries a
vector ``v`` of the row space back to the platform, ``structure^T z = v``.

What counts as singular is told by `degeneracy`; the volume of the rows, from the diagonal of ``L``, settles most poses.

The kernels write to arrays of the caller and trust finite input; `null_space` is for NumPy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import structures_of
from steeplejack.mechanics.cable.degeneracy import decide, row_scales, surely_regular
from steeplejack.mechanics.cable.status import RankStatus

Array = NDArray[np.float64]

DOUBTFUL = 1e-4  # [1] length of a row's rest below which rests are measured anew, as differences of squares lose digits


@dataclass(frozen=True)
class NullSpace:
    """Tensions that exert no wrench; leading axes are those of the question.

    Attributes:
        basis: Orthonormal columns ``N`` with ``structure @ N = 0``, (..., m, m - n) [1]; not a number where the rank
            is below n (the null space is then wider) or undefined. Neighbouring poses may get bases turned against
            each other: only the space is continuous.
        rank: Independent rows (`degeneracy.rank`), (...); -1 where undefined.
        status: `RankStatus` by number, (...).
    """

    basis: Array
    rank: NDArray[np.int64]
    status: NDArray[np.int64]


def null_space(structure: ArrayLike) -> NullSpace:
    """Orthonormal null space of structure matrices.

    Args:
        structure: (..., n, m) with n <= m.

    Returns:
        Basis, rank and status over the leading axes.

    Raises:
        InputError: Not a matrix, or more rows than cables.
    """
    flat, shape = structures_of(structure)
    n, m = flat.shape[1:]
    if n > m:
        raise InputError(
            "structure", f"shape {np.shape(structure)}", "(..., n, m) with at least as many cables as rows"
        )
    basis, rank = np.full((len(flat), m, m - n), np.nan), np.full(len(flat), -1)
    null_space_each(flat, basis, rank)
    status = np.where(rank < 0, RankStatus.UNDEFINED, np.where(rank < n, RankStatus.SINGULAR, RankStatus.FULL))
    return NullSpace(basis.reshape(*shape, m, m - n), rank.reshape(shape), status.reshape(shape))


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def null_space_each(structures: Array, basis: Array, rank: NDArray[np.int64]) -> None:
    """Null space of every matrix of a batch; the kernel of `null_space`.

    Args:
        structures: (k, n, m).
        basis: Written where the rank is n, (k, m, m - n).
        rank: Written where it is defined, (k,).
    """
    n, m = structures.shape[1], structures.shape[2]
    left, tau, scale, order = np.empty((n, m)), np.empty(n), np.empty(n), np.empty(n, np.int64)
    kinds, rows, motions, sizes = np.empty(n), np.empty((n, m)), np.empty((n, n)), np.empty(n)
    for k in range(structures.shape[0]):
        squares = row_scales(structures[k], kinds)
        if not squares > 0.0:
            continue
        volume, rank[k] = decompose(structures[k], left, tau, scale, order), n
        for r in range(n):
            volume *= kinds[r]
        if not surely_regular(volume, squares, n):
            rank[k] = decide(structures[k], kinds, rows, motions, sizes)
        if rank[k] == n:
            null_columns(left, tau, basis[k])


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def decompose(structure: Array, left: Array, tau: Array, scale: Array, order: NDArray[np.int64]) -> float:
    """Factorise one matrix, ``P D^-1 structure = L Q^T``.

    Args:
        structure: (n, m), finite, n <= m.
        left: Written, (n, m): ``L`` on and below the diagonal, the reflections' vectors above it, each with a one on
            the diagonal left out.
        tau: Written, factor of each reflection ``I - tau v v^T``, (n,).
        scale: Written, lengths of the rows, (n,); one for a row of zeros.
        order: Written, which row each row of ``left`` was, (n,).

    Returns:
        Volume of the rows, ``sqrt(det(structure structure^T))``; 0 where a row is exactly dependent on others, and then
        nothing written is to be used.
    """
    n, m = structure.shape
    volume = 1.0
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
        if not size > 0.0:
            return 0.0
        if best != k:
            order[k], order[best] = order[best], order[k]
            tau[k], tau[best] = tau[best], tau[k]
            for j in range(m):
                left[k, j], left[best, j] = left[best, j], left[k, j]
        volume *= size * scale[order[k]]
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
    return float(volume)


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
