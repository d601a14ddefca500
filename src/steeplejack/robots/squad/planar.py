"""CCRobot-S in the plane of its stays: the machine's attachments bound to four anchors (Table III and Eq. 2-18).

Pose ``(x, y, phi)`` with x along the bridge and y up; wrenches ``(fx, fy, mz)``. The platform's reference point p is
its centre of mass, so the weight acts at p and attachments count from there. Source: Zheng et al., CCRobot-S, IEEE
T-RO.

Range of validity: all four cables in one plane, taut and straight. Real stays are not coplanar; see
`steeplejack.mechanics.cable` for the spatial equilibria.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.pose.every_pose import every_planar_pose
from steeplejack.mechanics.cable.pose.forward import ForwardKinematics, forward_kinematics
from steeplejack.mechanics.cable.region.grid import best_node
from steeplejack.mechanics.cable.structure import planar_lengths, planar_structure_matrix
from steeplejack.mechanics.cable.tension.distribution import Method, TensionDistribution, distribute
from steeplejack.mechanics.cable.wrench.closure import in_wrench_closure, tension_factor
from steeplejack.robots.squad.dynamics import planar_weight
from steeplejack.robots.squad.parameters import Squad

Array = NDArray[np.float64]
Window = tuple[float, float]

ORIENTATIONS = np.deg2rad(np.arange(-180.0, 180.0, 5.0))  # [rad] searched for a start of forward kinematics
ON_STAY = 1e-3  # [1] distance from a stay, relative to the anchors' box, up to which an anchor sits on it


def planar_attachments(squad: Squad) -> Array:
    """Cable attachments from the platform's centre of mass, in its own plane.

    Args:
        squad: The machine.

    Returns:
        ``lB_i`` of cables 1..4, (4, 2) [m].
    """
    return np.array(squad.platform.attachments)[:, :2] - np.array(squad.platform.centre_of_mass)[:2]


@dataclass(frozen=True, eq=False)
class PlanarSquad:
    """Four anchors and a platform on four driving cables in one plane.

    Attributes:
        anchors: ``A_i`` where driving cables 1..4 leave their anchor bases, (4, 2) [m].
        attachments: ``lB_i`` in the platform frame from p, (4, 2) [m].
    """

    anchors: Array
    attachments: Array

    @classmethod
    def of(cls, squad: Squad, anchors: ArrayLike) -> PlanarSquad:
        """Bind a machine to anchors.

        Args:
            squad: The machine.
            anchors: (4, 2) [m].

        Returns:
            The bound robot.

        Raises:
            InputError: Anchors are not four finite points.
        """
        points = np.array(anchors, dtype=np.float64)
        if points.shape != (4, 2) or not np.isfinite(points).all():
            raise InputError("anchors", f"shape {points.shape}", "four finite points, (4, 2) in metres")
        return cls(points, planar_attachments(squad))

    def lengths(self, pose: ArrayLike) -> Array:
        """Cable lengths (Eq. 2-4) of poses (..., 3), (..., 4) [m]."""
        return planar_lengths(self.anchors, self.attachments, pose)

    def structure(self, pose: ArrayLike) -> Array:
        """Structure matrix ``J^T`` (Eq. 6, arm rotated) of poses (..., 3), (..., 3, 4)."""
        return planar_structure_matrix(self.anchors, self.attachments, pose)

    def tension_factor(self, pose: ArrayLike) -> Array:
        """Tension factor (Eq. 12) of poses (..., 3), 0 outside wrench closure, (...) [1]."""
        return tension_factor(self.structure(pose))

    def in_wrench_closure(self, pose: ArrayLike) -> NDArray[np.bool_]:
        """Wrench closure (Eq. 11) of poses (..., 3), (...)."""
        return in_wrench_closure(self.structure(pose))

    def tensions(
        self, pose: ArrayLike, mass: float, window: Window, gravity: ArrayLike, method: Method = "min-max"
    ) -> TensionDistribution:
        """Tensions that hold a mass at rest (Eq. 7).

        Args:
            pose: (..., 3) [m, m, rad].
            mass: Of the platform with its load, at p [kg].
            window: Least and greatest tension [N].
            gravity: Of the worksite, (2,) [m/s2].
            method: Which of the feasible tensions.

        Returns:
            The distribution with margin and certificate; its wrench rows are ``(fx, fy, mz)``.
        """
        return distribute(self.structure(pose), planar_weight(mass, gravity), window[0], window[1], method)

    def pose(
        self, lengths: ArrayLike, start: ArrayLike | None = None, tolerance: float | None = None
    ) -> ForwardKinematics:
        """Pose from cable lengths under load (Eq. 18); unique where no other at all explains them, proved.

        Args:
            lengths: (4,) [m].
            start: (3,); by default the best tension factor on a coarse grid over all orientations.
            tolerance: Residual that still explains the lengths [m]; by default a thousandth of the longest.

        Returns:
            The pose with residual, iterations and uniqueness.

        Raises:
            InputError: Lengths are not four positive finite numbers.
        """
        measured = np.array(lengths, dtype=np.float64)
        if measured.shape != (4,) or not np.all((measured > 0.0) & np.isfinite(measured)):
            raise InputError("lengths", f"{np.ravel(measured).tolist()}", "four positive finite lengths in metres")
        begin = best_node(self.anchors, self.attachments, ORIENTATIONS)[0] if start is None else start
        found = forward_kinematics(measured, self.anchors, self.attachments, begin, tolerance)
        every = every_planar_pose(
            measured, self.anchors, self.attachments, tolerance=tolerance or 1e-3 * float(measured.max())
        )
        return replace(found, unique=found.unique and every.unique)


def stay_directions(anchors: ArrayLike, stays: Mapping[str, tuple[float, float]]) -> Array:
    """Direction of the stay each anchor sits on: the one along which its base would slip.

    Args:
        anchors: (m, 2) [m].
        stays: Lines ``y = slope x + intercept`` by stay id, slope [1] and intercept [m].

    Returns:
        Unit vectors, (m, 2) [1].

    Raises:
        InputError: An anchor lies on none of the stays.
    """
    points = np.asarray(anchors, dtype=np.float64)
    slopes, intercepts = np.array(list(stays.values()), dtype=np.float64).reshape(-1, 2).T
    scale = np.hypot(1.0, slopes)
    offsets = np.abs(points[:, 1, None] - slopes * points[:, 0, None] - intercepts) / scale
    nearest = np.argmin(offsets, axis=1)
    for index, offset in enumerate(offsets[np.arange(len(points)), nearest]):
        if offset > ON_STAY * np.ptp(points, axis=0).max():
            raise InputError(f"anchor {index + 1}", f"{offset:.3g} m off the nearest stay", "on one of the stays")
    return np.stack((1.0 / scale, slopes / scale), axis=-1)[nearest]
