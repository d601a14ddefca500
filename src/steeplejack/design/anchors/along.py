"""Anchors along a path: the best configurations for a price of driving, and the whole trade-off between the two.

Dynamic programming over a grid of offsets finds who drives when; the grid is then refined about the places in use, and
the places themselves continuously, first stop by stop, then pose by pose. The objective is the mean over the poses
less the price of the metres driven:

    ``mean_k worth(v_k) - price sum_k sum_i |v_k,i - v_(k-1),i| s_i``

What is found is the best of a search. The mean of the pointwise optima (`steeplejack.design.anchors.optimal_anchors`)
bounds it from above.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.design.anchors.drives import drive_orders, driven
from steeplejack.design.anchors.grid import grid_axes
from steeplejack.design.anchors.problem import Reconfiguration
from steeplejack.design.anchors.refine import refine
from steeplejack.design.anchors.travel import Candidates, best_travel
from steeplejack.design.anchors.worth import GRIPPED, Duty, worth_of
from steeplejack.errors import InputError

Array = NDArray[np.float64]

FINER = 2  # times the grid is halved about the places in use
MOST_COMBINATIONS = 15_000  # of offsets looked at in a refined grid, a pose
MOST_GRID = 400_000  # of offsets on the first grid, a pose
FIRST_GRID = 15_000  # of offsets on a first grid that is chosen here
MOST_NODES = 101  # of one anchor on it
MOST_PRICE = 1e6  # [1/m] beyond which values drown in rounding


@dataclass(frozen=True, eq=False)
class AnchorPath:
    """Configurations along a path.

    Attributes:
        offsets: Of the anchors along x at every pose, (k, 4) [m].
        value: Objective at every pose, (k,) [1]; 0 where not held.
        held: Whether the platform is held, (k,).
        orders: Bases (0 to 3) in the order they drive before each pose but the first; None where every order would let
            the platform go.
        travel: Driven by all bases together, along their stays [m].
        price: The path was chosen for, in units of the mean objective [1/m].
    """

    offsets: Array
    value: Array
    held: NDArray[np.bool_]
    orders: tuple[tuple[int, ...] | None, ...]
    travel: float
    price: float

    @property
    def mean(self) -> float:
        """Mean objective, poses not held counting 0 [1]."""
        return float(np.mean(self.value))

    @property
    def net(self) -> float:
        """Mean objective less the price of what is driven [1]."""
        return self.mean - self.price * self.travel


def anchor_path(problem: Reconfiguration, offsets: Array, duty: Duty, price: float = 0.0) -> AnchorPath:
    """What given configurations are worth along a path.

    Args:
        problem: Anchors, platform and path.
        offsets: Along x, (k, 4) [m].
        duty: What is borne and what counts.
        price: Of a metre driven, in units of the mean objective [1/m].

    Returns:
        Values, what is held, drives and their orders.
    """
    value, flags = worth_of(problem, offsets, duty)
    orders = tuple(drive_orders(problem, offsets, duty))
    held = (flags & GRIPPED) > 0
    return AnchorPath(offsets, value, held, orders, float(driven(problem, offsets).sum()), price)


def anchors_along(
    problem: Reconfiguration,
    duty: Duty,
    price: float,
    step: float | None = None,
    most_step: float = np.inf,
    start: Array | None = None,
    continuous: bool = True,
) -> AnchorPath:
    """The best configurations found for a price of driving.

    Args:
        problem: Anchors, platform and path.
        duty: What is borne and what counts.
        price: Of a metre driven along a stay, in units of the mean objective [1/m].
        step: Of the first grid of offsets [m]; by default as fine as some ten thousand configurations allow.
        most_step: Farthest a base drives between two poses, along its stay [m].
        start: Offsets the bases stand at, at the first pose (4,) [m]; None if they may be set up anywhere.
        continuous: Refine the grid and the places; False keeps to the nodes of Algorithm 2.

    Returns:
        The path. Bases drive one at a time and each at most once between two poses, while the platform stands.

    Raises:
        InputError: A price or step that means nothing, or a grid too fine.
    """
    return trade_off(problem, duty, [price], step, most_step, start, continuous)[0]


def trade_off(
    problem: Reconfiguration,
    duty: Duty,
    prices: Iterable[float],
    step: float | None = None,
    most_step: float = np.inf,
    start: Array | None = None,
    continuous: bool = True,
) -> list[AnchorPath]:
    """The same for several prices: the trade-off between the mean objective and the driving.

    Args:
        problem: Anchors, platform and path.
        duty: What is borne and what counts.
        prices: Of a metre driven along a stay, in units of the mean objective [1/m].
        step: Of the first grid of offsets [m]; by default as fine as some ten thousand configurations allow.
        most_step: Farthest a base drives between two poses, along its stay [m].
        start: Offsets the bases stand at, at the first pose (4,) [m]; None if they may be set up anywhere.
        continuous: Refine the grid and the places; False keeps to the nodes of Algorithm 2.

    Returns:
        For each price the best of all paths found for any of them, so a higher price never means more driving.
    """
    asked = [float(price) for price in prices]
    for price in asked:
        if not 0.0 <= price <= MOST_PRICE:
            raise InputError("travel price", f"{price:g} per metre", f"0 to {MOST_PRICE:g}")
    if not most_step > 0.0:
        raise InputError("most step", f"{most_step:g} m", "above 0 m")
    step = first_step(problem.windows) if step is None else step
    grid = first_grid(problem, step, start, continuous)
    levels = FINER + 1 if continuous else 0
    found = [path for price in asked for path in _search(problem, duty, price, grid, step, most_step, start, levels)]
    best = []
    for price in asked:
        least = max(float(np.mean(path.value)) - price * path.travel for path in found)
        ties = [path for path in found if float(np.mean(path.value)) - price * path.travel >= least - 1e-12]
        path = min(ties, key=lambda one: one.travel)
        best.append(AnchorPath(path.offsets, path.value, path.held, path.orders, path.travel, price))
    return best


def _search(
    problem: Reconfiguration,
    duty: Duty,
    price: float,
    grid: Candidates,
    step: float,
    most_step: float,
    start: Array | None,
    levels: int,
) -> list[AnchorPath]:
    """Paths on the grid, and at each level their continuous refinement and the grid about the places in use."""
    total = price * len(problem.poses)
    offsets = best_travel(problem, grid, duty, total, most_step, start).offsets
    paths = [anchor_path(problem, offsets, duty, price)]
    for level in range(levels):
        refined = refine(problem, offsets, duty, price, step * 0.5**level, most_step, start)
        refined = refine(problem, refined, duty, price, step * 0.5**level, most_step, start, split=True)
        paths.append(anchor_path(problem, refined, duty, price))
        grid = _finer(offsets, problem.windows, step * 0.5 ** (level + 1))
        if np.prod([len(axis) for axis in grid], dtype=np.float64) > MOST_COMBINATIONS:
            break
        offsets = best_travel(problem, grid, duty, total, most_step, start).offsets
    return paths


def first_step(windows: Array) -> float:
    """Step of a first grid over windows (4, 2): some ten thousand configurations, or a hundred places of one anchor.

    Args:
        windows: Least and largest offset of each anchor along x [m].

    Returns:
        The step [m].
    """
    widths = windows[:, 1] - windows[:, 0]
    movable = max(int(np.count_nonzero(widths)), 1)
    nodes = min(int(FIRST_GRID ** (1.0 / movable)), MOST_NODES)
    return float(widths.max()) / (nodes - 1) if widths.max() > 0.0 else 1.0


def first_grid(problem: Reconfiguration, step: float, start: Array | None = None, ends: bool = True) -> Candidates:
    """The nodes of Algorithm 2, where the bases stand, and the ends of the windows where asked for.

    Args:
        problem: Anchors and their windows.
        step: Of the grid [m].
        start: Offsets the bases stand at, (4,) [m].
        ends: Whether the ends of the windows belong to it.

    Returns:
        Offsets each anchor may take, four sorted arrays [m].

    Raises:
        InputError: A start outside the windows, a step that means nothing or is too fine.
    """
    if start is not None and (np.shape(start) != (4,) or not np.isfinite(start).all()):
        raise InputError("start", f"shape {np.shape(start)}", "four finite offsets in metres")
    axes = []
    for i, (nodes, (low, high)) in enumerate(zip(grid_axes(problem, step), problem.windows, strict=True)):
        if start is not None and not low <= start[i] <= high:
            raise InputError(f"start of anchor {i + 1}", f"{start[i]:g} m", f"within {low:g} to {high:g} m")
        more = ([low, high] if ends else []) + ([] if start is None else [float(start[i])])
        axes.append(_distinct([*nodes, *more], step))
    combinations = np.prod([len(axis) for axis in axes], dtype=np.float64)
    if combinations > MOST_GRID:
        raise InputError("step", f"{step:g} m makes {combinations:.3g} configurations", f"at most {MOST_GRID}")
    return axes[0], axes[1], axes[2], axes[3]


def _finer(offsets: Array, windows: Array, step: float) -> Candidates:
    """The places in use and their neighbours at a finer step."""
    axes = [
        _distinct(np.clip(np.concatenate([used, used - step, used + step]), low, high), step)
        for used, (low, high) in zip(offsets.T, windows, strict=True)
    ]
    return axes[0], axes[1], axes[2], axes[3]


def _distinct(places: ArrayLike, step: float) -> Array:
    """Sorted places, those closer than a millionth of a step taken as one."""
    ordered = np.sort(np.asarray(places, dtype=np.float64))
    return ordered[np.append(True, np.diff(ordered) > 1e-6 * step)]
