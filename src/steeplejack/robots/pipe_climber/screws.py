"""The same kinematics by screws: joint twists, transmission wrenches, influence matrices, Lie brackets.

Follows section 4.4-4.5 of Ye et al. (Robotica 2024). Everything is spatial, expressed in the base frame with moments
and velocities at O1; twists are (angular; linear), wrenches (moment; force). What had to be corrected:

- Eq. 14: the wrenches' moments are about O1, ``P_i x n_i``, so the twist they meet must be the one at O1 as well; the
  paper pairs them with the twist at O2.
- Eq. 16: row i needs its own wrench; printed, S_T1 stands in all three.
- Eq. 18: J_q holds ``S_Ti o S_i2``; printed with S_i1, which is reciprocal to S_Ti, it is the zero matrix.
- Eq. 19: ``G_i = J_i^-1 J_T^-1 J_q``; printed, the inverse of the whole product maps the wrong way.
- Eq. 22: only joints up to j enter.
- Eq. 24: the products are Lie brackets of joint twists with joint *rates* as factors; printed, it multiplies reciprocal
  products of *accelerations*.
- Eq. 26: the second entry is the acceleration of the point at the reference, ``a - omega x v``, of the link after joint
  j, so it too is a partial sum.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from steeplejack.mechanics.limb.screws import force, prismatic, revolute
from steeplejack.robots.pipe_climber.inverse import limb_vectors
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.poses import Array, triples

Y_AXIS = (0.0, 1.0, 0.0)
PLANAR = [1, 3, 5]
"""Entries of a twist that a mechanism in X-Z can have: omega_y, v_x, v_z."""


def joint_twists(layout: Layout, poses: ArrayLike) -> Array:
    """Unit twists of the joints of every limb (Eq. 1): hinge at B_i, actuator, hinge at P_i.

    Args:
        layout: Hinges.
        poses: (x, w, alpha) of O2, (..., 3) [m, m, rad].

    Returns:
        (..., 3 limbs, 3 joints, 6), (angular; linear) at O1.
    """
    vectors = limb_vectors(layout, poses)
    base = np.zeros((*vectors.shape[:-1], 3))
    base[..., 0] = layout.base
    joints = revolute(Y_AXIS, base), prismatic(_unit(vectors)), revolute(Y_AXIS, base + _spatial(vectors))
    return np.stack(joints, axis=-2)


def transmission_wrenches(layout: Layout, poses: ArrayLike) -> Array:
    """Unit wrenches the actuators exert on the platform (Eq. 14): a force along each limb.

    Args:
        layout: Hinges.
        poses: (..., 3) [m, m, rad].

    Returns:
        (..., 3 limbs, 6), (moment; force) about O1 [m, 1].
    """
    vectors = limb_vectors(layout, poses)
    point = _spatial(vectors)
    point[..., 0] += layout.base
    return force(_unit(vectors), point)


def platform_twist(poses: ArrayLike, velocities: ArrayLike) -> Array:
    """Twist of the platform at O1 from the rates of its pose.

    Args:
        poses: (..., 3) [m, m, rad].
        velocities: (..., 3) [m/s, m/s, rad/s].

    Returns:
        (..., 6), (angular; linear) [rad/s, m/s].
    """
    pose, rate = np.broadcast_arrays(triples("poses", poses), triples("velocities", velocities))
    origin, turn = _spatial(pose[..., :2]), np.zeros((*pose.shape[:-1], 3))
    turn[..., 1] = rate[..., 2]
    return np.concatenate((turn, _spatial(rate[..., :2]) - np.cross(turn, origin)), axis=-1)


def screw_jacobian(layout: Layout, poses: ArrayLike) -> Array:
    """The Jacobian of the lengths from screws (Eq. 16-18 corrected): ``J_q^-1 J_T`` on the twists of x, w and alpha.

    Args:
        layout: Hinges.
        poses: (..., 3) [m, m, rad].

    Returns:
        (..., 3, 3), equal to `jacobian`.
    """
    pose = triples("poses", poses)
    wrenches = transmission_wrenches(layout, pose)
    actuators = joint_twists(layout, pose)[..., 1, :]
    freedoms = platform_twist(pose[..., None, :], np.eye(3))
    powers = (wrenches * actuators).sum(axis=-1)
    return wrenches @ np.swapaxes(freedoms, -1, -2) / powers[..., None]


def joint_influence(layout: Layout, poses: ArrayLike) -> Array:
    """First-order influence matrices (Eq. 19-20 corrected): joint rates of each limb per actuator rate.

    Args:
        layout: Hinges.
        poses: (..., 3), off the singular surface [m, m, rad].

    Returns:
        ``G``, (..., 3 limbs, 3 joints, 3 actuators), with ``G_i qd`` the rates of limb i; row 1 of G_i is that of the
        unit matrix. NaN on the singular surface, where actuators do not determine the motion.
    """
    pose = triples("poses", poses)
    wrenches = transmission_wrenches(layout, pose)[..., PLANAR]
    actuators = joint_twists(layout, pose)[..., 1, PLANAR]
    powers = (wrenches * actuators).sum(axis=-1)
    platform = _inverse(wrenches) * powers[..., None, :]
    return _inverse(_limbs(layout, pose)) @ platform[..., None, :, :]


def screw_joint_rates(layout: Layout, poses: ArrayLike, velocities: ArrayLike) -> Array:
    """Rates of the joints from Eq. 15, ``J_i^-1 S_p``: the second route to `joint_rates`, same arguments."""
    pose, rate = np.broadcast_arrays(triples("poses", poses), triples("velocities", velocities))
    twist = platform_twist(pose, rate)[..., None, PLANAR, None]
    return np.asarray(np.linalg.solve(_limbs(layout, pose), twist)[..., 0], dtype=np.float64)


def screw_joint_accelerations(
    layout: Layout, poses: ArrayLike, velocities: ArrayLike, accelerations: ArrayLike
) -> Array:
    """Accelerations of the joints from Eq. 25, ``J_i^-1 (A - S_Li)``: the second route to `joint_accelerations`."""
    pose, rate, second = np.broadcast_arrays(
        triples("poses", poses), triples("velocities", velocities), triples("accelerations", accelerations)
    )
    scaled = joint_twists(layout, pose) * screw_joint_rates(layout, pose, rate)[..., None]
    rest = _platform_acceleration(pose, rate, second)[..., None, :] - brackets(scaled)[..., -1, :]
    return np.asarray(np.linalg.solve(_limbs(layout, pose), rest[..., PLANAR, None])[..., 0], dtype=np.float64)


def link_twists(layout: Layout, poses: ArrayLike, velocities: ArrayLike) -> Array:
    """Twist of the link after every joint (Eq. 21-22): the sum of the joints up to it.

    Args:
        layout: Hinges.
        poses: (..., 3) [m, m, rad].
        velocities: (..., 3) [m/s, m/s, rad/s].

    Returns:
        (..., 3 limbs, 3 joints, 6), (angular; linear) at O1; the last of each limb is the platform's.
    """
    rates = screw_joint_rates(layout, poses, velocities)
    return np.cumsum(joint_twists(layout, poses) * rates[..., None], axis=-2)


def link_accelerations(layout: Layout, poses: ArrayLike, velocities: ArrayLike, accelerations: ArrayLike) -> Array:
    """Reduced acceleration of the link after every joint (Eq. 23-26 corrected): ``(omegad; a - omega x v)`` at O1.

    Args:
        layout: Hinges.
        poses: (..., 3) [m, m, rad].
        velocities: (..., 3) [m/s, m/s, rad/s].
        accelerations: (..., 3) [m/s2, m/s2, rad/s2].

    Returns:
        (..., 3 limbs, 3 joints, 6); the last of each limb is the platform's.
    """
    twists = joint_twists(layout, poses)
    scaled = twists * screw_joint_rates(layout, poses, velocities)[..., None]
    seconds = screw_joint_accelerations(layout, poses, velocities, accelerations)
    return np.cumsum(twists * seconds[..., None], axis=-2) + brackets(scaled)


def brackets(twists: Array) -> Array:
    """``S_L`` (Eq. 24 corrected) up to every joint: the sum over pairs j < k of Lie brackets ``[S_j, S_k]``.

    Args:
        twists: Joint twists times their rates along a chain, (..., joints, 6).

    Returns:
        (..., joints, 6).
    """
    before = np.cumsum(twists, axis=-2) - twists
    return np.cumsum(lie_bracket(before, twists), axis=-2)


def lie_bracket(first: Array, second: Array) -> Array:
    """``[A, B] = (w_A x w_B; w_A x v_B + v_A x w_B)`` of twists (angular; linear), (..., 6)."""
    angular = np.cross(first[..., :3], second[..., :3])
    linear = np.cross(first[..., :3], second[..., 3:]) + np.cross(first[..., 3:], second[..., :3])
    return np.concatenate((angular, linear), axis=-1)


def _platform_acceleration(pose: Array, rate: Array, second: Array) -> Array:
    """Reduced acceleration of the platform at O1, (..., 6)."""
    turn = np.zeros((*pose.shape[:-1], 3))
    turn[..., 1] = rate[..., 2]
    origin = _spatial(second[..., :2]) - np.cross(turn, _spatial(rate[..., :2]))  # a - omega x v at O2
    angular = np.zeros_like(turn)
    angular[..., 1] = second[..., 2]
    return np.concatenate((angular, origin - np.cross(angular, _spatial(pose[..., :2]))), axis=-1)


def _limbs(layout: Layout, poses: Array) -> Array:
    """``J_i`` in the plane: the joints' twists as columns, (..., 3 limbs, 3, 3)."""
    return np.swapaxes(joint_twists(layout, poses)[..., PLANAR], -1, -2)


def _inverse(matrices: Array) -> Array:
    """Inverse of 3x3 matrices, NaN where they have none."""
    sizes = np.linalg.norm(matrices, axis=-1).prod(axis=-1)
    good = np.abs(np.linalg.det(matrices)) > 1e-14 * sizes
    inverse = np.linalg.inv(np.where(good[..., None, None], matrices, np.eye(3)))
    return np.where(good[..., None, None], inverse, np.nan)


def _unit(vectors: Array) -> Array:
    """Directions in space of vectors in X-Z, (..., 3)."""
    return _spatial(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _spatial(vectors: Array) -> Array:
    """Vectors (x, z) as (x, 0, z)."""
    x, z = vectors[..., 0], vectors[..., 1]
    return np.stack((x, np.zeros_like(x), z), axis=-1)
