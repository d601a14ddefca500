"""What makes a stay one that can be climbed on paper: checked once, where files come in."""

from __future__ import annotations

import math
from typing import NamedTuple

from steeplejack.worksite.stay import Stay

SHORTEST, LONGEST = 0.01, 10_000.0  # [m] the longest stay in service measures 580 m; 10 km is a mistaken unit
THICKEST = 1.0  # [m] the thickest stay in service measures 0.22 m; 1 m is a mistaken unit
MOST_STRAIN = 0.05  # [1] far past the breaking strain of wire, and as far as the catenary is solved


class Fault(NamedTuple):
    """One thing wrong with a stay.

    Args:
        field: Field of :class:`Stay` (``anchorages`` for both together).
        what: What was found.
        valid: What would be valid.
    """

    field: str
    what: str
    valid: str


def first_fault(stay: Stay) -> Fault | None:
    """The first thing wrong with a stay's numbers, or ``None``."""
    return _geometry_fault(stay) or _number_fault(stay) or _load_fault(stay)


def _geometry_fault(stay: Stay) -> Fault | None:
    for field, anchorage in (("lower", stay.lower), ("upper", stay.upper)):
        if not all(math.isfinite(x) for x in anchorage):
            return Fault(field, f"stay {stay.id} has the anchorage {list(anchorage)}", "finite coordinates in metres")
    chord = math.dist(stay.lower, stay.upper)
    if chord < SHORTEST:
        return Fault("anchorages", f"stay {stay.id} has zero length", "two different anchorages")
    if chord > LONGEST:
        return Fault("anchorages", f"stay {stay.id} is {chord:.0f} m long", "under 10 km, coordinates in metres")
    if stay.upper[2] <= stay.lower[2]:
        what = f"stay {stay.id} has its tower anchorage at {stay.upper[2]:g} m, not above its deck anchorage"
        return Fault("upper", what, f"a height over {stay.lower[2]:g} m")
    return None


def _number_fault(stay: Stay) -> Fault | None:
    for field in ("diameter", "weight", "tension", "axial_stiffness"):
        value: float | None = getattr(stay, field)
        if value is not None and not 0.0 < value < math.inf:
            return Fault(field, f"stay {stay.id} has {field} {value:g}", "a number above 0, or none where unknown")
    if stay.diameter is not None and stay.diameter > THICKEST:
        return Fault("diameter", f"stay {stay.id} has diameter {stay.diameter:g} m", "under 1 m, given in metres")
    if stay.index < 0:
        return Fault("index", f"stay {stay.id} has index {stay.index}", "0, 1, 2, ... counted from the tower")
    return None


def _load_fault(stay: Stay) -> Fault | None:
    if stay.tension is None:
        return None
    load = (stay.weight or 0.0) * math.dist(stay.lower, stay.upper)
    if stay.tension < load:
        what = f"stay {stay.id} has tension {stay.tension:g} N"
        return Fault("tension", what, f"at least its own weight, {load:.0f} N")
    if stay.axial_stiffness is not None and stay.tension > MOST_STRAIN * stay.axial_stiffness:
        what = f"stay {stay.id} strains {stay.tension / stay.axial_stiffness:.0%} under its tension"
        return Fault("axial_stiffness", what, "an area that strains it under 5 %")
    return None
