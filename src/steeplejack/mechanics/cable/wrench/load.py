"""Wrenches that mass puts on a platform: gravity, and the inertia of a given motion (d'Alembert).

With them a dynamic question is a static one: tensions balance ``gravity + inertial + external`` wrenches. All are about
the platform's reference point, in world axes: planar (fx, fy, mz), spatial (moment; force).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def gravity_wrench(mass: ArrayLike, gravity: ArrayLike, arm: ArrayLike) -> Array:
    """Wrench of gravity, a force ``m g`` at the centre of mass.

    Args:
        mass: (...) [kg].
        gravity: Acceleration of free fall, (..., 2) or (..., 3) [m/s2].
        arm: Centre of mass from the reference point, world axes, (..., 2) or (..., 3) [m].

    Returns:
        (fx, fy, mz), (..., 3), or (moment; force), (..., 6) [N, N m].
    """
    force = np.asarray(mass, dtype=np.float64)[..., None] * np.asarray(gravity, dtype=np.float64)
    lever = np.asarray(arm, dtype=np.float64)
    force, lever = np.broadcast_arrays(force, lever)
    if force.shape[-1] == 2:
        return _planar(force, lever, np.zeros(force.shape[:-1]))
    return np.concatenate((np.cross(lever, force), force), axis=-1)


def inertial_wrench(
    mass: ArrayLike,
    inertia: ArrayLike,
    centre: ArrayLike,
    rotation: ArrayLike,
    angular_velocity: ArrayLike,
    acceleration: ArrayLike,
) -> Array:
    """Wrench of inertia of a spatial platform, the negative rate of its momentum.

    With ``c = R centre`` and ``I = R inertia R^T``: force ``-m (a + alpha x c + omega x (omega x c))``, moment
    ``-(I alpha + omega x I omega) + c x force``.

    Args:
        mass: (...) [kg].
        inertia: About the centre of mass, platform frame, (..., 3, 3) [kg m2].
        centre: Centre of mass in the platform frame, (..., 3) [m].
        rotation: From platform to world, (..., 3, 3).
        angular_velocity: ``omega``, world axes, (..., 3) [rad/s].
        acceleration: ``(alpha; a)``, angular, and linear of the reference point, world axes, (..., 6) [rad/s2, m/s2].

    Returns:
        (moment; force), (..., 6) [N m, N].
    """
    turn, omega, rate = (np.asarray(v, dtype=np.float64) for v in (rotation, angular_velocity, acceleration))
    alpha, linear = rate[..., :3], rate[..., 3:]
    arm = np.einsum("...ij,...j->...i", turn, np.asarray(centre, dtype=np.float64))
    turned = turn @ np.asarray(inertia, dtype=np.float64) @ np.swapaxes(turn, -1, -2)
    of_centre = linear + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
    force = -np.asarray(mass, dtype=np.float64)[..., None] * of_centre
    spin = np.einsum("...ij,...j->...i", turned, omega)
    moment = -np.einsum("...ij,...j->...i", turned, alpha) - np.cross(omega, spin) + np.cross(arm, force)
    return np.concatenate(np.broadcast_arrays(moment, force), axis=-1)


def planar_inertial_wrench(
    mass: ArrayLike, inertia: ArrayLike, centre: ArrayLike, phi: ArrayLike, rate: ArrayLike, acceleration: ArrayLike
) -> Array:
    """Wrench of inertia of a planar platform, the negative rate of its momentum.

    Args:
        mass: (...) [kg].
        inertia: About the centre of mass, (...) [kg m2].
        centre: Centre of mass in the platform frame, (..., 2) [m].
        phi: Orientation, (...) [rad].
        rate: Its rate, (...) [rad/s].
        acceleration: ``(ax, ay, alpha)``, linear of the reference point, and angular, (..., 3) [m/s2, rad/s2].

    Returns:
        (fx, fy, mz), (..., 3) [N, N, N m].
    """
    local, motion = np.asarray(centre, dtype=np.float64), np.asarray(acceleration, dtype=np.float64)
    angle, speed = np.asarray(phi, dtype=np.float64)[..., None], np.asarray(rate, dtype=np.float64)[..., None]
    cos, sin, x, y = np.cos(angle), np.sin(angle), local[..., :1], local[..., 1:]
    arm = np.concatenate((cos * x - sin * y, sin * x + cos * y), axis=-1)
    alpha = motion[..., 2:]
    of_centre = motion[..., :2] + alpha * np.stack((-arm[..., 1], arm[..., 0]), axis=-1) - speed**2 * arm
    force = -np.asarray(mass, dtype=np.float64)[..., None] * of_centre
    return _planar(force, arm, -np.asarray(inertia, dtype=np.float64) * alpha[..., 0])


def _planar(force: Array, arm: Array, couple: Array) -> Array:
    """(fx, fy, mz) of a force at an arm and a couple."""
    moment = couple + arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0]
    return np.concatenate((force, moment[..., None]), axis=-1)
