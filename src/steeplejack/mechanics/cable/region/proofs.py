"""Compiled proofs that a witness at the middle of a box of poses holds all over the box.

- *Inside*: tensions ``f_0`` well within their window. With ``G`` a right inverse of the columns ``C_0`` at the middle,
  ``f(x) = f_0 - G y`` balances the wrench where ``M(x) y = r(x)``, ``M = C(x) G`` and ``r(x) = C(x) f_0 + w(x)``. Where
  ``|I - M| <= Q`` over the box and ``Q`` contracts, ``M`` is regular, so ``C(x)`` has full rank, ``y`` exists and lies
  within ``Q |y|`` of ``r``: bounds of ``f(x)`` that are sharp to second order.
- *Outside*: a wrench ``z_0`` no tensions at the middle resist. ``z(x) = z_0 - H (B(x) - B_0)^T z_0``, ``H`` the
  pseudo-inverse of the transposed active columns ``B_0``, keeps its work on those constant to first order; where
  ``z(x) . (C(x) f + w(x)) > 0`` for every ``f`` in the window, at every pose, it is a Farkas certificate all over.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.cholesky import cholesky, substitute
from steeplejack.mechanics.cable.region.balance import LEAST_PIVOT
from steeplejack.mechanics.cable.region.models import ROUNDING, spread, times, weigh

Array = NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def held(
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
    if not cholesky(gram, 0.0, gram) > LEAST_PIVOT:
        return False
    for i in range(m):
        for r in range(6):
            right[i, r] = slack[i] * columns[i, r, 0]
        substitute(gram, right[i], right[i])
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
        far[r] = abs(residual[r, 0]) + spread(residual[r], half) + residual[r, 7]
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
            if not edge[0] - spread(edge, half) - edge[7] > 0.0:
                proved = False
                weigh(edge, half, root, weights)
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
            bounds[r, s] = (abs(row[0]) + spread(row, half) + row[7]) * (1.0 + ROUNDING)
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
def refused(
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
            times(normal[r], load[r], half, product)
            total += product
    proved, excess = True, 0.0
    for i in range(m):
        pull[:] = 0.0
        for r in range(6):
            times(normal[r], columns[i, r], half, product)
            pull += product
        if closure:
            if not pull[0] - spread(pull, half) - pull[7] > 0.0:
                proved = False
                weigh(pull, half, root, weights)
            continue
        times(pull, inverse[i], half, product)
        tension = window[0, i] if product[0] >= 0.0 else window[1, i]
        for k in range(7):
            total[k] += tension * product[k]
        total[7] += abs(tension) * (product[7] + ROUNDING * abs(product[0]))
        excess += (window[1, i] - window[0, i]) * max(0.0, spread(product, half) + product[7] - abs(product[0]))
    if closure:
        return proved
    if total[0] - spread(total, half) - total[7] - excess * (1.0 + ROUNDING) > 0.0:
        return True
    total[7] += excess
    weigh(total, half, root, weights)
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
    if not cholesky(gram, 0.0, gram) > LEAST_PIVOT:
        return
    for k in range(1, 7):
        for a in range(count):
            step[a] = 0.0
            for r in range(6):
                step[a] += columns[active[a], r, k] * z[r]
        substitute(gram, step, step)
        for a in range(count):
            for r in range(6):
                normal[r, k] -= columns[active[a], r, 0] * step[a]
