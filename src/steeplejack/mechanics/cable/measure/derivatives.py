"""Exact derivatives of structure matrices, and of measures of them, in the pose, the anchors and the attachments.

Of a column ``(r x u; u)`` with arm ``r = R b`` and direction ``u`` of a cable of length ``l``, P its second derivative
in the attachment's place (``(I - u u^T) / l`` of a straight cable; see `pulleys` for the others)

    du = P (dA - dr - dp),        d(r x u) = dr x u + r x du,        dr = w x r + R db,

where an anchor A takes its pulley along, whose axis and radius stay, and the pose moves by a displacement ``dp`` and a
rotation ``exp([w]x) R``, both in world axes: pose coordinates are (rotation; displacement) for spatial robots and
``(x, y, phi)`` for planar ones. A column depends on its own anchor and attachment only, so nothing larger than
(n, m, n) is stored.

A measure of the structure matrix (`slopes`: tension factor, margins) has a slope in each of its entries; `gradient`
multiplies the two and adds what a wrench that moves with the pose contributes.

Range of validity: taut, massless cables, straight or over swivelling pulleys. A cable of zero length, or with its
attachment inside its pulley or on the swivel axis, has no derivative: its entries are not a number.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import kind, leading, one, rotation_matrices, rows, vectors
from steeplejack.mechanics.cable.measure.slopes import Slope
from steeplejack.mechanics.cable.pulleys import course_derivatives, in_space
from steeplejack.mechanics.cable.rest.modes import cross_matrix
from steeplejack.mechanics.cable.rest.stiffness import PLANAR_ROWS, turn_about_z

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


@np.errstate(invalid="ignore", over="ignore")
def planar_structure_derivatives(
    anchors: ArrayLike,
    attachments: ArrayLike,
    pose: ArrayLike,
    axes: ArrayLike | None = None,
    radii: ArrayLike | None = None,
) -> StructureDerivatives:
    """Derivatives of a planar structure matrix.

    Args:
        anchors: (..., m, 2) [m].
        attachments: In the platform frame, (m, 2) [m].
        pose: ``(x, y, phi)``, (..., 3) [m, m, rad].
        axes: Swivel axes of pulleys in the plane, (m, 2); none for straight cables.
        radii: Of the pulleys, (m,) or a scalar [m].

    Returns:
        Derivatives with n = 3, d = 2.

    Raises:
        InputError: Shapes that do not fit, or radii that are negative or not finite.
    """
    where = vectors("pose", pose, 3)
    full = spatial_structure_derivatives(
        in_space(vectors("anchors", anchors, "m", 2)),
        in_space(rows("attachments", attachments, 2)),
        in_space(where[..., :2]),
        turn_about_z(where[..., 2]),
        axes,
        radii,
    )
    return StructureDerivatives(
        full.pose[..., PLANAR_ROWS, :, :][..., PLANAR_ROWS],
        full.anchors[..., PLANAR_ROWS, :, :2],
        full.attachments[..., PLANAR_ROWS, :, :2],
    )


@np.errstate(invalid="ignore", over="ignore")
def spatial_structure_derivatives(
    anchors: ArrayLike,
    attachments: ArrayLike,
    position: ArrayLike,
    rotation: ArrayLike,
    axes: ArrayLike | None = None,
    radii: ArrayLike | None = None,
) -> StructureDerivatives:
    """Derivatives of a spatial structure matrix.

    Args:
        anchors: (..., m, 3) [m].
        attachments: In the platform frame, (m, 3) [m].
        position: (..., 3) [m].
        rotation: From platform to world, (..., 3, 3).
        axes: Swivel axes of pulleys, (m, 3); none for straight cables.
        radii: Of the pulleys, (m,) or a scalar [m].

    Returns:
        Derivatives with n = 6, d = 3.

    Raises:
        InputError: Shapes that do not fit, radii that are negative or not finite, or one matrix that is no rotation.
    """
    local = rows("attachments", attachments, 3)
    m = len(local)
    fixed, place = vectors("anchors", anchors, m, 3), vectors("position", position, 3)
    turn = rotation_matrices("rotation", rotation)
    shape = leading(("anchors", fixed.shape, 2), ("position", place.shape, 1), ("rotation", turn.shape, 2))
    arms = np.broadcast_to(local @ np.swapaxes(turn, -1, -2), (*shape, m, 3))
    directions, bend = course_derivatives(fixed, axes, radii, place[..., None, :] + arms)
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


@np.errstate(invalid="ignore", over="ignore")
def planar_weight_derivative(weight: ArrayLike, centre: ArrayLike, pose: ArrayLike) -> Array:
    """Derivative of the wrench of a planar platform's weight in ``(x, y, phi)``.

    Args:
        weight: Gravity force, (2,) [N].
        centre: Centre of mass in the platform frame, (2,) [m].
        pose: ``(x, y, phi)``, (..., 3) [m, m, rad].

    Returns:
        (..., 3, 3).

    Raises:
        InputError: No numbers, or shapes that do not fit.
    """
    turn = turn_about_z(vectors("pose", pose, 3)[..., 2])
    force, point = in_space(one("weight", weight, 2)), in_space(one("centre", centre, 2))
    return spatial_weight_derivative(force, point, turn)[..., PLANAR_ROWS[:, None], PLANAR_ROWS]


@np.errstate(invalid="ignore", over="ignore")
def spatial_weight_derivative(weight: ArrayLike, centre: ArrayLike, rotation: ArrayLike) -> Array:
    """Derivative of the wrench ``(R c x W; W)`` of a weight in (rotation; displacement).

    Args:
        weight: Gravity force, (3,) [N].
        centre: Centre of mass in the platform frame, (3,) [m].
        rotation: From platform to world, (..., 3, 3).

    Returns:
        (..., 6, 6); only the moments in the rotations are not zero.

    Raises:
        InputError: No numbers, shapes that do not fit, or one matrix that is no rotation.
    """
    turn = rotation_matrices("rotation", rotation)
    out = np.zeros((*turn.shape[:-2], 6, 6))
    arm = turn @ one("centre", centre, 3)
    out[..., :3, :3] = cross_matrix(one("weight", weight, 3)) @ cross_matrix(arm)
    return out


@np.errstate(invalid="ignore", over="ignore")
def gradient(slope: Slope, derivatives: StructureDerivatives, wrench: ArrayLike | None = None) -> Gradient:
    """Gradient of a measure in pose, anchors and attachments, by the chain rule.

    Args:
        slope: Of the measure in the structure matrix and the wrench.
        derivatives: Of the structure matrix.
        wrench: Derivative of the external wrench in the pose coordinates, (..., n, n), for example
            `spatial_weight_derivative`; none for a wrench that does not move with the platform.

    Returns:
        Value, gradient and whether it is one.

    Raises:
        InputError: Slope and derivatives of different structure matrices.
    """
    kind("derivatives", derivatives, StructureDerivatives)
    n, m = kind("slope", slope, Slope).structure.shape[-2:]
    if derivatives.pose.shape[-3:-1] != (n, m):
        found = f"of {derivatives.pose.shape[-3:-1]} structure matrices"
        raise InputError("derivatives", found, f"those of ({n}, {m}), as the slope")
    pose = np.einsum("...nm,...nmk->...k", slope.structure, derivatives.pose)
    if wrench is not None:
        pose = pose + np.einsum("...n,...nk->...k", slope.wrench, vectors("wrench", wrench, n, n))
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
