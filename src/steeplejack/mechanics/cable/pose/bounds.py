"""Compiled bounds of squared cable lengths and their derivatives over a box of poses, straight and over pulleys.

Unknowns ``(x, y, z, a, b, c)``: the position and the turns of ``R = Rz(c) Ry(b) Rx(a) R_0``. All bounds are intervals
with outward rounding (`mechanics.interval`) about the numbers as stored. A straight cable has, with ``v = A - p - r``
and the turned arm ``r = R b``,

    s = v . v,        ds = -2 v . (dp + w x r).

A cable over a pulley (`pulleys`) has its squared length, free length f and wrapped angle beta,

    s = v . v + rad^2 (beta^2 - 2 + 2 cos beta) + 2 rad f (beta - sin beta),
    ds = (-2 v + 2 k) . (dp + w x r),        k = rad ((beta sin beta + cos beta - 1) n + (beta cos beta - sin beta) e),

with the swivel axis e and the unit vector n beside it towards the attachment: what a pulley adds is a function of beta
and f that grows with both, and small where the pulley is. It follows from ``l u = rad beta u + f u`` and
``B - A = T + f u``, u the direction of the free stretch and T the place where it leaves the pulley.

Over a rectangle of (h, rho) clear of the pulley's circle and of the axis beta is greatest and least in corners: its
gradient ``(cos beta, -sin beta) / f`` in (rho, h) vanishes nowhere, and where one component of it vanishes beta does
not change along that whole side.

Where a box of attachments meets the pulley or its axis, lengths have no derivative everywhere in it. Then lengths alone
are bounded, over what of the box is outside the pulley, and the derivatives are given as exactly zero: a preconditioner
built from them leaves such a cable out. Where the whole box is inside the pulley there is no length, and a squared one
is given that no measurement has.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics import interval as iv

Array = NDArray[np.float64]

NOWHERE = 1e150
"""Squared length, over that of the longest cable, of a cable that has none [1]."""

OFF_AXIS = 1e-9
"""Distance from a swivel axis over that along it below which the plane of the pulley is open [1]."""

WHOLE = 2.0 * math.pi * (1.0 + 2.0**-50)
"""More than a whole turn, the most there is to wrap [rad]."""

SLIP = 2.0**-48
"""Rounding of a wrapped angle, 32 units in the last place of one, where the free length is not [rad]."""


@njit(cache=True)
def enclose(
    low: Array, high: Array, anchors: Array, axes: Array, radii: Array, local: Array, squares: Array, slopes: Array
) -> None:
    """Bounds over a box: squared lengths (m, 2) and their derivatives (m, 6, 2).

    Args:
        low: (6,).
        high: (6,).
        anchors: (m, 3).
        axes: Unit swivel axes (m, 3).
        radii: Of the pulleys (m,).
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
    turns = (ex, ex2, ey, ey2, -sb2, -sb, cc, cc2, sc, sc2)
    for i in range(anchors.shape[0]):
        bx, by, bz = local[i, 0], local[i, 1], local[i, 2]
        # b turned by Rx(a), then Ry(b), then Rz(c).
        y, y2 = _turned(by, by, -bz, -bz, ca, ca2, sa, sa2)
        z, z2 = _turned(bz, bz, by, by, ca, ca2, sa, sa2)
        x, x2 = _turned(bx, bx, z, z2, cb, cb2, sb, sb2)
        rz, rz2 = _turned(z, z2, -bx, -bx, cb, cb2, sb, sb2)
        rx, rx2 = _turned(x, x2, -y2, -y, cc, cc2, sc, sc2)
        ry, ry2 = _turned(y, y2, x, x2, cc, cc2, sc, sc2)
        arm = (rx, rx2, ry, ry2, rz, rz2)
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
        # In a turn dr = w x r, and v . dr = g . dr with g = A - p, which holds the turn once less.
        _turning(-2.0, turns, arm, gx, gx2, gy, gy2, gz, gz2, False, slopes[i])
        if radii[i] != 0.0:
            _over_pulley(radii[i], axes[i], turns, arm, -vx2, -vx, -vy2, -vy, -vz2, -vz, squares[i], slopes[i])


@njit(cache=True)
def _turning(
    factor: float,
    turns: tuple[float, ...],
    arm: tuple[float, ...],
    gx: float,
    gx2: float,
    gy: float,
    gy2: float,
    gz: float,
    gz2: float,
    more: bool,
    slope: Array,
) -> None:
    """Write, or add if ``more``, bounds of ``factor g . (w x r)`` for the three turns to a cable's slopes (6, 2)."""
    ex, ex2, ey, ey2, ez, ez2, cc, cc2, sc, sc2 = turns
    rx, rx2, ry, ry2, rz, rz2 = arm
    # About z.
    p, p2 = _difference(gy, gy2, rx, rx2, gx, gx2, ry, ry2)
    _put(factor, p, p2, more, slope[5])
    # About (-sin c, cos c, 0): dr = (cc rz, sc rz, -(sc ry + cc rx)).
    p, p2 = _sum(gx, gx2, cc, cc2, gy, gy2, sc, sc2)
    p, p2 = iv.mul(p, p2, rz, rz2)
    q, q2 = _sum(sc, sc2, ry, ry2, cc, cc2, rx, rx2)
    q, q2 = iv.mul(q, q2, gz, gz2)
    p, p2 = iv.sub(p, p2, q, q2)
    _put(factor, p, p2, more, slope[4])
    # About e: g . (e x r) = e . (r x g).
    q, q2 = _difference(ry, ry2, gz, gz2, rz, rz2, gy, gy2)
    p, p2 = iv.mul(ex, ex2, q, q2)
    q, q2 = _difference(rz, rz2, gx, gx2, rx, rx2, gz, gz2)
    q, q2 = iv.mul(ey, ey2, q, q2)
    p, p2 = iv.add(p, p2, q, q2)
    q, q2 = _difference(rx, rx2, gy, gy2, ry, ry2, gx, gx2)
    q, q2 = iv.mul(ez, ez2, q, q2)
    p, p2 = iv.add(p, p2, q, q2)
    _put(factor, p, p2, more, slope[3])


@njit(cache=True)
def _put(factor: float, low: float, high: float, more: bool, out: Array) -> None:
    """Write, or add if ``more``, a power of two times an interval."""
    low, high = min(factor * low, factor * high), max(factor * low, factor * high)
    if more:
        low, high = iv.add(out[0], out[1], low, high)
    out[0], out[1] = low, high


@njit(cache=True)
def _over_pulley(
    radius: float,
    axis: Array,
    turns: tuple[float, ...],
    arm: tuple[float, ...],
    x: float,
    x2: float,
    y: float,
    y2: float,
    z: float,
    z2: float,
    square: Array,
    slope: Array,
) -> None:
    """Add to the bounds of one straight cable what its pulley changes; ``B - A`` is given."""
    h, h2 = _along(axis, x, x2, y, y2, z, z2)
    # Beside the axis: w = v - h e, each component with h written out, so that no part of v stands in it twice.
    wx, wx2 = _beside(axis, 0, x, x2, y, y2, z, z2)
    wy, wy2 = _beside(axis, 1, x, x2, y, y2, z, z2)
    wz, wz2 = _beside(axis, 2, x, x2, y, y2, z, z2)
    p, p2 = iv.sqr(wx, wx2)
    q, q2 = iv.sqr(wy, wy2)
    r, r2 = iv.sqr(wz, wz2)
    p, p2 = iv.add(p, p2, q, q2)
    p, p2 = iv.add(p, p2, r, r2)
    rho, rho2 = iv.sqrt(p, p2)
    free, free2 = _free_square(radius, h, h2, rho, rho2)
    wrap, wrap2 = 0.0, WHOLE
    clear = False
    if free > 0.0:
        wrap, wrap2, clear = _wraps(radius, h, h2, rho, rho2)
        clear &= rho > OFF_AXIS * max(abs(h), abs(h2))
    if free2 < 0.0:
        square[0] = square[1] = NOWHERE
    else:
        least, most = iv.sqrt(free, free2)
        if not free > 0.0:
            wrap, wrap2 = _touching(radius, h, h2, rho, rho2, most)
        square[0] = iv.down(square[0] + max(_excess(radius, wrap, least, False), 0.0))
        square[1] = iv.up(square[1] + _excess(radius, wrap2, most, True))
    if not clear:
        slope[:] = 0.0
        return
    kn, kn2, ke, ke2 = _pull(radius, wrap, wrap2)
    p, p2 = iv.div(kn, kn2, rho, rho2)
    kx, kx2 = _sum(p, p2, wx, wx2, ke, ke2, axis[0], axis[0])
    ky, ky2 = _sum(p, p2, wy, wy2, ke, ke2, axis[1], axis[1])
    kz, kz2 = _sum(p, p2, wz, wz2, ke, ke2, axis[2], axis[2])
    _put(2.0, kx, kx2, True, slope[0])
    _put(2.0, ky, ky2, True, slope[1])
    _put(2.0, kz, kz2, True, slope[2])
    _turning(2.0, turns, arm, kx, kx2, ky, ky2, kz, kz2, True, slope)


@njit(cache=True)
def _along(axis: Array, x: float, x2: float, y: float, y2: float, z: float, z2: float) -> tuple[float, float]:
    """``v . e``."""
    p, p2 = iv.scale(axis[0], x, x2)
    q, q2 = iv.scale(axis[1], y, y2)
    r, r2 = iv.scale(axis[2], z, z2)
    p, p2 = iv.add(p, p2, q, q2)
    return iv.add(p, p2, r, r2)


@njit(cache=True)
def _beside(axis: Array, k: int, x: float, x2: float, y: float, y2: float, z: float, z2: float) -> tuple[float, float]:
    """Component k of ``v - (v . e) e``; the coefficients are those of the stored axis to rounding."""
    room = 2.0**-51 * max(max(abs(x), abs(x2)), max(max(abs(y), abs(y2)), max(abs(z), abs(z2))))
    p, p2 = iv.scale((1.0 if k == 0 else 0.0) - axis[k] * axis[0], x, x2)
    q, q2 = iv.scale((1.0 if k == 1 else 0.0) - axis[k] * axis[1], y, y2)
    r, r2 = iv.scale((1.0 if k == 2 else 0.0) - axis[k] * axis[2], z, z2)
    p, p2 = iv.add(p, p2, q, q2)
    p, p2 = iv.add(p, p2, r, r2)
    return iv.down(p - room), iv.up(p2 + room)


@njit(cache=True)
def _free_square(radius: float, h: float, h2: float, rho: float, rho2: float) -> tuple[float, float]:
    """``(rho - rad)^2 - rad^2 + h^2``, not above zero inside the pulley."""
    p, p2 = iv.sub(rho, rho2, radius, radius)
    p, p2 = iv.sqr(p, p2)
    q, q2 = iv.sqr(h, h2)
    p, p2 = iv.add(p, p2, q, q2)
    q, q2 = iv.sqr(radius, radius)
    return iv.sub(p, p2, q, q2)


@njit(cache=True)
def _wraps(radius: float, h: float, h2: float, rho: float, rho2: float) -> tuple[float, float, bool]:
    """Least and greatest wrapped angle over a rectangle clear of the pulley, from its corners, and whether known."""
    least, most = math.inf, -math.inf
    for corner in range(4):
        on = h if corner % 2 == 0 else h2
        out = rho if corner < 2 else rho2
        square = out * (out - 2.0 * radius) + on * on
        if not square > 0.0:
            return 0.0, WHOLE, False
        free, beside = math.sqrt(square), out - radius
        wrap = math.atan2(free * beside + radius * on, free * on - radius * beside)
        if wrap < 0.0:
            wrap += 2.0 * math.pi
        # The square is off by its rounding, the free length by that over twice itself, the angle by that over the
        # distance from the pulley's centre.
        terms = abs(out * (out - 2.0 * radius)) + on * on
        slip = SLIP * (8.0 + terms / (free * math.sqrt(square + radius * radius)))
        if wrap > 2.0 * math.pi - slip:
            if on < 0.0:
                return 0.0, WHOLE, False
            wrap = 0.0  # on the axis and ahead nothing is wrapped, whatever rounding says
        least, most = min(least, wrap - slip), max(most, wrap + slip)
    return max(least, 0.0), most, True


@njit(cache=True)
def _touching(radius: float, h: float, h2: float, rho: float, rho2: float, free: float) -> tuple[float, float]:
    """Least and greatest wrapped angle over what of a rectangle is outside the pulley, its free length at most given.

    Seen from the pulley's centre an attachment stands ``atan(f / rad)`` beyond where the cable leaves the pulley. Where
    the rectangle meets the line from the centre to A, where angles begin and end, any angle is possible.
    """
    if not (h > 0.0 or h2 < 0.0 or rho > radius):
        return 0.0, WHOLE
    least, most = math.inf, -math.inf
    for corner in range(4):
        on = h if corner % 2 == 0 else h2
        out = rho if corner < 2 else rho2
        angle = math.atan2(on, radius - out)
        if angle < 0.0:
            angle += 2.0 * math.pi
        least, most = min(least, angle), max(most, angle)
    beyond = math.atan(free / radius)
    return max(least - beyond - 8.0 * SLIP, 0.0), min(most + 8.0 * SLIP, WHOLE)


@njit(cache=True)
def _excess(radius: float, wrap: float, free: float, above: bool) -> float:
    """A bound of ``rad^2 (beta^2 - 2 + 2 cos beta) + 2 rad f (beta - sin beta)``, which grows with both."""
    p, p2 = iv.sqr(wrap, wrap)
    q, q2 = iv.cos(wrap, wrap)
    p, p2 = iv.add(p, p2, 2.0 * q, 2.0 * q2)
    p, p2 = iv.sub(p, p2, 2.0, 2.0)
    p, p2 = iv.scale(radius, p, p2)
    q, q2 = iv.sin(wrap, wrap)
    q, q2 = iv.sub(wrap, wrap, q, q2)
    q, q2 = iv.scale(2.0 * free, q, q2)
    p, p2 = iv.add(p, p2, q, q2)
    p, p2 = iv.scale(radius, p, p2)
    return p2 if above else p


@njit(cache=True)
def _pull(radius: float, wrap: float, wrap2: float) -> tuple[float, float, float, float]:
    """``rad (beta sin beta + cos beta - 1)`` and ``rad (beta cos beta - sin beta)`` over a range of angles."""
    c, c2 = iv.cos(wrap, wrap2)
    s, s2 = iv.sin(wrap, wrap2)
    p, p2 = iv.mul(wrap, wrap2, s, s2)
    p, p2 = iv.add(p, p2, c, c2)
    p, p2 = iv.sub(p, p2, 1.0, 1.0)
    p, p2 = iv.scale(radius, p, p2)
    q, q2 = iv.mul(wrap, wrap2, c, c2)
    q, q2 = iv.sub(q, q2, s, s2)
    q, q2 = iv.scale(radius, q, q2)
    return p, p2, q, q2


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
