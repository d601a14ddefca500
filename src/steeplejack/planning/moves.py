"""The whole-squad move of the zero-downtime gait: bases drive to their next places one at a time.

While one base drives, the platform is parked at a place certified for the whole drive: the cable of the base under way
stays taut within the driving limit, the other three are gripped and within theirs. Between two drives the platform may
fly to another park. The order of the bases is found by depth-first search; for each drive the first park that can be
reached is taken, and no other tried where the search fails beyond it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.certificate import Scene, hold, survey
from steeplejack.planning.lattice import Lattice, route, straighten
from steeplejack.robots.squad.anchorage import ALONG, Stance, admissible

Array = NDArray[np.float64]

DRIVE_SAMPLE = 0.25  # [m] between certified places of a base under way
PARKS = 12  # parks certified for one drive before it counts as impossible
SPARE = 0.05  # [1] of its drive force that a base under way keeps beyond the reserve, where a park allows it
CROWDED = 40.0  # [N] of room above which a park is no better for having more


@dataclass(frozen=True)
class Drive:
    """One base drives while the platform is parked; before it, the platform flies to the park."""

    base: int
    flight: tuple[Array, ...]  # straight pieces of places (n, 3) from the last place to the park
    park: Array  # (3,) place of the platform
    s: Array  # (m, 4) base positions along the drive [m]
    clock: Array  # (m, 4) clock angles along the drive [rad]
    before: Stance  # stance the flight takes place in
    pull: Array  # (m, 2, 4, 4) linear limits it is certified with


def _turned(start: float, end: float) -> float:
    """The angle equal to ``end`` that is nearest to ``start`` [rad]."""
    return start + (end - start + np.pi) % (2.0 * np.pi) - np.pi


def _drive(scene: Scene, now: Stance, then: Stance, base: int) -> tuple[Array, Array]:
    """Base positions and clock angles (m, 4) while ``base`` drives from one stance to the next."""
    count = max(2, int(np.ceil(abs(then.s[base] - now.s[base]) / DRIVE_SAMPLE)) + 1)
    s, clock = np.tile(now.s, (count, 1)), np.tile(now.clock, (count, 1))
    s[:, base] = np.linspace(now.s[base], then.s[base], count)
    clock[:, base] = np.linspace(now.clock[base], _turned(now.clock[base], then.clock[base]), count)
    return s, clock


def _passable(scene: Scene, s: Array, base: int) -> bool:
    """Whether the base's way is clear of end zones, obstacles and the other base on its stay."""
    partner = {0: 3, 3: 0, 1: 2, 2: 1}[base]
    below, above = (base, partner) if base in (0, 1) else (partner, base)
    apart = bool(np.all(s[:, above] - s[:, below] >= scene.squad.base.spacing))
    return apart and bool(np.all(admissible(scene.bay, scene.squad, base, s[:, base])))


def _parks(scene: Scene, lattice: Lattice, base: int, s: Array, clock: Array, place: Array) -> Iterator[Array]:
    """Places (3,) that hold the platform along a whole drive by the fast survey, best first."""
    every = slice(None, None, 4)
    ways = np.unique(np.concatenate([np.arange(len(s))[every], [len(s) - 1]]))
    anchors, pull = scene.anchors(s[ways], clock[ways], base)
    nodes = np.concatenate([place[None], lattice.places])
    points = scene.bay.place(nodes[:, 0], nodes[:, 1], nodes[:, 2])
    lower, upper = scene.window
    rotation = scene.bay.frame(float(place[0]), float(place[1]))
    room = np.min(survey(anchors, pull, scene.attachments, scene.weight, rotation, points, lower, upper), axis=0)
    distance = np.linalg.norm(points - points[0], axis=1)
    worth = np.where(room > 0.0, np.minimum(room, CROWDED) - 2.0 * distance, -np.inf)
    for index in np.argsort(-worth, kind="stable")[:PARKS]:
        if np.isfinite(worth[index]):
            yield nodes[index]


def _held_parks(
    scene: Scene, lattice: Lattice, base: int, s: Array, clock: Array, place: Array
) -> Iterator[tuple[Array, Array]]:
    """Parks (3,) certified for a whole drive, with their linear limits: those that leave pull to spare before the rest.

    What is spared of the pull of the base under way is left for what control adds.
    """
    anchors, pull = scene.anchors(s, clock, base)
    eased = pull.copy()
    eased[..., ALONG, base, 3] -= SPARE * scene.squad.base.drive_force
    others: list[Array] = []
    for park in _parks(scene, lattice, base, s, clock, place):
        if _held(scene, anchors, eased, park):
            yield park, eased
        else:
            others.append(park)
    for park in others:
        if _held(scene, anchors, pull, park):
            yield park, pull


def _held(scene: Scene, anchors: Array, pull: Array, park: Array) -> bool:
    return bool(hold(scene, anchors, pull, np.tile(park, (len(anchors), 1))).along.all())


def fly(scene: Scene, lattice: Lattice, stance: Stance, start: Array, end: Array) -> tuple[Array, ...] | None:
    """Straight, certified pieces from one place (3,) to another within a stance; None when there is no way."""
    if np.allclose(start, end):
        return ()
    anchors, pull = scene.anchors(np.array(stance.s), np.array(stance.clock))
    direct = straighten(scene, anchors, pull, np.stack([start, end]))
    if all(hold(scene, anchors, pull, piece).along.all() for piece in direct):
        return tuple(direct)
    held, good = lattice.held(scene, anchors, pull)
    if not good.any():
        return None
    room = held.quality[:, 0].reshape(lattice.shape)
    first, last = (_joined(scene, lattice, anchors, pull, good, place) for place in (start, end))
    if first is None or last is None:
        return None
    spacing = float(np.linalg.norm(scene.bay.axis(2.0, start[1]) - scene.bay.axis(1.0, start[1])))
    nodes = route(lattice, good, room, first, last, spacing)
    if nodes is None:
        return None
    corners = np.concatenate([start[None], lattice.places[nodes], end[None]])
    pieces = straighten(scene, anchors, pull, corners)
    return tuple(pieces) if all(hold(scene, anchors, pull, piece).along.all() for piece in pieces) else None


def _joined(
    scene: Scene, lattice: Lattice, anchors: Array, pull: Array, good: NDArray[np.bool_], place: Array
) -> int | None:
    """A good node that a straight certified piece joins to a place."""
    for node in lattice.nearest(place, good)[:6]:
        if np.allclose(lattice.places[node], place):
            return node
        pieces = straighten(scene, anchors, pull, np.stack([place, lattice.places[node]]))
        if all(hold(scene, anchors, pull, piece).along.all() for piece in pieces):
            return node
    return None


def squad_move(scene: Scene, now: Stance, then: Stance, place: Array, lattice: Lattice) -> list[Drive] | None:
    """Drives that take the squad from one stance to the next, platform first at ``place`` (3,).

    Returns:
        The drives in order, or None when no order of the bases with parks on the lattice is certified.
    """
    left = [base for base in range(4) if abs(then.s[base] - now.s[base]) > 1e-9]
    if not left:
        return []
    # Bases that move towards the free end of their stay first: the order most likely to keep the pair apart.
    upwards = sum(then.s) > sum(now.s)
    for base in sorted(left, key=lambda i: (i in (0, 1)) == upwards):
        s, clock = _drive(scene, now, then, base)
        if not _passable(scene, s, base):
            continue
        for park, kept in _held_parks(scene, lattice, base, s, clock, place):
            flight = fly(scene, lattice, now, place, park)
            if flight is None:
                continue
            after = replace(now, s=_set(now.s, base, then.s[base]), clock=_set(now.clock, base, float(clock[-1, base])))
            rest = squad_move(scene, after, then, park, lattice)
            if rest is not None:
                return [Drive(base, flight, park, s, clock, now, kept), *rest]
            break
    return None


def _set(values: tuple[float, float, float, float], index: int, value: float) -> tuple[float, float, float, float]:
    changed = list(values)
    changed[index] = value
    return changed[0], changed[1], changed[2], changed[3]
