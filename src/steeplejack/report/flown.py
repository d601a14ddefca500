"""What the bases and cables went through as flown: twist about the stays, and gaps to them, at every sample.

A plan is certified at its waypoints; these are the same quantities again, from where the winch exits and the platform
truly were and from the true tensions, by the log's own stays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.mechanics.cable.region.clearance import cable_gap
from steeplejack.report.log import Log

Array = NDArray[np.float64]

NODE = 4.0  # [m] between the nodes of a stay's polyline: within 0.3 mm of a 550 m stay that sags 5 m


@dataclass(frozen=True)
class Flown:
    """Loads and gaps at every sample of a run."""

    twist: Array  # (n, 4) [N m] about the stay of every base
    cable_gap: Array  # (n,) [m] least, of the driving cables to the surfaces of stays they are not carried by
    body_gap: Array  # (n,) [m] least, of the platform's centre to the surfaces of all stays

    @classmethod
    def of(cls, log: Log) -> Flown:
        """As flown, the time on the brakes after a stop included."""
        states = log.states
        arms = np.einsum("nij,kj->nki", states.actual_rotation, np.array(log.squad.platform.attachments))
        ends = states.actual_position[:, None, :] + arms
        return cls(_twist(log, ends), *_gaps(log, ends))


def _twist(log: Log, ends: Array) -> Array:
    """Twists ``t |u . (tangent x arm)|`` (n, 4) [N m] of cables that end at ``ends`` (n, 4, 3) [m].

    The arm reaches from the stay's axis to the winch exit, u points along the cable; see ``robots.squad.anchorage``.
    """
    states, bay = log.states, log.bay
    u = ends - states.exits_actual
    u /= np.linalg.norm(u, axis=2, keepdims=True)
    twist = np.empty((len(ends), 4))
    for i, k in enumerate(bay.carriers):
        stay, s = bay.stays[k], states.actual_s[:, i]
        arm = states.exits_actual[:, i] - stay.position(s)
        twist[:, i] = states.actual_tension[:, i] * np.abs(np.sum(u[:, i] * np.cross(stay.tangent(s), arm), axis=1))
    return twist


def _gaps(log: Log, ends: Array) -> tuple[Array, Array]:
    """Least gaps (n,) [m] of the cables that end at ``ends`` (n, 4, 3) [m], and of the platform's centre, to stays."""
    bay, exits = log.bay, log.states.exits_actual
    nodes = int(np.ceil(max(stay.length for stay in bay.stays) / NODE)) + 1
    axes = np.stack([stay.position(np.linspace(0.0, stay.length, nodes)) for stay in bay.stays])
    radii = np.array([bay.radius(k) for k in range(len(bay.stays))])
    own = np.array(bay.carriers)
    gaps = np.array([cable_gap(exits[j], ends[j], axes, radii, own) for j in range(len(ends))])
    return gaps[:, 0], gaps[:, 1]
