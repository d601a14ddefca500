"""What moving takes while one gripper holds alone, for the oracle: rigid bodies by Newton and Euler, from rest.

How a body (`oracle_bodies`) moves with the freedoms are differences of its frames, as the gripper that holds sees it.
Weight and inertia of all of them are the load on that gripper; their virtual work is what the drives do.
"""

from __future__ import annotations

import numpy as np
from oracle_bodies import UPPER, Array, Bodies

STEP = 1e-5  # [m] and [rad] of the differences


def loads(bodies: Bodies, freedoms: Array, gravity: Array, rates: Array, upper: bool) -> tuple[Array, Array]:
    """Weight and inertia on the gripper that holds alone, in its frame, (moment; force).

    Args:
        bodies: The machine.
        freedoms: (x, w, alpha, beta), (k, 4) [m, m, rad, rad].
        gravity: In the lower gripper's frame, (k, 3) [m/s2].
        rates: Accelerations of the freedoms, of j motions each, (k, j, 4).
        upper: Whether it is the upper gripper.

    Returns:
        (k, 6) and (k, j, 6) [N m, N].
    """
    frames, pull = _held(bodies, freedoms, gravity, upper)
    arms = _middles(bodies, frames)
    weight = _wrench(arms, bodies.masses[:, None] * pull[:, None], np.zeros_like(arms))
    momenta = _momenta(bodies, frames, *_motions(bodies, freedoms, rates, upper))
    return weight, -_wrench(arms[:, None], *momenta)


def drives(bodies: Bodies, freedoms: Array, gravity: Array, rates: Array, upper: bool) -> Array:
    """Parts of their force and torque that the hardest driven cylinder and the servo take.

    Args:
        bodies: The machine.
        freedoms: As of `loads`, and the others.
        gravity: In the lower gripper's frame.
        rates: Of motions that may go to either side, and all at once.
        upper: Whether it is the upper gripper that holds.

    Returns:
        (k, 2) [1].
    """
    frames, pull = _held(bodies, freedoms, gravity, upper)
    linear, angular = _motions(bodies, freedoms, np.broadcast_to(np.eye(4), (len(freedoms), 4, 4)), upper)
    forces, moments = _momenta(bodies, frames, *_motions(bodies, freedoms, rates, upper))
    against = np.einsum("kfni,kjni->kjf", linear, forces) + np.einsum("kfni,kjni->kjf", angular, moments)
    hanging = -np.einsum("kfni,n,ki->kf", linear, bodies.masses, pull)[:, None]
    works = np.concatenate((hanging, against), axis=1)
    steps = STEP * np.eye(3)
    lengths = [bodies.lengths((freedoms[:, None, :3] + sign * steps).reshape(-1, 3)) for sign in (1.0, -1.0)]
    slopes = ((lengths[0] - lengths[1]) / (2.0 * STEP)).reshape(-1, 3, 3)  # (k, freedom, cylinder)
    cylinders = np.swapaxes(np.linalg.solve(slopes, np.swapaxes(works[..., :3], -1, -2)), -1, -2)
    cylinders[:, 1:] += bodies.robot.build.screw_inertia * rates[..., :3] @ slopes
    force = np.abs(cylinders).sum(axis=1).max(axis=-1) / bodies.robot.cylinders.force
    return np.stack((force, np.abs(works[..., 3]).sum(axis=1) / bodies.robot.build.servo_torque), axis=-1)


def _held(bodies: Bodies, freedoms: Array, gravity: Array, upper: bool) -> tuple[Array, Array]:
    """Frames of the bodies and gravity as the gripper that holds sees them."""
    frames = bodies.frames(freedoms)
    pull = np.einsum("kji,kj->ki", frames[:, UPPER, :3, :3], gravity) if upper else gravity
    return _seen(frames, upper), pull


def _seen(frames: Array, upper: bool) -> Array:
    """Frames of the bodies in that of the lower or of the upper gripper."""
    return np.linalg.inv(frames[:, UPPER])[:, None] @ frames if upper else frames


def _middles(bodies: Bodies, frames: Array) -> Array:
    return (frames[..., :3, :3] @ bodies.middles[..., None])[..., 0] + frames[..., :3, 3]


def _motions(bodies: Bodies, freedoms: Array, rates: Array, upper: bool) -> tuple[Array, Array]:
    """Of the bodies' middles and axes where the freedoms go at rates (k, j, 4), (k, j, n, 3) each."""
    size = np.abs(rates).max(axis=-1, keepdims=True)
    steps = STEP * rates / np.where(size > 0.0, size, 1.0)
    ends = [(freedoms[:, None] + sign * steps).reshape(-1, 4) for sign in (1.0, -1.0)]
    ahead, back = (_seen(bodies.frames(end), upper) for end in ends)
    scale = (size / (2.0 * STEP)).reshape(-1, 1, 1)
    linear = scale * (_middles(bodies, ahead) - _middles(bodies, back))
    spin = (ahead - back)[..., :3, :3] @ np.swapaxes((ahead + back)[..., :3, :3], -1, -2) / 2.0
    angular = scale * np.stack((spin[..., 2, 1], spin[..., 0, 2], spin[..., 1, 0]), axis=-1)
    shape = (*rates.shape[:2], len(bodies.masses), 3)
    return linear.reshape(shape), angular.reshape(shape)


def _momenta(bodies: Bodies, frames: Array, linear: Array, angular: Array) -> tuple[Array, Array]:
    """Forces and moments that give bodies accelerations (k, j, n, 3)."""
    turned = frames[..., :3, :3] @ bodies.inertias @ np.swapaxes(frames[..., :3, :3], -1, -2)
    return bodies.masses[:, None] * linear, np.einsum("knab,kjnb->kjna", turned, angular)


def _wrench(arms: Array, forces: Array, moments: Array) -> Array:
    """Sum of forces and moments on all bodies, about the origin."""
    return np.concatenate(((np.cross(arms, forces) + moments).sum(axis=-2), forces.sum(axis=-2)), axis=-1)
