"""What the squad's sensors make of the truth: quantised, noisy, biased, drifting.

* Winch and wheel encoders count grains; rates are what they count between two readings over the time in between. A
  wheel's scale error makes its odometry drift.
* Motor currents give the pull that the motor delivers, with a scale error and noise.
* Inclinometers give clock angles with a bias, noise and a resolution.
* Palm sensors give the preload with noise.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.robots.squad.parameters import Squad

Array = NDArray[np.float64]

BLOCK = 1000  # readings whose noise is drawn at once


class Sensors:
    """Sensor errors of one run: scale errors and biases drawn once, noise drawn in blocks, from one seed.

    Args:
        squad: The machine; its file states the size of every error.
        rng: Source of all of them.

    Attributes:
        errors: What each base keeps for the whole run (3, 4): scale errors of wheel odometry and torque constant [1],
            bias of the inclinometer [rad].
        grains: Resolution of winch encoders [m], wheel encoders [m] and inclinometers [rad] (3,).
    """

    def __init__(self, squad: Squad, rng: np.random.Generator) -> None:
        base, winch = squad.base, squad.winch
        gear = winch.ratio / winch.drum_radius
        spread = (base.odometry_drift, winch.torque_scale_error, base.clock_bias)
        self.errors: Array = np.array([rng.normal(0.0, each, 4) for each in spread])
        self.grains: Array = np.array([2.0 * np.pi / (gear * winch.encoder_counts), base.encoder_step, base.clock_step])
        current = winch.current_noise * winch.torque_constant * gear
        self._sizes = np.array([current, squad.gripper.palm_noise, base.clock_noise])[:, None]
        self._rng, self._used = rng, BLOCK
        self._block = np.empty((BLOCK, 3, 4))

    def noise(self) -> Array:
        """Noise of the next reading (3, 4): of the motor pulls [N], the palm sensors [N] and the clock angles [rad]."""
        if self._used == BLOCK:
            self._block, self._used = self._rng.normal(0.0, 1.0, (BLOCK, 3, 4)) * self._sizes, 0
        self._used += 1
        return self._block[self._used - 1]


@njit(cache=True)
def arc_length(x: Array, references: Array, arcs: Array) -> Array:
    """Arc lengths (4,) [m] of slide coordinates (4,) [m] on rails with polynomials ``arcs`` (4, 5)."""
    out = np.empty(4)
    for i in range(4):
        value = 0.0
        for k in range(arcs.shape[1] - 1, -1, -1):
            value = value * x[i] + arcs[i, k]
        out[i] = references[i] + value
    return out


@njit(cache=True)
def sense(
    out: Array,
    elapsed: float,
    paid: Array,
    pull: Array,
    s: Array,
    start: Array,
    clock: Array,
    palm: Array,
    noise: Array,
    errors: Array,
    grains: Array,
) -> None:
    """Fill a reading (7, 4) in place, rows as in ``runtime.plant.Measurement``.

    Args:
        out: The last reading; the encoders' rates are differences to it.
        elapsed: Time since the last reading [s]; 0 keeps the rates.
        paid: Unstressed cable out (4,) [m].
        pull: Motor pulls as delivered (4,) [N].
        s: Base positions (4,) [m].
        start: Base positions the odometry counts from (4,) [m].
        clock: Clock angles (4,) [rad].
        palm: Palm preloads (4,) [N].
        noise: See :meth:`Sensors.noise`.
        errors: See :class:`Sensors`.
        grains: See :class:`Sensors`.
    """
    for i in range(4):
        out_now = np.round(paid[i] / grains[0]) * grains[0]
        s_now = start[i] + np.round((s[i] - start[i]) * (1.0 + errors[0, i]) / grains[1]) * grains[1]
        if elapsed > 0.0:
            out[1, i] = (out_now - out[0, i]) / elapsed
            out[4, i] = (s_now - out[3, i]) / elapsed
        out[0, i], out[3, i] = out_now, s_now
        out[2, i] = pull[i] * (1.0 + errors[1, i]) + noise[0, i]
        out[5, i] = np.round((clock[i] + errors[2, i] + noise[2, i]) / grains[2]) * grains[2]
        out[6, i] = palm[i] + noise[1, i]
