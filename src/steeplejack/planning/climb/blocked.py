"""Why a climb ends and what would change that: the same run solved again with one limit relaxed at a time.

The limit that binds is the one whose relaxing brings the robot to the goal, or else furthest beyond where it stopped.
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
from steeplejack.planning.climb.lattice import build_lattice, deciding_limits, wanted_clocks
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import trouble
from steeplejack.planning.climb.planner import Found, climb
from steeplejack.robots.pipe_climber.parameters import PipeClimber
from steeplejack.worksite.pipe_run import PipeRun, with_bends, with_end

COARSE = (10,)
"""Parts of the stroke in which relaxed problems are solved; see `planner.PARTS`."""
HALVINGS = 5
FURTHER = 0.002
"""[m] By how much more a relaxed climb has to come for its limit to count."""

RIGHT = 0.5 * math.pi * (1.0 + 1e-9)
"""Tilt that a right angle between pipes needs [rad]."""
WIDEST_TURN = math.radians(60.0)
"""Range of the linkage that is tried; the parallelogram folds at 90 degrees [rad]."""

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


def explain(run: PipeRun, machine: Machine, found: Found) -> str:
    """Which limit ends a climb and what would change that.

    Args:
        run: What was to be climbed.
        machine: The climber, payload included.
        found: The furthest climb.

    Returns:
        One sentence, or two.
    """
    payload = machine.payload
    where = f"stopped with the lower gripper at {found.progress:.3f} m"
    if not found.standings:
        where = f"cannot begin at {run.start_s:.3f} m" + _trouble_at_start(run, machine)
    base = climb_relaxed((run, machine.robot), payload)
    for group in (_single(run, machine.robot, payload), _double(run, machine.robot)):
        results = [(one, climb_relaxed(one.change(1.0), payload)) for one in group]
        better = [(one, got) for one, got in results if got is not None and _beyond(got, base, found)]
        complete = [(one, got) for one, got in better if got.complete]
        if complete:
            said = "; or ".join(_least(one, payload) for one, _got in complete[:3])
            return f"{where}: limit is the {complete[0][0].limit}; the goal is reached with {said}"
        if better and group and group[0].graded:
            one, got = max(better, key=lambda pair: pair[1].progress)
            rest = _double_rest(run, machine.robot, payload)
            return f"{where}: limit is the {one.limit}; {one.amount(1.0)} brings it to {got.progress:.3f} m{rest}"
    return f"{where}: no single limit of the machine, the bends or the pipe's length changes that"


def climb_relaxed(problem: Problem, payload: float) -> Found | None:
    """The climb of a changed problem; None where it makes no sense."""
    try:
        return climb(problem[0], Machine.of(problem[1], payload), COARSE)
    except SteeplejackError:
        return None


def _beyond(got: Found, base: Found | None, found: Found) -> bool:
    """Whether a relaxed climb comes further than the real one did, on either lattice."""
    far = max(found.progress, base.progress if base is not None else -math.inf)
    begun = bool(got.standings) and not found.standings
    return got.complete or got.progress > far + FURTHER or begun


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


def _double_rest(run: PipeRun, robot: PipeClimber, payload: float) -> str:
    """What reaches the goal where one relaxation does not."""
    for one in _double(run, robot):
        got = climb_relaxed(one.change(1.0), payload)
        if got is not None and got.complete:
            return f"; the goal is reached with {one.amount(1.0)}"
    return ""


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


def _single(run: PipeRun, robot: PipeClimber, payload: float) -> list[Relaxation]:
    """Relaxations of one limit each that can matter to a run, those of the site last."""
    machine = Machine.of(robot, payload)
    gap = max(machine.straight_gaps[1] - machine.straight_gaps[0], 0.01)
    decide, slips = deciding_limits(run, machine, gap / COARSE[0]), _slips(run, machine, gap / COARSE[0])
    turning = len(wanted_clocks(run, machine)) > 1
    bends = any(not part.straight for pipe in run.pipes for part in pipe.parts)
    standing = bool(run.obstacles or run.crossings)
    sizes = [part.diameter for pipe in run.pipes for part in pipe.parts]
    wide = (min([*sizes, robot.gripper.pipe_diameter[0]]), max([*sizes, robot.gripper.pipe_diameter[1]]))
    length = bool(decide & {"shortest", "longest"})
    choices = [
        (bool(robot.linkage.claw_offset), _claw_offset(run, robot)),
        (standing or wide != robot.gripper.pipe_diameter, _clearance(run, machine)),
        (length, _longer_stroke(run, robot)),
        ("tilt" in decide, _tilt(run, robot)),
        (turning, _linkage(run, robot)),
        (standing or len(set(sizes)) > 1, _jaws(run, robot, 0.1)),
        (wide != robot.gripper.pipe_diameter, _diameters(run, robot, wide)),
        ("force" in decide, _force(run, robot)),
        (slips, _friction(run, robot)),
        (slips, _jaws(run, robot, 2.0, " against tilting")),
        (length, _size(run, robot)),
        (True, _pipe_end(run, robot)),
        (bends, _bends(run, robot)),
    ]
    return [relaxation for matters, relaxation in choices if matters]


def _slips(run: PipeRun, machine: Machine, step: float) -> bool:
    """Whether a grip does not bear the robot in some pose that is else allowed."""
    uses = build_lattice(run, machine, step).uses
    return bool((np.isfinite(uses) & (uses > 1.0)).any())


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
    thick = max(0.5 * part.diameter for pipe in run.pipes for part in pipe.parts)
    room = machine.lowest_bar - thick
    least = min(robot.gait.clearance, robot.gait.relief, room)
    most = max([one.height for one in run.obstacles] + [2.0 * robot.gait.clearance]) * (1.0 + 1e-6)

    def roomy(share: float) -> Problem:
        wanted = _between(least, most, share)
        more = max(0.0, wanted - room) / math.cos(min(robot.rcm.limit, math.radians(60.0)))
        linkage, rcm = robot.linkage, robot.rcm
        wide = _changed(robot, "linkage", half_width=linkage.half_width + more)
        wide = _changed(wide, "rcm", crank=rcm.crank + more, coupler=rcm.coupler + 2.0 * more)
        gait = robot.gait
        return run, _changed(
            wide, "gait", clearance=max(gait.clearance, wanted), relief=max(gait.relief, wanted)
        )  # fmt: skip

    return Relaxation(
        f"clearance about the pipe of {1e3 * least:.0f} mm",
        roomy,
        lambda k: f"a clearance of {1e3 * _between(least, most, k):.0f} mm",
    )


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


def _linkage(run: PipeRun, robot: PipeClimber) -> Relaxation:
    now = robot.rcm.limit
    limit, far = f"linkage's range of {math.degrees(now):.0f} deg", max(now, WIDEST_TURN)
    return _number(run, robot, ("rcm", "limit"), far, limit, lambda x: f"a linkage range of {math.degrees(x):.0f} deg")


def _jaws(run: PipeRun, robot: PipeClimber, far: float, why: str = "") -> Relaxation:
    now = robot.build.jaw_length
    limit = f"jaws' length of {1e3 * now:.0f} mm{why}"
    return _number(run, robot, ("build", "jaw_length"), far * now, limit, lambda x: f"jaws of {1e3 * x:.0f} mm")


def _diameters(run: PipeRun, robot: PipeClimber, wide: tuple[float, float]) -> Relaxation:
    least, most = robot.gripper.pipe_diameter
    return Relaxation(
        f"grippers' range of pipe diameters, {1e3 * least:.0f} to {1e3 * most:.0f} mm",
        lambda _k: (run, _changed(robot, "gripper", pipe_diameter=wide)),
        lambda _k: f"grippers for {1e3 * wide[0]:.0f} to {1e3 * wide[1]:.0f} mm",
        graded=False,
    )


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


def _double(run: PipeRun, robot: PipeClimber) -> list[Relaxation]:
    """Two limits at once: the mechanism as analysed in the paper, free in its whole reach, with tilt to 90 degrees."""
    reach = robot.cylinders.reach
    free = _changed(_stroke(robot, 1.0), "joints", limit=RIGHT)
    return [
        Relaxation(
            f"cylinders' stroke of {1e3 * robot.cylinders.stroke:.0f} mm together with the platform's tilt of "
            f"{math.degrees(robot.joints.limit):.0f} deg",
            lambda _k: (run, free),
            lambda _k: f"cylinders from {1e3 * reach[0]:.0f} to {1e3 * reach[1]:.0f} mm and a tilt of 90 deg",
            graded=False,
        )
    ]


def _larger(robot: PipeClimber, factor: float) -> PipeClimber:
    """The mechanism scaled: limbs, cylinders and their strokes."""
    linkage, cylinders = robot.linkage, robot.cylinders
    scaled = _changed(robot, "linkage", lengths=tuple(factor * one for one in linkage.lengths))
    return _changed(
        scaled, "cylinders", reach=tuple(factor * one for one in cylinders.reach), stroke=factor * cylinders.stroke,
        retracted=tuple(factor * one for one in cylinders.retracted),
    )  # fmt: skip
