"""Rates and accelerations of every joint of every limb, in closed form.

A limb is a vector of polar coordinates: length q and angle theta from Z about Y, ``n = (sin theta, cos theta)`` and
``t = dn/dtheta = (cos theta, -sin theta)`` in X-Z. With P the platform joint, moving with the platform,

    qd = n . Pd          thetad = t . Pd / q
    qdd = n . Pdd + q thetad^2          thetadd = (t . Pdd - 2 qd thetad) / q

and the hinge at P turns by ``alpha - theta``. `screws` arrives at the same numbers through Eq. 15-25 of Ye et al.
(Robotica 2024) as corrected there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from steeplejack.robots.pipe_climber.inverse import limb_vectors
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.poses import Array, triples


def joint_rates(layout: Layout, poses: ArrayLike, velocities: ArrayLike) -> Array:
    """Rates of the joints: hinge at B_i, actuator, hinge at P_i.

    Args:
        layout: Hinges.
        poses: (x, w, alpha) of O2, (..., 3) [m, m, rad].
        velocities: Their rates, (..., 3) [m/s, m/s, rad/s].

    Returns:
        (..., 3 limbs, 3 joints) [rad/s, m/s, rad/s], turns about Y; NaN where a limb has no length.
    """
    pose, rate = np.broadcast_arrays(triples("poses", poses), triples("velocities", velocities))
    lengths, n, t = _frames(layout, pose)
    arms = _arms(layout, pose)
    point = rate[..., None, :2] + rate[..., 2, None, None] * _quarter(arms)
    theta = _dot(t, point) / lengths
    return np.stack((theta, _dot(n, point), rate[..., 2, None] - theta), axis=-1)


def joint_accelerations(layout: Layout, poses: ArrayLike, velocities: ArrayLike, accelerations: ArrayLike) -> Array:
    """Accelerations of the joints: hinge at B_i, actuator, hinge at P_i.

    Args:
        layout: Hinges.
        poses: (x, w, alpha) of O2, (..., 3) [m, m, rad].
        velocities: Their first derivatives, (..., 3) [m/s, m/s, rad/s].
        accelerations: Their second derivatives, (..., 3) [m/s2, m/s2, rad/s2].

    Returns:
        (..., 3 limbs, 3 joints) [rad/s2, m/s2, rad/s2]; NaN where a limb has no length.
    """
    pose, rate, second = np.broadcast_arrays(
        triples("poses", poses), triples("velocities", velocities), triples("accelerations", accelerations)
    )
    lengths, n, t = _frames(layout, pose)
    arms = _arms(layout, pose)
    rates = joint_rates(layout, pose, rate)
    turn, turn_rate = rate[..., 2, None, None], second[..., 2, None, None]
    point = second[..., None, :2] + turn_rate * _quarter(arms) - turn**2 * arms
    theta = (_dot(t, point) - 2.0 * rates[..., 1] * rates[..., 0]) / lengths
    length = _dot(n, point) + lengths * rates[..., 0] ** 2
    return np.stack((theta, length, second[..., 2, None] - theta), axis=-1)


def _frames(layout: Layout, poses: Array) -> tuple[Array, Array, Array]:
    """Lengths (..., 3), directions n and tangents t of the limbs (..., 3, 2)."""
    vectors = limb_vectors(layout, poses)
    lengths = np.hypot(vectors[..., 0], vectors[..., 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        n = vectors / np.where(lengths > 0.0, lengths, np.nan)[..., None]
    return lengths, n, _quarter(n)


def _arms(layout: Layout, poses: Array) -> Array:
    """Vectors from O2 to P_i in X-Z, (..., 3, 2) [m]."""
    alpha = poses[..., 2, None]
    return np.stack((layout.platform * np.cos(alpha), -layout.platform * np.sin(alpha)), axis=-1)


def _quarter(vectors: Array) -> Array:
    """Vectors in X-Z turned by a quarter about Y: (x, z) to (z, -x)."""
    return np.stack((vectors[..., 1], -vectors[..., 0]), axis=-1)


def _dot(a: Array, b: Array) -> Array:
    return (a * b).sum(axis=-1)
