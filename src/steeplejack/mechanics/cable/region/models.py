"""Compiled first-order models over a box of spatial poses, orientations included: columns, lengths, wrenches.

A quantity over the box ``x_c + d`` is a model: a row of value, six slopes and a bound of the rest (Taylor, first
order). ``x`` is the position and a rotation vector ``w`` with ``R = exp(w) R_0``. ``b(w) = exp(w) b`` has slope
``(J(w) e) x b``, ``J`` the left Jacobian, and second derivative at most ``|b|`` along unit directions: in
``D^2 exp [H, H] = 2 int exp H exp H exp`` all exponentials are rotations (Dyson). Every rest gets ``ROUNDING`` of the
sizes summed, far above the error of the fewer than 1,000 operations behind it.

Columns are divided by the cable's length at the middle, moments by the longest arm.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.spatial.rotation import from_vector

Array = NDArray[np.float64]

ROUNDING = 2.0**-40
"""Rounding error of a bound over the sizes summed in it [1]."""


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
def column_models(
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
def load_models(wrench: Array, centre: Array, turned: Array, lever: float, half: Array, load: Array) -> None:
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
def spread(row: Array, half: Array) -> float:
    """How far the linear part goes from the value at the middle, rounded up."""
    total = 0.0
    for k in range(6):
        total += abs(row[1 + k]) * half[k]
    return total * (1.0 + ROUNDING)


@njit(cache=True, error_model="numpy")
def times(a: Array, b: Array, half: Array, out: Array) -> None:
    """Product of two models."""
    first, second = spread(a, half), spread(b, half)
    most, greatest = abs(a[0]) + first + a[7], abs(b[0]) + second + b[7]
    out[0] = a[0] * b[0]
    for k in range(1, 7):
        out[k] = a[k] * b[0] + b[k] * a[0]
    out[7] = first * second + a[7] * greatest + most * b[7] + ROUNDING * most * greatest


@njit(cache=True, error_model="numpy")
def weigh(row: Array, half: Array, root: Array, weights: Array) -> None:
    """Add each coordinate's share of a bound; that of the rest by the squares of the sides."""
    whole, squares = row[7], 0.0
    for k in range(6):
        whole += abs(row[1 + k]) * half[k]
        squares += (half[k] / root[k]) ** 2 if root[k] > 0.0 else 0.0
    if whole > 0.0 and squares > 0.0:
        for k in range(6):
            if root[k] > 0.0:
                weights[k] += (abs(row[1 + k]) * half[k] + row[7] * (half[k] / root[k]) ** 2 / squares) / whole
