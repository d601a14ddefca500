"""A planar worksite: four anchors on straight stays in one vertical plane, as in the paper's numerical example."""

from __future__ import annotations

from dataclasses import dataclass

from steeplejack.worksite.chord import Array

GRAVITY = (0.0, -9.81)  # [m/s2] the value squad.md computes its references with


@dataclass(frozen=True, eq=False)
class PlanarSite:
    """Anchors and stays in a plane, x along the bridge and y up, origin at anchor 1.

    Args:
        name: Its name.
        anchors: Where driving cables 1..4 leave their anchor bases (4, 2) [m], read-only.
        stays: Lines y = slope x + intercept by stay id: slope [1], intercept [m].
        source: Where the numbers come from.
        notes: What was corrected or is missing.
        gravity: Gravitational acceleration (2,) [m/s2].
    """

    name: str
    anchors: Array
    stays: dict[str, tuple[float, float]]
    source: str
    notes: tuple[str, ...] = ()
    gravity: tuple[float, float] = GRAVITY

    def __post_init__(self) -> None:
        """Keep a read-only copy of the anchors."""
        anchors = self.anchors.copy()
        anchors.setflags(write=False)
        object.__setattr__(self, "anchors", anchors)
