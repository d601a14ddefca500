"""Compiled proofs over boxes of spatial poses, orientations included: one witness, carried over the whole box.

Determinants of a platform that turns are no low polynomials, and there are many hyperplanes. One witness at the middle
of a box decides as well, for any number of cables:

- *Inside*: tensions ``f_0`` well within their window. With ``G`` a right inverse of the columns ``C_0`` at the middle,
  ``f(x) = f_0 - G y`` balances the wrench where ``M(x) y = r(x)``, ``M = C(x) G`` and ``r(x) = C(x) f_0 + w(x)``. Where
  ``|I - M| <= Q`` over the box and ``Q`` contracts, ``M`` is regular, so ``C(x)`` has full rank, ``y`` exists and lies
  within ``Q |y|`` of ``r``: bounds of ``f(x)`` that are sharp to second order.
- *Outside*: a wrench ``z_0`` no tensions at the middle resist. ``z(x) = z_0 - H (B(x) - B_0)^T z_0``, ``H`` the
  pseudo-inverse of the transposed active columns ``B_0``, keeps its work on those constant to first order; where
  ``z(x) . (C(x) f + w(x)) > 0`` for every ``f`` in the window, at every pose, it is a Farkas certificate all over.

Witnesses come from a regularised least-squares problem with bounds, solved by Newton steps on its dual. Nothing of how
they are found enters the proof.

A quantity over the box ``x_c + d`` is a model: a row of value, six slopes and a bound of the rest (Taylor, first
order). ``x`` is the position and a rotation vector ``w`` with ``R = exp(w) R_0``. ``b(w) = exp(w) b`` has slope
``(J(w) e) x b``, ``J`` the left Jacobian, and second derivative at most ``|b|`` along unit directions: in
``D^2 exp [H, H] = 2 int exp H exp H exp`` all exponentials are rotations (Dyson). Every rest gets ``ROUNDING`` of the
sizes summed, far above the error of the fewer than 1,000 operations behind it.

Columns are divided by the cable's length at the middle, moments by the longest arm. All compiled code of these
proofs is in this file because numba's disk cache notices changes in a function's own file only.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.region.enclosure import INSIDE, OUTSIDE, UNDECIDED
from steeplejack.spatial.rotation import from_vector

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

ROUNDING = 2.0**-40
"""Rounding error of a bound over the sizes summed in it [1]."""

SOFT = 1e-7
"""Weight of the dual variables' square in the search for witnesses, over that of the tensions' [1]."""

TIGHT = (0.3, 0.05, 0.005, 0.0005)
"""How much narrower than its window a witness is looked for, the safest first, over half the window [1]."""

THIN = 1.0 / 16.0
"""A side shorter than this share of the longest one, both relative to the search box, is not cut [1]."""

LATTICE = 64
"""Steps across each side of a box of orientations; the smallest piece looked at is two steps wide."""

ROOM = 128
"""Pieces of a box of orientations that may wait at a time."""


@njit(cache=True, error_model="numpy")
def classify_poses(
    anchors: Array, arms: Array, wrenches: Array, centre: Array, lower: Array, upper: Array,
    middles: Array, halves: Array, root: Array, labels: Integers, proofs: Integers, cuts: Integers,
) -> None:  # fmt: skip
    """Decide boxes of poses: inside, outside, or which side to cut.

    Args:
        anchors: (m, 3), scaled.
        arms: Attachments turned by the reference rotation, (m, 3), scaled.
        wrenches: (k, 6), scaled; none for wrench closure.
        centre: Where their forces act, turned by the reference rotation, (3,), scaled.
        lower: Least tensions, (m,), scaled; none for wrench closure.
        upper: Greatest tensions, (m,), scaled; none for wrench closure.
        middles: Positions and rotation vectors, (b, 6).
        halves: Half sides, (b, 6).
        root: Half sides of the search box, (6,).
        labels: Written, (b,).
        proofs: Written, (b,): the wrench that is not held where outside, 0 for wrench closure; else -1.
        cuts: Written, (b,): the side to cut where undecided; else -1.
    """
    weights = np.empty(6)
    for b in range(middles.shape[0]):
        labels[b], proofs[b] = judge(
            anchors, arms, wrenches, centre, lower, upper, middles[b], halves[b], root, weights
        )
        cuts[b] = cut(halves[b], root, weights) if labels[b] == UNDECIDED else -1


@njit(cache=True, error_model="numpy")
def classify_positions(
    anchors: Array, arms: Array, wrenches: Array, centre: Array, lower: Array, upper: Array,
    middles: Array, halves: Array, turns: Array, root: Array, labels: Integers, proofs: Integers, cuts: Integers,
) -> None:  # fmt: skip
    """Decide boxes of positions for all orientations of a range at once.

    Args:
        anchors: (m, 3), scaled.
        arms: Attachments turned by the reference rotation, (m, 3), scaled.
        wrenches: (k, 6), scaled; none for wrench closure.
        centre: Where their forces act, turned by the reference rotation, (3,), scaled.
        lower: Least tensions, (m,), scaled; none for wrench closure.
        upper: Greatest tensions, (m,), scaled; none for wrench closure.
        middles: Positions, (b, 3).
        halves: Half sides, (b, 3).
        turns: Lower and upper end of each component of the rotation vector, (3, 2).
        root: Half sides of the search box, rotation vectors included, (6,).
        labels: Written, (b,): inside for every orientation, or outside for one of them.
        proofs: Written, (b,): that one where outside, ``(i (LATTICE + 1) + j) (LATTICE + 1) + k``; else -1.
        cuts: Written, (b,): the side to cut where undecided; else -1.
    """
    weights, pieces = np.empty(6), np.empty((ROOM, 6), dtype=np.int64)
    middle, half = np.empty(6), np.empty(6)
    step = (turns[:, 1] - turns[:, 0]) / LATTICE
    for b in range(middles.shape[0]):
        middle[:3], half[:3] = middles[b], halves[b]
        labels[b], proofs[b], cuts[b] = INSIDE, -1, -1
        waiting = 1
        for k in range(3):
            pieces[0, k], pieces[0, 3 + k] = 0, LATTICE
        while waiting > 0:
            waiting -= 1
            place, size = pieces[waiting, :3].copy(), pieces[waiting, 3:].copy()
            for k in range(3):
                middle[3 + k] = turns[k, 0] + step[k] * (place[k] + 0.5 * size[k])
                half[3 + k] = 0.5 * step[k] * size[k] * (1.0 + ROUNDING) + (ROUNDING if step[k] > 0.0 else 0.0)
            label, _ = judge(anchors, arms, wrenches, centre, lower, upper, middle, half, root, weights)
            if label == INSIDE:
                continue
            side = cut(half, root, weights)
            witness = _witness(
                anchors, arms, wrenches, centre, lower, upper, middle, half, turns, place, size, root, waiting == 0
            )
            if witness >= 0:
                labels[b], proofs[b] = OUTSIDE, witness
                break
            if side < 3 or size[side - 3] <= 2 or waiting + 2 > ROOM:
                labels[b], cuts[b] = UNDECIDED, _position_side(half, root, weights)
                break
            for h in range(2):
                for k in range(3):
                    pieces[waiting, k], pieces[waiting, 3 + k] = place[k], size[k]
                pieces[waiting, 3 + side - 3] = size[side - 3] // 2
                pieces[waiting, side - 3] = place[side - 3] + h * (size[side - 3] // 2)
                waiting += 1


@njit(cache=True, error_model="numpy")
def _witness(
    anchors: Array, arms: Array, wrenches: Array, centre: Array, lower: Array, upper: Array,
    middle: Array, half: Array, turns: Array, place: Integers, size: Integers, root: Array, corners: bool,
) -> int:  # fmt: skip
    """An orientation of a piece, its middle or a corner, at which no position of the box is inside; -1 for none."""
    pose, still, weights = middle.copy(), half.copy(), np.empty(6)
    for corner in range(9 if corners else 1):
        index = 0
        for k in range(3):
            step = (turns[k, 1] - turns[k, 0]) / LATTICE
            at = place[k] + (size[k] // 2 if corner == 0 else size[k] * (((corner - 1) >> k) & 1))
            if step == 0.0:
                at = 0
            pose[3 + k] = turns[k, 0] + step * at
            still[3 + k] = ROUNDING if step > 0.0 else 0.0
            index = index * (LATTICE + 1) + at
        label, _ = judge(anchors, arms, wrenches, centre, lower, upper, pose, still, root, weights)
        if label == OUTSIDE:
            return index
    return -1


@njit(cache=True, error_model="numpy")
def cut(half: Array, root: Array, weights: Array) -> int:
    """The side that contributes most to the doubt, or the longest where that one has become thin beside it."""
    longest, best = -1, -1
    for k in range(half.size):
        if root[k] > 0.0:
            if longest < 0 or half[k] * root[longest] > half[longest] * root[k]:
                longest = k
            if best < 0 or weights[k] > weights[best]:
                best = k
    if weights[best] > 0.0 and half[best] * root[longest] > THIN * half[longest] * root[best]:
        return best
    return longest


@njit(cache=True, error_model="numpy")
def _position_side(half: Array, root: Array, weights: Array) -> int:
    """The side of the positions to cut."""
    return cut(half[:3], root[:3], weights[:3])


@njit(cache=True, error_model="numpy")
def judge(
    anchors: Array, arms: Array, wrenches: Array, centre: Array, lower: Array, upper: Array,
    middle: Array, half: Array, root: Array, weights: Array,
) -> tuple[int, int]:  # fmt: skip
    """Label of one box of poses, and the wrench that is not held; ``weights`` gets each coordinate's share of doubt."""
    count = anchors.shape[0]
    closure = lower.size == 0
    columns, inverse = np.empty((count, 6, 8)), np.empty((count, 8))
    load, turned = np.zeros((6, 8)), np.empty((4, 3))
    tensions, z, window = np.empty(count), np.empty(6), np.empty((2, count))
    weights[:] = 0.0
    lever = frame(middle, arms, turned)
    if not _models(anchors, arms, turned, lever, middle, half, columns, inverse):
        weights[:] = half / np.where(root > 0.0, root, np.inf)
        return UNDECIDED, -1
    label = INSIDE
    for k in range(1 if closure else wrenches.shape[0]):
        if closure:
            window[0], window[1] = 0.0, np.inf
        else:
            window[0], window[1] = lower, upper
            _load(wrenches[k], centre, turned, lever, half, load)
        if not _balance(columns, load, window, closure, 0.0, tensions, z):
            if _refused(columns, inverse, load, window, closure, tensions, z, half, root, weights):
                return OUTSIDE, k
            return UNDECIDED, -1
        proved = False
        for tight in TIGHT:
            if _balance(columns, load, window, closure, tight, tensions, z):
                proved = _held(columns, inverse, load, window, closure, tensions, half, root, weights)
                break
        if not proved:
            label = UNDECIDED
            if weights.max() == 0.0:
                weights[:] = half / np.where(root > 0.0, root, np.inf)
    return label, -1


@njit(cache=True, error_model="numpy")
def frame(middle: Array, arms: Array, turned: Array) -> float:
    """Write the columns of the left Jacobian at the middle's rotation vector (rows 0 to 2); the longest arm."""
    w = middle[3:]
    square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    angle = math.sqrt(square)
    # Series below 0.1 rad: the closed forms lose digits to cancellation, the next terms are 3e-15.
    if angle < 0.1:
        a = 0.5 - square / 24.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0))
        b = 1.0 / 6.0 - square / 120.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))
    else:
        a, b = (1.0 - math.cos(angle)) / square, (angle - math.sin(angle)) / (square * angle)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        turned[k, k] = 1.0 - b * (w[i] * w[i] + w[j] * w[j])
        turned[k, i] = a * w[j] + b * w[k] * w[i]
        turned[k, j] = -a * w[i] + b * w[k] * w[j]
    turned[3] = w
    longest = 0.0
    for i in range(arms.shape[0]):
        longest = max(longest, math.sqrt(arms[i, 0] ** 2 + arms[i, 1] ** 2 + arms[i, 2] ** 2))
    return longest if longest > 0.0 else 1.0


@njit(cache=True, error_model="numpy")
def _models(
    anchors: Array, arms: Array, turned: Array, lever: float, middle: Array, half: Array, columns: Array, inverse: Array
) -> bool:
    """Models of the columns (m, 6, 8) and of the length at the middle over the length (m, 8); False without length."""
    rotation, b, a, v = from_vector(turned[3]), np.empty(3), np.empty(3), np.empty(3)
    slope = np.empty((6, 3))  # of b; of p with the other sign
    shift = math.sqrt(half[0] ** 2 + half[1] ** 2 + half[2] ** 2)
    turn = math.sqrt(half[3] ** 2 + half[4] ** 2 + half[5] ** 2)
    for i in range(anchors.shape[0]):
        arm = far = square = size = 0.0
        for r in range(3):
            b[r] = rotation[r, 0] * arms[i, 0] + rotation[r, 1] * arms[i, 1] + rotation[r, 2] * arms[i, 2]
            a[r] = anchors[i, r] - middle[r]
            v[r] = a[r] - b[r]
            arm += arms[i, r] ** 2
            far += a[r] ** 2
            square += v[r] ** 2
            size += abs(anchors[i, r]) + abs(middle[r])
        arm, far, length = math.sqrt(arm) * (1.0 + ROUNDING), math.sqrt(far), math.sqrt(square)
        size += arm
        rate = (shift + turn * arm) * (1.0 + ROUNDING) + ROUNDING * size
        least = length - rate
        if not least > 0.0:
            return False
        for k in range(3):
            for r in range(3):
                slope[k, r] = -1.0 if r == k else 0.0
            for r in range(3):
                p, q = (r + 1) % 3, (r + 2) % 3
                slope[3 + k, r] = turned[k, p] * b[q] - turned[k, q] * b[p]
        scale = 1.0 / length
        moments = 0.5 * turn * turn * arm * far + turn * arm * shift + ROUNDING * (arm + turn * arm) * (size + shift)
        forces = 0.5 * turn * turn * arm + ROUNDING * (size + turn * arm)
        for r in range(3):
            p, q = (r + 1) % 3, (r + 2) % 3
            moment, force = columns[i, r], columns[i, 3 + r]
            moment[0] = (b[p] * a[q] - b[q] * a[p]) * scale / lever
            force[0] = v[r] * scale
            for k in range(3):
                moment[1 + k] = (b[p] * slope[k, q] - b[q] * slope[k, p]) * scale / lever
                moment[4 + k] = (slope[3 + k, p] * a[q] - slope[3 + k, q] * a[p]) * scale / lever
                force[1 + k] = slope[k, r] * scale
                force[4 + k] = -slope[3 + k, r] * scale
            moment[7] = moments * scale / lever * (1.0 + ROUNDING)
            force[7] = forces * scale * (1.0 + ROUNDING)
        inverse[i, 0] = 1.0
        for k in range(6):
            sign = 1.0 if k < 3 else -1.0
            along = v[0] * slope[k, 0] + v[1] * slope[k, 1] + v[2] * slope[k, 2]
            inverse[i, 1 + k] = -sign * along / square
        rest = rate * rate / (least * least * least) + 0.5 * turn * turn * arm / (least * least)
        inverse[i, 7] = length * rest * (1.0 + ROUNDING) + ROUNDING * (1.0 + size / least)
    return True


@njit(cache=True, error_model="numpy")
def _load(wrench: Array, centre: Array, turned: Array, lever: float, half: Array, load: Array) -> None:
    """Models of a wrench whose force acts at a point of the platform, (6, 8)."""
    rotation, g = from_vector(turned[3]), np.empty(3)
    turn = math.sqrt(half[3] ** 2 + half[4] ** 2 + half[5] ** 2)
    arm, force = math.sqrt((centre**2).sum()), math.sqrt((wrench[3:] ** 2).sum())
    load[:] = 0.0
    for r in range(3):
        g[r] = rotation[r, 0] * centre[0] + rotation[r, 1] * centre[1] + rotation[r, 2] * centre[2]
        load[3 + r, 0], load[3 + r, 7] = wrench[3 + r], ROUNDING * abs(wrench[3 + r])
    for r in range(3):
        p, q = (r + 1) % 3, (r + 2) % 3
        load[r, 0] = (wrench[r] + g[p] * wrench[3 + q] - g[q] * wrench[3 + p]) / lever
        for k in range(3):
            gp = turned[k, q] * g[r] - turned[k, r] * g[q]
            gq = turned[k, r] * g[p] - turned[k, p] * g[r]
            load[r, 4 + k] = (gp * wrench[3 + q] - gq * wrench[3 + p]) / lever
        rest = 0.5 * turn * turn * arm * force + ROUNDING * (abs(wrench[r]) + arm * force * (1.0 + turn))
        load[r, 7] = rest / lever * (1.0 + ROUNDING)


@njit(cache=True, error_model="numpy")
def _balance(
    columns: Array, load: Array, window: Array, closure: bool, tight: float, tensions: Array, z: Array
) -> bool:
    """Tensions at the middle that balance the load within a window made narrower by ``tight``, and the dual.

    Minimises ``|C f + w|^2 / (2 SOFT) + |(f - middle) / half|^2 / 2`` over the window by Newton steps on the dual:
    ``f = clip(middle + half^2 C^T y)``. Where the balance fails, ``z = -y`` of unit length points at what is missing.
    Wrench closure asks for ``sum f = 1`` in a seventh row instead of a wrench.
    """
    m, n = columns.shape[0], 7 if closure else 6
    c, start, low, high = np.empty((m, n)), np.zeros(n), np.empty(m), np.empty(m)
    widest = 0.0
    for i in range(m):
        widest = max(widest, 1.0 / m if closure else 0.5 * (window[1, i] - window[0, i]))
    for i in range(m):
        half = 1.0 / m if closure else 0.5 * (window[1, i] - window[0, i])
        middle = half if closure else 0.5 * (window[1, i] + window[0, i])
        low[i], high[i] = tight - 1.0, (np.inf if closure else 1.0 - tight)
        for r in range(6):
            c[i, r] = columns[i, r, 0] * half / widest
            start[r] += columns[i, r, 0] * middle / widest
        if closure:
            c[i, 6] = half / widest
            start[6] += middle / widest
    for r in range(6):
        start[r] += load[r, 0] / widest
    if closure:
        start[6] -= 1.0 / widest
    y, work, step, along = np.zeros(n), np.zeros(m), np.empty(n), np.empty(m)
    gradient, hessian = np.empty(n), np.empty((n, n))
    size = 1.0
    for r in range(n):
        size = max(size, abs(start[r]))
    for _ in range(40):
        for r in range(n):
            gradient[r] = start[r] + SOFT * y[r]
            for s in range(n):
                hessian[r, s] = SOFT if r == s else 0.0
        for i in range(m):
            value = min(max(work[i], low[i]), high[i])
            free = low[i] <= work[i] <= high[i]
            for r in range(n):
                gradient[r] += c[i, r] * value
                if free:
                    for s in range(r + 1):
                        hessian[r, s] += c[i, r] * c[i, s]
        most = 0.0
        for r in range(n):
            most = max(most, abs(gradient[r]))
        if most <= 1e-13 * size:
            break
        if not _cholesky(hessian):
            break
        for r in range(n):
            step[r] = -gradient[r]
        _solve(hessian, step)
        for i in range(m):
            along[i] = 0.0
            for r in range(n):
                along[i] += c[i, r] * step[r]
        share = _line(y, work, step, along, start, low, high, c)
        for r in range(n):
            y[r] += share * step[r]
        for i in range(m):
            work[i] += share * along[i]
    left, long = 0.0, 0.0
    for r in range(n):
        missing = start[r]
        for i in range(m):
            missing += c[i, r] * min(max(work[i], low[i]), high[i])
        left = max(left, abs(missing))
    for i in range(m):
        half = 1.0 / m if closure else 0.5 * (window[1, i] - window[0, i])
        middle = half if closure else 0.5 * (window[1, i] + window[0, i])
        tensions[i] = middle + half * min(max(work[i], low[i]), high[i])
    for r in range(6):
        long += y[r] * y[r]
    for r in range(6):
        z[r] = -y[r] / math.sqrt(long) if long > 0.0 else 0.0
    return left <= 1e2 * SOFT


@njit(cache=True, error_model="numpy")
def _line(y: Array, work: Array, step: Array, along: Array, start: Array, low: Array, high: Array, c: Array) -> float:
    """Where along a Newton step the slope of the dual objective vanishes, by bisection of its monotone slope."""
    constant = linear = 0.0
    for r in range(y.size):
        constant += step[r] * (start[r] + SOFT * y[r])
        linear += SOFT * step[r] * step[r]
    a, b, t = 0.0, 1.0, 1.0
    for _ in range(48):
        slope = constant + linear * t
        for i in range(work.size):
            slope += along[i] * min(max(work[i] + t * along[i], low[i]), high[i])
        if slope <= 0.0:
            a = t
        else:
            b = t
        if a == 1.0:
            return 1.0
        t = 0.5 * (a + b)
    return t


@njit(cache=True, error_model="numpy")
def _held(
    columns: Array, inverse: Array, load: Array, window: Array, closure: bool, tensions: Array, half: Array,
    root: Array, weights: Array,
) -> bool:  # fmt: skip
    """Whether tensions near those at the middle hold the load at every pose of the box."""
    m = columns.shape[0]
    right, gram, slack = np.empty((m, 6)), np.zeros((6, 6)), np.empty(m)
    for i in range(m):
        room = tensions[i] - window[0, i]
        if not closure:
            room = min(room, window[1, i] - tensions[i])
        slack[i] = room * room
        for r in range(6):
            for s in range(r + 1):
                gram[r, s] += slack[i] * columns[i, r, 0] * columns[i, s, 0]
    if not _cholesky(gram):
        return False
    for i in range(m):
        for r in range(6):
            right[i, r] = slack[i] * columns[i, r, 0]
        _solve(gram, right[i])
    # What remains of the balance at the middle goes into the tensions.
    for i in range(m):
        slack[i] = tensions[i]
    for r in range(6):
        left = load[r, 0]
        for i in range(m):
            left += columns[i, r, 0] * tensions[i]
        for i in range(m):
            slack[i] -= right[i, r] * left
    residual, far = np.empty((6, 8)), np.empty(6)
    for r in range(6):
        for k in range(8):
            residual[r, k] = load[r, k]
        for i in range(m):
            for k in range(7):
                residual[r, k] += slack[i] * columns[i, r, k]
            residual[r, 7] += abs(slack[i]) * (columns[i, r, 7] + ROUNDING * abs(columns[i, r, 0]))
        far[r] = abs(residual[r, 0]) + _spread(residual[r], half) + residual[r, 7]
    change, correction = np.empty((6, 6, 8)), np.empty(6)
    if not _settles(columns, right, half, far, change, correction):
        for k in range(6):
            weights[k] += half[k] / root[k] if root[k] > 0.0 else 0.0
        return False
    proved = True
    row, edge = np.empty(8), np.empty(8)
    for i in range(m):
        row[:] = 0.0
        row[0] = slack[i]
        for r in range(6):
            for k in range(7):
                row[k] -= right[i, r] * residual[r, k]
            row[7] += abs(right[i, r]) * (residual[r, 7] + ROUNDING * far[r])
            row[7] += _turned_change(right[i], change, r, half) * correction[r]
        for side in range(1 if closure else 2):
            for k in range(8):
                edge[k] = row[k] if side == 0 else -row[k]
            edge[7] = row[7] + ROUNDING * abs(slack[i])
            if not closure:
                bound = window[side, i] if side == 0 else -window[side, i]
                for k in range(7):
                    edge[k] -= bound * inverse[i, k]
                edge[7] += abs(bound) * inverse[i, 7]
            if not edge[0] - _spread(edge, half) - edge[7] > 0.0:
                proved = False
                _weigh(edge, half, root, weights)
    return proved


@njit(cache=True, error_model="numpy")
def _settles(columns: Array, right: Array, half: Array, far: Array, change: Array, correction: Array) -> bool:
    """Models of ``I - C(x) G`` (6, 6, 8) and bounds (6,) of ``y``; False where the matrix may be singular.

    With ``Q`` the bounds of its entries and ``v`` positive, ``far + Q v <= v`` shows both: the spectral radius of ``Q``
    is below 1 (Collatz, Wielandt), and ``|y| <= v``.
    """
    bounds, trial = np.empty((6, 6)), np.empty(6)
    for r in range(6):
        for s in range(6):
            row = change[r, s]
            row[:] = 0.0
            row[0] = 1.0 if r == s else 0.0
            for i in range(columns.shape[0]):
                for k in range(7):
                    row[k] -= columns[i, r, k] * right[i, s]
                row[7] += abs(right[i, s]) * (columns[i, r, 7] + ROUNDING * abs(columns[i, r, 0]))
            bounds[r, s] = (abs(row[0]) + _spread(row, half) + row[7]) * (1.0 + ROUNDING)
    for r in range(6):
        correction[r] = far[r] + 1e-12
    for _ in range(10):
        for r in range(6):
            trial[r] = far[r] + 1e-12
            for s in range(6):
                trial[r] += bounds[r, s] * correction[s]
        correction[:] = trial
    for r in range(6):
        correction[r] *= 1.1
    for r in range(6):
        least = far[r]
        for s in range(6):
            least += bounds[r, s] * correction[s]
        if not least * (1.0 + ROUNDING) <= correction[r]:
            return False
    return True


@njit(cache=True, error_model="numpy")
def _turned_change(right: Array, change: Array, s: int, half: Array) -> float:
    """Bound of an entry of ``G (I - C(x) G)``: a row of ``G`` (6,) times a column."""
    value, rest, spread = 0.0, 0.0, 0.0
    for r in range(6):
        value += right[r] * change[r, s, 0]
        rest += abs(right[r]) * (change[r, s, 7] + ROUNDING * abs(change[r, s, 0]))
    for k in range(6):
        if half[k] > 0.0:
            slope = 0.0
            for r in range(6):
                slope += right[r] * change[r, s, 1 + k]
            spread += abs(slope) * half[k]
    return (abs(value) + spread + rest) * (1.0 + ROUNDING)


@njit(cache=True, error_model="numpy")
def _refused(
    columns: Array, inverse: Array, load: Array, window: Array, closure: bool, tensions: Array, z: Array, half: Array,
    root: Array, weights: Array,
) -> bool:  # fmt: skip
    """Whether a wrench near ``z`` proves at every pose of the box that the load is not held."""
    m = columns.shape[0]
    normal = np.empty((6, 8))
    _carried(columns, window, closure, tensions, z, normal)
    product, pull, total = np.empty(8), np.empty(8), np.zeros(8)
    if not closure:
        for r in range(6):
            _times(normal[r], load[r], half, product)
            total += product
    proved, excess = True, 0.0
    for i in range(m):
        pull[:] = 0.0
        for r in range(6):
            _times(normal[r], columns[i, r], half, product)
            pull += product
        if closure:
            if not pull[0] - _spread(pull, half) - pull[7] > 0.0:
                proved = False
                _weigh(pull, half, root, weights)
            continue
        _times(pull, inverse[i], half, product)
        tension = window[0, i] if product[0] >= 0.0 else window[1, i]
        for k in range(7):
            total[k] += tension * product[k]
        total[7] += abs(tension) * (product[7] + ROUNDING * abs(product[0]))
        excess += (window[1, i] - window[0, i]) * max(0.0, _spread(product, half) + product[7] - abs(product[0]))
    if closure:
        return proved
    if total[0] - _spread(total, half) - total[7] - excess * (1.0 + ROUNDING) > 0.0:
        return True
    total[7] += excess
    _weigh(total, half, root, weights)
    return False


@njit(cache=True, error_model="numpy")
def _carried(columns: Array, window: Array, closure: bool, tensions: Array, z: Array, normal: Array) -> None:
    """Models (6, 8) of a wrench whose work on the active columns stays what it is at the middle, to first order."""
    m = columns.shape[0]
    active, count = np.empty(m, np.int64), 0
    for i in range(m):
        wide = 1.0 / m if closure else window[1, i] - window[0, i]
        above = tensions[i] - window[0, i] > 1e-6 * wide
        if above and (closure or window[1, i] - tensions[i] > 1e-6 * wide) and count < 6:
            active[count] = i
            count += 1
    normal[:] = 0.0
    for r in range(6):
        normal[r, 0] = z[r]
    if count == 0:
        return
    gram, step = np.empty((count, count)), np.empty(count)
    for a in range(count):
        for b in range(a + 1):
            gram[a, b] = 1e-9 if a == b else 0.0
            for r in range(6):
                gram[a, b] += columns[active[a], r, 0] * columns[active[b], r, 0]
    if not _cholesky(gram):
        return
    for k in range(1, 7):
        for a in range(count):
            step[a] = 0.0
            for r in range(6):
                step[a] += columns[active[a], r, k] * z[r]
        _solve(gram, step)
        for a in range(count):
            for r in range(6):
                normal[r, k] -= columns[active[a], r, 0] * step[a]


@njit(cache=True, error_model="numpy")
def _spread(row: Array, half: Array) -> float:
    """How far the linear part goes from the value at the middle, rounded up."""
    total = 0.0
    for k in range(6):
        total += abs(row[1 + k]) * half[k]
    return total * (1.0 + ROUNDING)


@njit(cache=True, error_model="numpy")
def _times(a: Array, b: Array, half: Array, out: Array) -> None:
    """Product of two models."""
    first, second = _spread(a, half), _spread(b, half)
    most, greatest = abs(a[0]) + first + a[7], abs(b[0]) + second + b[7]
    out[0] = a[0] * b[0]
    for k in range(1, 7):
        out[k] = a[k] * b[0] + b[k] * a[0]
    out[7] = first * second + a[7] * greatest + most * b[7] + ROUNDING * most * greatest


@njit(cache=True, error_model="numpy")
def _weigh(row: Array, half: Array, root: Array, weights: Array) -> None:
    """Add each coordinate's share of a bound; that of the rest by the squares of the sides."""
    whole, squares = row[7], 0.0
    for k in range(6):
        whole += abs(row[1 + k]) * half[k]
        squares += (half[k] / root[k]) ** 2 if root[k] > 0.0 else 0.0
    if whole > 0.0 and squares > 0.0:
        for k in range(6):
            if root[k] > 0.0:
                weights[k] += (abs(row[1 + k]) * half[k] + row[7] * (half[k] / root[k]) ** 2 / squares) / whole


@njit(cache=True, error_model="numpy")
def _cholesky(matrix: Array) -> bool:
    """Replace the lower half of a symmetric matrix by its Cholesky factor; False where it is not positive."""
    n = matrix.shape[0]
    for j in range(n):
        whole = matrix[j, j]
        for k in range(j):
            matrix[j, j] -= matrix[j, k] * matrix[j, k]
        if not matrix[j, j] > 1e-15 * whole:
            return False
        matrix[j, j] = math.sqrt(matrix[j, j])
        for i in range(j + 1, n):
            for k in range(j):
                matrix[i, j] -= matrix[i, k] * matrix[j, k]
            matrix[i, j] /= matrix[j, j]
    return True


@njit(cache=True, error_model="numpy")
def _solve(factor: Array, right: Array) -> None:
    """Solve with a Cholesky factor, in place."""
    n = factor.shape[0]
    for i in range(n):
        for k in range(i):
            right[i] -= factor[i, k] * right[k]
        right[i] /= factor[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            right[i] -= factor[k, i] * right[k]
        right[i] /= factor[i, i]
