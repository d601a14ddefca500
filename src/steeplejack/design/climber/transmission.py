"""Motion/force transmission of the 3-RPR mechanism: output index of each limb and the local index, in closed form.

With two limbs locked the platform turns about the point C where their lines meet, so the joint of the third moves
across ``P_i - C`` and

    OTI_i = |n_i . v_i| / |v_i| = |n_i x (P_i - C)| / |P_i - C|.

The input index is identically 1: the actuated joint is the prismatic one, on the line of the force it transmits
(``S_Ti o S_Hi = n_i . n_i``). Hence ``LTI = min_i OTI_i`` (Ye et al., Robotica 2024, Eq. 28-30).

In the frame of the moving body, whose joints lie on its x axis at ``g_i``, let ``d_i = (a_i, h_i)`` be the limbs and

    s_i = (a_k h_j (g_j - g_i) - a_j h_k (g_k - g_i), h_j h_k (g_j - g_k)),   (i, j, k) cyclic,

which is ``(P_i - C)`` times ``d_j x d_k``. It is finite where the two lines are parallel and the platform translates.
The product ``D = d_i x s_i`` is the same for all three and is ``q1 q2 q3 det J``, so with one division and one root

    LTI = |D| / max_i (|d_i| |s_i|).

The index is not one of the configuration alone: the characteristic point is a joint of the *moving* body. Fixing the
platform and moving the base gives other velocities, ``|B_i - C|``, and another value; the paper says it does not. At
(20 mm, 150 mm, 0) the original dimensions have 0.5681 with the platform moving and 0.5280 with the base.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber import Layout

Array = NDArray[np.float64]
Moving = Literal["platform", "base"]


def output_transmission(layout: Layout, poses: ArrayLike, moving: Moving = "platform") -> Array:
    """Output transmission index of each limb, OTI_i (Eq. 29).

    Args:
        layout: Hinges.
        poses: (x, w, alpha) of O2, (..., 3) [m, m, rad].
        moving: Which body's joints are the characteristic points.

    Returns:
        (..., 3) [1]; 0 at singular poses, also where ``v_i`` vanishes and the quotient is 0/0 or a limb has no length;
        NaN where a pose is not finite.

    Raises:
        InputError: Not (..., 3) numbers.
    """
    given = _poses(poses)
    indices = np.empty((given.size // 3, 3))
    _output(given.reshape(-1, 3), layout.base, layout.platform, moving == "platform", indices)
    return indices.reshape(given.shape)


def local_transmission(layout: Layout, poses: ArrayLike, moving: Moving = "platform") -> Array:
    """Local transmission index, the least of the output indices (Eq. 30): arguments of `output_transmission`.

    Returns:
        (...,) [1].
    """
    return output_transmission(layout, poses, moving).min(axis=-1)


def transmission_grid(
    layout: Layout, x: ArrayLike, w: ArrayLike, alpha: float = 0.0, moving: Moving = "platform"
) -> Array:
    """Local transmission index over a grid at one orientation, of limits regardless.

    Args:
        layout: Hinges.
        x: (m,) [m].
        w: (n,) [m].
        alpha: Orientation of the platform [rad].
        moving: Which body's joints are the characteristic points.

    Returns:
        (n, m) [1], as `local_transmission`.
    """
    across, along = (np.ascontiguousarray(axis, dtype=np.float64) for axis in (x, w))
    values = np.empty((along.size, across.size))
    grid_values(across, along, float(alpha), layout.base, layout.platform, moving == "platform", values)
    return values


def _poses(poses: ArrayLike) -> Array:
    given = np.asarray(poses)
    if given.dtype.kind not in "fiu" or given.ndim == 0 or given.shape[-1] != 3:
        raise InputError("poses", f"shape {given.shape} of {given.dtype}", "(..., 3) real numbers")
    return np.ascontiguousarray(given, dtype=np.float64)


@njit(cache=True, error_model="numpy")
def row(
    w: float, cos: float, sin: float, base: Array, platform: Array, platform_moves: bool
) -> tuple[float, float, float, float, float, float, float, float, float, float, float]:
    """Limbs in the frame of the moving body along a line of constant w: ``d_i = (a_i + x a', h_i + x h')``.

    Returns:
        a_1..3, h_1..3 at x = 0, the slopes a' and h', and the moving body's joints g_1..3.
    """
    if platform_moves:
        a, h = -w * sin, w * cos
        return (
            a + platform[0] - base[0] * cos,
            a + platform[1] - base[1] * cos,
            a + platform[2] - base[2] * cos,
            h - base[0] * sin,
            h - base[1] * sin,
            h - base[2] * sin,
            cos,
            sin,
            platform[0],
            platform[1],
            platform[2],
        )
    return (
        platform[0] * cos - base[0],
        platform[1] * cos - base[1],
        platform[2] * cos - base[2],
        w - platform[0] * sin,
        w - platform[1] * sin,
        w - platform[2] * sin,
        1.0,
        0.0,
        base[0],
        base[1],
        base[2],
    )


@njit(cache=True, error_model="numpy")
def squares(
    a1: float, a2: float, a3: float, h1: float, h2: float, h3: float, g1: float, g2: float, g3: float
) -> tuple[float, float, float, float]:
    """``D`` and the three ``|d_i|^2 |s_i|^2`` of a pose; see the module."""
    g12, g23, g31 = g1 - g2, g2 - g3, g3 - g1
    a1h2, a1h3 = a1 * h2, a1 * h3
    a2h1, a2h3 = a2 * h1, a2 * h3
    a3h1, a3h2 = a3 * h1, a3 * h2
    x1, z1 = -a3h2 * g12 - a2h3 * g31, h2 * h3 * g23
    x2, z2 = -a1h3 * g23 - a3h1 * g12, h3 * h1 * g31
    x3, z3 = -a2h1 * g31 - a1h2 * g23, h1 * h2 * g12
    return (
        a1 * z1 - h1 * x1,
        (a1 * a1 + h1 * h1) * (x1 * x1 + z1 * z1),
        (a2 * a2 + h2 * h2) * (x2 * x2 + z2 * z2),
        (a3 * a3 + h3 * h3) * (x3 * x3 + z3 * z3),
    )


@njit(cache=True, error_model="numpy")
def line_values(
    xs: Array, w: float, cos: float, sin: float, base: Array, platform: Array, platform_moves: bool, values: Array
) -> None:
    """Local transmission index along a line of constant w; fills ``values``. Without a branch, so vectorised."""
    a1, a2, a3, h1, h2, h3, da, dh, g1, g2, g3 = row(w, cos, sin, base, platform, platform_moves)
    for k in range(xs.size):
        a, h = xs[k] * da, xs[k] * dh
        product, top1, top2, top3 = squares(a + a1, a + a2, a + a3, h + h1, h + h2, h + h3, g1, g2, g3)
        top = top1 if top1 > top2 else top2
        top = top if top > top3 else top3
        # 0/0 is a singular pose: the least positive number below keeps it 0, and NaN stays NaN.
        values[k] = math.sqrt(product * product / (top + 5e-324))


@njit(cache=True, error_model="numpy")
def grid_values(
    xs: Array, ws: Array, alpha: float, base: Array, platform: Array, platform_moves: bool, values: Array
) -> None:
    """``transmission_grid``; fills ``values``."""
    cos, sin = math.cos(alpha), math.sin(alpha)
    for r in range(ws.size):
        line_values(xs, ws[r], cos, sin, base, platform, platform_moves, values[r])


@njit(cache=True, error_model="numpy")
def _output(poses: Array, base: Array, platform: Array, platform_moves: bool, indices: Array) -> None:
    """``output_transmission`` over (k, 3) poses; fills ``indices``."""
    for k in range(poses.shape[0]):
        x, w, alpha = poses[k, 0], poses[k, 1], poses[k, 2]
        a1, a2, a3, h1, h2, h3, da, dh, g1, g2, g3 = row(
            w, math.cos(alpha), math.sin(alpha), base, platform, platform_moves
        )
        a, h = x * da, x * dh
        product, top1, top2, top3 = squares(a + a1, a + a2, a + a3, h + h1, h + h2, h + h3, g1, g2, g3)
        # Rounding can lift a quotient that is 1 above it.
        indices[k, 0] = _quotient(product, top1)
        indices[k, 1] = _quotient(product, top2)
        indices[k, 2] = _quotient(product, top3)


@njit(cache=True, error_model="numpy")
def _quotient(product: float, top: float) -> float:
    """``|D| / sqrt(top)``, 0 where both vanish, at most 1."""
    if top == 0.0:
        return 0.0
    value = abs(product) / math.sqrt(top)
    return 1.0 if value > 1.0 else value
