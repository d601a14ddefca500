"""Plan an inspection with the zero-downtime gait: cells, stances, legs, squad moves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import InfeasibleError
from steeplejack.planning.cell import AMPLE, Cell
from steeplejack.planning.certificate import Scene
from steeplejack.planning.chain import Planned, best_chain
from steeplejack.planning.lattice import Lattice
from steeplejack.planning.legs import driving, flight, four, joined, least_margin
from steeplejack.planning.mission import FORMAT, Leg, Mission, Request, Uncovered
from steeplejack.planning.moves import fly, squad_move
from steeplejack.planning.outlook import Limits
from steeplejack.planning.pool import LOWER, UPPER, Site, pools
from steeplejack.planning.stances import find, why_not
from steeplejack.planning.visits import visits
from steeplejack.robots.squad.anchorage import Stance

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

STANCES_PER_CELL = 3
LEAST_GAIN = 1.0  # [m] of stay a further stance must add
MOVES = 8  # moves to the stances of one cell that are planned before the best of them is taken
POOLED = 0.6  # [1] share of the time of a plan that candidates take
HELD = "held, but not by a stance the plan could take or reach, or over less than two stations"
AROUND = 25.0  # [m] of stay beyond the outermost base that clearances are checked against


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
    sites = _sites(scene, request.from_m, request.to_m)
    chain = _chain(scene, sites, step)
    state, uncovered = chain.state, []
    for (local, cell, lattice), left in zip(sites, chain.left, strict=True):
        uncovered += _reasons(local, replace(cell, wanted=left), lattice)
    step(1.0)
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


def _sites(scene: Scene, low: float, high: float) -> list[Site]:
    """The cells of a stretch, each with the scene about it and its lattice."""
    out: list[Site] = []
    for a, b in _cells(low, high, scene.rules.cell_length):
        local = scene.around(*_surroundings(a, b))
        lattice = Lattice.over(local, a, b)
        out.append((local, Cell(a, b, _wanted(local, lattice)), lattice))
    return out


def _chain(scene: Scene, sites: list[Site], step: Callable[[float], None]) -> Planned[_Progress]:
    """The stances to take, with the squad's moves and the platform's legs."""
    found = pools(sites, lambda share: step(POOLED * share))

    def move(state: _Progress, at: tuple[int, int], left: Flags) -> tuple[_Progress, Flags, float] | None:
        _scene, cell, lattice = sites[at[0]]
        stance = found[at[0]][at[1]].stance
        local = scene.around(*_surroundings(cell.low, cell.high, state, stance))
        step(POOLED + (1.0 - POOLED) * at[0] / len(sites))
        return _advance(local, lattice, state, stance, left)

    gain = int(np.ceil(LEAST_GAIN / _spacing(sites[0][2]) - 1e-9))
    wanted = [cell.wanted for _scene, cell, _lattice in sites]
    start = _Progress(None, None, 0, ())
    return best_chain(found, wanted, start, move, Limits(gain, STANCES_PER_CELL, MOVES))


def held_fraction(scene: Scene, low: float, high: float) -> float:
    """Share of [low, high] on the interior stays that the best stance of each cell holds, moves aside."""
    held, wanted = 0, 0
    for site in _sites(scene, low, high):
        found = find(*site)
        wanted += int(site[1].wanted.sum())
        held += 0 if found is None else int(found.held.sum())
    return held / wanted if wanted else 0.0


def _cells(low: float, high: float, length: float) -> list[tuple[float, float]]:
    edges = np.linspace(low, high, max(1, int(np.ceil((high - low) / length - 1e-9))) + 1)
    return [(float(a), float(b)) for a, b in zip(edges[:-1], edges[1:], strict=True)]


def _surroundings(
    low: float, high: float, state: _Progress | None = None, stance: Stance | None = None
) -> tuple[float, float]:
    """The stretch of the stays that cables and platform may come near to while the squad moves to a cell and works it.

    Bases stand at most the search's offsets from the cell, where a stance says, or still where the last one left them.
    """
    ends = [low + min(LOWER), high + max(UPPER), *(() if stance is None else stance.s)]
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
) -> tuple[_Progress, Flags, float] | None:
    """Move the squad to a stance and inspect from it.

    Returns:
        Where it is then, the stations seen and the least slip margin, ample at most, of the legs that all bases are
        gripped in; None when the squad cannot get there, or not brace itself on the way.
    """
    legs: list[Leg | None] = []
    place, number = state.place, state.number
    if state.stance is not None and place is not None:
        span = Lattice.over(scene, min(place[1], lattice.s[0]), lattice.s[-1], coarse=2)
        drives = squad_move(scene, state.stance, stance, place, span)
        if drives is None:
            return None
        number += bool(drives)  # two cells may be inspected from one stance
        for drive in drives:
            legs += [flight(scene, drive.before, piece, number, "fly", None) for piece in drive.flight]
            legs.append(driving(scene, drive, number))
            place = drive.park
        # A base that did not drive keeps its clock angle, whatever the search gave it.
        stance = replace(stance, clock=four(drives[-1].clock[-1])) if drives else state.stance
    anchors, pull = scene.anchors(np.array(stance.s), np.array(stance.clock))
    held, good = lattice.held(scene, anchors, pull)
    room = held.quality[:, 0].reshape(lattice.shape)
    seen = np.zeros_like(wanted)
    for row, first, last, places in visits(scene, lattice, (anchors, pull), room, good, wanted, place):
        k = scene.bay.interior[row]
        if place is not None:
            pieces = fly(scene, lattice, stance, place, places[0])
            if pieces is None:
                continue
            legs += [flight(scene, stance, piece, number, "fly", None) for piece in pieces]
        legs.append(flight(scene, stance, places, number, "inspect", scene.bay.stays[k].id))
        place = places[-1]
        seen[row, first : last + 1] = True
    last = state.legs[-1:]  # what comes before it is joined already
    whole = [leg for leg in legs if leg is not None]
    added = joined(scene, (*last, *whole)) if len(whole) == len(legs) else None
    if added is None:
        return None
    added = added[len(last) :]
    return _Progress(stance, place, number, (*state.legs, *added)), seen, min(AMPLE, least_margin(scene, added))


def _reasons(scene: Scene, cell: Cell, lattice: Lattice) -> list[Uncovered]:
    """Stretches of a cell that stay uncovered, each about neighbouring stations at which the same limit binds."""
    half = 0.5 * _spacing(lattice)
    out: list[Uncovered] = []
    for row, k in enumerate(scene.bay.interior):
        stations = np.flatnonzero(cell.wanted[row])
        for j, why in zip(stations, why_not(scene, cell, lattice, row, stations), strict=True):
            low, high = max(cell.low, lattice.s[j] - half), min(cell.high, lattice.s[j] + half)
            out.append(Uncovered(scene.bay.stays[k].id, float(low), float(high), HELD if why == "none" else why))
    return _merged(out)


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
