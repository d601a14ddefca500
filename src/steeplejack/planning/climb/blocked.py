"""Why a climb ends and what would change that: the same run solved again with one limit relaxed at a time.

The limit that binds is the one whose relaxing brings the robot to the goal, or else furthest beyond where it stopped.
It is
solved on a coarse lattice, and no more is looked for than a few answers.
Limits that are numbers are then halved down to the least change that still does, in `HALVINGS` steps. What is
said of a changed machine is a plan on a lattice, not a design: it names what to look at.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from steeplejack.errors import SteeplejackError
from steeplejack.planning.climb.collide import AIR
from steeplejack.planning.climb.lattice import Lattice, build_lattice, deciding_limits, wanted_clocks
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import trouble
from steeplejack.planning.climb.planner import Found, climb, search, stroke_on_straights
from steeplejack.robots.pipe_climber.bars import widest_turn
from steeplejack.robots.pipe_climber.parameters import SHIPPED, PipeClimber, load_pipe_climber
from steeplejack.worksite.pipe_run import PipeRun, with_bends, with_end

COARSE = 5
"""Parts of the stroke in which relaxed problems are solved; see `planner.PARTS`."""
FINER = (COARSE, 2 * COARSE)
"""The same for other machines on runs from pipe to pipe."""
HALVINGS = 4
ENOUGH = 2
"""After this many limits whose relaxing alone reaches the goal no more are looked for."""
FURTHER = 0.002
"""[m] By how much more a relaxed climb has to come for its limit to count."""

RIGHT = 0.5 * math.pi * (1.0 + 1e-9)
"""Tilt that a right angle between pipes needs [rad]."""
Problem = tuple[PipeRun, PipeClimber]


@dataclass(frozen=True)
class Relaxation:
    """One limit, given way to.

    Attributes:
        limit: Its name, with its value.
        change: The problem with a share of the relaxation, 0 to 1.
        amount: How to say that share.
        graded: Whether shares between 0 and 1 mean anything.
    """

    limit: str
    change: Callable[[float], Problem]
    amount: Callable[[float], str]
    graded: bool = True


def _nothing(_text: str) -> None:
    """Tell nobody."""


def explain(run: PipeRun, machine: Machine, found: Found, tell: Callable[[str], None] = _nothing) -> str:
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
        where = f"cannot begin at {run.start_s:.3f} m" + _trouble_at_start(run, machine)
    tell(f"{where}: looking for what would change that")
    lattice = build_lattice(run, machine, stroke_on_straights(machine) / COARSE)
    far = max(found.progress, search(lattice).progress)
    enough, best = list[Relaxation](), None
    single, variants = _single(lattice), _variants(run, machine.robot)
    for one in (*variants, *single) if run.goal_pipe != run.pipes[0].name else single:
        tell(f"what if not for the {one.limit}")
        got = climb_relaxed(one.change(1.0), machine.payload, (COARSE,) if one in single else FINER)
        if got is None:
            continue
        if got.complete:
            enough.append(one)
            if len(enough) == ENOUGH or one in variants:
                break
        elif got.progress > far + FURTHER or got.standings and not found.standings:
            best = (one, got.progress) if best is None or got.progress > best[1] else best
    if enough:
        tell(f"how much of it: {enough[0].limit}")
        said = "; or ".join(_least(one, machine.payload) for one in enough)
        return f"{where}: limit is the {enough[0].limit}; the goal is reached with {said}"
    if best is not None:
        one, progress = best
        return f"{where}: limit is the {one.limit}; {one.amount(1.0)} brings it to {progress:.3f} m"
    return f"{where}: no single limit of the machine, the bends or the pipe's length changes that"


def climb_relaxed(problem: Problem, payload: float, parts: tuple[int, ...] = (COARSE,)) -> Found | None:
    """The climb of a changed problem; None where it makes no sense."""
    try:
        return climb(problem[0], Machine.of(problem[1], payload), parts)
    except SteeplejackError:
        return None


def _least(one: Relaxation, payload: float) -> str:
    """The least share of a relaxation that reaches the goal, in words."""
    if not one.graded:
        return one.amount(1.0)
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        got = climb_relaxed(one.change(middle), payload)
        low, high = (low, middle) if got is not None and got.complete else (middle, high)
    return one.amount(high)


def _trouble_at_start(run: PipeRun, machine: Machine) -> str:
    """What is wrong with the place the lower gripper begins at."""
    found = [why for why, at in trouble(run, machine, run.pipes[0], np.array([run.start_s])) if at[0]]
    return f" ({', '.join(found)} under the lower gripper)" if found else ""


def _changed(robot: PipeClimber, table: str, **values: Any) -> PipeClimber:
    part = getattr(robot, table)
    return msgspec.structs.replace(robot, **{table: msgspec.structs.replace(part, **values)})


def _between(low: float, high: float, share: float) -> float:
    return low + share * (high - low)


def _stroke(robot: PipeClimber, share: float) -> PipeClimber:
    """Each cylinder's window widened to both sides, up to the reach of the mechanism."""
    cylinders = robot.cylinders
    least, most = cylinders.reach
    stroke = _between(cylinders.stroke, most - least, share)
    retracted = tuple(
        min(max(least, one - 0.5 * (stroke - cylinders.stroke)), max(least, most - stroke))
        for one in cylinders.retracted
    )
    return _changed(robot, "cylinders", stroke=stroke, retracted=retracted)


def _single(lattice: Lattice) -> list[Relaxation]:
    """Relaxations of one limit each that can matter to a run, those of the site last."""
    run, machine, robot = lattice.run, lattice.machine, lattice.machine.robot
    decide = deciding_limits(run, machine, lattice.step)
    slips = bool((np.isfinite(lattice.uses) & (lattice.uses > 1.0)).any())
    turning = len(wanted_clocks(run, machine)) > 1
    bends = any(not part.straight for pipe in run.pipes for part in pipe.parts)
    standing = bool(run.obstacles or run.crossings)
    sizes = [part.diameter for pipe in run.pipes for part in pipe.parts]
    steps = len(set(sizes)) > 1
    wide = (min([*sizes, robot.gripper.pipe_diameter[0]]), max([*sizes, robot.gripper.pipe_diameter[1]]))
    length = bool(decide & {"shortest", "longest"})
    choices = [
        (bool(robot.linkage.claw_offset), _claw_offset(run, robot)),
        (wide != robot.gripper.pipe_diameter, _diameters(run, machine, wide)),
        (standing, _clearance(run, machine)),
        (slips and robot.gait.reserve > 0.0, _reserve(run, robot)),
        (slips, _friction(run, robot)),
        (slips and not steps, _jaws(run, robot, 2.0, " against tilting")),
        ("tilt" in decide, _tilt(run, robot)),
        (turning, _linkage(run, machine)),
        (length, _longer_stroke(run, robot)),
        (standing or steps, _jaws(run, robot, 0.4)),
        ("force" in decide, _force(run, robot)),
        ("servo" in decide, _servo(run, robot)),
        (length, _size(run, robot)),
        (True, _pipe_end(run, robot)),
        (bends, _bends(run, robot)),
    ]
    return [relaxation for matters, relaxation in choices if matters and relaxation is not None]


def _claw_offset(run: PipeRun, robot: PipeClimber) -> Relaxation:
    hz = robot.linkage.claw_offset
    return Relaxation(
        f"claw's offset hz of {1e3 * hz:.0f} mm",
        lambda k: (run, _changed(robot, "linkage", claw_offset=_between(hz, 0.0, k))),
        lambda k: f"hz of {1e3 * _between(hz, 0.0, k):.0f} mm",
    )


def _clearance(run: PipeRun, machine: Machine) -> Relaxation:
    """Room about the pipe: under the palm, under closed jaws, and within limbs and linkage."""
    robot = machine.robot
    room = machine.lowest_bar - _thickest(run)
    least = min(robot.gait.clearance, robot.gait.relief, room)
    most = max([one.height for one in run.obstacles] + [2.0 * robot.gait.clearance]) * (1.0 + 1e-6)

    def roomy(share: float) -> Problem:
        wanted, gait = _between(least, most, share), robot.gait
        return run, _changed(
            _roomier(robot, max(0.0, wanted - room)), "gait", clearance=max(gait.clearance, wanted),
            relief=max(gait.relief, wanted),
        )  # fmt: skip

    return Relaxation(
        f"clearance about the pipe of {1e3 * least:.0f} mm",
        roomy,
        lambda k: f"a clearance of {1e3 * _between(least, most, k):.0f} mm",
    )


def _thickest(run: PipeRun) -> float:
    """Radius of the thickest pipe [m]."""
    return max(0.5 * part.diameter for pipe in run.pipes for part in pipe.parts)


def _roomier(robot: PipeClimber, more: float) -> PipeClimber:
    """A machine whose bars keep further from the pipe [m]."""
    wider = more / math.cos(min(robot.rcm.limit, math.radians(60.0)))
    linkage, rcm = robot.linkage, robot.rcm
    wide = _changed(robot, "linkage", half_width=linkage.half_width + wider)
    return _changed(wide, "rcm", crank=rcm.crank + wider, coupler=rcm.coupler + 2.0 * wider)


def _longer_stroke(run: PipeRun, robot: PipeClimber) -> Relaxation:
    cylinders = robot.cylinders
    span = cylinders.reach[1] - cylinders.reach[0]
    return Relaxation(
        f"cylinders' stroke of {1e3 * cylinders.stroke:.0f} mm",
        lambda k: (run, _stroke(robot, k)),
        lambda k: f"a stroke of {1e3 * _between(cylinders.stroke, span, k):.0f} mm",
    )


def _number(
    run: PipeRun, robot: PipeClimber, field: tuple[str, str], far: float, limit: str, amount: Callable[[float], str]
) -> Relaxation:
    """One number of one table of the robot file, from what it is to ``far``."""
    table, name = field
    now = float(getattr(getattr(robot, table), name))
    return Relaxation(
        limit,
        lambda k: (run, _changed(robot, table, **{name: _between(now, far, k)})),
        lambda k: amount(_between(now, far, k)),
    )


def _tilt(run: PipeRun, robot: PipeClimber) -> Relaxation:
    limit = f"platform's tilt of {math.degrees(robot.joints.limit):.0f} deg"
    return _number(run, robot, ("joints", "limit"), RIGHT, limit, lambda x: f"a tilt of {math.degrees(x):.0f} deg")


def _linkage(run: PipeRun, machine: Machine) -> Relaxation | None:
    """A wider range of the linkage, up to where its bars come to the thickest pipe; None if that is what it has."""
    now = machine.robot.rcm.limit
    far = widest_turn(machine.robot, _thickest(run) + AIR)
    if far <= now:
        return None
    limit = f"linkage's range of {math.degrees(now):.0f} deg"
    return _number(
        run, machine.robot, ("rcm", "limit"), far, limit, lambda x: f"a linkage range of {math.degrees(x):.0f} deg"
    )


def _jaws(run: PipeRun, robot: PipeClimber, far: float, why: str = "") -> Relaxation:
    now = robot.build.jaw_length
    limit = f"jaws' length of {1e3 * now:.0f} mm{why}"
    return _number(run, robot, ("build", "jaw_length"), far * now, limit, lambda x: f"jaws of {1e3 * x:.0f} mm")


def _diameters(run: PipeRun, machine: Machine, wide: tuple[float, float]) -> Relaxation:
    """Grippers for every pipe of the run, and bars that clear the thickest."""
    least, most = machine.robot.gripper.pipe_diameter
    more = max(0.0, _thickest(run) - machine.lowest_bar)
    changed = _changed(_roomier(machine.robot, more), "gripper", pipe_diameter=wide)
    room = f" with bars {math.ceil(1e3 * more):.0f} mm further out" if more > 0.0 else ""
    return Relaxation(
        f"grippers' range of pipe diameters, {1e3 * least:.0f} to {1e3 * most:.0f} mm",
        lambda _k: (run, changed),
        lambda _k: f"grippers for {1e3 * wide[0]:.0f} to {1e3 * wide[1]:.0f} mm{room}",
        graded=False,
    )


def _reserve(run: PipeRun, robot: PipeClimber) -> Relaxation:
    limit = f"{100.0 * robot.gait.reserve:.0f} % of the grip that are kept in reserve"
    return _number(run, robot, ("gait", "reserve"), 0.0, limit, lambda x: f"a reserve of {100.0 * x:.1f} %")


def _servo(run: PipeRun, robot: PipeClimber) -> Relaxation:
    now = robot.build.servo_torque
    limit = f"torque of the linkage's servo of {now:.2f} N m"
    return _number(run, robot, ("build", "servo_torque"), 10.0 * now, limit, lambda x: f"a servo of {x:.1f} N m")


def _force(run: PipeRun, robot: PipeClimber) -> Relaxation:
    now = robot.cylinders.force
    limit = f"cylinders' force of {now:.0f} N"
    return _number(run, robot, ("cylinders", "force"), 10.0 * now, limit, lambda x: f"cylinders of {x:.0f} N")


def _friction(run: PipeRun, robot: PipeClimber) -> Relaxation:
    now = robot.gripper.friction
    limit = f"friction of {now:g} with {robot.gripper.force:.0f} N a jaw"
    return _number(run, robot, ("gripper", "friction"), 10.0 * now, limit, lambda x: f"friction of {x:.2f}")


def _size(run: PipeRun, robot: PipeClimber) -> Relaxation:
    return Relaxation(
        "size of the mechanism",
        lambda k: (run, _larger(robot, _between(1.0, 2.0, k))),
        lambda k: f"a mechanism {_between(1.0, 2.0, k):.2f} times as large, strokes and all",
    )


def _pipe_end(run: PipeRun, robot: PipeClimber) -> Relaxation:
    return Relaxation(
        "length of the pipe beyond the goal",
        lambda k: (with_end(run, max(1e-3, k)), robot),
        lambda k: f"{1e3 * k:.0f} mm more of pipe",
    )


def _bends(run: PipeRun, robot: PipeClimber) -> Relaxation:
    tightest = min(part.radius for pipe in run.pipes for part in pipe.parts)
    return Relaxation(
        f"bend's radius of {1e3 * tightest:.0f} mm",
        lambda k: (with_bends(run, _between(1.0, 4.0, k)), robot),
        lambda k: f"bends of at least {1e3 * tightest * _between(1.0, 4.0, k):.0f} mm",
    )


def _variants(run: PipeRun, robot: PipeClimber) -> list[Relaxation]:
    """The other shipped machines with the friction there is: for runs from one pipe to another."""
    found: list[Relaxation] = []
    for name in SHIPPED:
        if name != robot.name:
            other = _changed(load_pipe_climber(name), "gripper", friction=robot.gripper.friction)
            least, most = other.cylinders.retracted[1], other.cylinders.retracted[1] + other.cylinders.stroke
            amount = (
                f"the shipped robot {name}: cylinders from {1e3 * least:.0f} to {1e3 * most:.0f} mm and a tilt of "
                f"{math.degrees(other.joints.limit):.0f} deg"
            )
            now = f"cylinders' stroke of {1e3 * robot.cylinders.stroke:.0f} mm together with the platform's tilt of "
            now += f"{math.degrees(robot.joints.limit):.0f} deg"
            found.append(
                Relaxation(now, lambda _k, other=other: (run, other), lambda _k, said=amount: said, graded=False)
            )
    return found


def _larger(robot: PipeClimber, factor: float) -> PipeClimber:
    """The mechanism scaled: limbs, cylinders and their strokes."""
    linkage, cylinders = robot.linkage, robot.cylinders
    scaled = _changed(robot, "linkage", lengths=tuple(factor * one for one in linkage.lengths))
    return _changed(
        scaled, "cylinders", reach=tuple(factor * one for one in cylinders.reach), stroke=factor * cylinders.stroke,
        retracted=tuple(factor * one for one in cylinders.retracted),
    )  # fmt: skip
