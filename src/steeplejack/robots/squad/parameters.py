"""CCRobot-S as data: one TOML file decoded once into frozen structs, SI, every value with its source."""

from __future__ import annotations

from pathlib import Path

import msgspec

from steeplejack.robots.sourced import NonNegative, Positive, Sourced, Vector, Window, load_machine


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
    return load_machine(robot, (BUILT_IN,), "steeplejack.robots.squad", Squad)
