"""Tracking forward kinematics: poses from streams or batches of cable lengths, microseconds each.

Gauss-Newton from the last pose, or from a start for each; planar and spatial, any number of cables not below the number
of freedoms, over pulleys or straight. Least squares over all cables: with more cables than freedoms the residual tells
how well the lengths agree, and a pose is never returned without it.

What tracking cannot know is whether another pose explains the lengths as well: `forward_kinematics` tries other starts
and `every_pose` proves it.

Policy at degeneracies: lengths that are not finite, an attachment inside its pulley, or all lengths zero give
``UNDEFINED`` and leave the start; in a stream the next pose starts from the last defined one. At a pose where the
lengths determine the freedoms only to second order (a least sine of 3e-7) the status is ``SINGULAR``. That is wider
than the `degeneracy` of a given pose: a pose found from lengths is known to the root of rounding only where two
solutions meet, so that every pose that is singular there is so here, and near ones are too. A start that is not finite,
in a batch, is ``UNDEFINED`` and stops no other. A question with wrong shapes, geometry that is not finite, negative
radii or fewer cables than freedoms raises `InputError`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import rotation_matrices, vectors
from steeplejack.mechanics.cable.pose import misfit
from steeplejack.mechanics.cable.pose.given import Geometry, geometry, tolerance_of
from steeplejack.mechanics.cable.pulleys import in_space

Array = NDArray[np.float64]

PLANAR, SPATIAL = np.array([3, 4, 2]), np.arange(6)  # freedoms of (omega; v) in the order of a pose


class TrackingStatus(IntEnum):
    """How a search for a pose ended; `advice` says what to do."""

    CONVERGED = misfit.CONVERGED
    SINGULAR = misfit.SINGULAR
    UNFINISHED = misfit.UNFINISHED
    UNDEFINED = misfit.UNDEFINED
    UNEXPLAINED = 4

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _ADVICE[self]


_ADVICE = {
    TrackingStatus.CONVERGED: "the pose explains the lengths within the tolerance",
    TrackingStatus.SINGULAR: "the lengths leave a motion of the platform undetermined here; add a cable or move off",
    TrackingStatus.UNFINISHED: "no minimum was reached in the allowed steps; start nearer",
    TrackingStatus.UNDEFINED: "a length is not a finite number, or an attachment is inside its pulley; check the input",
    TrackingStatus.UNEXPLAINED: "the nearest minimum does not explain the lengths; search globally, check encoders",
}


@dataclass(frozen=True)
class PlanarTrack:
    """Poses in the plane and how far they can be trusted; leading axes are those of the lengths.

    Attributes:
        pose: ``(x, y, phi)``, phi continuous from the start, (..., 3) [m, m, rad].
        residual: ``|l(x) - l_o|`` over all cables, (...) [m]; not a number where undefined.
        iterations: (...).
        status: `TrackingStatus` by number, (...).
    """

    pose: Array
    residual: Array
    iterations: NDArray[np.int64]
    status: NDArray[np.int64]


@dataclass(frozen=True)
class SpatialTrack:
    """Poses in space and how far they can be trusted; leading axes are those of the lengths.

    Attributes:
        position: (..., 3) [m].
        rotation: From platform to world, (..., 3, 3).
        residual: ``|l(x) - l_o|`` over all cables, (...) [m]; not a number where undefined.
        iterations: (...).
        status: `TrackingStatus` by number, (...).
    """

    position: Array
    rotation: Array
    residual: Array
    iterations: NDArray[np.int64]
    status: NDArray[np.int64]


def track_planar(
    lengths: ArrayLike,
    anchors: ArrayLike,
    attachments: ArrayLike,
    start: ArrayLike,
    *,
    radii: ArrayLike | None = None,
    axes: ArrayLike | None = None,
    follow: bool = False,
    tolerance: float | None = None,
) -> PlanarTrack:
    """Poses of a planar robot from cable lengths, each the minimum nearest to its start.

    Args:
        lengths: Under load, arcs on pulleys included, (..., m) with m >= 3 [m].
        anchors: (m, 2) [m].
        attachments: In the platform frame, (m, 2) [m].
        start: ``(x, y, phi)``, one for all or one each, (3,) or (..., 3).
        radii: Of the pulleys, (m,) or a scalar [m]; straight cables where not given.
        axes: Swivel axes in the plane, see `pulleys`, (m, 2); needed with radii.
        follow: Whether the lengths are a stream along the last leading axis: each pose starts from the one before.
        tolerance: Residual up to which a pose explains the lengths [m]; a thousandth of the longest cable by default.

    Returns:
        Poses with residual, iterations and status.

    Raises:
        InputError: Shapes do not fit, or there are fewer than three cables.
    """
    first = vectors("start", start, 3)
    first = np.where(np.isfinite(first).all(axis=-1, keepdims=True), first, np.nan)
    cosine, sine = np.cos(first[..., 2]), np.sin(first[..., 2])
    rotation = np.zeros((*first.shape[:-1], 3, 3))
    rotation[..., 0, 0], rotation[..., 0, 1], rotation[..., 1, 0], rotation[..., 1, 1] = cosine, -sine, sine, cosine
    rotation[..., 2, 2] = 1.0
    robot = geometry(anchors, attachments, radii, axes, 2)
    measured = vectors("lengths", lengths, len(robot[0]))
    found = minima(measured, robot, PLANAR, in_space(first[..., :2]), rotation, follow, tolerance)
    phi = np.arctan2(found.rotation[..., 1, 0], found.rotation[..., 0, 0])
    reference = np.broadcast_to(first[..., 2], phi.shape)
    if follow and phi.ndim:
        phi = np.unwrap(np.concatenate((reference[..., :1], phi), axis=-1), axis=-1)[..., 1:]
    else:
        phi = nearest_turn(phi, reference)
    pose = np.concatenate((found.position[..., :2], phi[..., None]), axis=-1)
    return PlanarTrack(pose, found.residual, found.iterations, found.status)


def track_spatial(
    lengths: ArrayLike,
    anchors: ArrayLike,
    attachments: ArrayLike,
    position: ArrayLike,
    rotation: ArrayLike,
    *,
    radii: ArrayLike | None = None,
    axes: ArrayLike | None = None,
    follow: bool = False,
    tolerance: float | None = None,
) -> SpatialTrack:
    """Poses of a spatial robot from cable lengths, each the minimum nearest to its start.

    Args:
        lengths: Under load, arcs on pulleys included, (..., m) with m >= 6 [m].
        anchors: (m, 3) [m].
        attachments: In the platform frame, (m, 3) [m].
        position: Starts, one for all or one each, (3,) or (..., 3) [m].
        rotation: Starts, (3, 3) or (..., 3, 3).
        radii: Of the pulleys, (m,) or a scalar [m]; straight cables where not given.
        axes: Swivel axes, see `pulleys`, (m, 3); needed with radii.
        follow: Whether the lengths are a stream along the last leading axis: each pose starts from the one before.
        tolerance: Residual up to which a pose explains the lengths [m]; a thousandth of the longest cable by default.

    Returns:
        Poses with residual, iterations and status.

    Raises:
        InputError: Shapes do not fit, one start for all is no rotation, or there are fewer than six cables.
    """
    robot, turn = geometry(anchors, attachments, radii, axes, 3), rotation_matrices("rotation", rotation)
    measured = vectors("lengths", lengths, len(robot[0]))
    return minima(measured, robot, SPATIAL, vectors("position", position, 3), turn, follow, tolerance)


def nearest_turn(angle: ArrayLike, reference: ArrayLike) -> Array:
    """The same directions as ``angle`` within half a turn of ``reference`` [rad]."""
    middle = np.asarray(reference, dtype=np.float64)
    return middle + np.remainder(np.asarray(angle, dtype=np.float64) - middle + np.pi, 2.0 * np.pi) - np.pi


def minima(
    lengths: Array,
    robot: Geometry,
    freedoms: NDArray[np.int64],
    position: Array,
    rotation: Array,
    follow: bool = False,
    tolerance: float | None = None,
) -> SpatialTrack:
    """The nearest minima of the misfit for checked lengths (..., m), from starts (..., 3) and (..., 3, 3).

    Args:
        lengths: See `track_spatial`.
        robot: From `given.geometry`.
        freedoms: Which of (omega; v) move, (n,).
        position: See `track_spatial`.
        rotation: See `track_spatial`.
        follow: See `track_spatial`.
        tolerance: See `track_spatial`.

    Returns:
        Poses in space.

    Raises:
        InputError: As many starts as fit neither one nor each of the lengths, or a tolerance that is none.
    """
    wanted = tolerance_of(tolerance)
    shape, m = lengths.shape[:-1], len(robot[0])
    stream = shape[-1] if follow and shape else 1
    flat = np.ascontiguousarray(lengths.reshape(-1, m))
    try:
        positions = np.array(np.broadcast_to(position, (*shape, 3))).reshape(-1, 3)
        rotations = np.array(np.broadcast_to(rotation, (*shape, 3, 3))).reshape(-1, 3, 3)
    except ValueError:
        raise InputError(
            "start", f"{position.shape[:-1]} for lengths {shape}", "one for all, or one for each"
        ) from None
    residuals = np.empty(len(flat))
    steps, status = np.empty(len(flat), dtype=np.int64), np.empty(len(flat), dtype=np.int64)
    for begin in range(0, len(flat), max(stream, 1)) if follow else (0,):
        part = slice(begin, begin + stream) if follow else slice(None)
        misfit.track_each(
            flat[part],
            *robot,
            freedoms,
            follow,
            positions[part],
            rotations[part],
            residuals[part],
            steps[part],
            status[part],
        )
    with np.errstate(invalid="ignore"):
        enough = 1e-3 * np.abs(flat).max(axis=-1, initial=0.0) if wanted is None else wanted
        status[(status == TrackingStatus.CONVERGED) & (residuals > enough)] = TrackingStatus.UNEXPLAINED
    return SpatialTrack(
        positions.reshape(*shape, 3),
        rotations.reshape(*shape, 3, 3),
        residuals.reshape(shape),
        steps.reshape(shape),
        status.reshape(shape),
    )
