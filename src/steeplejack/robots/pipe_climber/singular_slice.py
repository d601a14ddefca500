"""det J over the poses of one alpha that the actuators reach: its least size, its signs, and the singular curve.

At one alpha every limb keeps O2 in a ring about ``(b_i - p_i cos a, p_i sin a)``, so a line of constant w meets the
reachable set in at most four intervals of x, known exactly. Rows of them are looked at, each with its ends; then the
best place is searched again on ever finer rows about it. w > 0, the side the robot is built on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from steeplejack.errors import InfeasibleError, InputError
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.poses import Array
from steeplejack.robots.pipe_climber.singular_cut import cut, level_line, reachable_x
from steeplejack.robots.pipe_climber.singularity import determinant, is_degenerate, singular_x

ROWS_PER_METRE = 1000
"""Rows in w that the singular curve is given at: the integer millimetres [1/m]."""

ROWS, NODES, ZOOMS = 257, 33, 12


@dataclass(frozen=True)
class SingularSlice:
    """What the actuators reach at one alpha, seen from the singular surface.

    Attributes:
        curve: Rows (w, x) of the surface at every millimetre of w of the reachable set, x where it is, inside the set
            or not, (n, 2) [m]; empty at alpha = 0, where it is w = 0. For L1 = L3 or L2 = L4 the line w = -L4 sin a
            besides, within the set.
        least: Least |det J| over the reachable set, 0 where the curve lies in it [m].
        least_at: (x, w) where the least was found [m].
        signs: Signs that det J takes over the set, -1, 1 or both.
        crossings: How many separate stretches of the surface the rows find in the set, counted along w.
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
        InfeasibleError: No pose of that alpha within the reach, or a mechanism with K = 0.
    """
    if not math.isfinite(alpha):
        raise InputError("alpha", f"{math.degrees(alpha):g} deg", "a finite angle")
    if is_degenerate(layout):
        what = f"a singular surface of dimensions {list(layout.lengths)} m"
        raise InfeasibleError(what, "joints in like proportions on base and platform, singular wherever alpha = 0")
    low, high = _heights(layout, alpha)
    heights = np.linspace(low, high, ROWS)
    poses = _nodes(layout, alpha, heights) if low < high else np.empty((0, 3))
    if not len(poses):
        window = f"{layout.reach[0]:g} to {layout.reach[1]:g} m"
        raise InfeasibleError(f"a pose with alpha = {math.degrees(alpha):g} deg", f"lengths of all limbs {window}")
    values = determinant(layout, poses)
    signs = tuple(sorted({int(one) for one in np.sign(values)} - {0}))
    best, place = float(np.abs(values).min()), poses[np.abs(values).argmin()]
    found = cut(layout, alpha, heights)
    singular, stretches = found.place, found.stretches
    step = (high - low) / (ROWS - 1)
    for _ in range(ZOOMS if singular is None else 0):
        near = np.linspace(max(low, place[1] - step), min(high, place[1] + step), NODES)
        poses = _nodes(layout, alpha, near, (place[0], 8.0 * step))
        step *= 4.0 / NODES
        sizes = np.abs(determinant(layout, poses))
        if len(poses) and sizes.min() < best:
            best, place = float(sizes.min()), poses[sizes.argmin()]
        singular = cut(layout, alpha, near).place
        if singular is not None:  # thinner than the rows are apart
            stretches = 1
            break
    at = (float(place[0]), float(place[1])) if singular is None else singular
    least = best if singular is None else 0.0
    return SingularSlice(_curve(layout, alpha, low, high), least, at, signs, stretches)


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


def _curve(layout: Layout, alpha: float, low: float, high: float) -> Array:
    """Rows (w, x) of the surface between two w, those of a line of constant w at every millimetre of x and its ends."""
    numbers = np.arange(math.ceil(low * ROWS_PER_METRE), math.floor(high * ROWS_PER_METRE) + 1, dtype=np.float64)
    rows = numbers / ROWS_PER_METRE
    rows = rows[[bool(reachable_x(layout, alpha, w)) for w in rows.tolist()]]
    x = singular_x(layout, rows, alpha)
    parts = [np.stack((rows, x), axis=-1)[np.isfinite(x)]]
    line = level_line(layout, alpha)
    for left, right in reachable_x(layout, alpha, line) if line is not None else []:
        inner = np.arange(math.floor(left * ROWS_PER_METRE) + 1, math.ceil(right * ROWS_PER_METRE)) / ROWS_PER_METRE
        places = np.concatenate(([left], inner, [right]))
        parts.append(np.stack((np.full(places.size, line), places), axis=-1))
    curve = np.concatenate(parts)
    return np.asarray(curve[np.lexsort((curve[:, 1], curve[:, 0]))], dtype=np.float64)
