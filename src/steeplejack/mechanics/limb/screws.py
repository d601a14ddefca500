"""Twists and wrenches as screws: lines, couples and joints, their reciprocal product and their change of frame.

Twists are ordered (angular; linear), wrenches (moment; force), both at the origin of the frame they are written in. In
this pair of orders the reciprocal product is the plain dot product. Papers that write both as (direction; moment)
exchange the halves of one of them; Ye et al. (Robotica 2024) write twists (omega; v) in Eq. 1 and (v; omega) in Eq. 3,
wrenches (force; moment) in Eq. 2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def revolute(axis: ArrayLike, point: ArrayLike) -> Array:
    """Unit twist ``(s; r x s)`` of a turn about a line.

    Args:
        axis: Unit direction ``s`` of the line, (..., 3) [1].
        point: Any point ``r`` of it, (..., 3) [m].

    Returns:
        (..., 6) [1; m].
    """
    return helical(axis, point, 0.0)


def prismatic(axis: ArrayLike) -> Array:
    """Unit twist ``(0; s)`` of a translation along a unit direction (..., 3), (..., 6) [1/m; 1]."""
    s = np.asarray(axis, dtype=np.float64)
    return np.concatenate((np.zeros_like(s), s), axis=-1)


def helical(axis: ArrayLike, point: ArrayLike, pitch: ArrayLike) -> Array:
    """Unit twist ``(s; r x s + h s)`` of a turn about a line with ``h`` of travel a radian.

    Args:
        axis: Unit direction ``s`` of the line, (..., 3) [1].
        point: Any point ``r`` of it, (..., 3) [m].
        pitch: ``h``, (...) [m/rad].

    Returns:
        (..., 6) [1; m].
    """
    s, r = np.broadcast_arrays(np.asarray(axis, dtype=np.float64), np.asarray(point, dtype=np.float64))
    travel = np.asarray(pitch, dtype=np.float64)[..., None] * s
    return np.concatenate(np.broadcast_arrays(s, np.cross(r, s) + travel), axis=-1)


def force(direction: ArrayLike, point: ArrayLike) -> Array:
    """Unit wrench ``(r x s; s)`` of a force along a line through a point, (..., 6) [m; 1]."""
    s, r = np.broadcast_arrays(np.asarray(direction, dtype=np.float64), np.asarray(point, dtype=np.float64))
    return np.concatenate((np.cross(r, s), s), axis=-1)


def couple(axis: ArrayLike) -> Array:
    """Unit wrench ``(s; 0)`` of a couple about a unit direction (..., 3), (..., 6) [1; 1/m]."""
    s = np.asarray(axis, dtype=np.float64)
    return np.concatenate((s, np.zeros_like(s)), axis=-1)


def reciprocal_product(twists: ArrayLike, wrenches: ArrayLike) -> Array:
    """Power ``omega . m + v . f`` of wrenches on twists.

    Args:
        twists: (..., 6) [rad/s; m/s].
        wrenches: (..., 6) [N m; N], of a shape that broadcasts with it; ``twists[:, None]`` for every pair of two sets.

    Returns:
        (...) [W]; 0 where the two are reciprocal.
    """
    return np.sum(np.asarray(twists, dtype=np.float64) * np.asarray(wrenches, dtype=np.float64), axis=-1)


def cross_matrix(vector: ArrayLike) -> Array:
    """Matrix ``[t]`` (..., 3, 3) of a vector (..., 3) with ``[t] u = t x u``."""
    t = np.asarray(vector, dtype=np.float64)
    out = np.zeros((*t.shape, 3))
    out[..., 2, 1], out[..., 0, 2], out[..., 1, 0] = t[..., 0], t[..., 1], t[..., 2]
    return out - np.swapaxes(out, -1, -2)


def transform_twists(rotation: ArrayLike, translation: ArrayLike, twists: ArrayLike) -> Array:
    """Twists in another frame, ``(R omega; R v + t x R omega)``: the adjoint of the displacement (R, t).

    Args:
        rotation: ``R_a_b``, (..., 3, 3).
        translation: ``t``, origin of b in a, (..., 3) [m].
        twists: In b, (..., 6) [rad/s; m/s].

    Returns:
        In a, (..., 6).
    """
    turn, screws = np.asarray(rotation, dtype=np.float64), np.asarray(twists, dtype=np.float64)
    angular = np.einsum("...ij,...j->...i", turn, screws[..., :3])
    linear = np.einsum("...ij,...j->...i", turn, screws[..., 3:])
    linear = linear + np.einsum("...ij,...j->...i", cross_matrix(translation), angular)
    return np.concatenate((angular, linear), axis=-1)


def transform_wrenches(rotation: ArrayLike, translation: ArrayLike, wrenches: ArrayLike) -> Array:
    """Wrenches in another frame, ``(R m + t x R f; R f)``; arguments as of `transform_twists`.

    Together with `transform_twists` it leaves every reciprocal product as it was.
    """
    screws = np.asarray(wrenches, dtype=np.float64)
    swapped = transform_twists(rotation, translation, np.roll(screws, 3, axis=-1))
    return np.roll(swapped, 3, axis=-1)


def pitch_of_twist(twist: ArrayLike) -> Array:
    """Travel along its axis a radian, ``omega . v / omega^2``, (...) [m/rad]; infinite for a pure translation."""
    screw = np.asarray(twist, dtype=np.float64)
    square = np.sum(screw[..., :3] ** 2, axis=-1)
    power = np.sum(screw[..., :3] * screw[..., 3:], axis=-1)
    return np.divide(power, square, out=np.full_like(square, np.inf), where=square > 0.0)
