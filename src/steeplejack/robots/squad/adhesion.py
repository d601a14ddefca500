"""How hard the palms of an anchor base must press to stay on a stay (Eq. 16-17, Fig. 10-11).

The palm closes about a joint at distance ``H`` above the stay's surface and ``W/2`` beside its axis. In the triangle of
cable centre, palm tip and joint, with sides R, L and ``sqrt((R + H)^2 + (W/2)^2)``, gamma is the angle at the palm tip.

Source: Zheng et al., CCRobot-S, IEEE T-RO, Eq. 16-17; W = 0.12 m, H = 0.015 m and mu = 0.3 in Section V-A. The palm
length L is not given there and is an input. Range of validity: the triangle closes and is not flat; stays of
0 to 90 degrees inclination.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from steeplejack.errors import InputError

Sign = Literal["+", "-"]


@dataclass(frozen=True)
class Grip:
    """Least palm force and the angle it acts at.

    Attributes:
        min_force: ``min F_pre`` of Eq. 17, never below 0 [N].
        gamma: Angle at the palm tip, between 0 and pi [rad].
    """

    min_force: float
    gamma: float


def palm_angle(radius: float, palm_length: float, joint_distance: float, joint_height: float) -> float:
    """Angle gamma at the palm tip of the triangle cable centre, palm tip, joint (Eq. 16).

    Args:
        radius: ``R`` of the stay [m].
        palm_length: ``L`` [m].
        joint_distance: ``W`` between the two palm joints [m].
        joint_height: ``H`` of a joint above the stay's surface [m].

    Returns:
        gamma [rad].

    Raises:
        InputError: A length is not positive, or the triangle does not close.
    """
    _require_positive("radius", radius, "m")
    _require_positive("palm length", palm_length, "m")
    _require_positive("joint distance", joint_distance, "m")
    if not (math.isfinite(joint_height) and joint_height >= 0.0):
        raise InputError("joint height", f"{joint_height:g} m", "finite and not negative")
    far = math.hypot(radius + joint_height, 0.5 * joint_distance)
    shortest, longest = abs(far - radius), far + radius
    if not shortest < palm_length < longest:
        valid = f"between {shortest:.6f} and {longest:.6f} m on a stay of {radius:g} m radius"
        raise InputError("palm length", f"{palm_length:g} m", valid)
    return math.acos((radius**2 + palm_length**2 - far**2) / (2.0 * radius * palm_length))


def min_grip_force(
    external_force: float,
    radius: float,
    inclination: float,
    palm_length: float,
    sign: Sign,
    friction: float = 0.3,
    joint_distance: float = 0.12,
    joint_height: float = 0.015,
) -> Grip:
    """Least palm force that holds a base, ``f (sin beta +- mu cos beta) / (2 mu sin gamma)`` (Eq. 17).

    Args:
        external_force: ``f`` of weight, driving cable and environment together [N].
        radius: ``R`` of the stay [m].
        inclination: ``beta`` of the stay against the horizontal, 0 to pi/2 [rad].
        palm_length: ``L`` [m].
        sign: ``+`` where the load pulls away from the palms, ``-`` where it presses on them.
        friction: ``mu`` between palm and sheath [1].
        joint_distance: ``W`` [m].
        joint_height: ``H`` [m].

    Returns:
        The least force, 0 where friction alone holds, and gamma.

    Raises:
        InputError: A quantity outside its range of validity.
    """
    if sign not in ("+", "-"):
        raise InputError("sign", repr(sign), "+ where the load pulls away from the palms, - where it presses")
    if not (math.isfinite(external_force) and external_force >= 0.0):
        raise InputError("external force", f"{external_force:g} N", "finite and not negative")
    if not 0.0 <= inclination <= 0.5 * math.pi + 1e-12:
        raise InputError("inclination", f"{math.degrees(inclination):g} deg", "between 0 and 90 deg")
    _require_positive("friction", friction, "")
    gamma = palm_angle(radius, palm_length, joint_distance, joint_height)
    press = friction * math.cos(inclination) * (1.0 if sign == "+" else -1.0)
    force = external_force * (math.sin(inclination) + press) / (2.0 * friction * math.sin(gamma))
    return Grip(min_force=max(force, 0.0), gamma=gamma)


def _require_positive(name: str, value: float, unit: str) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise InputError(name, f"{value:g} {unit}".strip(), "positive and finite")
