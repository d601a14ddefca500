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
within ``TOLERANCE`` of the span of those chosen is passed over. No rank is assumed, and every unit vector gives a valid
bound, so a normal that rounding has turned can cost a rounding of the answer, never more.

Rows of unlike units are first brought to one size: forces and moments are each divided by the longest force and the
longest moment part of a column. A matrix whose columns, so scaled, all lie within ``TOLERANCE`` of one hyperplane is
singular.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

TOLERANCE = 1e-9
"""Relative size below which a distance, a tension factor or a bound that is passed counts as zero [1]."""

INSIDE, OUTSIDE, SINGULAR, UNDEFINED = range(4)


@njit(cache=True)
def factors_each(structures: Array, room: int, factors: Array, certificates: Array, status: NDArray[np.int64]) -> None:
    """Tension factor, certificate and status of every structure matrix of a batch.

    Args:
        structures: (k, n, m).
        room: Number of subsets of ``n - 1`` of the ``m`` columns.
        factors: Written, (k,) [1].
        certificates: Written, (k, n); not a number inside.
        status: Written, (k,).
    """
    n, m = structures.shape[1], structures.shape[2]
    columns, scale, z = np.empty((m, n)), np.empty(n), np.empty(n)
    basis, chosen, normals = np.empty((n, n, n)), np.empty(n, np.int64), np.empty((room, n))
    for k in range(structures.shape[0]):
        factors[k], certificates[k] = 0.0, np.nan
        largest = equalise(structures[k], columns, scale)
        if not largest > 0.0:
            status[k] = UNDEFINED
            continue
        count = hyperplanes(columns, basis, chosen, normals)
        status[k], factors[k] = factor_of(columns, largest, normals, count, z)
        if count == 0:
            unresisted(columns, basis, z)
        if status[k] != INSIDE:
            certificates[k] = z * scale


@njit(cache=True)
def margins_each(
    structures: Array, room: int, lowers: Array, uppers: Array, vertices: Array, halves: Array, length: Array,
    margins: Array, certificates: Array, worst: Array, status: NDArray[np.int64],
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
        certificates: Written, (k, n); not a number where feasible.
        worst: Written, (k, n), the task wrench nearest the surface or farthest beyond it.
        status: Written, (k,).
    """
    n, m = structures.shape[1], structures.shape[2]
    columns, scale, v, z = np.empty((m, n)), np.empty(n), np.empty(m), np.empty(n)
    basis, chosen, normals = np.empty((n, n, n)), np.empty(n, np.int64), np.empty((room, n))
    for k in range(structures.shape[0]):
        margins[k], certificates[k], worst[k] = -np.inf, np.nan, np.nan
        largest = equalise(structures[k], columns, scale)
        if not (largest > 0.0 and _numbers(lowers[k], uppers[k], vertices[k], halves[k], length)):
            status[k] = UNDEFINED
            continue
        count = hyperplanes(columns, basis, chosen, normals)
        flat = count == 0
        if flat:
            unresisted(columns, basis, z)
        margin, surplus = np.inf, np.inf
        for j in range(count):
            widest = 0.0
            for i in range(m):
                v[i] = 0.0
                for r in range(n):
                    v[i] += columns[i, r] * normals[j, r]
                widest = max(widest, abs(v[i]))
            if not widest > TOLERANCE * largest:
                flat = True
                z[:] = normals[j]
                break
            size = 0.0
            for r in range(n):
                normals[j, r] *= scale[r]
                size += (normals[j, r] * length[r]) ** 2
            size = math.sqrt(size)
            for sign in (1.0, -1.0):
                reach, least = support(v, sign, lowers[k], uppers[k])
                if reach == np.inf:
                    continue
                which, power, most = _toughest(normals[j], sign, vertices[k], halves[k])
                distance = (reach + power) / size
                surplus = min(surplus, (reach + power) / (least + most) if least + most > 0.0 else 0.0)
                if distance < margin:
                    margin = distance
                    for r in range(n):
                        certificates[k, r] = -sign * normals[j, r]
                        side = halves[k, r] if sign * normals[j, r] < 0.0 else -halves[k, r]
                        worst[k, r] = vertices[k, which, r] + side
        if flat:
            z *= scale
            which, power, _ = _toughest(z, 1.0, vertices[k], halves[k])
            side, other, _ = _toughest(z, -1.0, vertices[k], halves[k])
            certificates[k] = -z if -power > -other else z
            worst[k] = vertices[k, which if -power > -other else side]
            status[k] = SINGULAR
            continue
        margins[k] = margin
        status[k] = INSIDE if surplus >= -TOLERANCE else OUTSIDE
        if status[k] == INSIDE:
            certificates[k] = np.nan


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
        How many were written; -1 where the set is flat, -2 where it is undefined.
    """
    n, m = structure.shape
    columns, scale, v = np.empty((m, n)), np.empty(n), np.empty(m)
    basis, chosen, found = np.empty((n, n, n)), np.empty(n, np.int64), np.empty((room, n))
    largest = equalise(structure, columns, scale)
    if not largest > 0.0:
        return -2
    count = hyperplanes(columns, basis, chosen, found)
    for j in range(count):
        widest = 0.0
        for i in range(m):
            v[i] = 0.0
            for r in range(n):
                v[i] += columns[i, r] * found[j, r]
            widest = max(widest, abs(v[i]))
        if not widest > TOLERANCE * largest:
            return -1
        for side in range(2):
            sign = 1.0 - 2.0 * side
            reaches[2 * j + side] = support(v, sign, lower, upper)[0]
            for r in range(n):
                normals[2 * j + side, r] = sign * found[j, r] * scale[r]
    return 2 * count if count > 0 else -1


@njit(cache=True)
def equalise(structure: Array, columns: Array, scale: Array) -> float:
    """Write the columns (m, n) with forces and moments brought to one size, and the factor of each row (n,).

    Returns:
        Length of the longest scaled column; -1 where an entry is not finite or a column is zero.
    """
    n, m = structure.shape
    first = n // 2 if n == 6 else (n - 1 if n == 3 else n)
    for r in range(n):
        for i in range(m):
            if not math.isfinite(structure[r, i]):
                return -1.0
    for begin, end in ((0, first), (first, n)):
        # Entries are first divided by the largest, so that no square overflows or vanishes.
        largest, longest = 0.0, 0.0
        for r in range(begin, end):
            for i in range(m):
                largest = max(largest, abs(structure[r, i]))
        if largest > 0.0:
            for i in range(m):
                square = 0.0
                for r in range(begin, end):
                    square += (structure[r, i] / largest) ** 2
                longest = max(longest, square)
        for r in range(begin, end):
            scale[r] = 1.0 / (largest * math.sqrt(longest)) if largest > 0.0 else 1.0
    longest = 0.0
    for i in range(m):
        square = 0.0
        for r in range(n):
            columns[i, r] = structure[r, i] * scale[r]
            square += columns[i, r] ** 2
        if square == 0.0:
            return -1.0
        longest = max(longest, square)
    return math.sqrt(longest)


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
            if size > TOLERANCE * math.sqrt(square):
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
def unresisted(columns: Array, basis: Array, z: Array) -> None:
    """Write a unit vector perpendicular to all columns of a matrix of rank below ``n - 1``."""
    m, n = columns.shape
    basis[0] = 0.0
    for r in range(n):
        basis[0, r, r] = 1.0
    depth = 0
    for j in range(m):
        if depth < n - 1 and _narrow(columns[j], basis[depth], basis[depth + 1], n - depth):
            depth += 1
    z[:] = basis[depth, 0]


@njit(cache=True)
def support(v: Array, sign: float, lower: Array, upper: Array) -> tuple[float, float]:
    """Reach ``max sign v . f`` over the tension box, and the sum of the sizes of its terms.

    A component below ``TOLERANCE`` times the largest does not reach for an infinite bound.
    """
    reach, size, widest = 0.0, 0.0, 0.0
    for i in range(v.size):
        widest = max(widest, abs(v[i]))
    for i in range(v.size):
        bound = upper[i] if sign * v[i] > 0.0 else lower[i]
        if not math.isinf(bound):
            reach += sign * v[i] * bound
            size += abs(v[i] * bound)
        elif abs(v[i]) > TOLERANCE * widest:
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
    if not square > TOLERANCE * TOLERANCE * length:
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
def factor_of(columns: Array, largest: float, normals: Array, count: int, z: Array) -> tuple[int, float]:
    """Status and tension factor; ``z`` gets the normal that decides, turned so that the columns lie on its side."""
    m, n = columns.shape
    factor = np.inf
    for j in range(count):
        plus, minus, widest = 0.0, 0.0, 0.0
        for i in range(m):
            v = 0.0
            for r in range(n):
                v += columns[i, r] * normals[j, r]
            plus += max(v, 0.0)
            minus -= min(v, 0.0)
            widest = max(widest, abs(v))
        if not widest > TOLERANCE * largest:
            z[:] = normals[j]
            return SINGULAR, 0.0
        ratio = min(plus, minus) / max(plus, minus)
        if ratio < factor:
            factor = ratio
            for r in range(n):
                z[r] = normals[j, r] if plus >= minus else -normals[j, r]
    if count == 0:
        return SINGULAR, 0.0
    return (INSIDE, factor) if factor > TOLERANCE else (OUTSIDE, 0.0)


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
def _numbers(lower: Array, upper: Array, vertices: Array, half: Array, length: Array) -> bool:
    """Whether task and lengths are finite and bounds are numbers in order, none infinite on the wrong side."""
    for i in range(lower.size):
        if not (lower[i] <= upper[i] and lower[i] < np.inf and upper[i] > -np.inf):
            return False
    for r in range(half.size):
        if not (math.isfinite(half[r]) and math.isfinite(length[r])):
            return False
        for p in range(vertices.shape[0]):
            if not math.isfinite(vertices[p, r]):
                return False
    return True
