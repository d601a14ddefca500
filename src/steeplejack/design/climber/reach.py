"""Workspaces of the 3-RPR mechanism: at one orientation, over all of them, and the orientations at each place.

- The *translational* workspace is what O2 reaches at one orientation (Ye et al., Robotica 2024, Fig. 6).
- The *orientation* workspace adds the orientation as third coordinate (Fig. 5); its volume is in m2 rad.
- The *reachable* workspace is what O2 reaches at any orientation: the shadow of the orientation workspace.

All are in the working mode (see `limits`), and the neutral that the joint limits count from is part of the layout.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.design.climber.limits import Limits
from steeplejack.design.climber.strips import MOST_ENDS, count_cells, intervals, mark_cells, strip_area
from steeplejack.errors import InfeasibleError, InputError
from steeplejack.robots.pipe_climber import Layout

Array = NDArray[np.float64]

MOST_CELLS = 30_000_000  # in the box around the workspace: cells of 0.1 mm
ALPHA_CELLS = 360  # orientations of a volume: cells of 1 degree
TOLERANCE = 1e-12  # of areas by strips, relative to the square of the largest limb length


@dataclass(frozen=True, eq=False)
class Places:
    """How many orientations of a range each place is reached at, over a grid of square cells.

    Attributes:
        x: Centres, (m,) [m].
        w: Centres, (n,) [m].
        turn: Measure of the orientations at which the centre is reached, (n, m) [rad].
        range: Measure of all orientations asked for [rad].
        cell: Area of one cell [m2].
    """

    x: Array
    w: Array
    turn: Array
    range: float
    cell: float

    @property
    def reachable_area(self) -> float:
        """Area reached at some of the orientations [m2]."""
        return self.cell * int(np.count_nonzero(self.turn > 0.0))

    @property
    def common_area(self) -> float:
        """Area reached at all of the orientations [m2]."""
        return self.cell * int(np.count_nonzero(self.turn >= self.range * (1.0 - 1e-9)))

    @property
    def volume(self) -> float:
        """Volume of the orientation workspace [m2 rad]."""
        return self.cell * float(self.turn.sum())


def workspace_area(layout: Layout, alpha: float = 0.0) -> float:
    """Area of the translational workspace, by exact strips.

    Args:
        layout: Hinges and limits.
        alpha: Orientation of the platform [rad].

    Returns:
        [m2]; 0 where no pose is reached. What is thinner than about 0.5 mm along w may be missed.

    Raises:
        InputError: An orientation that is not finite.
    """
    return float(strip_area(_angle(alpha), Limits.of(layout).arrays, TOLERANCE))


def workspace_cells(layout: Layout, alpha: ArrayLike, step: float) -> NDArray[np.int64]:
    """Cells of a grid whose centres ``((i + 1/2) step, (j + 1/2) step)`` are reached, at each orientation.

    Args:
        layout: Hinges and limits.
        alpha: (k,) [rad].
        step: Side of a cell [m].

    Returns:
        (k,), times ``step**2`` the areas.

    Raises:
        InputError: A step that is not between a tenth of the largest limb length and what memory and patience allow.
    """
    alphas = np.atleast_1d(np.asarray(alpha, dtype=np.float64))
    for one in alphas.ravel().tolist():
        _angle(one)
    counts = np.zeros(alphas.size, dtype=np.int64)
    count_cells(np.ascontiguousarray(alphas.ravel()), checked_step(layout, step), *Limits.of(layout).arrays, counts)
    return counts


def workspace_volume(layout: Layout, step: float, span: tuple[float, float] = (-math.pi, math.pi)) -> float:
    """Volume of the orientation workspace over cells of a grid and of 1 degree.

    Args:
        layout: Hinges and limits.
        step: Side of a cell in x and w [m].
        span: Least and largest orientation [rad].

    Returns:
        [m2 rad].
    """
    alphas, width = _orientations(span)
    return float(workspace_cells(layout, alphas, step).sum()) * step * step * width


def orientations(layout: Layout, step: float, span: tuple[float, float] = (-math.pi, math.pi)) -> Places:
    """At how many of a range of orientations each place is reached: arguments of `workspace_volume`.

    Raises:
        InputError: A step or a range that cannot be used.
    """
    alphas, width = _orientations(span)
    return places_at(layout, alphas, width, step)


def places_at(layout: Layout, alphas: Array, width: float, step: float) -> Places:
    """The same at given orientations, each standing for ``width`` [rad]."""
    side = checked_step(layout, step)
    half = math.ceil((layout.reach[1] + max(layout.lengths)) / side)
    counts = np.zeros((half, 2 * half), dtype=np.int32)
    mark_cells(alphas, side, -half, 0, *Limits.of(layout).arrays, counts)
    rows, columns = (np.flatnonzero(counts.any(axis=axis)) for axis in (1, 0))
    if not rows.size:
        rows, columns = np.array([0]), np.array([half])
    x, w = slice(columns[0], columns[-1] + 1), slice(rows[0], rows[-1] + 1)
    return Places(
        side * (np.arange(-half, half, dtype=np.float64) + 0.5)[x],
        side * (np.arange(half, dtype=np.float64) + 0.5)[w],
        width * counts[w, x].astype(np.float64),
        width * alphas.size,
        side * side,
    )


def strips(layout: Layout, w: ArrayLike, alpha: float = 0.0) -> list[Array]:
    """The sets of x reached at given w and one orientation.

    Args:
        layout: Hinges and limits.
        w: (n,) [m].
        alpha: [rad].

    Returns:
        For each w its intervals, (k, 2) [m], ascending; k is 0 where nothing is reached.
    """
    limits, angle = Limits.of(layout).arrays, _angle(alpha)
    found: list[Array] = []
    for height in np.atleast_1d(np.asarray(w, dtype=np.float64)).tolist():
        ends = np.empty(MOST_ENDS)
        pieces = int(intervals(height, (angle, math.cos(angle), math.sin(angle)), limits, ends))
        found.append(ends[: 2 * pieces].reshape(-1, 2).copy())
    return found


def require_poses(layout: Layout, alpha: float) -> float:
    """Area of the translational workspace, of which there must be some.

    Args:
        layout: Hinges and limits.
        alpha: [rad].

    Returns:
        `workspace_area` [m2].

    Raises:
        InfeasibleError: No pose at that orientation; names the limit without which there would be some.
    """
    limits, angle = Limits.of(layout), _angle(alpha)
    area = float(strip_area(angle, limits.arrays, TOLERANCE))
    if area > 0.0:
        return area
    free = limits.without_hinges()
    least, largest = layout.reach
    if math.isnan(limits.bounds[3]):
        binding = "parallel platforms are singular at every pose of these dimensions: they have no working mode"
    elif strip_area(angle, free.arrays, TOLERANCE) > 0.0:
        binding = f"joint limits of {math.degrees(layout.joint_limit):g} deg counted from {layout.neutral!r}"
    elif strip_area(angle, free.either_mode().arrays, TOLERANCE) > 0.0:
        binding = "singular surface: what the lengths allow lies beyond it, in another assembly mode"
    else:
        binding = f"limb lengths of {least:g} to {largest:g} m"
    raise InfeasibleError(f"workspace at alpha = {math.degrees(angle):g} deg is empty", binding)


def checked_step(layout: Layout, step: float) -> float:
    """A side of cells that the workspace of a layout can be cut into.

    Raises:
        InputError: Too coarse to show it, or too fine to be counted; dimensions next to which limbs are so short that
            every step is one or the other.
    """
    coarse, longest = 0.1 * layout.reach[1], max(layout.lengths)
    fine = math.sqrt(2.0 / MOST_CELLS) * (layout.reach[1] + longest)
    if fine > coarse:
        largest = coarse * math.sqrt(0.5 * MOST_CELLS) - layout.reach[1]
        what = f"a length of {longest:g} m with limbs of up to {layout.reach[1]:g} m"
        raise InputError("dimensions", what, f"lengths of up to {largest:.3g} m for a grid of cells")
    if not fine <= step <= coarse:
        raise InputError("step", f"{step:g} m", f"{fine:.2g} to {coarse:.2g} m")
    return float(step)


def _angle(alpha: float) -> float:
    if not math.isfinite(alpha):
        raise InputError("alpha", f"{alpha:g} rad", "finite")
    return float(alpha)


def _orientations(span: tuple[float, float]) -> tuple[Array, float]:
    """Centres of the cells of about 1 degree that a range is cut into, and their width [rad]."""
    low, high = span
    if not (math.isfinite(low) and math.isfinite(high) and 0.0 < high - low <= 2.0 * math.pi * (1.0 + 1e-12)):
        raise InputError("orientations", f"{low:g} to {high:g} rad", "the smaller first, at most one turn apart")
    count = max(1, round((high - low) / (2.0 * math.pi) * ALPHA_CELLS))
    width = (high - low) / count
    return low + width * (np.arange(count, dtype=np.float64) + 0.5), width
