"""Valid stays and schedules drawn at random: any heading, 10 to 90 deg, light and heavy tension, gaps in the data."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable

from hypothesis import strategies as st

from steeplejack.worksite import Stay
from steeplejack.worksite.schedule import OPTIONAL, REQUIRED, STEEL_MODULUS


def between(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_subnormal=False)


@st.composite
def stays(draw: st.DrawFn, complete: bool = False, index: int = 1) -> Stay:
    """A valid stay; ``complete`` ones know weight and tension."""
    length = draw(between(5.0, 600.0))
    angle = draw(st.one_of(between(0.2, math.pi / 2), st.just(math.pi / 2), st.just(math.pi / 2 - 1e-6)))
    azimuth = draw(between(-math.pi, math.pi))
    lower = (draw(between(-900.0, 900.0)), draw(between(-50.0, 50.0)), draw(between(-20.0, 100.0)))
    reach = length * math.cos(angle) if angle < math.pi / 2 else 0.0
    upper = (
        lower[0] + reach * math.cos(azimuth),
        lower[1] + reach * math.sin(azimuth),
        lower[2] + length * math.sin(angle),
    )
    weight = draw(between(50.0, 3000.0)) if complete else draw(st.none() | between(50.0, 3000.0))
    load = (weight or 100.0) * length
    tension = load * 10.0 ** draw(between(0.01, 3.0)) if complete else draw(st.none() | st.just(load * 20.0))
    strain = draw(st.none() | between(1e-4, 0.02))
    stiffness = None if strain is None or tension is None else tension / strain
    return Stay(
        id=f"stay {index}",
        tower=draw(st.sampled_from(["1", "2", "N3"])),
        plane=draw(st.sampled_from(["L", "R"])),
        side=draw(st.sampled_from(["main", "side"])),
        index=index,
        lower=lower,
        upper=upper,
        diameter=draw(st.none() | between(0.05, 0.3)),
        weight=weight,
        tension=tension,
        axial_stiffness=stiffness,
    )


@st.composite
def schedules(draw: st.DrawFn) -> list[Stay]:
    """One to six stays with different ids and places."""
    return [draw(stays(index=index)) for index in range(1, draw(st.integers(1, 6)) + 1)]


def as_csv(bridge: Iterable[Stay]) -> bytes:
    """The schedule that describes some stays, in its own units, every digit kept."""
    text = io.StringIO(newline="")
    rows = csv.writer(text)
    rows.writerow([*REQUIRED, *OPTIONAL, "remark"])
    for s in bridge:
        area = None if s.axial_stiffness is None else s.axial_stiffness / STEEL_MODULUS
        kilo = [None if x is None else x / 1e3 for x in (s.tension, s.weight)]
        rows.writerow(
            [s.id, s.tower, s.plane, s.side, s.index, *s.lower, *s.upper, s.diameter, area, *kilo, "as drawn, random"]
        )
    return text.getvalue().encode()
