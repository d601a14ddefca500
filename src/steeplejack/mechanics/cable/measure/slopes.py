"""Slopes of tension factor and margins in the entries of the structure matrix and in the wrench, any number of cables.

All three measures are optima of linear programs, and by the envelope theorem the slope of an optimum is that of its
Lagrangian with the optimisers held: a direction ``z`` of wrenches times tensions ``f``. With ``v = structure^T z``,
over all hyperplanes through n - 1 columns of the structure matrix and both signs of their normal ``z``:

- *Tension factor*: the largest t with ``structure f = 0`` and ``t <= f <= 1``. Active is the ``z`` with the least
  ``P / Q``, the sums of positive and of negative parts of ``v``. Cables on its positive side pull 1, those on the
  other t, and those in it what balances: ``dTF = z^T d(structure) f / Q``.
- *Capacity margin*: distance from the wrench to the nearest facet of the available wrench set, moments divided by a
  characteristic length that is held fixed. With ``z`` the facet's normal, of unit length in that metric, and ``f`` the
  tensions at the foot of the perpendicular, ``d = z^T d(structure) f + z^T d(wrench)``. The margin is that of Guay,
  Cardou, Cruz-Ruiz and Caro, "Measuring how well a structure supports varying external wrenches", New Advances in
  Mechanisms, Springer 2014.
- *Depth in the tension box*: `distribute`'s margin, the largest d with ``structure f + w = 0`` and
  ``lower + d <= f <= upper - d``. The box of that depth is an available wrench set with the same normals, so d is the
  least ``(h(z) + z . w) / sum |v_i|``, h the reach of the set, and never more than half the narrowest window:
  ``d = (z^T d(structure) f + z^T d(wrench)) / sum |v_i|``; all over half the widest window.

Where they have no derivative. Each measure is the least of finitely many functions of the pose, one for each facet. It
is smooth where the active facet is the only one and is spanned by exactly n - 1 columns. Where two facets tie to within
`TIE` it has a kink: one-sided slopes exist in every direction and are the least of those of the tied facets, of which
one is returned, so that no direction rises faster than the slope says. Where more than n - 1 columns lie in the active
facet its tensions are not unique and the slope is that of the least ones. Outside wrench closure the tension factor is
0 and so is its slope. Where the matrix is singular or an entry is not a number, margins are -inf, the tension factor is
0, slopes are not a number and nothing is smooth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import characteristic, finite_limits, leading, spread, structures_of, vectors
from steeplejack.mechanics.cable.degeneracy import TOLERANCE, rank
from steeplejack.mechanics.cable.measure.active_facet import DEPTH, FACTOR, MARGIN, TIE, active_facet_each
from steeplejack.mechanics.cable.wrench.feasibility import lengths_of, row_lengths

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
        structure: (..., n, m) with n from 2 to 6.

    Returns:
        The slope over the leading axes [1], [1] or [1/m].

    Raises:
        InputError: A shape that is no structure matrix.
    """
    matrices, _ = structures_of(structure, 2, 6)
    found = _active(FACTOR, structure, np.zeros(matrices.shape[1]), 0.0, 1.0, 1.0)
    held = found.value > TOLERANCE
    outside = np.isfinite(found.value) & ~held
    slope = np.where(outside[..., None, None], 0.0, found.structure)
    return Slope(np.where(held, found.value, 0.0), slope, np.zeros_like(found.wrench), found.smooth)


def capacity_margin_slope(
    structure: ArrayLike, wrench: ArrayLike, lower: ArrayLike, upper: ArrayLike, length: float
) -> Slope:
    """Signed distance of a wrench to the surface of the available wrench set, and its slope.

    Args:
        structure: (..., n, m) with n from 2 to 6.
        wrench: External wrench on the platform, (..., n).
        lower: Least tensions, finite, (m,) or a scalar [N].
        upper: Greatest tensions, finite, (m,) or a scalar [N].
        length: Characteristic length that moments are divided by, held fixed [m].

    Returns:
        The slope over the leading axes [N]; for a set of wrenches give the worst of them.

    Raises:
        InputError: Shapes that do not fit, a length that is not above 0, bounds that are not finite or upside down.
    """
    return _active(MARGIN, structure, wrench, lower, upper, length)


@np.errstate(invalid="ignore", over="ignore")
def margin_slope(structure: ArrayLike, wrench: ArrayLike, lower: ArrayLike, upper: ArrayLike) -> Slope:
    """Greatest depth in the tension box over half its widest window, and its slope, for any number of cables.

    Args:
        structure: (..., n, m) with n from 2 to 6.
        wrench: External wrench on the platform, (..., n).
        lower: Least tensions, finite, (m,) or a scalar [N].
        upper: Greatest tensions, finite, (m,) or a scalar [N].

    Returns:
        The slope over the leading axes; the value is `distribute`'s margin [1].

    Raises:
        InputError: Shapes that do not fit, or bounds that are not finite or upside down.
    """
    found = _active(DEPTH, structure, wrench, lower, upper, 1.0)
    low, high = _window(lower, upper, found.structure.shape[-1])
    half, cap = 0.5 * float(np.max(high - low)), 0.5 * float(np.min(high - low))
    full = found.value >= cap
    apart = np.abs(found.value - cap) > 2.0 * TIE * half
    return Slope(
        np.minimum(found.value, cap) / half,
        np.where(full[..., None, None], 0.0, found.structure) / half,
        np.where(full[..., None], 0.0, found.wrench) / half,
        np.where(full, apart, found.smooth & apart),
    )


@np.errstate(invalid="ignore", over="ignore")
def _active(
    measure: int, structure: ArrayLike, wrench: ArrayLike, lower: ArrayLike, upper: ArrayLike, length: float
) -> Slope:
    """A measure and its slope by its active facet."""
    matrices, own = structures_of(structure, 2, 6)
    _, n, m = matrices.shape
    load, (low, high) = vectors("wrench", wrench, n), _window(lower, upper, m)
    shape = leading(("structure", (*own, n, m), 2), ("wrench", load.shape, 1))
    flat, loads = spread(matrices.reshape(*own, n, m), shape, (n, m)), spread(load, shape, (n,))
    k, weights = len(flat), row_lengths(n, characteristic(length))
    value, smooth = np.full(k, -np.inf), np.zeros(k, dtype=np.bool_)
    normal, tensions, inside = np.full((k, n), np.nan), np.full((k, m), np.nan), np.zeros((k, m), dtype=np.bool_)
    active_facet_each(
        flat,
        rank(flat) == n,
        math.comb(m, n - 1),
        measure,
        loads,
        low,
        high,
        weights,
        value,
        normal,
        tensions,
        inside,
        smooth,
    )
    foot = value[:, None] * weights * (weights * normal) - loads if measure == MARGIN else -loads
    pulls = _balanced(flat, inside, tensions, foot)
    return Slope(
        value.reshape(shape),
        (normal[:, :, None] * pulls[:, None, :]).reshape(*shape, n, m),
        normal.reshape(*shape, n),
        smooth.reshape(shape),
    )


def _window(lower: ArrayLike, upper: ArrayLike, count: int) -> tuple[Array, Array]:
    """Bounds of every cable, (m,) each."""
    low, high = finite_limits(lower, upper, count)
    if not np.any(low < high):
        raise InputError("tension limits", "windows without width", "a least tension below its greatest")
    return low, high


def _inverse(matrices: Array) -> Array:
    """Pseudo-inverses (k, m, n); rows are first brought to unit length, so that units do not matter."""
    sizes = lengths_of(matrices)
    sizes = np.where(sizes > 0.0, sizes, 1.0)
    return np.linalg.pinv(matrices / sizes, rcond=TOLERANCE) / np.swapaxes(sizes, -1, -2)


def _balanced(structures: Array, inside: Flags, tensions: Array, wrench: Array) -> Array:
    """Tensions (k, m) with ``structure f = wrench``, those of cables outside the facet given."""
    known = np.asarray(np.isfinite(np.where(inside, 0.0, tensions)).all(axis=-1) & np.isfinite(wrench).all(axis=-1))
    outside = np.where(inside, 0.0, tensions)[known]
    facet = np.where(inside[known, None, :], structures[known], 0.0)
    rest = wrench[known] - np.einsum("knm,km->kn", structures[known], outside)
    out = np.full(tensions.shape, np.nan)
    out[known] = outside + np.einsum("kmn,kn->km", _inverse(facet), rest)
    return out
