"""From a worksite file to the worksite: stays read or written out, gaps filled, end zones and obstacles laid on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from steeplejack.errors import InputError
from steeplejack.files import read_source
from steeplejack.worksite.bridge import GRAVITY, Bridge
from steeplejack.worksite.planar import PlanarSite
from steeplejack.worksite.schedule import END_ZONE, END_ZONE_NOTE, STEEL_MODULUS, read_rows, stays_of
from steeplejack.worksite.site_file import Assumed, BridgeFile, Obstacle, PlanarFile, StayEntry, decode_site
from steeplejack.worksite.stay import Interval, Stay, with_end_zones
from steeplejack.worksite.validity import first_fault

KEY_OF = {"weight": "mass_per_metre", "axial_stiffness": "area", "anchorages": "lower and upper"}


def read_site(file: Path, folder: Path) -> Bridge | PlanarSite:
    """Read a worksite file.

    Args:
        file: The TOML file.
        folder: Where the schedule it names is found.

    Returns:
        The worksite, SI.

    Raises:
        InputError: A file or field that cannot be used; the message names it.
    """
    where = str(file)
    site = decode_site(read_source(file, "a .toml worksite"), where)
    return _planar(site, where) if isinstance(site, PlanarFile) else _bridge(site, where, folder)


def _planar(site: PlanarFile, where: str) -> PlanarSite:
    numbers = [x for anchor in site.anchors for x in anchor] + [x for s in site.stays for x in (s.slope, s.intercept)]
    if not all(math.isfinite(x) for x in numbers):
        raise InputError(where, "an anchor or stay that is not finite", "finite numbers in metres")
    if len({s.id for s in site.stays}) < len(site.stays):
        raise InputError(f"{where}, stays", "an id stands twice", "each id once")
    lines = {stay.id: (stay.slope, stay.intercept) for stay in site.stays}
    notes = (*site.notes, *(f"stay {stay.id}: {stay.source}" for stay in site.stays))
    return PlanarSite(site.name, np.array(site.anchors), lines, site.source, notes)


def _bridge(site: BridgeFile, where: str, folder: Path) -> Bridge:
    stays = _written(site.stays, where) if site.schedule is None else _scheduled(folder.joinpath(site.schedule))
    notes = list(site.notes)
    if site.assumed is not None:
        stays = _filled(stays, site.assumed, where)
        notes += [f"{name}: {text}" for name, text in site.assumed.source.items()]
    zones = site.end_zones
    lower, upper, note = (zones.lower, zones.upper, zones.source) if zones else (END_ZONE, END_ZONE, END_ZONE_NOTE)
    stays = [with_end_zones(stay, lower, upper, note) for stay in stays]
    stays = _obstructed(stays, site.obstacles, where)
    return Bridge(site.name, tuple(stays), site.source, (*notes, f"end zones: {note}"))


def _scheduled(file: Path) -> list[Stay]:
    return stays_of(read_rows(read_source(file, "a .csv stay schedule"), str(file)))


def _written(entries: Sequence[StayEntry], where: str) -> list[Stay]:
    stays = [_stay(entry) for entry in entries]
    for name in ("id", "place"):
        seen: set[object] = set()
        for number, stay in enumerate(stays):
            key = stay.id if name == "id" else (stay.fan, stay.index)
            if key in seen:
                raise InputError(f"{where}, stays[{number}]", f"stay {stay.id} repeats the {name}", f"each {name} once")
            seen.add(key)
    for number, stay in enumerate(stays):
        if fault := first_fault(stay):
            raise InputError(
                f"{where}, stays[{number}].{KEY_OF.get(fault.field, fault.field)}", fault.what, fault.valid
            )
    return stays


def _stay(entry: StayEntry) -> Stay:
    return Stay(
        id=entry.id,
        tower=entry.tower,
        plane=entry.plane,
        side=entry.side,
        index=entry.index,
        lower=entry.lower,
        upper=entry.upper,
        diameter=entry.diameter,
        weight=None if entry.mass_per_metre is None else -entry.mass_per_metre * GRAVITY[2],
        tension=entry.tension,
        axial_stiffness=None if entry.area is None else STEEL_MODULUS * entry.area,
    )


def _filled(stays: Sequence[Stay], assumed: Assumed, where: str) -> list[Stay]:
    """Stays with the assumed values where they had none; a diameter range grows linearly with the chord."""
    chords = [math.dist(stay.lower, stay.upper) for stay in stays]
    shortest, longest = min(chords), max(chords)
    filled: list[Stay] = []
    for stay, chord in zip(stays, chords, strict=True):
        fraction = (chord - shortest) / (longest - shortest) if longest > shortest else 0.0
        full = _fill(stay, assumed, fraction)
        if fault := first_fault(full):
            raise InputError(f"{where}, assumed.{KEY_OF.get(fault.field, fault.field)}", fault.what, fault.valid)
        filled.append(full)
    return filled


def _fill(stay: Stay, assumed: Assumed, fraction: float) -> Stay:
    diameter, weight, tension = stay.diameter, stay.weight, stay.tension
    if diameter is None:
        thin, thick = assumed.diameter_range or (assumed.diameter, assumed.diameter)
        diameter = None if thin is None or thick is None else thin + fraction * (thick - thin)
    if weight is None and assumed.mass_per_metre is not None:
        weight = -assumed.mass_per_metre * GRAVITY[2]
    if tension is None:
        tension = assumed.tension
        if assumed.tension_per_mass is not None and weight is not None:
            tension = -assumed.tension_per_mass * weight / GRAVITY[2]
    return replace(stay, diameter=diameter, weight=weight, tension=tension)


def _obstructed(stays: Sequence[Stay], obstacles: Sequence[Obstacle], where: str) -> list[Stay]:
    by_id = {stay.id: stay for stay in stays}
    for number, obstacle in enumerate(obstacles):
        place = f"{where}, obstacles[{number}]"
        stay = by_id.get(obstacle.stay)
        if stay is None:
            raise InputError(f"{place}.stay", f"no stay {obstacle.stay!r}", f"a stay id such as {stays[0].id}")
        if not obstacle.start < obstacle.end <= stay.length:
            what = f"from {obstacle.start:g} to {obstacle.end:g} m"
            raise InputError(place, what, f"start before end, both within the stay's {stay.length:.3f} m")
        interval = Interval(obstacle.start, obstacle.end, "obstacle", obstacle.height, obstacle.note)
        by_id[stay.id] = replace(stay, intervals=(*stay.intervals, interval))
    return list(by_id.values())
