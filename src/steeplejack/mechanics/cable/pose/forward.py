"""Forward kinematics of a planar cable robot: the pose that explains measured cable lengths (Eq. 18).

Source: Zheng et al., CCRobot-S, IEEE T-RO, Eq. 18: least squares of ``l(x) - l_o`` by damped Gauss-Newton from a start
with a tension factor near 1. Four lengths say more than three pose coordinates need, so a pose that explains them all
is as a rule the only one; but the squares also have false minima, and near-symmetric robots have near-twins. The
answer therefore carries its residual, and `ForwardKinematics.unique` says whether a spread of other starts found
another explanation. `tracking` is the same from one start, in batches; `every_pose` proves how many there are.

Range of validity: taut cables. Cables stretch, so give the lengths under load (`loaded_lengths`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.mechanics.cable.pose.tracking import TrackingStatus, nearest_turn, track_planar

Array = NDArray[np.float64]

TWIN = 1e-3  # [1] poses closer than this, relative to the anchors' box, are one pose


@dataclass(frozen=True)
class ForwardKinematics:
    """A pose and how far it can be trusted.

    Attributes:
        pose: ``(x, y, phi)``, phi within half a turn of the start's, (3,) [m, m, rad].
        residual: ``|l(x) - l_o|`` over all cables [m].
        iterations: Gauss-Newton steps from the start that led here.
        converged: Whether a minimum was reached in the allowed steps.
        unique: Whether this pose explains the lengths within the tolerance and no other pose found does.
    """

    pose: Array
    residual: float
    iterations: int
    converged: bool
    unique: bool


def loaded_lengths(unstretched: ArrayLike, tensions: ArrayLike, axial_stiffness: ArrayLike) -> Array:
    """Lengths of linearly elastic cables under load, ``L (1 + t / EA)``.

    Args:
        unstretched: ``L``, as paid out, (..., m) [m].
        tensions: ``t``, measured, (..., m) [N]; a slack cable does not stretch, so negative readings count as zero.
        axial_stiffness: ``EA`` [N].

    Returns:
        Lengths under load, (..., m) [m].
    """
    strain = np.maximum(np.asarray(tensions, dtype=np.float64), 0.0) / np.asarray(axial_stiffness)
    return np.asarray(unstretched, dtype=np.float64) * (1.0 + strain)


def forward_kinematics(
    lengths: ArrayLike,
    anchors: ArrayLike,
    attachments: ArrayLike,
    start: ArrayLike,
    tolerance: float | None = None,
    *,
    radii: ArrayLike | None = None,
    axes: ArrayLike | None = None,
) -> ForwardKinematics:
    """Pose that explains cable lengths best, from a start, checked against a spread of other starts (Eq. 18).

    The minimum reached from ``start`` is kept if it explains the lengths; otherwise the best of all starts is returned.

    Args:
        lengths: ``l_o``, under load, (m,) with m >= 3 [m].
        anchors: (m, 2) [m].
        attachments: In the platform frame, (m, 2) [m].
        start: Where to begin; a pose with a tension factor near 1 converges from all over the workspace, (3,).
        tolerance: Residual up to which a pose explains the lengths [m]; a thousandth of the longest cable by default.
        radii: Of the pulleys, (m,) or a scalar [m]; straight cables where not given.
        axes: Swivel axes of the pulleys, see `pulleys`, (m, 2).

    Returns:
        The pose with residual, iterations and whether it is the only explanation found. Where the lengths are not
        finite, the start with a residual that is not a number.

    Raises:
        InputError: Shapes do not fit, or there are fewer than three cables.
    """
    measured, fixed = np.asarray(lengths, dtype=np.float64), np.asarray(anchors, dtype=np.float64)
    starts = np.vstack((np.asarray(start, dtype=np.float64), _spread(fixed)))
    ends = track_planar(
        np.broadcast_to(measured, (len(starts), *measured.shape)), fixed, attachments, starts, radii=radii, axes=axes
    )
    enough = 1e-3 * float(np.abs(measured).max()) if tolerance is None else tolerance
    residuals = np.where(np.isfinite(ends.residual), ends.residual, np.inf)
    chosen = 0 if residuals[0] <= enough else int(np.argmin(residuals))
    pose = ends.pose[chosen].copy()
    pose[2] = nearest_turn(pose[2], starts[0, 2])
    converged = ends.status[chosen] in (TrackingStatus.CONVERGED, TrackingStatus.UNEXPLAINED)
    others = _distance(ends.pose[residuals <= enough], pose, fixed)
    return ForwardKinematics(
        pose=pose,
        residual=float(ends.residual[chosen]),
        iterations=int(ends.iterations[chosen]),
        converged=converged,
        unique=bool(converged and residuals[chosen] <= enough and np.all(others < TWIN)),
    )


def pose_rates(structure: ArrayLike, length_rates: ArrayLike) -> Array:
    """Platform velocity from cable length rates by least squares, ``dl/dt = -J dx/dt``.

    Args:
        structure: ``J^T``, of full row rank, (..., n, m).
        length_rates: Positive when a cable grows longer, (..., m) [m/s].

    Returns:
        The velocity dual to the rows, ``(vx, vy, omega)`` or (angular; linear), (..., n) [m/s, rad/s]; the least one
        where the structure is singular.
    """
    jacobian = np.swapaxes(np.asarray(structure, dtype=np.float64), -1, -2)
    return -np.einsum("...im,...m->...i", np.linalg.pinv(jacobian), np.asarray(length_rates, dtype=np.float64))


def _spread(anchors: Array) -> Array:
    """Starts on a 5 x 5 grid over the square around the anchors' box at 12 angles, (300, 3)."""
    middle, width = 0.5 * (anchors.min(axis=0) + anchors.max(axis=0)), np.ptp(anchors, axis=0).max()
    offsets = width * ((np.arange(5) + 0.5) / 5.0 - 0.5)
    grid = np.meshgrid(middle[0] + offsets, middle[1] + offsets, np.arange(12) * (np.pi / 6.0))
    return np.stack([axis.ravel() for axis in grid], axis=-1)


def _distance(poses: Array, pose: Array, anchors: Array) -> Array:
    """Distance of poses from one, in widths of the anchors' box and in radians, whichever is larger."""
    width = float(np.ptp(anchors, axis=0).max())
    turn = np.abs(nearest_turn(poses[:, 2], pose[2]) - pose[2])
    return np.maximum(np.linalg.norm(poses[:, :2] - pose[:2], axis=-1) / width, turn)
