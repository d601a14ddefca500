"""What the squad's sensors make of the truth: quantised, noisy, drifting."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.robots.squad.parameters import Squad

Array = NDArray[np.float64]

BLOCK = 1000  # readings whose noise is drawn at once


class Sensors:
    """Sensor errors of one run: scale errors drawn once, noise drawn in blocks, from one seed.

    Args:
        squad: The machine; its file states the size of every error.
        rng: Source of all of them.
    """

    def __init__(self, squad: Squad, rng: np.random.Generator) -> None:
        winch = squad.winch
        gear = winch.ratio / winch.drum_radius
        self.odometry = rng.normal(0.0, squad.base.odometry_drift, 4)  # [1] scale error of each wheel
        self.torque = rng.normal(0.0, winch.torque_scale_error, 4)  # [1] scale error of each torque constant
        self.grains = np.array([2.0 * np.pi / (gear * winch.encoder_counts), squad.base.encoder_step])
        self._sizes = np.array([[[winch.current_noise * winch.torque_constant * gear], [squad.gripper.palm_noise]]])
        self._rng, self._used = rng, BLOCK
        self._block = np.empty((BLOCK, 2, 4))

    def noise(self) -> Array:
        """Noise of the next reading (2, 4): of the motor pulls and of the palm sensors [N]."""
        if self._used == BLOCK:
            self._block, self._used = self._rng.normal(0.0, 1.0, (BLOCK, 2, 4)) * self._sizes, 0
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
    paid: Array,
    elapsed: float,
    pull: Array,
    s: Array,
    s_rate: Array,
    start: Array,
    clock: Array,
    palm: Array,
    noise: Array,
    odometry: Array,
    torque: Array,
    grains: Array,
) -> None:
    """Fill a reading (7, 4) in place, rows as in ``runtime.plant.Measurement``.

    Args:
        out: Last reading; its first row gives the winch rate over ``elapsed``.
        paid: Unstressed cable out (4,) [m].
        elapsed: Time since the last reading [s]; 0 keeps the rate.
        pull: Motor pull as driven (4,) [N].
        s: Base positions (4,) [m].
        s_rate: Their rates (4,) [m/s].
        start: Base positions the odometry counts from (4,) [m].
        clock: Clock angles (4,) [rad].
        palm: Palm preloads (4,) [N].
        noise: Of pulls and palms (2, 4) [N].
        odometry: Scale errors (4,) [1].
        torque: Scale errors (4,) [1].
        grains: Resolution of winch and wheel encoders [m].
    """
    for i in range(4):
        read = np.round(paid[i] / grains[0]) * grains[0]
        if elapsed > 0.0:
            out[1, i] = (read - out[0, i]) / elapsed
        out[0, i] = read
        out[2, i] = pull[i] * (1.0 + torque[i]) + noise[0, i]
        out[3, i] = start[i] + np.round((s[i] - start[i]) * (1.0 + odometry[i]) / grains[1]) * grains[1]
        out[4, i] = s_rate[i] * (1.0 + odometry[i])
        out[5, i] = clock[i]
        out[6, i] = palm[i] + noise[1, i]
