"""Forward kinematics of the 3-RPR mechanism: every real pose of three lengths, in one pass and in a fixed order.

With ``R = x^2 + w^2`` and ``v = x cos a - w sin a`` the squared lengths are linear in ``(R, v, x)``,

    q_i^2 = R + 2 p_i v - 2 b_i x + p_i^2 + b_i^2 - 2 p_i b_i cos a,

so these three are affine in ``c = cos a``, and eliminating w and sin a leaves a cubic,

    f(c) = R (1 - c^2) - x^2 - v^2 + 2 x v c = 0.

Hence degree 6 in tan(a/2); the 12 of Ye et al. (Robotica 2024, Eq. 13) is that sextic times ``(1 + u^2)^3``. As
``f(1) = -(x - v)^2`` and ``f(-1) = -(x + v)^2``, the cubic has no root or two in [-1, 1]: there are 0 or 4 real
solutions, never 6, each c giving a pose and its mirror image ``(x, -w, -a)``. Moreover
``det J = K f'(c) / (2 q1 q2 q3)`` with ``K = (q1 q2 q3 det J) / -w^2`` at a = 0, so the greater root is always the pose
on the side of the singular surface where the home pose is.

Roots are bracketed by the local maximum of f and the ends, so neither a = 0 nor 180 degrees, where Eq. 12 is 0/0,
needs luck; there w comes from ``w^2 = R - x^2``. Every pose is polished on the three lengths by Newton's method, which
is quadratic up to the singular surface. Where the maximum is zero within rounding, two pairs merge on that surface:
the status says so, and `certificate` decides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.modes import MODES, Mode
from steeplejack.robots.pipe_climber.poses import Array, triples
from steeplejack.robots.pipe_climber.singularity import is_degenerate

UNDECIDABLE = 16.0 * 2.0**-52
"""Rounding of the cubic's maximum, in parts of its terms: below it the number of solutions is not known [1]."""

SMALL_SINE = 1e-3
"""Below it w comes from w^2 = R - x^2 instead of from a quotient by sin a [1]."""

SETTLED = 2.0**-27
"""A Newton step this small is the last: convergence is quadratic, so what remains is rounding [1]."""


class ForwardStatus(IntEnum):
    """What is known about the number of real solutions."""

    NONE = 0
    """No pose has these lengths: the limbs do not close."""
    FOUR = 4
    """Four poses, one in each mode."""
    UNDECIDED = -1
    """On the singular surface within rounding: two pairs merge, or miss each other by less than can be told."""
    INVALID = -2
    """A length is not a finite number above 0."""


@dataclass(frozen=True)
class ForwardSolutions:
    """Every real pose of given limb lengths.

    Attributes:
        poses: (..., 4 modes, 3) as (x, w, alpha) [m, m, rad], in the order of `MODES`; NaN where there is none.
        status: (...) of `ForwardStatus`.
    """

    poses: Array
    status: NDArray[np.int8]

    @property
    def count(self) -> NDArray[np.int64]:
        """Number of poses found (...), 0 or 4."""
        return np.isfinite(self.poses[..., 0]).sum(axis=-1)

    def of(self, mode: Mode) -> Array:
        """The pose in one mode, (..., 3) [m, m, rad]; NaN where there is none."""
        return self.poses[..., MODES.index(mode), :]


def forward_kinematics(layout: Layout, lengths: ArrayLike) -> ForwardSolutions:
    """Every real pose of three limb lengths; the one in mode "home" is the robot's.

    Args:
        layout: Hinges. Its limits are not asked: every pose the limbs close at is an answer.
        lengths: q_1 to q_3, (..., 3) [m].

    Returns:
        Poses and what is known about their number. Lengths out of reach have no poses, and that is no error.

    Raises:
        InputError: Not (..., 3) numbers, or a mechanism that is singular whenever its platforms are parallel.
    """
    given = triples("lengths", lengths)
    b2, b3, l2, l4, unit = _scaled(layout)
    poses = np.empty((given.size // 3, 4, 3))
    status = np.empty(given.size // 3, dtype=np.int8)
    _solve(np.ascontiguousarray(given).reshape(-1, 3), b2, b3, l2, l4, unit, poses, status)
    return ForwardSolutions(poses.reshape(*given.shape[:-1], 4, 3), status.reshape(given.shape[:-1]))


def home_determinant(layout: Layout) -> float:
    """``K`` of ``det J = -K w^2 / (q1 q2 q3)`` at alpha = 0: L3 (L2 - L4) + L1 L4 (text) [m2]."""
    (_, b2, b3), (l4, _, l2) = -layout.base, -layout.platform
    return float(b2 * (l2 - l4) + b3 * l4)


def _scaled(layout: Layout) -> tuple[float, float, float, float, float]:
    """``-b_2, -b_3, L2, L4`` in parts of the longest, and that length [m].

    Raises:
        InputError: K = 0.
    """
    unit = max(layout.lengths)
    (_, b2, b3), (l4, _, l2) = -layout.base / unit, -layout.platform / unit
    if is_degenerate(layout):
        valid = "joints in unlike proportions on base and platform, else every pose with alpha = 0 is singular"
        raise InputError("dimensions", f"{list(layout.lengths)} m", valid)
    return float(b2), float(b3), float(l2), float(l4), unit


@njit(cache=True, error_model="numpy")
def _solve(
    lengths: Array, b2: float, b3: float, l2: float, l4: float, unit: float, poses: Array, status: NDArray[np.int8]
) -> None:
    """`forward_kinematics` over (k, 3) lengths; fills poses and status. Dimensions in parts of ``unit`` [m]."""
    per_k = 1.0 / (b2 * (l2 - l4) + b3 * l4)
    per_unit = 1.0 / unit
    slope_r = -2.0 * b2 * b3 * l2 * l4 * per_k
    half_b2, half_l4 = 0.5 / b2, 0.5 / l4
    slope_x, slope_v = -slope_r * half_b2, slope_r * half_l4
    for k in range(lengths.shape[0]):
        for mode in range(4):
            for axis in range(3):
                poses[k, mode, axis] = math.nan
        q1, q2, q3 = lengths[k, 0] * per_unit, lengths[k, 1] * per_unit, lengths[k, 2] * per_unit
        if not (0.0 < q1 < math.inf and 0.0 < q2 < math.inf and 0.0 < q3 < math.inf):
            status[k] = -2
            continue
        s1, s2, s3 = q1 * q1, q2 * q2, q3 * q3
        g1, g2, g3 = s1 - l4 * l4, s2 - b2 * b2, s3 - l2 * l2 - b3 * b3
        r0 = (l2 * b2 * g1 + b3 * l4 * g2 - l4 * b2 * g3) * per_k
        x0, v0 = (g2 - r0) * half_b2, (r0 - g1) * half_l4
        # f(c) = a3 c^3 + a2 c^2 + a1 c + a0
        a3 = 2.0 * slope_x * slope_v - slope_r
        a2 = 2.0 * (x0 * slope_v + slope_x * v0) - r0 - slope_x * slope_x - slope_v * slope_v
        a1 = slope_r + 2.0 * (x0 * v0 - x0 * slope_x - v0 * slope_v)
        a0 = r0 - x0 * x0 - v0 * v0
        top = _maximum(a3, a2, a1)
        height = ((a3 * top + a2) * top + a1) * top + a0
        # What rounding may have added: r0, x0 and v0 are differences of terms of sizes h1 to h3.
        h1, h2, h3 = s1 + l4 * l4, s2 + b2 * b2, s3 + l2 * l2 + b3 * b3
        size_r = (l2 * b2 * h1 + b3 * l4 * h2 + l4 * b2 * h3) * abs(per_k) + abs(slope_r)
        spread = (h1 + size_r) * half_l4 + (h2 + size_r) * half_b2
        size = size_r + 2.0 * spread * (abs(x0) + abs(v0) + abs(slope_x) + abs(slope_v))
        if not abs(height) > UNDECIDABLE * size:
            status[k] = -1
        else:
            status[k] = 4 if height > 0.0 else 0
        if not height > 0.0:
            continue
        bend = -(3.0 * a3 * top + a2)
        for mode in range(2):
            c = top + _offset(height, bend, a3, 1.0 - top if mode == 0 else -1.0 - top)
            x, v, r = x0 + slope_x * c, v0 + slope_v * c, r0 + slope_r * c
            x, w, alpha = _polished(x, v, r, c, s1, s2, s3, b2, b3, l2, l4)
            poses[k, mode, 0], poses[k, mode, 1], poses[k, mode, 2] = x * unit, w * unit, alpha + 0.0
            poses[k, mode + 2, 0], poses[k, mode + 2, 1], poses[k, mode + 2, 2] = x * unit, 0.0 - w * unit, 0.0 - alpha


@njit(cache=True, error_model="numpy")
def _maximum(a3: float, a2: float, a1: float) -> float:
    """Where the cubic is greatest inside [-1, 1]: its local maximum, or the end nearer to it."""
    inside = a2 * a2 - 3.0 * a3 * a1
    if inside <= 0.0:
        return 1.0 if a1 > 0.0 else -1.0  # monotone: no root strictly inside
    root = math.sqrt(inside)
    # There f'' = 6 a3 c + 2 a2 = -2 root; of the two forms of the quotient, the one without cancellation.
    top = a1 / (root - a2) if a2 < 0.0 else -(a2 + root) / (3.0 * a3)
    return min(max(top, -1.0), 1.0)


@njit(cache=True, error_model="numpy")
def _offset(height: float, bend: float, a3: float, end: float) -> float:
    """The root t between 0 and ``end`` of ``height - bend t^2 + a3 t^3``, the cubic seen from its maximum."""
    side = 1.0 if end > 0.0 else -1.0
    inner, outer = 0.0, abs(end)
    lean = side * a3
    t = math.sqrt(height / bend) if bend > 0.0 else outer
    t = min(t, outer)
    for _ in range(60):
        value = height - t * t * (bend - lean * t)
        if value > 0.0:
            inner = t
        else:
            outer = t
        after = t - value / (t * (3.0 * lean * t - 2.0 * bend))
        if not inner <= after <= outer:
            after = 0.5 * (inner + outer)
        moved = abs(after - t)
        t = after
        if moved <= SETTLED * t:
            break
    return side * t


@njit(cache=True, error_model="numpy")
def _polished(
    x: float, v: float, r: float, c: float, s1: float, s2: float, s3: float, b2: float, b3: float, l2: float, l4: float
) -> tuple[float, float, float]:
    """The pose with w > 0 of a root, by Newton's method on the squared lengths; never worse than it came."""
    s = math.sqrt(max((1.0 - c) * (1.0 + c), 0.0))
    product = x * c - v  # = w sin a
    w = abs(product) / s if s > SMALL_SINE else math.sqrt(max(r - x * x, 0.0))
    s = math.copysign(s, product)
    least = math.inf
    best_x, best_w, best_c, best_s = x, w, c, s
    for _ in range(5):
        u1, h1 = x - l4 * c, w + l4 * s
        u2, h2 = x + b2, w
        u3, h3 = x + b3 - l2 * c, w + l2 * s
        e1, e2, e3 = u1 * u1 + h1 * h1 - s1, u2 * u2 + h2 * h2 - s2, u3 * u3 + h3 * h3 - s3
        worst = max(abs(e1), max(abs(e2), abs(e3)))
        if not worst < least:
            break
        least, best_x, best_w, best_c, best_s = worst, x, w, c, s
        # Rows (u, h, m) of half the derivative; m_2 = 0 because P_2 is O2.
        m1, m3 = l4 * (s * u1 + c * h1), l2 * (s * u3 + c * h3)
        det = u2 * (h3 * m1 - h1 * m3) + h2 * (u1 * m3 - u3 * m1)
        per = 0.5 / det
        dx = per * (e1 * -h2 * m3 + e2 * (h1 * m3 - h3 * m1) + e3 * h2 * m1)
        dw = per * (e1 * u2 * m3 + e2 * (u3 * m1 - u1 * m3) - e3 * u2 * m1)
        turn = per * (e1 * (h2 * u3 - u2 * h3) + e2 * (u1 * h3 - u3 * h1) + e3 * (u2 * h1 - u1 * h2))
        x, w = x + dx, w + dw
        settled = abs(dx) + abs(dw) + abs(turn) <= SETTLED
        half = 0.5 * turn
        per_norm = 1.0 / (1.0 + half * half)  # the rotation by 2 atan(turn / 2)
        cos_turn, sin_turn = (1.0 - half * half) * per_norm, turn * per_norm
        c, s = c * cos_turn - s * sin_turn, s * cos_turn + c * sin_turn
        if settled:
            best_x, best_w, best_c, best_s = x, w, c, s
            break
    if best_w < 0.0:
        best_w, best_s = -best_w, -best_s
    return best_x, best_w, math.atan2(best_s, best_c)
