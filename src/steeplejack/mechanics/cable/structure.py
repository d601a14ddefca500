"""Cable vectors, lengths and structure matrices of a platform on straight cables.

Cable ``i`` runs from its attachment ``B_i`` on the platform to its anchor ``A_i``. Planar robots (``planar_*``) have
the pose ``(x, y, phi)`` and wrenches ``(fx, fy, mz)``, each the dual of the other; spatial robots (``spatial_*``) have
a position and a rotation matrix, and wrenches ordered (moment; force). Moments are about the platform's reference
point.

Source: Zheng et al., CCRobot-S, IEEE T-RO, Eq. 2-6. Eq. 4 has lost a minus sign and its brackets, and Eq. 5-6 print the
local attachment as the moment arm; it is the rotated one, ``b_i = R lB_i``, and only with it is ``dl/dx = -J`` true.

Range of validity: cables taut, straight, massless and of non-zero length.

Degeneracy. What only rounding makes of a pose counts as nothing, so that no question about it (`degeneracy`) is
answered by noise. A cable shorter than ``LENGTHLESS`` times the coordinates it is the difference of has no direction:
its column is zero, and no pose with one counts as held. Where the moments of all cables are below
``degeneracy.TOLERANCE`` times the longest arm (all cables through the reference point), they are zero. A coordinate
that is not a number makes columns that are not, and so does a matrix among many that is no rotation (`arguments`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.mechanics.cable.arguments import angles, leading, rotation_matrices, rows, vectors
from steeplejack.mechanics.cable.degeneracy import TOLERANCE

Array = NDArray[np.float64]

LENGTHLESS = 1e-12
"""Cable length that counts as zero, over the size of the coordinates it is the difference of [1]."""


def planar_arms(attachments: ArrayLike, phi: ArrayLike) -> Array:
    """Attachments turned into the world frame, ``b_i = R(phi) lB_i``.

    Args:
        attachments: ``lB_i`` in the platform frame, (m, 2) [m].
        phi: Orientation, (...) [rad].

    Returns:
        Arms from the reference point, world axes, (..., m, 2) [m].

    Raises:
        InputError: No numbers, or other shapes.
    """
    local, angle = rows("attachments", attachments, 2), angles("phi", phi)[..., None]
    cos, sin = np.cos(angle), np.sin(angle)
    with np.errstate(invalid="ignore", over="ignore"):
        return np.stack((cos * local[:, 0] - sin * local[:, 1], sin * local[:, 0] + cos * local[:, 1]), axis=-1)


def planar_vectors(anchors: ArrayLike, attachments: ArrayLike, pose: ArrayLike) -> Array:
    """Cable vectors from attachment to anchor, ``BA_i = A_i - b_i - p`` (Eq. 2-4).

    Args:
        anchors: ``A_i`` in the world, (..., m, 2) [m].
        attachments: ``lB_i`` in the platform frame, (m, 2) [m].
        pose: ``(x, y, phi)``, (..., 3) [m, m, rad].

    Returns:
        Vectors, world axes, (..., m, 2) [m].

    Raises:
        InputError: No numbers, or shapes that do not match.
    """
    where = vectors("pose", pose, 3)
    arms = planar_arms(attachments, where[..., 2])
    return _runs(_roots(anchors, arms, ("pose", where.shape, 1)), arms, where[..., None, :2])


def planar_lengths(anchors: ArrayLike, attachments: ArrayLike, pose: ArrayLike) -> Array:
    """Cable lengths ``l_i = |BA_i|`` of a planar robot.

    Args:
        anchors: (..., m, 2) [m].
        attachments: (m, 2) [m].
        pose: ``(x, y, phi)``, (..., 3) [m, m, rad].

    Returns:
        Lengths, (..., m) [m].

    Raises:
        InputError: No numbers, or shapes that do not match.
    """
    return _sizes(planar_vectors(anchors, attachments, pose))


def planar_structure_matrix(anchors: ArrayLike, attachments: ArrayLike, pose: ArrayLike) -> Array:
    """Structure matrix ``J^T`` of a planar robot: column ``i`` is ``(u_i; b_i x u_i)`` (Eq. 5-6, arm rotated).

    ``J^T f`` is the wrench the tensions ``f`` exert on the platform, and ``dl/dx = -J``.

    Args:
        anchors: (..., m, 2) [m].
        attachments: (m, 2) [m].
        pose: ``(x, y, phi)``, (..., 3) [m, m, rad].

    Returns:
        Rows ``fx, fy`` [1] and ``mz`` [m], (..., 3, m).

    Raises:
        InputError: No numbers, or shapes that do not match.
    """
    where = vectors("pose", pose, 3)
    arms = planar_arms(attachments, where[..., 2])
    roots = _roots(anchors, arms, ("pose", where.shape, 1))
    directions = _directions(roots, arms, where[..., None, :2])
    with np.errstate(invalid="ignore", over="ignore"):
        moments = arms[..., 0] * directions[..., 1] - arms[..., 1] * directions[..., 0]
    moments = _resisting(moments[..., None], arms)[..., 0]
    return np.stack((directions[..., 0], directions[..., 1], moments), axis=-2)


def spatial_vectors(anchors: ArrayLike, attachments: ArrayLike, position: ArrayLike, rotation: ArrayLike) -> Array:
    """Cable vectors from attachment to anchor in space, ``BA_i = A_i - R lB_i - p``.

    Args:
        anchors: (..., m, 3) [m].
        attachments: (m, 3) in the platform frame [m].
        position: ``p`` of the platform in the world, (..., 3) [m].
        rotation: ``R`` from platform to world, (..., 3, 3).

    Returns:
        Vectors, world axes, (..., m, 3) [m].

    Raises:
        InputError: No numbers, shapes that do not match, or one matrix that is no rotation.
    """
    where, arms = vectors("position", position, 3), _spatial_arms(attachments, rotation)
    return _runs(_roots(anchors, arms, ("position", where.shape, 1)), arms, where[..., None, :])


def spatial_lengths(anchors: ArrayLike, attachments: ArrayLike, position: ArrayLike, rotation: ArrayLike) -> Array:
    """Cable lengths of a spatial robot.

    Args:
        anchors: (..., m, 3) [m].
        attachments: (m, 3) in the platform frame [m].
        position: (..., 3) [m].
        rotation: From platform to world, (..., 3, 3).

    Returns:
        Lengths, (..., m) [m].

    Raises:
        InputError: No numbers, shapes that do not match, or one matrix that is no rotation.
    """
    return _sizes(spatial_vectors(anchors, attachments, position, rotation))


def spatial_structure_matrix(
    anchors: ArrayLike, attachments: ArrayLike, position: ArrayLike, rotation: ArrayLike
) -> Array:
    """Structure matrix of a spatial robot: column ``i`` is ``(b_i x u_i; u_i)``, moments before forces.

    With the platform's twist (angular; linear) about ``p`` in world axes, ``dl/dt = -structure^T twist``.

    Args:
        anchors: (..., m, 3) [m].
        attachments: (m, 3) in the platform frame [m].
        position: (..., 3) [m].
        rotation: From platform to world, (..., 3, 3).

    Returns:
        Rows ``mx, my, mz`` [m] and ``fx, fy, fz`` [1], (..., 6, m).

    Raises:
        InputError: No numbers, shapes that do not match, or one matrix that is no rotation.
    """
    where, arms = vectors("position", position, 3), _spatial_arms(attachments, rotation)
    roots = _roots(anchors, arms, ("position", where.shape, 1))
    directions = _directions(roots, arms, where[..., None, :])
    arms = np.broadcast_to(arms, directions.shape)
    with np.errstate(invalid="ignore", over="ignore"):
        moments = np.cross(arms, directions)
    moments = _resisting(moments, arms)
    return np.swapaxes(np.concatenate((moments, directions), axis=-1), -1, -2)


def _spatial_arms(attachments: ArrayLike, rotation: ArrayLike) -> Array:
    """``b_i = R lB_i``, (..., m, 3)."""
    local, turn = rows("attachments", attachments, 3), rotation_matrices("rotation", rotation)
    with np.errstate(invalid="ignore", over="ignore"):
        return local @ np.swapaxes(turn, -1, -2)


def _roots(anchors: ArrayLike, arms: Array, pose: tuple[str, tuple[int, ...], int]) -> Array:
    """Anchors that fit the arms (..., m, d) and the leading axes of a pose."""
    roots = vectors("anchors", anchors, arms.shape[-2], arms.shape[-1])
    leading(("anchors", roots.shape, 2), ("attachments and rotation", arms.shape, 2), pose)
    return roots


def _runs(roots: Array, arms: Array, where: Array) -> Array:
    """Vectors from attachments to anchors, (..., m, d)."""
    with np.errstate(invalid="ignore", over="ignore"):
        return roots - arms - where


def _sizes(runs: Array) -> Array:
    """Lengths of vectors (..., m, d), (..., m)."""
    with np.errstate(invalid="ignore", over="ignore"):
        return np.linalg.norm(runs, axis=-1)


def _directions(roots: Array, arms: Array, where: Array) -> Array:
    """Unit vectors from attachments to anchors; zero where a cable has no length, NaN where a point is none."""
    runs = _runs(roots, arms, where)
    lengths = _sizes(runs)[..., None]
    least = np.maximum(np.abs(roots).max(axis=-1), np.abs(arms).max(axis=-1))[..., None]
    least = LENGTHLESS * np.maximum(least, np.abs(where).max(axis=-1, keepdims=True))
    with np.errstate(invalid="ignore"):
        return np.divide(runs, lengths, out=np.zeros_like(runs), where=~(lengths <= least))


def _resisting(moments: Array, arms: Array) -> Array:
    """Moments (..., m, k), all zero where none of them is above rounding."""
    most = np.abs(moments).max(axis=(-2, -1), keepdims=True)
    return np.where(most <= TOLERANCE * np.abs(arms).max(axis=(-2, -1), keepdims=True), 0.0, moments)
