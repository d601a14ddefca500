"""The moving machine as round bars: what may touch a pipe or what stands on it.

Bars are segments with a radius: yokes of both platforms (open toward +X), cylinder bodies and rods, posts between
linkage and lower platform, cranks and couplers of the linkage. Pads, jaws and the palm of a gripper are not among them.
Sizes not in the robot file are those of the physics, estimates.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.robots.pipe_climber.inverse import limb_lengths, limb_vectors
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.parameters import PipeClimber
from steeplejack.robots.pipe_climber.poses import triples
from steeplejack.robots.pipe_climber.weights import BEHIND, linkage_height

Array = NDArray[np.float64]

YOKE, POST, ROD, BAR = 0.006, 0.004, 0.004, 0.005
"""Radii: arms of the platforms, posts, cylinder rods, bars of the linkage [m]."""


def mechanism_bars(robot: PipeClimber, layout: Layout, poses: ArrayLike) -> tuple[Array, Array]:
    """Everything that turns with the mechanism, in its frame: the lower gripper's turned by beta.

    Args:
        robot: The machine.
        layout: Its hinges.
        poses: (x, w, alpha), (k, 3) [m, m, rad].

    Returns:
        Ends of the bars, (k, 14, 2, 3) [m], and their radii, (14,) [m].
    """
    given = triples("poses", poses).reshape(-1, 3)
    half, body = robot.linkage.half_width, robot.cylinders.reach[0] - BEHIND
    crank, height, thick = robot.rcm.crank, linkage_height(robot), robot.build.limb_radius
    posts = np.array([[[0.0, s * crank, height], [0.0, s * half, 0.0]] for s in (1.0, -1.0)])
    lower = np.concatenate((_yoke(layout.base, half), posts))
    out = np.empty((len(given), 14, 2, 3))
    out[:, :5] = lower
    aside = np.array([half, -half, 0.0])
    lengths = limb_lengths(layout, given)
    ways = np.zeros((len(given), 3, 3))
    ways[..., [0, 2]] = limb_vectors(layout, given) / lengths[..., None]
    feet = np.stack((layout.base, aside, np.zeros(3)), axis=-1)
    for k, along in enumerate((np.full_like(lengths, thick), np.full_like(lengths, body - thick))):
        out[:, 5:8, k] = feet + along[..., None] * ways
    for k, along in enumerate((np.maximum(lengths - body, 0.0), lengths)):
        out[:, 8:11, k] = feet + along[..., None] * ways
    c, s = np.cos(given[:, 2]), np.sin(given[:, 2])
    yoke = _yoke(layout.platform, half)
    out[:, 11:, :, 0] = given[:, 0, None, None] + yoke[..., 0] * c[:, None, None]
    out[:, 11:, :, 1] = yoke[..., 1]
    out[:, 11:, :, 2] = given[:, 1, None, None] - yoke[..., 0] * s[:, None, None]
    radii = np.array([YOKE] * 3 + [POST] * 2 + [thick] * 3 + [ROD] * 3 + [YOKE] * 3)
    return out, radii


def linkage_bars(robot: PipeClimber, beta: ArrayLike) -> tuple[Array, Array]:
    """Cranks G1 and G2 and couplers G3 and G4, in the frame of the lower gripper.

    Args:
        robot: The machine.
        beta: Turn of the cranks, (k,) [rad].

    Returns:
        Ends of the bars, (k, 4, 2, 3) [m], and their radii, (4,) [m].
    """
    turn = np.atleast_1d(np.asarray(beta, dtype=np.float64))
    half, height = 0.5 * robot.rcm.coupler, linkage_height(robot)
    crank = robot.rcm.crank * np.stack((-np.sin(turn), np.cos(turn), np.zeros_like(turn)), axis=-1)
    pivots = np.array([[-half, 0.0, height], [half, 0.0, height]])
    out = np.empty((len(turn), 4, 2, 3))
    for k, pivot in enumerate(pivots):
        out[:, k, 0], out[:, k, 1] = pivot - crank, pivot + crank
        out[:, 2, k], out[:, 3, k] = pivot + crank, pivot - crank
    return out, np.full(4, BAR)


def ring_radius(robot: PipeClimber, beta: ArrayLike) -> Array:
    """How far the linkage's bars keep from the axis of the lower gripper, (...) [m].

    Args:
        robot: The machine.
        beta: Turn of the cranks, (...) [rad].
    """
    turn = np.minimum(np.abs(np.asarray(beta, dtype=np.float64)), 0.5 * math.pi)
    return min(robot.rcm.crank, 0.5 * robot.rcm.coupler) * np.cos(turn) - BAR


def widest_turn(robot: PipeClimber, radius: float) -> float:
    """Largest turn at which the linkage's bars keep to a distance from the axis of the lower gripper [m]; in [rad]."""
    return math.acos(min(1.0, (radius + BAR) / min(robot.rcm.crank, 0.5 * robot.rcm.coupler)))


def limb_room(robot: PipeClimber) -> float:
    """How far limbs, yokes and posts keep from the axis of a straight pipe on which both grippers are [m]."""
    return min(robot.linkage.half_width - max(robot.build.limb_radius, YOKE), robot.rcm.crank - POST)


def inner_radius(robot: PipeClimber) -> float:
    """How far every bar keeps from the axis of a straight pipe on which both grippers are, whatever beta is [m]."""
    return min(float(ring_radius(robot, robot.rcm.limit)), limb_room(robot))


def _yoke(places: Array, half: float) -> Array:
    """Arms beside the pipe from behind it to where limbs 1 and 2 are hinged or to its axis, and the bar behind."""
    back = float(places.min())
    arms = [
        [[back, side * half, 0.0], [max(float(place), 0.0), side * half, 0.0]]
        for side, place in ((1.0, places[0]), (-1.0, places[1]))
    ]
    return np.array([*arms, [[back, -half, 0.0], [back, half, 0.0]]])
