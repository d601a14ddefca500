"""What the climber's sensors make of the truth: scale errors and offsets of one run, drawn from its seed.

Each is drawn evenly from within a tolerance to either side. Grains stand in the robot file.

| sensor | error | tolerance | where from |
| --- | --- | --- | --- |
| encoder of a cylinder | scale | 0.07 % | ISO 3408-3, travel of a screw of class T10, 0.21 mm in 300 mm |
| | zero | 0.02 mm | estimate, what a limit switch repeats within |
| motor current as force | scale | 5 % | estimate, efficiency of a screw with its temperature |
| linkage's servo | scale | 0.5 % | estimate, a potentiometer's linearity |
| | zero | 0.1 deg | estimate, half of what it counts |
| force of a jaw | scale | 5 % | estimate, as of the cylinders |
| sensor of the pipe that passes | scale | 2 % | estimate, an optical one's distance to the surface |
| inclinometer | lean about X and Y | 0.5 deg | estimate, a MEMS accelerometer's offset of 9 mg |
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from steeplejack.control.climber.signals import Array

ENCODER, ZERO = 7e-4, 2e-5  # [1], [m]
CURRENT, GRIP = 0.05, 0.05  # [1]
SERVO, SERVO_ZERO = 5e-3, math.radians(0.1)  # [1], [rad]
PASSED = 0.02  # [1]
LEAN = math.radians(0.5)  # [rad]


def _none(*shape: int) -> Array:
    return field(default_factory=lambda: np.zeros(shape))


@dataclass(frozen=True)
class SensorErrors:
    """Errors that the sensors keep for a whole run; none by default.

    Attributes:
        encoder: Scale errors of the cylinders' lengths beyond the retracted ones (3,) [1].
        zero: Of the same lengths (3,) [m].
        current: Scale errors of the cylinders' forces (3,) [1].
        servo: Scale error and zero of the linkage's turn (2,) [1, rad].
        grip: Scale errors of the jaws' forces (2,) [1].
        passed: Scale errors of the pipe that passes through the grippers (2,) [1].
        lean: How far gravity seems turned about X and Y of the lower gripper (2,) [rad].
    """

    encoder: Array = _none(3)
    zero: Array = _none(3)
    current: Array = _none(3)
    servo: Array = _none(2)
    grip: Array = _none(2)
    passed: Array = _none(2)
    lean: Array = _none(2)

    @classmethod
    def drawn(cls, rng: np.random.Generator, times: float = 1.0) -> SensorErrors:
        """Errors of one run.

        Args:
            rng: Source of all of them.
            times: By which all tolerances are larger [1].
        """

        def within(*most: float) -> Array:
            return times * rng.uniform(-1.0, 1.0, len(most)) * most

        return cls(
            within(*[ENCODER] * 3), within(*[ZERO] * 3), within(*[CURRENT] * 3), within(SERVO, SERVO_ZERO),
            within(*[GRIP] * 2), within(*[PASSED] * 2), within(LEAN, LEAN),
        )  # fmt: skip

    def leaning(self) -> Array:
        """What turns gravity in the lower gripper's frame into what the inclinometer takes it for (3, 3)."""
        x, y = self.lean
        return np.array([[1.0, 0.0, y], [0.0, 1.0, -x], [-y, x, 1.0]])
