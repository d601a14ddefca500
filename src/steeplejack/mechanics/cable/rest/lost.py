"""A lost cable: where the platform settles when one of its cables is gone and the winches of the others are locked.

The platform descends from where it was to a local minimum of potential energy under the remaining cables, which can go
slack but not longer (`equilibrium`). The path is the heavily damped fall of `potential.descend`, in steps of a
hundredth of the longest cable, so the minimum is the one downhill of the pose and the sweep is known.

Dynamic overshoot is not included: the real platform swings beyond the settled pose, and tensions peak above the settled
ones (a suddenly applied load doubles them at worst in a linear system). The sweep is of the damped path, no envelope of
the swing.

Policy for bad input. What cannot be a question (no such cable, shapes that do not fit, a stride that is none, tensions
that are not numbers) raises `InputError`. In a map a pose that is not finite, whose rotation is none, or at which a
cable has no course, has status ``UNDEFINED`` and numbers that are none; it stops no other pose.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import kind, number, numbers, rotation_matrices, vectors, whole
from steeplejack.mechanics.cable.pulleys import in_space, pulley_runs
from steeplejack.mechanics.cable.rest.equilibrium import (
    SLACK,
    Equilibrium,
    Rest,
    fall_of,
    rest_of,
    springs,
    start_of,
)
from steeplejack.mechanics.cable.rest.locked import LockedPlatform
from steeplejack.mechanics.cable.rest.stiffness import turn_about_z

Array = NDArray[np.float64]

STRIDE = 0.01  # [1] longest step of the path over the longest cable
RECORD = 4000  # poses of a path that are kept
SHORT = 1e-12  # [1] length over the longest cable below which there is none but rounding


@dataclass(frozen=True, eq=False)
class LostCable:
    """Where the platform settles without a cable, and what it sweeps on the way; in space also for planar robots.

    Attributes:
        rest: The settled pose with tensions and stability; the lost cable's tension is 0.
        drop: How far the reference point sinks along gravity; not a number without a weight [m].
        reference_box: Least and greatest coordinates of the reference point along the path, (2, 3) [m].
        corner_box: The same over all corners, (2, 3) [m].
        positions: The reference point along the path, (k, 3) [m].
        rotations: (k, 3, 3).
    """

    rest: Equilibrium
    drop: float
    reference_box: Array
    corner_box: Array
    positions: Array
    rotations: Array


@dataclass(frozen=True, eq=False)
class LostCableMap:
    """Where the platform settles for every pose (k) and every cable lost (l).

    Attributes:
        position: Of the reference point, (k, l, 3) [m].
        rotation: (k, l, 3, 3).
        tensions: (k, l, m) [N].
        taut: (k, l, m).
        drop: Of the reference point along gravity, (k, l) [m].
        reference_box: (k, l, 2, 3) [m].
        corner_box: (k, l, 2, 3) [m].
        status: ``Rest`` by number, neutral rests counting as stable ones, (k, l).
    """

    position: Array
    rotation: Array
    tensions: Array
    taut: NDArray[np.bool_]
    drop: Array
    reference_box: Array
    corner_box: Array
    status: NDArray[np.int64]

    @property
    def settled(self) -> NDArray[np.bool_]:
        """Where the platform comes to rest, (k, l)."""
        return (self.status == Rest.STABLE) | (self.status == Rest.NEUTRAL)

    @property
    def greatest_tension(self) -> Array:
        """Of the cables that are left, at rest, (k, l) [N]."""
        return self.tensions.max(axis=-1)

    def lowest(self, up: ArrayLike) -> Array:
        """Least height that a corner is at on the way, along an axis of the world, (k, l) [m].

        Args:
            up: Plus or minus one of the world's axes, (3,).

        Raises:
            InputError: Another direction, along which a box of coordinates says too little.
        """
        direction = numbers("up", up)
        if direction.shape != (3,) or sorted(np.abs(direction).tolist()) != [0.0, 0.0, 1.0]:
            raise InputError("up", f"{direction.tolist()}", "plus or minus one of the world's axes")
        return np.minimum(self.corner_box[:, :, 0] @ direction, self.corner_box[:, :, 1] @ direction)


def locked_at(
    platform: LockedPlatform, position: ArrayLike, rotation: ArrayLike, tensions: ArrayLike = 0.0
) -> LockedPlatform:
    """The platform with its winches locked at a pose.

    Args:
        platform: Whose unstressed lengths are to be replaced.
        position: Of the reference point, (2,) or (3,) [m].
        rotation: (3, 3), or the angle phi of a planar platform [rad].
        tensions: In elastic cables at that pose, (m,) or a scalar [N].

    Returns:
        The platform with ``L = l / (1 + t / EA)``.

    Raises:
        InputError: The pose or a tension is not usable, or a cable has no length there.
    """
    place, turn = start_of(platform, position, rotation)
    lengths, _along = pulley_runs(
        platform.anchors, platform.axes, platform.radii, place + platform.attachments @ turn.T
    )
    if not _have_length(lengths):
        raise InputError("position", "a cable has no course there", "attachments away from anchors and pulleys")
    return replace(platform, unstressed=lengths / (1.0 + _strain(platform, tensions, ())))


def lost_cable(
    platform: LockedPlatform,
    cable: int,
    position: ArrayLike,
    rotation: ArrayLike,
    *,
    corners: ArrayLike | None = None,
    stride: float = STRIDE,
) -> LostCable:
    """Where the platform settles from a pose when a cable is lost.

    Args:
        platform: With all its cables, see `locked_at`.
        cable: Index of the one lost.
        position: Of the reference point at that moment, (2,) or (3,) [m].
        rotation: (3, 3), or the angle phi of a planar platform [rad].
        corners: Points of the platform whose sweep is asked for, (c, 2) or (c, 3) [m]; the attachments by default.
        stride: Longest step of the path over the longest cable [1].

    Returns:
        The settled pose, the drop and the sweep; read the status of the rest.

    Raises:
        InputError: No such cable, no other cable, or a pose, corner or stride that is not usable.
    """
    (index,), step = _check([cable], platform, stride)
    place, turn = start_of(platform, position, rotation)
    spring = springs(platform, platform.unstressed, platform.axial_stiffness)
    spring[index] = 0.0
    fall = fall_of(
        platform,
        platform.unstressed,
        spring,
        place,
        turn,
        step * float(platform.unstressed.max()),
        RECORD,
        _corners(platform, corners),
    )
    rest = rest_of(platform, platform.unstressed, spring, fall)
    path = fall.path_positions - fall.path_rotations @ platform.points[0]
    return LostCable(
        rest,
        float((rest.position - place) @ _down(platform)),
        fall.box[0],
        fall.box[1],
        path,
        fall.path_rotations,
    )


def lost_cable_map(
    platform: LockedPlatform,
    positions: ArrayLike,
    rotations: ArrayLike,
    *,
    anchors: ArrayLike | None = None,
    tensions: ArrayLike = 0.0,
    cables: Sequence[int] | None = None,
    corners: ArrayLike | None = None,
    stride: float = STRIDE,
    progress: Callable[[int], None] | None = None,
) -> LostCableMap:
    """Where the platform settles from each of many poses for each cable lost, the winches locked at that pose.

    Args:
        platform: Its unstressed lengths are not read.
        positions: Of the reference point, (k, 2) or (k, 3) [m].
        rotations: (k, 3, 3), or angles (k,) of a planar platform [rad].
        anchors: Where they stand at each pose, (k, m, d) [m]; those of the platform by default.
        tensions: In elastic cables before the loss, (k, m), (m,) or a scalar [N].
        cables: Which to lose, each alone; every one by default.
        corners: Points of the platform whose sweep is asked for, (c, 2) or (c, 3) [m]; the attachments by default.
        stride: Longest step of the path over the longest cable [1].
        progress: Told after each pose how many are done.

    Returns:
        The map; a pose that is not usable has status ``UNDEFINED``.

    Raises:
        InputError: No such cable, no other cable, shapes that do not fit, or a stride that is not usable.
    """
    kind("platform", platform, LockedPlatform)
    lost, step = _check(range(len(platform.anchors)) if cables is None else cables, platform, stride)
    places, turns, fixed = _poses(platform, positions, rotations, anchors)
    strain, around = _strain(platform, tensions, (len(places),)), _corners(platform, corners)
    table = _empty(len(places), len(lost), len(platform.anchors))
    ends = places[:, None] + platform.attachments @ np.swapaxes(turns, -1, -2)
    for k in range(len(places)):
        lengths, _along = pulley_runs(fixed[k], platform.axes, platform.radii, ends[k])
        unstressed = lengths / (1.0 + strain[k])
        if _have_length(unstressed):
            locked = replace(platform, anchors=fixed[k], unstressed=unstressed)
            _settle_each(table, k, locked, lost, places[k], turns[k], step, around)
        if progress is not None:
            progress(k + 1)
    table.drop[:] = (table.position - places[:, None]) @ _down(platform)
    with np.errstate(invalid="ignore"):
        table.taut[:] = table.tensions > SLACK * np.maximum(
            platform.load, table.tensions.max(axis=-1, keepdims=True, initial=0.0)
        )
    table.tensions[~table.taut & ~np.isnan(table.tensions)] = 0.0
    return table


def _have_length(lengths: Array) -> bool:
    """Whether every cable has a course, and a length that is not rounding."""
    return bool(np.isfinite(lengths).all() and np.all(lengths > SHORT * lengths.max(initial=0.0)))


def _settle_each(
    table: LostCableMap,
    k: int,
    platform: LockedPlatform,
    lost: Sequence[int],
    position: Array,
    rotation: Array,
    stride: float,
    corners: Array,
) -> None:
    """Write row k of a map: what happens at one pose when each of the cables is lost."""
    spring = springs(platform, platform.unstressed, platform.axial_stiffness)
    step = stride * float(platform.unstressed.max())
    for c, cable in enumerate(lost):
        left = np.where(np.arange(len(spring)) == cable, 0.0, spring)
        fall = fall_of(platform, platform.unstressed, left, position, rotation, step, 0, corners)
        table.position[k, c] = fall.position - fall.rotation @ platform.points[0]
        table.rotation[k, c], table.tensions[k, c], table.status[k, c] = fall.rotation, fall.tensions, fall.status
        table.reference_box[k, c], table.corner_box[k, c] = fall.box


def _empty(poses: int, lost: int, cables: int) -> LostCableMap:
    """A map of nothing yet."""
    shape = (poses, lost)
    return LostCableMap(
        position=np.full((*shape, 3), np.nan),
        rotation=np.full((*shape, 3, 3), np.nan),
        tensions=np.full((*shape, cables), np.nan),
        taut=np.zeros((*shape, cables), dtype=np.bool_),
        drop=np.full(shape, np.nan),
        reference_box=np.full((*shape, 2, 3), np.nan),
        corner_box=np.full((*shape, 2, 3), np.nan),
        status=np.full(shape, Rest.UNDEFINED, dtype=np.int64),
    )


def _poses(
    platform: LockedPlatform, positions: ArrayLike, rotations: ArrayLike, anchors: ArrayLike | None
) -> tuple[Array, Array, Array]:
    """Positions (k, 3), rotations (k, 3, 3) and anchors (k, m, 3) in space; what is no pose is not a number."""
    d, m = (2 if platform.in_plane else 3), len(platform.anchors)
    places, turns = vectors("positions", positions, d), numbers("rotations", rotations)
    if places.ndim != 2:
        raise InputError("positions", f"shape {places.shape}", f"(k, {d})")
    k = len(places)
    if turns.shape != (k, 3, 3) and not (platform.in_plane and turns.shape == (k,)):
        raise InputError("rotations", f"shape {turns.shape}", f"({k}, 3, 3), or angles ({k},) in the plane")
    turns = rotation_matrices("rotations", turn_about_z(turns) if turns.ndim == 1 else turns)
    fixed = platform.anchors if anchors is None else in_space(vectors("anchors", anchors, m, d))
    if fixed.shape not in ((m, 3), (k, m, 3)):
        raise InputError("anchors", f"shape {fixed.shape}", f"({k}, {m}, {d}), those of each pose")
    return in_space(places), turns, np.broadcast_to(fixed, (k, m, 3))


def _strain(platform: LockedPlatform, tensions: ArrayLike, lead: tuple[int, ...]) -> Array:
    """Strain ``t / EA`` of the cables, none where slack, (..., m) [1]."""
    given, m = numbers("tensions", tensions), len(platform.anchors)
    if given.shape not in ((), (m,), (*lead, m)) or not np.isfinite(given).all():
        raise InputError("tensions", f"shape {given.shape}", f"one finite number, ({m},) or {(*lead, m)} in N")
    return np.broadcast_to(np.maximum(given, 0.0) / platform.axial_stiffness, (*lead, m))


def _check(cables: Sequence[int], platform: LockedPlatform, stride: float) -> tuple[list[int], float]:
    """Cables to lose and the stride; refuses a cable that is not there, the loss of the only one, and tiny steps."""
    m, step = len(kind("platform", platform, LockedPlatform).anchors), number("stride", stride)
    try:
        asked = list(cables)
    except TypeError:
        raise InputError("cables", f"{cables!r}", "a list of them") from None
    lost = [whole("cable", cable, 0, m - 1) for cable in asked]
    if m < 2:
        raise InputError("cable", "the only one", "a platform with at least two cables")
    if not 1e-6 <= step <= 1.0:
        raise InputError("stride", f"{step:g}", "a share of the longest cable from 1e-6 to 1")
    return lost, step


def _corners(platform: LockedPlatform, corners: ArrayLike | None) -> Array:
    """Corners (c, 3) [m]."""
    if corners is None:
        return platform.attachments
    points = vectors("corners", corners, 2 if platform.in_plane else 3)
    if points.ndim != 2 or len(points) == 0 or not np.isfinite(points).all():
        raise InputError("corners", f"shape {points.shape}", "at least one finite point in metres")
    return in_space(points)


def _down(platform: LockedPlatform) -> Array:
    """Unit vector of the weight (3,), not a number without one."""
    size = float(np.linalg.norm(platform.forces[0]))
    return platform.forces[0] / size if size > 0.0 else np.full(3, np.nan)
