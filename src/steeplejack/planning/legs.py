"""Legs of a mission from certified places: flights, drives of a base, and braces between them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.certificate import Scene, hold, meets, slip_margin
from steeplejack.planning.mission import Leg, Waypoint
from steeplejack.planning.moves import Drive
from steeplejack.robots.squad.anchorage import Stance
from steeplejack.spatial import from_quaternion, to_quaternion, to_vector

Array = NDArray[np.float64]

BRACED = 0.5  # [N] of jump in a planned tension above which a brace is inserted
TURNED = np.deg2rad(1.0)  # [rad] of jump in the planned orientation above which two legs do not join, estimate
BRACE_SAMPLE = 5.0  # [N] between the equilibria of a brace
BRACE_SPEED = 20.0  # [N/s] and [N/s2], estimate: a tenth of the winch's pull a second
HAIR = 1e-3  # [m or N] by which a waypoint may miss a limit that was met when the place was first certified
TURNING = 0.7  # [1] share of a base's turning rate that a plan uses


def flight(scene: Scene, stance: Stance, places: Array, number: int, kind: str, stay: str | None) -> Leg | None:
    """A leg of the platform between gripped bases; None where a waypoint is not held as it is written."""
    anchors, pull = scene.anchors(np.array(stance.s), np.array(stance.clock))
    points = scene.bay.place(places[:, 0], places[:, 1], places[:, 2])
    travel = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    s, clock = np.tile(stance.s, (len(places), 1)), np.tile(stance.clock, (len(places), 1))
    waypoints = _waypoints(scene, travel, places, points, anchors, pull, s, clock)
    if waypoints is None:
        return None
    motion = scene.squad.motion
    if kind == "inspect":
        return Leg("inspect", number, stay, None, motion.speed, motion.acceleration, waypoints)
    return Leg("fly", number, None, None, motion.transit_speed, motion.acceleration, waypoints)


def driving(scene: Scene, drive: Drive, number: int) -> Leg | None:
    """A leg of one base, the platform parked; None as of `flight`."""
    anchors, _pull = scene.anchors(drive.s, drive.clock, drive.base)
    places = np.tile(drive.park, (len(drive.s), 1))
    points = scene.bay.place(places[:, 0], places[:, 1], places[:, 2])
    travel = np.abs(drive.s[:, drive.base] - drive.s[0, drive.base])
    waypoints = _waypoints(scene, travel, places, points, anchors, drive.pull, drive.s, drive.clock)
    if waypoints is None:
        return None
    base, turned = scene.squad.base, np.abs(np.diff(drive.clock[:, drive.base]))
    steepest = float(np.max(turned / np.diff(travel)))  # [rad/m]
    # Part of the turning rate is left to the controller that follows the reference.
    speed = min(scene.squad.motion.drive_speed, TURNING * base.max_turn_rate / max(steepest, 1e-9))
    return Leg("drive", number, None, drive.base + 1, speed, base.max_acceleration, waypoints)


def joined(scene: Scene, legs: tuple[Leg, ...]) -> tuple[Leg, ...] | None:
    """The legs with a brace wherever the planned tensions would jump.

    None where a brace is not certified, or where the platform would turn at once: its ends are two equilibria then.
    """
    out: list[Leg] = list(legs[:1])
    for leg in legs[1:]:
        before, after = out[-1].waypoints[-1], leg.waypoints[0]
        change = np.subtract(after.tension_n, before.tension_n)
        if float(np.max(np.abs(change))) > BRACED:
            brace = _brace(scene, before, after, change, leg.stance)
            if brace is None:
                return None
            out.append(brace)
        elif _turn(before, after) > TURNED:
            return None
        out.append(leg)
    return tuple(out)


def _turn(one: Waypoint, other: Waypoint) -> float:
    """Angle between two orientations [rad]."""
    a, b = (from_quaternion(np.array(each.quaternion)) for each in (one, other))
    return float(np.linalg.norm(to_vector(a.T @ b)))


def _brace(scene: Scene, before: Waypoint, after: Waypoint, change: Array, number: int) -> Leg | None:
    """Change the tensions at one place, through equilibria, all bases gripped; None where one is not certified.

    Both ends lie in the family ``t_p + lambda n`` of one place and within the limits of gripped bases, so what lies
    between nearly does; each step is certified with its own orientation.
    """
    most = float(np.max(np.abs(change)))
    share = np.linspace(0.0, 1.0, max(3, int(np.ceil(most / BRACE_SAMPLE)) + 1))
    places = np.tile(before.place, (len(share), 1))
    points = np.tile(before.position_m, (len(share), 1))
    s, clock = np.tile(after.base_s_m, (len(share), 1)), np.tile(np.radians(after.base_clock_deg), (len(share), 1))
    anchors, pull = scene.anchors(s[0], clock[0])
    target = np.asarray(before.tension_n) + share[:, None] * change
    waypoints = _waypoints(scene, most * share, places, points, anchors, pull, s, clock, target)
    if waypoints is None:
        return None
    missed = np.subtract([waypoints[0].tension_n, waypoints[-1].tension_n], [before.tension_n, after.tension_n])
    turned = max(_turn(waypoints[0], before), _turn(waypoints[-1], after))
    if float(np.max(np.abs(missed))) > BRACED or turned > TURNED:
        return None
    return Leg("brace", number, None, None, BRACE_SPEED, BRACE_SPEED, waypoints)


def _waypoints(
    scene: Scene,
    travel: Array,
    places: Array,
    points: Array,
    anchors: Array,
    pull: Array,
    s: Array,
    clock: Array,
    target: Array | None = None,
) -> tuple[Waypoint, ...] | None:
    """Places as they are written to a mission; None where one turns at once or misses a limit by more than a hair.

    A place was certified before among others, so from another guess, or was rounded when an earlier leg was written.
    """
    held = hold(scene, anchors, pull, places, target)
    if not (meets(scene, held.quality, HAIR) & held.steady).all():
        return None
    return tuple(
        Waypoint(
            round(float(travel[j]), 6),
            _three(places[j]),
            _three(points[j]),
            four(to_quaternion(held.rotation[j])),
            four(held.tension[j], 4),
            four(s[j], 6),
            four(np.degrees(clock[j]), 6),
        )
        for j in range(len(places))
    )


def four(values: Array, digits: int = 9) -> tuple[float, float, float, float]:
    """Four values as they are written to a mission."""
    a, b, c, d = (round(float(v), digits) for v in values)
    return a, b, c, d


def _three(values: Array) -> tuple[float, float, float]:
    a, b, c = (round(float(v), 6) for v in values)
    return a, b, c


def least_margin(scene: Scene, legs: Iterable[Leg]) -> float:
    """Least slip margin [1] over the waypoints of legs that all bases are gripped in."""
    least = 1.0
    for leg in legs:
        if leg.kind != "drive":
            points = leg.waypoints
            s, clock = (np.array([getattr(w, name) for w in points]) for name in ("base_s_m", "base_clock_deg"))
            rotation = np.stack([from_quaternion(np.array(point.quaternion)) for point in points])
            position, tension = (np.array([getattr(w, name) for w in points]) for name in ("position_m", "tension_n"))
            anchors, pull = scene.anchors(s, np.radians(clock))
            least = min(least, float(np.min(slip_margin(scene, anchors, pull, position, rotation, tension))))
    return least
