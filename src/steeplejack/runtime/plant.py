"""The seam between controller and machine: four calls that simulation and hardware both answer."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


def _four() -> Array:
    return np.zeros(4)


def _flags() -> Flags:
    return np.zeros(4, bool)


@njit(cache=True)
def _finite(values: Array) -> bool:
    total = 0.0  # of finite numbers this size, finite; otherwise not
    for value in values.flat:
        total += value
    return np.isfinite(total)


class Measurement:
    """What the squad's sensors say: named rows of one array (7, 4), overwritten by the next call of ``measure``."""

    def __init__(self) -> None:
        self.values = np.zeros((7, 4))
        self.paid: Array = self.values[0]  # [m] unstressed cable out, winch encoders
        self.pay_rate: Array = self.values[1]  # [m/s]
        self.pull: Array = self.values[2]  # [N] motor pull at the cable, from motor currents
        self.s: Array = self.values[3]  # [m] base positions, wheel odometry
        self.s_rate: Array = self.values[4]  # [m/s]
        self.clock: Array = self.values[5]  # [rad] winch exits about the stays, inclinometers
        self.palm: Array = self.values[6]  # [N] palm preload

    @property
    def readable(self) -> bool:
        """Whether every reading is a finite number."""
        return _finite(self.values)


@dataclass
class Command:
    """What the squad is told, held until the next command."""

    pull: Array = field(default_factory=_four)  # [N] winch motor pull at the cable
    drive: Array = field(default_factory=_four)  # [N] wheel traction along the stay
    turn: Array = field(default_factory=_four)  # [rad/s] of the base about the stay, while its palms are open
    grip: Flags = field(default_factory=_flags)  # close the palms
    brake: Flags = field(default_factory=_flags)  # close the winch brakes
    wheel_brake: Flags = field(default_factory=_flags)  # close the brakes of the wheels


@dataclass(frozen=True)
class Truth:
    """Where everything really is; for the log and for tests, never for the controller."""

    position: Array  # (3,) [m] platform, world
    rotation: Array  # (3, 3) platform to world
    velocity: Array  # (3,) [m/s] of the platform's origin, world
    tension: Array  # (4,) [N]
    exits: Array  # (4, 3) [m] winch exits, world
    s: Array  # (4,) [m] bases


class Plant(Protocol):
    """A squad that can be read and commanded."""

    @property
    def step(self) -> float:
        """Smallest time the plant advances by [s]; the control step is a multiple of it."""
        ...

    def measure(self) -> Measurement:
        """Read every sensor."""
        ...

    def apply(self, command: Command) -> None:
        """Hand over a command."""
        ...

    def advance(self, steps: int) -> None:
        """Let ``steps`` steps of time pass."""
        ...

    def extremes(self) -> tuple[Array, Array]:
        """Least and largest cable tensions (4,) [N] since the last call, at the plant's own rate."""
        ...

    def truth(self) -> Truth | None:
        """The true state, where the plant knows it."""
        ...
