"""From a wrench in the plane of the cables to bounded changes of the four tensions.

Planned tensions carry the weight. A correcting wrench (two forces in the plane, one moment about its normal) is three
equations in four changes of tension: the least change plus lambda times the null vector, lambda as near to 0 as the
bounds let it be, so that pretension, and with it the stand-off, stays as planned.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.robots.squad.suspension import choose, force_family, interval

Array = NDArray[np.float64]

EXACT, SCALED, CLIPPED = 0, 1, 2  # how much of the wrench the bounds let through: all, a share, whatever clipping left
HALVINGS = 4


@njit(cache=True)
def allocate(matrix: Array, wrench: Array, planned: Array, lower: Array, upper: Array) -> tuple[Array, int]:
    """Tensions (4,) [N] that add a wrench to planned tensions within bounds, and a status.

    Args:
        matrix: Structure matrix of the three controlled freedoms, transposed (4, 3), rows of like size.
        wrench: What to add (3,), in the matrix's units.
        planned: Planned tensions (4,) [N].
        lower: Bounds (4,) [N].
        upper: Bounds (4,) [N].
    """
    share = 1.0
    for attempt in range(HALVINGS + 1):
        change, null, independent = force_family(matrix, -share * wrench)
        if not independent:
            break
        low, high, _a, _b = interval(change, null, lower - planned, upper - planned)
        if low <= high:
            status = EXACT if attempt == 0 else SCALED
            return planned + choose(change, null, low, high, change), status
        share *= 0.5
    return np.minimum(np.maximum(planned, lower), upper), CLIPPED
