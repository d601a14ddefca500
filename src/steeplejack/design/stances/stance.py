"""The best stance at one place of the platform: the question, and its answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.design.stances import worth as kernels
from steeplejack.design.stances.ground import Ground
from steeplejack.design.stances.search import best_stances
from steeplejack.design.stances.weigh import by_forces, room_about
from steeplejack.errors import InputError

Array = NDArray[np.float64]

TOLERANCE = 0.01
"""Last step of the search along a stay [m]."""
STARTS = 6
"""Nodes of the grid that the search climbs from."""
COUNTS = {1: 121, 2: 31, 3: 13, 4: 9, 5: 5, 6: 5}
"""Nodes of the grid for each of so many movable bases."""


class Statics(StrEnum):
    """What must balance: forces in the plane at one point; forces and the moment in the plane; forces in space.

    In space the four tensions balance the forces and the platform turns until no moment is left, so its orientation
    is not chosen; the one given is a guess that moves the attachments by little next to the cables' length.
    """

    POINT = "point in the plane"
    BODY = "body in the plane"
    SPACE = "in space"


class Objective(StrEnum):
    """What the stance shall have most of, over the tensions that hold every load of the wrench set.

    - slip margin: the least over bases of 1 - pull along the stay / pull held [1]; below 0 a base would slip;
    - largest tension: its negative [N], no base slipping;
    - capacity margin: the least distance of the loads from a facet of the wrenches that the cables can exert with no
      base slipping [N]; below 0 where a load is not held.
    """

    SLIP = "slip margin"
    TENSION = "largest tension"
    CAPACITY = "capacity margin"


@dataclass(frozen=True, eq=False)
class BestStance:
    """Where the bases stand and what it is worth.

    Attributes:
        s: Place of each base along its stay (m,) [m]; not a number where none is admitted.
        worth: The objective there; ``-inf`` where no tensions within their window hold the loads.
        best: The largest value found; ``worth`` is less by at most the slack given up for less driving.
        driving: Sum over the bases of what they drive from where they stand [m].
        held: Whether every load is held, no base slipping.
    """

    s: Array
    worth: float
    best: float
    driving: float
    held: bool


def choose_stance(
    ground: Ground,
    position: ArrayLike,
    loads: ArrayLike,
    now: ArrayLike,
    within: float,
    statics: Statics = Statics.BODY,
    objective: Objective = Objective.SLIP,
    arms: ArrayLike | None = None,
    movable: Sequence[int] | None = None,
    slack: float = 0.0,
) -> BestStance:
    """The stance that holds a platform best at one place, and of those within ``slack`` the one nearest to ``now``.

    The outer search is numerical (a grid, then compass search), the inner problem exact.

    Args:
        ground: Stays, limits; see `straight` and `on_bay`.
        position: Of the platform (2,) or (3,) [m].
        loads: Wrench set by its vertices, each acting on the platform: forces (v, 2) at a point, (fx, fy, mz) in the
            plane, forces (v, 3) in space; [N] and [N m].
        now: Where the bases stand along their stays (m,) [m].
        within: How far along its stay a movable base may be from the place of ``now`` [m].
        statics: What must balance.
        objective: What to have most of.
        arms: Attachments from the position, turned with the platform (m, 2) or (m, 3) [m]; none at a point.
        movable: Bases that may move, from 0; all by default.
        slack: Of the objective that less driving may cost.

    Returns:
        The best stance found.

    Raises:
        InputError: Shapes that do not fit, or values that are not finite.
    """
    m = ground.bases
    stand = np.array(now, dtype=float)
    chosen = tuple(range(m)) if movable is None else tuple(movable)
    if stand.shape != (m,) or not np.isfinite(stand).all():
        raise InputError("now", f"shape {stand.shape}", f"a finite place for each of {m} bases")
    if len(set(chosen)) < len(chosen) or not set(chosen) <= set(range(m)):
        raise InputError("movable", str(list(chosen)), f"different bases of 0 to {m - 1}")
    if not (np.isfinite(within) and within >= 0.0 and np.isfinite(slack) and slack >= 0.0):
        raise InputError("within, slack", f"{within:g}, {slack:g}", "finite numbers that are not negative")
    room = room_about(ground, stand[None], within)
    fixed = [base for base in range(m) if base not in chosen]
    room.windows[:, fixed] = stand[fixed, None]
    worth = by_forces(
        list(Objective).index(objective),
        list(Statics).index(statics),
        ground,
        room,
        _solid("position", position, 1, statics),
        (np.zeros((m, 3)) if arms is None else _solid("arms", arms, m, statics))[None],
        _wrenches(loads, statics, float(ground.machine[2])),
        ground.limits[None],
    )
    found = best_stances(worth, room, stand[None], COUNTS.get(len(chosen), 3), STARTS, TOLERANCE, slack)
    s, value, most = found.s[0], float(found.worth[0]), float(found.best[0])
    nothing = value < kernels.NOTHING if objective is not Objective.CAPACITY else value == -np.inf
    held = not nothing and bool(value >= 0.0 or objective is Objective.TENSION)
    driven = float(np.sum(np.abs(s - stand)))
    return BestStance(s, -np.inf if nothing else value, -np.inf if nothing else most, driven, held)


def _solid(name: str, values: ArrayLike, rows: int, statics: Statics) -> Array:
    """Points as the kernels take them: a plane's lie at z = 0."""
    points = np.atleast_2d(np.asarray(values, dtype=float))
    size = 3 if statics is Statics.SPACE else 2
    if points.shape != (rows, size) or not np.isfinite(points).all():
        raise InputError(name, f"shape {np.shape(values)}", f"finite, {rows} of {size} coordinates")
    padded = np.zeros((rows, 3))
    padded[:, :size] = points
    return padded


def _wrenches(loads: ArrayLike, statics: Statics, length: float) -> Array:
    """Vertices of a wrench set (v, 3), moments divided by the length."""
    vertices = np.atleast_2d(np.asarray(loads, dtype=float))
    size = 2 if statics is Statics.POINT else 3
    if vertices.ndim != 2 or vertices.shape[1] != size or not len(vertices) or not np.isfinite(vertices).all():
        raise InputError("loads", f"shape {np.shape(loads)}", f"finite, (v, {size})")
    padded = np.zeros((len(vertices), 3))
    padded[:, :size] = vertices
    if statics is Statics.BODY:
        padded[:, 2] /= length
    return padded
