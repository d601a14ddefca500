"""The stance chart of a bridge: along every interior stay, how well the best stance near by holds a payload.

Each stay is charted in the bay of a few stays about it, its outer stays carrying the bases. Phases are the five the
squad works in: all bases gripped, and each base in turn driving (it then holds less). Beside the best stance stands
one fixed stance per cell, bases at the ends of a cell on both boundary stays, which is what is left when the squad
does not choose.

Two statics. ``chords``: the platform a point on the stay's chord, forces in the best-fit plane of the bay; an estimate
in milliseconds a station. ``space``: equilibria on the sagging stays at the camera's stand-offs, as a mission is
certified: torque about the stays, stability, dexterity, clearance, the drum's length.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.stances.ground import Ground, on_bay, straight
from steeplejack.design.stances.held import HELD, UNKNOWN
from steeplejack.design.stances.search import Room, best_stances, compass
from steeplejack.design.stances.weigh import Equilibria, by_forces, room_about
from steeplejack.design.stances.worth import POINT, SLIP, SPACE
from steeplejack.errors import InputError
from steeplejack.robots.squad import Bay, Squad
from steeplejack.worksite import Bridge, Fan
from steeplejack.worksite.bridge import plane_normal

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Statics = Literal["chords", "space"]

PHASES = ("gripped", "base 1 drives", "base 2 drives", "base 3 drives", "base 4 drives")
REASONS = (
    "held",
    "slip",
    "no balance of forces",
    "unstable",
    "dexterity",
    "cable too long",
    "cable meets a stay",
    "platform meets a stay",
    "no tensions within their window",
)
COUNT = 7
"""Places tried for each base before the search goes on from the best."""
STARTS = 2
TOLERANCE = 0.25
"""Last step of the search along a stay [m]; margins gain under 0.01 beyond it."""
CERTIFIED = 64
"""Stances of the grid whose equilibrium is looked at before a place counts as not held."""
AT_ONCE = 8
"""Of them, judged in one call."""
SWING = 0.05
"""Kept from both ends of the camera's range [m]: off the face the platform swings."""
AROUND = 25.0
"""Stay beyond the outermost base that clearances are checked against [m]."""
NODE = 4.0
"""Nodes of the stays that clearances are checked against [m]."""
BLOCK = 24
"""Stations for which the stays around are cut to one stretch."""


@dataclass(frozen=True)
class ChartRules:
    """What a chart asks for.

    Attributes:
        mass: Of platform and payload [kg].
        tension: Working window of the driving cables [N].
        within: How far from the platform's s a base may stand along its stay [m].
        spacing: Distance of the stations [m].
        width: Stays of a bay, boundary stays included, where the fan has as many.
        cell: Length of the cells of the fixed stance [m].
        reserve: Taken off every tension, pull and twist limit [1].
        levels: Stand-offs tried over the camera's range, in space.
        twist: Whether what a base holds about its stay counts, in space.
        cable_clearance: Gap of a driving cable from a stay's surface, in space [m].
        dexterity: Least over largest singular value in the plane of the cables, in space [1].
        driving: Whether the phases in which a base drives are charted as well.
    """

    mass: float = 30.0
    tension: tuple[float, float] = (10.0, 400.0)
    within: float = 30.0
    spacing: float = 2.0
    width: int = 5
    cell: float = 30.0
    reserve: float = 0.0
    levels: int = 4
    twist: bool = True
    cable_clearance: float = 0.02
    dexterity: float = 0.2
    driving: bool = True

    def __post_init__(self) -> None:
        """Refuse what no chart can be made of."""
        for name in ("mass", "within", "spacing", "cell"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise InputError(name, f"{getattr(self, name):g}", "a finite number above 0")
        if self.width < 3 or self.levels < 1:
            raise InputError("width, levels", f"{self.width}, {self.levels}", "at least 3 stays and 1 level")
        if not 0.0 <= self.reserve < 1.0:
            raise InputError("reserve", f"{self.reserve:g}", "a share of 0 or more, below 1")


def stance_chart(
    bridge: Bridge,
    squad: Squad,
    rules: ChartRules | None = None,
    statics: Statics = "chords",
    fans: Sequence[str] | None = None,
    bay: tuple[int, int] | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Chart the interior stays of a bridge.

    Args:
        bridge: The bridge; in ``space`` its stays sag as it says.
        squad: The machine.
        rules: What is asked for; by default 30 kg, 10-400 N, stances within 30 m.
        statics: ``chords`` or ``space``, see the module.
        fans: Names of the fans; all by default.
        bay: Boundary stays whose interior stays to chart; by default every interior stay of a fan in a bay of its own.
        progress: Called with the share done, from whichever thread has done it.

    Returns:
        On dimensions ``stay``, ``phase``, ``s`` [m] (and ``base``): ``margin``, the best slip margin [1], not a number
        where no stance holds any tensions; ``stance`` (.., base) [m]; ``fixed_margin`` of the fixed stance; ``asked``
        (stay, s), whether a station lies on the stay outside end zones and obstacles; in space also ``force_margin``,
        the grid's best by forces alone, ``stand_off`` [m] and ``reason``, an index into the attribute ``reasons``.

    Raises:
        InputError: An unknown fan, or a bay without an interior stay.
    """
    rules = rules or ChartRules()
    source = bridge.as_chords() if statics == "chords" else bridge
    chosen = [source.fan(name) for name in fans] if fans is not None else list(source.fans.values())
    rows = [row for fan in chosen for row in _rows(fan, rules.width, bay, squad)]
    if not rows:
        raise InputError("bay", "no interior stay", "boundary stays at least two apart, in fans of three stays or more")
    done: list[int] = []

    def along(row: tuple[Bay, int]) -> dict[str, Array]:
        table = _along(bridge, squad, rules, statics, *row)
        done.append(row[1])
        if progress:
            progress(len(done) / len(rows))
        return table

    # The kernels let other threads run; stays are independent and come back in order.
    with ThreadPoolExecutor() as pool:
        tables = list(pool.map(along, rows))
    return _dataset(bridge, rules, statics, rows, tables)


def shares(chart: xr.Dataset) -> xr.Dataset:
    """Share of the asked stay length, over all stays, held by some stance and by the fixed one, by phase.

    A stay's stations are evenly spaced, so their share is that of its length. ``every_phase`` is the share held in all
    phases, each with a stance of its own.
    """
    asked = chart["asked"]
    held, fixed = chart["margin"] >= 0.0, chart["fixed_margin"] >= 0.0
    total = asked.sum()
    return chart[[]].assign(
        free=(held & asked).sum(("stay", "s")) / total,
        fixed=(fixed & asked).sum(("stay", "s")) / total,
        every_phase=(held.all("phase") & asked).sum() / total,
        fixed_every_phase=(fixed.all("phase") & asked).sum() / total,
    )


def _rows(fan: Fan, width: int, bay: tuple[int, int] | None, squad: Squad) -> list[tuple[Bay, int]]:
    """Bays and the stays charted in them: all inside one bay, or each in a bay centred on it as the fan allows."""
    if bay is not None:
        one = Bay.of(fan, *bay, "under", squad)
        return [(one, k) for k in one.interior]
    count = min(width, len(fan.stays))
    rows: list[tuple[Bay, int]] = []
    for place in range(1, len(fan.stays) - 1):
        first = min(max(place - count // 2, 0), len(fan.stays) - count)
        ends = fan.stays[first].index, fan.stays[first + count - 1].index
        rows.append((Bay.of(fan, *ends, "under", squad), place - first))
    return rows


def _along(bridge: Bridge, squad: Squad, rules: ChartRules, statics: Statics, bay: Bay, k: int) -> dict[str, Array]:
    """The chart of one stay, by name of its variables; stations first."""
    s = np.arange(0.5 * rules.spacing, bay.stays[k].length, rules.spacing)
    asked = np.ones(len(s), bool)
    for zone in bay.stays[k].intervals:
        asked &= (s <= zone.start) | (s >= zone.end)
    ground = on_bay(bay, squad, rules.tension, rules.reserve, None, rules.twist and statics == "space")
    limits = _limits(bay, squad, rules, statics)
    room = room_about(ground, np.repeat(s[:, None], 4, axis=1), rules.within)
    fixed = _fixed(ground, s, rules)
    parts: list[dict[str, Array]] = []
    todo = np.flatnonzero(asked)
    for begin in range(0, len(todo), BLOCK):
        block = todo[begin : begin + BLOCK]
        some = s[block], replace(room, windows=room.windows[block]), fixed[block]
        if statics == "chords":
            parts.append(_in_plane(bridge, bay, k, rules, ground, limits, *some))
        else:
            parts.append(_in_space(bridge, bay, k, squad, rules, ground, limits, *some))
    table = {"s": s, "asked": asked}
    for name in parts[0] if parts else ():
        values = np.concatenate([part[name] for part in parts])
        table[name] = np.full((len(s), *values.shape[1:]), np.nan)
        table[name][todo] = values
    return table


def _limits(bay: Bay, squad: Squad, rules: ChartRules, statics: Statics) -> Array:
    """Limits of every phase (q, 4, 3) [N]; the estimate on chords knows no acceleration of a base under way."""
    phases = (None, 0, 1, 2, 3) if rules.driving else (None,)
    limits = np.stack([on_bay(bay, squad, rules.tension, rules.reserve, base).limits for base in phases])
    if statics == "chords":
        for row, base in enumerate(phases):
            if base is not None:
                limits[row, base, 2] = squad.base.drive_force * (1.0 - rules.reserve)
    return limits


def _fixed(ground: Ground, s: Array, rules: ChartRules) -> Array:
    """The fixed stance (n, 4) [m] of each station's cell: bases at its ends; not a number where no cell lies.

    Cells follow each other from where the first bases can stand; the last ends where the last can, and overlaps.
    """
    low = max(_first_free(ground, i) for i in range(4))
    high = min(_last_free(ground, i) for i in range(4))
    starts = np.arange(low, high - rules.cell + 1e-9, rules.cell)
    if not len(starts):
        return np.full((len(s), 4), np.nan)
    if starts[-1] + rules.cell < high:
        starts = np.append(starts, high - rules.cell)
    cell = np.clip(np.searchsorted(starts, s, side="right") - 1, 0, len(starts) - 1)
    begin = starts[cell]
    fixed = np.stack([begin, begin, begin + rules.cell, begin + rules.cell], axis=-1)
    fixed[(s < low) | (s > high)] = np.nan
    return fixed


def _first_free(ground: Ground, base: int) -> float:
    zones = ground.barred[base]
    return float(max([ground.range[base, 0], *(zone[1] for zone in zones if zone[0] <= ground.range[base, 0])]))


def _last_free(ground: Ground, base: int) -> float:
    zones = ground.barred[base]
    return float(min([ground.range[base, 1], *(zone[0] for zone in zones if zone[1] >= ground.range[base, 1])]))


def _in_plane(
    bridge: Bridge,
    bay: Bay,
    k: int,
    rules: ChartRules,
    ground: Ground,
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
        "margin": _known(found.worth).reshape(n, q),
        "stance": found.s.reshape(n, q, 4),
        "fixed_margin": _known(other(np.arange(n * q), np.repeat(fixed, q, axis=0)[:, None])).reshape(n, q),
    }


def _in_space(
    bridge: Bridge,
    bay: Bay,
    k: int,
    squad: Squad,
    rules: ChartRules,
    ground: Ground,
    limits: Array,
    s: Array,
    room: Room,
    fixed: Array,
) -> dict[str, Array]:
    """Stations of one stay by equilibria in space; a row is a station, a stand-off and a phase."""
    near, far = squad.camera.stand_off
    off = np.linspace(near + SWING, far - SWING, rules.levels)
    shape = len(s), len(off), len(limits)
    each = [np.ravel(values) for values in np.broadcast_arrays(*np.ix_(s, off, np.arange(len(limits))))]
    positions = bay.place(np.full(each[0].shape, float(k)), each[0], each[1] + bay.radius(k))
    guesses = np.repeat(np.stack([bay.frame(float(k), float(value)) for value in s]), shape[1] * shape[2], axis=0)
    room = replace(room, windows=np.repeat(room.windows, shape[1] * shape[2], axis=0))
    rows = np.arange(len(positions))
    attachments, weight = np.array(squad.platform.attachments), rules.mass * np.asarray(bridge.gravity)
    arms = attachments @ np.swapaxes(guesses, -1, -2)
    forces = by_forces(SLIP, SPACE, ground, room, positions, arms, weight[None], limits[each[2].astype(int)])
    platform = attachments, weight, np.array(squad.platform.centre_of_mass)
    truth = Equilibria(
        ground, room, positions, guesses, limits[each[2].astype(int)], platform, _surroundings(bay, squad, rules, s)
    )
    grid = room.grid(COUNT)
    values = forces(rows, grid)
    stances, margins, reasons = _ranked(truth, values, grid)
    level = np.argmax(margins.reshape(shape), axis=1)
    best = np.ravel((np.arange(shape[0])[:, None] * shape[1] + level) * shape[2] + np.arange(shape[2]))
    chosen = truth.of(best)
    mesh = float(np.max(room.windows[..., 1] - room.windows[..., 0])) / (COUNT - 1)
    stance, margin = compass(
        chosen.margin, chosen.room, stances[best], margins[best], 0.5 * mesh, TOLERANCE, together=False
    )
    level = np.where(np.isfinite(margin), each[1][best], np.nan)
    standing = replace(room, windows=np.broadcast_to([-np.inf, np.inf], room.windows.shape))
    others = truth.on(standing).margin(rows, np.repeat(fixed, shape[1] * shape[2], axis=0)[:, None])
    out = {
        "margin": _known(margin),
        "fixed_margin": _known(others.reshape(shape).max(axis=1)),
        "force_margin": _known(values.max(axis=1).reshape(shape).max(axis=1)),
        "stand_off": level,
        "reason": reasons[best].astype(float),
    }
    return {"stance": stance.reshape(shape[0], shape[2], 4)} | {
        name: of.reshape(shape[0], shape[2]) for name, of in out.items()
    }


def _ranked(truth: Equilibria, values: Array, grid: Array) -> tuple[Array, Array, NDArray[np.int64]]:
    """For each row the first stance of the grid (n, c, 4), in the order of its worth by forces, that truly holds.

    Returns:
        Stances (n, 4) [m], their margins (n,), ``-inf`` where none of those looked at holds, and why the first did not.
    """
    order = np.argsort(-values, axis=1, kind="stable")[:, :CERTIFIED]
    stances, margins = np.full((len(values), 4), np.nan), np.full(len(values), -np.inf)
    reasons = np.full(len(values), UNKNOWN)
    left = np.arange(len(values))
    for begin in range(0, order.shape[1], AT_ONCE):
        some = order[left, begin : begin + AT_ONCE]
        # Below 0 by forces nothing holds; one stance is judged all the same for the reason.
        open_ = values[left, some[:, 0]] >= (-np.inf if begin == 0 else 0.0)
        left, some = left[open_], some[open_]
        if not len(left):
            break
        trial = np.take_along_axis(grid[left], some[..., None], axis=1)
        found, why = truth.judge(left, trial)
        if begin == 0:
            reasons[left] = why[:, 0]
        good = why == HELD
        first = np.argmax(good, axis=1)
        hit = good[np.arange(len(left)), first]
        stances[left[hit]], margins[left[hit]] = trial[hit, first[hit]], found[hit, first[hit]]
        reasons[left[hit]] = HELD
        left = left[~hit]
    return stances, margins, reasons


def _surroundings(bay: Bay, squad: Squad, rules: ChartRules, s: Array) -> tuple[Array, Array, NDArray[np.int64], Array]:
    """Stays as polylines about the stations (k, n, 3) [m], their radii [m], each base's own, and what is asked."""
    low, high = max(0.0, float(np.min(s)) - rules.within - AROUND), float(np.max(s)) + rules.within + AROUND
    nodes = max(2, int(np.ceil((high - low) / NODE)) + 1)
    lines = [stay.position(np.linspace(min(low, stay.length), min(high, stay.length), nodes)) for stay in bay.stays]
    asked = [squad.cable.axial_stiffness, rules.dexterity, squad.winch.stored_length, rules.cable_clearance]
    radii = np.array([bay.radius(i) for i in range(len(bay.stays))])
    return np.stack(lines), radii, np.array(bay.carriers), np.array([*asked, squad.platform.clearance])


def _known(margins: Array) -> Array:
    """Margins with not a number where no tensions hold the platform."""
    return np.where(margins > -1e3, margins, np.nan)


def _dataset(
    bridge: Bridge, rules: ChartRules, statics: Statics, rows: list[tuple[Bay, int]], tables: list[dict[str, Array]]
) -> xr.Dataset:
    """Stays side by side on one axis of stations, not a number beyond a stay's end."""
    import xarray as xr

    longest = max((table["s"] for table in tables), key=len)
    phases = PHASES if rules.driving else PHASES[:1]
    units = {"margin": "1", "fixed_margin": "1", "force_margin": "1", "stance": "m", "stand_off": "m", "reason": "1"}
    variables = {}
    asked = np.zeros((len(tables), len(longest)), bool)
    for i, table in enumerate(tables):
        asked[i, : len(table["s"])] = table["asked"]
    variables["asked"] = (("stay", "s"), asked)
    present = [name for name in units if any(name in table for table in tables)]
    for name in present:
        sample = next(table[name] for table in tables if name in table)
        values = np.full((len(tables), len(longest), *sample.shape[1:]), np.nan)
        for i, table in enumerate(tables):
            if name in table:
                values[i, : len(table["s"])] = table[name]
        dims = ("stay", "phase", "s", "base") if name == "stance" else ("stay", "phase", "s")
        variables[name] = (dims, np.moveaxis(values, 1, 2), {"units": units[name]})
    return xr.Dataset(
        variables,
        coords={
            "stay": [bay.stays[k].id for bay, k in rows],
            "bay": ("stay", [f"{bay.stays[0].index}:{bay.stays[-1].index}" for bay, _k in rows]),
            "phase": list(phases),
            "s": ("s", longest, {"units": "m", "long_name": "arc length from the lower anchorage"}),
            "base": [1, 2, 3, 4],
            "length": ("stay", [bay.stays[k].length for bay, k in rows], {"units": "m"}),
        },
        attrs={
            "title": f"Stance chart of {bridge.name}",
            "statics": statics,
            "mass_kg": rules.mass,
            "tension_n": list(rules.tension),
            "within_m": rules.within,
            "cell_m": rules.cell,
            "reserve": rules.reserve,
            "reasons": list(REASONS),
        },
    )
