"""What the bases' own ring cameras saw of the boundary stays: all round, over the stretches the bases drove."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.robots.squad.bay import Bay

Array = NDArray[np.float64]
Stretch = tuple[float, float]  # from, to [m] along a stay

MOVED = 0.01  # [m] below which a base with open palms has not set off


@dataclass(frozen=True)
class Driven:
    """What the bases' ring cameras saw of one boundary stay within the requested stretch."""

    stay: str
    asked: tuple[Stretch, ...]  # requested, less end zones and obstacles
    stretches: tuple[Stretch, ...]  # driven over

    @property
    def asked_length(self) -> float:
        """Length asked for [m]."""
        return sum(high - low for low, high in self.asked)

    @property
    def seen_length(self) -> float:
        """Length asked for and driven over [m]."""
        pairs = ((a, b) for a in self.asked for b in self.stretches)
        return sum(max(0.0, min(a[1], b[1]) - max(a[0], b[0])) for a, b in pairs)

    @property
    def missed(self) -> tuple[Stretch, ...]:
        """Stretches asked for and not driven over."""
        out: list[Stretch] = []
        for low, high in self.asked:
            for start, end in self.stretches:
                if low < min(start, high):
                    out.append((low, min(start, high)))
                low = max(low, end)
            if low < high:
                out.append((low, high))
        return tuple(out)


def observe_boundary(bay: Bay, s: Array, moving: NDArray[np.int64], low: float, high: float) -> tuple[Driven, Driven]:
    """What the bases' ring cameras saw of the boundary stays: all round, where the base drove.

    Args:
        bay: The stays.
        s: Places of the four bases (p, 4) [m].
        moving: Base under way, 1 to 4, 0 for none (p,).
        low: Where the requested stretch begins [m].
        high: Where it ends [m].
    """
    first, last = (
        Driven(
            bay.stays[k].id,
            bay.stays[k].free_intervals(low, high),
            _union([part for i in range(4) if bay.carriers[i] == k for part in _drives(s[:, i], moving == i + 1)]),
        )
        for k in (0, len(bay.stays) - 1)
    )
    return first, last


def _drives(s: Array, moving: NDArray[np.bool_]) -> list[Stretch]:
    """Stretches covered by one base, one for each spell of open palms in which it moved."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], moving, [False]]).astype(np.int8)))
    spells = (s[a:b] for a, b in zip(edges[::2], edges[1::2], strict=True))
    return [(float(spell.min()), float(spell.max())) for spell in spells if np.ptp(spell) >= MOVED]


def _union(stretches: Sequence[Stretch]) -> tuple[Stretch, ...]:
    out: list[Stretch] = []
    for low, high in sorted(stretches):
        if out and low <= out[-1][1]:
            out[-1] = (out[-1][0], max(out[-1][1], high))
        else:
            out.append((low, high))
    return tuple(out)
