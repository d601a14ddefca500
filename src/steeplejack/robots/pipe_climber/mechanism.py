"""The pipe climber as linkages, for the analysis of mobility: the 3-RPR mechanism, the RCM linkage, the whole robot.

The frame has Z along the pipe and the hinges of the limbs parallel to Y. Limbs 1 and 2 lie a half width either side of
limb 3 (Table II). Three slips of the paper: Eq. 1 orders the joint twists (omega; v), as here, but Eq. 3 the platform's
twists (v; omega), which in the order of Eq. 1 would be the complement of what is meant; and what Eq. 2 calls motion
screws are wrenches, ordered (force; moment): couples about X and Z and a force along Y, the same from every limb.
"""

from __future__ import annotations

import math
from typing import Literal

from steeplejack.errors import InputError
from steeplejack.mechanics.limb import Joint, Linkage
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.linkage import linkage_joints
from steeplejack.robots.pipe_climber.parameters import PipeClimber, Rcm

End = Literal["lower", "upper"]
Pose = tuple[float, float, float]
Vector = tuple[float, float, float]

PAPER = "Ye et al., Robotica 2024"
Y_AXIS, Z_AXIS = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
LOWER, PLATE, UPPER = "lower_gripper", "lower_plate", "upper_gripper"


def parallel_mechanism(layout: Layout, half_width: float, pose: Pose | None = None) -> Linkage:
    """The 3-RPR mechanism between the lower plate and the upper gripper (Fig. 3).

    Args:
        layout: Hinges of the limbs.
        half_width: D, distance of limbs 1 and 2 from the middle plane [m].
        pose: (x, w, alpha) of the reference configuration [m, m, rad]; the home pose by default.

    Returns:
        The linkage, the lower plate fixed, its cylinders actuated.

    Raises:
        InputError: A pose that is not finite or that leaves a limb without length.
    """
    joints = tuple(joint for limb in range(3) for joint in _limb(layout, half_width, pose or layout.home, limb))
    limbs = tuple(link for number in (1, 2, 3) for link in (f"cylinder_{number}", f"rod_{number}"))
    return Linkage(
        name="3-rpr",
        description="parallel mechanism of the pipe climber",
        source=f"{PAPER}, section 3, Fig. 3",
        links=(PLATE, UPPER, *limbs),
        base=PLATE,
        output=UPPER,
        joints=joints,
    )


def rcm_linkage(rcm: Rcm, turn: float = 0.0, height: float = 0.0) -> Linkage:
    """The remote-centre-of-motion linkage between the lower gripper and the lower plate (Fig. 4).

    G1 and G2 are bars hinged in their middles on the gripper, a coupler's length apart either side of the pipe; G3 and
    G4 join their ends, and the plate is hinged to the middles of G3 and G4. The plate is a third bar parallel to G1 and
    G2 whose own middle, the remote centre on the pipe's axis, needs no hinge. Any one of the four corner hinges could
    be left out without a freedom gained: that is where its two redundant constraints come from.

    Args:
        rcm: Lengths.
        turn: beta of the reference configuration, within 90 degrees [rad].
        height: Of its plane over the frame's origin [m].

    Returns:
        The linkage, the lower gripper fixed, bar G1 actuated; the origin lies on the pipe's axis.

    Raises:
        InputError: A turn at or beyond the fold, or not a number.
    """
    hinges = (
        ("M1", LOWER, "G1"),
        ("M2", LOWER, "G2"),
        ("A1", "G1", "G3"),
        ("A2", "G2", "G3"),
        ("C1", "G1", "G4"),
        ("C2", "G2", "G4"),
        ("E3", "G3", PLATE),
        ("E4", "G4", PLATE),
    )
    places = linkage_joints(rcm, turn).tolist()

    return Linkage(
        name="rcm",
        description="remote-centre-of-motion linkage of the pipe climber",
        source=f"{PAPER}, section 3, Fig. 4; bars arranged from the text",
        links=(LOWER, "G1", "G2", "G3", "G4", PLATE),
        base=LOWER,
        output=PLATE,
        joints=tuple(
            Joint(
                name=name,
                kind="revolute",
                links=(first, second),
                axis=Z_AXIS,
                point=(x, y, height),
                actuated=name == "M1",
            )
            for (name, first, second), (x, y) in zip(hinges, places, strict=True)
        ),
    )


def whole_robot(robot: PipeClimber, layout: Layout | None = None, fixed: End = "lower") -> Linkage:
    """RCM linkage and 3-RPR mechanism in series, one gripper holding the pipe and the other one free.

    Args:
        robot: The machine.
        layout: Hinges of its limbs where other than the machine's own.
        fixed: Which gripper holds the pipe.

    Returns:
        The linkage at the home pose.
    """
    upper = parallel_mechanism(Layout.of(robot) if layout is None else layout, robot.linkage.half_width)
    lower = rcm_linkage(robot.rcm, height=-robot.rcm.coupler)
    ends = (LOWER, UPPER) if fixed == "lower" else (UPPER, LOWER)
    return Linkage(
        name="pipe-climber",
        description="the pipe climber, one gripper holding the pipe and the other one free",
        source=f"{PAPER}, section 3",
        links=(*lower.links, *(link for link in upper.links if link != PLATE)),
        base=ends[0],
        output=ends[1],
        joints=(*lower.joints, *upper.joints),
    )


def _limb(layout: Layout, half_width: float, pose: Pose, limb: int) -> tuple[Joint, Joint, Joint]:
    """Hinge on the lower plate, cylinder, hinge on the upper gripper."""
    x, w, alpha = pose
    if not all(map(math.isfinite, (*pose, half_width))):
        raise InputError("pose", f"{x:g} {w:g} {alpha:g}", "finite X and W in metres and ALPHA")
    y = (half_width, -half_width, 0.0)[limb]
    arm = float(layout.platform[limb])
    base: Vector = (float(layout.base[limb]), y, 0.0)
    platform: Vector = (x + arm * math.cos(alpha), y, w - arm * math.sin(alpha))
    along: Vector = (platform[0] - base[0], 0.0, platform[2])
    number = limb + 1
    body, rod = f"cylinder_{number}", f"rod_{number}"
    return (
        Joint(name=f"B{number}", kind="revolute", links=(PLATE, body), axis=Y_AXIS, point=base),
        Joint(name=f"Q{number}", kind="prismatic", links=(body, rod), axis=along, actuated=True),
        Joint(name=f"P{number}", kind="revolute", links=(rod, UPPER), axis=Y_AXIS, point=platform),
    )
