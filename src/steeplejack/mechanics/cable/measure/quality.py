"""How evenly a platform's cables act: condition number and dexterity of the normalised structure matrix.

Moments and forces cannot be compared until a length is chosen. Here the moment rows of the structure matrix are divided
by a *characteristic length* L, so that a unit wrench is 1 N or L x 1 N; `characteristic_length`, the mean distance of
the attachments from the platform's reference point, is the usual choice. Then

    condition number  kappa = sigma_max / sigma_min,        dexterity  1 / kappa in [0, 1],

the ratio of the longest to the shortest axis of the ellipsoid of wrenches that tensions of unit norm (of either sign)
exert. Source: Gosselin and Angeles, "A global performance index for the kinematic optimization of robotic
manipulators", J. Mechanical Design 113(3), 1991; Verhoeven, *Analysis of the workspace of tendon-based Stewart
platforms*, Duisburg 2004, on the choice of length. That cables only pull is not seen: a well-conditioned pose may be
outside wrench closure, so read it beside the tension factor.

Policy: dexterity is 0 and the condition number infinite where the rank is deficient (a singular value below 1e-12 of
the largest); both are not a number where an entry is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.wrench.feasibility import row_lengths

Array = NDArray[np.float64]

RANK = 1e-12
"""Share of the largest singular value below which one counts as zero [1]."""


def normalised_structure(structure: ArrayLike, length: float) -> Array:
    """Structure matrix with moment rows divided by a characteristic length, all entries then without unit.

    Args:
        structure: Rows ``(fx, fy, mz)``, (..., 3, m), or (moment; force), (..., 6, m).
        length: Characteristic length [m].

    Returns:
        Same shape [1].

    Raises:
        InputError: A length that is not positive, or other rows.
    """
    matrix = np.asarray(structure, dtype=np.float64)
    rows = matrix.shape[-2]
    if not 0.0 < length < np.inf:
        raise InputError("characteristic length", f"{length}", "a positive length in metres")
    if rows not in (3, 6):
        raise InputError("structure matrix", f"{rows} rows", "3 rows (fx, fy, mz) or 6 rows (moment; force)")
    return matrix / row_lengths(rows, length)[:, None]


def dexterity(structure: ArrayLike, length: float) -> Array:
    """Least over greatest singular value of the normalised structure matrix.

    Args:
        structure: Rows ``(fx, fy, mz)``, (..., 3, m), or (moment; force), (..., 6, m).
        length: Characteristic length, see `characteristic_length` [m].

    Returns:
        In [0, 1], 0 where singular, (...) [1].
    """
    matrix = normalised_structure(structure, length)
    if matrix.shape[-1] < matrix.shape[-2]:
        return np.zeros(matrix.shape[:-2])
    known = np.asarray(np.isfinite(matrix).all(axis=(-2, -1)))
    values = np.linalg.svd(np.where(known[..., None, None], matrix, 0.0), compute_uv=False)
    most, least = values[..., 0], values[..., -1]
    ratio = np.divide(least, most, out=np.zeros_like(most), where=least > RANK * most)
    return np.where(known, ratio, np.nan)


def condition_number(structure: ArrayLike, length: float) -> Array:
    """Greatest over least singular value of the normalised structure matrix; arguments as of `dexterity`.

    Returns:
        At least 1, infinite where singular, (...) [1].
    """
    with np.errstate(divide="ignore"):
        return 1.0 / dexterity(structure, length)
