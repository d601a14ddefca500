"""Global forward kinematics: every pose of a box that explains cable lengths, with the proof that there is none other.

A pose *explains* measured lengths if ``|l(x) - l_o| <= tolerance`` over all cables together. Interval branch and bound
(`global_search`) covers the box: each part of it is proved empty of such poses, or lies in the certified box of a
reported one, in which no two poses share their lengths; how far another explanation could lie from the reported pose
inside that box is reported too. What could not be decided is returned, and the search is then not `complete`.

Range of validity: cables of known length under load, straight or over swivelling pulleys, arcs on the pulleys included
(`bounds`). Planar robots are searched over any box and all angles, by default over one that holds every pose there is:
a cable of length l from an anchor A to an attachment b keeps the platform within ``l + |b| + tolerance`` of A, whatever
the angle and the pulley, and so in the intersection of those boxes; spatial ones over a stated box about a nominal
pose, angles within a right angle of it. At a singular pose lengths are unique in no box around it, so the search cannot
complete: an honest answer, as two solutions meet there. The same holds where an attachment touches its pulley.

What is proved is proved of the numbers as they are stored here, in units of the longest cable and axes of unit length:
rounded once, by 1e-16, a ten-thousandth of the least tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import number, numbers, whole
from steeplejack.mechanics.cable.pose.given import LARGEST, Geometry, geometry
from steeplejack.mechanics.cable.pose.global_search import search
from steeplejack.mechanics.cable.pose.tracking import TrackingStatus, track_planar, track_spatial
from steeplejack.spatial.rotation import rotation_matrix

Array = NDArray[np.float64]

TOLERANCE = 1e-6  # [1] over the longest cable
LEAST_TOLERANCE = 1e-12  # [1] the same; below it rounding decides
NARROW = 1e-9  # [1] width over the longest cable below which a box is undecided
MOST_BUDGET = 1_000_000_000  # boxes that may be asked for
MOST = 64  # solutions and undecided boxes kept
SEED_ANGLE = 0.7548776662466927  # [rad] keeps the cut of the circle off the angles people use

PLANAR_UNKNOWNS, SPATIAL_UNKNOWNS = np.array([0, 1, 5]), np.arange(6)


@dataclass(frozen=True, eq=False)
class EveryPose:
    """Poses that explain the lengths, each with its certificate; in space also for planar robots.

    Attributes:
        position: (s, 3) [m].
        rotation: From platform to world, (s, 3, 3).
        residual: Upper bounds of ``|l(x) - l_o|``, (s,) [m].
        boxes: Least and greatest unknowns of the box in which lengths are unique: (x, y, phi) or (x, y, z, a, b, c)
            with ``R = Rz(c) Ry(b) Rx(a) R_0``, (s, 2, n) [m, rad].
        spread: How far another explanation in the same box can lie from the pose, angles times the reach of the
            attachments, (s,) [m].
        complete: Whether it is proved that no pose of the box outside these boxes explains the lengths.
        undecided: Parts of the box left open, as many as are kept, (u, 2, n).
        examined: Boxes looked at.
        box: Least and greatest unknowns of the box searched, (2, n) [m, rad]; where a least one exceeds the greatest,
            the reaches of the cables have no point in common.
    """

    position: Array
    rotation: Array
    residual: Array
    boxes: Array
    spread: Array
    complete: bool
    undecided: Array
    examined: int
    box: Array

    @property
    def pose(self) -> Array:
        """``(x, y, phi)`` of a planar platform, phi between minus and plus half a turn, (s, 3) [m, m, rad]."""
        phi = np.arctan2(self.rotation[:, 1, 0], self.rotation[:, 0, 0])
        return np.column_stack((self.position[:, :2], phi))

    @property
    def unique(self) -> bool:
        """Whether exactly one pose of `box` explains the lengths, proved."""
        return self.complete and len(self.position) == 1


def every_planar_pose(
    lengths: ArrayLike,
    anchors: ArrayLike,
    attachments: ArrayLike,
    *,
    radii: ArrayLike | None = None,
    axes: ArrayLike | None = None,
    low: ArrayLike | None = None,
    high: ArrayLike | None = None,
    tolerance: float | None = None,
    budget: int = 200_000,
) -> EveryPose:
    """Every pose of a planar robot that explains cable lengths.

    Args:
        lengths: Under load, arcs on pulleys included, (m,) with m >= 3 [m].
        anchors: (m, 2) [m].
        attachments: In the platform frame, (m, 2) [m].
        radii: Of the pulleys, (m,) or a scalar [m]; straight cables where not given.
        axes: Swivel axes in the plane, see `pulleys`, (m, 2); needed with radii.
        low: Least ``(x, y, phi)`` of the search, (3,) [m, m, rad]; by default, with ``high``, a box that holds every
            pose that explains the lengths, and all angles.
        high: Greatest, (3,) [m, m, rad].
        tolerance: Residual up to which a pose explains the lengths [m]; a millionth of the longest by default.
        budget: Boxes to examine at most.

    Returns:
        The poses, and whether they are all.

    Raises:
        InputError: A shape does not fit or a number is not usable.
    """
    robot = geometry(anchors, attachments, radii, axes, 2)
    measured, enough = _measured(lengths, len(robot[0]), tolerance)
    whole("budget", budget, 1, MOST_BUDGET)
    least, most = _reachable(measured, robot[0][:, :2], robot[3][:, :2], enough)
    if low is None and high is None and not np.all(least < most):
        return _none(least, most)
    least, most = least if low is None else _bound(low, 3), most if high is None else _bound(high, 3)
    _check_box(least, most)
    grid = [a + (b - a) * (np.arange(k) + 0.5) / k for a, b, k in zip(least, most, (4, 4, 8), strict=True)]
    starts = np.stack([axis.ravel() for axis in np.meshgrid(*grid)], axis=-1)
    copies = np.broadcast_to(measured, (len(starts), len(measured)))
    seeds = track_planar(
        copies, robot[0][:, :2], robot[3][:, :2], starts, radii=robot[2], axes=robot[1][:, :2], tolerance=enough
    )
    reached = seeds.status == TrackingStatus.CONVERGED
    unknowns = np.zeros((int(reached.sum()), 6))
    unknowns[:, PLANAR_UNKNOWNS] = seeds.pose[reached]
    return _searched(measured, robot, least, most, PLANAR_UNKNOWNS, np.eye(3), enough, budget, unknowns)


def every_spatial_pose(
    lengths: ArrayLike,
    anchors: ArrayLike,
    attachments: ArrayLike,
    position: ArrayLike,
    rotation: ArrayLike,
    half_widths: ArrayLike,
    half_angles: ArrayLike,
    *,
    radii: ArrayLike | None = None,
    axes: ArrayLike | None = None,
    tolerance: float | None = None,
    budget: int = 200_000,
) -> EveryPose:
    """Every pose of a spatial robot near a nominal one that explains cable lengths.

    Args:
        lengths: Under load, arcs on pulleys included, (m,) with m >= 6 [m].
        anchors: (m, 3) [m].
        attachments: In the platform frame, (m, 3) [m].
        position: Middle of the search, (3,) [m].
        rotation: ``R_0`` in the middle of the search, (3, 3).
        half_widths: Of the box of positions, (3,) or a scalar [m].
        half_angles: Of a, b, c in ``R = Rz(c) Ry(b) Rx(a) R_0``, (3,) or a scalar, b below a right angle [rad].
        radii: Of the pulleys, (m,) or a scalar [m]; straight cables where not given.
        axes: Swivel axes, see `pulleys`, (m, 3); needed with radii.
        tolerance: Residual up to which a pose explains the lengths [m]; a millionth of the longest by default.
        budget: Boxes to examine at most.

    Returns:
        The poses, and whether they are all.

    Raises:
        InputError: A shape does not fit or a number is not usable.
    """
    robot = geometry(anchors, attachments, radii, axes, 3)
    measured, enough = _measured(lengths, len(robot[0]), tolerance)
    whole("budget", budget, 1, MOST_BUDGET)
    place, turn = numbers("position", position), rotation_matrix(rotation, "rotation")
    if place.shape != (3,) or not np.isfinite(place).all():
        raise InputError("position", f"shape {place.shape}", "a finite point (3,) in metres")
    if turn.shape != (3, 3):
        raise InputError("rotation", f"shape {turn.shape}", "one rotation matrix (3, 3)")
    half = np.concatenate([_half("half_widths", half_widths), _half("half_angles", half_angles)])
    if not half[4] < 0.5 * np.pi:
        raise InputError("half_angles", f"{half[4]:g} rad about y", "below a right angle")
    middle = np.concatenate((place, np.zeros(3)))
    _check_box(middle - half, middle + half)
    seed = track_spatial(measured, robot[0], robot[3], place, turn, radii=robot[2], axes=robot[1], tolerance=enough)
    unknowns = np.zeros((1 if seed.status == TrackingStatus.CONVERGED else 0, 6))
    if len(unknowns):
        unknowns[0] = np.concatenate((seed.position, _angles(seed.rotation @ turn.T)))
    return _searched(measured, robot, middle - half, middle + half, SPATIAL_UNKNOWNS, turn, enough, budget, unknowns)


def _searched(
    lengths: Array,
    robot: Geometry,
    low: Array,
    high: Array,
    unknowns: NDArray[np.int64],
    rotation: Array,
    tolerance: float,
    budget: int,
    seeds: Array,
) -> EveryPose:
    """Search in units of the longest cable, and translate the answer back."""
    anchors, axes, radii, attachments = robot
    size = float(lengths.max())
    unit = np.where(unknowns < 3, size, 1.0)
    reach = max(float(np.linalg.norm(attachments, axis=1).max()) / size, 1e-3)
    weights = np.array([1.0, 1.0, 1.0, 1.0 / reach, 1.0 / reach, 1.0 / reach])
    least, most = np.zeros(6), np.zeros(6)
    least[unknowns], most[unknowns] = low / unit, high / unit
    solutions, boxes = np.empty((MOST, 6)), np.empty((MOST, 2, 6))
    residuals, spreads, undecided = np.empty(MOST), np.empty(MOST), np.empty((MOST, 2, 6))
    scaled = seeds / np.array([size, size, size, 1.0, 1.0, 1.0])
    found, left, examined = search(
        least,
        most,
        unknowns,
        anchors / size,
        axes,
        radii / size,
        attachments @ rotation.T / size,
        lengths / size,
        weights,
        tolerance / size,
        NARROW,
        budget,
        scaled,
        solutions,
        boxes,
        residuals,
        spreads,
        undecided,
    )
    margin = 1e-12 + spreads[:found, None] * weights[unknowns]
    places = solutions[:found][:, unknowns]
    inside = np.all((places >= least[unknowns] - margin) & (places <= most[unknowns] + margin), axis=1)
    kept = _once(solutions[:found][inside], spreads[:found][inside])
    chosen = np.flatnonzero(inside)[kept]
    return EveryPose(
        solutions[chosen, :3] * size,
        _rotations(solutions[chosen, 3:]) @ rotation,
        residuals[chosen] * size,
        boxes[chosen][:, :, unknowns] * unit,
        spreads[chosen] * size,
        left == 0,
        undecided[: min(left, MOST)][:, :, unknowns] * unit,
        examined,
        np.stack((low, high)),
    )


def _reachable(lengths: Array, anchors: Array, attachments: Array, tolerance: float) -> tuple[Array, Array]:
    """Least and greatest ``(x, y, phi)`` of a box that holds every planar pose that explains lengths, rounded out."""
    reach = ((lengths + np.hypot(*attachments.T) + tolerance) * (1.0 + 2.0**-50))[:, None] + 2.0**-50 * np.abs(anchors)
    low, high = (anchors - reach).max(axis=0), (anchors + reach).min(axis=0)
    return np.append(low, SEED_ANGLE - np.pi), np.append(high, SEED_ANGLE + np.pi)


def _none(low: Array, high: Array) -> EveryPose:
    """No pose, proved without a search."""
    return EveryPose(
        position=np.empty((0, 3)),
        rotation=np.empty((0, 3, 3)),
        residual=np.empty(0),
        boxes=np.empty((0, 2, 3)),
        spread=np.empty(0),
        complete=True,
        undecided=np.empty((0, 2, 3)),
        examined=0,
        box=np.stack((low, high)),
    )


def _measured(lengths: ArrayLike, m: int, tolerance: float | None) -> tuple[Array, float]:
    """Lengths (m,) and the tolerance [m], or what is wrong with them."""
    measured = numbers("lengths", lengths)
    if measured.shape != (m,) or not np.all((measured > 0.0) & (measured < LARGEST)):
        raise InputError("lengths", f"{np.ravel(measured).tolist()}", f"{m} positive finite lengths in metres")
    longest = float(measured.max())
    enough = TOLERANCE * longest if tolerance is None else number("tolerance", tolerance)
    if not LEAST_TOLERANCE * longest <= enough < longest:
        raise InputError(
            "tolerance", f"{enough:g} m", f"from {LEAST_TOLERANCE * longest:g} m to below the longest cable"
        )
    return measured, enough


def _bound(value: ArrayLike, n: int) -> Array:
    """One end of a search box (n,)."""
    bound = np.array(numbers("search box", value))
    if bound.shape != (n,):
        raise InputError("search box", f"shape {bound.shape}", f"{n} finite bounds, each low below its high")
    return bound


def _half(where: str, value: ArrayLike) -> Array:
    """Half sides of a search box (3,)."""
    half = numbers(where, value)
    if half.shape not in ((), (3,)) or not np.all((half > 0.0) & (half < LARGEST)):
        raise InputError(where, f"{np.ravel(half).tolist()}", "one finite number or three, above 0")
    return np.broadcast_to(half, (3,))


def _check_box(low: Array, high: Array) -> None:
    """Refuse a box that is not one."""
    if not np.all((np.abs(low) < LARGEST) & (np.abs(high) < LARGEST) & (low < high)):
        raise InputError(
            "search box", f"{low.tolist()} to {high.tolist()}", f"{len(low)} finite bounds, each low below its high"
        )


def _once(solutions: Array, spreads: Array) -> list[int]:
    """Indices of solutions that are not another one a whole turn on."""
    kept: list[int] = []
    for k, one in enumerate(solutions):
        apart = [one - solutions[j] for j in kept]
        turns = [np.concatenate((gap[:3], np.remainder(gap[3:] + np.pi, 2.0 * np.pi) - np.pi)) for gap in apart]
        if all(np.abs(gap).max() > 1e-9 + 10.0 * spreads[k] for gap in turns):
            kept.append(k)
    return kept


def _rotations(angles: Array) -> Array:
    """``Rz(c) Ry(b) Rx(a)`` of angles (s, 3), (s, 3, 3)."""
    cosine, sine = np.cos(angles).T, np.sin(angles).T
    (ca, cb, cc), (sa, sb, sc) = cosine, sine
    rows = (
        (cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa),
        (sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa),
        (-sb, cb * sa, cb * ca),
    )
    return np.moveaxis(np.array(rows), 2, 0)


def _angles(rotation: Array) -> Array:
    """``(a, b, c)`` of a rotation matrix (3, 3), b within a right angle."""
    return np.array(
        [
            np.arctan2(rotation[2, 1], rotation[2, 2]),
            np.arctan2(-rotation[2, 0], np.hypot(rotation[0, 0], rotation[1, 0])),
            np.arctan2(rotation[1, 0], rotation[0, 0]),
        ]
    )
