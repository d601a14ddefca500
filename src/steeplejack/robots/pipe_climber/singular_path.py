"""Proof that a path meets no singularity: the sign of the surface's polynomial in interval arithmetic.

A path gives x, w and alpha as polynomials of t. Over a piece of it their values are enclosed, with them that of
``q1 q2 q3 det J`` (`singularity.surface_value`); a piece whose enclosure holds no zero is free, others are halved. The
first piece at whose end the sign has changed proves a crossing. A path that touches the surface, or passes it by very
little, stays undecided. Nothing lies between samples, as there are none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from steeplejack.errors import InputError
from steeplejack.mechanics import interval as iv
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.poses import Array, triples
from steeplejack.robots.pipe_climber.singularity import SurfaceConstants

DEPTH = 44
"""Halvings after which a piece is given up as undecided."""

MOST_PIECES = 200_000
"""Pieces after which a path that keeps very close to the surface is given up as undecided; a tenth of a second."""

Verdict = Literal["free", "crosses", "undecided"]
VERDICTS: tuple[Verdict, Verdict, Verdict] = ("free", "crosses", "undecided")


@dataclass(frozen=True)
class PathCheck:
    """What is proved about a path and the singular surface.

    Attributes:
        verdict: Free of singularities, crossing the surface, or undecided.
        between: The piece that decided, parameter from and to; None if free.
        pieces: How many pieces were looked at.
    """

    verdict: Verdict
    between: tuple[float, float] | None
    pieces: int


def check_polynomials(
    layout: Layout,
    polynomials: tuple[ArrayLike, ArrayLike, ArrayLike],
    span: tuple[float, float],
    turning_offset: float = 0.0,
) -> PathCheck:
    """Prove a path of polynomials free of singularities, or that it crosses one.

    Args:
        layout: Hinges.
        polynomials: Coefficients of x, w and alpha in rising powers of t [m, m, rad].
        span: t from and to.
        turning_offset: hz, if x and w are those of the claw and hz turns with alpha [m].

    Returns:
        The proof.

    Raises:
        InputError: A span that is empty or not finite, coefficients that are not finite.
    """
    begin, end = span
    if not -math.inf < begin < end < math.inf:
        raise InputError("span", f"{begin:g} to {end:g}", "two finite numbers, the smaller first")
    size = max(np.size(one) for one in polynomials)
    coefficients = np.zeros((3, size))
    for row, one in zip(coefficients, polynomials, strict=True):
        row[: np.size(one)] = one
    if not np.isfinite(coefficients).all():
        raise InputError("polynomials", "a coefficient that is not finite", "finite numbers")
    c = SurfaceConstants.of(layout)
    verdict, low, high, pieces = _follow(coefficients, begin, end, turning_offset, c.k, c.a, c.b, c.l4)
    return PathCheck(VERDICTS[verdict], None if verdict == 0 else (low, high), pieces)


def check_waypoints(layout: Layout, poses: ArrayLike) -> PathCheck:
    """Prove a path of straight pieces free of singularities, or that it crosses one.

    Args:
        layout: Hinges.
        poses: Waypoints, (n, 3) with n of at least 2 [m, m, rad]; x, w and alpha change linearly between them.

    Returns:
        The proof; its parameter is 0 at the first waypoint and 1 more at each further one.

    Raises:
        InputError: Fewer than two waypoints, or one that is not finite.
    """
    given = triples("poses", poses)
    if given.ndim != 2 or len(given) < 2 or not np.isfinite(given).all():
        raise InputError("poses", f"shape {given.shape}", "(n, 3) finite, n of at least 2")
    pieces = 0
    for number, (start, end) in enumerate(zip(given, given[1:], strict=False)):
        x, w, alpha = np.stack((start, end - start), axis=-1)
        found = check_polynomials(layout, (x, w, alpha), (0.0, 1.0))
        pieces += found.pieces
        if found.between is not None:
            low, high = found.between
            return PathCheck(found.verdict, (number + low, number + high), pieces)
    return PathCheck("free", None, pieces)


@njit(cache=True)
def _follow(
    coefficients: Array, begin: float, end: float, offset: float, k: float, a: float, b: float, l4: float
) -> tuple[int, float, float, int]:
    """Verdict (index in `VERDICTS`), the piece that decided, and how many were looked at; from begin to end."""
    low, high = _enclosed(coefficients, begin, begin, offset, k, a, b, l4)
    if low <= 0.0 <= high:
        return 2, begin, begin, 1
    sign = 1.0 if low > 0.0 else -1.0
    stack = np.empty((DEPTH + 2, 2))
    depths = np.empty(DEPTH + 2, dtype=np.int64)
    stack[0, 0], stack[0, 1], depths[0] = begin, end, 0
    waiting, pieces = 1, 1
    crossed = math.inf  # where the sign is proved to have changed
    while waiting > 0:
        waiting -= 1
        left, right, depth = stack[waiting, 0], stack[waiting, 1], depths[waiting]
        pieces += 1
        low, high = _enclosed(coefficients, left, right, offset, k, a, b, l4)
        if sign * low > 0.0 and sign * high > 0.0:
            continue
        low, high = _enclosed(coefficients, right, right, offset, k, a, b, l4)
        if sign * low < 0.0 and sign * high < 0.0:
            crossed, waiting = right, 0  # before that place: what lies behind it no longer matters
        if depth >= DEPTH or pieces >= MOST_PIECES:
            return (1 if crossed < math.inf else 2), left, min(crossed, end), pieces
        middle = 0.5 * (left + right)
        stack[waiting, 0], stack[waiting, 1], depths[waiting] = middle, right, depth + 1
        stack[waiting + 1, 0], stack[waiting + 1, 1], depths[waiting + 1] = left, middle, depth + 1
        waiting += 2
    return 0, end, end, pieces


@njit(cache=True)
def _enclosed(
    coefficients: Array, left: float, right: float, offset: float, k: float, a: float, b: float, l4: float
) -> tuple[float, float]:
    """Enclosure of ``-q1 q2 q3 det J`` over a piece of the path."""
    xl, xh = _horner(coefficients[0], left, right)
    wl, wh = _horner(coefficients[1], left, right)
    al, ah = _horner(coefficients[2], left, right)
    sl, sh = iv.sin(al, ah)
    cl, ch = iv.cos(al, ah)
    if offset != 0.0:
        pl, ph = iv.scale(offset, sl, sh)
        xl, xh = iv.sub(xl, xh, pl, ph)
        pl, ph = iv.scale(offset, cl, ch)
        wl, wh = iv.sub(wl, wh, pl, ph)
    pl, ph = iv.mul(xl, xh, sl, sh)
    ql, qh = iv.mul(wl, wh, cl, ch)
    normal_l, normal_h = iv.add(pl, ph, ql, qh)
    pl, ph = iv.scale(k, wl, wh)
    ql, qh = iv.scale(a, sl, sh)
    arm_l, arm_h = iv.add(pl, ph, ql, qh)
    pl, ph = iv.scale(l4, sl, sh)
    ql, qh = iv.add(wl, wh, pl, ph)
    pl, ph = iv.scale(b, sl, sh)
    rest_l, rest_h = iv.mul(pl, ph, ql, qh)
    pl, ph = iv.mul(normal_l, normal_h, arm_l, arm_h)
    return iv.add(pl, ph, rest_l, rest_h)


@njit(cache=True)
def _horner(coefficients: Array, left: float, right: float) -> tuple[float, float]:
    """Enclosure of a polynomial over an interval."""
    low = high = coefficients[-1]
    for power in range(coefficients.shape[0] - 2, -1, -1):
        low, high = iv.mul(low, high, left, right)
        low, high = iv.add(low, high, coefficients[power], coefficients[power])
    return low, high
