"""What makes each built-in run of pipes hard, in physics: plans run where the robot passes it, at mu = 0.3."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hung_climber import GRAVITY, LAYOUT, ROBOT, nothing

from steeplejack.planning.climb import ClimbPlan, places, plan_climb
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import footing
from steeplejack.robots.pipe_climber import Layout, load_pipe_climber
from steeplejack.robots.pipe_climber.pads import BOTH, grip_body, grip_use
from steeplejack.robots.pipe_climber.weights import grip_loads
from steeplejack.runtime.climb_record import EndRecord
from steeplejack.simulation.climber.run import ClimbRun
from steeplejack.simulation.climber.sensors import SensorErrors
from steeplejack.simulation.climber.session import ClimbSession
from steeplejack.simulation.climber.watch import Watch
from steeplejack.worksite.pipe_builtin import load_pipe
from steeplejack.worksite.pipe_file import BendPart, GoalEntry, MainEntry, PipeFile, StartEntry, StraightPart
from steeplejack.worksite.pipe_run import PipeRun, build_run

pytestmark = pytest.mark.long


def stretch(plan: ClimbPlan, first: float, last: float) -> ClimbPlan:
    """The part of a plan from where the upper gripper is at a place of the pipe to where the lower one is [m]."""
    phases = plan.phases
    begins = next(i for i, one in enumerate(phases) if one.s_upper >= first and one.kind.startswith("release"))
    ends = next(
        i for i, one in enumerate(phases) if i > begins and one.s_lower >= last and one.kind.startswith("release")
    )
    return replace(plan, phases=phases[begins:ends])


@pytest.mark.parametrize(
    ("name", "first", "last"),
    [("flange", 0.28, 0.42), ("clock-obstacle", 0.28, 0.42), ("around", 0.24, 0.40), ("bend-300", 0.33, 0.40)],
)
def test_the_hard_part_is_climbed_within_a_millimetre_and_half_a_degree(name: str, first: float, last: float) -> None:
    run = load_pipe(name)
    plan = stretch(plan_climb(run, ROBOT), first, last)
    mu = ROBOT.gripper.friction
    plant = ClimbSession(plan, run, ROBOT, LAYOUT, (mu, mu)).plant()
    watch = Watch(plant, run, None)
    end = ClimbRun(plan, run, ROBOT, LAYOUT, plant, watch).run(nothing)
    assert end.completed and end.safe and end.slips == 0 and end.collisions == 0
    closed = [grip for grip in watch.grips if grip.phase > 0]
    assert len(closed) == sum(one.kind.startswith("grip") for one in plan.phases)
    assert max(grip.error_m for grip in closed) < 1e-3
    assert max(grip.place_error_m for grip in closed) < 1e-3
    assert max(grip.error_rad for grip in closed) < math.radians(0.5)
    moving = [one for sample in watch.samples if sample.act == "move" for one in sample.margin if one is not None]
    assert min(moving) > ROBOT.gait.reserve - 0.02  # as planned, but for the edges of the cones
    turned = max(abs(sample.reference[3]) for sample in watch.samples)
    assert (turned > 0.1) is (name in ("clock-obstacle", "around"))


def test_a_change_of_diameter_is_climbed_with_one_row_of_pads_at_a_time() -> None:
    """At a friction with which one row holds alone: open jaws clear the thicker pipe below their middle."""
    robot = msgspec.structs.replace(ROBOT, gripper=msgspec.structs.replace(ROBOT.gripper, friction=0.7))
    run = replace(load_pipe("reducer"), start_s=0.29, goal_s=0.46)
    plan = plan_climb(run, robot)
    plant = ClimbSession(plan, run, robot, LAYOUT, (0.7, 0.7)).plant()
    watch = Watch(plant, run, None)
    end = ClimbRun(plan, run, robot, LAYOUT, plant, watch).run(nothing)
    assert end.completed and end.safe and end.slips == 0 and end.collisions == 0
    moving = [one for sample in watch.samples if sample.act == "move" for one in sample.margin if one is not None]
    machine = Machine.of(robot)
    radius, rows = footing(machine, run.pipe("main"), np.array([0.41]))[0]
    loads = grip_loads(robot, LAYOUT, np.array([0.0, 0.15, 0.0, 0.0]), GRAVITY)
    assert int(rows) != BOTH
    assert min(moving) == pytest.approx(1.0 - grip_use(grip_body(robot, float(radius), int(rows)), loads[0]), abs=0.05)


def bent(radius: float) -> PipeRun:
    """A vertical pipe of 60 mm with a bend of 30 degrees."""
    straight, bend = StraightPart(length=0.4), BendPart(radius=radius, angle_deg=30.0, toward_deg=0.0)
    file = PipeFile(
        name="bent", description="a bend of 30 degrees", source="test", start=StartEntry(s=0.05),
        goal=GoalEntry(s=0.5 + bend.radius * math.radians(bend.angle_deg)),
        main=MainEntry(diameter=0.06, parts=(straight, bend, straight)),
    )  # fmt: skip
    return build_run(file, "test")


def test_the_tightest_bend_that_grippers_close_in_is_climbed_without_a_slip() -> None:
    """Stiff jaws give by 0.5 mm there before both rows touch; where they would give by 1.8 mm the plan is refused."""
    run, mu = bent(0.17), ROBOT.gripper.friction
    plan = plan_climb(run, ROBOT)
    plant = ClimbSession(plan, run, ROBOT, LAYOUT, (mu, mu)).plant()
    watch = Watch(plant, run, None)
    end = ClimbRun(plan, run, ROBOT, LAYOUT, plant, watch).run(nothing)
    assert plan.complete and end.completed and end.safe and end.slips == 0 and end.collisions == 0
    assert max(grip.error_m for grip in watch.grips) < 1.2e-3
    refused = plan_climb(bent(0.09), ROBOT)
    assert not refused.complete and "bends of at least 1" in str(refused.blocked)


def test_grippers_slip_in_a_bend_where_rows_give_by_more_than_they_may(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the limit is for: planned as if any give were allowed, 1.8 mm of it are slips."""
    monkeypatch.setattr(places, "GIVE", 1.0)
    run, mu = bent(0.09), ROBOT.gripper.friction
    plan = plan_climb(run, ROBOT)
    plant = ClimbSession(plan, run, ROBOT, LAYOUT, (mu, mu)).plant()
    end = ClimbRun(plan, run, ROBOT, LAYOUT, plant, Watch(plant, run, None)).run(nothing)
    assert plan.complete and end.slips > 0


def crossed(start_clock: float) -> tuple[ClimbPlan, EndRecord, Watch]:
    """The planar cross by a robot that begins at a clock, sensors with the errors of seed 0."""
    run, robot = replace(load_pipe("planar-cross"), start_clock=start_clock), load_pipe_climber("pipe-climber-cross")
    plan, mu = plan_climb(run, robot), robot.gripper.friction
    plant = ClimbSession(plan, run, robot, Layout.of(robot), (mu, mu)).plant()
    watch = Watch(plant, run, None)
    return plan, ClimbRun(plan, run, robot, Layout.of(robot), plant, watch).run(nothing), watch


def test_the_planar_cross_is_climbed_over() -> None:
    """With cylinders of 120 mm: the upper gripper goes over to the level pipe, then the lower one after it."""
    plan, end, watch = crossed(math.pi)
    assert end.completed and end.safe and end.slips == 0 and end.collisions == 0
    assert [grip.gripper for grip in watch.grips][-1] == "lower" and plan.phases[-1].pipe_lower == "level"
    assert max(grip.error_m for grip in watch.grips) < 1e-3
    assert max(grip.place_error_m for grip in watch.grips) < 1e-3
    assert max(grip.error_rad for grip in watch.grips) < math.radians(0.5)
    assert max(sample.max_force_n for sample in watch.samples) < 50.0


def test_half_a_turn_before_the_cross_costs_what_the_servo_errs() -> None:
    """Its scale error adds up over six turns, and at the level pipe jaws pull the robot round by that."""
    _plan, end, watch = crossed(0.0)
    assert end.completed and end.safe and end.collisions == 0
    met = next(grip for grip in watch.grips if grip.place_error_m > 1e-3)
    servo = SensorErrors.drawn(np.random.default_rng(0)).servo[0]
    assert met.gripper == "upper"
    assert met.place_error_m == pytest.approx(math.pi * abs(servo) * 0.2033, rel=0.25)  # the way out to that pipe
    assert max(grip.error_m for grip in watch.grips) < 1.5e-3
    assert max(grip.error_rad for grip in watch.grips) < math.radians(0.5)
