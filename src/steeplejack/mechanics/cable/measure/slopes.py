"""Slopes of tension factor and margins in the entries of the structure matrix and in the wrench.

All three measures are optima, and by the envelope theorem the slope of an optimum is that of its Lagrangian with the
optimiser held: a direction ``z`` of wrenches times tensions ``f``. What differs is which facet is active.

- *Tension factor*, any number of cables: the largest t with ``structure f = 0`` and ``t <= f <= 1``. Active is the
  hyperplane ``z`` through n - 1 columns with the least ``Q / P`` (P the larger, Q the smaller of the sums of positive
  and of negative parts of ``structure^T z``, see `hyperplanes`); cables on its larger side pull t, those on the other
  side 1, and those in it what balances: ``dTF = -z^T d(structure) f / P``.
- *Capacity margin*, any number of cables: distance from the wrench to the nearest facet of the available wrench set,
  moments divided by a characteristic length that is held fixed. With ``z`` the facet's normal, of unit length in that
  metric, and ``f`` the tensions at the foot of the perpendicular, ``d = z^T d(structure) f + z^T d(wrench)``. The
  margin is that of Guay, Cardou, Cruz-Ruiz and Caro, "Measuring how well a structure supports varying external
  wrenches", New Advances in Mechanisms, Springer 2014.
- *Depth in the tension box*, one cable too many: `distribute`'s margin, set by two bounds on the line of tensions. With
  their weights ``v`` and ``structure^T z = -v``, ``d = z^T d(structure) f + z^T d(wrench)``, over half the widest
  window.

Smooth is a pose whose active facet is the only one and is spanned by exactly n - 1 columns (for the depth: whose two
bounds are the only ones). Where two tie to within `TIE` the measure has a kink, and the slope returned is that of one
of the pieces that meet. Outside wrench closure the tension factor is 0 and so is its slope. Where the matrix is
singular or an entry is not a number, margins are -inf, the tension factor is 0, slopes are not a number and nothing is
smooth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.measure.active_facet import TIE, active_factor_each, active_margin_each
from steeplejack.mechanics.cable.tension.nullspace import null_space
from steeplejack.mechanics.cable.wrench.feasibility import row_lengths

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Slope:
    """A measure of a structure matrix and its partial derivatives; leading axes are those of the question.

    Attributes:
        value: The measure, (...).
        structure: In every entry of the structure matrix, (..., n, m).
        wrench: In every component of the external wrench, (..., n); zero for the tension factor.
        smooth: Whether these are the derivatives, (...).
    """

    value: Array
    structure: Array
    wrench: Array
    smooth: Flags


def tension_factor_slope(structure: ArrayLike) -> Slope:
    """Tension factor and its slope, for any number of cables.

    Args:
        structure: (..., n, m) with n = 3 or 6 and m > n.

    Returns:
        The slope over the leading axes [1], [1] or [1/m].
    """
    flat, shape = _flat(structure)
    k, n, m = flat.shape
    value, size, smooth = np.zeros(k), np.full(k, np.nan), np.zeros(k, dtype=np.bool_)
    normals, tensions, inside = np.full((k, n), np.nan), np.full((k, m), np.nan), np.zeros((k, m), dtype=np.bool_)
    active_factor_each(flat, math.comb(m, n - 1), value, size, normals, tensions, inside, smooth)
    tensions = _balanced(flat, inside, tensions, np.zeros((k, n)))
    slope = -normals[:, :, None] * (tensions / size[:, None])[:, None, :]
    slope[(value == 0.0) & smooth] = 0.0
    return _slope(shape, value, slope, np.zeros((k, n)), smooth)


def capacity_margin_slope(
    structure: ArrayLike, wrench: ArrayLike, lower: ArrayLike, upper: ArrayLike, length: float
) -> Slope:
    """Signed distance of a wrench to the surface of the available wrench set, and its slope.

    Args:
        structure: (..., n, m) with n = 3 or 6 and m >= n.
        wrench: External wrench on the platform, (..., n).
        lower: Least tensions, finite, (m,) or a scalar [N].
        upper: Greatest tensions, finite, (m,) or a scalar [N].
        length: Characteristic length that moments are divided by, held fixed [m].

    Returns:
        The slope over the leading axes [N]; for a set of wrenches give the worst of them.

    Raises:
        InputError: Bounds that are not finite, or upside down.
    """
    flat, shape = _flat(structure, np.asarray(wrench).shape[:-1])
    k, n, m = flat.shape
    load = np.array(np.broadcast_to(wrench, (*shape, n)), dtype=np.float64).reshape(k, n)
    weights = row_lengths(n, length)
    low, high = _window(lower, upper, m)
    value, smooth = np.full(k, -np.inf), np.zeros(k, dtype=np.bool_)
    normals, tensions, inside = np.full((k, n), np.nan), np.full((k, m), np.nan), np.zeros((k, m), dtype=np.bool_)
    active_margin_each(flat, math.comb(m, n - 1), load, low, high, weights, value, normals, tensions, inside, smooth)
    with np.errstate(invalid="ignore"):
        foot = value[:, None] * weights**2 * normals - load
    tensions = _balanced(flat, inside, tensions, foot)
    return _slope(shape, value, normals[:, :, None] * tensions[:, None, :], normals, smooth)


def margin_slope(structure: ArrayLike, wrench: ArrayLike, lower: ArrayLike, upper: ArrayLike) -> Slope:
    """Greatest depth in the tension box over half its widest window, and its slope; one cable too many.

    Args:
        structure: (..., n, n + 1).
        wrench: External wrench on the platform, (..., n).
        lower: Least tensions, finite, (n + 1,) or a scalar [N].
        upper: Greatest tensions, finite, (n + 1,) or a scalar [N].

    Returns:
        The slope over the leading axes; the value is `distribute`'s margin [1].

    Raises:
        InputError: Not one cable too many, or bounds that are not finite or upside down.
    """
    flat, shape = _flat(structure, np.asarray(wrench).shape[:-1])
    k, n, m = flat.shape
    if m != n + 1:
        raise InputError("structure matrix", f"{n} rows and {m} cables", "one cable more than rows")
    load = np.array(np.broadcast_to(wrench, (*shape, n)), dtype=np.float64).reshape(k, n)
    low, high = _window(lower, upper, m)
    null = null_space(flat).basis[..., 0]
    known = np.asarray(np.isfinite(null).all(axis=-1) & np.isfinite(load).all(axis=-1))
    back = np.swapaxes(_inverse(flat[known]), -1, -2)
    start = -np.einsum("knm,kn->km", back, load[known])
    depth, tensions, weights, alone = _deepest(null[known], start, low, high)
    half = 0.5 * float(np.max(high - low))
    value, smooth = np.full(k, -np.inf), np.zeros(k, dtype=np.bool_)
    slope, z = np.full((k, n, m), np.nan), np.full((k, n), np.nan)
    value[known], smooth[known] = depth / half, alone
    z[known] = -np.einsum("knm,km->kn", back, weights) / half
    slope[known] = z[known][:, :, None] * tensions[:, None, :]
    return _slope(shape, value, slope, z, smooth)


def _flat(structure: ArrayLike, other: tuple[int, ...] = ()) -> tuple[Array, tuple[int, ...]]:
    """Structure matrices (k, n, m) and the leading shape they share with another argument."""
    matrix = np.asarray(structure, dtype=np.float64)
    shape = np.broadcast_shapes(matrix.shape[:-2], other)
    tail = matrix.shape[-2:]
    return np.array(np.broadcast_to(matrix, (*shape, *tail)), order="C").reshape(-1, *tail), shape


def _window(lower: ArrayLike, upper: ArrayLike, count: int) -> tuple[Array, Array]:
    """Bounds of every cable, (m,) each."""
    low, high = (np.array(np.broadcast_to(value, (count,)), dtype=np.float64) for value in (lower, upper))
    if not (np.isfinite(low).all() and np.isfinite(high).all() and np.all(low <= high) and np.any(low < high)):
        raise InputError("tension bounds", "not finite windows", "finite lower bounds below finite upper ones")
    return low, high


def _slope(shape: tuple[int, ...], value: Array, structure: Array, wrench: Array, smooth: Flags) -> Slope:
    n, m = structure.shape[-2:]
    return Slope(
        value.reshape(shape), structure.reshape(*shape, n, m), wrench.reshape(*shape, n), smooth.reshape(shape)
    )


def _inverse(matrices: Array) -> Array:
    """Pseudo-inverses (k, m, n); rows are first brought to unit length, so that units do not matter."""
    sizes = np.linalg.norm(matrices, axis=-1, keepdims=True)
    sizes = np.where(sizes > 0.0, sizes, 1.0)
    return np.linalg.pinv(matrices / sizes, rcond=1e-12) / np.swapaxes(sizes, -1, -2)


def _balanced(structures: Array, inside: Flags, tensions: Array, wrench: Array) -> Array:
    """Tensions (k, m) with ``structure f = wrench``, those of cables outside the facet given."""
    known = np.asarray(np.isfinite(np.where(inside, 0.0, tensions)).all(axis=-1) & np.isfinite(wrench).all(axis=-1))
    outside = np.where(inside, 0.0, tensions)[known]
    facet = np.where(inside[known, None, :], structures[known], 0.0)
    rest = wrench[known] - np.einsum("knm,km->kn", structures[known], outside)
    out = np.full(tensions.shape, np.nan)
    out[known] = outside + np.einsum("kmn,kn->km", _inverse(facet), rest)
    return out


def _deepest(null: Array, start: Array, low: Array, high: Array) -> tuple[Array, Array, Array, Flags]:
    """Depth (k,), tensions there (k, m), weights of the bounds (k, m) and whether no other pair of bounds ties.

    Every cable has a bound it leaves and one it nears along the line; the depth is the least, over pairs of one rising
    and one falling distance, of their crossing.
    """
    count = np.arange(len(null))
    rising = np.where(null >= 0.0, start - low, high - start)
    falling = np.where(null >= 0.0, high - start, start - low)
    slope, sign = np.abs(null), np.where(null >= 0.0, 1.0, -1.0)
    up, down = slope[:, :, None], slope[:, None, :]
    with np.errstate(invalid="ignore", divide="ignore"):
        crossing = (down * rising[:, :, None] + up * falling[:, None, :]) / (up + down)
    crossing = np.where(np.isfinite(crossing), crossing, np.inf).reshape(len(null), null.shape[1] ** 2)
    two = np.partition(crossing, 1, axis=-1)[:, :2]
    i, j = np.divmod(np.argmin(crossing, axis=-1), null.shape[1])
    total = slope[count, i] + slope[count, j]
    weights = np.zeros_like(null)
    np.add.at(weights, (count, i), sign[count, i] * slope[count, j] / total)
    np.add.at(weights, (count, j), -sign[count, j] * slope[count, i] / total)
    place = (falling[count, j] - rising[count, i]) / total
    return two[:, 0], start + place[:, None] * null, weights, two[:, 1] - two[:, 0] > TIE * np.max(high - low)
