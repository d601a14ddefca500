"""Bases between two control steps: wheels pull up to what they hold, palms take their time."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

TURN_GAIN = 20.0  # [N m s/rad] of the drive that turns a base about its stay while its palms are open


@njit(cache=True)
def drive(
    inputs: Array, traction: Array, turn: Array, grip: Flags, rates: Array, dofs: NDArray[np.int64], most: Array
) -> None:
    """Write wheel tractions [N] and turning torques [N m] of the bases into ``inputs`` (8,), within their limits.

    Args:
        inputs: Written.
        traction: Commanded (4,) [N].
        turn: Commanded turning rates (4,) [rad/s]; nothing turns a base whose palms are told to close.
        grip: Palms told to be closed (4,).
        rates: Velocities of every degree of freedom.
        dofs: Those of the bases about their stays (4,).
        most: Largest traction [N] and torque [N m].
    """
    for i in range(4):
        inputs[i] = min(max(traction[i], -most[0]), most[0])
        torque = TURN_GAIN * (turn[i] - rates[dofs[i]])
        inputs[4 + i] = 0.0 if grip[i] else min(max(torque, -most[1]), most[1])


@njit(cache=True)
def squeeze(palm: Array, grip: Flags, force: float, most: float, brake: Flags, braked: Flags) -> bool:
    """Close and open palms (4,) [N] by at most ``most`` [N], take over wheel brakes; whether anything changed."""
    changed = False
    for i in range(4):
        goal = force if grip[i] else 0.0
        if goal != palm[i]:
            palm[i] += min(max(goal - palm[i], -most), most)
            changed = True
        if brake[i] != braked[i]:
            braked[i] = brake[i]
            changed = True
    return changed
