"""Drives between two physics steps: screws turn, the servo turns, jaws open and close at their own speed."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True)
def advance(
    dt: float,
    goals: Array,
    ranges: Array,
    places: Array,
    speeds: Array,
    closed: NDArray[np.bool_],
    opening: Array,
    constants: Array,
) -> None:
    """Advance what the drives aim at and how hard jaws may press, in place.

    Args:
        dt: Step [s].
        goals: Of cylinders 1 to 3 [m], servo [rad], jaws a and b of the lower and of the upper gripper [m], (8,).
        ranges: Force limits of the same drives, (8, 2) [N]; the jaws' are written.
        places: Lengths of the cylinders and places of the jaws (3 + 2,) [m].
        speeds: Of cylinders [m/s] and servo [rad/s], (4,).
        closed: Grippers told to close (2,).
        opening: Where open pads stand (2,) [m].
        constants: See `constants`.
    """
    slack, press, rate, force, half = constants
    for i in range(3):
        # A screw that meets its force stalls: it does not turn on while the rod stands.
        goals[i] = min(max(goals[i] + dt * speeds[i], places[i] - slack), places[i] + slack)
    goals[3] += dt * speeds[3]
    for i in range(2):
        place = places[3 + i]
        goal = place - press if closed[i] else opening[i]
        moved = goals[4 + 2 * i] + min(max(goal - goals[4 + 2 * i], -rate * dt), rate * dt)
        # Pads meet the pipe at an angle to the jaw's way; the force counts where they touch.
        most = force * place / math.hypot(place, half)
        for k in range(4 + 2 * i, 6 + 2 * i):
            goals[k] = moved
            ranges[k, 0], ranges[k, 1] = -most, most


@njit(cache=True)
def load(forces: Array, rates: Array, strongest: float) -> tuple[float, float]:
    """Largest force of a cylinder so far [N], and the power that cylinders and servo put in now [W].

    Args:
        forces: Of the drives, cylinders and servo first [N or N m].
        rates: Of the same [m/s or rad/s].
        strongest: Largest force before [N].
    """
    power = 0.0
    for i in range(4):
        power += max(forces[i] * rates[i], 0.0)
        if i < 3:
            strongest = max(strongest, abs(forces[i]))
    return strongest, power
