"""Second derivative of a hanging platform's potential: what each force adds, compiled; the one place it stands in.

For a rotation and a displacement (omega; v) in world axes a cable of tension t and rate k whose free stretch has the
direction u at an arm r adds ``D^T B D`` with ``D = [-(r x), I]`` and ``B = k u u^T + t C``, C the curvature of its
length (see `pulleys`); and every force f at an arm r adds ``(f . r) I - (f r^T + r f^T) / 2`` in the rotations.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def add_cable(
    arm: Array, along: Array, across: Array, inside: float, outside: float, tension: float, rate: float, bend: Array,
    out: Array,
) -> None:  # fmt: skip
    """Add a cable's part to a Hessian.

    Args:
        arm: From the reference point to the attachment, world axes (3,) [m].
        along: Unit vector along the free stretch (3,).
        across: Unit normal of the pulley's plane (3,); not used where both curvatures are equal.
        inside: Curvature of the length in the pulley's plane [1/m].
        outside: And out of it [1/m].
        tension: Above 0 [N].
        rate: Of the cable [N/m].
        bend: Work space (3, 3).
        out: Added to (6, 6).
    """
    stretch, twist = rate - inside * tension, (outside - inside) * tension
    for p in range(3):
        for q in range(3):
            bend[p, q] = stretch * along[p] * along[q] + twist * across[p] * across[q]
        bend[p, p] += inside * tension
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        # Row i of [r x] B, and its cross product with r for the rotations.
        x = arm[j] * bend[k, 0] - arm[k] * bend[j, 0]
        y = arm[j] * bend[k, 1] - arm[k] * bend[j, 1]
        z = arm[j] * bend[k, 2] - arm[k] * bend[j, 2]
        out[i, 0] += arm[1] * z - arm[2] * y
        out[i, 1] += arm[2] * x - arm[0] * z
        out[i, 2] += arm[0] * y - arm[1] * x
        out[i, 3] += x
        out[i, 4] += y
        out[i, 5] += z
        out[3, i] += x
        out[4, i] += y
        out[5, i] += z
        for p in range(3):
            out[3 + i, 3 + p] += bend[i, p]
    add_turn(tension, along, arm, out)


@njit(cache=True, error_model="numpy")
def add_turn(size: float, force: Array, arm: Array, out: Array) -> None:
    """Add ``(f . r) I - (f r^T + r f^T) / 2`` to the rotations, with ``f = size force``."""
    dot = size * (force[0] * arm[0] + force[1] * arm[1] + force[2] * arm[2])
    for p in range(3):
        out[p, p] += dot
        for q in range(3):
            out[p, q] -= 0.5 * size * (force[p] * arm[q] + arm[p] * force[q])


@njit(cache=True, error_model="numpy")
def arm_of(rotation: Array, points: Array, i: int, arm: Array) -> None:
    """Write point ``i`` of (m, 3) turned into world axes, ``rotation @ points[i]``."""
    for p in range(3):
        arm[p] = rotation[p, 0] * points[i, 0] + rotation[p, 1] * points[i, 1] + rotation[p, 2] * points[i, 2]
