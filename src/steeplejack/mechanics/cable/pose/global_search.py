"""Compiled branch and bound for every pose that explains cable lengths; `every_pose` is its public face.

Unknowns ``(x, y, z, a, b, c)``: the position and the turns of ``R = Rz(c) Ry(b) Rx(a) R_0``; planar robots move x, y
and c. Functions are the squared lengths ``s_i = |A_i - p - R b_i|^2``, which must lie in
``T_i = [(l_i - tol)^2, (l_i + tol)^2]``. All bounds are intervals with outward rounding (`mechanics.interval`).

A box is thrown away where

- the lengths over it miss the measured ones by more than the tolerance together, or
- it is outside what Krawczyk's operator with an n x m preconditioner ``C`` (the pseudo-inverse at its middle) leaves,

      x in mid + C (T - s(mid)) + (I - C S(X)) (X - mid),      S(X) an enclosure of ds/dx,

  which by the mean value theorem, row by row, holds every pose of the box that explains the lengths, or
- it lies in the box of a solution already certified.

What is left is halved along the unknown that moves the lengths most. A box Y around a pose with ``|I - C S(Y)| < 1`` is
*certified*: no two poses of it have the same lengths (two would differ by ``(I - C S)`` times their difference).
Source: Neumaier, Interval Methods for Systems of Equations, 1990, chapter 5; Merlet, "Solving the forward kinematics of
a Gough-type parallel manipulator with interval analysis", IJRR 23(3), 2004.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics import interval as iv
from steeplejack.mechanics.cable.pose.misfit import cholesky, substitute

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SWEEPS = 3  # contractions of a box before it is halved
SHRUNK = 0.7  # [1] a contraction that leaves more of the widest side than this is not repeated


@njit(cache=True)
def enclose(low: Array, high: Array, anchors: Array, local: Array, squares: Array, slopes: Array) -> None:
    """Bounds over a box: squared lengths (m, 2) and their derivatives (m, 6, 2).

    Args:
        low: (6,).
        high: (6,).
        anchors: (m, 3).
        local: Attachments turned by the reference rotation (m, 3).
        squares: Written.
        slopes: Written.
    """
    ca, ca2 = iv.cos(low[3], high[3])
    sa, sa2 = iv.sin(low[3], high[3])
    cb, cb2 = iv.cos(low[4], high[4])
    sb, sb2 = iv.sin(low[4], high[4])
    cc, cc2 = iv.cos(low[5], high[5])
    sc, sc2 = iv.sin(low[5], high[5])
    # The axis of a: the first column of R.
    ex, ex2 = iv.mul(cc, cc2, cb, cb2)
    ey, ey2 = iv.mul(sc, sc2, cb, cb2)
    ez, ez2 = -sb2, -sb
    for i in range(anchors.shape[0]):
        bx, by, bz = local[i, 0], local[i, 1], local[i, 2]
        # b turned by Rx(a), then Ry(b), then Rz(c).
        y, y2 = _turned(by, by, -bz, -bz, ca, ca2, sa, sa2)
        z, z2 = _turned(bz, bz, by, by, ca, ca2, sa, sa2)
        x, x2 = _turned(bx, bx, z, z2, cb, cb2, sb, sb2)
        rz, rz2 = _turned(z, z2, -bx, -bx, cb, cb2, sb, sb2)
        rx, rx2 = _turned(x, x2, -y2, -y, cc, cc2, sc, sc2)
        ry, ry2 = _turned(y, y2, x, x2, cc, cc2, sc, sc2)
        gx, gx2 = iv.sub(anchors[i, 0], anchors[i, 0], low[0], high[0])
        gy, gy2 = iv.sub(anchors[i, 1], anchors[i, 1], low[1], high[1])
        gz, gz2 = iv.sub(anchors[i, 2], anchors[i, 2], low[2], high[2])
        vx, vx2 = iv.sub(gx, gx2, rx, rx2)
        vy, vy2 = iv.sub(gy, gy2, ry, ry2)
        vz, vz2 = iv.sub(gz, gz2, rz, rz2)
        p, p2 = iv.sqr(vx, vx2)
        q, q2 = iv.sqr(vy, vy2)
        r, r2 = iv.sqr(vz, vz2)
        p, p2 = iv.add(p, p2, q, q2)
        squares[i, 0], squares[i, 1] = iv.add(p, p2, r, r2)
        slopes[i, 0, 0], slopes[i, 0, 1] = -2.0 * vx2, -2.0 * vx
        slopes[i, 1, 0], slopes[i, 1, 1] = -2.0 * vy2, -2.0 * vy
        slopes[i, 2, 0], slopes[i, 2, 1] = -2.0 * vz2, -2.0 * vz
        # In a turn dr = w x r, and v . dr = g . dr with g = A - p, which holds the turn once less. About z:
        p, p2 = iv.mul(gy, gy2, rx, rx2)
        q, q2 = iv.mul(gx, gx2, ry, ry2)
        p, p2 = iv.sub(p, p2, q, q2)
        slopes[i, 5, 0], slopes[i, 5, 1] = -2.0 * p2, -2.0 * p
        # About (-sin c, cos c, 0): dr = (cc rz, sc rz, -(sc ry + cc rx)).
        p, p2 = _sum(gx, gx2, cc, cc2, gy, gy2, sc, sc2)
        p, p2 = iv.mul(p, p2, rz, rz2)
        q, q2 = _sum(sc, sc2, ry, ry2, cc, cc2, rx, rx2)
        q, q2 = iv.mul(q, q2, gz, gz2)
        p, p2 = iv.sub(p, p2, q, q2)
        slopes[i, 4, 0], slopes[i, 4, 1] = -2.0 * p2, -2.0 * p
        # About e: g . (e x r) = e . (r x g).
        q, q2 = _difference(ry, ry2, gz, gz2, rz, rz2, gy, gy2)
        p, p2 = iv.mul(ex, ex2, q, q2)
        q, q2 = _difference(rz, rz2, gx, gx2, rx, rx2, gz, gz2)
        q, q2 = iv.mul(ey, ey2, q, q2)
        p, p2 = iv.add(p, p2, q, q2)
        q, q2 = _difference(rx, rx2, gy, gy2, ry, ry2, gx, gx2)
        q, q2 = iv.mul(ez, ez2, q, q2)
        p, p2 = iv.add(p, p2, q, q2)
        slopes[i, 3, 0], slopes[i, 3, 1] = -2.0 * p2, -2.0 * p


@njit(cache=True)
def _turned(x: float, x2: float, y: float, y2: float, c: float, c2: float, s: float, s2: float) -> tuple[float, float]:
    """``x cos + y sin``."""
    p, p2 = iv.mul(x, x2, c, c2)
    q, q2 = iv.mul(y, y2, s, s2)
    return iv.add(p, p2, q, q2)


@njit(cache=True)
def _sum(a: float, a2: float, b: float, b2: float, c: float, c2: float, d: float, d2: float) -> tuple[float, float]:
    """``a b + c d``."""
    p, p2 = iv.mul(a, a2, b, b2)
    q, q2 = iv.mul(c, c2, d, d2)
    return iv.add(p, p2, q, q2)


@njit(cache=True)
def _difference(
    a: float, a2: float, b: float, b2: float, c: float, c2: float, d: float, d2: float
) -> tuple[float, float]:
    """``a b - c d``."""
    p, p2 = iv.mul(a, a2, b, b2)
    q, q2 = iv.mul(c, c2, d, d2)
    return iv.sub(p, p2, q, q2)


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
def precondition(
    slopes: Array, free: Ints, gram: Array, factor: Array, column: Array, solved: Array, inverse: Array
) -> bool:
    """Write the pseudo-inverse (n, m) of the middle of the slopes; False where it is singular to rounding."""
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
    if not cholesky(gram, 0.0, factor) > 1e-14:
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
def _polish(
    where: Array,
    free: Ints,
    anchors: Array,
    local: Array,
    lengths: Array,
    weights: Array,
    squares: Array,
    slopes: Array,
    gram: Array,
    factor: Array,
    column: Array,
    move: Array,
) -> float:
    """Gauss-Newton from ``where`` (6,), in place; the least residual reached, an upper bound."""
    best, residual = where.copy(), np.inf
    n, m = free.shape[0], lengths.shape[0]
    for _ in range(30):
        enclose(where, where, anchors, local, squares, slopes)
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
        if not cholesky(gram, 0.0, factor) > 1e-14:
            break
        substitute(factor, column, move)
        for a in range(n):
            where[free[a]] += move[a]
    where[:] = best
    return residual


@njit(cache=True)
def certify(
    where: Array,
    radius: float,
    free: Ints,
    anchors: Array,
    local: Array,
    weights: Array,
    tolerance: float,
    squares: Array,
    slopes: Array,
    gram: Array,
    factor: Array,
    column: Array,
    solved: Array,
    inverse: Array,
    rest: Array,
    low: Array,
    high: Array,
) -> float:
    """Find a box ``low, high`` (6,) about a pose in which lengths are unique, from a radius downwards.

    Returns:
        How far apart two poses of the box that explain the lengths can be at most, in the greatest component over its
        weight; negative where no box was found.
    """
    while radius > 1e-13:
        low[:] = where
        high[:] = where
        for a in range(free.shape[0]):
            low[free[a]] -= radius * weights[free[a]]
            high[free[a]] += radius * weights[free[a]]
        enclose(low, high, anchors, local, squares, slopes)
        if precondition(slopes, free, gram, factor, column, solved, inverse):
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


@njit(cache=True)
def search(
    low: Array,
    high: Array,
    free: Ints,
    anchors: Array,
    local: Array,
    lengths: Array,
    weights: Array,
    tolerance: float,
    narrow: float,
    budget: int,
    seeds: Array,
    solutions: Array,
    boxes: Array,
    residuals: Array,
    spreads: Array,
    undecided: Array,
) -> tuple[int, int, int]:
    """Every pose of a box that explains the lengths.

    Args:
        low: (6,).
        high: (6,).
        free: Which unknowns move (n,).
        anchors: (m, 3).
        local: (m, 3).
        lengths: (m,).
        weights: Of the unknowns in norms, 1 for places, 1 / reach for angles (6,).
        tolerance: On the lengths, in the Euclidean norm.
        narrow: Width over weight below which a box is given up as undecided.
        budget: Boxes examined at most.
        seeds: Poses to try first (k, 6).
        solutions: Gets poses (s, 6).
        boxes: Gets their boxes (s, 2, 6).
        residuals: Gets upper bounds of their residuals (s,).
        spreads: Gets what `certify` returns (s,).
        undecided: Gets boxes given up (u, 2, 6).

    Returns:
        Numbers of solutions, of boxes undecided (with those left when the budget or the space ran out) and of boxes
        examined.
    """
    n, m = free.shape[0], lengths.shape[0]
    squares, slopes = np.empty((m, 2)), np.empty((m, 6, 2))
    squares_mid, slopes_mid = np.empty((m, 2)), np.empty((m, 6, 2))
    gram, factor, column, solved = np.empty((n, n)), np.empty((n, n)), np.empty(n), np.empty(n)
    inverse, rest = np.empty((n, m)), np.full((n, n, 2), np.inf)
    middle, where, box_low, box_high = np.empty(6), np.empty(6), np.empty(6), np.empty(6)
    stack = np.empty((4096, 2, 6))
    found, open_boxes, examined, depth = 0, 0, 0, 1
    stack[0, 0], stack[0, 1] = low, high
    for k in range(seeds.shape[0]):
        where[:] = seeds[k]
        residual = _polish(where, free, anchors, local, lengths, weights, squares, slopes, gram, factor, column, solved)
        if residual <= tolerance and found < solutions.shape[0] and not _known(where, where, boxes, found, free):
            spread = certify(
                where, 1.0, free, anchors, local, weights, tolerance, squares, slopes, gram, factor, column, solved,
                inverse, rest, box_low, box_high,
            )  # fmt: skip
            if spread >= 0.0:
                solutions[found], boxes[found, 0], boxes[found, 1] = where, box_low, box_high
                residuals[found], spreads[found] = residual, spread
                found += 1
    while depth > 0:
        depth -= 1
        box_low[:], box_high[:] = stack[depth, 0], stack[depth, 1]
        examined += 1
        gone = False
        for _sweep in range(SWEEPS):
            if _known(box_low, box_high, boxes, found, free):
                gone = True
                break
            enclose(box_low, box_high, anchors, local, squares, slopes)
            if missed(squares, lengths, tolerance):
                gone = True
                break
            if not precondition(slopes, free, gram, factor, column, solved, inverse):
                break
            for a in range(6):
                middle[a] = 0.5 * (box_low[a] + box_high[a])
            enclose(middle, middle, anchors, local, squares_mid, slopes_mid)
            defect(slopes, free, inverse, rest)
            before, after = 0.0, 0.0
            for a in range(n):
                j = free[a]
                p = p2 = float(middle[j])
                for i in range(m):
                    t = max(iv.down(lengths[i] - tolerance), 0.0)
                    t2 = iv.up(lengths[i] + tolerance)
                    q, q2 = iv.sub(iv.down(t * t), iv.up(t2 * t2), squares_mid[i, 0], squares_mid[i, 1])
                    q, q2 = iv.scale(inverse[a, i], q, q2)
                    p, p2 = iv.add(p, p2, q, q2)
                for b in range(n):
                    k = free[b]
                    d, d2 = iv.down(float(box_low[k] - middle[k])), iv.up(float(box_high[k] - middle[k]))
                    q, q2 = iv.mul(rest[a, b, 0], rest[a, b, 1], d, d2)
                    p, p2 = iv.add(p, p2, q, q2)
                column[a], solved[a] = max(p, box_low[j]), min(p2, box_high[j])
                if column[a] > solved[a]:
                    gone = True
                before = max(before, (box_high[j] - box_low[j]) / weights[j])
                after = max(after, (solved[a] - column[a]) / weights[j])
            if gone:
                break
            for a in range(n):
                box_low[free[a]], box_high[free[a]] = column[a], solved[a]
            if after > SHRUNK * before:
                break
        if gone:
            continue
        width, longest, split = 0.0, -1.0, free[0]
        for a in range(n):
            j = free[a]
            width = max(width, (box_high[j] - box_low[j]) / weights[j])
            smear = 0.0
            for i in range(m):
                smear = max(smear, abs(slopes[i, j, 0]), abs(slopes[i, j, 1]))
            smear *= box_high[j] - box_low[j]
            if smear > longest:
                longest, split = smear, j
        if width < narrow or (width < 1.0 and contraction(rest, weights, free) < 1.0):
            for a in range(6):
                where[a] = 0.5 * (box_low[a] + box_high[a])
            residual = _polish(
                where, free, anchors, local, lengths, weights, squares_mid, slopes_mid, gram, factor, column, solved
            )
            if residual <= tolerance and found < solutions.shape[0] and not _known(where, where, boxes, found, free):
                spread = certify(
                    where, 1.0, free, anchors, local, weights, tolerance, squares_mid, slopes_mid, gram, factor, column,
                    solved, inverse, rest, middle, solutions[found],
                )  # fmt: skip
                if spread >= 0.0:
                    boxes[found, 0], boxes[found, 1] = middle, solutions[found]
                    solutions[found] = where
                    residuals[found], spreads[found] = residual, spread
                    found += 1
                    if _known(box_low, box_high, boxes, found, free):
                        continue
        if width < narrow or examined >= budget or depth + 2 > stack.shape[0]:
            if open_boxes < undecided.shape[0]:
                undecided[open_boxes, 0], undecided[open_boxes, 1] = box_low, box_high
            open_boxes += 1
            if examined >= budget:
                return found, open_boxes + depth, examined
            continue
        cut = 0.5 * (box_low[split] + box_high[split])
        for side in range(2):
            stack[depth, 0], stack[depth, 1] = box_low, box_high
            stack[depth, 1 - side, split] = cut
            depth += 1
    return found, open_boxes, examined


@njit(cache=True)
def _known(low: Array, high: Array, boxes: Array, found: int, free: Ints) -> bool:
    """Whether a box lies in that of a solution."""
    for s in range(found):
        inside = True
        for a in range(free.shape[0]):
            j = free[a]
            if low[j] < boxes[s, 0, j] or high[j] > boxes[s, 1, j]:
                inside = False
                break
        if inside:
            return True
    return False
