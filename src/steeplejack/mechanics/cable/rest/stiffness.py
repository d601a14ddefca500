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

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.pulleys import cable_run, in_space, pulley_radii, unit_axes

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
    """
    force = np.asarray(axial_stiffness, dtype=np.float64) + np.maximum(np.asarray(tensions, dtype=np.float64), 0.0)
    with np.errstate(divide="ignore"):
        return force / np.asarray(lengths, dtype=np.float64)


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
        InputError: A shape that does not fit.
    """
    where = np.asarray(pose, dtype=np.float64)
    full = spatial_stiffness(
        in_space(np.asarray(anchors, dtype=np.float64)),
        in_space(np.asarray(attachments, dtype=np.float64)),
        in_space(where[..., :2]),
        turn_about_z(where[..., 2]),
        tensions,
        rates,
        in_space(np.asarray(weight, dtype=np.float64)),
        in_space(np.asarray(centre, dtype=np.float64)),
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
        InputError: A shape that does not fit.
    """
    fixed, place, turn, pull, rate = (
        np.asarray(value, dtype=np.float64) for value in (anchors, position, rotation, tensions, rates)
    )
    local, load, middle = (np.array(value, dtype=np.float64) for value in (attachments, weight, centre))
    if local.ndim != 2 or local.shape[1] != 3:
        raise InputError("attachments", f"shape {local.shape}", "(m, 3)")
    m = len(local)
    swivels, wheels = unit_axes(axes, m), np.asarray(0.0 if radii is None else radii, dtype=np.float64)
    _check("anchors", fixed, (m, 3))
    _check("position", place, (3,))
    _check("rotation", turn, (3, 3))
    _check("tensions", pull, (m,))
    for where, value, tail in (("rates", rate, (m,)), ("radii", wheels, (m,))):
        if value.ndim:
            _check(where, value, tail)
    for where, value, whole in (("axes", swivels, (m, 3)), ("weight", load, (3,)), ("centre", middle, (3,))):
        if value.shape != whole:
            raise InputError(where, f"shape {value.shape}", f"{whole}")
    try:
        shape = np.broadcast_shapes(
            fixed.shape[:-2], place.shape[:-1], turn.shape[:-2], pull.shape[:-1], rate.shape[:-1] if rate.ndim else ()
        )
    except ValueError:
        raise InputError("poses", "leading axes that do not fit each other", "axes that broadcast") from None
    out = np.empty((math.prod(shape), 6, 6))
    _stiffness_each(
        _stack(fixed, shape, (m, 3)),
        swivels,
        pulley_radii(wheels, m),
        local,
        _stack(place, shape, (3,)),
        _stack(turn, shape, (3, 3)),
        _stack(pull, shape, (m,)),
        _stack(rate, shape, (m,)),
        load,
        middle,
        out,
    )
    return out.reshape(*shape, 6, 6)


def turn_about_z(phi: ArrayLike) -> Array:
    """Rotation matrices of planar orientations, (..., 3, 3).

    Args:
        phi: (...) [rad].
    """
    angle = np.asarray(phi, dtype=np.float64)
    out = np.zeros((*angle.shape, 3, 3))
    out[..., 0, 0] = out[..., 1, 1] = np.cos(angle)
    out[..., 1, 0] = np.sin(angle)
    out[..., 0, 1] = -out[..., 1, 0]
    out[..., 2, 2] = 1.0
    return out


def _check(where: str, values: Array, tail: tuple[int, ...]) -> None:
    """Refuse values whose last axes are not these."""
    if values.shape[-len(tail) :] != tail:
        raise InputError(where, f"shape {values.shape}", f"(..., {', '.join(map(str, tail))})")


def _stack(values: Array, shape: tuple[int, ...], tail: tuple[int, ...]) -> Array:
    """Broadcast to ``shape + tail``, leading axes flattened to one; always a copy, so that one compilation serves."""
    return np.array(np.broadcast_to(values, (*shape, *tail)), order="C").reshape(-1, *tail)


@njit(cache=True, error_model="numpy")
def _stiffness_each(
    anchors: Array, axes: Array, radii: Array, attachments: Array, positions: Array, rotations: Array,
    tensions: Array, rates: Array, weight: Array, centre: Array, out: Array,
) -> None:  # fmt: skip
    """Stiffness of every pose of a batch (k), written to ``out`` (k, 6, 6); shapes as of `spatial_stiffness`."""
    along, across, arm, point, force = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    bend, lever = np.empty((3, 3)), np.zeros((3, 6))
    lever[0, 3] = lever[1, 4] = lever[2, 5] = 1.0
    m = attachments.shape[0]
    for k in range(positions.shape[0]):
        out[k] = 0.0
        for i in range(m):
            if tensions[k, i] <= 0.0:
                continue
            _turn(rotations[k], attachments[i], arm)
            size = 0.0
            for p in range(3):
                point[p] = positions[k, p] + arm[p]
                size += abs(point[p]) + abs(anchors[k, i, p])
            length, inside, outside = cable_run(anchors[k], axes, radii, i, point, along, across)
            if not length > SHORTEST * size:
                out[k] = np.nan
                break
            for p in range(3):
                force[p] = tensions[k, i] * along[p]
                for q in range(3):
                    bend[p, q] = (rates[k, i] - inside * tensions[k, i]) * along[p] * along[q]
                    bend[p, q] += (outside - inside) * tensions[k, i] * across[p] * across[q]
                bend[p, p] += inside * tensions[k, i]
            lever[0, 1], lever[0, 2] = arm[2], -arm[1]
            lever[1, 0], lever[1, 2] = -arm[2], arm[0]
            lever[2, 0], lever[2, 1] = arm[1], -arm[0]
            _add_bend(bend, lever, out[k])
            _add_turn(force, arm, out[k])
        _turn(rotations[k], centre, arm)
        _add_turn(weight, arm, out[k])
        if not math.isfinite(out[k].sum()):
            out[k] = np.nan


@njit(cache=True)
def _turn(rotation: Array, point: Array, arm: Array) -> None:
    """Write ``rotation @ point``."""
    for p in range(3):
        arm[p] = rotation[p, 0] * point[0] + rotation[p, 1] * point[1] + rotation[p, 2] * point[2]


@njit(cache=True)
def _add_bend(bend: Array, lever: Array, out: Array) -> None:
    """Add ``lever^T bend lever``."""
    for j in range(6):
        for p in range(3):
            carried = bend[p, 0] * lever[0, j] + bend[p, 1] * lever[1, j] + bend[p, 2] * lever[2, j]
            for i in range(6):
                out[i, j] += lever[p, i] * carried


@njit(cache=True)
def _add_turn(force: Array, arm: Array, out: Array) -> None:
    """Add ``(f . r) I - (f r^T + r f^T) / 2`` to the rotations."""
    dot = force[0] * arm[0] + force[1] * arm[1] + force[2] * arm[2]
    for p in range(3):
        out[p, p] += dot
        for q in range(3):
            out[p, q] -= 0.5 * (force[p] * arm[q] + arm[p] * force[q])
