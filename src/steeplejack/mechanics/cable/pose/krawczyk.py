"""Compiled tests of a box of poses: thrown away, made smaller, or proved to hold no two poses of the same lengths.

Functions are the squared lengths ``s_i``, which must lie in ``T_i = [(l_i - tol)^2, (l_i + tol)^2]``; `bounds` encloses
them and their derivatives. A box is thrown away where

- the lengths over it miss the measured ones by more than the tolerance together, or
- it is outside what Krawczyk's operator with an n x m preconditioner ``C`` (the pseudo-inverse at its middle) leaves,

      x in mid + C (T - s(mid)) + (I - C S(X)) (X - mid),      S(X) an enclosure of ds/dx,

  which by the mean value theorem, row by row, holds every pose of the box that explains the lengths.

A box Y with ``|I - C S(Y)| < 1`` is *certified*: no two poses of it have the same lengths (two would differ by
``(I - C S)`` times their difference). A cable whose derivatives `bounds` gives as zero has a zero column in C and takes
no part in either. Source: Neumaier, Interval Methods for Systems of Equations, 1990, chapter 5.

What belongs together travels in plain tuples: ``Robot`` is anchors, swivel axes, radii and turned attachments;
``Asked`` lengths (m,), weights of the unknowns in norms (6,), which of them move (n,) and the tolerance; ``Room`` is
space for intermediate results, see `room`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics import interval as iv
from steeplejack.mechanics.cable.cholesky import cholesky, substitute
from steeplejack.mechanics.cable.pose.bounds import enclose

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Robot = tuple[Array, Array, Array, Array]
Asked = tuple[Array, Array, Ints, float]
Room = tuple[Array, Array, Array, Array, Array, Array, Array, Array]

SINGULAR = 1e-14
"""Least pivot over its diagonal below which a preconditioner is not formed [1]."""


@njit(cache=True)
def room(n: int, m: int) -> Room:
    """Space for squares (m, 2), slopes (m, 6, 2), gram and its factor (n, n), two columns (n,), C (n, m), I - CS."""
    return (
        np.empty((m, 2)),
        np.empty((m, 6, 2)),
        np.empty((n, n)),
        np.empty((n, n)),
        np.empty(n),
        np.empty(n),
        np.empty((n, m)),
        np.full((n, n, 2), np.inf),
    )


@njit(cache=True)
def missed(squares: Array, lengths: Array, tolerance: float) -> bool:
    """Whether no pose with these squared lengths (m, 2) explains the measured ones, in the Euclidean norm."""
    total = 0.0
    for i in range(lengths.shape[0]):
        least, most = iv.sqrt(squares[i, 0], squares[i, 1])
        off = max(iv.down(least - lengths[i]), iv.down(float(lengths[i]) - most))
        if off > 0.0:
            total = iv.down(total + iv.down(off * off))
    return total > iv.up(tolerance * tolerance)


@njit(cache=True)
def precondition(slopes: Array, free: Ints, space: Room) -> bool:
    """Write the pseudo-inverse (n, m) of the middle of the slopes; False where it is singular to rounding."""
    _squares, _slopes, gram, factor, column, solved, inverse, _rest = space
    n, m = free.shape[0], slopes.shape[0]
    for a in range(n):
        for b in range(a + 1):
            total = 0.0
            for i in range(m):
                total += (
                    0.25
                    * (slopes[i, free[a], 0] + slopes[i, free[a], 1])
                    * (slopes[i, free[b], 0] + slopes[i, free[b], 1])
                )
            gram[a, b] = total
    if not cholesky(gram, 0.0, factor) > SINGULAR:
        return False
    for i in range(m):
        for a in range(n):
            column[a] = 0.5 * (slopes[i, free[a], 0] + slopes[i, free[a], 1])
        substitute(factor, column, solved)
        for a in range(n):
            inverse[a, i] = solved[a]
    return True


@njit(cache=True)
def defect(slopes: Array, free: Ints, inverse: Array, rest: Array) -> None:
    """Write bounds (n, n, 2) of ``I - C S``."""
    n, m = inverse.shape
    for a in range(n):
        for b in range(n):
            one = 1.0 if a == b else 0.0
            p, p2 = one, one
            for i in range(m):
                q, q2 = iv.scale(inverse[a, i], slopes[i, free[b], 0], slopes[i, free[b], 1])
                p, p2 = iv.sub(p, p2, q, q2)
            rest[a, b, 0], rest[a, b, 1] = p, p2


@njit(cache=True)
def contraction(rest: Array, weights: Array, free: Ints) -> float:
    """Norm of ``I - C S`` in the greatest component over its weight; below 1 no two poses share their lengths."""
    n, greatest = rest.shape[0], 0.0
    for a in range(n):
        total = 0.0
        for b in range(n):
            size = max(abs(rest[a, b, 0]), abs(rest[a, b, 1]))
            total = iv.up(total + iv.up(size * weights[free[b]]))
        total = iv.up(total / float(weights[free[a]]))
        greatest = max(greatest, total)
    return greatest


@njit(cache=True)
def narrowed(low: Array, high: Array, middle: Array, squares_mid: Array, asked: Asked, space: Room) -> float:
    """Cut a box to what Krawczyk's operator leaves of it.

    Args:
        low: (6,), replaced.
        high: (6,), replaced.
        middle: Of the box (6,).
        squares_mid: Bounds of the squared lengths there (m, 2).
        asked: See the module.
        space: With ``C`` and ``I - C S`` of the box; the two columns are written.

    Returns:
        Widest side left over the widest before, both over their weights; negative where nothing is left.
    """
    lengths, weights, free, tolerance = asked
    least, most, inverse, rest = space[4], space[5], space[6], space[7]
    before, after = 0.0, 0.0
    for a in range(free.shape[0]):
        j = free[a]
        p = p2 = float(middle[j])
        for i in range(lengths.shape[0]):
            t = max(iv.down(lengths[i] - tolerance), 0.0)
            t2 = iv.up(lengths[i] + tolerance)
            q, q2 = iv.sub(iv.down(t * t), iv.up(t2 * t2), squares_mid[i, 0], squares_mid[i, 1])
            q, q2 = iv.scale(inverse[a, i], q, q2)
            p, p2 = iv.add(p, p2, q, q2)
        for b in range(free.shape[0]):
            k = free[b]
            d, d2 = iv.down(float(low[k] - middle[k])), iv.up(float(high[k] - middle[k]))
            q, q2 = iv.mul(rest[a, b, 0], rest[a, b, 1], d, d2)
            p, p2 = iv.add(p, p2, q, q2)
        least[a], most[a] = max(p, low[j]), min(p2, high[j])
        if least[a] > most[a]:
            return -1.0
        before = max(before, float((high[j] - low[j]) / weights[j]))
        after = max(after, float((most[a] - least[a]) / weights[j]))
    for a in range(free.shape[0]):
        low[free[a]], high[free[a]] = least[a], most[a]
    return after / before if before > 0.0 else 1.0


@njit(cache=True)
def polish(where: Array, robot: Robot, asked: Asked, space: Room) -> float:
    """Gauss-Newton from ``where`` (6,), in place; the least residual reached, an upper bound."""
    anchors, axes, radii, local = robot
    lengths, _weights, free, _tolerance = asked
    squares, slopes, gram, factor, column, move, _inverse, _rest = space
    best, residual = where.copy(), np.inf
    n, m = free.shape[0], lengths.shape[0]
    for _ in range(30):
        enclose(where, where, anchors, axes, radii, local, squares, slopes)
        total = 0.0
        for a in range(n):
            column[a] = 0.0
            for b in range(a + 1):
                gram[a, b] = 0.0
        for i in range(m):
            least, most = iv.sqrt(squares[i, 0], squares[i, 1])
            off = max(iv.up(most - lengths[i]), iv.up(lengths[i] - least))
            total = iv.up(total + iv.up(off * off))
            middle = 0.5 * (least + most)
            if not middle > 0.0:
                where[:] = best
                return residual
            for a in range(n):
                slope = slopes[i, free[a], 0] / (2.0 * middle)
                column[a] -= slope * (middle - lengths[i])
                for b in range(a + 1):
                    gram[a, b] += slope * slopes[i, free[b], 0] / (2.0 * middle)
        total = iv.up(math.sqrt(total))
        if not total < residual:
            break
        residual = total
        best[:] = where
        if not cholesky(gram, 0.0, factor) > SINGULAR:
            break
        substitute(factor, column, move)
        for a in range(n):
            where[free[a]] += move[a]
    where[:] = best
    return residual


@njit(cache=True)
def certify(where: Array, radius: float, robot: Robot, asked: Asked, space: Room, low: Array, high: Array) -> float:
    """Find a box ``low, high`` (6,) about a pose in which lengths are unique, from a radius downwards.

    Returns:
        How far apart two poses of the box that explain the lengths can be at most, in the greatest component over its
        weight; negative where no box was found.
    """
    anchors, axes, radii, local = robot
    _lengths, weights, free, tolerance = asked
    squares, slopes, inverse, rest = space[0], space[1], space[6], space[7]
    while radius > 1e-13:
        low[:] = where
        high[:] = where
        for a in range(free.shape[0]):
            low[free[a]] -= radius * weights[free[a]]
            high[free[a]] += radius * weights[free[a]]
        enclose(low, high, anchors, axes, radii, local, squares, slopes)
        if precondition(slopes, free, space):
            defect(slopes, free, inverse, rest)
            norm = contraction(rest, weights, free)
            if norm < 0.95:
                spread = 0.0
                for a in range(inverse.shape[0]):
                    total = 0.0
                    for i in range(inverse.shape[1]):
                        reach = iv.up(math.sqrt(squares[i, 1]))
                        total = iv.up(total + iv.up(abs(float(inverse[a, i])) * 4.0 * reach * tolerance))
                    spread = max(spread, iv.up(total / float(weights[free[a]])))
                return iv.up(spread / iv.down(1.0 - norm))
        radius *= 0.6
    return -1.0
