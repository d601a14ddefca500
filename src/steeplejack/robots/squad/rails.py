"""The stays under the bases as tables: where winch exits are, in a microsecond, for loops at 1 kHz."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.robots.squad.bay import Bay

Array = NDArray[np.float64]

RAIL_STEP = 1.0  # [m] between tabulated places on a stay; the arc between them is off its chord by 20 um at R = 6 km


def tabulate(bay: Bay) -> Array:
    """Every base's stay at steps of RAIL_STEP (4, n, 12): point [m], tangent, directions of 12 and 3 o'clock."""
    count = max(int(np.ceil(bay.stays[k].length / RAIL_STEP)) for k in bay.carriers) + 1
    out = np.empty((4, count, 12))
    for i, k in enumerate(bay.carriers):
        stay = bay.stays[k]
        s = np.minimum(np.arange(count) * RAIL_STEP, stay.length)
        twelve, three = stay.clock_frame(s)
        out[i] = np.hstack([stay.position(s), stay.tangent(s), twelve, three])
    return out


@njit(cache=True)
def winch_exits(rails: Array, step: float, offset: float, s: Array, clock: Array) -> tuple[Array, Array]:
    """Winch exits and stay tangents (4, 3) of bases at ``s`` [m] and ``clock`` [rad] from tabulated stays.

    Args:
        rails: See :func:`tabulate`.
        step: Spacing of the table [m].
        offset: Winch exit off the axis [m].
        s: Base positions (4,) [m].
        clock: Clock angles (4,) [rad].
    """
    points, tangents = np.empty((4, 3)), np.empty((4, 3))
    for i in range(4):
        cell = min(max(int(s[i] / step), 0), rails.shape[1] - 2)
        share = s[i] / step - cell
        cosine, sine = offset * np.cos(clock[i]), offset * np.sin(clock[i])
        for k in range(3):
            at = rails[i, cell, k] + share * (rails[i, cell + 1, k] - rails[i, cell, k])
            tangents[i, k] = rails[i, cell, 3 + k] + share * (rails[i, cell + 1, 3 + k] - rails[i, cell, 3 + k])
            points[i, k] = at + cosine * rails[i, cell, 6 + k] + sine * rails[i, cell, 9 + k]
    return points, tangents
