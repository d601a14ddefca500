"""When a pose is singular: one definition for closure, feasibility, tensions, quality, slopes and maps.

A pose is singular where its cables, were they to push as well as pull, could not resist some wrench: the rows of the
structure matrix are dependent. In floating point "dependent" needs a scale and a number.

- *Scale.* Forces and moments have different units, so each kind is divided by its own largest size in the matrix: the
  force rows by the longest force part of a column (1 where columns are unit cables), the moment rows by the longest
  moment part (the characteristic length of the pose: the longest lever a cable has on the platform). Both are lengths
  of vectors, so units of force and of length, the size of the robot, the order of its cables and the orientation of the
  world's axes do not matter. With 3 rows the moment is the last one, with 6 the first three are; with any other number
  all rows are of one kind. Columns keep their relative lengths: a cable counts by what it exerts.
- *Number.* The pose is singular where the least singular value of the scaled matrix is at most ``TOLERANCE = 1e-9`` of
  the greatest. Rounding alone leaves 1e-16 to 1e-13 (coordinates a thousand times longer than levers); geometry is
  known to 1e-5 at the very best. Between those, 1e-9 takes every singular pose for one and no pose that could be told
  from one; and tensions of a pose just above it still have seven digits, as rounding is amplified by its inverse.
- *A column of zeros* belongs to a cable without length. It pulls nobody knows where, so the pose is ``UNDEFINED``, as
  it is where an entry is not finite. Neither is ever held.
- *Levers.* Moments that are rounding only look like those of a small robot. `structure` writes such moments as zeros;
  kernels that see the pose itself may compare moments with the longest arm: below ``TOLERANCE`` of it there are none.
- *Tension factor.* At most ``TOLERANCE`` counts as 0, for the same reason.

Every kernel may settle a pose on its own where `surely_regular` says so: the product of the singular values bounds the
least from below, and a determinant or a product of pivots is at hand anyway. Whatever is closer is decided here, by
singular values that do not lose small ones (one-sided Jacobi; Demmel and Veselic, SIAM J. Matrix Anal. Appl. 13(4),
1992), so that no two questions about one pose contradict each other.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.mechanics.cable.arguments import structures_of

Array = NDArray[np.float64]

TOLERANCE = 1e-9
"""Share of the greatest singular value below which one counts as zero, and tension factor that does [1]."""

SETTLED = 1e-15  # [1] cosine between two rows that counts as perpendicular
LEAST = 1e-300  # entry below which a kind of rows is all zeros, as its inverse has no room
MOST_SWEEPS = 30  # of rotations; six are usual


def rank(structure: ArrayLike) -> NDArray[np.int64]:
    """Number of independent wrenches the cables of a pose exert, were they to push as well as pull.

    Args:
        structure: (..., n, m); rows (fx, fy, mz), (moment; force), or n others of one kind.

    Returns:
        Rank, (...); -1 where an entry is not finite or a column is zero.

    Raises:
        InputError: Not a matrix of numbers.
    """
    matrices, leading = structures_of(structure)
    ranks = np.empty(len(matrices), np.int64)
    _rank_each(matrices, ranks)
    return ranks.reshape(leading)


def is_singular(structure: ArrayLike) -> NDArray[np.bool_]:
    """Whether some wrench is resisted by no tensions of either sign.

    Args:
        structure: (..., n, m).

    Returns:
        True where singular, (...); also where an entry is not finite or a cable has no length.

    Raises:
        InputError: Not a matrix of numbers.
    """
    return rank(structure) < np.shape(structure)[-2]


@njit(cache=True, error_model="numpy")
def first_kind(n: int) -> int:
    """How many of n rows come before those of the other kind: forces before a moment, moments before forces; or all."""
    if n == 3:
        return 2
    return 3 if n == 6 else n


@njit(cache=True, error_model="numpy")
def row_scales(structure: Array, scale: Array) -> float:
    """Write the factor of each row (n,) that brings forces and moments to one size; a kind that is all zeros gets 1.

    Returns:
        Sum of squares of the scaled matrix, from which `surely_regular` bounds its singular values; -1 where an entry
        is not finite or a column is zero.
    """
    n, m = structure.shape
    for i in range(m):
        column = 0.0
        for r in range(n):
            column += abs(structure[r, i])
        if not 0.0 < column < np.inf:
            return -1.0
    first, squares = first_kind(n), 0.0
    for begin, end in ((0, first), (first, n)):
        # Entries are first divided by the largest, so that no square overflows or vanishes.
        largest, longest, total = 0.0, 0.0, 0.0
        for r in range(begin, end):
            for i in range(m):
                largest = max(largest, abs(structure[r, i]))
        inverse = 1.0 / largest if largest > LEAST else 0.0
        if inverse > 0.0:
            for i in range(m):
                square = 0.0
                for r in range(begin, end):
                    square += (structure[r, i] * inverse) ** 2
                longest, total = max(longest, square), total + square
            squares += total / longest
        for r in range(begin, end):
            scale[r] = inverse / math.sqrt(longest) if inverse > 0.0 else 1.0
    return squares


@njit(cache=True, error_model="numpy")
def equalise(structure: Array, columns: Array, scale: Array) -> float:
    """Write the columns (m, n) with forces and moments brought to one size, and the factor of each row (n,).

    Returns:
        Length of the longest scaled column; -1 where an entry is not finite or a column is zero.
    """
    n, m = structure.shape
    if not row_scales(structure, scale) > 0.0:
        return -1.0
    longest = 0.0
    for i in range(m):
        square = 0.0
        for r in range(n):
            columns[i, r] = structure[r, i] * scale[r]
            square += columns[i, r] ** 2
        longest = max(longest, square)
    return math.sqrt(longest)


@njit(cache=True, error_model="numpy")
def surely_regular(volume: float, squares: float, n: int) -> bool:
    """Whether a matrix of n rows cannot be singular, from a lower bound of the product of its singular values.

    The product of the other n - 1 is at most their mean square to the power (n - 1) / 2, so
    ``least >= volume ((n - 1) / squares)^((n - 1) / 2)``, and the greatest is at most the root of ``squares``.

    Args:
        volume: Of the scaled matrix; a determinant of n of its columns, or ``sqrt(det(A A^T))`` of all.
        squares: Sum of squares of the scaled matrix, from `row_scales`.
        n: Rows.
    """
    bound = volume * volume
    for _ in range(n - 1):
        bound *= (n - 1) / squares
    return bound > TOLERANCE * TOLERANCE * squares


@njit(cache=True, error_model="numpy")
def rank_of(structure: Array, scale: Array, squares: float, rows: Array, motions: Array, sizes: Array) -> int:
    """Rank of one matrix: by elimination where that is sure, else by `decide`, with the same arguments.

    ``squares`` is from `row_scales`; motions and sizes are written only where the rank is below n.
    """
    n, m = structure.shape
    if m >= n:
        for r in range(n):
            for i in range(m):
                rows[r, i] = structure[r, i] * scale[r]
        if surely_regular(_volume(rows), squares, n):
            return n
    return decide(structure, scale, rows, motions, sizes)


@njit(cache=True, error_model="numpy")
def _volume(rows: Array) -> float:
    """Size of the determinant of n columns, each the largest left in its row (Gauss); the rows are overwritten."""
    n, m = rows.shape
    volume = 1.0
    for q in range(n):
        best = q
        for c in range(q + 1, m):
            if abs(rows[q, c]) > abs(rows[q, best]):
                best = c
        pivot = rows[q, best]
        volume *= abs(pivot)
        if volume == 0.0:
            return 0.0
        for r in range(q + 1, n):
            times = rows[r, best] / pivot
            rows[r, best] = rows[r, q]
            for c in range(q + 1, m):
                if c != best:
                    rows[r, c] -= times * rows[q, c]
            if best != q:
                rows[r, best] -= times * rows[q, q]
    return volume


@njit(cache=True, error_model="numpy")
def decide(structure: Array, scale: Array, rows: Array, motions: Array, sizes: Array) -> int:
    """Rank of one matrix by its singular values: the last word where `surely_regular` has none.

    Args:
        structure: (n, m), finite.
        scale: From `row_scales`, (n,).
        rows: Overwritten, (n, m).
        motions: Written, (n, n): row k is the unit motion whose work on the columns has the size ``sizes[k]``, all in
            the scaled units; perpendicular to each other.
        sizes: Written, the singular values, (n,).

    Returns:
        How many singular values are above ``TOLERANCE`` of the greatest.
    """
    n, m = structure.shape
    for r in range(n):
        for i in range(m):
            rows[r, i] = structure[r, i] * scale[r]
        for c in range(n):
            motions[r, c] = 1.0 if r == c else 0.0
    for _ in range(MOST_SWEEPS):
        if not _sweep(rows, motions):
            break
    greatest, count = 0.0, 0
    for r in range(n):
        sizes[r] = _dot(rows, r, r) ** 0.5
        greatest = max(greatest, sizes[r])
    for r in range(n):
        count += sizes[r] > TOLERANCE * greatest
    return count


@njit(cache=True, error_model="numpy")
def unresisted(scale: Array, motions: Array, sizes: Array, wrench: Array, z: Array) -> None:
    """Write a unit motion of a singular pose that no cable resists, ``structure^T z = 0``, from what `decide` left.

    Of all such motions the one along which the wrench does most work, if it does any; else the one resisted least.

    Args:
        scale: From `row_scales`, (n,).
        motions: From `decide`, (n, n).
        sizes: From `decide`, (n,).
        wrench: External wrench on the platform, finite, (n,).
        z: Written, (n,).
    """
    n = scale.size
    greatest, load, least = 0.0, 0.0, 0
    for k in range(n):
        z[k] = 0.0
        greatest = max(greatest, sizes[k])
        load = max(load, abs(wrench[k] * scale[k]))
        if sizes[k] < sizes[least]:
            least = k
    found = False
    for k in range(n):
        work = 0.0
        for r in range(n):
            work += motions[k, r] * (wrench[r] * scale[r])
        if sizes[k] <= TOLERANCE * greatest and abs(work) > TOLERANCE * load:
            found = True
            for r in range(n):
                z[r] += work / load * motions[k, r]
    most = 0.0
    for r in range(n):
        z[r] = (z[r] if found else motions[least, r]) * scale[r]
        most = max(most, abs(z[r]))
    size = 0.0
    for r in range(n):
        size += (z[r] / most) ** 2
    for r in range(n):
        z[r] /= most * math.sqrt(size)


@njit(cache=True, error_model="numpy")
def _sweep(rows: Array, motions: Array) -> bool:
    """Turn every two rows perpendicular to each other (Hestenes 1958); whether any had to be turned."""
    turned = False
    n = rows.shape[0]
    for p in range(n - 1):
        for q in range(p + 1, n):
            alpha, beta, gamma = _dot(rows, p, p), _dot(rows, q, q), _dot(rows, p, q)
            if gamma == 0.0 or abs(gamma) <= SETTLED * math.sqrt(alpha * beta):
                continue
            turned = True
            zeta = (beta - alpha) / (2.0 * gamma)
            tangent = math.copysign(1.0, zeta) / (abs(zeta) + math.hypot(1.0, zeta))
            cosine = 1.0 / math.hypot(1.0, tangent)
            _turn(rows, p, q, cosine, cosine * tangent)
            _turn(motions, p, q, cosine, cosine * tangent)
    return turned


@njit(cache=True, error_model="numpy")
def _turn(rows: Array, p: int, q: int, cosine: float, sine: float) -> None:
    """Turn two rows into each other."""
    for i in range(rows.shape[1]):
        a, b = rows[p, i], rows[q, i]
        rows[p, i], rows[q, i] = cosine * a - sine * b, sine * a + cosine * b


@njit(cache=True, error_model="numpy")
def _dot(rows: Array, p: int, q: int) -> float:
    """Product of two rows."""
    total = 0.0
    for i in range(rows.shape[1]):
        total += rows[p, i] * rows[q, i]
    return total


@njit(cache=True, error_model="numpy")
def _rank_each(structures: Array, ranks: NDArray[np.int64]) -> None:
    """Rank of every matrix of a batch, -1 where undefined."""
    n, m = structures.shape[1], structures.shape[2]
    scale, rows, motions, sizes = np.empty(n), np.empty((n, m)), np.empty((n, n)), np.empty(n)
    for k in range(structures.shape[0]):
        ranks[k] = -1
        if row_scales(structures[k], scale) > 0.0:
            ranks[k] = decide(structures[k], scale, rows, motions, sizes)
