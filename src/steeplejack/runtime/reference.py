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
def _sample(knots: Array, coefficients: Array, travel: float) -> tuple[Array, Array, Array]:
    """Value, first and second derivative by travel of every column of a cubic spline (4, n, c)."""
    cell = min(max(np.searchsorted(knots, travel) - 1, 0), knots.shape[0] - 2)
    x = travel - knots[cell]
    columns = coefficients.shape[2]
    value, slope, bend = np.empty(columns), np.empty(columns), np.empty(columns)
    for j in range(columns):
        a, b, c, d = (
            coefficients[0, cell, j],
            coefficients[1, cell, j],
            coefficients[2, cell, j],
            coefficients[3, cell, j],
        )
        value[j] = ((a * x + b) * x + c) * x + d
        slope[j] = (3.0 * a * x + 2.0 * b) * x + c
        bend[j] = 6.0 * a * x + 2.0 * b
    return value, slope, bend


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
        value, slope, bend = _sample(self.knots, self.coefficients, travel)
        rate = slope * speed
        second = slope * acceleration + bend * speed**2
        return Setpoint(
            value[:3],
            from_quaternion(value[3:7]),
            rate[:3],
            second[:3],
            value[7:11],
            value[11:15],
            rate[11:15],
            second[11:15],
            value[15:19],
            rate[15:19],
        )
