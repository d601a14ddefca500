"""Cable vectors, lengths and structure matrices of a platform on straight cables.

Cable ``i`` runs from its attachment ``B_i`` on the platform to its anchor ``A_i``. Planar robots (``planar_*``) have
the pose ``(x, y, phi)`` and wrenches ``(fx, fy, mz)``, each the dual of the other; spatial robots (``spatial_*``) have
a position and a rotation matrix, and wrenches ordered (moment; force). Moments are about the platform's reference
point.

Source: Zheng et al., CCRobot-S, IEEE T-RO, Eq. 2-6. Eq. 4 has lost a minus sign and its brackets, and Eq. 5-6 print the
local attachment as the moment arm; it is the rotated one, ``b_i = R lB_i``, and only with it is ``dl/dx = -J`` true.

Range of validity: cables taut, straight, massless and of non-zero length. A cable of zero length has no direction, so
its column is zero and no pose with one counts as held.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def planar_arms(attachments: ArrayLike, phi: ArrayLike) -> Array:
    """Attachments turned into the world frame, ``b_i = R(phi) lB_i``.

    Args:
        attachments: ``lB_i`` in the platform frame, (m, 2) [m].
        phi: Orientation, (...) [rad].

    Returns:
        Arms from the reference point, world axes, (..., m, 2) [m].
    """
    local = np.asarray(attachments, dtype=np.float64)
    angle = np.asarray(phi, dtype=np.float64)[..., None]
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack((cos * local[:, 0] - sin * local[:, 1], sin * local[:, 0] + cos * local[:, 1]), axis=-1)


def planar_vectors(anchors: ArrayLike, attachments: ArrayLike, pose: ArrayLike) -> Array:
    """Cable vectors from attachment to anchor, ``BA_i = A_i - b_i - p`` (Eq. 2-4).

    Args:
        anchors: ``A_i`` in the world, (..., m, 2) [m].
        attachments: ``lB_i`` in the platform frame, (m, 2) [m].
        pose: ``(x, y, phi)``, (..., 3) [m, m, rad].

    Returns:
        Vectors, world axes, (..., m, 2) [m].
    """
    where = np.asarray(pose, dtype=np.float64)
    return np.asarray(anchors, dtype=np.float64) - planar_arms(attachments, where[..., 2]) - where[..., None, :2]


def planar_lengths(anchors: ArrayLike, attachments: ArrayLike, pose: ArrayLike) -> Array:
    """Cable lengths ``l_i = |BA_i|`` of a planar robot.

    Args:
        anchors: (..., m, 2) [m].
        attachments: (m, 2) [m].
        pose: ``(x, y, phi)``, (..., 3) [m, m, rad].

    Returns:
        Lengths, (..., m) [m].
    """
    return np.linalg.norm(planar_vectors(anchors, attachments, pose), axis=-1)


def planar_structure_matrix(anchors: ArrayLike, attachments: ArrayLike, pose: ArrayLike) -> Array:
    """Structure matrix ``J^T`` of a planar robot: column ``i`` is ``(u_i; b_i x u_i)`` (Eq. 5-6, arm rotated).

    ``J^T f`` is the wrench the tensions ``f`` exert on the platform, and ``dl/dx = -J``.

    Args:
        anchors: (..., m, 2) [m].
        attachments: (m, 2) [m].
        pose: ``(x, y, phi)``, (..., 3) [m, m, rad].

    Returns:
        Rows ``fx, fy`` [1] and ``mz`` [m], (..., 3, m).
    """
    arms = planar_arms(attachments, np.asarray(pose, dtype=np.float64)[..., 2])
    directions = _directions(planar_vectors(anchors, attachments, pose))
    moments = arms[..., 0] * directions[..., 1] - arms[..., 1] * directions[..., 0]
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
    """
    where = np.asarray(position, dtype=np.float64)[..., None, :]
    return np.asarray(anchors, dtype=np.float64) - _spatial_arms(attachments, rotation) - where


def spatial_lengths(anchors: ArrayLike, attachments: ArrayLike, position: ArrayLike, rotation: ArrayLike) -> Array:
    """Cable lengths of a spatial robot.

    Args:
        anchors: (..., m, 3) [m].
        attachments: (m, 3) in the platform frame [m].
        position: (..., 3) [m].
        rotation: From platform to world, (..., 3, 3).

    Returns:
        Lengths, (..., m) [m].
    """
    return np.linalg.norm(spatial_vectors(anchors, attachments, position, rotation), axis=-1)


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
    """
    directions = _directions(spatial_vectors(anchors, attachments, position, rotation))
    moments = np.cross(_spatial_arms(attachments, rotation), directions)
    return np.swapaxes(np.concatenate((moments, directions), axis=-1), -1, -2)


def _spatial_arms(attachments: ArrayLike, rotation: ArrayLike) -> Array:
    """``b_i = R lB_i``, (..., m, 3)."""
    turned = np.asarray(rotation, dtype=np.float64)
    return np.asarray(attachments, dtype=np.float64) @ np.swapaxes(turned, -1, -2)


def _directions(vectors: Array) -> Array:
    """Unit vectors along the last axis; zero where a cable has no length."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0.0)
