"""Compiled margins of a planar four-cable robot over a grid; the kernel behind `region.grid.margin_grid`.

Structure matrices are written node by node, and each is decided and measured as `distribute` does it (`depth`), so map
and pose agree. What counts as margin 1 is half the widest window before pull limits narrow any: one number for all
nodes.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from steeplejack.mechanics.cable.status import NO
from steeplejack.mechanics.cable.tension.depth import settle, share_of_window

Array = NDArray[np.float64]


@njit(cache=True, error_model="numpy", parallel=True)
def planar_margins(
    roots: Array, arms: Array, xs: Array, ys: Array, wrench: Array, lower: Array, upper: Array,
    stays: Array, pull_limit: Array, margins: Array,
) -> None:  # fmt: skip
    """Margin of every node of a planar grid at one orientation; singular nodes and cables of no length get -inf.

    Args:
        roots: ``A_i - b_i``, (4, 2) [m].
        arms: ``b_i``, (4, 2) [m].
        xs: (nx,) [m].
        ys: (ny,) [m].
        wrench: ``(fx, fy, mz)`` on the platform, (3,) [N, N, N m].
        lower: (4,) [N].
        upper: (4,) [N].
        stays: Unit directions the anchors would slip along, (4, 2) [1].
        pull_limit: Greatest component of a cable's tension along its stay, (4,) [N]; infinite for none.
        margins: Written, (ny, nx) [1]; not negative exactly where feasible.
    """
    for j in prange(ys.size):
        structure, limit, proof, bounds = np.empty((3, 4)), np.empty(4), np.empty(4), np.empty((4, 4))
        left, tau, scale, order = np.empty((3, 4)), np.empty(3), np.empty(3), np.empty(3, np.int64)
        start, basis, work, nothing = np.empty(4), np.empty((4, 1)), np.empty((4, 1)), np.empty(3)
        chosen, active, place, space = np.empty(1, np.int64), np.empty(2, np.int64), np.empty(2), np.empty(64)
        for i in range(xs.size):
            for k in range(4):
                dx, dy = roots[k, 0] - xs[i], roots[k, 1] - ys[j]
                length = math.sqrt(dx * dx + dy * dy)
                share = 1.0 / length if length > 0.0 else 0.0
                structure[0, k], structure[1, k] = dx * share, dy * share
                structure[2, k] = (arms[k, 0] * dy - arms[k, 1] * dx) * share
                along = abs(structure[0, k] * stays[k, 0] + structure[1, k] * stays[k, 1])
                limit[k] = min(upper[k], pull_limit[k] / along) if along > 0.0 else upper[k]
            status, depth = settle(
                structure, wrench, lower, limit, 0.0, left, tau, scale, order, start, basis, bounds[0], bounds[1],
                bounds[2], bounds[3], chosen, work, space, active, place, proof, nothing,
            )  # fmt: skip
            margins[j, i] = share_of_window(status, depth, start, lower, upper) if status <= NO else -np.inf
