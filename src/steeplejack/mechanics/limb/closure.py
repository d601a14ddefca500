"""Loop closure of a linkage in joint coordinates: where its links are, its Jacobian, and Newton steps that close it.

The displacement of a link from the reference configuration is the product of exponentials of the joint twists along
the tree, ``T = exp(S_1 q_1) exp(S_2 q_2) ...`` (Brockett; Lynch and Park, Modern Robotics, ch. 4), so that coordinates
are zero in the reference configuration. Every joint outside the tree closes a loop: six equations, whose Jacobian
holds the present twists of the joints round it. All lengths are in units of the gauge.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from steeplejack.mechanics.limb.graph import Arrangement, spanning_tree
from steeplejack.mechanics.limb.linkage import Joint
from steeplejack.mechanics.limb.screws import cross_matrix, transform_twists
from steeplejack.mechanics.limb.systems import Gauge
from steeplejack.spatial.rotation import from_vector

Array = NDArray[np.float64]

CLOSED = 1e-12
"""Largest misclosure of a closed loop [rad; characteristic lengths]."""
LEAST_DAMPING = 1e-13
"""Of the Newton steps; the equations have more unknowns than rank, so that some is always needed [1]."""


class Displacement(NamedTuple):
    """Rotation (3, 3) and translation (3,) [characteristic lengths] of a link from its reference."""

    rotation: Array
    translation: Array


class Configuration(NamedTuple):
    """A linkage at given joint coordinates, all in the gauge.

    Attributes:
        twists: Present unit twist of every coordinate, at the base's frame, (f, 6).
        jacobian: Of the loop equations in the coordinates, (6 loops, f).
        misclosure: Of the loop equations, (6 loops,).
        output: Twist of the output by the coordinates, (6, f).
        moved: Where the output is.
    """

    twists: Array
    jacobian: Array
    misclosure: Array
    output: Array
    moved: Displacement


@dataclass(frozen=True)
class Closure:
    """The loop equations of a part of a linkage.

    Attributes:
        part: Whose.
        gauge: Lengths are measured so.
        tree: Joints of the spanning tree with the link each reaches.
        chords: Joints that close loops.
        twists: Unit twists in the reference configuration, in the gauge, by name of the joint, (freedoms, 6).
        columns: Coordinates of every joint, by name.
    """

    part: Arrangement
    gauge: Gauge
    tree: list[tuple[Joint, str]]
    chords: list[Joint]
    twists: dict[str, Array]
    columns: dict[str, slice]

    @classmethod
    def of(cls, part: Arrangement, gauge: Gauge) -> Closure:
        """The equations of a part."""
        tree, chords = spanning_tree(part)
        twists, columns, count = dict[str, Array](), dict[str, slice](), 0
        for joint in part.joints:
            twists[joint.name] = _unit_turns(gauge.twists(joint.twists(gauge.origin)))
            columns[joint.name] = slice(count, count + joint.freedoms)
            count += joint.freedoms
        return cls(part, gauge, tree, chords, twists, columns)

    @property
    def freedoms(self) -> int:
        """Sum of the freedoms of the joints."""
        return sum(joint.freedoms for joint in self.part.joints)

    def at(self, coordinates: Array) -> Configuration:
        """The linkage at joint coordinates (f,) [rad; characteristic lengths]."""
        places = {self.part.base: Displacement(np.eye(3), np.zeros(3))}
        maps = {self.part.base: np.zeros((6, self.freedoms))}
        present = np.zeros((self.freedoms, 6))
        for joint, link in self.tree:
            here = self.columns[joint.name]
            step, local = _product(self.twists[joint.name], coordinates[here])
            forward = link == joint.links[1]
            known = joint.links[0] if forward else joint.links[1]
            places[link] = _compose(places[known], step if forward else _inverse(step))
            present[here] = transform_twists(*places[joint.links[0]], local)
            maps[link] = maps[known].copy()
            maps[link][:, here] += present[here].T if forward else -present[here].T
        jacobian = np.zeros((6 * len(self.chords), self.freedoms))
        misclosure = np.zeros(6 * len(self.chords))
        for number, joint in enumerate(self.chords):
            here, rows = self.columns[joint.name], slice(6 * number, 6 * number + 6)
            first, second = joint.links
            step, local = _product(self.twists[joint.name], coordinates[here])
            present[here] = transform_twists(*places[first], local)
            jacobian[rows] = maps[first] - maps[second]
            jacobian[rows, here] += present[here].T
            misclosure[rows] = _gap(_compose(places[first], step), places[second])
        return Configuration(present, jacobian, misclosure, maps[self.part.output], places[self.part.output])

    def closed(self, coordinates: Array, steps: int = 60) -> Array | None:
        """Coordinates (f,) nearby at which every loop closes; None if none was found.

        Levenberg-Marquardt with the square of the misclosure as damping, which keeps quadratic convergence where
        equations are dependent (Yamashita and Fukushima, 2001), as they are in every overconstrained linkage.
        """
        found = coordinates.copy()
        for _step in range(steps):
            now = self.at(found)
            gap = float(np.abs(now.misclosure).max(initial=0.0))
            if gap <= CLOSED:
                return found
            if not gap < 10.0:  # far off: a sphere of the size of the mechanism is 1
                return None
            damping = max(float(now.misclosure @ now.misclosure), LEAST_DAMPING)
            normal = now.jacobian.T @ now.jacobian + damping * np.eye(self.freedoms)
            found = found - np.linalg.solve(normal, now.jacobian.T @ now.misclosure)
        return None


def _unit_turns(twists: Array) -> Array:
    """Twists (k, 6) scaled to a unit turn, or to a unit translation where they do not turn."""
    turns = np.linalg.norm(twists[:, :3], axis=1, keepdims=True)
    moves = np.linalg.norm(twists[:, 3:], axis=1, keepdims=True)
    return twists / np.where(turns > 0.0, turns, moves)


def _product(twists: Array, coordinates: Array) -> tuple[Displacement, Array]:
    """Product of exponentials of a joint's unit twists (k, 6), and those twists as they stand after the ones before."""
    total, present = Displacement(np.eye(3), np.zeros(3)), np.empty_like(twists)
    for number, (twist, value) in enumerate(zip(twists, coordinates, strict=True)):
        present[number] = transform_twists(*total, twist)
        total = _compose(total, _exponential(twist, float(value)))
    return total, present


def _exponential(twist: Array, value: float) -> Displacement:
    """Displacement by a unit twist (6,) a distance or an angle along."""
    axis, linear = twist[:3], twist[3:]
    if not axis.any():
        return Displacement(np.eye(3), linear * value)
    rotation = from_vector(axis * value)
    arm = cross_matrix(axis) @ linear
    return Displacement(rotation, arm - rotation @ arm + axis * (axis @ linear) * value)


def _compose(one: Displacement, other: Displacement) -> Displacement:
    return Displacement(one.rotation @ other.rotation, one.translation + one.rotation @ other.translation)


def _inverse(one: Displacement) -> Displacement:
    return Displacement(one.rotation.T, -one.rotation.T @ one.translation)


def _gap(one: Displacement, other: Displacement) -> Array:
    """Displacement (6,) from one to another as a small twist at the frame; zero exactly where the two agree."""
    turn = one.rotation @ other.rotation.T
    skew = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    # Half a turn has no skew part either: the missing trace keeps it from counting as closed.
    if np.trace(turn) < 1.0:
        skew = skew + 1.0
    return np.concatenate((skew, one.translation - turn @ other.translation))
