"""The pipe climber as data: one TOML file decoded once into frozen structs, SI, every value with its source."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from steeplejack.errors import InputError
from steeplejack.robots.sourced import NonNegative, Positive, Sourced, Vector, Window, load_machine

Convention = Literal["text", "equations"]
Neutral = Literal["none", "normal", "home"]

BUILT_IN = "pipe-climber"
SHIPPED = (BUILT_IN, "pipe-climber-cross")
"""Machines with a robot file here, by name."""


class Linkage(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The 3-RPR parallel mechanism (Fig. 3, Table II)."""

    lengths: tuple[Positive, Positive, Positive, Positive]
    convention: Convention
    claw_offset: float
    half_width: NonNegative


class Cylinders(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The three electric cylinders that drive the limbs."""

    reach: Window
    retracted: tuple[Positive, Positive, Positive]
    stroke: Positive
    speed: Positive
    force: Positive
    mass: Positive

    def __post_init__(self) -> None:
        """Refuse a cylinder that has no length in common with what the mechanism uses."""
        super().__post_init__()
        least, largest = self.reach
        for limb, shortest in enumerate(self.retracted, 1):
            if shortest > largest or shortest + self.stroke < least:
                raise ValueError(
                    f"`retracted` of limb {limb} with its stroke, {shortest:g} to {shortest + self.stroke:g} m, "
                    f"does not meet `reach`, {least:g} to {largest:g} m"
                )


class Joints(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Range of the revolute joints at both ends of every limb."""

    limit: Positive
    neutral: Neutral
    home: Vector


class Rcm(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The remote-centre-of-motion parallelogram linkage (Fig. 4)."""

    limit: Positive
    crank: Positive
    coupler: Positive


class Gripper(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One of the two grippers, alike at both ends."""

    force: Positive
    jaws: Annotated[int, msgspec.Meta(ge=1)]
    friction: Positive
    close_time: NonNegative
    pipe_diameter: Window


class Body(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The robot as a whole."""

    mass: Positive


class Build(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Masses, sizes, stiffnesses and sensors that only physics asks for."""

    gripper_mass: Positive
    jaw_mass: Positive
    plate_mass: Positive
    limb_radius: Positive
    jaw_length: Positive
    jaw_width: Positive
    pad_radius: Positive
    jaw_clearance: Positive
    screw_stiffness: Positive
    screw_inertia: Positive
    servo_torque: Positive
    servo_stiffness: Positive
    encoder_step: Positive
    angle_step: Positive
    slip_step: Positive

    @property
    def least_radius(self) -> float:
        """Radius of the pipe that would slip between the pads of one jaw [m]."""
        return 0.5 * self.jaw_width - self.pad_radius

    def jamming_friction(self, radius: float) -> float:
        """Friction at which the pads of one jaw wedge on a pipe, ``cot phi`` [1]; phi as `pads.pad_clock` gives it.

        From there on a pad's friction alone may push its jaw away, pads press one another without bound whatever the
        drive does, and there is no set of wrenches that a grip can give.

        Args:
            radius: Of the pipe, above `least_radius` [m].
        """
        reach, half = radius + self.pad_radius, 0.5 * self.jaw_width
        return math.sqrt((reach - half) * (reach + half)) / half


class Gait(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What a climb asks for beyond the mechanism: how fast moves begin, and what open and closed grippers pass over."""

    ramp: Positive
    turn_speed: Positive
    clearance: Positive
    palm: Positive
    relief: Positive
    reserve: Annotated[float, msgspec.Meta(ge=0.0, lt=1.0)]


class PipeClimber(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The whole machine: gripper, 3-RPR parallel mechanism, RCM linkage, gripper."""

    name: str
    linkage: Linkage
    cylinders: Cylinders
    joints: Joints
    rcm: Rcm
    gripper: Gripper
    body: Body
    gait: Gait
    build: Build

    def __post_init__(self) -> None:
        """Refuse pipes that slip between the pads of a jaw, friction that makes pads jam, a linkage that folds."""
        thinnest, least = self.gripper.pipe_diameter[0], 2.0 * self.build.least_radius
        if not thinnest > least:
            raise InputError("`gripper.pipe_diameter`", f"from {thinnest:g} m", f"above {least:g} m")
        most = self.build.jamming_friction(0.5 * thinnest)
        if not self.gripper.friction < most:
            valid = f"below {most:.4g}, where pads jam on a pipe of {1e3 * thinnest:g} mm"
            raise InputError("`gripper.friction`", f"{self.gripper.friction:g}", valid)
        if not self.rcm.limit < 0.5 * math.pi:
            raise InputError("`rcm.limit`", f"{self.rcm.limit:g} rad", "below pi / 2, where the parallelogram is flat")


def load_pipe_climber(robot: str | Path = BUILT_IN) -> PipeClimber:
    """Read a pipe climber from its built-in name or a TOML file.

    Args:
        robot: ``pipe-climber``, another of `SHIPPED`, or the path of a TOML file of the same form.

    Returns:
        The machine, frozen, SI.

    Raises:
        InputError: No such robot or file, or a field that cannot be used; the message names it.
    """
    return load_machine(robot, SHIPPED, "steeplejack.robots.pipe_climber", PipeClimber)
