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

Policy: dexterity is 0 and the condition number infinite where the pose is singular, and both are not a number where it
is undefined, as `degeneracy` defines both; what is singular does not depend on the characteristic length.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import characteristic, structures_of
from steeplejack.mechanics.cable.degeneracy import decide, rank
from steeplejack.mechanics.cable.wrench.feasibility import row_lengths

Array = NDArray[np.float64]


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
    matrices, lead = structures_of(structure)
    with np.errstate(invalid="ignore", over="ignore"):
        return (matrices * _scales(matrices.shape[1], length)[:, None]).reshape(*lead, *matrices.shape[1:])


def dexterity(structure: ArrayLike, length: float) -> Array:
    """Least over greatest singular value of the normalised structure matrix.

    Args:
        structure: Rows ``(fx, fy, mz)``, (..., 3, m), or (moment; force), (..., 6, m).
        length: Characteristic length, see `characteristic_length` [m].

    Returns:
        In [0, 1], 0 where singular, not a number where undefined, (...) [1].

    Raises:
        InputError: A length that is not positive, or other rows.
    """
    matrices, lead = structures_of(structure)
    n = matrices.shape[1]
    ranks, out = rank(matrices), np.full(len(matrices), np.nan)
    _evenness_each(matrices, _scales(n, length), ranks, out)
    return out.reshape(lead)


def condition_number(structure: ArrayLike, length: float) -> Array:
    """Greatest over least singular value of the normalised structure matrix; arguments and errors as of `dexterity`.

    Returns:
        At least 1, infinite where singular, not a number where undefined, (...) [1].
    """
    with np.errstate(divide="ignore"):
        return 1.0 / dexterity(structure, length)


@njit(cache=True)
def evenness(structure: Array, scale: Array) -> float:
    """Least over greatest singular value [1] of one matrix (n, m) of finite numbers, its rows multiplied by a scale.

    Args:
        structure: (n, m).
        scale: One over the characteristic length for moments, 1 for forces (n,).
    """
    n, m = structure.shape
    sizes = np.empty(n)
    decide(structure, scale, np.empty((n, m)), np.empty((n, n)), sizes)
    most = np.max(sizes)
    return np.min(sizes) / most if most > 0.0 else 0.0


@njit(cache=True)
def _evenness_each(structures: Array, scale: Array, ranks: NDArray[np.int64], out: Array) -> None:
    """`evenness` of every matrix of a batch, 0 where the rank is deficient; undefined ones are left alone."""
    for k in range(structures.shape[0]):
        if ranks[k] == structures.shape[1]:
            out[k] = evenness(structures[k], scale)
        elif ranks[k] >= 0:
            out[k] = 0.0


def _scales(rows: int, length: float) -> Array:
    """What each row is multiplied by, (n,)."""
    scale = characteristic(length)
    if rows not in (3, 6):
        raise InputError("structure", f"{rows} rows", "3 rows (fx, fy, mz) or 6 rows (moment; force)")
    with np.errstate(over="ignore"):
        return 1.0 / row_lengths(rows, scale)
