"""What wrenches a platform must hold: one, a box of them, or a polytope."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import leading, vectors

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
        """One wrench, (..., n).

        Raises:
            InputError: No vector of numbers.
        """
        load = vectors("task wrench", wrench, "n")
        return cls(load[..., None, :], np.zeros_like(load))

    @classmethod
    def box(cls, low: ArrayLike, high: ArrayLike) -> TaskWrenches:
        """All wrenches with ``low <= w <= high``, (..., n) each.

        Raises:
            InputError: No vectors of numbers of one size, or a lower end above its upper one.
        """
        least = vectors("task box, low", low, "n")
        most = vectors("task box, high", high, least.shape[-1])
        leading(("task box, low", least.shape, 1), ("task box, high", most.shape, 1))
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
        corners = vectors("task polytope", vertices, "p", "n")
        return cls(corners, np.zeros_like(corners[..., 0, :]))

    def shifted(self, wrench: ArrayLike) -> TaskWrenches:
        """The same wrenches on top of another, (..., n): gravity, or the inertia of a motion.

        Raises:
            InputError: Another number of rows, or leading axes that do not fit.
        """
        by = vectors("wrench", wrench, self.vertices.shape[-1])
        leading(("task", self.vertices.shape, 2), ("wrench", by.shape, 1))
        return TaskWrenches(self.vertices + by[..., None, :], self.half)
