"""How well the platform followed its planned equilibria while it inspected.

Two errors, told apart because they have different causes. The relative error is actual less planned position, less
the shift that drifting wheel odometry and inclinometers alone explain: the quality of the control. The absolute error
is actual less planned position in the world, drift included: how far a defect may be from where the report puts it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.report.drift import drift_shift
from steeplejack.report.log import Log
from steeplejack.runtime.gait import Phase

Array = NDArray[np.float64]
AXES = ("along", "across", "stand-off")


@dataclass(frozen=True)
class Accuracy:
    """Errors at every sample of the inspecting flights, in the frame of the inspected stay."""

    sample: NDArray[np.int64]  # (n,) index into the log's samples
    stay: NDArray[np.int64]  # (n,) place of the inspected stay in the bay
    s: Array  # (n,) [m] arc length of the point of the stay nearest to the platform
    travel: Array  # (n,) [m] inspected so far, planned path
    stand_off: Array  # (n,) [m] from the stay's surface
    relative: Array  # (n, 3) [m] along, across, stand-off
    absolute: Array  # (n,) [m]

    @classmethod
    def of(cls, log: Log) -> Accuracy:
        """Errors of a run; empty where it inspected nothing."""
        states, legs = log.states, log.mission.legs
        inspecting = np.array([leg.kind == "inspect" for leg in legs])
        sample = np.flatnonzero(inspecting[states.leg] & (states.phase == Phase.FLY.value))
        place = {stay.id: k for k, stay in enumerate(log.bay.stays)}
        stays = np.array([place.get(leg.stay or "", 0) for leg in legs])[states.leg[sample]]
        actual, desired = states.actual_position[sample], states.desired_position[sample]
        offset = actual - desired
        shift = _shift(log, sample)[:, 3:]
        s, stand_off, relative = np.empty(len(sample)), np.empty(len(sample)), np.empty((len(sample), 3))
        for k in np.unique(stays):
            here = stays == k
            s[here], distance = log.bay.stays[k].nearest(actual[here])
            stand_off[here] = distance - log.bay.radius(int(k))
            relative[here] = np.einsum("ni,nij->nj", (offset - shift)[here], _axes(log, int(k), s[here]))
        absolute = np.linalg.norm(offset, axis=1)
        return cls(sample, stays, s, _travel(desired, states.leg[sample]), stand_off, relative, absolute)


def _shift(log: Log, sample: NDArray[np.int64]) -> Array:
    states, squad = log.states, log.squad
    mass = squad.platform.mass + log.mission.request.payload_kg
    return drift_shift(
        states.exits_actual[sample],
        states.exits_measured[sample],
        np.array(squad.platform.attachments),
        mass * np.array(log.site.gravity),
        np.array(squad.platform.centre_of_mass),
        states.desired_position[sample],
        states.desired_rotation[sample],
        states.actual_tension[sample],
    )


def _axes(log: Log, k: int, s: Array) -> Array:
    """Unit vectors along, across and off stay ``k`` (n, 3, 3) in columns: across points like the platform's x."""
    along = log.bay.stays[k].tangent(s)
    normal = log.bay.normal(np.full(len(s), float(k)), s)
    off = normal - np.sum(normal * along, axis=1, keepdims=True) * along
    off /= np.linalg.norm(off, axis=1, keepdims=True)
    axes = np.empty((len(s), 3, 3))
    axes[:, :, 0], axes[:, :, 1], axes[:, :, 2] = along, np.cross(off, along), off
    return axes


def _travel(desired: Array, leg: NDArray[np.int64]) -> Array:
    """Length of the planned path up to every sample (n,) [m], flights between the stays left out."""
    steps = np.linalg.norm(np.diff(desired, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(np.where(np.diff(leg) == 0, steps, 0.0))])[: len(desired)]
