"""det J over the poses of one alpha that the actuators reach: its least size, its signs, and the singular curve.

At one alpha every limb keeps O2 in a ring about ``(b_i - p_i cos a, p_i sin a)``, so a line of constant w meets the
reachable set in at most four intervals of x, known exactly. Rows of them are looked at, each with its ends; then the
best place is searched again on ever finer rows about it. w > 0, the side the robot is built on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import InfeasibleError, InputError
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.poses import Array
from steeplejack.robots.pipe_climber.singularity import determinant, singular_x

ROWS_PER_METRE = 1000
"""Rows in w that the singular curve is given at: the integer millimetres [1/m]."""

ROWS, NODES, ZOOMS = 257, 33, 12


@dataclass(frozen=True)
class SingularSlice:
    """What the actuators reach at one alpha, seen from the singular surface.

    Attributes:
        curve: Rows (w, x) of the surface at every millimetre of w of the reachable set, x where it is, inside the set
            or not, (n, 2) [m]; empty at alpha = 0, where it is w = 0.
        least: Least |det J| over the reachable set, 0 where the curve lies in it [m].
        least_at: (x, w) where the least was found [m].
        signs: Signs that det J takes over the set, -1, 1 or both.
        crossings: How many separate stretches of the curve the rows find in the set.
    """

    curve: Array
    least: float
    least_at: tuple[float, float]
    signs: tuple[int, ...]
    crossings: int


def singular_slice(layout: Layout, alpha: float) -> SingularSlice:
    """Least |det J|, signs of det J and the singular curve at one alpha.

    Args:
        layout: Hinges and reach; the hinges' own limits are not asked.
        alpha: [rad].

    Returns:
        The slice; its least is that of the rows, refined to a relative 1e-6 or better where |det J| is smooth.

    Raises:
        InputError: An angle that is not finite.
        InfeasibleError: No pose of that alpha within the reach.
    """
    if not math.isfinite(alpha):
        raise InputError("alpha", f"{math.degrees(alpha):g} deg", "a finite angle")
    low, high = _heights(layout, alpha)
    heights = np.linspace(low, high, ROWS)
    poses = _nodes(layout, alpha, heights) if low < high else np.empty((0, 3))
    if not len(poses):
        window = f"{layout.reach[0]:g} to {layout.reach[1]:g} m"
        raise InfeasibleError(f"a pose with alpha = {math.degrees(alpha):g} deg", f"lengths of all limbs {window}")
    values = determinant(layout, poses)
    signs = tuple(sorted({int(one) for one in np.sign(values)} - {0}))
    best, place = float(np.abs(values).min()), poses[np.abs(values).argmin()]
    step = (high - low) / (ROWS - 1)
    for _ in range(ZOOMS):
        near = np.linspace(max(low, place[1] - step), min(high, place[1] + step), NODES)
        poses = _nodes(layout, alpha, near, (place[0], 8.0 * step))
        step *= 4.0 / NODES
        sizes = np.abs(determinant(layout, poses))
        if len(poses) and sizes.min() < best:
            best, place = float(sizes.min()), poses[sizes.argmin()]
    numbers = np.arange(math.ceil(low * ROWS_PER_METRE), math.floor(high * ROWS_PER_METRE) + 1, dtype=np.float64)
    rows = numbers / ROWS_PER_METRE
    rows = rows[[bool(reachable_x(layout, alpha, w)) for w in rows.tolist()]]
    x = singular_x(layout, rows, alpha)
    curve = np.asarray(np.stack((rows, x), axis=-1)[np.isfinite(x)], dtype=np.float64)
    inside = _curve_inside(layout, alpha, heights)
    if inside.any():
        w = heights[inside][0]
        best, place = 0.0, np.array([singular_x(layout, w, alpha), w])
    stretches = int(np.count_nonzero(np.diff(inside.astype(np.int8), prepend=0) == 1))
    return SingularSlice(curve, best, (float(place[0]), float(place[1])), signs, stretches)


def reachable_x(layout: Layout, alpha: float, w: float) -> list[tuple[float, float]]:
    """Intervals of x that the actuators reach at one w and alpha, in order, at most four [m]."""
    least, largest = layout.reach
    centres = layout.base - layout.platform * math.cos(alpha)
    heights = w - layout.platform * math.sin(alpha)
    if np.abs(heights).max() > largest:
        return []
    outer = np.sqrt(largest**2 - heights**2)
    pieces = [(float((centres - outer).max()), float((centres + outer).min()))]
    for centre, height in zip(centres.tolist(), heights.tolist(), strict=True):
        if abs(height) < least:
            inner = math.sqrt(least**2 - height**2)
            left, right = centre - inner, centre + inner
            pieces = [part for low, high in pieces for part in ((low, min(high, left)), (max(low, right), high))]
    return sorted({(low, high) for low, high in pieces if low <= high})


def _heights(layout: Layout, alpha: float) -> tuple[float, float]:
    """Least and largest w that any limb's reach allows, above 0 [m]."""
    sides = layout.platform * math.sin(alpha)
    return max(float(sides.max()) - layout.reach[1], 1e-9), float(sides.min()) + layout.reach[1]


def _nodes(layout: Layout, alpha: float, heights: Array, about: tuple[float, float] | None = None) -> Array:
    """Reachable poses on rows of w, ends of every interval included, (k, 3); about an x if one is given."""
    rows: list[Array] = []
    for w in heights.tolist():
        for low, high in reachable_x(layout, alpha, w):
            if about is not None:
                low, high = max(low, about[0] - about[1]), min(high, about[0] + about[1])
            if low <= high:
                x = np.linspace(low, high, NODES)
                rows.append(np.stack((x, np.full(NODES, w), np.full(NODES, alpha)), axis=-1))
    return np.concatenate(rows) if rows else np.empty((0, 3))


def _curve_inside(layout: Layout, alpha: float, heights: Array) -> NDArray[np.bool_]:
    """On which rows the singular curve lies inside the reachable set."""
    places = singular_x(layout, heights, alpha)
    inside = [
        any(low <= x <= high for low, high in reachable_x(layout, alpha, w))
        for w, x in zip(heights.tolist(), places.tolist(), strict=True)
    ]
    return np.array(inside, dtype=np.bool_)
