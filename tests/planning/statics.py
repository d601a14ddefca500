"""Statics written out again from the mission file and the stays alone: no function of the planner is used here."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from steeplejack.planning import Leg, Mission, Waypoint
from steeplejack.robots.squad import Squad
from steeplejack.worksite import Bridge, Stay

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pose:
    """One waypoint of a leg, in space."""

    leg: Leg
    waypoint: Waypoint
    position: Array  # (3,) [m]
    rotation: Array  # (3, 3) platform to world
    tension: Array  # (4,) [N]
    exits: Array  # (4, 3) [m] winch exits
    tangents: Array  # (4, 3) of the stays at the bases
    arms: Array  # (4, 3) [m] from the stay's axis to the exit
    ends: Array  # (4, 3) [m] attachments

    @property
    def forces(self) -> Array:
        """Cable forces on the platform (4, 3) [N]."""
        cables = self.exits - self.ends
        return self.tension[:, None] * cables / np.linalg.norm(cables, axis=1, keepdims=True)


def clock_arm(stay: Stay, s: float, clock: float, length: float) -> tuple[Array, Array]:
    """Tangent by finite differences, and an arm at a clock angle: 12 points up most, clockwise looking up the stay."""
    step = 1e-4
    tangent = stay.position(s + step) - stay.position(s - step)
    tangent /= np.linalg.norm(tangent)
    twelve = np.array([0.0, 0.0, 1.0]) - tangent[2] * tangent
    twelve /= np.linalg.norm(twelve)
    return tangent, length * (np.cos(clock) * twelve + np.sin(clock) * np.cross(tangent, twelve))


def poses(mission: Mission, bridge: Bridge, squad: Squad) -> list[Pose]:
    """Every waypoint of a mission, in space."""
    found: list[Pose] = []
    carriers = [bridge.stay(name) for name in mission.carriers]
    attachments = np.array(squad.platform.attachments)
    for leg in mission.legs:
        for point in leg.waypoints:
            w, x, y, z = point.quaternion
            rotation = Rotation.from_quat([x, y, z, w]).as_matrix()
            places = zip(carriers, point.base_s_m, np.radians(point.base_clock_deg), strict=True)
            frames = [clock_arm(stay, s, clock, squad.base.exit_offset) for stay, s, clock in places]
            axes = np.array([stay.position(s) for stay, s in zip(carriers, point.base_s_m, strict=True)])
            tangents, arms = (np.array(part) for part in zip(*frames, strict=True))
            position = np.array(point.position_m)
            ends = position + attachments @ rotation.T
            tension = np.array(point.tension_n)
            found.append(Pose(leg, point, position, rotation, tension, axes + arms, tangents, arms, ends))
    return found


def potential_hessian(pose: Pose, squad: Squad, weight: Array) -> Array:
    """Hessian (6, 6) of elastic and gravity potential with locked winches, by central differences of the energy.

    Coordinates are a rotation vector in the world's frame [rad] and a displacement [m]; cables are springs of EA over
    their unstressed length that never push.
    """
    stiffness = squad.cable.axial_stiffness
    attachments, centre = np.array(squad.platform.attachments), np.array(squad.platform.centre_of_mass)
    unstressed = np.linalg.norm(pose.exits - pose.ends, axis=1) / (1.0 + pose.tension / stiffness)

    def energy(offsets: Array) -> Array:
        turned = Rotation.from_rotvec(offsets[:, :3]).as_matrix() @ pose.rotation
        moved = pose.position + offsets[:, 3:]
        ends = moved[:, None] + np.einsum("nij,kj->nki", turned, attachments)
        stretch = np.maximum(np.linalg.norm(pose.exits - ends, axis=2) - unstressed, 0.0)
        drop = offsets[:, 3:] + (turned - pose.rotation) @ centre
        return np.sum(0.5 * stiffness / unstressed * stretch**2, axis=1) - drop @ weight

    h = 1e-3 * np.eye(6)
    i, j = (index.ravel() for index in np.meshgrid(range(6), range(6), indexing="ij"))
    signs = ((1, 1), (1, -1), (-1, 1), (-1, -1))
    parts = [a * b * energy(a * h[i] + b * h[j]) for a, b in signs]
    return (sum(parts) / (4.0 * 1e-6)).reshape(6, 6)
