"""The fastest way over one lattice, as places of both grippers, or the way to the furthest place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.clocks import turned
from steeplejack.planning.climb.frames import gripper_frames, touching, worst_uses
from steeplejack.planning.climb.lattice import Lattice
from steeplejack.planning.climb.moves import Standing, lower_moves, way
from steeplejack.planning.climb.plan import Hold
from steeplejack.planning.climb.search import shortest_times
from steeplejack.planning.climb.solids import AIR
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.singular_path import check_waypoints
from steeplejack.worksite.pipe_run import PipeRun

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Found:
    """A climb on a lattice.

    Attributes:
        standings: Both grippers closed, from the start on.
        progress: How far the lower gripper is along the way to the goal [m].
        complete: Whether that is the goal.
        duration: By the search [s].
        least: What holding alone takes in the best of the lattice's states; see `uses.Uses`.
    """

    standings: tuple[Standing, ...]
    progress: float
    complete: bool
    duration: float
    least: Array


def search(lattice: Lattice) -> Found:
    """The fastest way over one lattice, ways between pipes proved one at a time."""
    banned, starts = np.empty((0, 2), dtype=np.int64), _start_states(lattice)
    if not len(starts):
        return Found((), lattice.run.start_s, False, 0.0, lattice.uses.least)
    count = 1  # the upper gripper as near as it can be, and wherever it can be if that leads nowhere
    while True:
        path, times, complete = _search_once(lattice, banned, starts[:count])
        bad = _impossible(lattice, path)
        if bad is not None:
            banned = np.append(banned, [bad], axis=0)
        elif complete or count == len(starts):
            break
        else:
            count = len(starts)
    standings = _standings(lattice, path)
    return Found(standings, progress(lattice.run, standings[-1].lower), complete, times, lattice.uses.least)


def progress(run: PipeRun, place: tuple[int, float]) -> float:
    """How far a place is along the way to the goal: along the main pipe, then along the crossing one [m]."""
    index, s = place
    if index == 0:
        return s
    crossing = run.crossings[index - 1]
    return crossing.at + s - crossing.at_other


def _search_once(lattice: Lattice, banned: Indices, starts: Indices) -> tuple[list[int], float, bool]:
    """States from start to goal, or to the furthest reached; the time; whether it is the goal."""
    machine = lattice.machine
    pairs, joined, near = lattice.pairs, lattice.joined, lattice.near
    goal = _goal_pairs(lattice)
    lengths = limb_lengths(machine.layout, joined.poses)
    turns = (lattice.clocks[np.maximum(near, 0)] - lattice.clocks[:, None] + np.pi) % (2.0 * np.pi) - np.pi
    order = np.lexsort((pairs[:, 0], pairs[:, 1]))
    behind = np.full_like(lattice.ahead, -1)
    for gripper in range(2):
        have = np.flatnonzero(lattice.ahead[:, gripper] >= 0)
        behind[lattice.ahead[have, gripper], gripper] = have
    cylinders, gait, tables, uses = machine.robot.cylinders, machine.robot.gait, lattice.obstructions, lattice.uses
    lower, upper = lattice.lower, lattice.upper
    groups = (
        np.searchsorted(pairs[:, 0], np.arange(len(lower.s) + 1)),
        np.searchsorted(pairs[order, 1], np.arange(len(upper.s) + 1)),
        order,
    )
    times, before, reached = shortest_times(
        (joined.coaxial, lattice.sides, joined.allowed, lengths), (pairs, lattice.ahead, behind, lattice.middles),
        (near, turns),
        (uses.of * np.float32(1.0 - 1e-6), uses.kinds, uses.swing_on, uses.swing_off,
         tables.row_of_pair, tables.mechanism, tables.row_of_place, tables.by_upper, tables.by_lower),
        ((upper.holds, lattice.upper_passes, upper.pipe), (lower.holds, lattice.lower_passes, lower.pipe)),
        groups, banned, starts, goal,
        (cylinders.speed, gait.turn_speed, gait.ramp, 2.0 * machine.robot.gripper.close_time),
    )  # fmt: skip
    state = int(reached) if reached >= 0 else _furthest(lattice, times)
    path = [state]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return path[::-1], float(times[state]), bool(reached >= 0)


def _start_states(lattice: Lattice) -> Indices:
    """The lower gripper at the start, the upper one where it can hold, the nearest first; clear of everything."""
    run, pairs, joined, tables = lattice.run, lattice.pairs, lattice.joined, lattice.obstructions
    lower, upper = lattice.lower, lattice.upper
    clock = int(np.argmin(np.abs((lattice.clocks - run.start_clock + np.pi) % (2.0 * np.pi) - np.pi)))
    at_start = (lower.pipe[pairs[:, 0]] == 0) & (np.abs(lower.s[pairs[:, 0]] - run.start_s) < 1e-9)
    good = at_start & lower.holds[pairs[:, 0]] & upper.holds[pairs[:, 1]]
    fits = (joined.coaxial[:, None] | (lattice.sides == clock)) & joined.allowed
    good &= fits.any(axis=1) & (upper.pipe[pairs[:, 1]] == 0)
    for rows, met in (
        (tables.row_of_pair, tables.mechanism[:, clock, 0]),
        (tables.row_of_place[pairs[:, 0]], tables.by_upper[:, clock, 0, 0]),
    ):
        good[rows >= 0] &= ~met[rows[rows >= 0]]
    count, spread = lattice.near.shape
    return (np.flatnonzero(good) * count + clock) * spread


def _goal_pairs(lattice: Lattice) -> NDArray[np.bool_]:
    run = lattice.run
    index = next(i for i, pipe in enumerate(run.pipes) if pipe.name == run.goal_pipe)
    places = lattice.lower
    there = (places.pipe == index) & (places.s >= run.goal_s - 1e-9) & places.holds
    return there[lattice.pairs[:, 0]]


def _furthest(lattice: Lattice, times: Array) -> int:
    """The reached state with the lower gripper furthest on, then the upper one, then the earliest."""
    count, spread = lattice.near.shape
    by_pair = times.reshape(len(lattice.pairs), -1)
    quickest = by_pair.min(axis=1)
    run = lattice.run
    offsets = np.array([0.0] + [one.at - one.at_other for one in run.crossings])
    far = [
        offsets[places.pipe[lattice.pairs[:, column]]] + places.s[lattice.pairs[:, column]]
        for column, places in enumerate((lattice.lower, lattice.upper))
    ]
    reached = np.flatnonzero(np.isfinite(quickest))
    best = reached[np.lexsort((quickest[reached], -far[1][reached], -far[0][reached]))[0]]
    return int(best) * count * spread + int(by_pair[best].argmin())


def _standings(lattice: Lattice, path: list[int]) -> tuple[Standing, ...]:
    """Both grippers' places along a path of states, clocks unwrapped."""
    count, spread = lattice.near.shape
    found: list[Standing] = []
    for state in path:
        pair, upper = state // (count * spread), (state // spread) % count
        lower = int(lattice.near[upper, state % spread])
        low, high = lattice.pairs[pair]
        coaxial = bool(lattice.joined.coaxial[pair])
        side = 0 if coaxial else int(np.flatnonzero((lattice.sides[pair] == upper) & lattice.joined.allowed[pair])[0])
        before = found[-1].upper_clock if found else lattice.run.start_clock
        upper_clock = before + float((lattice.clocks[upper] - before + np.pi) % (2.0 * np.pi) - np.pi)
        lower_clock = upper_clock + float(turned(lattice.clocks, upper, lower))
        x, w, alpha = lattice.joined.poses[pair, side].tolist()
        found.append(
            Standing(
                (int(lattice.lower.pipe[low]), float(lattice.lower.s[low])),
                (int(lattice.upper.pipe[high]), float(lattice.upper.s[high])),
                lower_clock, upper_clock, (x, w, alpha),
            )
        )  # fmt: skip
    return tuple(found)


def _impossible(lattice: Lattice, path: list[int]) -> tuple[int, int] | None:
    """The first pair of states with no way between two pipes that the cylinders can go, or one near a singularity."""
    count, spread = lattice.near.shape
    standings = _standings(lattice, path)
    for state, following, start, end in zip(path, path[1:], standings, standings[1:], strict=False):
        if (start.lower[0], start.upper[0]) == (end.lower[0], end.upper[0]):
            continue
        poses = way(lattice.run, lattice.machine, start, end)
        if (
            poses is None
            or check_waypoints(lattice.machine.layout, poses).verdict != "free"
            or _hindered(lattice, start, end, poses)
        ):
            return state // (count * spread), following // (count * spread)
    return None


def _hindered(lattice: Lattice, start: Standing, end: Standing, poses: Array) -> bool:
    """Whether bars meet something on a way between two pipes, or grip and drives do not bear the robot there."""
    run, machine = lattice.run, lattice.machine
    holds = Hold.UPPER if lower_moves(start, end) else Hold.LOWER
    freedoms = np.append(poses, np.full((len(poses), 1), start.freedoms[3]), axis=1)
    at = (run.pipes[start.lower[0]].name, start.lower[1], start.lower_clock)
    frames = gripper_frames(run, machine, at, np.array(start.freedoms), freedoms, holds)
    if touching(lattice.solids, machine, frames[0], freedoms, AIR, linkage=False).any():
        return True
    places = [(run.pipes[pipe].name, s) for pipe, s in (start.lower, start.upper)]
    return bool((worst_uses(run, machine, frames, freedoms, places, holds) > 1.0).any())
