"""The straight line between two anchorages: a stay of unknown weight or tension, a vertical one, or one asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Point = tuple[float, float, float]
Array = NDArray[np.float64]

VERTICAL = 1e-9  # [1] cosine of the inclination below which a stay counts as vertical


def heading(lower: Point, upper: Point) -> Array:
    """Horizontal unit vector from the lower towards the upper anchorage; +x where the stay is vertical.

    Args:
        lower: Lower anchorage [m], world frame, z up.
        upper: Upper anchorage [m], world frame.

    Returns:
        Unit vector (3,) [1], read-only.
    """
    across = np.subtract(upper, lower)
    across[2] = 0.0
    span = float(np.linalg.norm(across))
    vertical = span < VERTICAL * abs(upper[2] - lower[2])
    unit = np.array([1.0, 0.0, 0.0]) if vertical else across / span
    unit.setflags(write=False)
    return unit


@dataclass(frozen=True)
class Chord:
    """Straight line from the lower to the upper anchorage, by arc length from the lower one.

    Args:
        lower: Lower anchorage [m], world frame, z up.
        upper: Upper anchorage [m], world frame.
    """

    lower: Point
    upper: Point

    @cached_property
    def length(self) -> float:
        """Distance between the anchorages [m]."""
        return float(np.linalg.norm(np.subtract(self.upper, self.lower)))

    @property
    def sag(self) -> float:
        """Largest distance from the chord [m]: none."""
        return 0.0

    @cached_property
    def direction(self) -> Array:
        """Unit vector (3,) [1] from the lower to the upper anchorage."""
        return np.subtract(self.upper, self.lower) / self.length

    @cached_property
    def heading(self) -> Array:
        """Horizontal unit vector (3,) [1] from the lower to the upper anchorage; +x where vertical."""
        return heading(self.lower, self.upper)

    def position(self, s: ArrayLike) -> Array:
        """Points of the line.

        Args:
            s: Arc length (...) [m] from the lower anchorage.

        Returns:
            Points (..., 3) [m], world frame.
        """
        return np.asarray(self.lower) + np.asarray(s, dtype=float)[..., None] * self.direction

    def tangent(self, s: ArrayLike) -> Array:
        """Unit tangents (..., 3) [1] from lower to upper at arc length ``s`` (...) [m]."""
        return np.broadcast_to(self.direction, (*np.shape(s), 3)).copy()

    def nearest(self, p: ArrayLike) -> tuple[Array, Array]:
        """Nearest points between the anchorages.

        Args:
            p: Points (..., 3) [m], world frame.

        Returns:
            Arc length (...) [m] and distance (...) [m].
        """
        offset = np.asarray(p, dtype=float) - self.lower
        s = np.clip(offset @ self.direction, 0.0, self.length)
        return s, np.linalg.norm(offset - s[..., None] * self.direction, axis=-1)
