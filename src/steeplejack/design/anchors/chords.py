"""The chord problem of a box of anchor offsets: its best twist, and the offsets it suggests.

With every arc of cable directions replaced by its chord, the force of cable ``i`` is ``alpha_i left_i + beta_i
right_i`` and the tension factor a linear program over equilibria, ``tau <= alpha_i + beta_i <= c_i``. Its dual is over
twists; all 66 pairs of the twelve planes in which a vertex lies are tried, which is cheaper than pivoting for so few.
The forces of the best vertex are in balance exactly, so the directions they have are offsets whose tension factor is
below the bound by a term of second order.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

PARALLEL = 1e-24  # squared sine between planes that are taken for one
CREASE = 1e-11  # work at the other end, over twist and column, that counts as none
SHARP = 1e-3  # least cosine of half a sector; wider ones still only guide the choice of twist


@njit(cache=True)
def solve(left: Array, right: Array, unit: bool, z: Array, shares: Array) -> None:
    """Best twist of the chord problem of a box, and the forces in balance that belong to it.

    Args:
        left: Columns at the lower ends of the box, (4, 4).
        right: Columns at the upper ends, (4, 4).
        unit: Whether they have unit length; otherwise arcs are chords already.
        z: Written, the twist, (3,); 0 where the columns span no plane.
        shares: Written, ``alpha_i, beta_i``, (4, 2).
    """
    caps, planes = np.empty(4), np.empty((12, 3))
    for i in range(4):
        for k in range(3):
            planes[2 * i, k], planes[2 * i + 1, k] = left[i, k], right[i, k]
            planes[8 + i, k] = right[i, k] - left[i, k]
        caps[i] = _cap(left[i], right[i]) if unit else 1.0
    one, two, tau = _best_vertex(left, right, caps, planes, z)
    shares[:] = 0.5
    if one >= 0:
        _forces(left, right, caps, planes, z, one, two, tau, shares)


@njit(cache=True)
def _best_vertex(left: Array, right: Array, caps: Array, planes: Array, z: Array) -> tuple[int, int, float]:
    """The two planes (-1, -1 for none) in which the twist with the least bound lies, and that bound."""
    one = two = -1
    best, normal = math.inf, np.empty(3)
    z[:] = 0.0
    for p in range(12):
        for q in range(p + 1, 12):
            _cross(planes[p], planes[q], normal)
            if _dot(normal, normal) <= PARALLEL * _dot(planes[p], planes[p]) * _dot(planes[q], planes[q]):
                continue
            forth, back = _bounds(normal, left, right, caps)
            a, b = _turning(normal, planes, p), _turning(normal, planes, q)
            if max(a[0], b[0]) > 0.0:
                forth = math.inf
            if max(a[1], b[1]) > 0.0:
                back = math.inf
            if min(forth, back) < best:
                best, one, two = min(forth, back), p, q
                for k in range(3):
                    z[k] = normal[k] if forth <= back else -normal[k]
    return one, two, best


@njit(cache=True)
def _turning(z: Array, planes: Array, plane: int) -> tuple[float, float]:
    """Whether the bound has a crease in a plane at a twist and at the opposite one: there, neither is positive.

    Where one end of a cable does no work but the other does some, the first does not matter.
    """
    if plane >= 8:
        return 0.0, 0.0
    other = _dot(z, planes[plane ^ 1])
    slack = CREASE * math.sqrt(_dot(z, z))
    return other - slack, -other - slack


@njit(cache=True)
def _bounds(z: Array, left: Array, right: Array, caps: Array) -> tuple[float, float]:
    """Bound of the chord problem by a twist and by the opposite one."""
    gives = takes = gives_back = takes_back = 0.0
    for i in range(4):
        a, b = _dot(z, left[i]), _dot(z, right[i])
        most, least = max(a, b), min(a, b)
        if most > 0.0:
            gives += caps[i] * most
        else:
            takes -= most
        if least < 0.0:
            gives_back -= caps[i] * least
        else:
            takes_back += least
    forth = gives / takes if takes > 0.0 else math.inf if gives > 0.0 else 0.0
    back = gives_back / takes_back if takes_back > 0.0 else math.inf if gives_back > 0.0 else 0.0
    return forth, back


@njit(cache=True)
def _cap(left: Array, right: Array) -> float:
    """Largest ``alpha + beta`` under which all of the arc lies: ``1 / cos`` of half the sector."""
    x, y = left[0] + right[0], left[1] + right[1]
    return 1.0 / max(0.5 * math.sqrt(x * x + y * y), SHARP)


@njit(cache=True)
def _forces(
    left: Array, right: Array, caps: Array, planes: Array, z: Array, one: int, two: int, tau: float, shares: Array
) -> None:
    """Forces by complementary slackness: all but two follow from the twist, those two from the balance."""
    rest, side, normal = np.zeros(3), np.empty(3), np.empty(3)
    for i in range(4):
        shares[i, 0] = shares[i, 1] = 0.0
        if one // 2 == i or two // 2 == i:  # an end without work; planes 8 to 11 halve to 4 and 5
            continue
        a, b = _dot(z, left[i]), _dot(z, right[i])
        pull = caps[i] if max(a, b) > 0.0 else tau
        lower = a >= b or 8 + i == one or 8 + i == two
        shares[i, 0 if lower else 1] = pull
        for k in range(3):
            rest[k] += pull * (left[i, k] if lower else right[i, k])
    _cross(planes[one], planes[two], normal)
    size = _dot(normal, normal)
    _cross(rest, planes[two], side)
    _add(one, -_dot(side, normal) / size, shares)
    _cross(planes[one], rest, side)
    _add(two, -_dot(side, normal) / size, shares)
    for i in range(4):
        shares[i, 0], shares[i, 1] = max(shares[i, 0], 0.0), max(shares[i, 1], 0.0)


@njit(cache=True)
def _add(plane: int, amount: float, shares: Array) -> None:
    """Put the unknown force of a plane into the shares of its cable."""
    if plane < 8:
        shares[plane // 2, plane % 2] += amount
    else:
        shares[plane - 8, 0] -= amount
        shares[plane - 8, 1] += amount


@njit(cache=True)
def _cross(a: Array, b: Array, out: Array) -> None:
    """Vector product."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@njit(cache=True)
def _dot(a: Array, b: Array) -> float:
    """Inner product of triples."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
