"""Rectangles of the plane X-W, cut into cells: the prescribed workspaces over which designs are compared."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import InputError

Array = NDArray[np.float64]

MOST_CELLS = 20_000_000
SHORTEST, FARTHEST = 1e-6, 1e6
"""Least side and largest coordinate of a rectangle [m]."""


@dataclass(frozen=True)
class Rectangle:
    """A prescribed workspace of O2, above the base.

    Attributes:
        x0: Least x [m].
        x1: Largest x [m].
        w0: Least w [m], not negative.
        w1: Largest w [m].
    """

    x0: float
    x1: float
    w0: float
    w1: float

    def __post_init__(self) -> None:
        """Refuse what is no rectangle above the base."""
        given = " ".join(f"{value:g}" for value in (self.x0, self.x1, self.w0, self.w1))
        if not all(map(math.isfinite, (self.x0, self.x1, self.w0, self.w1))):
            raise InputError("rectangle", given, "X0 X1 W0 W1 in metres, all finite")
        if not (self.x0 < self.x1 and 0.0 <= self.w0 < self.w1):
            raise InputError("rectangle", given, "X0 X1 W0 W1 in metres with X0 < X1 and 0 <= W0 < W1")
        sides, far = (self.x1 - self.x0, self.w1 - self.w0), max(-self.x0, self.x1, self.w1)
        if min(sides) < SHORTEST or far > FARTHEST:
            raise InputError(
                "rectangle", given, f"sides of {SHORTEST:g} m and more, coordinates of up to {FARTHEST:g} m"
            )

    def cells(self, step: float) -> tuple[Array, Array]:
        """Centres of the cells that tile the rectangle, along x (m,) and w (n,) [m].

        Args:
            step: Side of a cell [m]. Where it does not divide a side, cells are the nearest size that does.

        Raises:
            InputError: Not positive, longer than a side, or so fine that there are too many cells.
        """
        wide, high = self.x1 - self.x0, self.w1 - self.w0
        fine = math.sqrt(wide * high / MOST_CELLS)
        if not fine <= step <= min(wide, high):
            raise InputError("step", f"{step:g} m", f"{fine:.2g} to {min(wide, high):.2g} m for this rectangle")
        columns, rows = round(wide / step), round(high / step)
        x = self.x0 + wide * (np.arange(columns) + 0.5) / columns
        return x, self.w0 + high * (np.arange(rows) + 0.5) / rows
