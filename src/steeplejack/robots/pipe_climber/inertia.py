"""What a move's acceleration puts on the gripper that holds alone and on the drives: inertia, d'Alembert's way.

The robot is points of mass. Every part is a box of even density, as in the physics, which takes its boxes from here. A
box of sides a, b, c has the mass, the middle and the inertia of four equal points at those corners of
``(+-a, +-b, +-c) / (2 sqrt 3)`` that have an even number of minus signs. With the freedoms accelerating by ``rates``
from a pose r of every point follows ``a = (d r / d freedoms) rates``, and the load is

    (moment; force) = - sum m (r x a; a)

about the middle of the gripper that holds, in its frame. The drives move the rest against it. What grows with the
square of speeds is left out: at 17 mm/s and 1 rad/s it is under 0.05 m/s2.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.robots.pipe_climber.grippers import free_gripper
from steeplejack.robots.pipe_climber.inverse import limb_lengths, limb_vectors
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.pads import pad_place
from steeplejack.robots.pipe_climber.parameters import PipeClimber
from steeplejack.robots.pipe_climber.statics import actuator_forces
from steeplejack.robots.pipe_climber.weights import BEHIND, BODY_SHARE, FRAME, linkage_height, linkage_mass

Array = NDArray[np.float64]

BAR_SIDE, PLATE_SIDE, ROD_SIDE = 0.010, 0.012, 0.010
"""Thickness of the linkage's bars, of the platforms and of the rods, for their inertia; estimates [m]."""
GRIPPER = (0.08, 0.06, 0.05)
"""Box with the inertia of a gripper's frame; estimate [m]."""
LOAD = (0.1, 0.1, 0.04)
"""Box with the inertia of a payload; estimate [m]."""
JAW = (0.02, 0.04, 0.05)
"""Box with the inertia of a jaw, estimate [m]."""
JAW_OUT = 0.012
"""How far its middle is outside its pads, estimate [m]."""
STEP = 1e-6
"""Of the differences [m] and [rad]."""
CORNERS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / (2.0 * math.sqrt(3.0))
ROWS = 256
"""Poses that are worked on at once, so that they stay in the processor's cache."""


def points(robot: PipeClimber, layout: Layout, freedoms: ArrayLike, payload: float = 0.0) -> tuple[Array, Array]:
    """The robot as points of mass, in the frame of the lower gripper.

    Args:
        robot: The machine.
        layout: Its hinges.
        freedoms: (x, w, alpha, beta), (..., 4) [m, m, rad, rad].
        payload: At the upper gripper's middle [kg].

    Returns:
        Masses (n,) [kg] and places (..., n, 3) [m].
    """
    given = np.asarray(freedoms, dtype=np.float64)
    shape, build = given.shape[:-1], robot.build
    frame, jaws = build.gripper_mass - 2.0 * build.jaw_mass, [build.jaw_mass] * 2
    width, back = 2.0 * robot.linkage.half_width, (float(layout.base.min()), float(layout.platform.min()))
    hz = robot.linkage.claw_offset
    still = np.concatenate((_box((FRAME[0], 0.0, -FRAME[1]), GRIPPER), *_jaws(robot, 0.0)))
    plate = _box((0.5 * back[0], 0.0, 0.0), (-back[0], width, PLATE_SIDE))
    upper = np.concatenate((
        _box((0.5 * back[1], 0.0, 0.0), (-back[1], width, PLATE_SIDE)), _box((FRAME[0], 0.0, FRAME[1] + hz), GRIPPER),
        *_jaws(robot, hz), _box((0.0, 0.0, hz), LOAD),
    ))  # fmt: skip
    carried = np.concatenate((
        np.broadcast_to(plate, (*shape, *plate.shape)), _limbs(robot, layout, given[..., :3]),
        _tilted(upper, given[..., :3]),
    ), axis=-2)  # fmt: skip
    places = np.concatenate((
        np.broadcast_to(still, (*shape, *still.shape)), _bars(robot, given[..., 3]), _turned(carried, given[..., 3]),
    ), axis=-2)  # fmt: skip
    parts = [frame, *jaws, *[0.25 * linkage_mass(robot)] * 4, build.plate_mass]
    parts += [share * robot.cylinders.mass for share in (BODY_SHARE, 1.0 - BODY_SHARE) for _limb in range(3)]
    return np.repeat([*parts, build.plate_mass, frame, *jaws, payload], len(CORNERS)) / len(CORNERS), places


def inertia(
    robot: PipeClimber, layout: Layout, freedoms: ArrayLike, rates: ArrayLike, end: int, payload: float = 0.0
) -> tuple[Array, Array]:
    """Inertia of an accelerating robot while one gripper holds alone: the load on it, and what the drives add.

    Args:
        robot: The machine.
        layout: Its hinges.
        freedoms: (x, w, alpha, beta), (k, 4) [m, m, rad, rad].
        rates: Their accelerations, any number of them, (..., k, 4) [m/s2, m/s2, rad/s2, rad/s2].
        end: 0 where the lower gripper holds, 1 where the upper one does.
        payload: At the upper gripper's middle [kg].

    Returns:
        (moment; force) at the middle of the gripper that holds in its own frame, (..., k, 6) [N m, N]; and forces of
        the cylinders, positive where they push, with the torque of the linkage's servo, positive where it makes beta
        grow, (..., k, 4) [N, N m]: by virtual work ``J^T f = sum m (d r / d pose)^T a``, and what motor and screw of
        a cylinder take themselves. Forces are NaN at a singular pose.
    """
    given, asked = np.asarray(freedoms, dtype=np.float64), np.asarray(rates, dtype=np.float64)
    many = asked.reshape(-1, *given.shape)
    loads, works = np.empty((*many.shape[:2], 6)), np.empty_like(many)
    for first in range(0, len(given), ROWS):
        rows = slice(first, first + ROWS)
        loads[:, rows], works[:, rows] = _push(robot, layout, given[rows], many[:, rows], payload, end)
    poses = given[:, :3]
    own = robot.build.screw_inertia * (jacobian(layout, poses) @ many[..., :3, None])[..., 0]
    drives = np.append(own + actuator_forces(layout, poses, -works[..., :3]), works[..., 3:], axis=-1)
    return loads.reshape(*asked.shape[:-1], 6), drives.reshape(asked.shape)


def _push(
    robot: PipeClimber, layout: Layout, freedoms: Array, rates: Array, payload: float, end: int
) -> tuple[Array, Array]:
    """Loads on one gripper (m, k, 6), and what moving along each freedom works against (m, k, 4)."""
    steps, shape = STEP * np.eye(4), (*rates.shape[:2], -1, 3)
    masses, places = _seen(robot, layout, freedoms, payload, end)
    ahead, back = (_seen(robot, layout, freedoms[:, None] + sign * steps, payload, end)[1] for sign in (1.0, -1.0))
    ways = ((ahead - back) / (2.0 * STEP)).reshape(len(freedoms), 4, -1)  # (k, 4, 3 n)
    pushes = (rates[..., None, :] @ ways).reshape(shape) * masses[:, None]
    works = (ways @ pushes.reshape(*rates.shape[:2], -1, 1))[..., 0]
    return -np.concatenate((np.cross(places, pushes).sum(axis=-2), pushes.sum(axis=-2)), axis=-1), works


def _seen(robot: PipeClimber, layout: Layout, freedoms: Array, payload: float, end: int) -> tuple[Array, Array]:
    """`points` in the frame of the lower (0) or of the upper (1) gripper."""
    masses, places = points(robot, layout, freedoms, payload)
    if end == 0:
        return masses, places
    upper = free_gripper(freedoms, robot.linkage.claw_offset)
    return masses, (places - upper[..., None, :3, 3]) @ upper[..., :3, :3]


def _box(middle: tuple[float, float, float], sides: tuple[float, float, float]) -> Array:
    """The points of a box, (4, 3)."""
    return np.array(middle) + CORNERS * np.array(sides)


def _jaws(robot: PipeClimber, height: float) -> list[Array]:
    """A gripper's two jaws at its height, where they stand on the thickest pipe: the larger inertia."""
    out = pad_place(robot, 0.5 * robot.gripper.pipe_diameter[1]) + JAW_OUT
    return [_box((side * out, 0.0, height), JAW) for side in (1.0, -1.0)]


def _limbs(robot: PipeClimber, layout: Layout, poses: Array) -> Array:
    """Bodies, then rods, in the mechanism's frame, (..., 24, 3)."""
    lengths, body = limb_lengths(layout, poses), robot.cylinders.reach[0] - BEHIND
    z = np.zeros((*lengths.shape, 3))
    z[..., [0, 2]] = limb_vectors(layout, poses) / lengths[..., None]
    x = np.stack((z[..., 2], np.zeros_like(lengths), -z[..., 0]), axis=-1)
    axes = np.stack((x, np.broadcast_to([0.0, 1.0, 0.0], x.shape), z), axis=-2)  # rows
    half = robot.linkage.half_width
    feet = np.stack((layout.base, [half, -half, 0.0], np.zeros(3)), axis=-1)
    thick = 2.0 * robot.build.limb_radius
    bodies = (feet + 0.5 * body * z)[..., None, :] + (CORNERS * np.array([thick, thick, body])) @ axes
    rods = (feet + (lengths - 0.5 * body)[..., None] * z)[..., None, :] + (
        CORNERS * np.array([ROD_SIDE, ROD_SIDE, body])
    ) @ axes
    return np.concatenate((bodies, rods), axis=-3).reshape(*lengths.shape[:-1], 24, 3)


def _tilted(places: Array, poses: Array) -> Array:
    """Points of the upper platform, (n, 3) in its frame, in the mechanism's, (..., n, 3)."""
    x, w, alpha = (one[..., None] for one in np.moveaxis(poses, -1, 0))
    c, s = np.cos(alpha), np.sin(alpha)
    first, third = x + places[:, 0] * c + places[:, 2] * s, w - places[:, 0] * s + places[:, 2] * c
    return np.stack((first, np.broadcast_to(places[:, 1], first.shape), third), axis=-1)


def _turned(places: Array, beta: Array) -> Array:
    """Points (..., n, 3) of the mechanism's frame in the lower gripper's."""
    c, s = np.cos(beta)[..., None], np.sin(beta)[..., None]
    x, y, z = np.moveaxis(places, -1, 0)
    return np.stack((x * c - y * s, x * s + y * c, z), axis=-1)


def _bars(robot: PipeClimber, beta: Array) -> Array:
    """Cranks G1 and G2, which turn about their middles, and couplers G3 and G4, which do not turn, (..., 16, 3)."""
    rcm, height = robot.rcm, linkage_height(robot)
    crank = _turned(np.broadcast_to(CORNERS * [BAR_SIDE, 2.0 * rcm.crank, BAR_SIDE], (*beta.shape, 4, 3)), beta)
    coupler = CORNERS * [rcm.coupler, BAR_SIDE, BAR_SIDE]
    out = np.stack((-np.sin(beta), np.cos(beta), np.zeros_like(beta)), axis=-1)[..., None, :] * rcm.crank
    half = np.array([0.5 * rcm.coupler, 0.0, 0.0])
    found = np.concatenate((crank - half, crank + half, coupler + out, coupler - out), axis=-2)
    return found + np.array([0.0, 0.0, height])
