"""Forward kinematics of a cable robot, planar or spatial: the pose that explains measured cable lengths (Eq. 18).

Source: Zheng et al., CCRobot-S, IEEE T-RO, Eq. 18: least squares of ``l(x) - l_o`` by damped Gauss-Newton from a start
with a tension factor near 1. More lengths than freedoms say more than a pose needs, so a pose that explains them all is
as a rule the only one; but the squares also have false minima, near-symmetric robots have near-twins, and as many
lengths as freedoms have up to 6 poses in the plane and 40 in space. The answer therefore carries its residual, and
`ForwardKinematics.unique` says whether a spread of other starts found another explanation. `tracking` is the same from
one start, in batches; `every_pose` proves how many there are.

A pose is three numbers in the plane, ``(x, y, phi)``, and six in space, ``(x, y, z, wx, wy, wz)`` with the rotation
vector ``w`` of the platform in world axes (`steeplejack.spatial.to_vector`).

Range of validity: taut cables, straight or over swivelling pulleys. Cables stretch, so give the lengths under load
(`loaded_lengths`).

Policy at degeneracies: where the lengths leave a motion of the platform open, at the pose found, the status is
``SINGULAR`` and the pose is not called unique, whatever else was found. Lengths that are not finite are ``UNDEFINED``.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import leading, numbers, spread, stiffness_of, structures_of, vectors
from steeplejack.mechanics.cable.degeneracy import rank
from steeplejack.mechanics.cable.pose.given import Geometry, geometry, tolerance_of
from steeplejack.mechanics.cable.pose.tracking import PLANAR, SPATIAL, TrackingStatus, minima, nearest_turn
from steeplejack.spatial.rotation import from_vector, to_vector

Array = NDArray[np.float64]

TWIN = 1e-3  # [1] poses closer than this, relative to the anchors' box or in radians, are one pose
EXPLAINED = 1e-3  # [1] residual over the longest cable up to which a pose explains the lengths, by default


@dataclass(frozen=True, eq=False)
class ForwardKinematics:
    """A pose and how far it can be trusted.

    Attributes:
        pose: ``(x, y, phi)``, phi within half a turn of the start's, (3,) [m, m, rad]; or in space the position and the
            rotation vector, (6,) [m, rad].
        position: In space also for planar robots, (3,) [m].
        rotation: From platform to world, (3, 3).
        residual: ``|l(x) - l_o|`` over all cables [m].
        iterations: Gauss-Newton steps from the start that led here.
        status: How the search ended; its `advice` says what to do.
        unique: Whether this pose explains the lengths within the tolerance and no other pose found does.
    """

    pose: Array
    position: Array
    rotation: Array
    residual: float
    iterations: int
    status: TrackingStatus
    unique: bool

    @property
    def converged(self) -> bool:
        """Whether a minimum was reached in the allowed steps at which lengths determine the pose."""
        return self.status in (TrackingStatus.CONVERGED, TrackingStatus.UNEXPLAINED)


def loaded_lengths(unstretched: ArrayLike, tensions: ArrayLike, axial_stiffness: ArrayLike) -> Array:
    """Lengths of linearly elastic cables under load, ``L (1 + t / EA)``.

    Args:
        unstretched: ``L``, as paid out, (..., m) [m].
        tensions: ``t``, measured, (..., m) [N]; a slack cable does not stretch, so negative readings count as zero.
        axial_stiffness: ``EA``, (..., m) or a scalar [N]; may be inf.

    Returns:
        Lengths under load, (..., m) [m].

    Raises:
        InputError: No numbers, shapes that do not match, or an axial stiffness of zero or less.
    """
    paid, pull = numbers("unstretched", unstretched), numbers("tensions", tensions)
    elastic = stiffness_of(axial_stiffness)
    leading(("unstretched", paid.shape, 0), ("tensions", pull.shape, 0), ("axial_stiffness", elastic.shape, 0))
    with np.errstate(invalid="ignore", over="ignore"):
        return paid * (1.0 + np.maximum(pull, 0.0) / elastic)


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
        lengths: ``l_o``, under load, arcs on pulleys included, (m,) with m >= 3 in the plane, m >= 6 in space [m].
        anchors: (m, 2) or (m, 3) [m].
        attachments: In the platform frame, (m, 2) or (m, 3) [m].
        start: Where to begin, (3,) in the plane, (6,) in space or (3,) there for the platform upright; a pose with a
            tension factor near 1 converges from all over the workspace.
        tolerance: Residual up to which a pose explains the lengths [m]; a thousandth of the longest cable by default.
        radii: Of the pulleys, (m,) or a scalar [m]; straight cables where not given.
        axes: Swivel axes of the pulleys, see `pulleys`, (m, 2) or (m, 3); needed with radii.

    Returns:
        The pose with residual, iterations and whether it is the only explanation found. Where the lengths are not
        finite, the start with a residual that is not a number.

    Raises:
        InputError: Shapes do not fit, a number is not usable, or there are fewer cables than freedoms.
    """
    robot, d = _robot(anchors, attachments, radii, axes)
    measured, begin = vectors("lengths", lengths, len(robot[0])), numbers("start", start)
    if measured.ndim != 1:
        raise InputError("lengths", f"shape {measured.shape}", f"({len(robot[0])},), one for each cable")
    if begin.shape not in (((3,),) if d == 2 else ((3,), (6,))) or not np.isfinite(begin).all():
        raise InputError("start", f"{np.ravel(begin).tolist()}", "finite (x, y, phi), or in space (3,) or (6,)")
    wanted = tolerance_of(tolerance)
    places, turns = _starts(robot[0], begin, d)
    many = np.broadcast_to(measured, (len(places), len(measured)))
    ends = minima(many, robot, PLANAR if d == 2 else SPATIAL, places, turns)
    enough = EXPLAINED * float(np.abs(measured).max()) if wanted is None else wanted
    residuals = np.where(np.isfinite(ends.residual), ends.residual, np.inf)
    explained = residuals <= enough
    chosen = 0 if explained[0] else int(np.argmin(residuals))
    place, turn = ends.position[chosen], ends.rotation[chosen]
    status = TrackingStatus(int(ends.status[chosen]))
    if status in (TrackingStatus.CONVERGED, TrackingStatus.UNEXPLAINED):
        status = TrackingStatus.CONVERGED if explained[chosen] else TrackingStatus.UNEXPLAINED
    apart = np.linalg.norm(ends.position[explained] - place, axis=-1)
    twist = np.linalg.norm(ends.rotation[explained] - turn, axis=(-2, -1)) / np.sqrt(2.0)  # 2 sin(angle / 2)
    size = max(float(np.ptp(robot[0], axis=0).max()), float(measured.max()))
    alone = np.all(np.maximum(apart / size, twist) < TWIN)
    return ForwardKinematics(
        pose=_planar_pose(place, turn, begin[2]) if d == 2 else np.concatenate((place, to_vector(turn))),
        position=place,
        rotation=turn,
        residual=float(ends.residual[chosen]),
        iterations=int(ends.iterations[chosen]),
        status=status,
        unique=bool(status is TrackingStatus.CONVERGED and alone),
    )


def pose_rates(structure: ArrayLike, length_rates: ArrayLike) -> Array:
    """Platform velocity from cable length rates by least squares, ``dl/dt = -J dx/dt``.

    Args:
        structure: ``J^T``, of full row rank, (..., n, m).
        length_rates: Positive when a cable grows longer, (..., m) [m/s].

    Returns:
        The velocity dual to the rows, ``(vx, vy, omega)`` or (angular; linear), (..., n) [m/s, rad/s]; not a number
        where the structure is singular or undefined (`degeneracy`), or a rate is not finite.

    Raises:
        InputError: No numbers, or shapes that do not match.
    """
    matrices, own = structures_of(structure)
    n, m = matrices.shape[1:]
    rates = vectors("length_rates", length_rates, m)
    shape = leading(("structure", (*own, n, m), 2), ("length_rates", rates.shape, 1))
    flat, speeds = spread(matrices.reshape(*own, n, m), shape, (n, m)), spread(rates, shape, (m,))
    known = (rank(flat) == n) & np.isfinite(speeds).all(axis=-1)
    scale = np.abs(flat[known]).max(axis=-1)  # rows differ in units: what they are in must not decide the least squares
    jacobian = np.swapaxes(flat[known] / scale[..., None], -1, -2)
    out = np.full((len(flat), n), np.nan)
    out[known] = -np.einsum("kim,km->ki", np.linalg.pinv(jacobian, rcond=0.0), speeds[known]) / scale
    return out.reshape(*shape, n)


def _robot(
    anchors: ArrayLike, attachments: ArrayLike, radii: ArrayLike | None, axes: ArrayLike | None
) -> tuple[Geometry, int]:
    """Geometry in space, and 2 or 3 for the plane or space the anchors are given in."""
    given = numbers("anchors", anchors)
    if given.ndim != 2 or given.shape[1] not in (2, 3):
        raise InputError("anchors", f"shape {given.shape}", "(m, 2) or (m, 3) in metres")
    d = given.shape[1]
    return geometry(given, attachments, radii, axes, d), d


def _starts(anchors: Array, start: Array, d: int) -> tuple[Array, Array]:
    """Positions (k, 3) [m] and rotations (k, 3, 3) to start from: the given one, then those spread about the anchors.

    In the plane a 5 x 5 grid over the square around the anchors' box at 12 angles; in space a 3 x 3 x 3 grid over the
    cube around it, in the 24 orientations that turn the axes of the first start into each other.
    """
    low, high = anchors[:, :d].min(axis=0), anchors[:, :d].max(axis=0)
    count = 5 if d == 2 else 3
    offsets = (high - low).max() * ((np.arange(count) + 0.5) / count - 0.5)
    grid = np.zeros((count**d, 3))
    grid[:, :d] = 0.5 * (low + high) + np.array(list(itertools.product(offsets, repeat=d)))
    first, place = np.eye(3), np.zeros(3)
    place[:d] = start[:d]
    if d == 2:
        first = from_vector(np.array([0.0, 0.0, start[2]]))
        turns = np.array([from_vector(np.array([0.0, 0.0, k * np.pi / 6.0])) for k in range(12)])
    else:
        first = from_vector(start[3:]) if len(start) == 6 else first
        turns = _axes_to_axes() @ first
    places = np.vstack((place, np.repeat(grid, len(turns), axis=0)))
    return places, np.concatenate((first[None], np.tile(turns, (len(grid), 1, 1))))


def _axes_to_axes() -> Array:
    """The 24 rotations that turn the axes of space into each other, (24, 3, 3)."""
    signed = [
        np.diag(signs)[:, order]
        for order in itertools.permutations(range(3))
        for signs in itertools.product((1.0, -1.0), repeat=3)
    ]
    return np.array([matrix for matrix in signed if np.linalg.det(matrix) > 0.0])


def _planar_pose(position: Array, rotation: Array, phi: float) -> Array:
    """``(x, y, phi)`` with phi within half a turn of another, (3,)."""
    return np.array([position[0], position[1], nearest_turn(np.arctan2(rotation[1, 0], rotation[0, 0]), phi)])
