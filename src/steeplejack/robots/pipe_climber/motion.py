"""Motions of the claw, and the limbs along them: Eq. 27 as printed and as it must read, or any polynomials of time.

`motion_file` reads motions, `sampled_motion` has those that are known by samples alone. Whatever gives coordinates with
two derivatives, and the polynomials it is made of, is a motion (`Trajectory`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.joints import joint_accelerations, joint_rates
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.poses import Array, Offset

DURATION = 10.0
"""Of Eq. 27 [s]."""


class Piece(NamedTuple):
    """A stretch of a motion in which x, z and alpha are polynomials of the time since it began."""

    begin: float  # [s]
    end: float  # [s]
    polynomials: tuple[ArrayLike, ArrayLike, ArrayLike]  # rising powers [m, m, rad]


class Trajectory(Protocol):
    """A motion of the claw's centre relative to the base: what limbs and limits need to know of one."""

    @property
    def name(self) -> str:
        """For people."""
        ...

    @property
    def duration(self) -> float:
        """It runs from t = 0 to this [s]."""
        ...

    @property
    def offset(self) -> Offset:
        """Whether hz turns with alpha or lies along Z, as Eq. 8 has it."""
        ...

    def coordinates(self, times: Array) -> Array:
        """x, z, alpha and beta with two derivatives at times (...), (..., 4, 3) [m, m, rad, rad; per s; per s2]."""
        ...

    def pieces(self) -> Iterator[Piece]:
        """What it is made of, in the order of time."""
        ...


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

    def coordinates(self, times: Array) -> Array:
        """x, z, alpha and beta with two derivatives at times (...), (..., 4, 3)."""
        return np.stack([_with_derivatives(one, times) for one in (self.x, self.z, self.alpha, self.beta)], axis=-2)

    def pieces(self) -> Iterator[Piece]:
        """One."""
        yield Piece(0.0, self.duration, (self.x, self.z, self.alpha))


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


def states(motion: Trajectory, times: ArrayLike, claw_offset: float) -> PoseState:
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
    x, z, alpha, beta = np.moveaxis(motion.coordinates(given), -2, 0).copy()
    if motion.offset == "along-z":
        z[..., 0] -= claw_offset
    else:
        sine, cosine = np.sin(alpha[..., 0]), np.cos(alpha[..., 0])
        rate, second = alpha[..., 1], alpha[..., 2]
        x -= claw_offset * np.stack((sine, cosine * rate, cosine * second - sine * rate**2), axis=-1)
        z -= claw_offset * np.stack((cosine, -sine * rate, -sine * second - cosine * rate**2), axis=-1)
    pose, velocity, acceleration = (np.stack((x[..., k], z[..., k], alpha[..., k]), axis=-1) for k in range(3))
    return PoseState(pose, velocity, acceleration, beta)


def limb_states(layout: Layout, motion: Trajectory, times: ArrayLike, claw_offset: float) -> tuple[Array, Array, Array]:
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


def _with_derivatives(coefficients: tuple[float, ...], times: Array) -> Array:
    """A polynomial with its first and second derivative, (..., 3)."""
    orders = [np.polynomial.polynomial.polyder(np.asarray(coefficients), order) for order in range(3)]
    values = [np.polynomial.polynomial.polyval(times, one) for one in orders]
    return np.asarray(np.stack(values, axis=-1), dtype=np.float64)


def _metres(*millimetres: float) -> tuple[float, ...]:
    return tuple(1e-3 * one for one in millimetres)


def _radians(*degrees: float) -> tuple[float, ...]:
    return tuple(math.radians(one) for one in degrees)
