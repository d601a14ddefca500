"""Compiled search for the hyperplane that sets a measure of a pose; `slopes` is its public face and has the theory.

With ``z`` the normal of a hyperplane through n - 1 columns, ``v = structure^T z`` and the reach
``h(z) = sum_i max(lower_i v_i, upper_i v_i) + z . wrench``, each measure is the least over all ``z``, of both signs, of

    h(z) / size(z),      size = |z| in a metric (capacity margin), sum |v_i| (depth), sum max(-v_i, 0) (tension factor),

the tension factor with bounds 0 and 1 and no wrench. The walk over the columns is that of `hyperplanes`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.degeneracy import TOLERANCE, equalise
from steeplejack.mechanics.cable.wrench.hyperplanes import hyperplanes, weighted_length

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

FACTOR, MARGIN, DEPTH = range(3)

TIE = 1e-9
"""Difference over the widest window below which two facets count as one and the same value [1]."""


@njit(cache=True, error_model="numpy")
def active_facet_each(
    structures: Array, held: Flags, room: int, measure: int, wrenches: Array, lower: Array, upper: Array,
    weights: Array,
    value: Array, normal: Array, tensions: Array, inside: Flags, smooth: Flags,
) -> None:  # fmt: skip
    """The facet that sets a measure of every structure matrix (k, n, m); nothing is written where it has none.

    Args:
        structures: (k, n, m).
        held: Which of them are regular; the others are passed over (k,).
        room: Number of subsets of ``n - 1`` of the ``m`` columns.
        measure: `FACTOR`, `MARGIN` or `DEPTH`.
        wrenches: (k, n).
        lower: (m,) [N].
        upper: (m,) [N].
        weights: Of the rows of ``z`` in the metric: 1 for forces, the characteristic length for moments (n,).
        value: Written, the measure (k,).
        normal: Written, ``z / size(z)``, pointing out of the facet (k, n).
        tensions: Written where a cable is not in the facet (k, m).
        inside: Written, cables in the facet (k, m).
        smooth: Written, whether the facet is the only one and spanned by n - 1 columns (k,).
    """
    n, m = structures.shape[1], structures.shape[2]
    columns, scale, v = np.empty((m, n)), np.empty(n), np.empty(m)
    basis, chosen, normals = np.empty((n, n, n)), np.empty(n, np.int64), np.empty((room, n))
    ratios, count = np.empty(2 * room), 0
    tie = TIE * np.max(upper - lower)
    for k in range(structures.shape[0]):
        if not (held[k] and equalise(structures[k], columns, scale) > 0.0 and math.isfinite(wrenches[k].sum())):
            continue
        count = hyperplanes(columns, basis, chosen, normals)
        best = _least(columns, normals, count, scale, measure, wrenches[k], lower, upper, weights, ratios)
        if best < 0:
            continue
        sign = 1.0 - 2.0 * (best % 2)
        _components(columns, normals[best // 2], v)
        for r in range(n):
            normals[best // 2, r] *= scale[r]
        size = _reach(measure, v, normals[best // 2], sign, wrenches[k], lower, upper, weights)[1]
        value[k], spanning = ratios[best], 0
        for r in range(n):
            normal[k, r] = sign * normals[best // 2, r] / size
        for i in range(m):
            inside[k, i] = v[i] == 0.0
            spanning += inside[k, i]
            pulls = sign * v[i] > 0.0
            tensions[k, i] = upper[i] if pulls else lower[i]
            if measure == DEPTH:
                tensions[k, i] += -value[k] if pulls else value[k]
            elif measure == FACTOR and not pulls:
                tensions[k, i] = value[k]
        outside = measure == FACTOR and ratios[best] <= TOLERANCE
        smooth[k] = spanning == n - 1 and (outside or _alone(ratios, best, 2 * count, tie))


@njit(cache=True, error_model="numpy")
def _least(
    columns: Array, normals: Array, count: int, scale: Array, measure: int, wrench: Array,
    lower: Array, upper: Array, weights: Array, ratios: Array,
) -> int:  # fmt: skip
    """Write reach over size of both sides of every hyperplane; returns the least one, -1 where there is none."""
    m, n = columns.shape
    v, z, best = np.empty(m), np.empty(n), -1
    for j in range(count):
        _components(columns, normals[j], v)
        for r in range(n):
            z[r] = normals[j, r] * scale[r]
        for side in range(2):
            a = 2 * j + side
            reach, size = _reach(measure, v, z, 1.0 - 2.0 * side, wrench, lower, upper, weights)
            ratios[a] = reach / size if size > 0.0 else np.inf
            if best < 0 or ratios[a] < ratios[best]:
                best = a
    return best


@njit(cache=True)
def _reach(
    measure: int, v: Array, z: Array, sign: float, wrench: Array, lower: Array, upper: Array, weights: Array
) -> tuple[float, float]:
    """``h(sign z)`` and the size it is divided by."""
    reach, size = 0.0, 0.0
    for i in range(v.size):
        along = sign * v[i]
        reach += along * (upper[i] if along > 0.0 else lower[i])
        if measure == DEPTH:
            size += abs(along)
        elif measure == FACTOR:
            size += max(-along, 0.0)
    for r in range(z.size):
        reach += sign * z[r] * wrench[r]
    return reach, weighted_length(z, weights) if measure == MARGIN else size


@njit(cache=True)
def _components(columns: Array, normal: Array, v: Array) -> None:
    """Write the columns' (m, n) components along a normal, 0 in its hyperplane."""
    m, n = columns.shape
    widest = 0.0
    for i in range(m):
        v[i] = 0.0
        for r in range(n):
            v[i] += columns[i, r] * normal[r]
        widest = max(widest, abs(v[i]))
    for i in range(m):
        if abs(v[i]) <= TOLERANCE * widest:
            v[i] = 0.0


@njit(cache=True)
def _alone(values: Array, best: int, count: int, tie: float) -> bool:
    """Whether no other facet comes within ``tie`` of the least."""
    for j in range(count):
        if j != best and values[j] - values[best] <= tie:
            return False
    return True
