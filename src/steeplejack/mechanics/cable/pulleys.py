"""Cables over swivelling pulleys: length and direction from a winch exit over a pulley of radius r to an attachment.

Source: A. Pott, *Cable-Driven Parallel Robots* (Springer STAR 120, 2018), section 4.3, pulley kinematics; "Influence of
pulley kinematics on cable-driven parallel robots", Advances in Robot Kinematics, 2012. The cable arrives at ``A`` along
the swivel axis ``e`` (the way it travels, from the winch to the pulley), wraps around a pulley whose centre stands a
radius beside the axis on the attachment's side, and leaves along a tangent. With ``v = B - A``, ``h = v . e`` along the
axis, ``rho = |v - h e|`` beside it and ``f = sqrt((rho - r)^2 + h^2 - r^2)`` the free length,

    beta = atan2(f (rho - r) + r h, f h - r (rho - r)),        l = r beta + f.

An arc rolls off without slipping, so ``dl/dB`` is the unit vector of the free stretch, as of a straight cable, and
the second derivative is ``1/f`` across it in the pulley's plane and ``sin(beta) / rho`` out of it: every formula for
straight cables holds with these in place of ``1/l``. Radius 0 is the straight cable.

Policy at degeneracies: an attachment inside the pulley has no tangent, and one on the swivel axis of a pulley leaves
its plane open; both lengths are not a number. A straight cable of zero length has length 0 and no direction.

In the plane (`planar` arguments have two columns) the pulley stands on the attachment's side of its axis.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import leading, numbers, spread, vectors

Array = NDArray[np.float64]

ON_AXIS = 1e-12  # [1] distance from the swivel axis over the distance from A below which the plane is open


@njit(cache=True, error_model="numpy")
def cable_run(
    anchors: Array, axes: Array, radii: Array, i: int, point: Array, along: Array, across: Array
) -> tuple[float, float, float]:
    """Course of cable ``i`` from its anchor over its pulley to a point.

    Args:
        anchors: ``A`` (m, 3) [m].
        axes: Unit swivel axes ``e`` (m, 3); not read where the radius is 0.
        radii: Of the pulleys (m,) [m].
        i: Which cable; whole arrays and an index because a slice costs as much as the course of a straight cable.
        point: Attachment ``B`` in the world (3,) [m].
        along: Gets the unit vector from ``B`` along the free stretch (3,), which is ``-dl/dB``.
        across: Gets the unit normal of the pulley's plane (3,); zero for a straight cable.

    Returns:
        Length [m], and the curvatures of the length in the pulley's plane and out of it [1/m]: the second derivative is
        ``c (I - u u^T) + (s - c) n n^T``. Not a number where the course is undefined.
    """
    x, y, z = point[0] - anchors[i, 0], point[1] - anchors[i, 1], point[2] - anchors[i, 2]
    across[0] = across[1] = across[2] = 0.0
    radius = radii[i]
    if radius == 0.0:
        length = math.sqrt(x * x + y * y + z * z)
        inverse = 1.0 / length if length > 0.0 else 0.0
        along[0], along[1], along[2] = -x * inverse, -y * inverse, -z * inverse
        return length, inverse, inverse
    ex, ey, ez = axes[i, 0], axes[i, 1], axes[i, 2]
    h = x * ex + y * ey + z * ez
    x, y, z = x - h * ex, y - h * ey, z - h * ez
    rho = math.sqrt(x * x + y * y + z * z)
    square = rho * (rho - 2.0 * radius) + h * h
    if not (square > 0.0 and rho > ON_AXIS * math.hypot(rho, h)):
        along[0] = along[1] = along[2] = np.nan
        return np.nan, np.nan, np.nan
    free, beside = math.sqrt(square), rho - radius
    scale = 1.0 / (square + radius * radius)
    out, on = (free * beside + radius * h) * scale, (free * h - radius * beside) * scale
    wrap = math.atan2(out, on)
    if wrap < 0.0:
        wrap += 2.0 * math.pi
    x, y, z = x / rho, y / rho, z / rho
    along[0] = -(out * x + on * ex)
    along[1] = -(out * y + on * ey)
    along[2] = -(out * z + on * ez)
    across[0] = ey * z - ez * y
    across[1] = ez * x - ex * z
    across[2] = ex * y - ey * x
    return radius * wrap + free, 1.0 / free, out / rho


@njit(cache=True)
def _run_each(
    anchors: Array, axes: Array, radii: Array, points: Array, lengths: Array, along: Array, curvatures: Array
) -> None:
    """`cable_run` of every cable (m) of every pose (k): lengths (k, m), along (k, m, 3), curvatures (k, m, 2)."""
    across = np.empty(3)
    for k in range(points.shape[0]):
        for i in range(points.shape[1]):
            lengths[k, i], curvatures[k, i, 0], curvatures[k, i, 1] = cable_run(
                anchors, axes, radii, i, points[k, i], along[k, i], across
            )


def pulley_runs(anchors: ArrayLike, axes: ArrayLike, radii: ArrayLike, points: ArrayLike) -> tuple[Array, Array]:
    """Lengths and directions of cables over swivelling pulleys.

    With these directions in place of ``(A - B) / l`` the structure matrix of a robot with pulleys has the usual form,
    and ``dl/dx = -J`` stays true.

    Args:
        anchors: ``A_i``, where cables arrive at their pulleys, (m, d) with d = 2 or 3 [m].
        axes: Swivel axes ``e_i``, the way the cable travels on arrival, (m, d); any length but zero.
        radii: Of the pulleys, (m,) or a scalar [m]; 0 is a straight cable.
        points: Attachments in the world, (..., m, d) [m].

    Returns:
        Lengths from ``A_i`` to the attachments, wrapped arcs included, (..., m) [m]; unit vectors from the attachments
        along the free stretches, (..., m, d). Not a number where an attachment is inside its pulley or on its axis.

    Raises:
        InputError: Shapes that do not fit, or radii that are negative or not finite.
    """
    fixed = vectors("anchors", anchors, "m", "d")
    m, d = fixed.shape[-2:]
    if fixed.ndim != 2 or d not in (2, 3):
        raise InputError("anchors", f"shape {fixed.shape}", "(m, 2) or (m, 3)")
    ends = vectors("points", points, m, d)
    lead = ends.shape[:-2]
    flat = in_space(ends.reshape(-1, m, d))
    lengths, along = np.empty(flat.shape[:2]), np.empty_like(flat)
    _run_each(
        in_space(fixed),
        unit_axes(axes, m),
        pulley_radii(radii, m),
        flat,
        lengths,
        along,
        np.empty((*flat.shape[:2], 2)),
    )
    return lengths.reshape(*lead, m), along[..., :d].reshape(*lead, m, d)


def course_derivatives(
    anchors: Array, axes: ArrayLike | None, radii: ArrayLike | None, points: Array
) -> tuple[Array, Array]:
    """Directions of cables in space, and how they turn as their attachments move: minus the length's Hessian.

    Args:
        anchors: (..., m, 3) [m].
        axes: Swivel axes, (m, 3); none for straight cables.
        radii: (m,) or a scalar [m]; none for straight cables.
        points: Attachments in the world, (..., m, 3) [m].

    Returns:
        Unit vectors from the attachments along the free stretches, (..., m, 3), and ``d2l/dB2``, symmetric,
        (..., m, 3, 3) [1/m]: ``du = -(d2l/dB2) (dB - dA)``. Not a number for a cable without length or course.
    """
    m = points.shape[-2]
    shape = leading(("anchors", anchors.shape, 2), ("points", points.shape, 2))
    fixed, ends = spread(anchors, shape, (m, 3)), spread(points, shape, (m, 3))
    along, bends = np.empty_like(ends), np.empty((*ends.shape, 3))
    _bend_each(fixed, unit_axes(axes, m), pulley_radii(radii, m), ends, along, bends)
    return along.reshape(*shape, m, 3), bends.reshape(*shape, m, 3, 3)


@njit(cache=True)
def _bend_each(anchors: Array, axes: Array, radii: Array, points: Array, along: Array, bends: Array) -> None:
    """`cable_run` of every cable (m) of every pose (k) with anchors (k, m, 3): its direction and second derivative."""
    across = np.empty(3)
    for k in range(points.shape[0]):
        for i in range(points.shape[1]):
            length, inside, outside = cable_run(anchors[k], axes, radii, i, points[k, i], along[k, i], across)
            if not length > 0.0:
                along[k, i], inside = np.nan, np.nan
            for a in range(3):
                for b in range(3):
                    bends[k, i, a, b] = (outside - inside) * across[a] * across[b]
                    bends[k, i, a, b] -= inside * along[k, i, a] * along[k, i, b]
                bends[k, i, a, a] += inside


def in_space(points: Array) -> Array:
    """Points (..., 2) or (..., 3) as points (..., 3), contiguous; those of the plane at z = 0 [m]."""
    out = np.zeros((*points.shape[:-1], 3))
    out[..., : points.shape[-1]] = points
    return out


def unit_axes(axes: ArrayLike | None, count: int) -> Array:
    """Swivel axes as unit vectors (count, 3); up (z) where none are given, which straight cables do not read.

    Raises:
        InputError: Another shape.
    """
    if axes is None:
        return np.tile([0.0, 0.0, 1.0], (count, 1))
    given = numbers("axes", axes)
    if given.ndim != 2 or len(given) != count or given.shape[1] not in (2, 3):
        raise InputError("axes", f"shape {given.shape}", f"({count}, 2) in the plane or ({count}, 3) in space")
    given = in_space(given)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return np.ascontiguousarray(given / np.linalg.norm(given, axis=-1, keepdims=True))


def pulley_radii(radii: ArrayLike | None, count: int) -> Array:
    """Radii (count,) [m]; 0 where none are given.

    Raises:
        InputError: Another shape, or radii that are negative or not finite.
    """
    given = np.zeros(()) if radii is None else numbers("radii", radii)
    if given.shape not in ((), (count,)):
        raise InputError("radii", f"shape {given.shape}", f"one number or {count}")
    if not np.all((given >= 0.0) & (given < np.inf)):
        raise InputError("radii", f"{given.tolist()}", "finite radii in metres, 0 or more")
    return np.array(np.broadcast_to(given, (count,)))
