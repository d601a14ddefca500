"""Plans of the built-in runs and of runs made for one limit each: references, replays, refusals and their reasons."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from climb_cases import ROBOT, analysed, attacked, changed, random_run

from steeplejack.errors import InputError
from steeplejack.planning.climb import ClimbPlan, Hold, faults, plan_climb
from steeplejack.planning.climb.blocked import explain
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.pairs import join
from steeplejack.planning.climb.planner import as_plan, climb
from steeplejack.robots.pipe_climber import PipeClimber
from steeplejack.worksite.pipe_builtin import load_pipe
from steeplejack.worksite.pipe_run import PipeObstacle, PipeRun, with_bends

pytestmark = pytest.mark.long


def coarse(run: PipeRun, robot: PipeClimber = ROBOT) -> ClimbPlan:
    """The plan on a coarse lattice, without asking why it ends."""
    machine = Machine.of(robot)
    return as_plan(run, machine, climb(run, machine, (10,)), None)


def refusal(run: PipeRun, robot: PipeClimber = ROBOT, payload_kg: float = 0.0) -> str:
    """Why a run is not climbed, from a coarse lattice."""
    machine = Machine.of(robot, payload_kg)
    found = climb(run, machine, (10,))
    assert not found.complete
    why = explain(run, machine, found)
    assert "\n" not in why
    return why


def strides(plan: ClimbPlan, hold: Hold) -> np.ndarray:
    moves = [phase for phase in plan.phases if phase.kind == "move" and phase.hold is hold]
    return np.array([abs(phase.end[1] - phase.start[1]) for phase in moves])


def test_straight_climb_is_as_fast_as_its_bound_allows():
    run = load_pipe("straight-vertical")
    plan = plan_climb(run, ROBOT)
    assert plan.complete and plan.blocked is None
    assert faults(plan, run, ROBOT) == []
    assert plan.reached_m == pytest.approx(1.0)
    speed = plan.reached_m / plan.duration
    stroke, grips = ROBOT.cylinders.stroke, 4.0 * ROBOT.gripper.close_time
    assert speed >= 0.95 * stroke / (2.0 * stroke / ROBOT.cylinders.speed + grips)
    assert speed >= 8.07e-3
    assert plan.steps == 20
    np.testing.assert_allclose(strides(plan, Hold.LOWER), 0.05)


@pytest.mark.parametrize("name", ["around", "bend-300", "flange", "clock-obstacle"])
def test_built_in_runs_are_climbed_within_every_limit(name):
    run = load_pipe(name)
    plan = coarse(run)
    assert plan.complete
    assert faults(plan, run, ROBOT) == []
    assert plan.reached_m == pytest.approx(run.goal_s - run.start_s, abs=5e-3)
    turns = [abs(phase.end[3] - phase.start[3]) for phase in plan.phases]
    assert max(turns) <= math.radians(30.0) + 1e-6


def test_a_finer_lattice_is_not_slower():
    run, machine = load_pipe("flange"), Machine.of(ROBOT)
    durations = [climb(run, machine, parts).duration for parts in ((5,), (5, 10), (5, 10, 20))]
    assert durations == sorted(durations, reverse=True)


def test_turning_goes_either_way_in_steps_of_the_linkage():
    run = load_pipe("around")
    clocks = [phase.clock for phase in coarse(run).phases]
    assert max(clocks) - min(clocks) > math.radians(30.0)
    mirrored = replace(
        run,
        obstacles=tuple(replace(one, clock=(math.pi - one.clock[1], math.pi - one.clock[0])) for one in run.obstacles),
    )
    other = [phase.clock for phase in coarse(mirrored).phases]
    assert faults(coarse(mirrored), mirrored, ROBOT) == []
    signs = {np.sign(clocks[int(np.argmax(np.abs(clocks)))]), np.sign(other[int(np.argmax(np.abs(other)))])}
    assert signs == {-1.0, 1.0}


def step_in_bend(robot: PipeClimber, radius: float, side: int = 0) -> float:
    """Difference of the largest and the least distance along a bend at which the grippers can both hold [m]."""
    run = with_bends(load_pipe("bend-300"), radius / 0.3)
    begin = run.pipes[0].parts[1].start
    gaps = np.linspace(1e-3, radius * math.pi / 2, 20001)
    lower = run.centre_line(np.full_like(gaps, begin))
    joined = join(Machine.of(robot), np.array(run.gravity), lower, run.centre_line(begin + gaps))
    good = gaps[joined.allowed[:, side]]
    return float(np.ptp(good)) if len(good) else 0.0


@pytest.mark.parametrize(("hz", "step"), [(0.0, 0.0665), (0.06, 0.0104), (0.08, 0.0)])
def test_step_in_the_bend_of_300_mm_is_the_published_one(hz, step):
    assert step_in_bend(analysed(claw_offset=hz), 0.3) == pytest.approx(step, abs=3e-4)


def test_least_bend_radius_is_the_published_one():
    assert step_in_bend(analysed(), 0.1470) == 0.0
    assert step_in_bend(analysed(), 0.1480) > 0.0
    assert step_in_bend(analysed(), 0.1690) < 0.010 < step_in_bend(analysed(), 0.1700)


def test_a_bend_is_refused_with_an_offset_claw_and_the_reason_names_it():
    run = load_pipe("bend-300")
    assert "claw's offset hz of 80 mm" in refusal(run, analysed(claw_offset=0.08))
    assert coarse(run, analysed(claw_offset=0.0)).complete


def test_a_bend_toward_minus_x_is_passed_by_turning_first_and_refused_without():
    run = replace(load_pipe("bend-300"), start_clock=math.pi)
    plan = coarse(run)
    assert plan.complete
    assert faults(plan, run, ROBOT) == []
    in_bend = [phase for phase in plan.phases if abs(phase.end[2]) > 0.1]
    assert all(phase.end[2] > 0.0 for phase in in_bend)
    stiff = changed(ROBOT, "rcm", limit=1e-3)
    assert "tilt of 30 deg" in refusal(run, stiff)


def test_a_collar_higher_than_the_clearance_is_refused_and_says_how_much_is_needed():
    run = load_pipe("flange")
    run = replace(run, obstacles=tuple(replace(one, height=0.020) for one in run.obstacles))
    why = refusal(run)
    assert "clearance of 15 mm" in why and "a clearance of 20 mm" in why


def test_a_collar_longer_than_a_stride_less_the_jaws_is_refused():
    run = load_pipe("flange")
    for length, passes in ((0.0099, True), (0.0102, False)):
        longer = replace(run, obstacles=(PipeObstacle("main", 0.345, 0.345 + length, 0.012, None, "collar"),))
        assert coarse(longer).complete is passes


def test_a_pipe_too_thick_is_refused_for_its_diameter():
    run = load_pipe("flange")
    pipe = run.pipes[0]
    thick = replace(run, obstacles=(), pipes=(replace(pipe, parts=(replace(pipe.parts[0], diameter=0.09),)),))
    plan = plan_climb(thick, ROBOT)
    assert plan.blocked is not None and "pipe diameters, 50 to 80 mm" in plan.blocked
    assert plan.phases == ()


def test_a_load_beyond_the_grip_is_refused_for_friction():
    run = load_pipe("flange")
    assert coarse(run).complete
    assert "friction of 0.3" in refusal(run, payload_kg=0.5)
    with pytest.raises(InputError, match="payload"):
        plan_climb(run, ROBOT, payload_kg=math.nan)


def test_the_planar_cross_needs_the_mechanisms_whole_reach_and_tilt():
    run = load_pipe("planar-cross")
    free = analysed(tilt_deg=90.0)
    plan = coarse(run, free)
    assert plan.complete
    assert faults(plan, run, free) == []
    assert {phase.pipe_lower for phase in plan.phases} == {"main", "level"}
    assert not climb(run, Machine.of(analysed()), (5,)).complete


@pytest.mark.parametrize("seed", range(6))
def test_random_runs_are_climbed_within_limits_or_not_passed_by_sampling(seed):
    run = random_run(seed)
    plan = coarse(run)
    assert faults(plan, run, ROBOT) == []
    if not plan.complete:
        far = attacked(run, ROBOT, plan, np.random.default_rng(seed), 100)
        assert far <= run.start_s + plan.reached_m + 3e-3


def test_a_replay_sees_what_is_wrong():
    run = load_pipe("flange")
    plan = coarse(run)
    swapped = replace(plan, phases=(plan.phases[1], plan.phases[0], *plan.phases[2:]))
    assert faults(swapped, run, ROBOT)
    fast = replace(plan, phases=tuple(replace(phase, times=0.5 * phase.times) for phase in plan.phases))
    assert any("m/s" in fault for fault in faults(fast, run, ROBOT))
    assert any("obstacle" in fault for fault in faults(plan, replace(run, obstacles=(
        PipeObstacle("main", 0.25, 0.26, 0.012, None, "collar"),)), ROBOT))  # fmt: skip
    weak = changed(ROBOT, "cylinders", force=1.0)
    assert any("force" in fault for fault in faults(plan, run, weak))
    assert faults(replace(plan, phases=plan.phases[:-1]), run, ROBOT)
