"""Motions of the claw as polynomials of time: Eq. 27 as printed and as it must read, or any other from a file.

A motion file is TOML, coefficients in rising powers of t [s]:

    name = "lift"
    duration_s = 2.0
    offset = "turning"               # hz turns with alpha, or "along-z" as in Eq. 8 (default "turning")
    x_m = [0.0]
    z_m = [0.150, 0.0, 0.075, -0.025]
    alpha_deg = [0.0]
    beta_deg = [0.0]                 # optional, as alpha_deg is

Samples are better fitted before they come here: velocity and acceleration are derivatives of what is given.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.joints import joint_accelerations, joint_rates
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.poses import Array, Offset

Coefficients = Annotated[tuple[float, ...], msgspec.Meta(min_length=1)]

DURATION = 10.0
"""Of Eq. 27 [s]."""
SHORTEST, LONGEST = 1e-3, 1e6
"""Durations a motion may have [s]."""
LARGEST = 1e6
"""What each term of a polynomial may come to within the motion, in the file's unit: no machine, and no overflow."""


class MotionFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The file as it is written, lengths in metres and angles in degrees."""

    name: str
    duration_s: Annotated[float, msgspec.Meta(gt=0.0)]
    x_m: Coefficients
    z_m: Coefficients
    alpha_deg: Coefficients = (0.0,)
    beta_deg: Coefficients = (0.0,)
    offset: Offset = "turning"


@dataclass(frozen=True)
class Motion:
    """A motion of the claw's centre relative to the base, each coordinate a polynomial of time.

    Attributes:
        name: For people.
        duration: It runs from t = 0 to this [s].
        x: Coefficients in rising powers of t [m].
        z: Of the claw's centre, hz included [m].
        alpha: [rad].
        beta: Of the linkage [rad].
        offset: Whether hz turns with alpha or lies along Z, as Eq. 8 has it.
    """

    name: str
    duration: float
    x: tuple[float, ...]
    z: tuple[float, ...]
    alpha: tuple[float, ...] = (0.0,)
    beta: tuple[float, ...] = (0.0,)
    offset: Offset = "turning"


@dataclass(frozen=True)
class PoseState:
    """Poses of O2 with two derivatives, and the turn of the linkage.

    Attributes:
        pose: (x, w, alpha), (..., 3) [m, m, rad].
        velocity: (..., 3) [m/s, m/s, rad/s].
        acceleration: (..., 3) [m/s2, m/s2, rad/s2].
        beta: Turn of the linkage with two derivatives, (..., 3) [rad, rad/s, rad/s2].
    """

    pose: Array
    velocity: Array
    acceleration: Array
    beta: Array


def eq27() -> Motion:
    """Eq. 27 of Ye et al. (Robotica 2024) with alpha's last coefficient 9/20: rest to rest in 10 s."""
    return _eq27("eq27", 9.0 / 20.0)


def eq27_printed() -> Motion:
    """Eq. 27 as printed, alpha's last coefficient 9/80: it ends at -292.5 deg and -101 deg/s."""
    return _eq27("eq27-printed", 9.0 / 80.0)


def _eq27(name: str, last: float) -> Motion:
    """Eq. 27; x and z in millimetres there, and hz along Z as in Eq. 8."""
    return Motion(
        name,
        DURATION,
        _metres(20.0, 0.0, 0.0, 3.0 / 5.0, -9.0 / 100.0, 9.0 / 2500.0),
        _metres(200.0, 0.0, 0.0, 7.0 / 5.0, -21.0 / 100.0, 21.0 / 2500.0),
        _radians(0.0, 0.0, 0.0, last, -27.0 / 400.0, 27.0 / 10000.0),
        _radians(0.0, 0.0, 0.0, 3.0 / 20.0, -9.0 / 400.0, 9.0 / 10000.0),
        "along-z",
    )


def load_motion(motion: str | Path) -> Motion:
    """A motion by name, ``eq27`` or ``eq27-printed``, or from a TOML file.

    Raises:
        InputError: No such file, an unknown or missing key, a number that is not finite or of no machine.
    """
    if str(motion) in ("eq27", "eq27-printed"):
        return eq27() if str(motion) == "eq27" else eq27_printed()
    try:
        text = Path(motion).read_bytes()
    except OSError as error:
        raise InputError(str(motion), error.strerror or "cannot be read", "eq27, eq27-printed or a TOML file") from None
    try:
        given = msgspec.toml.decode(text, type=MotionFile)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        valid = "name, duration_s, x_m, z_m and, optional, alpha_deg, beta_deg, offset"
        raise InputError(str(motion), str(error).replace("\n", " "), valid) from None
    _require_sizes(str(motion), given)
    alpha, beta = _radians(*given.alpha_deg), _radians(*given.beta_deg)
    return Motion(given.name, given.duration_s, given.x_m, given.z_m, alpha, beta, given.offset)


def states(motion: Motion, times: ArrayLike, claw_offset: float) -> PoseState:
    """Pose of O2 and its derivatives along a motion of the claw.

    Args:
        motion: Of the claw's centre.
        times: (...), within the motion [s].
        claw_offset: hz [m].

    Returns:
        What the limbs have to follow.

    Raises:
        InputError: A time before the motion begins or after it ends.
    """
    given = np.asarray(times, dtype=np.float64)
    if not ((given >= 0.0) & (given <= motion.duration)).all():
        worst = float(given.flat[np.argmax(~((given >= 0.0) & (given <= motion.duration)))])
        raise InputError("time", f"{worst:g} s", f"within the motion, 0 to {motion.duration:g} s")
    x, z, alpha, beta = (_with_derivatives(one, given) for one in (motion.x, motion.z, motion.alpha, motion.beta))
    if motion.offset == "along-z":
        z[..., 0] -= claw_offset
    else:
        sine, cosine = np.sin(alpha[..., 0]), np.cos(alpha[..., 0])
        rate, second = alpha[..., 1], alpha[..., 2]
        x -= claw_offset * np.stack((sine, cosine * rate, cosine * second - sine * rate**2), axis=-1)
        z -= claw_offset * np.stack((cosine, -sine * rate, -sine * second - cosine * rate**2), axis=-1)
    pose, velocity, acceleration = (np.stack((x[..., k], z[..., k], alpha[..., k]), axis=-1) for k in range(3))
    return PoseState(pose, velocity, acceleration, beta)


def limb_states(layout: Layout, motion: Motion, times: ArrayLike, claw_offset: float) -> tuple[Array, Array, Array]:
    """Lengths, speeds and accelerations of the limbs along a motion.

    Args:
        layout: Hinges.
        motion: Of the claw's centre.
        times: (...), within the motion [s].
        claw_offset: hz [m].

    Returns:
        Each (..., 3) [m], [m/s], [m/s2].
    """
    state = states(motion, times, claw_offset)
    rates = joint_rates(layout, state.pose, state.velocity)
    seconds = joint_accelerations(layout, state.pose, state.velocity, state.acceleration)
    return limb_lengths(layout, state.pose), rates[..., 1], seconds[..., 1]


def _require_sizes(where: str, given: MotionFile) -> None:
    """Refuse numbers that are not finite, and those so large that no polynomial of a machine has them."""
    fields = ("x_m", "z_m", "alpha_deg", "beta_deg")
    for field in ("duration_s", *fields):
        if not np.isfinite(getattr(given, field)).all():
            raise InputError(where, f"`{field}` is not finite", "finite numbers")
    if not SHORTEST <= given.duration_s <= LONGEST:
        raise InputError(where, f"`duration_s` is {given.duration_s:g} s", f"{SHORTEST:g} to {LONGEST:g} s")
    for field in fields:
        for power, one in enumerate(getattr(given, field)):
            # In logarithms, because the power itself may overflow.
            if one and math.log10(abs(one)) + power * math.log10(given.duration_s) > math.log10(LARGEST):
                what = f"`{field}` has {one:g} t^{power}, with t up to {given.duration_s:g} s"
                raise InputError(where, what, f"terms of at most {LARGEST:g} within the motion")


def _with_derivatives(coefficients: tuple[float, ...], times: Array) -> Array:
    """A polynomial with its first and second derivative, (..., 3)."""
    orders = [np.polynomial.polynomial.polyder(np.asarray(coefficients), order) for order in range(3)]
    values = [np.polynomial.polynomial.polyval(times, one) for one in orders]
    return np.asarray(np.stack(values, axis=-1), dtype=np.float64)


def _metres(*millimetres: float) -> tuple[float, ...]:
    return tuple(1e-3 * one for one in millimetres)


def _radians(*degrees: float) -> tuple[float, ...]:
    return tuple(math.radians(one) for one in degrees)
