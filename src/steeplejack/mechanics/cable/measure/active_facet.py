"""Compiled search for the hyperplane that sets a pose's tension factor or capacity margin; `slopes` is its public face.

Every hyperplane through n - 1 columns is tried (see `hyperplanes`); of the active one the kernels write the normal, the
cables that lie in it and what the others pull, and whether it is the only one.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.wrench.hyperplanes import TOLERANCE, equalise, hyperplanes

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

TIE = 1e-9
"""Relative difference below which two facets count as one and the same value [1]."""


@njit(cache=True)
def active_factor_each(
    structures: Array, room: int, value: Array, size: Array, normal: Array, tensions: Array,
    inside: Flags, smooth: Flags,
) -> None:  # fmt: skip
    """The hyperplane that sets the tension factor of every structure matrix (k, n, m).

    Args:
        structures: (k, n, m).
        room: Number of subsets of ``n - 1`` of the ``m`` columns.
        value: Written, the tension factor (k,).
        size: Written, ``P`` (k,).
        normal: Written, ``z`` towards the larger side (k, n).
        tensions: Written where a cable is not in the hyperplane (k, m).
        inside: Written, cables in the hyperplane (k, m).
        smooth: Written (k,).
    """
    n, m = structures.shape[1], structures.shape[2]
    columns, scale, v = np.empty((m, n)), np.empty(n), np.empty(m)
    basis, chosen, normals = np.empty((n, n, n)), np.empty(n, np.int64), np.empty((room, n))
    flags, ratios = np.empty((room, m), np.bool_), np.empty(room)
    for k in range(structures.shape[0]):
        largest = equalise(structures[k], columns, scale)
        if not largest > 0.0:
            continue
        count = hyperplanes(columns, basis, chosen, normals)
        best, singular = -1, count == 0
        for j in range(count):
            widest = _sides(columns, normals[j], v, flags[j])
            if not widest > TOLERANCE * largest:
                singular = True
                break
            plus, minus = 0.0, 0.0
            for i in range(m):
                plus += max(v[i], 0.0)
                minus -= min(v[i], 0.0)
            ratios[j] = min(plus, minus) / max(plus, minus)
            if best < 0 or ratios[j] < ratios[best]:
                best = j
        if singular:
            continue
        if not ratios[best] > TOLERANCE:
            smooth[k] = True
            continue
        smooth[k] = ratios[best] < 1.0 - TIE and _alone(flags, ratios, best, count, n, TIE)
        _sides(columns, normals[best], v, inside[k])
        plus, minus = 0.0, 0.0
        for i in range(m):
            plus += max(v[i], 0.0)
            minus -= min(v[i], 0.0)
        sign = 1.0 if plus >= minus else -1.0
        value[k], size[k] = ratios[best], max(plus, minus)
        for r in range(n):
            normal[k, r] = sign * normals[best, r] * scale[r]
        for i in range(m):
            tensions[k, i] = ratios[best] if sign * v[i] > 0.0 else 1.0


@njit(cache=True)
def active_margin_each(
    structures: Array, room: int, wrenches: Array, lower: Array, upper: Array, weights: Array,
    value: Array, normal: Array, tensions: Array, inside: Flags, smooth: Flags,
) -> None:  # fmt: skip
    """The facet of the available wrench set nearest to a wrench, for every structure matrix (k, n, m).

    Args:
        structures: (k, n, m).
        room: Number of subsets of ``n - 1`` of the ``m`` columns.
        wrenches: (k, n).
        lower: (m,) [N].
        upper: (m,) [N].
        weights: Of the rows of ``z`` in its norm: 1 for forces, the characteristic length for moments (n,).
        value: Written, signed distance (k,) [N].
        normal: Written, outward ``z`` of unit length (k, n).
        tensions: Written where a cable is not in the facet (k, m).
        inside: Written, cables in the facet (k, m).
        smooth: Written (k,).
    """
    n, m = structures.shape[1], structures.shape[2]
    columns, scale, v = np.empty((m, n)), np.empty(n), np.empty(m)
    basis, chosen, normals = np.empty((n, n, n)), np.empty(n, np.int64), np.empty((room, n))
    flags, reach = np.empty((2 * room, m), np.bool_), np.empty(2 * room)
    widest_window = 0.0
    for i in range(m):
        widest_window = max(widest_window, upper[i] - lower[i])
    for k in range(structures.shape[0]):
        largest = equalise(structures[k], columns, scale)
        if not (largest > 0.0 and math.isfinite(wrenches[k].sum() + lower.sum() + upper.sum())):
            continue
        count = hyperplanes(columns, basis, chosen, normals)
        best, singular = -1, count == 0
        for j in range(count):
            if not _sides(columns, normals[j], v, flags[2 * j]) > TOLERANCE * largest:
                singular = True
                break
            size, power = 0.0, 0.0
            for r in range(n):
                normals[j, r] *= scale[r]
                size += (normals[j, r] * weights[r]) ** 2
            size = math.sqrt(size)
            for r in range(n):
                normals[j, r] /= size
                power += normals[j, r] * wrenches[k, r]
            flags[2 * j + 1] = flags[2 * j]
            for side in range(2):
                a, sign = 2 * j + side, 1.0 - 2.0 * side
                reach[a] = sign * power
                for i in range(m):
                    if not flags[a, i]:
                        reach[a] += max(sign * v[i] * lower[i], sign * v[i] * upper[i]) / size
                if best < 0 or reach[a] < reach[best]:
                    best = a
        if singular:
            continue
        smooth[k] = _alone(flags, reach, best, 2 * count, n, TIE * widest_window)
        sign = 1.0 - 2.0 * (best % 2)
        value[k] = reach[best]
        for r in range(n):
            normal[k, r] = sign * normals[best // 2, r]
        for i in range(m):
            inside[k, i] = flags[best, i]
            along = 0.0
            for r in range(n):
                along += normal[k, r] * structures[k, r, i]
            tensions[k, i] = upper[i] if along > 0.0 else lower[i]


@njit(cache=True)
def _sides(columns: Array, normal: Array, v: Array, inside: Flags) -> float:
    """Write the columns' (m, n) components along a normal, and which lie in its hyperplane; returns the largest."""
    m, n = columns.shape
    widest = 0.0
    for i in range(m):
        v[i] = 0.0
        for r in range(n):
            v[i] += columns[i, r] * normal[r]
        widest = max(widest, abs(v[i]))
    for i in range(m):
        inside[i] = abs(v[i]) <= TOLERANCE * widest
        if inside[i]:
            v[i] = 0.0
    return widest


@njit(cache=True)
def _alone(flags: Flags, values: Array, best: int, count: int, n: int, tie: float) -> bool:
    """Whether the facet with the least value has n - 1 cables in it and no other facet comes within ``tie``.

    Facets with the same cables are the same facet, but for the two sides of one hyperplane.
    """
    held = 0
    for i in range(flags.shape[1]):
        held += flags[best, i]
    if held != n - 1:
        return False
    for j in range(count):
        if j != best and values[j] - values[best] <= tie:
            return False
    return True
