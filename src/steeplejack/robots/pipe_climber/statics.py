"""Static forces: actuators for a wrench, the largest load within their limit, and what the grip holds.

By virtual work ``J^T f + wrench = 0``, with f positive where a limb pushes (lengthens) and the wrench, on the platform
at O2, as (F_x, F_z, M_y), the power of each on the rates of (x, w, alpha). Hinges without friction, limbs without
weight; forces out of the plane are carried by the hinges and are no matter of the actuators.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.parameters import Gripper
from steeplejack.robots.pipe_climber.poses import Array, triples

SINGULAR = 1e-12
"""det J in parts of the rows' lengths below which no forces balance a general wrench [1]."""


@dataclass(frozen=True)
class Load:
    """The largest load of a direction that the actuators hold.

    Attributes:
        size: How often the direction's wrench [1]; NaN where even the preload is not held or the pose is singular.
        limb: Which limb is then at its limit, 1 to 3; 0 where size is NaN.
        forces: What the actuators then push with, (..., 3) [N].
    """

    size: Array
    limb: Array
    forces: Array


def actuator_forces(layout: Layout, poses: ArrayLike, wrenches: ArrayLike) -> Array:
    """Forces of the actuators that balance a wrench on the platform, ``f = -J^-T wrench``.

    Args:
        layout: Hinges.
        poses: (x, w, alpha), (..., 3) [m, m, rad].
        wrenches: (F_x, F_z, M_y) at O2, (..., 3) [N, N, N m].

    Returns:
        (..., 3), positive where a limb pushes [N]; NaN at a singular pose.
    """
    pose, wrench = np.broadcast_arrays(triples("poses", poses), triples("wrenches", wrenches))
    rows = jacobian(layout, pose)
    sizes = np.linalg.norm(rows, axis=-1).prod(axis=-1)
    good = np.abs(np.linalg.det(rows)) > SINGULAR * sizes
    safe = np.where(good[..., None, None], rows, np.eye(3))
    forces = -np.linalg.solve(np.swapaxes(safe, -1, -2), wrench[..., None])[..., 0]
    return np.where(good[..., None], forces, np.nan)


def largest_load(
    layout: Layout, poses: ArrayLike, direction: ArrayLike, limit: float, preload: ArrayLike = (0.0, 0.0, 0.0)
) -> Load:
    """The largest multiple of a wrench that the actuators hold, on top of a preload.

    Args:
        layout: Hinges.
        poses: (..., 3) [m, m, rad].
        direction: The unit of load, for example (0, -1, 0) for 1 N against Z, (..., 3) [N, N, N m].
        limit: Largest push and pull of an actuator [N].
        preload: Wrench that acts anyhow, (..., 3) [N, N, N m].

    Returns:
        The load, the limb that limits it, and the forces.

    Raises:
        InputError: A limit that is not above 0, a direction of zeros.
    """
    if not 0.0 < limit < math.inf:
        raise InputError("limit", f"{limit:g} N", "a finite force above 0 N")
    if not np.any(np.asarray(direction), axis=-1).all():
        raise InputError("direction", "a wrench of zeros", "a wrench to take multiples of")
    each, still = actuator_forces(layout, poses, direction), actuator_forces(layout, poses, preload)
    each, still = np.broadcast_arrays(each, still)
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.where(each == 0.0, np.inf, (limit - np.sign(each) * still) / np.abs(each))
    held = (np.abs(still) <= limit).all(axis=-1) & np.isfinite(each).all(axis=-1)
    size = np.where(held, room.min(axis=-1), np.nan)
    limb = np.where(held, room.argmin(axis=-1) + 1, 0)
    return Load(size, limb, still + size[..., None] * each)


def friction_needed(gripper: Gripper, axial: float, torque: float = 0.0, radius: float | None = None) -> float:
    """Least coefficient of friction with which a gripper holds a load on a pipe.

    Every jaw presses with its force and resists along the pipe and around it together: ``mu >= sqrt(F^2 + (T/r)^2) /
    (jaws * force)``. Tilting moments, which load jaws unevenly, are not in it.

    Args:
        gripper: Jaws and their force.
        axial: Force along the pipe [N].
        torque: About the pipe [N m].
        radius: Of the pipe, which a torque needs [m].

    Returns:
        Coefficient [1].

    Raises:
        InputError: A load that is not finite, a radius that is not above 0, a torque without a radius.
    """
    if not (math.isfinite(axial) and math.isfinite(torque)):
        raise InputError("load of the grip", f"{axial:g} N, {torque:g} N m", "a finite force and a finite torque")
    if radius is None and torque != 0.0:
        raise InputError("radius", f"none with a torque of {torque:g} N m", "the radius of the pipe")
    if radius is not None and not 0.0 < radius < math.inf:
        raise InputError("radius", f"{radius:g} m", "a finite length above 0 m")
    around = 0.0 if radius is None else torque / radius
    return math.hypot(axial, around) / (gripper.jaws * gripper.force)


def grip_margin(gripper: Gripper, axial: float, torque: float = 0.0, radius: float | None = None) -> float:
    """How far the grip is from slipping: 1 - needed / available friction; negative where it slips.

    Args:
        gripper: Jaws, their force and their friction.
        axial: Force along the pipe [N].
        torque: About the pipe [N m].
        radius: Of the pipe, which a torque needs [m].

    Returns:
        Margin [1].

    Raises:
        InputError: As `friction_needed`.
    """
    return 1.0 - friction_needed(gripper, axial, torque, radius) / gripper.friction
