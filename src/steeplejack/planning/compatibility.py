"""Does the machine fit a stay? Yes, no with reasons, or unknown with what is missing."""

from __future__ import annotations

import math
from dataclasses import dataclass

from steeplejack.robots.squad.adhesion import min_grip_force
from steeplejack.robots.squad.parameters import Squad
from steeplejack.worksite import Stay
from steeplejack.worksite.chord import Point


@dataclass(frozen=True)
class Verdict:
    """Whether the squad's bases can climb a stay."""

    stay: str
    reasons: tuple[str, ...]  # why not
    unknown: tuple[str, ...]  # data without which it cannot be decided

    @property
    def fits(self) -> bool | None:
        """True, False, or None where data are missing."""
        if self.reasons:
            return False
        return None if self.unknown else True


def holding_force(squad: Squad, radius: float, inclination: float, gravity: Point) -> float:
    """Least palm force that holds a base at its rated pull on a stay (Eq. 17).

    The rated pull is a component along the stay, so it counts as on a vertical one; the base's own weight hangs at the
    stay's inclination and pulls away from the palms, as below the stay. Eq. 17 is linear in the load.

    Args:
        squad: The machine.
        radius: Of the stay [m].
        inclination: Of the stay against the horizontal [rad].
        gravity: Of the worksite (3,) [m/s2].

    Returns:
        The force [N].

    Raises:
        InputError: The palms do not close around that radius.
    """
    base, gripper = squad.base, squad.gripper
    shape = (gripper.friction, gripper.joint_distance, gripper.joint_height)
    loads = ((base.hold_force, 0.5 * math.pi), (base.mass * math.hypot(*gravity), inclination))
    return sum(min_grip_force(load, radius, angle, gripper.palm_length, "+", *shape).min_force for load, angle in loads)


def check(stay: Stay, squad: Squad, gravity: Point) -> Verdict:
    """Compare a stay with the machine's limits; ranges include both ends.

    Weight and tension only shape the curve (a chord is used without them), so they decide nothing here.

    Args:
        stay: A stay.
        squad: The machine.
        gravity: Of the worksite (3,) [m/s2].
    """
    base, reasons, unknown = squad.base, [], []
    low, high = base.stay_diameter
    if stay.diameter is None:
        unknown.append("diameter")
    elif not low <= stay.diameter <= high:
        reasons.append(f"diameter {1e3 * stay.diameter:.4g} mm outside {1e3 * low:.0f}-{1e3 * high:.0f} mm")
    elif (needed := holding_force(squad, 0.5 * stay.diameter, stay.inclination, gravity)) > squad.gripper.force:
        reasons.append(f"palms press {squad.gripper.force:.0f} N, a base at its rated pull needs {needed:.0f} N there")
    if stay.inclination > base.max_inclination:
        limit = math.degrees(base.max_inclination)
        reasons.append(f"inclination {math.degrees(stay.inclination):.1f} deg above {limit:.0f} deg")
    if not stay.free_intervals(0.0, stay.length, base.obstacle_height):
        reasons.append("no stretch free of end zones and obstacles")
    unknown += [
        f"height of the obstacle at {zone.start:.1f}-{zone.end:.1f} m"
        for zone in stay.intervals
        if zone.kind == "obstacle" and zone.height is None
    ]
    return Verdict(stay.id, tuple(reasons), tuple(unknown))
