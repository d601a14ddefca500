"""Why a climb ends and what would change that: the same run solved again with one limit relaxed at a time.

The limit that binds is the one whose relaxing brings the robot to the goal, or else furthest beyond where it stopped.
Relaxed problems are solved on a coarse lattice, and a few answers are enough. Amounts are then halved down to the least
that still does, `HALVINGS` times: to within 3 % of it, but for what goes down to nothing (claw offset, reserve: a
hundredth of what there is) and the pipe's length (10 mm). What is said of a changed machine is a plan on a
lattice, not a design: it names what to look at.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import SteeplejackError
from steeplejack.planning.climb.lattice import Lattice, build_lattice
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import edges, trouble
from steeplejack.planning.climb.planner import climb, stroke_on_straights
from steeplejack.planning.climb.relaxation import Relaxation, rounded_down
from steeplejack.planning.climb.relaxations import other_machines, relaxations
from steeplejack.planning.climb.route import Found, search
from steeplejack.worksite.pipe_run import PipeRun

Array = NDArray[np.float64]

COARSE = 5
"""Parts of the stroke in which relaxed problems are solved; see `planner.PARTS`."""
FINER = (COARSE, 2 * COARSE)
"""The same for other machines on runs from pipe to pipe."""
HALVINGS = 7
ENOUGH = 2
"""After this many limits whose relaxing alone reaches the goal no more are looked for."""
FURTHER = 0.002
"""[m] By how much more a relaxed climb has to come for its limit to count."""
MANY = 1e4
"""How many times what there is are said to the order of magnitude only."""
SAID = 1e-4
"""[m] To what a place to begin at is rounded."""


def explain(run: PipeRun, machine: Machine, found: Found, tell: Callable[[str], None] = lambda _text: None) -> str:
    """Which limit ends a climb and what would change that.

    Args:
        run: What was to be climbed.
        machine: The climber, payload included.
        found: The furthest climb.
        tell: Called with what is tried next, in words.

    Returns:
        One sentence, or two.
    """
    where = f"stopped with the lower gripper at {found.progress:.3f} m"
    if not found.standings:
        where, place = _start(run, machine)
        if place is not None:
            return f"{where}; it can begin at {place:.4f} m"
    tell(f"{where}: looking for what would change that")
    lattice = build_lattice(run, machine, stroke_on_straights(machine) / COARSE)
    helped = _what_helps(lattice, found, tell)
    if helped.enough:
        tell(f"how much of it: {helped.enough[0].limit}")
        said = "; or ".join(_least(one, machine.payload, _reaches_goal) for one in helped.enough)
        return f"{where}: limit is the {helped.enough[0].limit}; the goal is reached with {said}"
    if helped.best is not None:
        one, got = helped.best
        tell(f"how much of it: {one.limit}")
        amount = _least(one, machine.payload, lambda other: other.progress > got.progress - FURTHER)
        begins = not found.standings and got.progress <= run.start_s + FURTHER
        reached = "can begin there" if begins else f"comes to {got.progress:.3f} m"
        return f"{where}: limit is the {one.limit}; with {amount} it {reached}; none alone brings it to the goal"
    limits = _too_much(machine, lattice.uses.least)
    binding = f"holding alone takes at least {limits}; " if limits else ""
    return f"{where}: {binding}none of these changes that by itself, as far as is looked at: {'; '.join(helped.vain)}"


@dataclass
class _Helped:
    """What relaxing one limit at a time has brought.

    Attributes:
        enough: The first relaxations that reach the goal.
        best: The one that comes furthest of those that do not.
        vain: The other limits.
    """

    enough: list[Relaxation] = field(default_factory=list[Relaxation])
    best: tuple[Relaxation, Found] | None = None
    vain: list[str] = field(default_factory=list[str])


def _what_helps(lattice: Lattice, found: Found, tell: Callable[[str], None]) -> _Helped:
    """Relax one limit after the other until enough of them reach the goal.

    A climb that comes further and has a gripper that can nowhere hold alone tells nothing: the other one still makes
    its move, longer with a longer stroke, say, and that is no way on.
    """
    run, machine = lattice.run, lattice.machine
    far, helped = max(found.progress, search(lattice).progress) + FURTHER, _Helped()
    binding = _too_much(machine, lattice.uses.least)
    others = other_machines(run, machine.robot) if run.goal_pipe != run.pipes[0].name else []
    for one in (*others, *relaxations(lattice)):
        tell(f"what if not for the {one.limit}")
        got = climb_relaxed(one, 1.0, machine.payload, FINER if one in others else (COARSE,))
        if got is not None and got.complete:
            helped.enough.append(one)
            if len(helped.enough) == ENOUGH or one in others:
                break
        elif got is None or not (got.progress > far or got.standings and not found.standings):
            helped.vain.append(one.limit)
        elif left := _too_much(machine, got.least):
            then = f" (without it holding alone takes at least {left})" if not binding else ""
            helped.vain.append(one.limit + then)
        elif helped.best is None or got.progress > helped.best[1].progress:
            helped.best = (one, got)
    return helped


def _too_much(machine: Machine, least: Array) -> str:
    """What holding alone takes too much of wherever the robot stands, in words, by `uses.Uses.least`."""
    whats = (
        "the grip that may be used", f"the cylinders' force of {machine.robot.cylinders.force:.4g} N",
        f"the servo's torque of {machine.robot.build.servo_torque:.4g} N m",
    )  # fmt: skip
    most = np.where(np.isfinite(least), least, 0.0).max(axis=0)
    said = [f"{_times(one)} times {what}" for one, what in zip(most, whats, strict=True) if one > 1.0]
    return " and ".join([", ".join(said[:-1]), said[-1]]) if len(said) > 1 else "".join(said)


def _times(many: float) -> str:
    """Rounded down, to the order of magnitude where there is no more to say."""
    return rounded_down(many, 2 if many < 10.0 else 0) if many < MANY else f"1e{math.floor(math.log10(many))}"


def climb_relaxed(one: Relaxation, share: float, payload: float, parts: tuple[int, ...] = (COARSE,)) -> Found | None:
    """The climb with a share of a relaxation, how far on the pipes as they are; None where that makes no sense."""
    try:
        run, robot = one.change(share)
        found = climb(run, Machine.of(robot, payload), parts)
    except SteeplejackError:
        return None
    return replace(found, progress=one.place(share, found.progress))


def _reaches_goal(found: Found) -> bool:
    return found.complete


def _least(one: Relaxation, payload: float, does: Callable[[Found], bool]) -> str:
    """The least share of a relaxation that does, in words; all of it does."""
    if not one.graded:
        return one.amount(1.0)
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        got = climb_relaxed(one, middle, payload)
        low, high = (low, middle) if got is not None and got.standings and does(got) else (middle, high)
    return one.amount(high)


def _start(run: PipeRun, machine: Machine) -> tuple[str, float | None]:
    """What is wrong with the place the lower gripper begins at, and the next one where it is not [m].

    There is none where grippers do not fit the pipe, or where the place is good and the robot does not hold there.
    """
    found = [why for why, at in trouble(run, machine, run.pipes[0], np.array([run.start_s])) if at[0]]
    where = f"cannot begin at {run.start_s:.3f} m"
    if not found:
        return where, None
    where += f" ({', '.join(found)} under the lower gripper)"
    return where, None if "diameter" in found else _next_start(run, machine)


def _next_start(run: PipeRun, machine: Machine) -> float | None:
    """The next place along the main pipe where the robot can begin, None if there is none before the goal [m]."""
    pipe = run.pipes[0]
    last = run.goal_s if run.goal_pipe == pipe.name else pipe.length
    ends = edges(run, machine, pipe)
    ends = np.ceil(ends[(ends > run.start_s) & (ends < last)] / SAID - 1e-6) * SAID
    good = ~np.any([at for _why, at in trouble(run, machine, pipe, ends)], axis=0)
    for place in ends[good]:
        if climb(replace(run, start_s=float(place)), machine, (COARSE,)).standings:
            return float(place)
    return None
