"""Plan an inspection with the zero-downtime gait: cells, stances, legs, squad moves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from steeplejack.errors import InfeasibleError, SteeplejackError
from steeplejack.planning.certificate import Scene, hold, meets
from steeplejack.planning.lattice import SAMPLE, Lattice, profile_along, runs, visible_levels
from steeplejack.planning.mission import FORMAT, Leg, Mission, Request, Uncovered, Waypoint
from steeplejack.planning.moves import Drive, fly, squad_move
from steeplejack.planning.stances import LOWER, UPPER, Cell, find, why_not
from steeplejack.robots.squad.anchorage import Stance
from steeplejack.spatial import to_quaternion

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

STANCES_PER_CELL = 3
LEAST_GAIN = 1.0  # [m] of stay a further stance must add
BRACED = 0.5  # [N] of jump in a planned tension above which a brace is inserted
BRACE_SAMPLE = 5.0  # [N] between the equilibria of a brace
BRACE_SPEED = 20.0  # [N/s] and [N/s2], estimate: a tenth of the winch's pull a second
ROUNDING = (
    1e-3  # [m or N] by which a waypoint may miss what was certified: tensions and angles are rounded in a mission
)
TURNING = 0.7  # [1] share of a base's turning rate that a plan uses
AROUND = 25.0  # [m] of stay beyond the outermost base that clearances are checked against
SMOOTHING = 5  # stations over which the stand-off is averaged, twice


@dataclass(frozen=True)
class _Progress:
    """Where the squad is while the plan grows."""

    stance: Stance | None
    place: Array | None  # (3,)
    number: int
    legs: tuple[Leg, ...]


def plan(scene: Scene, request: Request, assumed: tuple[str, ...], step: Callable[[float], None]) -> Mission:
    """Plan the inspection of [from, to] on every interior stay of a bay.

    Args:
        scene: Bay, machine, rules.
        request: What was asked for; ``from_m`` and ``to_m`` bound the stretch.
        assumed: Unknown data of the bridge that were assumed.
        step: Called with the fraction done.

    Raises:
        InfeasibleError: No stance holds any of it; names the binding limit.
    """
    bay = scene.bay
    state = _Progress(None, None, 0, ())
    uncovered: list[Uncovered] = []
    cells = _cells(request.from_m, request.to_m, scene.rules.cell_length)
    for done, (low, high) in enumerate(cells):
        local = scene.around(*_surroundings(low, high, state))
        lattice = Lattice.over(local, low, high)
        wanted = _wanted(local, lattice)
        left = wanted.copy()
        for _ in range(STANCES_PER_CELL):
            found = find(local, Cell(low, high, left), lattice)
            if found is None or found[1].sum() * _spacing(lattice) < min(LEAST_GAIN, left.sum() * _spacing(lattice)):
                break
            stance, _flags = found
            advanced = _advance(local, lattice, state, stance, left)
            if advanced is None:
                break
            state, seen = advanced
            left &= ~seen
        uncovered += _reasons(local, Cell(low, high, left), lattice)
        step((done + 1) / len(cells))
    if not any(leg.kind == "inspect" for leg in state.legs):
        why = uncovered[0].why if uncovered else "the stretch lies in end zones or obstacles"
        raise InfeasibleError(f"no stance holds the platform on fan {bay.fan}, stays {request.stays}", why)
    ids = [stay.id for stay in bay.stays]
    carriers = tuple(ids[k] for k in bay.carriers)
    return Mission(
        FORMAT,
        request,
        (ids[0], ids[-1]),
        tuple(ids[1:-1]),
        (carriers[0], carriers[1], carriers[2], carriers[3]),
        scene.rules.reserve,
        assumed,
        state.legs,
        tuple(_merged(uncovered)),
    ).sealed()


def held_fraction(scene: Scene, low: float, high: float) -> float:
    """Share of [low, high] on the interior stays that the best stance of each cell holds, moves aside."""
    held, wanted = 0, 0
    for a, b in _cells(low, high, scene.rules.cell_length):
        local = scene.around(*_surroundings(a, b, None))
        lattice = Lattice.over(local, a, b)
        cell = Cell(a, b, _wanted(local, lattice))
        found = find(local, cell, lattice)
        wanted += int(cell.wanted.sum())
        held += 0 if found is None else int(found[1].sum())
    return held / wanted if wanted else 0.0


def _cells(low: float, high: float, length: float) -> list[tuple[float, float]]:
    edges = np.linspace(low, high, max(1, int(np.ceil((high - low) / length - 1e-9))) + 1)
    return [(float(a), float(b)) for a, b in zip(edges[:-1], edges[1:], strict=True)]


def _surroundings(low: float, high: float, state: _Progress | None) -> tuple[float, float]:
    """The stretch of the stays that cables and platform may come near to while the squad moves to a cell and works it.

    Bases stand at most the search's offsets from the cell, or still where the last stance left them.
    """
    ends = [low + min(LOWER), high + max(UPPER)]
    if state is not None and state.stance is not None and state.place is not None:
        ends += [*state.stance.s, float(state.place[1])]
    return max(0.0, min(ends) - AROUND), max(ends) + AROUND


def _spacing(lattice: Lattice) -> float:
    return float(lattice.s[1] - lattice.s[0])


def _wanted(scene: Scene, lattice: Lattice) -> Flags:
    """Stations to inspect: on the stay, outside end zones and obstacles."""
    wanted = np.ones((len(scene.bay.interior), len(lattice.s)), bool)
    for row, k in enumerate(scene.bay.interior):
        stay = scene.bay.stays[k]
        wanted[row] = lattice.s <= stay.length
        for zone in stay.intervals:
            wanted[row] &= (lattice.s <= zone.start) | (lattice.s >= zone.end)
    return wanted


def _advance(
    scene: Scene, lattice: Lattice, state: _Progress, stance: Stance, wanted: Flags
) -> tuple[_Progress, Flags] | None:
    """Move the squad to a stance and inspect from it; None when the squad cannot get there."""
    legs: list[Leg] = []
    place, number = state.place, state.number
    if state.stance is not None and place is not None:
        number += 1
        span = Lattice.over(scene, min(place[1], lattice.s[0]), lattice.s[-1], coarse=2)
        drives = squad_move(scene, state.stance, stance, place, span)
        if drives is None:
            return None
        for drive in drives:
            legs += [_flight(scene, drive.before, piece, number, "fly", None) for piece in drive.flight]
            legs.append(_driving(scene, drive, number))
            place = drive.park
        # A base that did not drive keeps its clock angle, whatever the search gave it.
        stance = replace(stance, clock=_tuple(drives[-1].clock[-1])) if drives else state.stance
    anchors, pull = scene.anchors(np.array(stance.s), np.array(stance.clock))
    held, good = lattice.held(scene, anchors, pull)
    room = held.quality[:, 0].reshape(lattice.shape)
    seen = np.zeros_like(wanted)
    for row, first, last, places in _visits(scene, lattice, (anchors, pull), room, good, wanted, place):
        k = scene.bay.interior[row]
        if place is not None:
            pieces = fly(scene, lattice, stance, place, places[0])
            if pieces is None:
                continue
            legs += [_flight(scene, stance, piece, number, "fly", None) for piece in pieces]
        legs.append(_flight(scene, stance, places, number, "inspect", scene.bay.stays[k].id))
        place = places[-1]
        seen[row, first : last + 1] = True
    return _Progress(stance, place, number, _joined(scene, (*state.legs, *legs))), seen


def _visits(
    scene: Scene,
    lattice: Lattice,
    stance: tuple[Array, Array],
    room: Array,
    good: Flags,
    wanted: Flags,
    place: Array | None,
) -> list[tuple[int, int, int, Array]]:
    """Runs (row, first, last station, places) in zigzag order from the corner nearest to the platform."""
    rows = list(range(len(scene.bay.interior)))
    up = True
    if place is not None:
        up = abs(place[1] - lattice.s[0]) <= abs(place[1] - lattice.s[-1])
        if abs(place[0] - scene.bay.interior[0]) > abs(place[0] - scene.bay.interior[-1]):
            rows.reverse()
    out: list[tuple[int, int, int, Array]] = []
    for row in rows:
        found = _stay_runs(scene, lattice, stance, room, good, wanted[row], row)
        for first, last, places in found if up else found[::-1]:
            out.append((row, first, last, places if up else places[::-1]))
        up = up != bool(found)
    return out


def _stay_runs(
    scene: Scene,
    lattice: Lattice,
    stance: tuple[Array, Array],
    room: Array,
    good: Flags,
    wanted: Flags,
    row: int,
) -> list[tuple[int, int, Array]]:
    """Certified runs (first, last station, places) along one interior stay.

    Stations are certified on the lattice; the run between them, stand-off smoothed, is certified again as it will be
    flown, and cut where that fails.
    """
    k = scene.bay.interior[row]
    node = int(np.argmin(np.abs(lattice.eta - k)))
    visible = good[node] & visible_levels(scene, lattice, k)[None, :]
    near, far = scene.squad.camera.stand_off
    preferred = scene.bay.radius(k) + near + 0.4 * (far - near)
    level, reached = profile_along(room[node], visible, lattice.d, preferred)
    jump = np.concatenate([[False], np.abs(np.diff(level)) > 2])
    out: list[tuple[int, int, Array]] = []
    for first, last in runs(reached & wanted, jump):
        out += _certified(scene, lattice, stance, float(k), first, last, level)
    return out


def _certified(
    scene: Scene,
    lattice: Lattice,
    stance: tuple[Array, Array],
    k: float,
    first: int,
    last: int,
    level: NDArray[np.int64],
) -> list[tuple[int, int, Array]]:
    """A run as it will be flown: smoothed, or as found where smoothing leaves the certified set, or its good parts."""
    if last == first:
        return []
    part = slice(first, last + 1)
    for smoothing in (SMOOTHING, 1):
        places = _path(lattice, k, part, level, smoothing)
        good = hold(scene, *stance, places).good
        if good.all():
            return [(first, last, places)]
    broken = np.flatnonzero(~good)
    cut = int(np.clip(np.searchsorted(lattice.s, places[broken[0], 1]), first + 1, last))
    halves = ((first, cut - 1), (cut, last))
    return [run for a, b in halves for run in _certified(scene, lattice, stance, k, a, b, level)]


def _path(lattice: Lattice, k: float, part: slice, level: NDArray[np.int64], smoothing: int) -> Array:
    """Places (n, 3) of a run, a sample apart, its stand-off averaged twice over ``smoothing`` stations."""
    s, raw = lattice.s[part], lattice.d[level[part]]
    off = uniform_filter1d(uniform_filter1d(raw, smoothing, mode="nearest"), smoothing, mode="nearest")
    fine = np.linspace(s[0], s[-1], max(3, int(np.ceil((s[-1] - s[0]) / SAMPLE)) + 1))
    return np.column_stack([np.full(len(fine), k), fine, np.interp(fine, s, off)])


def _flight(scene: Scene, stance: Stance, places: Array, number: int, kind: str, stay: str | None) -> Leg:
    """A leg of the platform between gripped bases."""
    anchors, pull = scene.anchors(np.array(stance.s), np.array(stance.clock))
    points = scene.bay.place(places[:, 0], places[:, 1], places[:, 2])
    travel = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    s, clock = np.tile(stance.s, (len(places), 1)), np.tile(stance.clock, (len(places), 1))
    waypoints = _waypoints(scene, travel, places, points, anchors, pull, s, clock)
    motion = scene.squad.motion
    if kind == "inspect":
        return Leg("inspect", number, stay, None, motion.speed, motion.acceleration, waypoints)
    return Leg("fly", number, None, None, motion.transit_speed, motion.acceleration, waypoints)


def _driving(scene: Scene, drive: Drive, number: int) -> Leg:
    """A leg of one base, the platform parked."""
    anchors, pull = scene.anchors(drive.s, drive.clock, drive.base)
    places = np.tile(drive.park, (len(drive.s), 1))
    points = scene.bay.place(places[:, 0], places[:, 1], places[:, 2])
    travel = np.abs(drive.s[:, drive.base] - drive.s[0, drive.base])
    waypoints = _waypoints(scene, travel, places, points, anchors, pull, drive.s, drive.clock)
    base, turned = scene.squad.base, np.abs(np.diff(drive.clock[:, drive.base]))
    steepest = float(np.max(turned / np.diff(travel)))  # [rad/m]
    # Part of the turning rate is left to the controller that follows the reference.
    speed = min(scene.squad.motion.drive_speed, TURNING * base.max_turn_rate / max(steepest, 1e-9))
    return Leg("drive", number, None, drive.base + 1, speed, base.max_acceleration, waypoints)


def _joined(scene: Scene, legs: tuple[Leg, ...]) -> tuple[Leg, ...]:
    """The legs with a brace wherever the planned tensions would jump from one to the next."""
    out: list[Leg] = list(legs[:1])
    for leg in legs[1:]:
        before, after = out[-1].waypoints[-1], leg.waypoints[0]
        change = np.subtract(after.tension_n, before.tension_n)
        most = float(np.max(np.abs(change)))
        if most > BRACED:
            out.append(_brace(scene, before, after, change, leg.stance))
        out.append(leg)
    return tuple(out)


def _brace(scene: Scene, before: Waypoint, after: Waypoint, change: Array, number: int) -> Leg:
    """Change the tensions at one place, through equilibria, all bases gripped.

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
) -> tuple[Waypoint, ...]:
    held = hold(scene, anchors, pull, places, target)
    # Every caller has certified these places; what differs is the rounding of the file.
    if not meets(scene, held.quality, ROUNDING).all():
        raise SteeplejackError(f"a waypoint near s = {places[0, 1]:.1f} m does not meet the limits it was planned for")
    return tuple(
        Waypoint(
            round(float(travel[j]), 6),
            _three(places[j]),
            _three(points[j]),
            _tuple(to_quaternion(held.rotation[j])),
            _tuple(held.tension[j], 4),
            _tuple(s[j], 6),
            _tuple(np.degrees(clock[j]), 6),
        )
        for j in range(len(places))
    )


def _tuple(values: Array, digits: int = 9) -> tuple[float, float, float, float]:
    a, b, c, d = (round(float(v), digits) for v in values)
    return a, b, c, d


def _three(values: Array) -> tuple[float, float, float]:
    a, b, c = (round(float(v), 6) for v in values)
    return a, b, c


def _reasons(scene: Scene, cell: Cell, lattice: Lattice) -> list[Uncovered]:
    """Stretches of a cell that stay uncovered, with the limit that binds in the middle of each."""
    half = 0.5 * _spacing(lattice)
    out: list[Uncovered] = []
    for row, k in enumerate(scene.bay.interior):
        for first, last in runs(cell.wanted[row], np.zeros(len(lattice.s), bool)):
            why = why_not(scene, cell, lattice, row, (first + last) // 2)
            if why == "none":
                why = "held, but no certified way leads there, or over less than two stations"
            low, high = max(cell.low, lattice.s[first] - half), min(cell.high, lattice.s[last] + half)
            out.append(Uncovered(scene.bay.stays[k].id, float(low), float(high), why))
    return out


def _merged(stretches: list[Uncovered]) -> list[Uncovered]:
    """Join stretches of one stay that touch and have one reason."""
    out: list[Uncovered] = []
    for item in sorted(stretches, key=lambda u: (u.stay, u.from_m)):
        last = out[-1] if out else None
        if last and last.stay == item.stay and last.why == item.why and item.from_m - last.to_m < 1e-6:
            out[-1] = Uncovered(last.stay, last.from_m, item.to_m, last.why)
        else:
            out.append(item)
    return out
