"""Candidate moves of the oracle's search: one gripper open, along the main pipe and about it at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from oracle_bodies import Array


@dataclass
class Moves:
    """Candidate moves as columns: states they begin at, where they end, and whether the upper gripper moves."""

    start: Array  # (n, 4) s_lower, s_upper, clock_lower, clock_upper
    end: Array  # (n, 4)
    upper: Array  # (n,)

    def only(self, keep: Array) -> Moves:
        """Some of the moves."""
        return Moves(self.start[keep], self.end[keep], self.upper[keep])

    @property
    def turns(self) -> Array:
        """Whether they turn."""
        return (self.end[:, 2:] != self.start[:, 2:]).any(axis=1)

    def moving(self) -> tuple[Array, Array]:
        """Place and clock of the gripper that moves, at the start and at the end, (n, 2) each."""
        column, every = self.upper.astype(int), np.arange(len(self.upper))
        places, clocks = (
            np.stack((self.start[every, column + at], self.end[every, column + at]), axis=-1) for at in (0, 2)
        )
        return places, clocks

    def ways(self, spacing: float) -> tuple[Array, Array, Array]:
        """Which move, places of both grippers (m, 2) along it, and where each begins."""
        span = np.abs(self.end[:, :2] - self.start[:, :2]).max(axis=1)
        counts = np.maximum(2, np.ceil(span / spacing).astype(int) + 1)
        which = np.repeat(np.arange(len(counts)), counts)
        first = np.concatenate(([0], np.cumsum(counts)[:-1]))
        share = (np.arange(len(which)) - first[which]) / (counts[which] - 1.0)
        return which, (self.start[which] + share[:, None] * (self.end - self.start)[which])[:, :2], first
