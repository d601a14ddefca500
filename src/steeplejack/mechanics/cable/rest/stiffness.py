"""Stiffness of a platform on any number of elastic cables, over pulleys or straight, planar or spatial.

With winches locked a small displacement ``d`` of the platform changes its wrench by ``-K d``. Two parts add up:

    K = sum_i  k_i j_i j_i^T                                        elastic: j_i is column i of the structure matrix
      + sum_i  t_i D_i^T C_i D_i  +  (f . r) I - (f r^T + r f^T)/2  tension: of every force f at an arm r

with ``D_i = [-(r_i x), I]``, ``C_i = (I - u_i u_i^T) / l_i`` the curvature of a straight cable's length (over a pulley
it is ``1/f`` in the pulley's plane and another out of it, see `pulleys`), and the last term in the rotations only, the
weight at the centre of mass included. The rate of a cable of unstressed length L is ``k = EA / L``, in the length l and
tension t it has now ``k = (EA + t) / l`` (`cable_rates`). Source: Behzadipour and Khajepour, "Stiffness of cable-based
parallel manipulators with application to stability analysis", J. Mechanical Design 128(1), 2006, written as the second
derivative of the potential in a rotation vector (left, world axes) and a displacement of the reference point.

This is the symmetric part of ``-d(wrench)/d(twist)``. The rest is half the cross matrix of the total moment, which is
zero at equilibrium: only there does stiffness decide stability. A dead force at the reference point adds nothing.

Policy: a cable with a tension of zero or less is slack and adds nothing. A pose with a number that is not finite, a
taut cable of zero length (below 1e-12 of its ends' coordinates) or an attachment inside its pulley has no stiffness:
every entry is not a number.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.mechanics.cable.arguments import (
    angles,
    each_cable,
    leading,
    numbers,
    one,
    rotation_matrices,
    rows,
    spread,
    stiffness_of,
    vectors,
)
from steeplejack.mechanics.cable.pulleys import cable_run, in_space, pulley_radii, unit_axes
from steeplejack.mechanics.cable.rest.curvature import add_cable, add_turn, arm_of

Array = NDArray[np.float64]

SHORTEST = 1e-12
"""Length of a cable over its ends' coordinates below which it is rounding [1]."""

PLANAR_ROWS = np.array([3, 4, 2])
"""Where ``(x, y, phi)`` stand among (rotation; displacement)."""


def cable_rates(axial_stiffness: ArrayLike, lengths: ArrayLike, tensions: ArrayLike) -> Array:
    """Spring rates of linearly elastic cables, ``k = EA / L = (EA + t) / l``.

    Args:
        axial_stiffness: ``EA``, (..., m) or a scalar [N].
        lengths: ``l``, under load, (..., m) [m].
        tensions: ``t``, (..., m) [N]; negative ones count as zero.

    Returns:
        Rates, (..., m) [N/m]; infinite for zero length.

    Raises:
        InputError: Shapes that do not fit, or an axial stiffness of zero or less.
    """
    elastic, length = stiffness_of(axial_stiffness), numbers("lengths", lengths)
    pull = numbers("tensions", tensions)
    leading(("axial_stiffness", elastic.shape, 0), ("lengths", length.shape, 0), ("tensions", pull.shape, 0))
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        return (elastic + np.maximum(pull, 0.0)) / length


def planar_stiffness(
    anchors: ArrayLike,
    attachments: ArrayLike,
    pose: ArrayLike,
    tensions: ArrayLike,
    rates: ArrayLike,
    weight: ArrayLike = (0.0, 0.0),
    centre: ArrayLike = (0.0, 0.0),
    axes: ArrayLike | None = None,
    radii: ArrayLike | None = None,
) -> Array:
    """Stiffness of a planar robot in ``(x, y, phi)``; the spatial one's rows and columns of the plane.

    Args:
        anchors: (..., m, 2) [m].
        attachments: In the platform frame, (m, 2) [m].
        pose: ``(x, y, phi)``, (..., 3) [m, m, rad].
        tensions: (..., m) [N].
        rates: See `cable_rates`, (..., m) or a scalar [N/m]; 0 for the stiffness at constant tension.
        weight: Gravity force, (2,) [N].
        centre: Centre of mass in the platform frame, (2,) [m].
        axes: Swivel axes of pulleys, (m, 2); none for straight cables.
        radii: Of the pulleys, (m,) or a scalar [m].

    Returns:
        Symmetric, (..., 3, 3) [N/m, N, N m].

    Raises:
        InputError: A shape that does not fit, or radii that are negative or not finite.
    """
    where = vectors("pose", pose, 3)
    full = spatial_stiffness(
        in_space(vectors("anchors", anchors, "m", 2)),
        in_space(rows("attachments", attachments, 2)),
        in_space(where[..., :2]),
        turn_about_z(where[..., 2]),
        tensions,
        rates,
        in_space(one("weight", weight, 2)),
        in_space(one("centre", centre, 2)),
        axes,
        radii,
    )
    return full[..., PLANAR_ROWS[:, None], PLANAR_ROWS]


def spatial_stiffness(
    anchors: ArrayLike,
    attachments: ArrayLike,
    position: ArrayLike,
    rotation: ArrayLike,
    tensions: ArrayLike,
    rates: ArrayLike,
    weight: ArrayLike = (0.0, 0.0, 0.0),
    centre: ArrayLike = (0.0, 0.0, 0.0),
    axes: ArrayLike | None = None,
    radii: ArrayLike | None = None,
) -> Array:
    """Stiffness of a spatial robot in (rotation; displacement), both in world axes.

    Args:
        anchors: (..., m, 3) [m].
        attachments: In the platform frame, (m, 3) [m].
        position: (..., 3) [m].
        rotation: From platform to world, (..., 3, 3).
        tensions: (..., m) [N].
        rates: See `cable_rates`, (..., m) or a scalar [N/m]; 0 for the stiffness at constant tension.
        weight: Gravity force, (3,) [N].
        centre: Centre of mass in the platform frame, (3,) [m].
        axes: Swivel axes of pulleys, (m, 3); none for straight cables.
        radii: Of the pulleys, (m,) or a scalar [m].

    Returns:
        Symmetric, (..., 6, 6): N m in the rotations, N/m in the displacements, N between them.

    Raises:
        InputError: A shape that does not fit, radii that are negative or not finite, or one matrix that is no rotation.
    """
    local = rows("attachments", attachments, 3)
    m = len(local)
    fixed, place = vectors("anchors", anchors, m, 3), vectors("position", position, 3)
    turn, pull = rotation_matrices("rotation", rotation), vectors("tensions", tensions, m)
    rate = each_cable("rates", rates, m)
    load, middle = one("weight", weight, 3), one("centre", centre, 3)
    swivels, wheels = unit_axes(axes, m), pulley_radii(radii, m)
    shape = leading(
        ("anchors", fixed.shape, 2),
        ("position", place.shape, 1),
        ("rotation", turn.shape, 2),
        ("tensions", pull.shape, 1),
        ("rates", rate.shape, 1),
    )
    out = np.empty((math.prod(shape), 6, 6))
    _stiffness_each(
        spread(fixed, shape, (m, 3)),
        swivels,
        wheels,
        np.array(local, order="C"),
        spread(place, shape, (3,)),
        spread(turn, shape, (3, 3)),
        spread(pull, shape, (m,)),
        spread(rate, shape, (m,)),
        load,
        middle[None],
        out,
    )
    return out.reshape(*shape, 6, 6)


def turn_about_z(phi: ArrayLike) -> Array:
    """Rotation matrices of planar orientations, (..., 3, 3).

    Args:
        phi: (...) [rad]; not a number in every entry of the turn where one is infinite.

    Raises:
        InputError: No numbers.
    """
    angle = angles("phi", phi)
    out = np.zeros((*angle.shape, 3, 3))
    out[..., 0, 0] = out[..., 1, 1] = np.cos(angle)
    out[..., 1, 0] = np.sin(angle)
    out[..., 0, 1] = -out[..., 1, 0]
    out[..., 2, 2] = 1.0
    return out


@njit(cache=True, error_model="numpy")
def _stiffness_each(
    anchors: Array, axes: Array, radii: Array, attachments: Array, positions: Array, rotations: Array,
    tensions: Array, rates: Array, weight: Array, centre: Array, out: Array,
) -> None:  # fmt: skip
    """Stiffness of every pose of a batch (k), written to ``out`` (k, 6, 6); shapes as of `spatial_stiffness`."""
    along, across, arm, point, bend = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty((3, 3))
    for k in range(positions.shape[0]):
        out[k] = 0.0
        for i in range(attachments.shape[0]):
            if tensions[k, i] <= 0.0:
                continue
            arm_of(rotations[k], attachments, i, arm)
            size = 0.0
            for p in range(3):
                point[p] = positions[k, p] + arm[p]
                size += abs(point[p]) + abs(anchors[k, i, p])
            length, inside, outside = cable_run(anchors[k], axes, radii, i, point, along, across)
            if not length > SHORTEST * size:
                out[k] = np.nan
                break
            add_cable(arm, along, across, inside, outside, tensions[k, i], rates[k, i], bend, out[k])
        arm_of(rotations[k], centre, 0, arm)
        add_turn(1.0, weight, arm, out[k])
        if not math.isfinite(out[k].sum()):
            out[k] = np.nan
