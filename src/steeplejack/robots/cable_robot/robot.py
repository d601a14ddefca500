"""A cable robot bound to the mechanics: cables from anchors in the world to attachments on one rigid platform.

Planar robots take the pose ``(x, y, phi)`` and wrenches ``(fx, fy, mz)``; spatial robots take a position and a rotation
matrix from platform to world, and wrenches ``(moment; force)``. Moments, twists and mass matrices are about the origin
of the platform frame, world axes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import finite, leading, one, rotation_matrices, vectors
from steeplejack.mechanics.cable.pulleys import pulley_runs
from steeplejack.mechanics.cable.region.oriented import PoseQuestion, pose_question
from steeplejack.mechanics.cable.rest.locked import LockedPlatform
from steeplejack.mechanics.cable.rest.lost import locked_at
from steeplejack.mechanics.cable.rest.modes import planar_mass_matrix, spatial_mass_matrix
from steeplejack.mechanics.cable.rest.stiffness import cable_rates, planar_stiffness, spatial_stiffness, turn_about_z
from steeplejack.mechanics.cable.structure import (
    planar_lengths,
    planar_structure_matrix,
    planar_vectors,
    spatial_lengths,
    spatial_structure_matrix,
    spatial_vectors,
)
from steeplejack.mechanics.cable.wrench.load import gravity_wrench
from steeplejack.robots.cable_robot.parameters import AXES, Dimension, Parameters

Array = NDArray[np.float64]
_Planar = Callable[[ArrayLike, ArrayLike, ArrayLike], Array]
_Spatial = Callable[[ArrayLike, ArrayLike, ArrayLike, ArrayLike], Array]


@dataclass(frozen=True, eq=False)
class CableRobot:
    """Cables, their limits and one rigid platform; d is 2 for a planar robot and 3 for a spatial one.

    Attributes:
        name: What the robot is called.
        dimension: ``planar`` or ``spatial``.
        anchors: Where cables leave the world, (m, d) [m].
        attachments: Where they meet the platform, platform frame, (m, d) [m].
        lower: Least tensions, (m,) [N].
        upper: Greatest tensions, (m,) [N]; may be infinite.
        mass: Of the platform [kg].
        inertia: About the centre of mass, platform axes: (3, 3), or () for a planar robot [kg m2].
        centre_of_mass: In the platform frame, (d,) [m].
        axial_stiffness: EA of the cables, (m,) [N]; none where it is not known.
        pulley_radii: (m,) [m]; none for straight cables.
        pulley_axes: Way the cables travel on reaching their pulleys, (m, d); none for straight cables.
    """

    name: str
    dimension: Dimension
    anchors: Array
    attachments: Array
    lower: Array
    upper: Array
    mass: float
    inertia: Array
    centre_of_mass: Array
    axial_stiffness: Array | None = None
    pulley_radii: Array | None = None
    pulley_axes: Array | None = None

    @classmethod
    def of(cls, parameters: Parameters) -> CableRobot:
        """Bind what a robot file says."""
        cables, pulleys = parameters.cables, parameters.pulleys
        count = len(cables.anchors)
        stiffness = cables.axial_stiffness
        return cls(
            name=parameters.name,
            dimension=parameters.dimension,
            anchors=np.array(cables.anchors),
            attachments=np.array(cables.attachments),
            lower=_each(cables.tension_min, (count,)),
            upper=_each(cables.tension_max, (count,)),
            mass=parameters.platform.mass,
            inertia=np.array(parameters.platform.inertia),
            centre_of_mass=np.array(parameters.platform.centre_of_mass),
            axial_stiffness=None if stiffness is None else _each(stiffness, (count,)),
            pulley_radii=None if pulleys is None else _each(pulleys.radius, (count,)),
            pulley_axes=None if pulleys is None else _each(pulleys.axis, (count, AXES[parameters.dimension])),
        )

    @property
    def redundancy(self) -> int:
        """Cables beyond the degrees of freedom; negative where there are fewer."""
        return len(self.anchors) - (3 if self.dimension == "planar" else 6)

    @property
    def straight(self) -> tuple[Array, Array]:
        """Anchors and attachments, (m, d) each [m], for what takes cables as straight from anchors to attachments.

        That are maps, certified regions, rays and interference. Over pulleys `structure` answers pose by pose.

        Raises:
            InputError: The robot has pulleys.
        """
        if self.pulley_radii is not None and self.pulley_radii.any():
            found = f"pulleys of radius {self.pulley_radii.max():g} m"
            raise InputError(f"robot {self.name}", found, "straight cables; with pulleys ask `structure` at each pose")
        return self.anchors, self.attachments

    def pose_question(self, gravity: ArrayLike, rotation: ArrayLike | None = None) -> PoseQuestion:
        """Whether a spatial robot holds its weight within its limits, for `certify_poses` and `certify_orientations`.

        Args:
            gravity: Of the worksite, (3,) [m/s2].
            rotation: Reference ``R_0`` that orientations are counted from, (3, 3); level if None.

        Raises:
            InputError: A planar robot, pulleys, an upper limit that is infinite, or no vector of gravity.
        """
        if self.dimension == "planar":
            raise InputError(f"robot {self.name}", "planar", "a spatial robot; `planar_facets` takes all orientations")
        weight = np.concatenate((np.zeros(3), self.mass * finite("gravity", gravity, 3).reshape(3)))
        return pose_question(*self.straight, rotation, weight, self.lower, self.upper, self.centre_of_mass)

    def lengths(self, pose: ArrayLike, rotation: ArrayLike | None = None) -> Array:
        """Cable lengths from the anchors, arcs on pulleys included.

        Args:
            pose: ``(x, y, phi)``, (..., 3), or the position of a spatial platform, (..., 3).
            rotation: From platform to world, (..., 3, 3); spatial robots only.

        Returns:
            (..., m) [m].

        Raises:
            InputError: Not numbers of that shape, a rotation is missing or too many, or one matrix is no rotation.
        """
        if self.pulley_radii is None:
            return self._call(planar_lengths, spatial_lengths, self.anchors, pose, rotation)
        return self._pulley_runs(pose, rotation)[0]

    def structure(self, pose: ArrayLike, rotation: ArrayLike | None = None) -> Array:
        """Structure matrix ``J^T``; arguments and errors as of `lengths`.

        Returns:
            (..., 3, m) with rows ``fx, fy, mz``, or (..., 6, m) with rows (moment; force).
        """
        exits = self.anchors if self.pulley_radii is None else self._pulley_runs(pose, rotation)[1]
        return self._call(planar_structure_matrix, spatial_structure_matrix, exits, pose, rotation)

    def weight(self, gravity: ArrayLike, pose: ArrayLike, rotation: ArrayLike | None = None) -> Array:
        """Wrench of gravity on the platform about its reference point.

        Args:
            gravity: Of the worksite, (d,) [m/s2].
            pose: As of `lengths`.
            rotation: As of `lengths`.

        Returns:
            ``(fx, fy, mz)``, (..., 3), or (moment; force), (..., 6) [N, N m].

        Raises:
            InputError: As of `lengths`, or gravity of another dimension.
        """
        axes = len(self.centre_of_mass)
        place, turn = self._turned(pose, rotation)
        wrench = gravity_wrench(self.mass, one("gravity", gravity, axes), turn[..., :axes, :axes] @ self.centre_of_mass)
        shape = leading(("rotation", turn.shape, 2), ("pose", place.shape, 1))
        return np.array(np.broadcast_to(wrench, (*shape, wrench.shape[-1])))

    def stiffness(
        self, tensions: ArrayLike, gravity: ArrayLike, pose: ArrayLike, rotation: ArrayLike | None = None
    ) -> Array:
        """Stiffness about an equilibrium with locked winches, of the stretch between anchors and attachments alone.

        Args:
            tensions: (..., m) [N].
            gravity: Of the worksite, (d,) [m/s2].
            pose: As of `lengths`.
            rotation: As of `lengths`.

        Returns:
            (..., 3, 3) in (x, y, phi) or (..., 6, 6) in (rotation; displacement).

        Raises:
            InputError: As of `lengths`, gravity of another dimension, or the robot's axial stiffness is not known.
        """
        if self.axial_stiffness is None:
            raise InputError(f"robot {self.name}", "no axial stiffness", "cables.axial_stiffness in its file")
        rates = cable_rates(self.axial_stiffness, self.lengths(pose, rotation), tensions)
        weight = self.mass * one("gravity", gravity, len(self.centre_of_mass))
        rest = (tensions, rates, weight, self.centre_of_mass, self.pulley_axes, self.pulley_radii)
        if rotation is None:
            return planar_stiffness(self.anchors, self.attachments, pose, *rest)
        return spatial_stiffness(self.anchors, self.attachments, pose, rotation, *rest)

    def mass_matrix(self, pose: ArrayLike, rotation: ArrayLike | None = None) -> Array:
        """Mass matrix about the reference point; arguments and errors as of `lengths`.

        Returns:
            (..., 3, 3) in (x, y, phi) or (..., 6, 6) in (angular; linear).
        """
        place, turn = self._turned(pose, rotation)
        if self.dimension == "planar":
            return planar_mass_matrix(self.mass, self.inertia, self.centre_of_mass, place[..., 2])
        return spatial_mass_matrix(self.mass, self.inertia, self.centre_of_mass, turn)

    def locked(
        self,
        gravity: ArrayLike,
        pose: ArrayLike,
        rotation: ArrayLike | None = None,
        tensions: ArrayLike | None = None,
    ) -> LockedPlatform:
        """The platform with its winches locked at one pose, for `settle`, `equilibria` and `lost_cable`.

        Args:
            gravity: Of the worksite, (d,) [m/s2].
            pose: As of `lengths`, one.
            rotation: As of `lengths`, one.
            tensions: In the cables at that pose, which stretch by the robot's axial stiffness, (m,) or a scalar [N];
                cables that do not stretch where None.

        Returns:
            The platform with the lengths it has at that pose.

        Raises:
            InputError: As of `lengths`, no finite pose, a cable without a course there, gravity of another dimension,
                or tensions without a known axial stiffness.
        """
        if tensions is not None and self.axial_stiffness is None:
            raise InputError(f"robot {self.name}", "no axial stiffness", "cables.axial_stiffness in its file")
        place = self._turned(pose, rotation)[0]
        if place.ndim != 1:
            raise InputError("pose", f"shape {place.shape}", "one pose")
        axes = len(self.centre_of_mass)
        platform = (LockedPlatform.planar if axes == 2 else LockedPlatform.spatial)(
            self.anchors,
            self.attachments,
            1.0,  # `locked_at` puts the lengths of the pose in its place
            self.mass * one("gravity", gravity, axes),
            axial_stiffness=np.inf if tensions is None or self.axial_stiffness is None else self.axial_stiffness,
            centre=self.centre_of_mass,
            radii=self.pulley_radii,
            axes=self.pulley_axes,
            gyration=math.sqrt(np.mean(np.linalg.eigvalsh(np.atleast_2d(self.inertia))) / self.mass),
        )
        turn = place[2] if rotation is None else rotation
        return locked_at(platform, place[:axes], turn, 0.0 if tensions is None else tensions)

    def _turned(self, pose: ArrayLike, rotation: ArrayLike | None) -> tuple[Array, Array]:
        """The pose (..., 3) and the rotation from platform to world, (..., 3, 3)."""
        if (rotation is None) != (self.dimension == "planar"):
            found = "no rotation" if rotation is None else "a rotation"
            raise InputError(
                f"pose of {self.name}", found, "(x, y, phi) for planar robots, position and rotation for spatial ones"
            )
        place = vectors("pose", pose, 3)
        return place, turn_about_z(place[..., 2]) if rotation is None else rotation_matrices("rotation", rotation)

    def _call(
        self, planar: _Planar, spatial: _Spatial, exits: Array, pose: ArrayLike, rotation: ArrayLike | None
    ) -> Array:
        """The planar or the spatial one of two functions of the geometry."""
        place, turn = self._turned(pose, rotation)
        if self.dimension == "planar":
            return planar(exits, self.attachments, place)
        return spatial(exits, self.attachments, place, turn)

    def _pulley_runs(self, pose: ArrayLike, rotation: ArrayLike | None) -> tuple[Array, Array]:
        """Lengths over the pulleys (..., m) [m], and points (..., m, d) [m] the free stretches lead to."""
        ends = self.anchors - self._call(planar_vectors, spatial_vectors, self.anchors, pose, rotation)
        assert self.pulley_radii is not None and self.pulley_axes is not None
        lengths, along = pulley_runs(self.anchors, self.pulley_axes, self.pulley_radii, ends)
        return lengths, ends + along


def _each(value: object, shape: tuple[int, ...]) -> Array:
    """One value for every cable."""
    return np.array(np.broadcast_to(np.asarray(value, dtype=np.float64), shape))
