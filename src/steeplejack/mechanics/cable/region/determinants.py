"""Determinants of un-normalised cable columns as polynomials of the pose, computed exactly and rounded once.

A column is ``c_i = (v_i; b_i x v_i)`` in the plane and ``(b_i x v_i; v_i)`` in space, ``v_i = A_i - b_i - p``.

Planar, three columns: ``m_i d_jk + m_j d_ki + m_k d_ij`` with ``m_i = b_i x v_i`` and ``d_jk = v_j x v_k``, both affine
in ``x, y`` and of first degree in ``cos phi, sin phi``. So the determinant is quadratic in ``x, y``, with coefficients
over ``1, cos phi, sin phi, cos 2 phi, sin 2 phi``.

Spatial, six columns at one orientation: a cubic in ``x, y, z``, interpolated from its values at twenty integer points.

Numbers are Python integers: a double is an integer over a power of two, so everything given is scaled by one such power
(``shift``), and the only rounding is the last division.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError

Array = NDArray[np.float64]
Exact = NDArray[Any]  # of Python integers
Points = list[list[int]]
Rationals = list[list[Fraction]]

CUBIC = tuple(e for degree in range(4) for e in itertools.product(range(3, -1, -1), repeat=3) if sum(e) == degree)
"""Exponents of x, y, z of the twenty monomials of a cubic, in the order of its coefficients."""

LEAST = 2.0**-1000
"""A coefficient below this is refused: its rounding would no longer be relative [1]."""

QUADRATIC_DEGREES = (0, 1, 1, 2, 2, 2)
"""Degree in x and y of the six monomials ``1, x, y, x^2, x y, y^2``, in the order of the coefficients."""


def differences(values: ArrayLike, origin: ArrayLike = 0.0) -> Rationals:
    """Differences of doubles, exact.

    Args:
        values: (k, d), finite.
        origin: (d,) or a scalar, finite.

    Returns:
        ``value - origin``, (k, d).
    """
    rows = np.atleast_2d(np.asarray(values, dtype=np.float64))
    start = np.broadcast_to(np.asarray(origin, dtype=np.float64), rows.shape[-1:])
    return [[Fraction(v) - Fraction(o) for v, o in zip(row, start.tolist(), strict=True)] for row in rows.tolist()]


def turned(points: ArrayLike, rotation: ArrayLike) -> Rationals:
    """Points turned without rounding, by the matrix with its entries as multiples of 2^-53.

    A linear map of the points as stored: what lies on one line or in one plane stays so, exactly.

    Args:
        points: (k, 3), finite.
        rotation: (3, 3).

    Returns:
        ``rotation @ point``, (k, 3).
    """
    matrix = differences(np.rint(np.asarray(rotation, dtype=np.float64) * 2.0**53) / 2.0**53)
    local = differences(points)
    return [[sum((r * b for r, b in zip(row, point, strict=True)), Fraction()) for row in matrix] for point in local]


def integers(*groups: Rationals) -> tuple[list[Points], int]:
    """Fractions over powers of two as integers over one of them.

    Args:
        groups: Each (k, d).

    Returns:
        For each group ``value 2^shift``, and the least ``shift`` that makes all of them whole.
    """
    bits = [value.denominator.bit_length() - 1 for group in groups for row in group for value in row]
    shift = max(bits, default=0)
    return [[[int(value * (1 << shift)) for value in row] for row in group] for group in groups], shift


def planar_volumes(roots: Points, arms: Points, shift: int, triples: Sequence[Sequence[int]]) -> Array:
    """Determinants of three columns.

    Args:
        roots: Anchors, (m, 2), over ``2^shift``.
        arms: Attachments in the platform frame, (m, 2), over ``2^shift``.
        shift: Power of two that lengths are scaled by.
        triples: Cables of each determinant.

    Returns:
        Coefficients, (t, 6, 5).
    """
    moments = [_moment(*root, *arm) for root, arm in zip(roots, arms, strict=True)]
    found: list[Array] = []
    for i, j, k in triples:
        whole = _product(moments[i], _cross(roots, arms, j, k))
        whole = whole + _product(moments[j], _cross(roots, arms, k, i))
        whole = whole + _product(moments[k], _cross(roots, arms, i, j))
        found.append(_rounded(whole, [shift * (4 - degree) for degree in QUADRATIC_DEGREES]))
    return np.array(found)


def planar_loads(
    roots: Points, arms: Points, shift: int, pairs: Sequence[Sequence[int]], wrench: list[int], wrench_shift: int
) -> Array:
    """Determinants of two columns and a wrench.

    Args:
        roots: Anchors, (m, 2), over ``2^shift``.
        arms: Attachments in the platform frame, (m, 2), over ``2^shift``.
        shift: Power of two that lengths are scaled by.
        pairs: Cables of each determinant.
        wrench: ``fx, fy`` over ``2^wrench_shift`` and ``mz`` over ``2^(wrench_shift + shift)``.
        wrench_shift: Power of two that forces are scaled by.

    Returns:
        Coefficients, (s, 6, 5).
    """
    fx, fy, mz = wrench
    moments = [_moment(*root, *arm) for root, arm in zip(roots, arms, strict=True)]
    pulls = [
        _affine(
            [ax * fy - ay * fx, -lx * fy + ly * fx, ly * fy + lx * fx],
            [-fy, 0, 0],
            [fx, 0, 0],
        )
        for (ax, ay), (lx, ly) in zip(roots, arms, strict=True)
    ]
    constant = _affine([mz, 0, 0], [0, 0, 0], [0, 0, 0])
    found: list[Array] = []
    for j, k in pairs:
        whole = _product(moments[j], pulls[k]) - _product(moments[k], pulls[j])
        whole = whole + _product(constant, _cross(roots, arms, j, k))
        found.append(_rounded(whole, [shift * (3 - degree) + wrench_shift for degree in QUADRATIC_DEGREES]))
    return np.array(found)


def spatial_volumes(roots: Points, arms: Points, shift: int, sextets: Sequence[Sequence[int]]) -> Array:
    """Determinants of six columns at one orientation.

    Args:
        roots: Anchors, (m, 3), over ``2^shift``.
        arms: Attachments in world axes, (m, 3), over ``2^shift``.
        shift: Power of two that lengths are scaled by.
        sextets: Cables of each determinant.

    Returns:
        Coefficients in the order of `CUBIC`, (t, 20, 1).
    """
    columns = _columns_at_nodes(roots, arms, shift)
    return np.array([_cubic([_determinant([at[i] for i in s]) for at in columns], 9 * shift) for s in sextets])


def spatial_loads(
    roots: Points, arms: Points, shift: int, quintets: Sequence[Sequence[int]], wrench: list[int], wrench_shift: int
) -> Array:
    """Determinants of five columns and a wrench at one orientation.

    Args:
        roots: Anchors, (m, 3), over ``2^shift``.
        arms: Attachments in world axes, (m, 3), over ``2^shift``.
        shift: Power of two that lengths are scaled by.
        quintets: Cables of each determinant.
        wrench: Moment over ``2^(wrench_shift + shift)`` and force over ``2^wrench_shift``.
        wrench_shift: Power of two that forces are scaled by.

    Returns:
        Coefficients in the order of `CUBIC`, (s, 20, 1).
    """
    columns = _columns_at_nodes(roots, arms, shift)
    power = 8 * shift + wrench_shift
    return np.array([_cubic([_determinant([*(at[i] for i in s), wrench]) for at in columns], power) for s in quintets])


def _affine(constant: list[int], x: list[int], y: list[int]) -> Exact:
    """Coefficients over (1, x, y) and (1, cos, sin), (3, 3)."""
    table = np.empty((3, 3), dtype=object)
    table[0, :], table[1, :], table[2, :] = constant, x, y
    return table


def _moment(ax: int, ay: int, lx: int, ly: int) -> Exact:
    """``b x v = p x b - A x b``."""
    return _affine([0, ay * lx - ax * ly, -ax * lx - ay * ly], [0, ly, lx], [0, -lx, ly])


def _cross(roots: Points, arms: Points, j: int, k: int) -> Exact:
    """``v_j x v_k``; the product of the two turned arms does not depend on the angle."""
    (ax, ay), (bx, by) = roots[j], roots[k]
    (px, py), (qx, qy) = arms[j], arms[k]
    still = ax * by - ay * bx + px * qy - py * qx
    cosine = -(ax * qy - ay * qx) + (bx * py - by * px)
    sine = -(ax * qx + ay * qy) + (bx * px + by * py)
    dx, dy = qx - px, qy - py
    return _affine([still, cosine, sine], [ay - by, dy, dx], [bx - ax, -dx, dy])


_MONOMIAL = {(0, 0): 0, (0, 1): 1, (0, 2): 2, (1, 1): 3, (1, 2): 4, (2, 2): 5}
# Twice the products of 1, cos, sin as sums over 1, cos, sin, cos 2, sin 2.
_TRIGONOMETRIC = {
    (0, 0): ((0, 2),),
    (0, 1): ((1, 2),),
    (0, 2): ((2, 2),),
    (1, 1): ((0, 1), (3, 1)),
    (1, 2): ((4, 1),),
    (2, 2): ((0, 1), (3, -1)),
}


def _product(a: Exact, b: Exact) -> Exact:
    """Twice the product of two affine tables, over the six monomials and five harmonics, (6, 5)."""
    whole = np.full((6, 5), 0, dtype=object)
    for (i, s), (j, t) in itertools.product(np.ndindex(3, 3), repeat=2):
        value = a[i, s] * b[j, t]
        if value:
            for harmonic, weight in _TRIGONOMETRIC[min(s, t), max(s, t)]:
                whole[_MONOMIAL[min(i, j), max(i, j)], harmonic] += weight * value
    return whole


def _rounded(doubled: Exact, powers: list[int]) -> Array:
    """Half of integers over a power of two a row, each rounded once."""
    rows = zip(doubled.tolist(), powers, strict=True)
    return np.array([[_quotient(value, 2, power) for value in row] for row, power in rows])


def _quotient(value: int, divisor: int, power: int) -> float:
    """``value / (divisor 2^power)`` to the nearest double, which is zero only if the value is."""
    quotient = value / (divisor << power)
    if value and abs(quotient) < LEAST:
        raise InputError("cables", "lengths or forces too unlike in size", "ratios above about 1e-40")
    return quotient


def _columns_at_nodes(roots: Points, arms: Points, shift: int) -> list[Points]:
    """Columns of every cable at the twenty integer positions ``CUBIC``."""
    nodes = [[coordinate << shift for coordinate in node] for node in CUBIC]
    pairs = list(zip(roots, arms, strict=True))
    return [[_column(root, arm, node) for root, arm in pairs] for node in nodes]


def _column(root: list[int], arm: list[int], position: list[int]) -> list[int]:
    """``(b x v; v)``; moments over ``2^(2 shift)``, forces over ``2^shift``."""
    x, y, z = (a - b - p for a, b, p in zip(root, arm, position, strict=True))
    bx, by, bz = arm
    return [by * z - bz * y, bz * x - bx * z, bx * y - by * x, x, y, z]


def _determinant(rows: Points) -> int:
    """Determinant in whole numbers (Bareiss, Math. Comp. 22, 1968)."""
    a, sign, last = [list(row) for row in rows], 1, 1
    size = len(a)
    for k in range(size - 1):
        pivot = next((i for i in range(k, size) if a[i][k]), None)
        if pivot is None:
            return 0
        if pivot != k:
            a[k], a[pivot], sign = a[pivot], a[k], -sign
        for i in range(k + 1, size):
            for j in range(k + 1, size):
                a[i][j] = (a[i][j] * a[k][k] - a[i][k] * a[k][j]) // last
        last = a[k][k]
    return sign * a[-1][-1]


def _cubic(values: list[int], power: int) -> Array:
    """Coefficients (20, 1) of the cubic with these values over ``2^power`` at the nodes."""
    exact = _sixfold_inverse() @ np.array(values, dtype=object)
    return np.array([[_quotient(value, 6, power)] for value in exact.tolist()])


@cache
def _sixfold_inverse() -> Exact:
    """Six times the inverse of the matrix of monomials at the nodes; a matrix of integers."""
    nodes = np.array(CUBIC, dtype=np.float64)
    monomials = (nodes[:, None, :] ** nodes[None, :, :]).prod(axis=-1)
    return np.rint(6.0 * np.linalg.inv(monomials)).astype(np.int64).astype(object)
