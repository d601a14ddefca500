"""What wrenches a platform must hold: one, a box of them, or a polytope."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TaskWrenches:
    """External wrenches on the platform: a box around each vertex, and everything between (their convex hull).

    Rows as in the structure matrix: (fx, fy, mz) or (moment; force).

    Attributes:
        vertices: (..., p, n) [N, N m].
        half: Half-widths of the box, (..., n) [N, N m].
    """

    vertices: Array
    half: Array

    @classmethod
    def point(cls, wrench: ArrayLike) -> TaskWrenches:
        """One wrench, (..., n)."""
        load = np.asarray(wrench, dtype=np.float64)
        return cls(load[..., None, :], np.zeros_like(load))

    @classmethod
    def box(cls, low: ArrayLike, high: ArrayLike) -> TaskWrenches:
        """All wrenches with ``low <= w <= high``, (..., n) each.

        Raises:
            InputError: A lower end above its upper one.
        """
        least, most = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
        if np.any(least > most):
            raise InputError("task box", "a lower end is above its upper one", "low <= high for every row")
        middle = 0.5 * (least + most)
        return cls(middle[..., None, :], np.broadcast_to(0.5 * (most - least), middle.shape))

    @classmethod
    def polytope(cls, vertices: ArrayLike) -> TaskWrenches:
        """The convex hull of vertices, (..., p, n).

        Raises:
            InputError: No vertex.
        """
        corners = np.asarray(vertices, dtype=np.float64)
        if corners.ndim < 2 or corners.shape[-2] == 0:
            raise InputError("task polytope", f"shape {corners.shape}", "(..., p, n) with at least one vertex")
        return cls(corners, np.zeros_like(corners[..., 0, :]))

    def shifted(self, wrench: ArrayLike) -> TaskWrenches:
        """The same wrenches on top of another, (..., n): gravity, or the inertia of a motion."""
        return TaskWrenches(self.vertices + np.asarray(wrench, dtype=np.float64)[..., None, :], self.half)
