"""Questions for tension distributions: published robots at turned poses, random ones, paths, and a check of optima."""

from __future__ import annotations

import numpy as np
from published_robots import GRAVITY
from scipy.optimize import nnls

from steeplejack.mechanics.cable import planar_structure_matrix, spatial_structure_matrix


def published(robot, rng, count):
    """A robot under gravity at random poses: structures, wrenches, lower, upper."""
    if robot.dimension == 2:
        poses = robot.poses(rng, count)
        structures = planar_structure_matrix(robot.anchors, robot.attachments, poses)
        cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        arm = cos * robot.centre[0] - sin * robot.centre[1]
        force = -robot.mass * GRAVITY * np.ones(count)
        wrenches = np.stack((0.0 * force, force, arm * force), axis=-1)
    else:
        position, rotation = robot.poses(rng, count)
        structures = spatial_structure_matrix(robot.anchors, robot.attachments, position, rotation)
        force = np.array([0.0, 0.0, -robot.mass * GRAVITY])
        wrenches = np.concatenate((np.cross(rotation @ robot.centre, force), np.tile(force, (count, 1))), axis=-1)
    lower, upper = (np.full((count, len(robot.anchors)), bound) for bound in robot.window)
    return structures, wrenches, lower, upper


def balanced_by(structures, tensions):
    """Wrenches that given tensions balance."""
    return -np.einsum("...ij,...j->...i", structures, tensions)


def drawn(rng, n, m, count, outside=30.0):
    """Random structures and windows; the tensions behind the wrench lie up to ``outside`` beyond the windows [N]."""
    structures = rng.normal(size=(count, n, m))
    lower = rng.uniform(0.0, 50.0, (count, m))
    upper = lower + rng.uniform(20.0, 200.0, (count, m))
    inside = rng.uniform(lower - outside, upper + outside)
    return structures, balanced_by(structures, inside), lower, upper


def excess(tensions, lower, upper):
    """How far the worst tension is outside its window; negative inside [N]."""
    return np.maximum(lower - tensions, tensions - upper).max(axis=-1)


def descent_left(structure, tensions, gradient, lower, upper, reach=1e-6):
    """What is left of a convex objective's gradient once the equations and the bounds met have taken their share [1].

    Zero exactly at the optimum (Karush, Kuhn and Tucker), relative to the gradient.
    """
    met = reach * (upper - lower).max()
    at_lower, at_upper = tensions - lower < met, upper - tensions < met
    rows = structure / np.linalg.norm(structure, axis=1, keepdims=True)
    sides = np.eye(tensions.size)
    columns = np.vstack((rows, -rows, sides[at_lower], -sides[at_upper])).T
    size = np.linalg.norm(gradient)
    return 0.0 if size == 0.0 else nnls(columns, gradient / size)[1]
