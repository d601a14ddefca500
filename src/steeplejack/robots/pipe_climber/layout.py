"""Where the limbs of the 3-RPR mechanism are hinged, and what limits them: the few numbers its mathematics needs.

In the plane X-Z the base joints are ``B_i = (b_i, 0)`` and the platform joints ``P_i = (x + p_i cos a, w - p_i sin a)``
with ``w = z - hz`` and ``p = (-L4, 0, -L2)``. The paper contradicts itself on the base: Table II, section 3 and Eq. 33
("text") put ``b = (0, -L3, -L1)``; Eq. 5, 8 and 9 ("equations") put ``b = (0, -L1, -L3)``. Source: Ye et al., Robotica
2024, section 3-4; the text is the default because it alone is symmetric under exchange of the platforms.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.parameters import Convention, Neutral, PipeClimber

Array = NDArray[np.float64]

LEAST, LARGEST = 1e-9, 1e6
"""Lengths a mechanism may have [m]; far beyond any machine, and their products keep clear of over- and underflow."""


@dataclass(frozen=True)
class Layout:
    """Hinges and limits of a 3-RPR mechanism.

    Attributes:
        lengths: L1..L4 [m].
        convention: Where B2 and B3 sit.
        reach: Least and largest limb length [m].
        joint_limit: Largest turn of a hinge from its neutral [rad].
        neutral: What that limit counts from; "none" for no limit.
        home: Pose (x, w, alpha) the neutral "home" refers to [m, m, rad].
    """

    lengths: tuple[float, float, float, float]
    convention: Convention = "text"
    reach: tuple[float, float] = (0.120, 0.240)
    joint_limit: float = float(np.pi / 6)
    neutral: Neutral = "none"
    home: tuple[float, float, float] = (0.0, 0.160, 0.0)

    def __post_init__(self) -> None:
        """Refuse dimensions no mechanism has."""
        if len(self.lengths) != 4 or not all(LEAST <= length <= LARGEST for length in self.lengths):
            valid = f"four finite lengths L1 L2 L3 L4 of {LEAST:g} to {LARGEST:g} m"
            raise InputError("dimensions", f"{list(self.lengths)} m", valid)
        if not LEAST <= self.reach[0] < self.reach[1] <= LARGEST:
            valid = f"least < largest, both of {LEAST:g} to {LARGEST:g} m"
            raise InputError("reach", f"{self.reach[0]:g} to {self.reach[1]:g} m", valid)
        if not 0.0 < self.joint_limit < np.inf:
            raise InputError("joint limit", f"{self.joint_limit:g} rad", "above 0 rad")
        x, w, alpha = self.home
        if not (abs(x) <= LARGEST and abs(w) <= LARGEST and math.isfinite(alpha)):
            raise InputError("home", f"{list(self.home)}", f"a finite pose x, w, alpha, x and w up to {LARGEST:g} m")
        if self.neutral == "home" and not all(length >= LEAST for length in self.home_lengths):
            raise InputError("home", f"{list(self.home)}: a limb without length", "a pose whose hinges have angles")

    @classmethod
    def of(cls, robot: PipeClimber) -> Layout:
        """The mechanism of a machine.

        Raises:
            InputError: Dimensions no mechanism has, or a home pose it cannot take.
        """
        joints, linkage = robot.joints, robot.linkage
        found = cls(
            linkage.lengths, linkage.convention, robot.cylinders.reach, joints.limit, joints.neutral, joints.home
        )
        found.require_home()
        return found

    def require_home(self) -> None:
        """Refuse a neutral "home" that the limbs cannot take.

        A machine has to; a design that is compared with others need not, because its limit counts from there all the
        same.

        Raises:
            InputError: The limb that is too short or too long there.
        """
        least, largest = self.reach
        for limb, length in enumerate(self.home_lengths, 1):
            if self.neutral == "home" and not least <= length <= largest:
                what = f"{list(self.home)}: limb {limb} is {length:.6g} m long"
                raise InputError("home", what, f"a pose with limbs of {least:g} to {largest:g} m")

    @property
    def home_lengths(self) -> tuple[float, float, float]:
        """Lengths of the limbs at the home pose [m]."""
        x, w, alpha = self.home
        along_x = x + self.platform * math.cos(alpha) - self.base
        first, second, third = np.hypot(along_x, w - self.platform * math.sin(alpha)).tolist()
        return first, second, third

    @property
    def base(self) -> Array:
        """``b_i``: places of the base joints along X, (3,) [m]."""
        l1, _l2, l3, _l4 = self.lengths
        return np.array([0.0, -l3, -l1]) if self.convention == "text" else np.array([0.0, -l1, -l3])

    @property
    def platform(self) -> Array:
        """``p_i``: places of the platform joints along its x axis, (3,) [m]."""
        _l1, l2, _l3, l4 = self.lengths
        return np.array([-l4, 0.0, -l2])
