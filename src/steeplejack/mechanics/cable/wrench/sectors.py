"""Compiled tension factors for one or two cables too many, by elimination.

Elimination turns ``structure @ f = 0`` into ``f = N lambda`` with a row of ``N`` per cable; the cables left over have
the rows of the identity.

- *One too many.* ``N`` is the null vector; ``TF = min / max`` where all its components have one sign.
- *Two too many.* Closure is a half plane: some ``lambda`` has a positive product with every row, so the rows lie in an
  open half plane. The identity rows make that an interval of ``lambda_2 / lambda_1``, and an empty one ends the matter.
  Inside, each three cables i, j, k give ``v = (N_j x N_k, N_k x N_i, N_i x N_j)``, the work ``structure^T z`` of the
  normal ``z`` of the hyperplane of the other columns, and ``TF`` is the least ratio of its two signed sums
  (`hyperplanes` says why).

Whatever is too close to call here (a pivot below ``PIVOT``, a factor below ``NARROW``) and any other number of cables
is left to the walk over all hyperplanes, which needs no elimination; whether a pose is singular, to `degeneracy`.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.degeneracy import decide, equalise, row_scales, surely_regular
from steeplejack.mechanics.cable.wrench.hyperplanes import factor_of, hyperplanes

Array = NDArray[np.float64]

PIVOT = 1e-5  # [1] pivot of the scaled matrix below which elimination is not trusted
NARROW = 1e-6  # [1] tension factor below which the answer is settled by all hyperplanes
PARALLEL = 1e-8  # [1] sum of cross products of three rows below which they count as parallel


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def structure_factors(structures: Array, room: int, factors: Array) -> None:
    """Tension factor of every structure matrix of a batch, 0 outside wrench closure.

    Args:
        structures: (k, n, m).
        room: Number of subsets of ``n - 1`` of the ``m`` columns.
        factors: Written, (k,) [1].
    """
    n, m = structures.shape[1], structures.shape[2]
    columns, scale, work, rows = np.empty((m, n)), np.empty(n), np.empty((n, m)), np.empty((2, m))
    basis, chosen, normals, z = np.empty((n, n, n)), np.empty(n, np.int64), np.empty((room, n)), np.empty(n)
    for k in range(structures.shape[0]):
        factors[k] = 0.0
        squares = row_scales(structures[k], scale)
        if not squares > 0.0 or m <= n:
            continue
        factor = -1.0
        if m <= n + 2:
            for r in range(n):
                for i in range(m):
                    work[r, i] = structures[k, r, i] * scale[r]
            if surely_regular(_reduce(work), squares, n):
                factor = _one_too_many(work) if m == n + 1 else _two_too_many(work, rows)
        if factor < 0.0:
            factor = 0.0
            if decide(structures[k], scale, work, basis[0], z) == n:
                equalise(structures[k], columns, scale)
                count = hyperplanes(columns, basis, chosen, normals)
                factor = factor_of(columns, normals, count, z)
        factors[k] = factor


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _reduce(work: Array) -> float:
    """Gauss-Jordan on the largest entry of each row in turn, columns exchanged.

    Returns:
        Size of the pivots' product; 0 where one is too small to go on.
    """
    n, m = work.shape
    volume = 1.0
    for q in range(n):
        best, most = q, abs(work[q, q])
        for c in range(q + 1, m):
            if abs(work[q, c]) > most:
                best, most = c, abs(work[q, c])
        if not most > PIVOT:
            return 0.0
        volume *= most
        if best != q:
            for r in range(n):
                work[r, q], work[r, best] = work[r, best], work[r, q]
        inverse = 1.0 / work[q, q]
        for c in range(q + 1, m):
            work[q, c] *= inverse
        for r in range(n):
            if r != q:
                times = work[r, q]
                for c in range(q + 1, m):
                    work[r, c] -= times * work[q, c]
    return volume


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _one_too_many(work: Array) -> float:
    """Tension factor from the last column, the negative null vector but for its last component, 1; -1 if too close."""
    n = work.shape[0]
    least, most = 1.0, 1.0
    for q in range(n):
        least, most = min(least, -work[q, n]), max(most, -work[q, n])
    factor = least / most
    return max(factor, 0.0) if abs(factor) > NARROW else -1.0


@njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _two_too_many(work: Array, rows: Array) -> float:
    """Tension factor from the last two columns, the negative rows of ``N`` but for the identity; -1 if too close."""
    n = work.shape[0]
    low, high = 0.0, np.inf
    for q in range(n):
        x, y = -work[q, n], -work[q, n + 1]
        rows[0, q], rows[1, q] = x, y
        if y > 0.0:
            low = max(low, -x / y)
        elif y < 0.0:
            high = min(high, -x / y)
        elif x <= 0.0:
            return 0.0
    if not low < high:
        return 0.0
    rows[0, n], rows[1, n], rows[0, n + 1], rows[1, n + 1] = 1.0, 0.0, 0.0, 1.0
    factor = 1.0
    for i in range(n + 2):
        xi, yi = rows[0, i], rows[1, i]
        for j in range(i + 1, n + 2):
            xj, yj = rows[0, j], rows[1, j]
            ij = xi * yj - xj * yi
            for k in range(j + 1, n + 2):
                jk, ki = xj * rows[1, k] - rows[0, k] * yj, rows[0, k] * yi - xi * rows[1, k]
                net, size = abs(ij + jk + ki), abs(ij) + abs(jk) + abs(ki)
                if size > PARALLEL:
                    factor = min(factor, (size - net) / (size + net))
    return factor if factor > NARROW else -1.0
