"""Inverse kinematics of the 3-RPR mechanism: limb lengths and angles from poses, and which limit a pose breaks.

With ``d_i = P_i - B_i = (x + p_i cos a - b_i, w - p_i sin a)`` the length of limb i is ``q_i = |d_i|`` (Ye et al.,
Robotica 2024, Eq. 8 with beta = 0). With beta Eq. 8 asks of the limbs what they cannot do: their hinges hold the
platform's y axis parallel to Y, so beta belongs to the linkage behind the platform, and D drops out.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.poses import Array, triples

ROUNDING = 1e-12
"""What a length or an angle may exceed its limit by and still hold it: rounding, in parts of the limit."""


def limb_lengths(layout: Layout, poses: ArrayLike) -> Array:
    """Lengths of the three limbs ``q_i = |P_i - B_i|``.

    Args:
        layout: Hinges.
        poses: (x, w, alpha) of O2, (..., 3) [m, m, rad].

    Returns:
        (..., 3) [m]; NaN where a pose is not finite.

    Raises:
        InputError: Not (..., 3) numbers.
    """
    given = triples("poses", poses)
    lengths = np.empty((given.size // 3, 3))
    _lengths(np.ascontiguousarray(given).reshape(-1, 3), layout.base, layout.platform, lengths)
    return lengths.reshape(given.shape)


def limb_vectors(layout: Layout, poses: ArrayLike) -> Array:
    """Vectors ``d_i = P_i - B_i`` of the limbs in the plane X-Z.

    Args:
        layout: Hinges.
        poses: (..., 3) [m, m, rad].

    Returns:
        (..., 3 limbs, 2) [m].
    """
    given = triples("poses", poses)
    x, w, alpha = (given[..., axis, None] for axis in range(3))
    along_x = x + layout.platform * np.cos(alpha) - layout.base
    return np.stack((along_x, w - layout.platform * np.sin(alpha)), axis=-1)


def hinge_angles(layout: Layout, poses: ArrayLike, counted: Literal["normal", "home"] = "normal") -> Array:
    """Turn of the hinges at both ends of every limb.

    At B_i the angle of the limb from Z, ``theta_i = atan2(d_x, d_z)``; at P_i its angle from the platform's normal,
    ``theta_i - alpha``, both about Y. Angles lie in (-pi, pi].

    Args:
        layout: Hinges, and the home pose.
        poses: (..., 3) [m, m, rad].
        counted: From the normals of the platforms, or from the angles at the layout's home pose.

    Returns:
        (..., 3 limbs, 2 ends: base, platform) [rad].
    """
    turn = _from_normals(layout, triples("poses", poses))
    if counted == "home":
        turn = turn - _from_normals(layout, np.asarray(layout.home))
    return _wrapped(turn)


def _from_normals(layout: Layout, poses: Array) -> Array:
    vectors = limb_vectors(layout, poses)
    theta = np.arctan2(vectors[..., 0], vectors[..., 1])
    return _wrapped(np.stack((theta, theta - poses[..., 2, None]), axis=-1))


def _wrapped(angles: Array) -> Array:
    """Angles in (-pi, pi]."""
    return math.pi - np.mod(math.pi - angles, 2.0 * math.pi)


class Excess(NamedTuple):
    """A limit that a pose does not hold."""

    limb: int  # 1 to 3
    what: Literal["length", "hinge at the base", "hinge at the platform"]
    value: float  # [m] or [rad]
    limit: float  # [m] or [rad], the bound that is exceeded

    def __str__(self) -> str:
        """For example "length of limb 2 is 0.251 m, largest 0.24 m"."""
        if self.what == "length":
            side = "least" if self.value < self.limit else "largest"
            return f"length of limb {self.limb} is {self.value:.6g} m, {side} {self.limit:g} m"
        given, bound = (math.degrees(angle) for angle in (self.value, self.limit))
        return f"{self.what} of limb {self.limb} is turned {given:.5g} deg, limit {bound:.5g} deg"


def exceeded(layout: Layout, pose: ArrayLike) -> list[Excess]:
    """The limits one pose does not hold: lengths of the limbs, and turns of the hinges if the layout limits them.

    Args:
        layout: Hinges and limits.
        pose: (3,) [m, m, rad].

    Returns:
        One entry a limit, lengths first; empty if the pose can be taken.
    """
    found = exceeded_lengths(layout, limb_lengths(layout, pose))
    if layout.neutral == "none":
        return found
    bound = layout.joint_limit
    for limb, ends in enumerate(hinge_angles(layout, pose, layout.neutral).tolist(), 1):
        for what, turn in zip(("hinge at the base", "hinge at the platform"), ends, strict=True):
            if abs(turn) > bound * (1.0 + ROUNDING):
                found.append(Excess(limb, what, turn, math.copysign(bound, turn)))
    return found


def exceeded_lengths(layout: Layout, lengths: ArrayLike) -> list[Excess]:
    """Lengths of three limbs (3,) [m] that are outside the layout's reach, one entry each."""
    least, largest = layout.reach
    found: list[Excess] = []
    for limb, length in enumerate(triples("lengths", lengths).tolist(), 1):
        if length < least * (1.0 - ROUNDING):
            found.append(Excess(limb, "length", length, least))
        elif length > largest * (1.0 + ROUNDING):
            found.append(Excess(limb, "length", length, largest))
    return found


@njit(cache=True)
def _lengths(poses: Array, base: Array, platform: Array, lengths: Array) -> None:
    """``limb_lengths`` over (k, 3) poses; fills ``lengths``. B_1 and P_2 sit at the origins of their frames."""
    p1, p3, b2, b3 = platform[0], platform[2], base[1], base[2]
    for k in range(poses.shape[0]):
        x, w, alpha = poses[k, 0], poses[k, 1], poses[k, 2]
        c, s = math.cos(alpha), math.sin(alpha)
        u1, v1 = x + p1 * c, w - p1 * s
        u3, v3 = x + p3 * c - b3, w - p3 * s
        lengths[k, 0] = math.sqrt(u1 * u1 + v1 * v1)
        lengths[k, 1] = math.sqrt((x - b2) * (x - b2) + w * w)
        lengths[k, 2] = math.sqrt(u3 * u3 + v3 * v3)
