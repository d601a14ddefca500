"""Which limits can matter to a run, each as a relaxation of it; those of the site come last.

Sizes, forces and friction change by equal factors; angles, clearances, the pipe's end and what goes down to nothing by
equal amounts.
"""

from __future__ import annotations

import math

from steeplejack.planning.climb.clocks import wanted_clocks
from steeplejack.planning.climb.lattice import Lattice, deciding_limits
from steeplejack.planning.climb.limits import ROUNDING, Machine
from steeplejack.planning.climb.relaxation import (
    Problem,
    Relaxation,
    by_factors,
    changed,
    evenly,
    in_mm,
    number,
    rounded_down,
    rounded_up,
)
from steeplejack.planning.climb.solids import AIR
from steeplejack.robots.pipe_climber.bars import widest_turn
from steeplejack.robots.pipe_climber.parameters import SHIPPED, PipeClimber, load_pipe_climber
from steeplejack.worksite.pipe_run import PipeRun, place_with_bends, with_bends, with_end

RIGHT = 0.5 * math.pi * (1.0 + 1e-9)
"""Tilt that a right angle between pipes needs [rad]."""
RUBBING = 3.0
"""How many times the friction there is is looked at, at most [1]."""
SHORT_OF_JAMMING = 0.9
"""The same in parts of the friction at which pads jam [1]; see `parameters.Build.jamming_friction`."""
STRONGER = 10.0
"""How many times the force or the torque of an actuator is looked at, at most [1]."""
LEAST_END = 1e-3
"""[m] The least of pipe that is put to an end."""


def relaxations(lattice: Lattice) -> list[Relaxation]:
    """Relaxations of one limit each that can matter to a run, those of the site last."""
    run, machine, robot = lattice.run, lattice.machine, lattice.machine.robot
    decide = deciding_limits(run, machine, lattice.step)
    slips = "grip" in lattice.uses.scarce
    turning = len(wanted_clocks(run, machine)) > 1
    bends = any(not part.straight for pipe in run.pipes for part in pipe.parts)
    standing = bool(run.obstacles or run.crossings)
    sizes = _diameters_of(run)
    steps = len(set(sizes)) > 1
    wide = (min([*sizes, robot.gripper.pipe_diameter[0]]), max([*sizes, robot.gripper.pipe_diameter[1]]))
    length = bool(decide & {"shortest", "longest"})
    choices = [
        (bool(robot.linkage.claw_offset), _claw_offset(run, robot)),
        (wide != robot.gripper.pipe_diameter, _grippers(run, machine, wide)),
        (_thickest(run) > machine.lowest_bar and wide == robot.gripper.pipe_diameter, _bars(run, machine)),
        (standing, _clearance(run, machine)),
        (slips and robot.gait.reserve > 0.0, _reserve(run, robot)),
        (slips, _friction(run, robot)),
        (slips and not steps, _jaws(run, robot, 2.0, " against tilting")),
        ("tilt" in decide, _tilt(run, robot)),
        (turning, _linkage(run, machine)),
        (length, _stroke(run, robot)),
        (standing or steps, _jaws(run, robot, 0.4)),
        ("force" in lattice.uses.scarce, _force(run, robot)),
        ("servo" in lattice.uses.scarce, _servo(run, robot)),
        (length, _size(run, robot)),
        (True, _pipe_end(run, robot)),
        (bends, _bends(run, robot)),
    ]
    return [relaxation for matters, relaxation in choices if matters and relaxation is not None]


def other_machines(run: PipeRun, robot: PipeClimber) -> list[Relaxation]:
    """The other shipped machines with the friction there is: for runs from one pipe to another."""
    now = (
        f"cylinders' stroke of {1e3 * robot.cylinders.stroke:.4g} mm together with the platform's tilt of "
        f"{math.degrees(robot.joints.limit):.4g} deg"
    )
    found: list[Relaxation] = []
    for other in (load_pipe_climber(name) for name in SHIPPED if name != robot.name):
        least, most = other.cylinders.retracted[1], other.cylinders.retracted[1] + other.cylinders.stroke
        amount = (
            f"the shipped robot {other.name}: cylinders from {1e3 * least:.4g} to {1e3 * most:.4g} mm and a tilt of "
            f"{math.degrees(other.joints.limit):.4g} deg"
        )
        found.append(
            Relaxation(
                now,
                lambda _k, other=other: (run, changed(other, "gripper", friction=robot.gripper.friction)),
                lambda _k, said=amount: said,
                graded=False,
            )
        )
    return found


def _claw_offset(run: PipeRun, robot: PipeClimber) -> Relaxation:
    hz = robot.linkage.claw_offset
    limit, offset = f"claw's offset hz of {1e3 * hz:.4g} mm", evenly(hz, 0.0)
    return number(run, robot, ("linkage", "claw_offset"), offset, limit, lambda x: f"hz of {rounded_down(1e3 * x)} mm")


def _clearance(run: PipeRun, machine: Machine) -> Relaxation:
    """Room about the pipe: under the palm, under closed jaws, and within limbs and linkage."""
    robot = machine.robot
    room = machine.lowest_bar - _thickest(run)
    least = min(robot.gait.clearance, robot.gait.relief, room)
    most = max([one.height for one in run.obstacles] + [2.0 * robot.gait.clearance]) * (1.0 + 1e-6)
    wanted = evenly(least, most)

    def roomy(share: float) -> Problem:
        roomier, gait = _roomier(robot, max(0.0, wanted(share) - room)), robot.gait
        clearance, relief = max(gait.clearance, wanted(share)), max(gait.relief, wanted(share))
        return run, changed(roomier, "gait", clearance=clearance, relief=relief)

    return Relaxation(
        f"clearance about the pipe of {1e3 * least:.4g} mm", roomy, lambda k: f"a clearance of {in_mm(wanted(k))} mm"
    )


def _bars(run: PipeRun, machine: Machine) -> Relaxation:
    """Bars that clear the thickest pipe."""
    more = _thickest(run) - machine.lowest_bar + ROUNDING
    return Relaxation(
        f"bars, which pass pipes of up to {2e3 * machine.lowest_bar:.4g} mm",
        lambda _k: (run, _roomier(machine.robot, more)),
        lambda _k: f"bars {in_mm(more)} mm further out",
        graded=False,
    )


def _grippers(run: PipeRun, machine: Machine, wide: tuple[float, float]) -> Relaxation:
    """Grippers for every pipe of the run, and bars that clear the thickest."""
    least, most = machine.robot.gripper.pipe_diameter
    more = max(0.0, _thickest(run) - machine.lowest_bar)
    room = f" with bars {in_mm(more)} mm further out" if more > 0.0 else ""
    thinnest = 2.0 * machine.robot.build.least_radius
    never = f" (jaws as wide hold none of {1e3 * thinnest:.4g} mm or less)" if wide[0] <= thinnest else ""
    return Relaxation(
        f"grippers' range of pipe diameters, {1e3 * least:.4g} to {1e3 * most:.4g} mm{never}",
        lambda _k: (run, changed(_roomier(machine.robot, more), "gripper", pipe_diameter=wide)),
        lambda _k: f"grippers for {1e3 * wide[0]:.4g} to {1e3 * wide[1]:.4g} mm{room}",
        graded=False,
    )


def _reserve(run: PipeRun, robot: PipeClimber) -> Relaxation:
    limit, reserve = (
        f"{100.0 * robot.gait.reserve:.4g} % of the grip that are kept in reserve",
        evenly(robot.gait.reserve, 0.0),
    )
    return number(
        run, robot, ("gait", "reserve"), reserve, limit, lambda x: f"a reserve of {rounded_down(100.0 * x, 1)} %"
    )


def _servo(run: PipeRun, robot: PipeClimber) -> Relaxation:
    now = robot.build.servo_torque
    limit = f"torque of the linkage's servo of {now:.4g} N m"
    return number(
        run, robot, ("build", "servo_torque"), by_factors(now, STRONGER * now), limit,
        lambda x: f"a servo of {rounded_up(x, 2)} N m",
    )  # fmt: skip


def _force(run: PipeRun, robot: PipeClimber) -> Relaxation:
    now = robot.cylinders.force
    limit = f"cylinders' force of {now:.4g} N"
    return number(
        run, robot, ("cylinders", "force"), by_factors(now, STRONGER * now), limit,
        lambda x: f"cylinders of {rounded_up(x, 1)} N",
    )  # fmt: skip


def _friction(run: PipeRun, robot: PipeClimber) -> Relaxation | None:
    """More friction, short of what makes pads jam on the thinnest pipe they hold; None if that is what there is."""
    now, thinnest = robot.gripper.friction, 0.5 * robot.gripper.pipe_diameter[0]
    far = min(RUBBING * now, SHORT_OF_JAMMING * robot.build.jamming_friction(thinnest))
    if far <= now:
        return None
    limit = f"friction of {now:g} with {robot.gripper.force:.4g} N a jaw"
    return number(
        run, robot, ("gripper", "friction"), by_factors(now, far), limit, lambda x: f"friction of {rounded_up(x, 3)}"
    )


def _jaws(run: PipeRun, robot: PipeClimber, far: float, why: str = "") -> Relaxation:
    now = robot.build.jaw_length
    limit, jaws = f"jaws' length of {1e3 * now:.4g} mm{why}", by_factors(now, far * now)
    return number(
        run,
        robot,
        ("build", "jaw_length"),
        jaws,
        limit,
        lambda x: f"jaws of {in_mm(x) if far > 1.0 else rounded_down(1e3 * x)} mm",
    )


def _tilt(run: PipeRun, robot: PipeClimber) -> Relaxation:
    now = robot.joints.limit
    limit, tilt = f"platform's tilt of {math.degrees(now):.4g} deg", evenly(now, RIGHT)
    return number(
        run, robot, ("joints", "limit"), tilt, limit, lambda x: f"a tilt of {rounded_up(math.degrees(x), 1)} deg"
    )


def _linkage(run: PipeRun, machine: Machine) -> Relaxation | None:
    """A wider range of the linkage, up to where its bars come to the thickest pipe; None if that is what it has."""
    now = machine.robot.rcm.limit
    far = widest_turn(machine.robot, _thickest(run) + AIR)
    if far <= now:
        return None
    return number(
        run, machine.robot, ("rcm", "limit"), evenly(now, far), f"linkage's range of {math.degrees(now):.4g} deg",
        lambda x: f"a linkage range of {rounded_up(math.degrees(x), 1)} deg",
    )  # fmt: skip


def _stroke(run: PipeRun, robot: PipeClimber) -> Relaxation:
    """Each cylinder's window widened to both sides, up to the reach of the mechanism."""
    cylinders = robot.cylinders
    least, most = cylinders.reach
    stroke = by_factors(cylinders.stroke, max(cylinders.stroke, most - least))

    def longer(share: float) -> Problem:
        more = stroke(share) - cylinders.stroke
        retracted = tuple(
            min(max(least, one - 0.5 * more), max(least, most - stroke(share))) for one in cylinders.retracted
        )
        return run, changed(robot, "cylinders", stroke=stroke(share), retracted=retracted)

    return Relaxation(
        f"cylinders' stroke of {1e3 * cylinders.stroke:.4g} mm", longer, lambda k: f"a stroke of {in_mm(stroke(k))} mm"
    )


def _size(run: PipeRun, robot: PipeClimber) -> Relaxation:
    factor = by_factors(1.0, 2.0)
    return Relaxation(
        "size of the mechanism",
        lambda k: (run, _larger(robot, factor(k))),
        lambda k: f"a mechanism {rounded_up(factor(k), 2)} times as large, strokes and all",
    )


def _pipe_end(run: PipeRun, robot: PipeClimber) -> Relaxation:
    return Relaxation(
        "length of the pipe beyond the goal",
        lambda k: (with_end(run, max(LEAST_END, k)), robot),
        lambda k: f"{in_mm(max(LEAST_END, k))} mm more of pipe",
    )


def _bends(run: PipeRun, robot: PipeClimber) -> Relaxation:
    tightest, factor = min(part.radius for pipe in run.pipes for part in pipe.parts), by_factors(1.0, 4.0)
    return Relaxation(
        f"bend's radius of {1e3 * tightest:.4g} mm",
        lambda k: (with_bends(run, factor(k)), robot),
        lambda k: f"bends of at least {in_mm(tightest * factor(k))} mm",
        place=lambda k, s: place_with_bends(with_bends(run, factor(k)), 1.0 / factor(k), s),
    )


def _roomier(robot: PipeClimber, more: float) -> PipeClimber:
    """A machine whose bars keep further from the pipe [m]."""
    wider = more / math.cos(min(robot.rcm.limit, math.radians(60.0)))
    linkage, rcm = robot.linkage, robot.rcm
    wide = changed(robot, "linkage", half_width=linkage.half_width + wider)
    return changed(wide, "rcm", crank=rcm.crank + wider, coupler=rcm.coupler + 2.0 * wider)


def _larger(robot: PipeClimber, factor: float) -> PipeClimber:
    """The mechanism scaled: limbs, cylinders and their strokes."""
    linkage, cylinders = robot.linkage, robot.cylinders
    scaled = changed(robot, "linkage", lengths=tuple(factor * one for one in linkage.lengths))
    return changed(
        scaled, "cylinders", reach=tuple(factor * one for one in cylinders.reach), stroke=factor * cylinders.stroke,
        retracted=tuple(factor * one for one in cylinders.retracted),
    )  # fmt: skip


def _diameters_of(run: PipeRun) -> list[float]:
    """Of every part of every pipe [m]."""
    return [part.diameter for pipe in run.pipes for part in pipe.parts]


def _thickest(run: PipeRun) -> float:
    """Radius of the thickest pipe [m]."""
    return 0.5 * max(_diameters_of(run))
