"""Compiled hyperplane enumeration: every hyperplane spanned by columns of a structure matrix, and what it decides.

``n - 1`` independent columns of an ``n x m`` structure matrix span a hyperplane with a normal ``z``. Those normals
decide everything asked of a pose (`closure` and `zonotope` are the public faces), for any ``m``, without a linear
program:

- *Tension factor.* ``structure @ f = 0`` with ``t <= f <= 1`` has a solution exactly where 0 lies in the zonotope
  ``structure @ [t, 1]^m``, whose facets have these normals. With ``v = structure^T z``, ``P`` the sum of its positive
  parts and ``Q`` of its negative ones, the facets ``z`` and ``-z`` ask ``t P <= Q`` and ``t Q <= P``. Hence
  ``TF = min over z of min(P, Q) / max(P, Q)``.
- *Closure.* ``TF > 0``; a normal with all columns on one closed side makes it 0, and proves that (Stiemke).
- *Wrench set.* ``h(z) = sum_i max(lower_i v_i, upper_i v_i)`` is how far ``structure @ [lower, upper]`` reaches along
  ``z`` (Bouchard, Gosselin, Moore, J. Mechanisms Robotics 2(1), 2010; Gouttefarde, Krut, ARK 2010).

The walk goes depth first over column subsets and keeps, at each depth, an orthonormal basis of the complement of the
columns chosen so far; one Householder reflection adds a column, and the last column leaves one direction. A column
within ``DEPENDENT`` of the span of those chosen is passed over. Every unit vector gives a valid bound, so a normal that
rounding has turned can cost a rounding of the answer, never more.

Rows of unlike units are first brought to one size, and whether the matrix is singular is asked before anything else
(`degeneracy`).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.degeneracy import TOLERANCE, equalise, rank_of, row_scales, unresisted
from steeplejack.mechanics.cable.status import NO, SINGULAR, UNDEFINED, YES

Array = NDArray[np.float64]

LEAST_SQUARE = 1e-280
"""Below this a square has lost digits."""

DEPENDENT = 1e-12
"""Share of a column's length off the span of others below which it lies in it: rounding, with room [1]."""

NOISE = 1e-15
"""Work of a column along a unit normal that rounding leaves of none, over the sum of the column's entries [1]."""


@njit(cache=True)
def factors_each(structures: Array, room: int, factors: Array, certificates: Array, status: NDArray[np.int64]) -> None:
    """Tension factor, certificate and status of every structure matrix of a batch.

    Args:
        structures: (k, n, m).
        room: Number of subsets of ``n - 1`` of the ``m`` columns.
        factors: Written, (k,) [1].
        certificates: Written, of unit length, (k, n); not a number inside.
        status: Written, (k,).
    """
    n, m = structures.shape[1], structures.shape[2]
    columns, scale, z, rows = np.empty((m, n)), np.empty(n), np.empty(n), np.empty((n, m))
    basis, chosen, normals = np.empty((n, n, n)), np.empty(n, np.int64), np.empty((room, n))
    motions, sizes, nothing = np.empty((n, n)), np.empty(n), np.zeros(n)
    for k in range(structures.shape[0]):
        factors[k], certificates[k] = 0.0, np.nan
        squares = row_scales(structures[k], scale)
        if not squares > 0.0:
            status[k] = UNDEFINED
            continue
        if rank_of(structures[k], scale, squares, rows, motions, sizes) < n:
            status[k] = SINGULAR
            unresisted(scale, motions, sizes, nothing, certificates[k])
            continue
        equalise(structures[k], columns, scale)
        count = hyperplanes(columns, basis, chosen, normals)
        factors[k] = factor_of(columns, normals, count, z)
        status[k] = YES if factors[k] > 0.0 else NO
        if status[k] == NO:
            z *= scale
            certificates[k] = z / np.sqrt(np.sum(z * z))


@njit(cache=True, error_model="numpy")
def margins_each(
    structures: Array, room: int, lowers: Array, uppers: Array, vertices: Array, halves: Array, length: Array,
    margins: Array, surplus: Array, certificates: Array, worst: Array, status: NDArray[np.int64],
) -> None:  # fmt: skip
    """Signed distance of the task wrenches to the surface of the available wrench set, of every pose of a batch.

    Args:
        structures: (k, n, m).
        room: Number of subsets of ``n - 1`` of the ``m`` columns.
        lowers: (k, m) [N].
        uppers: (k, m) [N].
        vertices: Task wrenches, (k, p, n).
        halves: Half-widths of a box around each of them, (k, n).
        length: Weight of each row of ``z`` in its norm: 1 for forces, the characteristic length for moments, (n,).
        margins: Written, (k,) [N].
        surplus: Written, the least distance to a facet over the sizes summed in it, (k,) [1].
        certificates: Written, (k, n); a number also where feasible: the facet that is nearest.
        worst: Written, (k, n), the task wrench nearest the surface or farthest beyond it.
        status: Written, (k,); `YES` where no facet is passed at all.
    """
    n, m = structures.shape[1], structures.shape[2]
    columns, scale, rows = np.empty((m, n)), np.empty(n), np.empty((n, m))
    basis, chosen, normals = np.empty((n, n, n)), np.empty(n, np.int64), np.empty((room, n))
    motions, sizes, z = np.empty((n, n)), np.empty(n), np.empty(n)
    for k in range(structures.shape[0]):
        margins[k], surplus[k], certificates[k], worst[k] = -np.inf, -np.inf, np.nan, np.nan
        squares = row_scales(structures[k], scale)
        status[k] = _question(lowers[k], uppers[k], vertices[k], halves[k]) if squares > 0.0 else UNDEFINED
        if status[k] == UNDEFINED:
            continue
        if rank_of(structures[k], scale, squares, rows, motions, sizes) < n:
            status[k] = SINGULAR
            unresisted(scale, motions, sizes, vertices[k, 0], z)
            which, power, _ = _toughest(z, 1.0, vertices[k], halves[k])
            side, other, _ = _toughest(z, -1.0, vertices[k], halves[k])
            certificates[k] = -z if power < other else z
            worst[k] = vertices[k, which if power < other else side]
        elif status[k] == YES:
            equalise(structures[k], columns, scale)
            count = hyperplanes(columns, basis, chosen, normals)
            margins[k], surplus[k] = _nearest(
                columns, scale, normals[:count], length, lowers[k], uppers[k], vertices[k], halves[k],
                certificates[k], worst[k],
            )  # fmt: skip
            status[k] = YES if surplus[k] >= 0.0 else NO


@njit(cache=True, error_model="numpy")
def _nearest(
    columns: Array, scale: Array, normals: Array, length: Array, lower: Array, upper: Array, vertices: Array,
    half: Array, certificate: Array, worst: Array,
) -> tuple[float, float]:  # fmt: skip
    """Least signed distance to a facet [N], and least share of the sizes summed in one; the normals are overwritten."""
    m, n = columns.shape
    v = np.empty(m)
    margin, surplus = np.inf, np.inf
    for j in range(normals.shape[0]):
        _work(columns, normals[j], v)
        for r in range(n):
            normals[j, r] *= scale[r]
        size = weighted_length(normals[j], length)
        for sign in (1.0, -1.0):
            reach, least = support(v, sign, lower, upper)
            if reach == np.inf:
                continue
            which, power, most = _toughest(normals[j], sign, vertices, half)
            surplus = min(surplus, (reach + power) / (least + most) if least + most > 0.0 else 0.0)
            if (reach + power) / size < margin:
                margin = (reach + power) / size
                for r in range(n):
                    certificate[r] = -sign * normals[j, r] / size
                    worst[r] = vertices[which, r] + (half[r] if sign * normals[j, r] < 0.0 else -half[r])
    return margin, surplus


@njit(cache=True)
def weighted_length(z: Array, weights: Array) -> float:
    """Length of a normal (n,) whose rows are multiplied by weights (n,); over its largest part where squares vanish."""
    square, largest = 0.0, 0.0
    for r in range(z.size):
        square += (z[r] * weights[r]) ** 2
        largest = max(largest, abs(z[r] * weights[r]))
    if LEAST_SQUARE < square < np.inf or not 0.0 < largest < np.inf:
        return math.sqrt(square)
    square = 0.0
    for r in range(z.size):
        square += (z[r] * weights[r] / largest) ** 2
    return largest * math.sqrt(square)


@njit(cache=True)
def facets(structure: Array, room: int, lower: Array, upper: Array, normals: Array, reaches: Array) -> int:
    """Outward normals and reaches of one available wrench set, each hyperplane twice; repeated ones not removed.

    Args:
        structure: (n, m).
        room: Number of subsets of ``n - 1`` of the ``m`` columns.
        lower: (m,) [N].
        upper: (m,) [N].
        normals: Written, (2 room, n).
        reaches: Written, (2 room,); infinite along an unbounded direction.

    Returns:
        How many were written; -1 where the pose is singular, -2 where it is undefined.
    """
    n, m = structure.shape
    columns, scale, v, rows = np.empty((m, n)), np.empty(n), np.empty(m), np.empty((n, m))
    basis, chosen, found = np.empty((n, n, n)), np.empty(n, np.int64), np.empty((room, n))
    squares = row_scales(structure, scale)
    if not squares > 0.0:
        return -2
    if rank_of(structure, scale, squares, rows, np.empty((n, n)), np.empty(n)) < n:
        return -1
    equalise(structure, columns, scale)
    count = hyperplanes(columns, basis, chosen, found)
    for j in range(count):
        _work(columns, found[j], v)
        for side in range(2):
            sign = 1.0 - 2.0 * side
            reaches[2 * j + side] = support(v, sign, lower, upper)[0]
            for r in range(n):
                normals[2 * j + side, r] = sign * found[j, r] * scale[r]
    return 2 * count


@njit(cache=True)
def _work(columns: Array, z: Array, v: Array) -> None:
    """Write the work of every column along a unit normal, (m,); near a singular pose it is little, and noise is not."""
    m, n = columns.shape
    for i in range(m):
        total, size = 0.0, 0.0
        for r in range(n):
            total += columns[i, r] * z[r]
            size += abs(columns[i, r])
        v[i] = total if abs(total) > NOISE * size else 0.0


@njit(cache=True)
def hyperplanes(columns: Array, basis: Array, chosen: NDArray[np.int64], normals: Array) -> int:
    """Write the unit normals of all hyperplanes spanned by ``n - 1`` independent columns.

    Args:
        columns: (m, n).
        basis: Work space, (n, n, n).
        chosen: Work space, (n,).
        normals: Written, (p, n) with ``p`` the number of subsets.

    Returns:
        How many were written; 0 where the rank is below ``n - 1``.
    """
    m, n = columns.shape
    basis[0] = 0.0
    for r in range(n):
        basis[0, r, r] = 1.0
    count, depth, j = 0, 0, 0
    while depth >= 0:
        if j > m - (n - 1 - depth):
            depth -= 1
            if depth >= 0:
                j = chosen[depth] + 1
            continue
        if depth == n - 2:
            c0, c1, square = 0.0, 0.0, 0.0
            for r in range(n):
                c0 += basis[depth, 0, r] * columns[j, r]
                c1 += basis[depth, 1, r] * columns[j, r]
                square += columns[j, r] * columns[j, r]
            size = math.sqrt(c0 * c0 + c1 * c1)
            if size > DEPENDENT * math.sqrt(square):
                c0, c1 = c0 / size, c1 / size
                for r in range(n):
                    normals[count, r] = c0 * basis[depth, 1, r] - c1 * basis[depth, 0, r]
                count += 1
            j += 1
        else:
            if _narrow(columns[j], basis[depth], basis[depth + 1], n - depth):
                chosen[depth] = j
                depth += 1
            j += 1
    return count


@njit(cache=True)
def support(v: Array, sign: float, lower: Array, upper: Array) -> tuple[float, float]:
    """Reach ``max sign v . f`` over the tension box, and the sum of the sizes of its terms.

    Parts that reach for infinite bounds but are together at most ``TOLERANCE`` of the others are zeros with rounding:
    the rule that makes a tension factor 0, so that "in wrench closure" and "no facet" are the same.
    """
    reach, size, endless, rest = 0.0, 0.0, 0.0, 0.0
    for i in range(v.size):
        bound = upper[i] if sign * v[i] > 0.0 else lower[i]
        if math.isinf(bound):
            endless += abs(v[i])
        else:
            reach += sign * v[i] * bound
            size += abs(v[i] * bound)
            rest += abs(v[i])
    if endless > TOLERANCE * rest:
        return np.inf, np.inf
    return reach, size


@njit(cache=True)
def _narrow(column: Array, wide: Array, narrow: Array, size: int) -> bool:
    """From an orthonormal basis (size rows) to that of its part perpendicular to a column; False where there is none.

    The Householder reflection that turns the column's coordinates onto the first axis, applied to the basis.
    """
    n = column.size
    square, length = 0.0, 0.0
    for q in range(size):
        c = 0.0
        for r in range(n):
            c += wide[q, r] * column[r]
        narrow[q, 0] = c
        square += c * c
    for r in range(n):
        length += column[r] * column[r]
    if not square > DEPENDENT * DEPENDENT * length:
        return False
    size_c = math.sqrt(square)
    c0 = narrow[0, 0]
    first = c0 + size_c if c0 >= 0.0 else c0 - size_c
    # w = (first, c1, c2, ...) and |w|^2 / 2 = size_c |first|; the last column of `narrow` holds c until it is written.
    beta = 1.0 / (size_c * abs(first))
    for q in range(1, size):
        narrow[q - 1, n - 1] = narrow[q, 0]
    for r in range(n):
        total = first * wide[0, r]
        for q in range(1, size):
            total += narrow[q - 1, n - 1] * wide[q, r]
        total *= beta
        for q in range(1, size):
            narrow[q - 1, r] = wide[q, r] - narrow[q - 1, n - 1] * total
    return True


@njit(cache=True)
def factor_of(columns: Array, normals: Array, count: int, z: Array) -> float:
    """Tension factor; ``z`` gets the normal that decides, turned so that the columns lie on its side."""
    m, n = columns.shape
    factor = np.inf
    for j in range(count):
        plus, minus = 0.0, 0.0
        for i in range(m):
            v, size = 0.0, 0.0
            for r in range(n):
                v += columns[i, r] * normals[j, r]
                size += abs(columns[i, r])
            if abs(v) > NOISE * size:
                plus += max(v, 0.0)
                minus -= min(v, 0.0)
        if not max(plus, minus) > 0.0:
            continue
        ratio = min(plus, minus) / max(plus, minus)
        if ratio < factor:
            factor = ratio
            for r in range(n):
                z[r] = normals[j, r] if plus >= minus else -normals[j, r]
    return factor if TOLERANCE < factor < np.inf else 0.0


@njit(cache=True)
def _toughest(z: Array, sign: float, vertices: Array, half: Array) -> tuple[int, float, float]:
    """Task wrench with the least ``sign z . w``: index of its vertex, that value, and the sum of its terms' sizes."""
    which, least, most = 0, np.inf, 0.0
    for p in range(vertices.shape[0]):
        power, size = 0.0, 0.0
        for r in range(z.size):
            power += sign * z[r] * vertices[p, r] - abs(z[r]) * half[r]
            size += abs(z[r]) * (abs(vertices[p, r]) + half[r])
        if power < least:
            which, least, most = p, power, size
    return which, least, most


@njit(cache=True)
def _question(lower: Array, upper: Array, vertices: Array, half: Array) -> int:
    """`YES` where there is something to decide, `NO` where a window is empty, `UNDEFINED` where an input is no number.

    An infinite bound is one where it leaves its side open.
    """
    for r in range(half.size):
        if not (math.isfinite(half[r]) and half[r] >= 0.0):
            return UNDEFINED
        for p in range(vertices.shape[0]):
            if not math.isfinite(vertices[p, r]):
                return UNDEFINED
    empty = False
    for i in range(lower.size):
        if not (lower[i] < np.inf and upper[i] > -np.inf):
            return UNDEFINED
        empty = empty or lower[i] > upper[i]
    return NO if empty else YES
