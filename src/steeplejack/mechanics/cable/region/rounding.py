"""How far the determinants of spatial cables may be off because anchors, attachments and rotation were stored rounded.

Moment and force of a column, ``m = b x (A - p)`` and ``v = A - b - p``, move with small errors ``e`` of the arm and
``a`` of the anchor by at most ``|e| (|A - p| + |a|) + |b| |a|`` and ``|e| + |a|``. A determinant of six columns is a
sum over the twenty choices of three that give their moments (Laplace), each product of two 3 x 3 determinants at most
the product of the lengths in them (Hadamard). So with errors put into one column after the other it moves by at most

    sum_i [t^3]  (dv_i + t dm_i)  prod_{j != i} (v_j + t m_j),

all lengths at their greatest over the poses asked about. Determinants that vanish identically are left alone.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from steeplejack.mechanics.cable.region.facets import Facets

Array = NDArray[np.float64]

ARM = 2.0**-50
"""Error of an arm over its length: half a unit in the last place of nine entries of the rotation and of the attachment,
with room for the few operations here [1]."""

ANCHOR = 2.0**-52
"""Error of an anchor over the sum of its absolute coordinates [1]."""


def stored_rounding(facets: Facets, low: Array, high: Array) -> Array:
    """Bounds of the error of every determinant of a spatial question.

    Args:
        facets: The question.
        low: Least scaled positions asked about, (3,).
        high: Greatest, (3,).

    Returns:
        Of the determinants of six columns, then for every wrench of those of five and it, (t + k s,).
    """
    arm = np.linalg.norm(facets.arms, axis=1)
    stored = np.abs(facets.anchors).sum(axis=1) + np.abs(facets.origin).sum() / facets.length
    reach = _farthest(facets.anchors, low, high)
    arm_error, anchor_error = ARM * arm, ANCHOR * stored
    force_error = arm_error + anchor_error
    moment_error = arm_error * (reach + anchor_error) + arm * anchor_error
    errors = np.stack((force_error, moment_error), axis=1)
    columns = np.stack((_farthest(facets.anchors - facets.arms, low, high), arm * reach), axis=1) + errors
    wholes = np.array(list(itertools.combinations(range(len(arm)), 6)))
    vanish = np.concatenate((facets.volumes, facets.loads.reshape(-1, *facets.volumes.shape[1:])))
    bounds = [_moved(columns[wholes], errors[wholes])]
    for wrench in facets.wrenches:
        given = np.array([float(np.linalg.norm(wrench[3:])), float(np.linalg.norm(wrench[:3]))])
        shape = (len(facets.subsets), 1, 2)
        five, five_errors = columns[facets.subsets], errors[facets.subsets]
        bounds.append(
            _moved(
                np.concatenate((five, np.broadcast_to(given, shape)), axis=1),
                np.concatenate((five_errors, np.zeros(shape)), axis=1),
            )
        )
    return np.concatenate(bounds) * np.any(vanish, axis=(1, 2))


def _farthest(points: Array, low: Array, high: Array) -> Array:
    """Greatest distance of points (m, 3) from anywhere in a box, (m,)."""
    return np.linalg.norm(np.maximum(np.abs(points - low), np.abs(points - high)), axis=1)


def _moved(columns: Array, errors: Array) -> Array:
    """The sum of the module's equation: forces and moments (s, 6, 2) of every determinant and their errors, (s,)."""
    whole, change = np.zeros((len(columns), 4)), np.zeros((len(columns), 4))
    whole[:, 0] = 1.0
    for k in range(columns.shape[1]):
        change = _times(change, columns[:, k]) + _times(whole, errors[:, k])
        whole = _times(whole, columns[:, k])
    return change[:, 3]


def _times(polynomials: Array, factors: Array) -> Array:
    """Products of cubics in t (s, 4) and ``f_0 + t f_1`` (s, 2), cut after t^3."""
    out = polynomials * factors[:, :1]
    out[:, 1:] += polynomials[:, :-1] * factors[:, 1:]
    return out
