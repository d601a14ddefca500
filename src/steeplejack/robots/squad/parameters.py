"""CCRobot-S as data: one TOML file decoded once into frozen structs, SI, every value with its source.

Each table of the file carries a second table ``source`` with the same keys. A value without a source, an unknown key,
a negative mass or a window upside down is refused with the path of the field.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Annotated

import msgspec

from steeplejack.errors import InputError

Vector = tuple[float, float, float]
Window = tuple[float, float]
Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NonNegative = Annotated[float, msgspec.Meta(ge=0.0)]


class Sourced(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of values, each with its source or the word "estimate"."""

    source: dict[str, str]

    def __post_init__(self) -> None:
        """Refuse a value without a source and a window upside down."""
        names = {field for field in self.__struct_fields__ if field != "source"}
        for name in sorted(names ^ set(self.source)):
            raise ValueError(f"`{name}` needs both a value and an entry under `source`")
        for name in sorted(names):
            value = getattr(self, name)
            if isinstance(value, tuple) and len(value) == 2 and not value[0] < value[1]:  # pyright: ignore
                raise ValueError(f"`{name}` = {list(value)} is upside down")  # pyright: ignore[reportUnknownArgumentType]


class Platform(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Flying platform; its frame sits in the middle of the attachment square, z towards the stays."""

    mass: Positive
    size: tuple[Positive, Positive, Positive]
    inertia: tuple[Positive, Positive, Positive]
    centre_of_mass: Vector
    attachments: tuple[Vector, Vector, Vector, Vector]
    clearance: Positive


class Camera(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Inspection camera looking along the platform's z axis."""

    field_of_view: Positive
    stand_off: Window
    max_incidence: Positive
    faced_half_sector: Positive


class Base(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Movable anchor base: drives and grips on a stay, carries a winch."""

    mass: Positive
    hold_force: Positive
    drive_force: Positive
    twist_torque: Positive
    exit_offset: NonNegative
    length: Positive
    max_speed: Positive
    max_acceleration: Positive
    max_turn_rate: Positive
    spacing: Positive
    obstacle_height: NonNegative
    stay_diameter: Window
    max_inclination: Positive
    encoder_step: Positive
    clock_bias: NonNegative
    clock_noise: NonNegative
    clock_step: Positive
    wheel_brake: NonNegative
    ring_camera: bool
    odometry_drift: NonNegative


class Gripper(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Palm gripper of an anchor base (Fig. 10, Eq. 16-17)."""

    friction: Positive
    joint_distance: Positive
    joint_height: Positive
    palm_length: Positive
    force: Positive
    close_time: Positive
    palm_noise: NonNegative


class Winch(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Quasi-direct-drive winch with a brake that closes without power."""

    ratio: Positive
    drum_radius: Positive
    rotor_inertia: Positive
    max_torque: Positive
    torque_constant: Positive
    friction: NonNegative
    brake_torque: Positive
    encoder_counts: Positive
    current_noise: NonNegative
    torque_scale_error: NonNegative
    max_speed: Positive
    stored_length: Positive


class Cable(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Driving cable."""

    axial_stiffness: Positive
    damping_time: NonNegative
    tension: tuple[NonNegative, Positive]


class Motion(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Speeds and accelerations the squad moves with."""

    speed: Positive
    acceleration: Positive
    transit_speed: Positive
    drive_speed: Positive


class Controller(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Gains of the platform controller."""

    stiffness: Positive
    damping: Positive
    yaw_stiffness: Positive
    yaw_damping: Positive
    drive_stiffness: Positive
    drive_damping: Positive
    tension_filter: Positive
    stretch_filter: Positive
    length_noise: Positive
    force_noise: Positive
    moment_noise: Positive


class Safety(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How far readings and commands may stray before the squad stops on its brakes."""

    tension_excess: NonNegative
    slack_share: Positive
    pull_allowance: NonNegative
    fence: Positive
    imbalance: Positive
    creep: Positive
    turn: Positive


class Simulation(Sourced, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What the physics needs beyond the machine itself."""

    drag_density: NonNegative


class Squad(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The whole machine: four anchor bases, four driving cables, a flying platform."""

    name: str
    platform: Platform
    camera: Camera
    base: Base
    gripper: Gripper
    winch: Winch
    cable: Cable
    motion: Motion
    controller: Controller
    safety: Safety
    simulation: Simulation


BUILT_IN = "ccrobot-s"


def load_squad(robot: str | Path = BUILT_IN) -> Squad:
    """Read a squad from its built-in name or a TOML file.

    Args:
        robot: ``ccrobot-s`` or the path of a TOML file of the same form.

    Returns:
        The machine, frozen, SI.

    Raises:
        InputError: No such robot or file, or a field that cannot be used; the message names it.
    """
    if str(robot) == BUILT_IN:
        text = files("steeplejack.robots.squad").joinpath("ccrobot_s.toml").read_bytes()
    else:
        try:
            text = Path(robot).read_bytes()
        except OSError as error:
            raise InputError(
                str(robot), error.strerror or "cannot be read", f"a TOML robot file or {BUILT_IN}"
            ) from None
    try:
        return msgspec.toml.decode(text, type=Squad)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError(
            str(robot), str(error).replace("\n", " "), "see the built-in ccrobot_s.toml for every field"
        ) from None
