"""What a stance chart asks for, and how finely it searches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from steeplejack.errors import InputError

COUNT = 7
"""Places tried for each base before the search goes on from the best."""
TOLERANCE = 0.25
"""Last step of the search along a stay [m]; margins gain under 0.01 beyond it."""


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
