"""How evenly four cables can pull while each anchor stands anywhere in an interval of its stay: bounds from twists.

Tensions ``f > 0`` with ``sum_i f_i w_i = 0`` do no work on any twist ``z``, so ``sum_i f_i (z . w_i) = 0``. Let
``m_i(z)`` be the largest ``z . w_i`` while anchor ``i`` moves through its interval. No tension exceeds the largest, and
none is below TF times the largest, so

    TF sum_i max(-m_i, 0) <= sum_i max(m_i, 0)        for every twist z,

wherever in their intervals the anchors stand. Every twist is a certificate, the best twist the Lagrangian dual of the
problem; where all ``m_i`` are negative nothing in the box is in wrench closure: along ``z`` all four cables slacken.

Under ``z`` attachment ``i`` moves with ``g_i = (z_x - z_phi b_iy, z_y + z_phi b_ix)``, and ``z . w_i = g_i . u_i``. So
``m_i`` is ``|g_i|`` if ``g_i`` points into the sector of cable ``i`` and otherwise its value at an end: exact, in
closed form. With the paper's un-normalised columns (J~) ``g_i . BA_i`` is linear in the offset, and an end is best.

The best twist is sought among the vertices of the problem with each arc replaced by its chord, ``m_i`` by the larger
of its end values and the bound 1 of the tension by ``1 / cos`` of half the sector, which is a linear program in
``z``: there, two of twelve planes are met (an end at which a cable does no work, or both its ends equally well).
Chord and arc differ in second order of the sector, and so do bound and optimum.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.wrench.hyperplanes import TOLERANCE

Array = NDArray[np.float64]

ROUNDING = 2.0**-47  # of a work z . w, relative to what is added up: each sum has under ten terms
TINY = 1e-300  # keeps 1 / length finite where a stay has no direction either
BLUNT = -0.999999  # cosine of a sector that is taken for half a turn: the stay all but passes through the attachment


@njit(cache=True)
def columns(
    arms: Array, roots: Array, along: Array, unit: bool, shortest: float, offsets: Array, inward: float, out: Array
) -> bool:  # fmt: skip
    """Wrench of each cable at given offsets, a column of J^T or, where ``unit`` is False, of J~.

    Args:
        arms: ``b_i``, (4, 2) [m].
        roots: ``BA_i`` at no offset, (4, 2) [m].
        along: Change of ``BA_i`` with the offset, (4, 2) [1].
        unit: Whether columns are divided by the cable's length.
        shortest: Length from which a cable has a direction that rounding leaves alone [m].
        offsets: (4,) [m].
        inward: Where a cable has no length, the sign of the offsets from which its direction is taken as a limit.
        out: Written, (4, 4): fx, fy, mz, and the factor of the column relative to ``BA_i``.

    Returns:
        Whether every cable has a direction: half of that length is room for the ends of boxes, which are rounded.
    """
    complete = True
    for i in range(4):
        x, y = roots[i, 0] + offsets[i] * along[i, 0], roots[i, 1] + offsets[i] * along[i, 1]
        factor = 1.0
        if unit:
            length = math.sqrt(x * x + y * y)
            complete &= length > 0.5 * shortest
            if not length > 0.0:
                x, y = inward * along[i, 0], inward * along[i, 1]
                length = max(math.sqrt(x * x + y * y), TINY)
            factor = 1.0 / length
        out[i, 0], out[i, 1] = x * factor, y * factor
        out[i, 2] = (arms[i, 0] * y - arms[i, 1] * x) * factor
        out[i, 3] = factor
    return complete


@njit(cache=True)
def factor_of(wrenches: Array) -> float:
    """``min n / max n`` of the null vector of four columns (4, >= 3), 0 outside wrench closure or where singular."""
    a, b, c, d = wrenches[0], wrenches[1], wrenches[2], wrenches[3]
    n1, n2, n3, n4 = _triple(b, c, d), -_triple(a, c, d), _triple(a, b, d), -_triple(a, b, c)
    least, most = min(min(n1, n2), min(n3, n4)), max(max(n1, n2), max(n3, n4))
    small, large = max(least, -most), max(most, -least)
    volume = 1.0
    for row in range(3):
        volume *= a[row] ** 2 + b[row] ** 2 + c[row] ** 2 + d[row] ** 2
    if small <= TOLERANCE * large or n1 * n1 + n2 * n2 + n3 * n3 + n4 * n4 <= TOLERANCE**2 * volume:
        return 0.0
    return small / large


@njit(cache=True)
def upper_bound(z: Array, arms: Array, left: Array, right: Array, unit: bool) -> float:
    """No tension factor in the box exceeds this, whatever the rounding [1].

    Args:
        z: Twist (vx, vy, omega), any length, (3,).
        arms: ``b_i``, (4, 2) [m].
        left: Columns at the lower ends, as `columns` writes them, (4, 4).
        right: Columns at the upper ends, (4, 4).
        unit: As for `columns`.

    Returns:
        The bound, at most 1; 0 where no cable can resist the twist, and 1 for the twist 0, which proves nothing.
    """
    if z[0] == 0.0 and z[1] == 0.0 and z[2] == 0.0:
        return 1.0
    gives = takes = 0.0
    for i in range(4):
        work = largest_work(z, arms[i], left[i], right[i], unit)
        if work > 0.0:
            gives += work
        else:
            takes -= work
    if gives == 0.0:
        return 0.0
    return gives / takes * (1.0 + ROUNDING) if gives < takes else 1.0


@njit(cache=True)
def largest_work(z: Array, arm: Array, left: Array, right: Array, unit: bool) -> float:
    """Largest ``z . w`` of one cable while its anchor moves through its interval, rounded up."""
    gx, gy = z[0] - z[2] * arm[1], z[1] + z[2] * arm[0]
    work = max(gx * left[0] + gy * left[1], gx * right[0] + gy * right[1])
    size = abs(z[0]) + abs(z[1]) + abs(z[2]) * (abs(arm[0]) + abs(arm[1]))
    if not unit:
        reach = abs(left[0]) + abs(left[1]) + abs(right[0]) + abs(right[1])
        return work + ROUNDING * size * reach
    turn = left[0] * right[1] - left[1] * right[0]
    blunt = left[0] * right[0] + left[1] * right[1] < BLUNT
    if blunt or ((left[0] * gy - left[1] * gx) * turn > 0.0 and (gx * right[1] - gy * right[0]) * turn > 0.0):
        work = math.sqrt(gx * gx + gy * gy)
    return work + ROUNDING * size


@njit(cache=True)
def _triple(a: Array, b: Array, c: Array) -> float:
    """Determinant of three columns."""
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
