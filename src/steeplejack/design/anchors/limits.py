"""Why no offsets hold the platform: the cable that would have to push, and the windows whose widening would help."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.anchors.exact import AnchorStatus, optimal_anchors
from steeplejack.design.anchors.problem import Reconfiguration
from steeplejack.mechanics.cable.structure import planar_vectors

Array = NDArray[np.float64]

FARTHEST = 4.0  # widening tried, in lengths of the longest cable
HALVINGS = 24


@dataclass(frozen=True, eq=False)
class BindingLimit:
    """What keeps a pose out of wrench closure for all offsets in the windows; worked out when it is first asked for.

    Attributes:
        pose: Index of the pose.
        problem: That pose alone.
    """

    pose: int
    problem: Reconfiguration = field(repr=False)

    @cached_property
    def cables(self) -> tuple[int, ...]:
        """Cables (from 0) whose component of the null vector cannot have the sign the others need.

        That is, anywhere in the windows; empty where each could, but not all at once.
        """
        return _pushing(self.problem)

    @cached_property
    def widening(self) -> Array:
        """How far one end of one window would have to move outward, all others staying, for closure to begin.

        (4, 2), lower and upper end [m]; infinite where that does not help.
        """
        far = FARTHEST * float(np.linalg.norm(self.problem.anchors - self.problem.poses[0, :2], axis=1).max())
        ends = [[_least_widening(self.problem, anchor, end, far) for end in range(2)] for anchor in range(4)]
        return np.array(ends)

    @cached_property
    def text(self) -> str:
        """One line for a person; poses, cables and anchors count from 1 in it."""
        names = ", ".join(str(cable + 1) for cable in self.cables)
        cables = "cables" if len(self.cables) > 1 else "cable"
        why = f"{cables} {names} would have to push" if names else "not all four cables can pull at once"
        if not np.isfinite(self.widening).any():
            return f"pose {self.pose + 1}: {why}; no single window helps"
        anchor, end = np.unravel_index(int(np.argmin(self.widening)), (4, 2))
        side = "upper" if end else "lower"
        return (
            f"pose {self.pose + 1}: {why}; moving the {side} end of the window of anchor {anchor + 1} "
            f"by {self.widening[anchor, end]:.3g} m helps"
        )


def binding_limits(problem: Reconfiguration) -> tuple[BindingLimit, ...]:
    """The limit that binds at every pose that is infeasible.

    Args:
        problem: Anchors, platform, windows and poses.

    Returns:
        One entry a pose without wrench closure anywhere in the windows, in their order.
    """
    status = optimal_anchors(problem, gap=0.1).status
    found = np.flatnonzero(status == AnchorStatus.INFEASIBLE)
    return tuple(BindingLimit(int(k), replace(problem, poses=problem.poses[k])) for k in found)


def _least_widening(problem: Reconfiguration, anchor: int, end: int, far: float) -> float:
    """Least outward move of one end of a window that lets closure in, by halving; infinite beyond ``far``."""

    def closes(distance: float) -> bool:
        windows = problem.windows.copy()
        windows[anchor, end] += distance if end else -distance
        answer = optimal_anchors(replace(problem, windows=windows), gap=1.0, most=2000)
        return bool(answer.tension_factor[0] > 0.0)

    if not closes(far):
        return float(np.inf)
    low, high = 0.0, far
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if closes(middle) else (middle, high)
    return high


def _pushing(problem: Reconfiguration) -> tuple[int, ...]:
    """Cables that cannot have the sign the fewest cables cannot have.

    Un-normalised component ``i`` is linear in each of the other three offsets, so over the windows its extremes lie at
    the corners.
    """
    corners = np.stack(np.meshgrid(*problem.windows, indexing="ij"), axis=-1).reshape(-1, 4)
    vectors = planar_vectors(problem.placed(corners), problem.attachments, problem.poses[0])
    arms = problem.anchors - planar_vectors(problem.anchors, problem.attachments, problem.poses[0])
    arms = arms - problem.poses[0, :2]
    moments = arms[:, 0] * vectors[..., 1] - arms[:, 1] * vectors[..., 0]
    structure = np.concatenate((np.swapaxes(vectors, -1, -2), moments[..., None, :]), axis=-2)
    others = [[j for j in range(4) if j != i] for i in range(4)]
    parts = np.stack([(-1) ** i * np.linalg.det(structure[..., other]) for i, other in enumerate(others)], axis=-1)
    blocked = (np.flatnonzero(parts.max(axis=0) <= 0.0), np.flatnonzero(parts.min(axis=0) >= 0.0))
    fewest = min(blocked, key=len)
    return tuple(int(cable) for cable in fewest)
