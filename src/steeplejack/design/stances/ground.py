"""What a stance is chosen on, as data: the stays of the bases, where on them they may stand, and what they hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import InputError
from steeplejack.robots.squad import Bay, Squad

Array = NDArray[np.float64]

NODE = 1.0
"""Distance of the nodes of a tabulated stay [m]: a 550 m stay sagging 5 m stays within 0.02 mm of its axis."""
PAIRS = ((0, 3), (1, 2))
"""Lower and upper base on each boundary stay."""


@dataclass(frozen=True, eq=False)
class Ground:
    """Stays that bases stand on and the limits of bases and cables; every array as the kernels of `worth` take it.

    Attributes:
        axes: Nodes of each base's stay (m, k, 3) [m], evenly spaced by arc length from s = 0.
        tangents: Unit tangents there (m, k, 3).
        step: Distance of the nodes (m,) [m].
        range: Least and largest place of each base's centre on its stay (m, 2) [m].
        barred: Intervals that no base's centre may stand in (m, q, 2) [m].
        pairs: Lower and upper base on one stay (p, 2).
        limits: Least and largest tension and pull held along the stay (m, 3) [N].
        machine: Offset of an exit [m], twist held [N m], length that moments are divided by [m], spacing [m] (4,).
    """

    axes: Array
    tangents: Array
    step: Array
    range: Array
    barred: Array
    pairs: NDArray[np.int64]
    limits: Array
    machine: Array

    @property
    def bases(self) -> int:
        """Number of bases."""
        return len(self.step)


def straight(
    lower: Array,
    upper: Array,
    tension: tuple[float, float],
    hold: Sequence[float] | float,
    pairs: Sequence[tuple[int, int]] = PAIRS,
    spacing: float = 0.0,
    length: float = 1.0,
) -> Ground:
    """Bases on straight stays in the plane, their winch exits on the axis.

    Args:
        lower: Where each base's stay begins (m, 2) [m]; s counts from there.
        upper: Where it ends (m, 2) [m].
        tension: Working window of every cable [N].
        hold: What each base holds along its stay, or all of them [N].
        pairs: Lower and upper base on one stay, for each pair on one.
        spacing: Least distance of such a pair [m].
        length: That moments are divided by [m]; scales the capacity margin alone.

    Raises:
        InputError: Shapes that do not fit, a stay of no length, limits that are not positive or upside down.
    """
    ends = np.stack([np.asarray(lower, float), np.asarray(upper, float)], axis=1)
    if ends.ndim != 3 or ends.shape[1:] != (2, 2) or not np.isfinite(ends).all():
        raise InputError("stays", f"ends of shape {ends.shape}", "two finite points in the plane a base, (m, 2) each")
    m = len(ends)
    span = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=-1)
    for i in np.flatnonzero(span <= 0.0):
        raise InputError(f"stay of base {i + 1}", "no length", "two different ends")
    axes = np.concatenate([ends, np.zeros((m, 2, 1))], axis=-1)
    tangents = np.repeat(((axes[:, 1] - axes[:, 0]) / span[:, None])[:, None], 2, axis=1)
    return Ground(
        axes,
        tangents,
        span,
        np.column_stack([np.zeros(m), span]),
        np.empty((m, 0, 2)),
        np.array(pairs, dtype=np.int64).reshape(-1, 2),
        _limits(m, tension, hold),
        np.array([0.0, np.inf, length, spacing]),
    )


def on_bay(
    bay: Bay,
    squad: Squad,
    tension: tuple[float, float],
    reserve: float = 0.0,
    driving: int | None = None,
    twist: bool = True,
) -> Ground:
    """The squad's bases on the boundary stays of a bay, sagging as they do.

    Args:
        bay: The bay.
        squad: The machine.
        tension: Working window of the driving cables [N].
        reserve: Taken off every tension, pull and twist limit [1].
        driving: Base under way; it holds what its drive does less its own acceleration. None: all are gripped.
        twist: Whether what a base holds about its stay counts.

    Raises:
        InputError: A window upside down or not positive.
    """
    stays = [bay.stays[k] for k in bay.carriers]
    nodes = max(int(np.ceil(max(stay.length for stay in stays) / NODE)), 1) + 1
    grids = [np.linspace(0.0, stay.length, nodes) for stay in stays]
    base, half = squad.base, 0.5 * squad.base.length
    hold = np.full(4, base.hold_force * (1.0 - reserve))
    if driving is not None:
        hold[driving] = base.drive_force * (1.0 - reserve) - base.mass * base.max_acceleration
    low, high = tension
    return Ground(
        np.stack([stay.position(grid) for stay, grid in zip(stays, grids, strict=True)]),
        np.stack([stay.tangent(grid) for stay, grid in zip(stays, grids, strict=True)]),
        np.array([grid[1] for grid in grids]),
        np.array([[half, stay.length - half] for stay in stays]),
        _barred(bay, squad),
        np.array(PAIRS),
        _limits(4, (low * (1.0 + reserve), high * (1.0 - reserve)), hold),
        np.array([base.exit_offset, base.twist_torque * (1.0 - reserve) if twist else np.inf, 1.0, base.spacing]),
    )


def _barred(bay: Bay, squad: Squad) -> Array:
    """Where a base would stand in an end zone or on an obstacle too high, for each base (4, q, 2) [m]."""
    half = 0.5 * squad.base.length
    each = [
        [
            (zone.start - half, zone.end + half)
            for zone in bay.stays[k].intervals
            if zone.kind == "end zone" or zone.height is None or zone.height > squad.base.obstacle_height
        ]
        for k in bay.carriers
    ]
    out = np.zeros((4, max(len(zones) for zones in each), 2))
    for i, zones in enumerate(each):
        out[i, : len(zones)] = np.array(zones).reshape(-1, 2)
    return out


def _limits(m: int, tension: tuple[float, float], hold: Sequence[float] | Array | float) -> Array:
    low, high = tension
    if not 0.0 <= low < high < np.inf:
        raise InputError("tension", f"{low:g} to {high:g} N", "0 N or more, the least before the largest")
    held = np.broadcast_to(np.asarray(hold, float), (m,)) if np.ndim(hold) == 0 else np.asarray(hold, float)
    if held.shape != (m,) or not (held > 0.0).all():
        raise InputError("hold", f"{held.tolist()} N", f"a positive force for each of {m} bases")
    return np.column_stack([np.full(m, low), np.full(m, high), held])
