"""What a closed gripper holds, for the oracle: friction on eight pads by a convex hull.

What the pads hold is the convex hull of their wrenches (`robots.pipe_climber.pads` has the definition): with its facets
``n . w <= 1`` a load w takes the part ``max n . (-w)`` of it, and the worst of a weight with inertia to either side
``max (-n . w + sum |n . push|)``. `by_highs` asks the same of a linear programme.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from oracle_bodies import Array
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from steeplejack.robots.pipe_climber import PipeClimber
from steeplejack.robots.pipe_climber.pads import EDGES, FIRST, INSET, LAST

CHUNK = 256  # loads held against all facets at once


@dataclass(frozen=True)
class Pads:
    """What of a robot file says how a closed gripper holds.

    Attributes:
        aside: Half of the distance of the pads of one jaw across the pipe [m].
        size: Radius of a pad [m].
        row: From the gripper's middle to either row of pads [m].
        force: Of all jaws together [N].
        friction: [1].
    """

    aside: float
    size: float
    row: float
    force: float
    friction: float

    @classmethod
    def of(cls, robot: PipeClimber) -> Pads:
        """A robot's."""
        build, gripper = robot.build, robot.gripper
        row = 0.5 * build.jaw_length - INSET * build.pad_radius
        return cls(0.5 * build.jaw_width, build.pad_radius, row, gripper.jaws * gripper.force, gripper.friction)

    def wrenches(self, radius: float, rows: int) -> Array:
        """Corners of what they give, in the gripper's frame, (j, 6) [N m, N].

        Args:
            radius: Of the pipe under them [m].
            rows: Which rows of pads touch it: `pads.BOTH`, `FIRST` or `LAST`.
        """
        phi = math.asin(self.aside / (radius + self.size))
        ends = {FIRST: [-self.row], LAST: [self.row]}.get(rows, [-self.row, self.row])
        found: list[Array] = []
        for clock in (phi, -phi, math.pi - phi, math.pi + phi):  # about the pipe, from the gripper's X
            normal = np.array([math.cos(clock), math.sin(clock), 0.0])
            around = np.array([-math.sin(clock), math.cos(clock), 0.0])
            for end in ends:
                for edge in np.arange(EDGES) * 2.0 * math.pi / EDGES:
                    rub = math.cos(edge) * around + math.sin(edge) * np.array([0.0, 0.0, 1.0])
                    force = normal + self.friction * rub
                    force *= self.force * math.cos(phi) / abs(force[0])
                    found.append(np.concatenate((np.cross(radius * normal + [0.0, 0.0, end], force), force)))
        return np.array(found)


def by_highs(wrenches: Array, load: Array) -> float:
    """How much of a grip a load takes: least sum of parts of the pads' wrenches that bear it."""
    found = linprog(np.ones(len(wrenches)), A_eq=wrenches.T, b_eq=-load, bounds=(0.0, None))
    assert found.status == 0
    return float(found.fun)


@cache
def facets(pads: Pads, radius: float, rows: int) -> Array:
    """Normals n (f, 6) of the hull of the pads' wrenches, ``n . w <= 1`` within it; see `Pads.wrenches`."""
    wrenches = pads.wrenches(radius, rows)
    scale = np.abs(wrenches).max(axis=0)
    hull = ConvexHull(wrenches / scale, qhull_options="Qt").equations  # outward normals, and how far out facets are
    return np.unique(np.round(-hull[:, :6] / hull[:, 6:], 9), axis=0) / scale


def used(normals: Array, weight: Array, pushes: Array) -> Array:
    """Part of a grip that a weight (k, 6) takes with the worst of pushes (k, j, 6) to either side, (k,)."""
    found = np.empty(len(weight))
    for first in range(0, len(weight), CHUNK):
        some = slice(first, first + CHUNK)
        parts = -weight[some] @ normals.T
        for number in range(pushes.shape[1]):
            parts += np.abs(pushes[some, number] @ normals.T)
        found[some] = parts.max(axis=1)
    return found
