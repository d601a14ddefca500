"""The set of feasible tensions of a robot with two cables too many: a convex polygon, exactly.

All tensions that balance a wrench are ``f = start + N lambda`` with an orthonormal null basis ``N`` (m, 2), so the box
``lower <= f <= upper`` is a polygon in the plane of ``lambda``, with at most two sides a cable (Mikelsons et al. 2008;
Lamaury and Gouttefarde 2013). Its congruent image in the space of tensions does not depend on the basis.

The two cables whose rows of ``N`` are most independent make a parallelogram; the other cables' sides are cut off one
by one. A cable the null space does not move (a row of zeros: its tension is fixed by the wrench) has no side; it makes
the set empty or leaves it alone. Cables with parallel rows cut parallel sides.

Whether there are feasible tensions is decided first, by the rule that `distribute` and `wrench_feasible` follow too
(`depth`). Where the set is thinner than its corners can be told apart, the deepest tensions are its one corner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import each_cable, leading, spread, structures_of, vectors
from steeplejack.mechanics.cable.degeneracy import TOLERANCE
from steeplejack.mechanics.cable.status import UNDEFINED, YES
from steeplejack.mechanics.cable.tension.depth import settle, upside_down
from steeplejack.mechanics.cable.tension.linear import independent, room

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SLACK = 1e-12
"""How far outside a bound still counts as on it, relative to the numbers that meet there [1]."""

ROUNDED = 1e-14
"""The same, relative to the corners it is found from: a polygon a billion newtons long is as thin as they round [1]."""


@dataclass(frozen=True)
class TensionPolygon:
    """Feasible tensions of robots with two cables too many; leading axes are those of the question.

    Attributes:
        corners: Tensions at the corners, in order around the polygon, (..., 2 m, m) [N]; not a number beyond ``count``.
        sides: Bound that is met from each corner to the next, (..., 2 m): the cable's index, plus m for an upper bound;
            -1 beyond ``count``.
        count: Corners, (...); 0 where no tensions are feasible, one or two where the set has no area.
        certificate: ``z`` that proves infeasibility (see `certificate_gap`), or that no cable resists where the rows
            are dependent, (..., n); not a number where there are feasible tensions, and where a least tension is above
            its greatest, which needs no proof.
        status: `FeasibilityStatus` by number, (...); there are corners exactly where it is ``FEASIBLE``.
    """

    corners: Array
    sides: Index
    count: Index
    certificate: Array
    status: Index


def tension_polygon(structure: ArrayLike, wrench: ArrayLike, lower: ArrayLike, upper: ArrayLike) -> TensionPolygon:
    """Feasible tensions of robots with two cables too many, as polygons.

    Args:
        structure: (..., m - 2, m); rows in any units.
        wrench: External wrench on the platform, same rows, (..., m - 2).
        lower: Least tensions, (..., m) or a scalar [N].
        upper: Greatest tensions, (..., m) or a scalar [N].

    Returns:
        Corners, sides, certificate and status over the broadcast leading axes. With an infinite bound the set need not
        be a polygon: ``UNDEFINED``.

    Raises:
        InputError: No numbers, not two cables too many, or shapes that do not match.
    """
    matrix, poses = structures_of(structure)
    _, n, m = matrix.shape
    if m - n != 2:
        raise InputError("structure", f"shape {np.shape(structure)}", "(..., m - 2, m): two cables too many")
    load, low, high = vectors("wrench", wrench, n), each_cable("lower", lower, m), each_cable("upper", upper, m)
    shape = leading(
        ("structure", (*poses, n, m), 2), ("wrench", load.shape, 1), ("lower", low.shape, 1), ("upper", high.shape, 1)
    )
    structures = spread(matrix.reshape(*poses, n, m), shape, (n, m))
    total = len(structures)
    corners, sides = np.full((total, 2 * m, m), np.nan), np.full((total, 2 * m), -1)
    count, certificate, status = np.zeros(total, np.int64), np.full((total, n), np.nan), np.empty(total, np.int64)
    polygons_each(
        structures, spread(load, shape, (n,)), spread(low, shape, (m,)), spread(high, shape, (m,)),
        corners, sides, count, certificate, status,
    )  # fmt: skip
    return TensionPolygon(
        corners.reshape(*shape, 2 * m, m),
        sides.reshape(*shape, 2 * m),
        count.reshape(shape),
        certificate.reshape(*shape, n),
        status.reshape(shape),
    )


@njit(cache=True, error_model="numpy")
def polygons_each(
    structures: Array, wrenches: Array, lowers: Array, uppers: Array,
    corners: Array, sides: Index, counts: Index, certificates: Array, status: Index,
) -> None:  # fmt: skip
    """Polygon of every question of a batch; the kernel of `tension_polygon`.

    Args:
        structures: (k, m - 2, m).
        wrenches: (k, m - 2).
        lowers: (k, m) [N].
        uppers: (k, m) [N].
        corners: Written up to each count, (k, 2 m, m) [N].
        sides: Written up to each count, (k, 2 m).
        counts: Written where feasible, (k,).
        certificates: Written where infeasible or singular, (k, m - 2).
        status: Written, (k,).
    """
    n, m = structures.shape[1], structures.shape[2]
    left, tau, scale, order = np.empty((n, m)), np.empty(n), np.empty(n), np.empty(n, np.int64)
    start, basis, proof, chosen = np.empty(m), np.empty((m, 2)), np.empty(m), np.empty(2, np.int64)
    work, points, labels = np.empty((m, 2)), np.empty((2, 2 * m + 4, 2)), np.empty((2, 2 * m + 4), np.int64)
    space, active, place = np.empty(room(m, 2)), np.empty(3, np.int64), np.empty(3)
    low, high, least, most = np.empty(m), np.empty(m), np.empty(m), np.empty(m)
    for k in range(structures.shape[0]):
        lower, upper = lowers[k], uppers[k]
        if not np.isfinite(lower.sum() + upper.sum()):
            status[k] = UNDEFINED
            continue
        status[k], _ = settle(
            structures[k], wrenches[k], lower, upper, 0.0, left, tau, scale, order, start, basis, low, high,
            least, most, chosen, work, space, active, place, proof, certificates[k],
        )  # fmt: skip
        if status[k] != YES:
            continue
        independent(basis, work, chosen)
        counts[k] = clip(start, basis, lower, upper, chosen, points, labels)
        if counts[k] == 0:
            counts[k], points[0, 0, 0], points[0, 0, 1], labels[0, 0] = 1, place[0], place[1], active[0]
        for c in range(counts[k]):
            sides[k, c] = labels[0, c]
            for i in range(m):
                corners[k, c, i] = start[i] + basis[i, 0] * points[0, c, 0] + basis[i, 1] * points[0, c, 1]


@njit(cache=True, error_model="numpy")
def clip(start: Array, basis: Array, lower: Array, upper: Array, chosen: Index, points: Array, labels: Index) -> int:
    """Corners of one polygon.

    Args:
        start: (m,) [N].
        basis: ``N``, (m, 2).
        lower: (m,) [N].
        upper: (m,) [N].
        chosen: Two cables with independent rows, from `linear.independent`, (2,).
        points: Written, the corners in ``points[0]`` in order, (2, 2 m + 4, 2) [N].
        labels: Written, in ``labels[0]`` the bound met from each corner to the next, (2, 2 m + 4).

    Returns:
        How many corners; 0 where nothing is left.
    """
    m = start.size
    load = 0.0
    if upside_down(lower, upper):
        return 0
    for i in range(m):
        load = max(load, abs(start[i]))
    i, j = chosen[0], chosen[1]
    det = basis[i, 0] * basis[j, 1] - basis[i, 1] * basis[j, 0]
    for c in range(4):
        a = (lower[i] if c == 0 or c == 3 else upper[i]) - start[i]
        b = (lower[j] if c < 2 else upper[j]) - start[j]
        points[0, c, 0] = (a * basis[j, 1] - b * basis[i, 1]) / det
        points[0, c, 1] = (b * basis[i, 0] - a * basis[j, 0]) / det
    labels[0, 0], labels[0, 1], labels[0, 2], labels[0, 3] = j, i + m, j + m, i
    count, now = 4, 0
    for side in range(2 * m):
        cable = side % m
        if cable == i or cable == j:
            continue
        sign = -1.0 if side < m else 1.0
        limit = sign * ((lower[cable] if side < m else upper[cable]) - start[cable])
        x, y = sign * basis[cable, 0], sign * basis[cable, 1]
        slack = SLACK * (load + abs(lower[cable] if side < m else upper[cable]))
        if (x * x + y * y) ** 0.5 <= TOLERANCE:
            if limit < -slack - TOLERANCE * _reach(points[now], count):
                return 0
            continue
        count = _cut(points[now], labels[now], count, x, y, limit, slack, side, points[1 - now], labels[1 - now])
        now = 1 - now
        if count == 0:
            return 0
    return _tidy(points, labels, now, count, SLACK * (load + _reach(points[now], count)))


@njit(cache=True, error_model="numpy")
def _reach(points: Array, count: int) -> float:
    """Largest coordinate of the corners [N]."""
    reach = 0.0
    for c in range(count):
        reach = max(reach, max(abs(points[c, 0]), abs(points[c, 1])))
    return float(reach)


@njit(cache=True, error_model="numpy")
def _cut(
    points: Array, labels: Index, count: int, x: float, y: float, limit: float, slack: float, side: int,
    kept: Array, names: Index,
) -> int:  # fmt: skip
    """Cut a polygon with ``x a + y b <= limit`` (Sutherland and Hodgman 1974); corners on the line stay as they are."""
    out = 0
    for c in range(count):
        slack = max(slack, ROUNDED * max(abs(x * points[c, 0]), abs(y * points[c, 1])))
    before = x * points[count - 1, 0] + y * points[count - 1, 1] - limit
    for c in range(count):
        last = c - 1 if c > 0 else count - 1
        here = x * points[c, 0] + y * points[c, 1] - limit
        if (here > slack and before < -slack) or (here < -slack and before > slack):
            share = before / (before - here)
            kept[out, 0] = points[last, 0] + share * (points[c, 0] - points[last, 0])
            kept[out, 1] = points[last, 1] + share * (points[c, 1] - points[last, 1])
            names[out] = side if here > 0.0 else labels[last]
            out += 1
        if here <= slack:
            kept[out, 0], kept[out, 1], names[out] = points[c, 0], points[c, 1], labels[c]
            following = x * points[(c + 1) % count, 0] + y * points[(c + 1) % count, 1] - limit
            if here >= -slack and following > slack:
                names[out] = side
            out += 1
        before = here
    return out


@njit(cache=True, error_model="numpy")
def _tidy(points: Array, labels: Index, now: int, count: int, slack: float) -> int:
    """Move the corners to the front of the arrays, without those that stand where the next one does."""
    if now == 1:
        for c in range(count):
            points[0, c, 0], points[0, c, 1], labels[0, c] = points[1, c, 0], points[1, c, 1], labels[1, c]
    out = 0
    for c in range(count):
        after = (c + 1) % count
        gap = abs(points[0, c, 0] - points[0, after, 0]) + abs(points[0, c, 1] - points[0, after, 1])
        if gap > slack or (c == count - 1 and out == 0):
            points[0, out, 0], points[0, out, 1], labels[0, out] = points[0, c, 0], points[0, c, 1], labels[0, c]
            out += 1
    return out


@njit(cache=True, error_model="numpy")
def centroid(points: Array, count: int) -> tuple[float, float]:
    """Centre of area of a convex polygon; of a segment or a point, its middle.

    Triangles fan out from the first corner, so coordinates far from zero cost nothing.

    Args:
        points: Corners in order, (at least count, 2).
        count: How many, at least one.

    Returns:
        Its two coordinates.
    """
    x0, y0 = points[0, 0], points[0, 1]
    area, x, y, reach, far = 0.0, 0.0, 0.0, 0.0, 0
    for c in range(1, count):
        ax, ay = points[c, 0] - x0, points[c, 1] - y0
        if ax * ax + ay * ay > reach:
            reach, far = ax * ax + ay * ay, c
        if c + 1 < count:
            bx, by = points[c + 1, 0] - x0, points[c + 1, 1] - y0
            part = ax * by - ay * bx
            area += part
            x += part * (ax + bx)
            y += part * (ay + by)
    if abs(area) <= 1e-12 * reach:
        return 0.5 * (x0 + points[far, 0]), 0.5 * (y0 + points[far, 1])
    return x0 + x / (3.0 * area), y0 + y / (3.0 * area)
