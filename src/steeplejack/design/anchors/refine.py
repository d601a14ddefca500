"""Continuous refinement of a path of configurations: the places of its stops move, who stops when does not.

Each stretch of poses over which a base stands is one unknown place. Tensions come along as unknowns, so the objective
is linear and only the balance of forces is not; it is linearised about the present answer and the linear program is
solved within a trust region, which shrinks where the true objective does not follow (sequential linear programming).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import linprog

from steeplejack.design.anchors.drives import STILL, drive_orders, driven
from steeplejack.design.anchors.problem import Reconfiguration
from steeplejack.design.anchors.worth import GRIPPED, Duty, worth_of

Array = NDArray[np.float64]

ROUNDS = 60
ENOUGH = 1e-7  # [m] trust region at which refinement ends


def net_worth(problem: Reconfiguration, offsets: Array, duty: Duty, price: float) -> float:
    """Mean objective over the poses less the price of what is driven.

    Args:
        problem: Anchors, platform and path.
        offsets: Along x, (k, 4) [m].
        duty: What is borne and what counts.
        price: Of a metre driven along a stay, in units of the mean objective [1/m].

    Returns:
        Poses that are not held count 0.
    """
    return float(np.mean(worth_of(problem, offsets, duty)[0])) - price * float(driven(problem, offsets).sum())


def refine(
    problem: Reconfiguration,
    offsets: Array,
    duty: Duty,
    price: float,
    region: float,
    most_step: float = np.inf,
    start: Array | None = None,
    split: bool = False,
) -> Array:
    """Move the stops of a path to better places.

    Args:
        problem: Anchors, platform and path.
        offsets: Along x, (k, 4) [m].
        duty: What is borne and what counts.
        price: Of a metre driven along a stay, in units of the mean objective [1/m].
        region: First trust region: how far a stop moves in one round [m].
        most_step: Farthest a base drives between two poses, along its stay [m].
        start: Offsets the bases stand at, at the first pose (4,) [m]; None if free to choose.
        split: Let a base drive at every pose, so that who stops when may change too.

    Returns:
        Offsets (k, 4) [m], never worth less, holding wherever the given ones hold and driving in an order that holds
        wherever the given ones have one.
    """
    stops = _Stops.of(offsets, split)
    task = _Task(problem, stops, duty, price, most_step, start)
    places, best = stops.places(offsets), net_worth(problem, offsets, duty, price)
    safe = _safe(problem, offsets, duty)
    tensions = _program(task, places, 0.0, None)[1]
    for _round in range(ROUNDS):
        if region < ENOUGH or tensions is None:
            break
        trial, next_tensions = _program(task, places, region, tensions)
        path = stops.path(trial)
        value = net_worth(problem, path, duty, price)
        if next_tensions is None or value <= best or np.any(safe & ~_safe(problem, path, duty)):
            region *= 0.35
            continue
        places, best, tensions = trial, value, next_tensions
    return stops.path(places)


@dataclass(frozen=True)
class _Stops:
    """Which unknown place each base stands at, pose by pose."""

    index: NDArray[np.int64]  # (k, 4)

    @classmethod
    def of(cls, offsets: Array, split: bool) -> _Stops:
        change = np.vstack([np.ones((1, 4), bool), (np.abs(np.diff(offsets, axis=0)) > STILL) | split])
        counts = np.cumsum(change, axis=0) - 1
        firsts = np.concatenate([[0], np.cumsum(counts[-1] + 1)[:-1]])
        return cls(counts + firsts)

    def places(self, offsets: Array) -> Array:
        """Unknowns (s,) [m] of a path."""
        out = np.empty(int(self.index.max()) + 1)
        out[self.index] = offsets
        return out

    def path(self, places: Array) -> Array:
        """Path (k, 4) [m] of unknowns."""
        return places[self.index]


@dataclass(frozen=True)
class _Task:
    """What stays the same from round to round."""

    problem: Reconfiguration
    stops: _Stops
    duty: Duty
    price: float
    most_step: float
    start: Array | None


def _safe(problem: Reconfiguration, offsets: Array, duty: Duty) -> NDArray[np.bool_]:
    """Poses held (k,), then drives with an order that holds (k - 1,)."""
    held = (worth_of(problem, offsets, duty)[1] & GRIPPED) > 0
    driven_safely = np.array([order is not None for order in drive_orders(problem, offsets, duty)], dtype=bool)
    return np.concatenate([held, driven_safely])


def _columns(problem: Reconfiguration, offsets: Array) -> tuple[Array, Array, Array, Array]:
    """Columns of the structure matrix (k, 4, 3), shares of the pull along the stay (k, 4), and both by offset."""
    cos, sin = np.cos(problem.poses[:, 2]), np.sin(problem.poses[:, 2])
    rotation = np.stack([np.stack([cos, -sin], -1), np.stack([sin, cos], -1)], -2)
    arms = np.einsum("kij,mj->kmi", rotation, problem.attachments)
    cables = problem.placed(offsets) - problem.poses[:, None, :2] - arms
    lengths = np.linalg.norm(cables, axis=-1, keepdims=True)
    u = cables / lengths
    slope = (problem.directions - u * np.sum(u * problem.directions, axis=-1, keepdims=True)) / lengths
    along = problem.directions / np.linalg.norm(problem.directions, axis=-1, keepdims=True)
    pull, by = np.sum(u * along, axis=-1), np.sum(slope * along, axis=-1)
    return _with_moment(u, arms), np.abs(pull), _with_moment(slope, arms), np.sign(pull) * by


def _with_moment(force: Array, arms: Array) -> Array:
    moment = arms[..., 0] * force[..., 1] - arms[..., 1] * force[..., 0]
    return np.concatenate([force, moment[..., None]], axis=-1)


def _program(task: _Task, places: Array, region: float, tensions: Array | None) -> tuple[Array, Array | None]:
    """One linear program: changed places (s,) and tensions (h, 4) of the held poses; None where it has no answer.

    Unknowns are the changes of the places (s), tensions (4 h), the objective of each pose (h) and the drives.
    """
    problem, stops, duty = task.problem, task.stops, task.duty
    offsets = stops.path(places)
    poses = np.flatnonzero((worth_of(problem, offsets, duty)[1] & GRIPPED) > 0)
    h, s, index = len(poses), len(places), stops.index[poses]
    columns, share, by_columns, by_share = (part[poses] for part in _columns(problem, offsets))
    fixed = np.zeros((h, 4)) if tensions is None else tensions
    load, scale, window = _loading(duty)
    balance = _balance(columns, by_columns, fixed, index, s, load / scale, problem)
    upper = _objective_rows(share, by_share, fixed, index, s, duty, scale)
    drives, count = _drive_rows(problem, stops, places, h)
    low, high = _room(task, places, region)
    bounds = [(low, high), *(([a] * n, [b] * n) for a, b, n in ((*window, 4 * h), (-np.inf, np.inf, h)))]
    bounds.append(([0.0] * count, [task.most_step] * count))
    found: Array | None = linprog(
        np.concatenate([np.zeros(s + 4 * h), np.full(h, -1.0 / len(offsets)), np.full(count, task.price)]),
        A_ub=sparse.vstack([_widened(*upper, count), drives[0]]),
        b_ub=np.concatenate([upper[1], drives[1]]),
        A_eq=_widened(*balance, count),
        b_eq=balance[1],
        bounds=np.concatenate([np.stack(pair, -1) for pair in bounds]),
        method="highs",
    ).x
    if found is None:
        return places, None
    return places + found[:s], found[s : s + 4 * h].reshape(h, 4)


def _loading(duty: Duty) -> tuple[Array, float, tuple[float, float]]:
    """Weight (3,) [N], the unit forces are counted in [N], and the window of tensions in it.

    The tension factor is a matter of the null vector alone, scaled to a largest tension of one.
    """
    if duty.objective == "tension-factor":
        return np.zeros(3), 1.0, (0.0, 1.0)
    load = np.append(duty.load[0] * duty.load[3:5], 0.0)
    scale = max(float(np.linalg.norm(load)), duty.window[0])
    return load, scale, (duty.window[0] / scale, duty.window[1] / scale)


def _room(task: _Task, places: Array, region: float) -> tuple[Array, Array]:
    """How far each place may move (s,) [m]: within its window and the trust region, not from where the bases start."""
    window = task.problem.windows[_owners(task.stops)]
    low, high = np.maximum(window[:, 0] - places, -region), np.minimum(window[:, 1] - places, region)
    if task.start is not None:
        low[task.stops.index[0]] = high[task.stops.index[0]] = 0.0
    return low, np.maximum(low, high)


def _widened(matrix: sparse.csr_array, right: Array, columns: int) -> sparse.csr_array:
    """The same rows, one a right-hand side, with columns of zeros after them."""
    return sparse.csr_array(sparse.hstack([matrix, sparse.csr_array((len(right), columns))]))


def _balance(
    columns: Array, by: Array, fixed: Array, index: NDArray[np.int64], s: int, load: Array, problem: Reconfiguration
) -> tuple[sparse.csr_array, Array]:
    """Balance of forces, linearised in places: columns f + sum (d column / d v) f0 dv = -load."""
    h = len(columns)
    arm = float(np.abs(problem.attachments).max()) or 1.0
    weight = np.array([1.0, 1.0, 1.0 / arm])
    k, i, r = np.meshgrid(np.arange(h), np.arange(4), np.arange(3), indexing="ij")
    row = (3 * k + r).ravel()
    force = (columns * weight).ravel()
    moved = (by * fixed[..., None] * weight).ravel()
    place = np.broadcast_to(index[..., None], k.shape).ravel()
    tension = (s + 4 * k + i).ravel()
    matrix = sparse.csr_array(
        (np.concatenate([moved, force]), (np.tile(row, 2), np.concatenate([place, tension]))), shape=(3 * h, s + 5 * h)
    )
    return matrix, np.tile(-load * weight, h)


def _objective_rows(
    share: Array, by: Array, fixed: Array, index: NDArray[np.int64], s: int, duty: Duty, scale: float
) -> tuple[sparse.csr_array, Array]:
    """Rows of t <= f_i for the tension factor (f_i <= 1), or t <= 1 - pull_i / hold; and pulls within the limit."""
    h = len(share)
    k, i = np.meshgrid(np.arange(h), np.arange(4), indexing="ij")
    row, tension, place, t = (4 * k + i).ravel(), (s + 4 * k + i).ravel(), index.ravel(), (s + 4 * h + k).ravel()
    shape = (4 * h, s + 5 * h)
    if duty.objective == "tension-factor":
        ones = np.ones(4 * h)
        matrix = sparse.csr_array(
            (np.concatenate([ones, -ones]), (np.tile(row, 2), np.concatenate([t, tension]))), shape
        )
        return matrix, np.zeros(4 * h)
    hold = duty.hold / scale
    pull, moved = (share / hold).ravel(), (by * fixed / hold).ravel()
    values = np.concatenate([np.ones(4 * h), pull, moved])
    matrix = sparse.csr_array((values, (np.tile(row, 3), np.concatenate([t, tension, place]))), shape)
    return matrix, np.ones(4 * h)


def _drive_rows(
    problem: Reconfiguration, stops: _Stops, places: Array, h: int
) -> tuple[tuple[sparse.csr_array, Array], int]:
    """Lengths e of the drives between stops: e >= +-(change of place) along the stay."""
    owners = _owners(stops)
    second = np.flatnonzero(np.diff(owners) == 0) + 1
    first, count, s = second - 1, len(second), len(places)
    stretch = np.hypot(problem.directions[:, 0], problem.directions[:, 1])[owners[second]]
    now = stretch * (places[second] - places[first])
    row = np.arange(count)
    entries, rows, columns, right = [], [], [], []
    for half, sign in enumerate((1.0, -1.0)):
        entries += [sign * stretch, -sign * stretch, -np.ones(count)]
        rows += [row + half * count] * 3
        columns += [second, first, s + 5 * h + row]
        right.append(-sign * now)
    matrix = sparse.csr_array(
        (np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))), shape=(2 * count, s + 5 * h + count)
    )
    return (matrix, np.concatenate(right)), count


def _owners(stops: _Stops) -> NDArray[np.int64]:
    """Base (s,) of each stop."""
    owners = np.empty(int(stops.index.max()) + 1, dtype=np.int64)
    owners[stops.index] = np.arange(4)
    return owners
