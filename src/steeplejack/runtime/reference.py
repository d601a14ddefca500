"""References from a mission: every leg as a cubic spline through its waypoints, run with its time scaling."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from steeplejack.control.controller import Setpoint
from steeplejack.planning.mission import Leg
from steeplejack.spatial import Profile, from_quaternion, nearest_turn, profile

Array = NDArray[np.float64]


@njit(cache=True)
def _sample(
    knots: Array, coefficients: Array, travel: float, speed: float, acceleration: float, out: Array, rotation: Array
) -> None:
    """A cubic spline (4, n, 19) in the travel and its time derivatives, into ``out`` (33,) and ``rotation``."""
    cell = min(max(np.searchsorted(knots, travel) - 1, 0), knots.shape[0] - 2)
    x = travel - knots[cell]
    quaternion = np.empty(4)
    for j in range(19):
        a, b = coefficients[0, cell, j], coefficients[1, cell, j]
        c, d = coefficients[2, cell, j], coefficients[3, cell, j]
        value = ((a * x + b) * x + c) * x + d
        slope = (3.0 * a * x + 2.0 * b) * x + c
        rate = slope * speed
        second = slope * acceleration + (6.0 * a * x + 2.0 * b) * speed * speed
        if j < 3:
            out[j], out[3 + j], out[6 + j] = value, rate, second
        elif j < 7:
            quaternion[j - 3] = value
        elif j < 11:
            out[2 + j] = value
        elif j < 15:
            out[2 + j], out[6 + j], out[10 + j] = value, rate, second
        else:
            out[10 + j], out[14 + j] = value, rate
    rotation[:] = from_quaternion(quaternion)


@dataclass(frozen=True)
class LegReference:
    """One leg, ready to be sampled in time."""

    leg: Leg
    timing: Profile
    knots: Array  # (n,) [m], or [N] when tensions change at one place
    coefficients: Array  # (4, n - 1, 19): position 3, quaternion 4, tension 4, s 4, clock 4

    @classmethod
    def of(cls, leg: Leg) -> LegReference:
        """Interpolate a leg's waypoints."""
        points = leg.waypoints
        knots = np.array([p.travel for p in points])
        columns = np.hstack(
            [
                np.array([p.position_m for p in points]),
                nearest_turn(np.array([p.quaternion for p in points])),
                np.array([p.tension_n for p in points]),
                np.array([p.base_s_m for p in points]),
                np.unwrap(np.radians([p.base_clock_deg for p in points]), axis=0),
            ]
        )
        timing = profile(float(knots[-1]), leg.speed, leg.acceleration)
        return cls(leg, timing, knots, np.ascontiguousarray(CubicSpline(knots, columns).c))

    def at(self, time: float) -> Setpoint:
        """The reference ``time`` seconds into the leg; at rest before and after."""
        travel, speed, acceleration = self.timing.at(time)
        out, rotation = np.empty(33), np.empty((3, 3))
        _sample(self.knots, self.coefficients, travel, speed, acceleration, out, rotation)
        return Setpoint(out[0:3], rotation, out[3:6], out[6:9], out[9:13], out[13:33].reshape(5, 4))
