"""A lost cable: where the platform settles when one of its cables is gone and the winches of the others are locked.

The platform descends from where it was to a local minimum of potential energy under the remaining cables, which can go
slack but not longer (`equilibrium`). The path is the heavily damped fall of `potential.descend`, in steps of a
hundredth of the longest cable, so the minimum is the one downhill of the pose and the sweep is known.

Dynamic overshoot is not included: the real platform swings beyond the settled pose, and tensions peak above the settled
ones (a suddenly applied load doubles them at worst in a linear system). The sweep is of the damped path, no envelope of
the swing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
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
        InputError: The pose is not usable, or a cable has no length there.
    """
    place, turn = start_of(platform, position, rotation)
    lengths, _along = pulley_runs(
        platform.anchors, platform.axes, platform.radii, place + platform.attachments @ turn.T
    )
    if not np.all(lengths > 0.0):
        raise InputError("position", "a cable has no course there", "attachments away from anchors and pulleys")
    strain = np.maximum(np.asarray(tensions, dtype=np.float64), 0.0) / platform.axial_stiffness
    return replace(platform, unstressed=lengths / (1.0 + strain))


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
        InputError: No such cable, no other cable, or a pose that is not usable.
    """
    _check([cable], platform)
    place, turn = start_of(platform, position, rotation)
    spring = springs(platform, platform.unstressed, platform.axial_stiffness)
    spring[cable] = 0.0
    fall = fall_of(
        platform,
        platform.unstressed,
        spring,
        place,
        turn,
        stride * float(platform.unstressed.max()),
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
    tensions: ArrayLike = 0.0,
    cables: Sequence[int] | None = None,
    corners: ArrayLike | None = None,
    stride: float = STRIDE,
) -> LostCableMap:
    """Where the platform settles from each of many poses for each cable lost, the winches locked at that pose.

    Args:
        platform: Its unstressed lengths are not read.
        positions: Of the reference point, (k, 2) or (k, 3) [m].
        rotations: (k, 3, 3), or angles (k,) of a planar platform [rad].
        tensions: In elastic cables before the loss, (k, m), (m,) or a scalar [N].
        cables: Which to lose, each alone; every one by default.
        corners: Points of the platform whose sweep is asked for, (c, 2) or (c, 3) [m]; the attachments by default.
        stride: Longest step of the path over the longest cable [1].

    Returns:
        The map; a pose that is not finite has status ``UNDEFINED``.

    Raises:
        InputError: No such cable, no other cable, or shapes that do not fit.
    """
    lost = np.arange(len(platform.anchors)) if cables is None else np.asarray(cables, dtype=np.int64)
    _check(lost.tolist(), platform)
    places = np.asarray(positions, dtype=np.float64)
    turns = np.asarray(rotations, dtype=np.float64)
    if places.ndim != 2 or places.shape[1] != (2 if platform.in_plane else 3) or len(turns) != len(places):
        raise InputError("positions", f"shape {places.shape}", "(k, d), and as many rotations")
    turns = turn_about_z(turns) if platform.in_plane and turns.ndim == 1 else turns
    starts, shape, m = in_space(places), (len(places), len(lost)), len(platform.anchors)
    ends = starts[:, None] + platform.attachments @ np.swapaxes(turns, -1, -2)
    lengths, _along = pulley_runs(platform.anchors, platform.axes, platform.radii, ends)
    strain = np.maximum(np.asarray(tensions, dtype=np.float64), 0.0) / platform.axial_stiffness
    unstressed = lengths / (1.0 + strain)
    position, rotation = np.full((*shape, 3), np.nan), np.full((*shape, 3, 3), np.nan)
    pull, boxes = np.full((*shape, m), np.nan), np.full((*shape, 2, 2, 3), np.nan)
    status, around = np.full(shape, Rest.UNDEFINED, dtype=np.int64), _corners(platform, corners)
    for k in np.flatnonzero(np.all((unstressed > 0.0) & np.isfinite(unstressed), axis=-1)):
        spring = springs(platform, unstressed[k], platform.axial_stiffness)
        step = stride * float(unstressed[k].max())
        for c, cable in enumerate(lost):
            left = np.where(np.arange(m) == cable, 0.0, spring)
            fall = fall_of(platform, unstressed[k], left, starts[k], turns[k], step, 0, around)
            position[k, c], rotation[k, c] = fall.position - fall.rotation @ platform.points[0], fall.rotation
            pull[k, c], boxes[k, c], status[k, c] = fall.tensions, fall.box, fall.status
    with np.errstate(invalid="ignore"):
        taut = pull > SLACK * np.maximum(platform.load, pull.max(axis=-1, keepdims=True))
    return LostCableMap(
        position,
        rotation,
        np.where(taut | np.isnan(pull), pull, 0.0),
        taut,
        (position - starts[:, None]) @ _down(platform),
        boxes[:, :, 0],
        boxes[:, :, 1],
        status,
    )


def _check(cables: Sequence[int], platform: LockedPlatform) -> None:
    """Refuse a cable that is not there, and the loss of the only one."""
    m = len(platform.anchors)
    for cable in cables:
        if not 0 <= cable < m:
            raise InputError("cable", f"{cable}", f"0 to {m - 1}")
    if m < 2:
        raise InputError("cable", "the only one", "a platform with at least two cables")


def _corners(platform: LockedPlatform, corners: ArrayLike | None) -> Array:
    """Corners (c, 3) [m]."""
    return (
        platform.attachments
        if corners is None
        else in_space(np.asarray(corners, dtype=np.float64).reshape(-1, 2 if platform.in_plane else 3))
    )


def _down(platform: LockedPlatform) -> Array:
    """Unit vector of the weight (3,), not a number without one."""
    size = float(np.linalg.norm(platform.forces[0]))
    return platform.forces[0] / size if size > 0.0 else np.full(3, np.nan)
