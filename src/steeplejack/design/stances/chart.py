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
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.stances.ground import Ground, on_bay
from steeplejack.design.stances.in_space import in_space
from steeplejack.design.stances.on_chords import on_chords
from steeplejack.design.stances.rules import ChartRules
from steeplejack.design.stances.weigh import room_about
from steeplejack.errors import InputError
from steeplejack.robots.squad import Bay, Squad
from steeplejack.worksite import Bridge, Fan

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
BLOCK = 24
"""Stations for which the stays around are cut to one stretch."""


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
            parts.append(on_chords(bridge, bay, k, rules, limits, *some))
        else:
            parts.append(in_space(bridge, bay, k, squad, rules, ground, limits, *some))
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
