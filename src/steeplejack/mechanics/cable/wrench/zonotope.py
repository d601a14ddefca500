"""The available wrench set of a pose: all wrenches its cables can exert within their tension limits, by its facets.

``{structure @ f : lower <= f <= upper}`` is a zonotope, the box of tensions seen through the structure matrix. Each
facet's normal is perpendicular to ``n - 1`` columns, and all of them are found by going through those subsets
(hyperplane shifting: Bouchard, Gosselin, Moore, J. Mechanisms Robotics 2(1), 2010; Gouttefarde, Krut, ARK 2010).

The set of a singular pose (`degeneracy`) is flat, and that of an empty window has no points: they have no facets in the
sense used here, and the status says so.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import characteristic, each_cable, structures_of
from steeplejack.mechanics.cable.status import WrenchSetStatus
from steeplejack.mechanics.cable.wrench import hyperplanes
from steeplejack.mechanics.cable.wrench.feasibility import lengths_of, row_lengths

Array = NDArray[np.float64]

SAME_FACET = 1e-9
"""Difference of unit normals below which two facets are one [1]."""


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
        InputError: No numbers, more than one pose, shapes that do not match, or a length that is not above 0.
    """
    matrices, leading = structures_of(structure, 2, 6)
    if leading:
        raise InputError("structure", f"leading axes {leading}", "one pose, (n, m)")
    _, n, m = matrices.shape
    weights = row_lengths(n, characteristic(length))
    low, high = _bounds("lower", lower, m), _bounds("upper", upper, m)
    room = math.comb(m, n - 1)
    normals, reaches = np.empty((2 * room, n)), np.empty(2 * room)
    count = hyperplanes.facets(matrices[0], room, low, high, normals, reaches)
    status = _status(count, low, high)
    if status != WrenchSetStatus.SOLID:
        return WrenchSet(np.empty((0, n)), np.empty(0), status)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        size = lengths_of(normals[:count] * weights)
        unit, reach = normals[:count] / size, reaches[:count] / size[:, 0]
        kept = _distinct(unit * weights) & np.isfinite(reach)
    return WrenchSet(unit[kept], reach[kept], WrenchSetStatus.SOLID)


def _bounds(where: str, values: ArrayLike, m: int) -> Array:
    """Bounds of every cable, (m,)."""
    given = each_cable(where, values, m)
    if given.ndim > 1:
        raise InputError(where, f"shape {given.shape}", f"a scalar or ({m},)")
    return np.array(np.broadcast_to(given, (m,)))


def _status(count: int, lower: Array, upper: Array) -> WrenchSetStatus:
    """What a set is like, by what `hyperplanes.facets` returned and its bounds."""
    if count == -2 or not np.all((lower < np.inf) & (upper > -np.inf)):
        return WrenchSetStatus.UNDEFINED
    if count == -1:
        return WrenchSetStatus.SINGULAR
    return WrenchSetStatus.EMPTY if np.any(lower > upper) else WrenchSetStatus.SOLID


def _distinct(normals: Array) -> NDArray[np.bool_]:
    """Marks the first of each group of equal normals."""
    same = np.abs(normals[:, None] - normals[None]).max(axis=-1) < SAME_FACET
    return ~np.tril(same, -1).any(axis=1)
