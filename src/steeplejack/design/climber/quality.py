"""Transmission over a workspace: the map of the local index, and the global one (Ye et al., Robotica 2024, Eq. 34)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.climber.limits import Limits, holds_grid
from steeplejack.design.climber.reach import checked_step, places_at, require_poses
from steeplejack.design.climber.region import Rectangle
from steeplejack.design.climber.transmission import Moving, transmission_grid
from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber import Layout

Array = NDArray[np.float64]

GOOD = 0.5
"""Local transmission index from which a pose counts as one of high quality (section 5.2)."""


@dataclass(frozen=True, eq=False)
class TransmissionMap:
    """The local transmission index over cells at one orientation.

    Attributes:
        x: Centres, (m,) [m].
        w: Centres, (n,) [m].
        alpha: [rad].
        values: (n, m) [1]; NaN outside the region.
        within: Whether the mechanism can take the pose at a cell's centre, (n, m).
    """

    x: Array
    w: Array
    alpha: float
    values: Array
    within: NDArray[np.bool_]

    @property
    def cells(self) -> int:
        """Cells of the region."""
        return int(np.isfinite(self.values).sum())

    @property
    def gti(self) -> float:
        """Global transmission index: share of the region where the local index is at least 0.5 [1]."""
        return float(np.count_nonzero(self.values >= GOOD)) / self.cells

    @property
    def mean(self) -> float:
        """Mean of the local index over the region [1]."""
        return float(np.nanmean(self.values))

    @property
    def least(self) -> tuple[float, float, float]:
        """Least value and its place (x, w) [1, m, m]."""
        return self._at(int(np.nanargmin(self.values)))

    @property
    def largest(self) -> tuple[float, float, float]:
        """Largest value and its place (x, w) [1, m, m]."""
        return self._at(int(np.nanargmax(self.values)))

    @property
    def within_limits(self) -> float:
        """Share of the region that the mechanism can take [1]."""
        return float(np.count_nonzero(self.within & np.isfinite(self.values))) / self.cells

    def _at(self, flat: int) -> tuple[float, float, float]:
        row, column = divmod(flat, self.x.size)
        return float(self.values[row, column]), float(self.x[column]), float(self.w[row])


def transmission_map(
    layout: Layout,
    step: float,
    alpha: float = 0.0,
    rectangle: Rectangle | None = None,
    moving: Moving = "platform",
) -> TransmissionMap:
    """Local transmission index over the workspace, or over a prescribed rectangle whether or not limits allow it.

    Args:
        layout: Hinges and limits.
        step: Side of a cell [m].
        alpha: Orientation of the platform [rad].
        rectangle: The prescribed workspace; without one the translational workspace at that orientation.
        moving: Which body's joints are the characteristic points.

    Returns:
        The map, over at least one cell.

    Raises:
        InfeasibleError: An empty workspace; names the limit that empties it.
        InputError: A step too coarse to hit the workspace, or too fine.
    """
    if not np.isfinite(alpha):
        raise InputError("alpha", f"{alpha:g} rad", "finite")
    if rectangle is None:
        return _over_workspace(layout, step, alpha, moving)
    x, w = rectangle.cells(step)
    values = transmission_grid(layout, x, w, alpha, moving)
    return TransmissionMap(x, w, alpha, values, reached(layout, x, w, alpha))


def _over_workspace(layout: Layout, step: float, alpha: float, moving: Moving) -> TransmissionMap:
    area = require_poses(layout, alpha)  # first, because the limit that empties it says more than a step does
    side = checked_step(layout, step)
    places = places_at(layout, np.array([float(alpha)]), 1.0, side)
    within = places.turn > 0.0
    if not within.any():
        raise InputError("step", f"{step:g} m", f"finer: no centre of a cell lies in the {area:.3g} m2 reached")
    values = transmission_grid(layout, places.x, places.w, alpha, moving)
    return TransmissionMap(places.x, places.w, alpha, np.where(within, values, np.nan), within)


def reached(layout: Layout, x: Array, w: Array, alpha: float) -> NDArray[np.bool_]:
    """Whether the mechanism can take the poses of a grid, (n, m): arguments of `transmission_grid`."""
    inside = np.empty((w.size, x.size), dtype=np.bool_)
    holds_grid(x, w, float(alpha), Limits.of(layout).arrays, inside)
    return inside
