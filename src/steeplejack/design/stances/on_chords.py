"""Stations of a stance chart by the point-mass estimate: the platform on the stay's chord, in the plane of the bay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.stances.ground import straight
from steeplejack.design.stances.rules import COUNT, TOLERANCE, ChartRules
from steeplejack.design.stances.search import Room, best_stances
from steeplejack.design.stances.weigh import by_forces, known
from steeplejack.design.stances.worth import POINT, SLIP
from steeplejack.robots.squad import Bay
from steeplejack.worksite import Bridge
from steeplejack.worksite.bridge import plane_normal

Array = NDArray[np.float64]

STARTS = 2
"""Nodes of the grid that the search climbs from."""


def on_chords(
    bridge: Bridge,
    bay: Bay,
    k: int,
    rules: ChartRules,
    limits: Array,
    s: Array,
    room: Room,
    fixed: Array,
) -> dict[str, Array]:
    """Stations of one stay by the point-mass estimate on chords; every phase of every station is a row."""
    normal = plane_normal(bay.stays)
    up = np.array([0.0, 0.0, 1.0]) - normal[2] * normal
    up /= np.linalg.norm(up)
    plane = np.stack([np.cross(up, normal), up])
    ends = np.stack([np.array([bay.stays[i].lower, bay.stays[i].upper]) @ plane.T for i in bay.carriers])
    flat = straight(ends[:, 0], ends[:, 1], rules.tension, 1.0)
    n, q = len(s), len(limits)
    positions = np.zeros((n * q, 3))
    positions[:, :2] = np.repeat(bay.stays[k].position(s) @ plane.T, q, axis=0)
    load = np.append(plane @ (rules.mass * np.asarray(bridge.gravity)), 0.0)[None]
    arms = np.zeros((n * q, 4, 3))
    room = replace(room, windows=np.repeat(room.windows, q, axis=0))
    worth = by_forces(SLIP, POINT, flat, room, positions, arms, load, np.tile(limits, (n, 1, 1)))
    found = best_stances(worth, room, room.windows.mean(axis=-1), COUNT, STARTS, TOLERANCE)
    standing = replace(room, windows=np.broadcast_to([-np.inf, np.inf], room.windows.shape))
    other = by_forces(SLIP, POINT, flat, standing, positions, arms, load, np.tile(limits, (n, 1, 1)))
    return {
        "margin": known(found.worth).reshape(n, q),
        "stance": found.s.reshape(n, q, 4),
        "fixed_margin": known(other(np.arange(n * q), np.repeat(fixed, q, axis=0)[:, None])).reshape(n, q),
    }
