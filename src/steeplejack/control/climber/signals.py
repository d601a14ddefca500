"""What passes between controller and climber: reference, measurement, command. Lower gripper first, then upper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Reference:
    """Where the mechanism should be now.

    Attributes:
        lengths: Of the limbs (3,) [m].
        rates: Their rates (3,) [m/s].
        beta: Turn of the linkage [rad].
        beta_rate: Its rate [rad/s].
        closed: Grippers that should hold (2,).
        radius: Of the pipe where each gripper stands, or goes to: what an open jaw clears (2,) [m].
        load: What the cylinders should push with, wherever they are, (3,) [N]; if None they keep to the lengths, or
            while both grippers should hold to what they pushed with before.
    """

    lengths: Array
    rates: Array
    beta: float
    beta_rate: float
    closed: Flags
    radius: Array
    load: Array | None = None


@dataclass(frozen=True)
class Measurement:
    """What the climber's sensors say.

    Attributes:
        lengths: Of the limbs, encoders (3,) [m].
        forces: Of the cylinders, motor currents, positive when pushing (3,) [N].
        beta: Of the linkage's servo [rad].
        jaws: How far the pads of each gripper stand from its axis (2,) [m].
        grip: Force of a jaw of each gripper, as normal force of its pads (2,) [N].
        passed: How far the pipe has passed through each gripper, along and around, summed since the start (2, 2) [m].
        gravity: By the inclinometer, in the lower gripper's frame (3,) [m/s2].
    """

    lengths: Array
    forces: Array
    beta: float
    jaws: Array
    grip: Array
    passed: Array
    gravity: Array

    @property
    def readable(self) -> bool:
        """Whether every reading is a finite number."""
        total = self.lengths.sum() + self.forces.sum() + self.beta + self.jaws.sum() + self.grip.sum()
        return bool(np.isfinite(total + self.passed.sum() + self.gravity.sum()))


@dataclass(frozen=True)
class Command:
    """What the climber is told, held until the next command.

    Attributes:
        speeds: Of the cylinders (3,) [m/s].
        servo_speed: Of the linkage [rad/s].
        closed: Grippers told to close (2,).
        opening: Where open pads stand from the gripper's axis (2,) [m].
    """

    speeds: Array
    servo_speed: float
    closed: Flags
    opening: Array


class Plant(Protocol):
    """A climber that can be read and commanded."""

    @property
    def step(self) -> float:
        """Smallest time it advances by [s]; the control step is a multiple of it."""
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
