"""Which poses the 3-RPR mechanism can take: limits of a layout as the arrays that kernels read, and the test itself.

A pose (x, w, alpha) is reached if w > 0, every limb is as long as its cylinder allows, every hinge is within its limit,
and ``det J`` has the sign it has with parallel platforms: the robot cannot pass the singular surface, so what lies
beyond is another assembly mode. Within 30 degrees of the original dimensions that last condition never binds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.design.climber.transmission import squares
from steeplejack.robots.pipe_climber import Layout
from steeplejack.robots.pipe_climber.inverse import hinge_angles
from steeplejack.robots.pipe_climber.singularity import is_degenerate

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Turn = tuple[float, float, float]
Arrays = tuple[Array, Array, Array, Array]


@dataclass(frozen=True, eq=False)
class Limits:
    """Hinges and limits of a layout, flat.

    Attributes:
        base: ``b_i``, (3,) [m].
        platform: ``p_i``, (3,) [m].
        bounds: Least and largest length [m], joint limit [rad] or infinity, sign of the working mode (0 for either).
        neutral: Angle from which each hinge counts, (3 limbs, 2 ends: base, platform) [rad].
    """

    base: Array
    platform: Array
    bounds: Array
    neutral: Array

    @classmethod
    def of(cls, layout: Layout) -> Limits:
        """Limits of a layout in its working mode."""
        limited = layout.neutral != "none" and layout.joint_limit < math.pi
        neutral = np.zeros((3, 2))
        if layout.neutral == "home":
            neutral = np.ascontiguousarray(hinge_angles(layout, layout.home))
        bounds = np.array([*layout.reach, layout.joint_limit if limited else np.inf, working_sign(layout)])
        return cls(layout.base, layout.platform, bounds, neutral)

    @property
    def arrays(self) -> Arrays:
        """What kernels take after the pose."""
        return self.base, self.platform, self.bounds, self.neutral

    def without_hinges(self) -> Limits:
        """The same with hinges that turn freely."""
        bounds = self.bounds.copy()
        bounds[2] = np.inf
        return replace(self, bounds=bounds)

    def either_mode(self) -> Limits:
        """The same on both sides of the singular surface."""
        bounds = self.bounds.copy()
        bounds[3] = 0.0
        return replace(self, bounds=bounds)


def working_sign(layout: Layout) -> float:
    """Sign of ``q1 q2 q3 det J`` with parallel platforms: of ``-K w^2``, K = L3(L2-L4)+L1L4 or L1(L2-L4)+L3L4.

    Returns:
        -1, 1, or NaN where K = 0: such a mechanism is singular wherever its platforms are parallel.
    """
    if is_degenerate(layout):
        return math.nan
    return math.copysign(1.0, determinant(0.0, 1.0, 1.0, 0.0, layout.base, layout.platform))


@njit(cache=True, error_model="numpy")
def determinant(x: float, w: float, cos: float, sin: float, base: Array, platform: Array) -> float:
    """``q1 q2 q3 det J`` of a pose: linear in x [m4]."""
    product, _, _, _ = squares(
        x + platform[0] * cos - base[0],
        x + platform[1] * cos - base[1],
        x + platform[2] * cos - base[2],
        w - platform[0] * sin,
        w - platform[1] * sin,
        w - platform[2] * sin,
        base[0],
        base[1],
        base[2],
    )
    return product


@njit(cache=True, error_model="numpy")
def holds(x: float, w: float, turn: Turn, limits: Arrays) -> bool:
    """Whether the mechanism can take a pose; bounds included, the singular surface not.

    Args:
        x: [m].
        w: [m].
        turn: alpha [rad], its cosine and its sine.
        limits: `Limits.arrays`.
    """
    (alpha, cos, sin), (base, platform, bounds, neutral) = turn, limits
    if not w > 0.0:
        return False
    least, largest = bounds[0] * bounds[0], bounds[1] * bounds[1]
    for i in range(3):
        u, v = x + platform[i] * cos - base[i], w - platform[i] * sin
        square = u * u + v * v
        if not (least <= square <= largest):
            return False
    if bounds[2] < math.pi:
        for i in range(3):
            theta = math.atan2(x + platform[i] * cos - base[i], w - platform[i] * sin)
            at_base, at_platform = theta - neutral[i, 0], theta - alpha - neutral[i, 1]
            if abs(turned(at_base)) > bounds[2] or abs(turned(at_platform)) > bounds[2]:
                return False
    if bounds[3] == 0.0:
        return True
    return bounds[3] * determinant(x, w, cos, sin, base, platform) > 0.0


@njit(cache=True)
def turned(angle: float) -> float:
    """An angle in [-pi, pi]."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


@njit(cache=True, error_model="numpy")
def holds_grid(xs: Array, ws: Array, alpha: float, limits: Arrays, inside: Flags) -> None:
    """``holds`` over a grid at one orientation; fills ``inside``, (n of w, m of x)."""
    turn = (alpha, math.cos(alpha), math.sin(alpha))
    for r in range(ws.size):
        for k in range(xs.size):
            inside[r, k] = holds(xs[k], ws[r], turn, limits)
