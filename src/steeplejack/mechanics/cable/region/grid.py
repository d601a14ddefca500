"""Maps of a planar four-cable robot at one orientation, node by node, compiled.

The tension factor needs one division and one square root a node, everything else is a few multiplications:

- Columns are left un-normalised, ``c_i = (BA_i; b_i x BA_i)``. Their cofactors ``N_i`` give the null vector of the unit
  columns up to a common factor, ``n_i ~ N_i l_i``, so signed squares ``N_i |N_i| l_i^2`` are compared and one root
  remains.
- Along a grid row the moments and the cross products of two ``BA_i`` are linear in x, so each cofactor is a quadratic
  in x: three coefficients a row, two multiply-adds a node.

Source: Zheng et al., CCRobot-S, IEEE T-RO, Eq. 2-6 and 10-12 as `structure` and `closure` correct them.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import (
    cables,
    each_cable,
    finite,
    finite_limits,
    kind,
    number,
    points,
    positive,
    whole,
)
from steeplejack.mechanics.cable.degeneracy import TOLERANCE
from steeplejack.mechanics.cable.structure import planar_arms
from steeplejack.mechanics.cable.tension.plane import planar_margins

Array = NDArray[np.float64]

UNIT = 1e-9
"""How far the square of a direction may be from 1 [1]."""

MOST_NODES = 100_000_000
"""Nodes along one axis that still fit in memory."""

LEAST_VOLUME = 1e-12  # [1] cofactor that counts as zero, over the longest arm times its cables' lengths


def grid_nodes(low: float, high: float, step: float) -> Array:
    """Integer multiples of a step inside a closed interval, both ends included.

    Args:
        low: Lower end [m].
        high: Upper end [m].
        step: Distance of nodes, counted from the origin [m].

    Returns:
        Nodes, ascending, (k,) [m]; empty where none lies inside.

    Raises:
        InputError: Ends that are not finite, a step that is not above 0, or one so small that nodes do not fit in
            memory or are no longer apart.
    """
    ends, size = (number("low", low), number("high", high)), positive("step", step)
    if not np.isfinite(ends).all():
        raise InputError("ends", f"{ends[0]:g} to {ends[1]:g} m", "finite ones")
    rounding = 1e-9
    first, last = ends[0] / size - rounding, ends[1] / size + rounding
    if max(abs(first), abs(last)) >= 2.0**53 or last - first >= MOST_NODES:
        raise InputError("step", f"{size:g} m from {ends[0]:g} to {ends[1]:g} m", f"at most {MOST_NODES:g} nodes")
    return size * np.arange(math.ceil(first), math.floor(last) + 1, dtype=np.float64)


def tension_factor_grid(
    anchors: ArrayLike, attachments: ArrayLike, phi: float, xs: ArrayLike, ys: ArrayLike, out: Array | None = None
) -> Array:
    """Tension factor at every node of a grid, 0 outside wrench closure (Eq. 11-12).

    Args:
        anchors: (4, 2) [m].
        attachments: In the platform frame, (4, 2) [m].
        phi: Orientation [rad].
        xs: (nx,) [m].
        ys: (ny,) [m].
        out: Contiguous, writable array to write to, (ny, nx) [1]; a new one if None.

    Returns:
        TF, (ny, nx) [1].

    Raises:
        InputError: Not four cables, or numbers that are not finite.
    """
    roots, arms, x, y = _question(anchors, attachments, phi, xs, ys)
    middle = 0.5 * (x[0] + x[-1]) if x.size else 0.0
    roots[:, 0] -= middle
    factors = np.empty((y.size, x.size)) if out is None else _writable(out, (y.size, x.size))
    with np.errstate(over="ignore"):
        thin = LEAST_VOLUME**2 * float((arms**2).sum(axis=1).max())
    planar_tension_factors(roots, arms, x - middle, y, thin, factors)
    return factors


def margin_grid(
    anchors: ArrayLike,
    attachments: ArrayLike,
    phi: float,
    xs: ArrayLike,
    ys: ArrayLike,
    wrench: ArrayLike,
    lower: ArrayLike,
    upper: ArrayLike,
    stays: ArrayLike | None = None,
    pull_limit: ArrayLike = np.inf,
) -> Array:
    """Margin of the tension distribution at every node of a grid; a node is feasible from 0 up.

    The margin is that of `distribute`: depth inside the tension box over half the widest window (over the largest force
    that must act, where no window has a width), -inf where singular. A pull limit lowers a cable's upper bound to
    ``pull_limit / |u_i . s_i|``, so that the component of its tension along the stay its anchor sits on stays within
    the limit; the windows that margins are shares of are those before.

    Args:
        anchors: (4, 2) [m].
        attachments: In the platform frame, (4, 2) [m].
        phi: Orientation [rad].
        xs: (nx,) [m].
        ys: (ny,) [m].
        wrench: ``(fx, fy, mz)`` on the platform, (3,) [N, N, N m].
        lower: Least tensions, (4,) or a scalar [N].
        upper: Greatest tensions, (4,) or a scalar [N].
        stays: Unit directions of the stays the anchors sit on, (4, 2) [1]; needed with a pull limit.
        pull_limit: Greatest component of a tension along its stay, (4,) or a scalar [N].

    Returns:
        Margin, (ny, nx) [1].

    Raises:
        InputError: Not four cables, numbers that are not finite, a least tension above its greatest, a pull limit
            without stays, or stays that are not unit directions.
    """
    roots, arms, x, y = _question(anchors, attachments, phi, xs, ys)
    low, high = finite_limits(lower, upper, 4)
    load = finite("wrench", wrench, 3)
    if load.ndim != 1:
        raise InputError("wrench", f"shape {load.shape}", "one wrench (3,)")
    along, pull = _stays(stays, pull_limit)
    margins = np.empty((y.size, x.size))
    planar_margins(roots, arms, x, y, load, low, high, along, pull, margins)
    return margins


def best_node(anchors: ArrayLike, attachments: ArrayLike, phis: ArrayLike, nodes: int = 40) -> tuple[Array, float]:
    """Pose of the largest tension factor on a coarse grid over the anchors' box; a start for finer searches.

    Args:
        anchors: (4, 2) [m].
        attachments: In the platform frame, (4, 2) [m].
        phis: Orientations to try, (k,) [rad].
        nodes: Nodes along each side of the box, 1 to 10 000.

    Returns:
        ``(x, y, phi)`` (3,) [m, m, rad] and its TF [1]; 0 where no node is in wrench closure.

    Raises:
        InputError: Not four cables, numbers that are not finite, no orientation, or no such number of nodes.
    """
    fixed, turns = cables(anchors, attachments, 2)[0], finite("phis", phis).ravel()
    whole("nodes", nodes, 1, 10_000)
    if not turns.size:
        raise InputError("phis", "none", "one orientation at least")
    share = (np.arange(nodes) + 0.5) / nodes
    low, size = fixed.min(axis=0), np.ptp(fixed, axis=0)
    xs, ys = low[0] + share * size[0], low[1] + share * size[1]
    best, most = np.array([xs[nodes // 2], ys[nodes // 2], turns[0]]), 0.0
    for phi in turns:
        factors = tension_factor_grid(fixed, attachments, float(phi), xs, ys)
        row, column = np.unravel_index(int(np.argmax(factors)), factors.shape)
        if factors[row, column] > most:
            best, most = np.array([xs[column], ys[row], phi]), float(factors[row, column])
    return best, most


def _stays(stays: ArrayLike | None, pull_limit: ArrayLike) -> tuple[Array, Array]:
    """Directions (4, 2) that pulls are limited along, zero where there are none, and the limits (4,) [N]."""
    given = each_cable("pull limit", pull_limit, 4)
    if given.ndim > 1 or not (given >= 0.0).all():
        raise InputError("pull limit", f"{given.tolist()} N", "a scalar or (4,), not negative")
    pull = np.array(np.broadcast_to(given, (4,)))
    if stays is None:
        if np.isfinite(pull).any():
            raise InputError("stays", "none", "unit directions (4, 2): a pull limit is along them")
        return np.zeros((4, 2)), pull
    along = points("stays", stays, 2)
    with np.errstate(over="ignore"):
        off = np.abs((along**2).sum(axis=1) - 1.0)
    if along.shape != (4, 2) or not (off <= UNIT).all():
        raise InputError("stays", f"{along.tolist()}", "unit directions (4, 2)")
    return along, pull


def _writable(out: Array, shape: tuple[int, int]) -> Array:
    """An array that a kernel can write to."""
    given = kind("out", out, np.ndarray)
    if given.shape != shape or given.dtype != np.float64 or not (given.flags.c_contiguous and given.flags.writeable):
        raise InputError("out", f"{given.dtype} of shape {given.shape}", f"writable, contiguous float64 of {shape}")
    return given


def _question(
    anchors: ArrayLike, attachments: ArrayLike, phi: float, xs: ArrayLike, ys: ArrayLike
) -> tuple[Array, Array, Array, Array]:
    """``A_i - b_i`` and ``b_i``, (4, 2) each, and the coordinates of the nodes, (nx,) and (ny,) [m]."""
    fixed, local = cables(anchors, attachments, 2)
    if len(fixed) != 4:
        raise InputError("cables", f"{len(fixed)} of them", "four; `planar_closure_map` takes any number")
    turn, x, y = finite("phi", phi), finite("xs", xs), finite("ys", ys)
    if turn.ndim or x.ndim != 1 or y.ndim != 1:
        raise InputError("grid", f"phi {turn.shape}, xs {x.shape}, ys {y.shape}", "one angle and two rows of numbers")
    arms = planar_arms(local, turn)
    return fixed - arms, arms, x, y


@njit(cache=True, parallel=True, error_model="numpy", fastmath={"contract", "nsz", "nnan", "ninf"})
def planar_tension_factors(roots: Array, arms: Array, xs: Array, ys: Array, thin: float, factors: Array) -> None:
    """Write the tension factor of every node; the kernel of `tension_factor_grid`.

    Args:
        roots: ``A_i - b_i``, (4, 2) [m].
        arms: ``b_i``, (4, 2) [m].
        xs: (nx,) [m].
        ys: (ny,) [m].
        thin: ``(N l)^2`` that counts as zero over the squared greatest length of each of the four cables in the row: a
            cofactor rounds relative to the arm times the lengths of its own three cables [m2].
        factors: Written, (ny, nx) [1].
    """
    (x1, t1), (x2, t2), (x3, t3), (x4, t4) = roots[0], roots[1], roots[2], roots[3]
    (bx1, by1), (bx2, by2), (bx3, by3), (bx4, by4) = arms[0], arms[1], arms[2], arms[3]
    if xs.size == 0:
        return
    left, right = xs.min(), xs.max()
    for j in prange(ys.size):
        y1, y2, y3, y4 = t1 - ys[j], t2 - ys[j], t3 - ys[j], t4 - ys[j]
        w1, w2, w3, w4 = y1 * y1, y2 * y2, y3 * y3, y4 * y4
        flat = thin * _far(x1, left, right, w1) * _far(x2, left, right, w2)
        flat *= _far(x3, left, right, w3) * _far(x4, left, right, w4)
        p1, q1, r1 = _minor(x2, y2, bx2, by2, x3, y3, bx3, by3, x4, y4, bx4, by4)
        p2, q2, r2 = _minor(x1, y1, bx1, by1, x4, y4, bx4, by4, x3, y3, bx3, by3)
        p3, q3, r3 = _minor(x1, y1, bx1, by1, x2, y2, bx2, by2, x4, y4, bx4, by4)
        p4, q4, r4 = _minor(x1, y1, bx1, by1, x3, y3, bx3, by3, x2, y2, bx2, by2)
        for i in range(xs.size):
            x = xs[i]
            n1, n2 = p1 + x * (q1 + x * r1), p2 + x * (q2 + x * r2)
            n3, n4 = p3 + x * (q3 + x * r3), p4 + x * (q4 + x * r4)
            l1, l2 = (x1 - x) * (x1 - x) + w1, (x2 - x) * (x2 - x) + w2
            l3, l4 = (x3 - x) * (x3 - x) + w3, (x4 - x) * (x4 - x) + w4
            s1, s2, s3, s4 = n1 * abs(n1) * l1, n2 * abs(n2) * l2, n3 * abs(n3) * l3, n4 * abs(n4) * l4
            least, most = min(min(s1, s2), min(s3, s4)), max(max(s1, s2), max(s3, s4))
            small, large = max(least, -most), max(most, -least)
            factors[j, i] = math.sqrt(small / large) if small > TOLERANCE**2 * large + flat else 0.0


@njit(cache=True)
def _far(x: float, left: float, right: float, height: float) -> float:
    """Greatest squared length of a cable along a row [m2]; ``height`` is its squared part across."""
    return max((x - left) * (x - left), (x - right) * (x - right)) + height


@njit(cache=True, fastmath={"contract", "nsz"})
def _minor(
    xi: float, yi: float, bxi: float, byi: float,
    xj: float, yj: float, bxj: float, byj: float,
    xk: float, yk: float, bxk: float, byk: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Determinant of un-normalised columns i, j, k along a row, as coefficients of 1, x, x^2."""
    mi, mj, mk = bxi * yi - byi * xi, bxj * yj - byj * xj, bxk * yk - byk * xk
    dij, djk, dki = xi * yj - xj * yi, xj * yk - xk * yj, xk * yi - xi * yk
    eij, ejk, eki = yi - yj, yj - yk, yk - yi
    return (
        mi * djk + mj * dki + mk * dij,
        mi * ejk + mj * eki + mk * eij + byi * djk + byj * dki + byk * dij,
        byi * ejk + byj * eki + byk * eij,
    )
