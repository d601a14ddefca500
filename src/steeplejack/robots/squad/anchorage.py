"""Where the four bases stand: winch exits and the limits each base puts on its cable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Squad

Array = NDArray[np.float64]
ALONG, ABOUT = 0, 1  # rows of the linear limits: pull along the stay, twist about it


@dataclass(frozen=True)
class Stance:
    """Places of the four bases on their boundary stays.

    The winch exit lies ``exit_offset`` off the stay's axis at a clock angle fixed while the base stands, so that it
    points at the middle of the cell: a cable out of the plane of stay axis and exit twists the base about the stay.
    """

    s: tuple[float, float, float, float]  # [m] arc length from the lower anchorage
    clock: tuple[float, float, float, float]  # [rad] of the winch exit, from 12 on top, clockwise looking up the stay


def exits(bay: Bay, squad: Squad, s: Array, clock: Array) -> tuple[Array, Array, Array]:
    """Winch exits, stay tangents and radial arms (..., 4, 3) [m] of bases at ``s`` and ``clock`` (..., 4)."""
    s, clock = np.asarray(s, float), np.asarray(clock, float)
    shape = (*s.shape, 3)
    points, tangents, arms = np.empty(shape), np.empty(shape), np.empty(shape)
    for i, k in enumerate(bay.carriers):
        stay = bay.stays[k]
        twelve, three = stay.clock_frame(s[..., i])
        tangents[..., i, :] = stay.tangent(s[..., i])
        angle = clock[..., i, None]
        arms[..., i, :] = squad.base.exit_offset * (np.cos(angle) * twelve + np.sin(angle) * three)
        points[..., i, :] = stay.position(s[..., i]) + arms[..., i, :]
    return points, tangents, arms


def facing(bay: Bay, s: Array, target: Array) -> Array:
    """Clock angles (..., 4) [rad] at which winch exits of bases at ``s`` (..., 4) point towards ``target`` (3,) [m]."""
    s = np.asarray(s, float)
    clock = np.empty(s.shape)
    for i, k in enumerate(bay.carriers):
        stay = bay.stays[k]
        twelve, three = stay.clock_frame(s[..., i])
        towards = target - stay.position(s[..., i])
        clock[..., i] = np.arctan2(np.sum(towards * three, -1), np.sum(towards * twelve, -1))
    return clock


def limits(squad: Squad, tangents: Array, arms: Array, reserve: float, driving: int | None) -> Array:
    """Linear limits (..., 2, 4, 4) on the four tensions, see ``robots.squad.suspension.upper_bounds``.

    Pull along the stay at most the hold force, or the drive force less the base's own acceleration for the base under
    way; twist about the stay ``|t u . (tangent x arm)|`` at most the palms' torque. Both lowered by ``reserve`` [1].
    """
    base = squad.base
    out = np.empty((*tangents.shape[:-2], 2, 4, 4))
    out[..., ALONG, :, :3] = tangents
    out[..., ALONG, :, 3] = base.hold_force * (1.0 - reserve)
    out[..., ABOUT, :, :3] = np.cross(tangents, arms)
    out[..., ABOUT, :, 3] = base.twist_torque * (1.0 - reserve)
    if driving is not None:
        out[..., ALONG, driving, 3] = base.drive_force * (1.0 - reserve) - base.mass * base.max_acceleration
    return out


def admissible(bay: Bay, squad: Squad, base: int, s: Array) -> NDArray[np.bool_]:
    """Whether a base's centre may stand or drive at ``s`` (n,): on the stay, clear of end zones and high obstacles."""
    stay = bay.stays[bay.carriers[base]]
    s = np.asarray(s, float)
    half = 0.5 * squad.base.length
    good = (s >= half) & (s <= stay.length - half)
    for zone in stay.intervals:
        if zone.kind == "end zone" or zone.height is None or zone.height > squad.base.obstacle_height:
            good &= (s + half <= zone.start) | (s - half >= zone.end)
    return good
