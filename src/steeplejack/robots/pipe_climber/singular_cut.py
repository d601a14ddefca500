"""Where the singular surface cuts the poses of one alpha that the actuators reach.

On a row of constant w ``q1 q2 q3 det J`` is linear in x, so the surface cuts an interval of the row if the signs at its
ends differ, and passes between two rows if the signs differ at an x that both reach. No graph x(w) is asked for: where
that is steep, or the curve is a line of constant w, signs still tell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.poses import Array
from steeplejack.robots.pipe_climber.singularity import LINES, SurfaceConstants

HALVINGS = 60

Pieces = list[tuple[float, float]]


def reachable_x(layout: Layout, alpha: float, w: float) -> Pieces:
    """Intervals of x that the actuators reach at one w and alpha, in order, at most four [m]."""
    least, largest = layout.reach
    centres = layout.base - layout.platform * math.cos(alpha)
    heights = w - layout.platform * math.sin(alpha)
    if np.abs(heights).max() > largest:
        return []
    outer = np.sqrt(largest**2 - heights**2)
    pieces = [(float((centres - outer).max()), float((centres + outer).min()))]
    for centre, height in zip(centres.tolist(), heights.tolist(), strict=True):
        if abs(height) < least:
            inner = math.sqrt(least**2 - height**2)
            left, right = centre - inner, centre + inner
            pieces = [part for low, high in pieces for part in ((low, min(high, left)), (max(low, right), high))]
    return sorted({(low, high) for low, high in pieces if low <= high})


def level_line(layout: Layout, alpha: float) -> float | None:
    """Height of the line ``w = -L4 sin a`` of singular poses, for L1 = L3 or L2 = L4 ("text"); None without one."""
    c = SurfaceConstants.of(layout)
    if abs(c.a - c.k * c.l4) > LINES * (c.a + abs(c.k) * c.l4):
        return None
    w = -c.l4 * math.sin(alpha)
    return w if w > 0.0 else None


@dataclass(frozen=True)
class Cut:
    """What rows see of the surface.

    Attributes:
        found: Rows (even) and gaps between rows (odd) that the surface cuts, (2 n - 1).
        place: (x, w) of one singular pose within reach [m]; None if no row or gap is cut.
    """

    found: NDArray[np.bool_]
    place: tuple[float, float] | None

    @property
    def stretches(self) -> int:
        """Runs of neighbouring rows and gaps that are cut."""
        return int(np.count_nonzero(np.diff(self.found.astype(np.int8), prepend=0) == 1))


def cut(layout: Layout, alpha: float, heights: Array) -> Cut:
    """Rows, and gaps between neighbouring rows, in which the surface lies within reach.

    Args:
        layout: Hinges and reach.
        alpha: [rad].
        heights: w of the rows, rising, (n) [m].
    """
    found = np.zeros(max(2 * len(heights) - 1, 0), dtype=np.bool_)
    levels = heights.tolist()
    rows = [reachable_x(layout, alpha, w) for w in levels]
    places: list[tuple[float, float]] = []
    for k, (w, pieces) in enumerate(zip(levels, rows, strict=True)):
        if (x := _cut_row(layout, alpha, w, pieces)) is not None:
            found[2 * k] = True
            places.append((x, w))
        if k and (place := _cut_gap(layout, alpha, (levels[k - 1], w), (rows[k - 1], pieces))) is not None:
            found[2 * k - 1] = True
            places.append(place)
    found[1:-1:2] |= found[:-2:2] & found[2::2]
    line = level_line(layout, alpha)
    if line is not None and len(levels) and levels[0] <= line <= levels[-1]:
        for low, _ in reachable_x(layout, alpha, line)[:1]:
            found[max(2 * int(np.searchsorted(heights, line)) - 1, 0)] = True
            places.append((low, line))
    return Cut(found, places[0] if places else None)


def _value(layout: Layout, alpha: float, w: float) -> tuple[float, float]:
    """Slope in x and value at x = 0 of ``-q1 q2 q3 det J`` on a row."""
    c = SurfaceConstants.of(layout)
    cosine, sine = math.cos(alpha), math.sin(alpha)
    arm = c.k * w + c.a * sine
    return sine * arm, w * cosine * arm + c.b * sine * (w + c.l4 * sine)


def _cut_row(layout: Layout, alpha: float, w: float, pieces: Pieces) -> float | None:
    """An x within reach at which a row is singular."""
    slope, level = _value(layout, alpha, w)
    for low, high in pieces:
        if (slope * low + level) * (slope * high + level) <= 0.0:
            return min(max(-level / slope, low), high) if slope != 0.0 else low
    return None


def _cut_gap(
    layout: Layout, alpha: float, levels: tuple[float, float], rows: tuple[Pieces, Pieces]
) -> tuple[float, float] | None:
    """A singular pose (x, w) within reach between two rows, at an x that both reach."""
    (lower, upper), (slope, level), (slope_up, level_up) = levels, *(_value(layout, alpha, w) for w in levels)
    for low, high in rows[0]:
        for low_up, high_up in rows[1]:
            for x in (max(low, low_up), min(high, high_up)):
                inside = max(low, low_up) <= x <= min(high, high_up)
                if inside and (slope * x + level) * (slope_up * x + level_up) < 0.0:
                    w = _between(layout, alpha, x, lower, upper)
                    if any(left <= x <= right for left, right in reachable_x(layout, alpha, w)):
                        return x, w
    return None


def _between(layout: Layout, alpha: float, x: float, low: float, high: float) -> float:
    """Height w of the surface at one x, between two w of unlike signs."""

    def positive(w: float) -> bool:
        slope, level = _value(layout, alpha, w)
        return slope * x + level > 0.0

    at_high = positive(high)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if positive(middle) == at_high:
            high = middle
        else:
            low = middle
    return high
