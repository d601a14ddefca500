"""Wrenches that mass puts on a platform: gravity, and the inertia of a given motion (d'Alembert).

With them a dynamic question is a static one: tensions balance ``gravity + inertial + external`` wrenches. All are about
the platform's reference point, in world axes: planar (fx, fy, mz), spatial (moment; force).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import angles, leading, numbers, rotation_matrices, vectors

Array = NDArray[np.float64]


@np.errstate(invalid="ignore", over="ignore")
def gravity_wrench(mass: ArrayLike, gravity: ArrayLike, arm: ArrayLike) -> Array:
    """Wrench of gravity, a force ``m g`` at the centre of mass.

    Args:
        mass: (...) [kg].
        gravity: Acceleration of free fall, (..., 2) or (..., 3) [m/s2].
        arm: Centre of mass from the reference point, world axes, (..., 2) or (..., 3) [m].

    Returns:
        (fx, fy, mz), (..., 3), or (moment; force), (..., 6) [N, N m].

    Raises:
        InputError: No numbers, neither two nor three axes, or shapes that do not match.
    """
    fall, heavy = vectors("gravity", gravity, "axes"), numbers("mass", mass)
    axes = fall.shape[-1]
    if axes not in (2, 3):
        raise InputError("gravity", f"shape {fall.shape}", "(..., 2) or (..., 3)")
    lever = vectors("arm", arm, axes)
    leading(("mass", heavy.shape, 0), ("gravity", fall.shape, 1), ("arm", lever.shape, 1))
    force, lever = np.broadcast_arrays(heavy[..., None] * fall, lever)
    if force.shape[-1] == 2:
        return _planar(force, lever, np.zeros(force.shape[:-1]))
    return np.concatenate((np.cross(lever, force), force), axis=-1)


@np.errstate(invalid="ignore", over="ignore")
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

    Raises:
        InputError: No numbers, shapes that do not match, or one matrix that is no rotation.
    """
    heavy, tensor, middle = numbers("mass", mass), vectors("inertia", inertia, 3, 3), vectors("centre", centre, 3)
    turn, omega = rotation_matrices("rotation", rotation), vectors("angular velocity", angular_velocity, 3)
    rate = vectors("acceleration", acceleration, 6)
    leading(
        ("mass", heavy.shape, 0),
        ("inertia", tensor.shape, 2),
        ("centre", middle.shape, 1),
        ("rotation", turn.shape, 2),
        ("angular velocity", omega.shape, 1),
        ("acceleration", rate.shape, 1),
    )
    alpha, linear = rate[..., :3], rate[..., 3:]
    arm = np.einsum("...ij,...j->...i", turn, middle)
    turned = turn @ tensor @ np.swapaxes(turn, -1, -2)
    of_centre = linear + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
    force = -heavy[..., None] * of_centre
    spin = np.einsum("...ij,...j->...i", turned, omega)
    moment = -np.einsum("...ij,...j->...i", turned, alpha) - np.cross(omega, spin) + np.cross(arm, force)
    return np.concatenate(np.broadcast_arrays(moment, force), axis=-1)


@np.errstate(invalid="ignore", over="ignore")
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

    Raises:
        InputError: No numbers, or shapes that do not match.
    """
    heavy, round_centre = numbers("mass", mass), numbers("inertia", inertia)
    local, motion = vectors("centre", centre, 2), vectors("acceleration", acceleration, 3)
    angle, speed = angles("phi", phi)[..., None], numbers("rate", rate)[..., None]
    shape = leading(
        ("mass", heavy.shape, 0),
        ("inertia", round_centre.shape, 0),
        ("centre", local.shape, 1),
        ("phi", angle.shape, 1),
        ("rate", speed.shape, 1),
        ("acceleration", motion.shape, 1),
    )
    cos, sin, x, y = np.cos(angle), np.sin(angle), local[..., :1], local[..., 1:]
    arm = np.broadcast_to(np.concatenate((cos * x - sin * y, sin * x + cos * y), axis=-1), (*shape, 2))
    alpha = motion[..., 2:]
    of_centre = motion[..., :2] + alpha * np.stack((-arm[..., 1], arm[..., 0]), axis=-1) - speed**2 * arm
    force = -heavy[..., None] * of_centre
    return _planar(force, arm, -round_centre * alpha[..., 0])


def _planar(force: Array, arm: Array, couple: Array) -> Array:
    """(fx, fy, mz) of a force at an arm and a couple."""
    moment = couple + arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0]
    return np.concatenate((force, moment[..., None]), axis=-1)
