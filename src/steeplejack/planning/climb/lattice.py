"""The lattice a climb is searched on: places for each gripper, pairs of places that a pose joins, clocks, and ways.

Places of either gripper stand at equal distances along every pipe; those of the upper one are shifted by the least
distance of the grippers on a straight, so that a full stroke there begins and ends on the lattice. Where something
begins or ends that a gripper may not close on, and where the other gripper is then with the stroke used up, there are
places as well: on straights a way exists if the lattice has one. Between two neighbouring places the middle is looked
at too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from steeplejack.errors import InputError
from steeplejack.planning.climb.clocks import near_clocks, wanted_clocks
from steeplejack.planning.climb.limits import LIMITS, Limit, Machine
from steeplejack.planning.climb.obstructions import Obstructions, obstructions, unobstructed
from steeplejack.planning.climb.pairs import Joined, join
from steeplejack.planning.climb.places import Places, edges, joined_places, passes, places_on
from steeplejack.planning.climb.solids import Solids, obstacles_of
from steeplejack.planning.climb.uses import Uses, uses_of_states
from steeplejack.worksite.pipe_line import Pipe
from steeplejack.worksite.pipe_run import PipeRun

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]

MOST_PLACES = 40_000
SAME_PLACE = 1e-7
"""Places closer than this are one [m]."""


@dataclass(frozen=True)
class Lattice:
    """Everything the search needs.

    Attributes:
        run: What is climbed.
        machine: What climbs.
        step: Distance of neighbouring places [m].
        lower: Places of the lower gripper.
        upper: Places of the upper gripper.
        clocks: (c,) in [0, 2 pi) [rad].
        near: Clocks the linkage reaches from each, (c, b) indices, -1 where there are fewer.
        pairs: (k, 2) places of lower and upper gripper, by lower and then by upper.
        joined: Their poses.
        sides: Index of the clock of either side, (k, 2); -1 where it is none of the lattice's.
        ahead: Pair with the next place of the (upper, lower) gripper, (k, 2); -1 where there is none.
        middles: Clock indices allowed halfway to it, (k, 2 grippers, 2); -2 for any clock, -1 for none.
        lower_passes: Open lower gripper turning between clocks, (n, c, b).
        upper_passes: The same of the upper one.
        uses: What holding alone takes.
        solids: What bars must not meet.
        obstructions: Where they do.
    """

    run: PipeRun
    machine: Machine
    step: float
    lower: Places
    upper: Places
    clocks: Array
    near: Indices
    pairs: Indices
    joined: Joined
    sides: Indices
    ahead: Indices
    middles: Indices
    lower_passes: Flags
    upper_passes: Flags
    uses: Uses
    solids: Solids
    obstructions: Obstructions


def build_lattice(run: PipeRun, machine: Machine, step: float) -> Lattice:
    """Lay the lattice over a run.

    Raises:
        InputError: More places than are searched.
    """
    total = sum(pipe.length for pipe in run.pipes)
    if total / step > MOST_PLACES:
        raise InputError(f"run {run.name}", f"{total:g} m of pipe", f"up to {MOST_PLACES * step:g} m at this stride")
    clocks = wanted_clocks(run, machine)
    near = near_clocks(clocks, machine.robot.rcm.limit)
    lower = _places(run, machine, step, "lower")
    upper = _places(run, machine, step, "upper")
    pairs = _close_pairs(machine, lower, upper)
    joined = join(machine, _at(lower, pairs[:, 0]), _at(upper, pairs[:, 1]))
    useful = np.asarray(joined.allowed.any(axis=1))
    pairs, joined = pairs[useful], joined.only(useful)
    solids = obstacles_of(run)
    free = unobstructed(machine, solids, joined, lower, pairs)
    useful = np.asarray(free.any(axis=1))
    pairs, joined = pairs[useful], replace(joined.only(useful), allowed=free[useful])
    ahead = np.stack([_ahead(pairs, (upper, lower)[g], 1 - g) for g in range(2)], axis=-1)
    middles = np.full((len(pairs), 2, 2), -1, dtype=np.int64)
    for gripper in range(2):
        have = np.flatnonzero(ahead[:, gripper] >= 0)
        ends = [_at(lower, pairs[have, 0]), _at(upper, pairs[have, 1])]
        moving = 1 - gripper
        ends[moving] = _halfway(run, machine, (lower, upper)[moving], pairs[have, moving])
        between = join(machine, ends[0], ends[1])
        middles[have, gripper] = _clock_choice(between, clocks)
    sides = _sides(joined, clocks)
    return Lattice(
        run, machine, step, lower, upper, clocks, near, pairs, joined, sides, ahead, middles,
        _passable(run, machine, lower, clocks, near), _passable(run, machine, upper, clocks, near),
        uses_of_states(run, machine, lower, upper, pairs, joined, sides, clocks, near),
        solids, obstructions(run, machine, solids, lower, pairs, joined, clocks, near),
    )  # fmt: skip


def deciding_limits(run: PipeRun, machine: Machine, step: float) -> set[Limit]:
    """Limits that alone rule out some pair of places of a run: no other limit's relaxing gives a new pose."""
    lower, upper = _places(run, machine, step, "lower"), _places(run, machine, step, "upper")
    pairs = _close_pairs(machine, lower, upper, 1.5)
    joined = join(machine, _at(lower, pairs[:, 0]), _at(upper, pairs[:, 1]))
    broken = (joined.margins < -1e-9).reshape(-1, len(LIMITS))
    length = broken[:, 1] | broken[:, 2]
    alone = broken[broken[:, [0, 3, 4, 5]].sum(axis=1) + length == 1]
    return {limit for limit, some in zip(LIMITS, np.asarray(alone.any(axis=0)), strict=True) if some}


def _places(run: PipeRun, machine: Machine, step: float, gripper: Literal["lower", "upper"]) -> Places:
    """Places of one gripper on all pipes."""
    found: list[Places] = []
    for index, pipe in enumerate(run.pipes):
        origin = (run.start_s if index == 0 else 0.0) + (machine.straight_gaps[0] if gripper == "upper" else 0.0)
        first, last = math.ceil(-origin / step - 1e-9), math.floor((pipe.length - origin) / step + 1e-9)
        grid = origin + step * np.arange(first, last + 1, dtype=np.float64)
        s = _merged(grid, _marks(run, machine, pipe, gripper), pipe.length)
        found.append(places_on(run, machine, index, s))
    return joined_places(found)


def _marks(run: PipeRun, machine: Machine, pipe: Pipe, gripper: Literal["lower", "upper"]) -> Array:
    """Places one gripper has to come to exactly: its edges, and where it is when the other one is at its own."""
    own, least, most = edges(run, machine, pipe), *machine.straight_gaps
    if pipe.name == run.goal_pipe:
        own = np.append(own, run.goal_s) if gripper == "lower" else own
    if most < least:
        return own
    sign = 1.0 if gripper == "upper" else -1.0
    return np.concatenate((own, own + sign * least, own + sign * most))


def _merged(grid: Array, marks: Array, length: float) -> Array:
    """Places of a grid and marks between the ends of a pipe, rising; of two that are one the mark."""
    marks = np.unique(np.round(marks[(marks > -SAME_PLACE) & (marks < length + SAME_PLACE)], 9))
    marks = marks[np.append(True, np.diff(marks) > SAME_PLACE)] if len(marks) else marks
    apart = np.abs(grid[:, None] - marks).min(axis=1, initial=np.inf)
    return np.clip(np.sort(np.concatenate((grid[apart > SAME_PLACE], marks))), 0.0, length)


def _at(places: Places, which: Indices) -> tuple[Array, Array]:
    return places.points[which], places.frames[which]


def _halfway(run: PipeRun, machine: Machine, places: Places, which: Indices) -> tuple[Array, Array]:
    """Points and frames halfway to the next places."""
    return places.only(which).beside(run, machine, 0.5 * (places.s[which + 1] - places.s[which]))


def _close_pairs(machine: Machine, lower: Places, upper: Places, beyond: float = 1.0) -> Indices:
    """Pairs no further apart than limb 2 reaches with its base joint's distance, (k, 2)."""
    far = beyond * float(machine.longest[1]) + abs(float(machine.layout.base[1])) + abs(machine.claw_offset)
    close = KDTree(lower.points).sparse_distance_matrix(KDTree(upper.points), far, output_type="ndarray")
    pairs = np.stack((close["i"], close["j"]), axis=-1).astype(np.int64)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _ahead(pairs: Indices, places: Places, column: int) -> Indices:
    """Index of the pair with the next place of one gripper on the same pipe, -1 where there is none."""
    width = int(pairs.max(initial=0)) + 2
    code = pairs[:, 0] * width + pairs[:, 1]
    wanted = code + (1 if column == 1 else width)
    found = np.searchsorted(code, wanted)
    if not len(code):
        return found
    found = np.minimum(found, len(code) - 1)
    here = pairs[:, column]
    following = np.minimum(here + 1, len(places.pipe) - 1)
    good = (code[found] == wanted) & (places.pipe[following] == places.pipe[here]) & (following > here)
    return np.where(good, found, -1)


def _sides(joined: Joined, clocks: Array) -> Indices:
    """Index of the clock of either side of each pair, -1 where it is none of the lattice's."""
    apart = np.abs((joined.clocks[..., None] - clocks + math.pi) % (2.0 * math.pi) - math.pi)
    best = apart.argmin(axis=-1)
    return np.where(np.take_along_axis(apart, best[..., None], axis=-1)[..., 0] < 1e-4, best, -1)


def _clock_choice(joined: Joined, clocks: Array) -> Indices:
    """Clock index allowed at either side, -2 for any, -1 for none, (k, 2)."""
    choice = np.where(joined.allowed, _sides(joined, clocks), -1)
    choice[joined.coaxial] = np.where(joined.allowed[joined.coaxial], -2, -1)
    return choice


def _passable(run: PipeRun, machine: Machine, places: Places, clocks: Array, near: Indices) -> Flags:
    """Whether the open gripper passes a place while it turns from a clock to one near it, (n, c, b)."""
    passable = np.ones((len(places.s), *near.shape), dtype=np.bool_)
    ends = clocks[np.maximum(near, 0)]
    turn = (ends - clocks[:, None] + math.pi) % (2.0 * math.pi) - math.pi
    middle, half = (clocks[:, None] + 0.5 * turn), 0.5 * np.abs(turn)
    for index, pipe in enumerate(run.pipes):
        mine = places.pipe == index
        for column in range(near.shape[1]):
            for row in range(near.shape[0]):
                passable[mine, row, column] = passes(
                    run, machine, pipe, places.s[mine], middle[row, column : column + 1], float(half[row, column])
                )[:, 0]
    return passable
