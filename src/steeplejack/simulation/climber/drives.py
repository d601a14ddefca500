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
    controls: Array,
    goals: Array,
    ranges: Array,
    places: Array,
    speeds: Array,
    windows: Array,
    closed: NDArray[np.bool_],
    opening: Array,
    constants: Array,
) -> None:
    """Advance what the drives aim at and how hard jaws may press, in place.

    A rod or a linkage that follows its drive is damped against the drive, not against the frame: MuJoCo's position
    actuators push with ``kp (control - q) - kv q'``, so the control leads the goal by ``kv / kp`` of the goal's rate.

    Args:
        dt: Step [s].
        controls: Of MuJoCo's actuators, written (8,).
        goals: Of cylinders 1 to 3 [m], servo [rad], jaws a and b of the lower and of the upper gripper [m], (8,).
        ranges: Force limits of the same drives, (8, 2) [N]; the jaws' are written.
        places: Lengths of the cylinders and places of the jaws (3 + 2,) [m].
        speeds: Of cylinders [m/s] and servo [rad/s], (4,).
        windows: Lengths between which the screws turn (3, 2) [m].
        closed: Grippers told to close (2,).
        opening: Where open pads stand (2,) [m].
        constants: How far a screw leads its rod [m], how far jaws aim beyond their pads [m], their rate [m/s],
            force [N] and half width [m], leads of screw and servo [s], range of the servo to either side [rad], (8,).
    """
    slack, press, rate, force, half, lead, servo_lead, swing = constants
    for i in range(3):
        # A screw that meets its force stalls: it does not turn on while the rod stands.
        turned = min(max(goals[i] + dt * speeds[i], windows[i, 0]), windows[i, 1])
        turned = min(max(turned, places[i] - slack), places[i] + slack)
        controls[i] = turned + lead * (turned - goals[i]) / dt
        goals[i] = turned
    turned = min(max(goals[3] + dt * speeds[3], -swing), swing)
    controls[3] = turned + servo_lead * (turned - goals[3]) / dt
    goals[3] = turned
    for i in range(2):
        place = places[3 + i]
        goal = place - press if closed[i] else opening[i]
        moved = goals[4 + 2 * i] + min(max(goal - goals[4 + 2 * i], -rate * dt), rate * dt)
        # Pads meet the pipe at an angle to the jaw's way; the force counts where they touch.
        most = force * place / math.hypot(place, half)
        for k in range(4 + 2 * i, 6 + 2 * i):
            goals[k] = moved
            controls[k] = moved
            ranges[k, 0], ranges[k, 1] = -most, most


@njit(cache=True)
def passed(before: Array, now: Array, radii: Array, total: Array) -> None:
    """Add up what has passed through the grippers, along and around the pipe, in place.

    Args:
        before: Places (3) and axes by rows (9) of the grippers' frames, (2, 12) [m].
        now: The same, a little later.
        radii: Of the pipe in each (2,) [m].
        total: Along and around, (2, 2) [m].
    """
    for i in range(2):
        for k in range(3):
            total[i, 0] += (now[i, k] - before[i, k]) * before[i, 5 + 3 * k]
        sine = cosine = 0.0
        for k in range(3):
            sine += before[i, 4 + 3 * k] * now[i, 3 + 3 * k]
            cosine += before[i, 3 + 3 * k] * now[i, 3 + 3 * k]
        total[i, 1] += radii[i] * math.atan2(sine, cosine)


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
