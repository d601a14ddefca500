"""Exact derivatives of structure matrices, and of measures of them, in the pose, the anchors and the attachments.

Of a column ``(r x u; u)`` with arm ``r = R b``, direction ``u``, length ``l`` and ``P = (I - u u^T) / l``

    du = P (dA - dr - dp),        d(r x u) = dr x u + r x du,        dr = w x r + R db,

where the pose moves by a displacement ``dp`` and a rotation ``exp([w]x) R``, both in world axes: pose coordinates are
(rotation; displacement) for spatial robots and ``(x, y, phi)`` for planar ones. A column depends on its own anchor and
attachment only, so nothing larger than (n, m, n) is stored.

A measure of the structure matrix (`slopes`: tension factor, margins) has a slope in each of its entries; `gradient`
multiplies the two and adds what a wrench that moves with the pose contributes.

Range of validity: straight cables. A cable of zero length has no derivative: its entries are not a number.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.mechanics.cable.measure.slopes import Slope
from steeplejack.mechanics.cable.pulleys import in_space
from steeplejack.mechanics.cable.rest.modes import cross_matrix
from steeplejack.mechanics.cable.rest.stiffness import PLANAR_ROWS, turn_about_z
from steeplejack.mechanics.cable.structure import spatial_vectors

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StructureDerivatives:
    """Derivatives of a structure matrix (..., n, m); d is 2 for planar robots and 3 for spatial ones.

    Attributes:
        pose: In the pose coordinates, (..., n, m, n).
        anchors: Of each column in its own anchor, (..., n, m, d).
        attachments: Of each column in its own attachment, platform frame, (..., n, m, d).
    """

    pose: Array
    anchors: Array
    attachments: Array


@dataclass(frozen=True)
class Gradient:
    """Gradient of one measure of a pose; leading axes are those of the question.

    Attributes:
        value: The measure itself, (...).
        pose: In the pose coordinates, (..., n).
        anchors: In every anchor, (..., m, d).
        attachments: In every attachment, platform frame, (..., m, d).
        smooth: Whether the measure has a derivative there, (...); where not, this is the slope of one of the smooth
            pieces that meet.
    """

    value: Array
    pose: Array
    anchors: Array
    attachments: Array
    smooth: NDArray[np.bool_]


def planar_structure_derivatives(anchors: ArrayLike, attachments: ArrayLike, pose: ArrayLike) -> StructureDerivatives:
    """Derivatives of a planar structure matrix.

    Args:
        anchors: (..., m, 2) [m].
        attachments: In the platform frame, (m, 2) [m].
        pose: ``(x, y, phi)``, (..., 3) [m, m, rad].

    Returns:
        Derivatives with n = 3, d = 2.
    """
    where = np.asarray(pose, dtype=np.float64)
    full = spatial_structure_derivatives(
        in_space(np.asarray(anchors, dtype=np.float64)),
        in_space(np.asarray(attachments, dtype=np.float64)),
        in_space(where[..., :2]),
        turn_about_z(where[..., 2]),
    )
    return StructureDerivatives(
        full.pose[..., PLANAR_ROWS, :, :][..., PLANAR_ROWS],
        full.anchors[..., PLANAR_ROWS, :, :2],
        full.attachments[..., PLANAR_ROWS, :, :2],
    )


def spatial_structure_derivatives(
    anchors: ArrayLike, attachments: ArrayLike, position: ArrayLike, rotation: ArrayLike
) -> StructureDerivatives:
    """Derivatives of a spatial structure matrix.

    Args:
        anchors: (..., m, 3) [m].
        attachments: In the platform frame, (m, 3) [m].
        position: (..., 3) [m].
        rotation: From platform to world, (..., 3, 3).

    Returns:
        Derivatives with n = 6, d = 3.
    """
    vectors = spatial_vectors(anchors, attachments, position, rotation)
    turn = np.asarray(rotation, dtype=np.float64)
    arms = np.broadcast_to(np.asarray(attachments, dtype=np.float64) @ np.swapaxes(turn, -1, -2), vectors.shape)
    lengths = np.linalg.norm(vectors, axis=-1)[..., None]
    with np.errstate(invalid="ignore", divide="ignore"):
        directions = vectors / lengths
        bend = (np.eye(3) - directions[..., :, None] * directions[..., None, :]) / lengths[..., None]
    lever, pull, towards = cross_matrix(arms), cross_matrix(directions), turn[..., None, :, :]
    turned = bend @ lever
    return StructureDerivatives(
        _columns(
            np.concatenate((pull @ lever + lever @ turned, -lever @ bend), axis=-1),
            np.concatenate((turned, -bend), axis=-1),
        ),
        _columns(lever @ bend, bend),
        _columns(-(pull + lever @ bend) @ towards, -bend @ towards),
    )


def planar_weight_derivative(weight: ArrayLike, centre: ArrayLike, pose: ArrayLike) -> Array:
    """Derivative of the wrench of a planar platform's weight in ``(x, y, phi)``.

    Args:
        weight: Gravity force, (2,) [N].
        centre: Centre of mass in the platform frame, (2,) [m].
        pose: ``(x, y, phi)``, (..., 3) [m, m, rad].

    Returns:
        (..., 3, 3).
    """
    turn = turn_about_z(np.asarray(pose, dtype=np.float64)[..., 2])
    force, point = (in_space(np.asarray(value, dtype=np.float64)) for value in (weight, centre))
    return spatial_weight_derivative(force, point, turn)[..., PLANAR_ROWS[:, None], PLANAR_ROWS]


def spatial_weight_derivative(weight: ArrayLike, centre: ArrayLike, rotation: ArrayLike) -> Array:
    """Derivative of the wrench ``(R c x W; W)`` of a weight in (rotation; displacement).

    Args:
        weight: Gravity force, (3,) [N].
        centre: Centre of mass in the platform frame, (3,) [m].
        rotation: From platform to world, (..., 3, 3).

    Returns:
        (..., 6, 6); only the moments in the rotations are not zero.
    """
    turn = np.asarray(rotation, dtype=np.float64)
    out = np.zeros((*turn.shape[:-2], 6, 6))
    arm = turn @ np.asarray(centre, dtype=np.float64)
    out[..., :3, :3] = cross_matrix(np.asarray(weight, dtype=np.float64)) @ cross_matrix(arm)
    return out


def gradient(slope: Slope, derivatives: StructureDerivatives, wrench: ArrayLike | None = None) -> Gradient:
    """Gradient of a measure in pose, anchors and attachments, by the chain rule.

    Args:
        slope: Of the measure in the structure matrix and the wrench.
        derivatives: Of the structure matrix.
        wrench: Derivative of the external wrench in the pose coordinates, (..., n, n), for example
            `spatial_weight_derivative`; none for a wrench that does not move with the platform.

    Returns:
        Value, gradient and whether it is one.
    """
    pose = np.einsum("...nm,...nmk->...k", slope.structure, derivatives.pose)
    if wrench is not None:
        pose = pose + np.einsum("...n,...nk->...k", slope.wrench, np.asarray(wrench, dtype=np.float64))
    return Gradient(
        slope.value,
        pose,
        np.einsum("...nm,...nmd->...md", slope.structure, derivatives.anchors),
        np.einsum("...nm,...nmd->...md", slope.structure, derivatives.attachments),
        slope.smooth,
    )


def _columns(moments: Array, forces: Array) -> Array:
    """Derivatives of moment and force parts, (..., m, 3, k) each, as (..., 6, m, k)."""
    return np.moveaxis(np.concatenate((moments, forces), axis=-2), -2, -3)
