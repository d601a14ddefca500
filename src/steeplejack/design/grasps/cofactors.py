"""Null vector of the structure matrix over a grasp region, as polynomials with bounds of their rounding.

With un-normalised columns ``c_i = (v_i; b_i x v_i)``, ``v_i = r_i - z``, ``r_i = A_i - b_i``, the null vector of the
unit columns is ``n_i ~ N_i l_i`` with ``l_i = |v_i|`` and ``N_i`` the cofactors (Eq. 10). At one orientation

    b_i x v_i = b_i x r_i + z x b_i,          v_j x v_k = r_j x r_k + z x (r_j - r_k)

are affine in the position ``z``, so every ``N_i`` is a quadratic. Positions count along the stay and across it from the
middle of the region, in units of the farthest ``r_i``: neither scale nor the place of the origin enters.

Rounding. Coordinates of ``r`` and ``b`` are off by some units in the last place of the numbers they come from (``dr``,
``db``), so a cofactor by the sum over its three cables of ``(|db| v_i + |b_i| dr) v_j v_k + |b_i| v_i dr (v_j + v_k)``,
all lengths at their greatest over the region, and its few operations add as many units of the last place of the terms.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.grasps.question import GraspQuestion
from steeplejack.mechanics.cable.structure import planar_arms

Array = NDArray[np.float64]

TRIPLES = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))  # columns of cofactor i, in the order that gives it its sign
STORED = 2.0**-49  # [1] error of a coordinate over the numbers it is computed from
OPERATIONS = 2.0**-48  # [1] error of the few dozen operations of a cofactor over the sum of its terms


@dataclass(frozen=True, eq=False)
class Cofactors:
    """The quadratics of one question.

    Attributes:
        unit: One unit of the scaled coordinates [m].
        roots: ``r_i`` along the stay and across it, (4, 2), scaled.
        polynomials: Coefficients of ``1, s, t, s^2, s t, t^2`` of every ``N_i``, (4, 6), scaled.
        slack: Bounds of their rounding over the region, (4,).
        off: Bound of the rounding of a length, scaled.
        arm: Longest ``b_i``, scaled.
    """

    unit: float
    roots: Array
    polynomials: Array
    slack: Array
    off: float
    arm: float


def cofactors_of(question: GraspQuestion) -> Cofactors:
    """Write the cofactors as polynomials of the position in the region.

    Args:
        question: Robot, orientation and region.

    Returns:
        The quadratics.
    """
    region = question.region
    turned = planar_arms(question.attachments, question.phi)
    roots, arms = region.coordinates(question.anchors - turned), turned @ region.axes.T
    corner = float(np.hypot(region.half_length, region.half_width))
    unit = max(float(np.linalg.norm(roots, axis=1).max()), corner) or 1.0
    roots, arms = roots / unit, arms / unit
    stored = np.abs(question.anchors).max() + np.abs(region.point).max() + np.abs(turned).max() + corner
    off = STORED * float(stored) / unit
    moments, far = _moments(roots, arms), np.linalg.norm(roots, axis=1) + corner / unit + off
    lengths = np.linalg.norm(arms, axis=1)
    polynomials = np.array([_cofactor(moments, roots, triple) for triple in TRIPLES])
    slack = np.array([_rounding(lengths, far, off, triple) for triple in TRIPLES])
    return Cofactors(unit, roots, polynomials, slack, off, float(lengths.max()))


def _moments(roots: Array, arms: Array) -> Array:
    """``b_i x v_i`` as coefficients of ``1, s, t``, (4, 3)."""
    still = arms[:, 0] * roots[:, 1] - arms[:, 1] * roots[:, 0]
    return np.stack((still, arms[:, 1], -arms[:, 0]), axis=1)


def _cofactor(moments: Array, roots: Array, triple: tuple[int, int, int]) -> Array:
    """Determinant of three columns, (6,)."""
    i, j, k = triple
    turns = ((i, j, k), (j, k, i), (k, i, j))
    return np.sum([_product(moments[a], _cross(roots[b], roots[c])) for a, b, c in turns], axis=0)


def _cross(first: Array, second: Array) -> Array:
    """``v_j x v_k`` as coefficients of ``1, s, t``, (3,)."""
    still = first[0] * second[1] - first[1] * second[0]
    return np.array([still, first[1] - second[1], second[0] - first[0]])


def _product(a: Array, b: Array) -> Array:
    """Product of two affine functions, (6,)."""
    whole = np.outer(a, b)
    return np.array([
        whole[0, 0], whole[0, 1] + whole[1, 0], whole[0, 2] + whole[2, 0],
        whole[1, 1], whole[1, 2] + whole[2, 1], whole[2, 2],
    ])  # fmt: skip


def _rounding(arms: Array, far: Array, off: float, triple: tuple[int, int, int]) -> float:
    """The bound of the module's text for one cofactor."""
    i, j, k = triple
    bound = 0.0
    for a, b, c in ((i, j, k), (j, k, i), (k, i, j)):
        bound += (STORED * arms[a] * far[a] + arms[a] * off) * far[b] * far[c]
        bound += arms[a] * far[a] * off * (far[b] + far[c]) + OPERATIONS * arms[a] * far[a] * far[b] * far[c]
    return float(bound)
