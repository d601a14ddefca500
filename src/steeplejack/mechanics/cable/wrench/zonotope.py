"""The available wrench set of a pose: all wrenches its cables can exert within their tension limits, by its facets.

``{structure @ f : lower <= f <= upper}`` is a zonotope, the box of tensions seen through the structure matrix. Each
facet's normal is perpendicular to ``n - 1`` columns, and all of them are found by going through those subsets
(hyperplane shifting: Bouchard, Gosselin, Moore, J. Mechanisms Robotics 2(1), 2010; Gouttefarde, Krut, ARK 2010).

The set of a singular pose is flat: it has no facets in the sense used here, and its status says so.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.wrench import hyperplanes
from steeplejack.mechanics.cable.wrench.closure import stacked
from steeplejack.mechanics.cable.wrench.feasibility import row_lengths

Array = NDArray[np.float64]

SAME_FACET = 1e-9
"""Difference of unit normals below which two facets are one [1]."""


class WrenchSetStatus(IntEnum):
    """What an available wrench set is like; `advice` says what to do."""

    SOLID = 0
    FLAT = 1
    UNDEFINED = 2

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _ADVICE[self]


_ADVICE = {
    WrenchSetStatus.SOLID: "the set has an inside; its facets bound it",
    WrenchSetStatus.FLAT: "the pose is singular, so the set has no inside; move off it",
    WrenchSetStatus.UNDEFINED: "an entry is not finite or a cable has no length; check pose, anchors and bounds",
}


@dataclass(frozen=True)
class WrenchSet:
    """Available wrenches ``{w : normals @ w <= reaches}``.

    Attributes:
        normals: Outward, of unit length once moments are divided by the characteristic length, (k, n).
        reaches: (k,) [N].
        status: Whether the set is solid; without facets where it is not, or where it is the whole space.
    """

    normals: Array
    reaches: Array
    status: WrenchSetStatus


def available_wrench_set(structure: ArrayLike, lower: ArrayLike, upper: ArrayLike, length: float = 1.0) -> WrenchSet:
    """Facets of the available wrench set of one pose.

    Args:
        structure: (n, m) with n from 2 to 6; (fx, fy, mz) or (moment; force) rows.
        lower: Least tensions, (m,) or a scalar [N]; may be -inf.
        upper: Greatest tensions, (m,) or a scalar [N]; may be inf, and directions without a limit have no facet.
        length: Characteristic length that turns moments into forces, above 0 [m].

    Returns:
        Facets, each once.

    Raises:
        InputError: More than one pose, bounds out of order, or a length that is not above 0.
    """
    matrices, leading = stacked(structure)
    if leading:
        raise InputError("structure", f"leading axes {leading}", "one pose, (n, m)")
    if not 0.0 < length < math.inf:
        raise InputError("characteristic length", f"{length} m", "a finite length above 0")
    _, n, m = matrices.shape
    low, high = (np.array(np.broadcast_to(np.asarray(b, dtype=np.float64), (m,))) for b in (lower, upper))
    if not np.all((low <= high) & (low < np.inf) & (high > -np.inf)):
        raise InputError("tension bounds", "a lower bound is not below its upper one", "lower <= upper, both numbers")
    room = math.comb(m, n - 1)
    normals, reaches = np.empty((2 * room, n)), np.empty(2 * room)
    count = hyperplanes.facets(matrices[0], room, low, high, normals, reaches)
    if count < 0:
        status = WrenchSetStatus.FLAT if count == -1 else WrenchSetStatus.UNDEFINED
        return WrenchSet(np.empty((0, n)), np.empty(0), status)
    size = np.linalg.norm(normals[:count] * row_lengths(n, length), axis=-1)
    unit, reach = normals[:count] / size[:, None], reaches[:count] / size
    kept = _distinct(unit * row_lengths(n, length)) & np.isfinite(reach)
    return WrenchSet(unit[kept], reach[kept], WrenchSetStatus.SOLID)


def _distinct(normals: Array) -> NDArray[np.bool_]:
    """Marks the first of each group of equal normals."""
    same = np.abs(normals[:, None] - normals[None]).max(axis=-1) < SAME_FACET
    return ~np.tril(same, -1).any(axis=1)
