"""Plans of the built-in runs and of runs made for one limit each: references, replays, refusals and their reasons."""

from __future__ import annotations

import math
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from climb_cases import CRIPPLED, ROBOT, analysed, changed, noticed, trial

from steeplejack.errors import InputError
from steeplejack.planning.climb import ClimbPlan, Hold, faults, plan_climb
from steeplejack.planning.climb.blocked import explain
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.pairs import join
from steeplejack.planning.climb.planner import as_plan, climb
from steeplejack.robots.pipe_climber import PipeClimber, load_pipe_climber
from steeplejack.robots.pipe_climber.statics import friction_needed
from steeplejack.worksite.pipe_builtin import load_pipe
from steeplejack.worksite.pipe_run import PipeObstacle, PipeRun, with_bends

pytestmark = pytest.mark.long

PUBLISHED = tomllib.loads((Path(__file__).parents[1] / "reference" / "pipe_climber.toml").read_text())
BENDS = PUBLISHED["bends"]
MUTATED = {"does not turn": (0, 11), "steps over nothing": (3, 10), "short steps": (5,), "wrong clearance": (5,)}
"""Random runs that a crippled planner refuses wrongly."""


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
    assert 0.95 * PUBLISHED["climbing"]["speed"] <= speed <= PUBLISHED["climbing"]["speed"]
    assert plan.duration / plan.steps >= PUBLISHED["climbing"]["cycle"]
    assert plan.steps == 20
    np.testing.assert_allclose(strides(plan, Hold.LOWER), 0.05)


@pytest.mark.parametrize("name", ["around", "bend-300", "flange", "clock-obstacle"])
def test_built_in_runs_are_climbed_within_every_limit(name: str):
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


def test_turning_goes_in_steps_of_the_linkage_wherever_it_begins():
    run = load_pipe("around")
    plan = coarse(run)
    clocks = np.degrees([(phase.clock, phase.clock + phase.end[3]) for phase in plan.phases])
    assert np.abs(clocks).max() >= 50.0
    assert np.abs(np.diff(clocks, axis=0)).max() <= 30.0 + 1e-4
    # Turned about the pipe by half a turn, run and robot, it is the same climb.
    turned = replace(run, start_clock=run.start_clock + math.pi, obstacles=tuple(
        replace(one, clock=(one.clock[0] + math.pi, one.clock[1] + math.pi)) for one in run.obstacles if one.clock
    ))  # fmt: skip
    assert coarse(turned).duration == pytest.approx(plan.duration)


def test_a_lug_too_high_to_step_over_is_passed_by_turning():
    run = load_pipe("clock-obstacle")
    lug = run.obstacles[0]
    assert lug.height > ROBOT.gait.clearance and lug.clock is not None
    plan = coarse(run)
    assert plan.complete
    assert faults(plan, run, ROBOT) == []
    beside = [phase for phase in plan.phases if phase.s_lower < lug.start < phase.s_upper]
    assert (
        min(abs(phase.clock + phase.start[3]) for phase in beside)
        >= 0.5 * (lug.clock[1] - lug.clock[0]) + ROBOT.gait.palm - 1e-9
    )
    straight_on = coarse(replace(run, obstacles=()))
    assert {phase.clock for phase in straight_on.phases} == {0.0}
    said = faults(straight_on, run, ROBOT)
    assert any("palm" in one for one in said) and any("bar" in one for one in said)
    stiff = changed(ROBOT, "rcm", limit=1e-3)
    why = refusal(run, stiff)
    assert "clearance about the pipe" in why and "linkage range" in why


def test_limbs_and_linkage_keep_clear_of_what_the_palm_passes():
    """A fin where limb 1 is, away from the palm: only the bars meet it; as high as they pass, it is no matter."""
    run = load_pipe("clock-obstacle")
    stiff = changed(ROBOT, "rcm", limit=1e-3)
    for height, passes in ((0.020, False), (0.0119, True)):
        fin = replace(run.obstacles[0], clock=(math.radians(80.0), math.radians(110.0)), height=height)
        assert coarse(replace(run, obstacles=(fin,)), stiff).complete is passes


def step_in_bend(robot: PipeClimber, radius: float, side: int = 0) -> float:
    """Difference of the largest and the least distance along a bend at which the grippers can both hold [m]."""
    run = with_bends(load_pipe("bend-300"), radius / 0.3)
    begin = run.pipes[0].parts[1].start
    gaps = np.linspace(1e-3, radius * math.pi / 2, 20001)
    lower = run.centre_line(np.full_like(gaps, begin))
    joined = join(Machine.of(robot), lower, run.centre_line(begin + gaps))
    good = gaps[joined.allowed[:, side]]
    return float(np.ptp(good)) if len(good) else 0.0


@pytest.mark.parametrize(("hz", "step"), BENDS["steps"])
def test_step_in_the_bend_of_300_mm_is_the_published_one(hz: float, step: float):
    found = step_in_bend(analysed(claw_offset=hz), BENDS["radius"])
    assert step <= found < step + 1e-3 if step else found == 0.0


def test_least_bend_radius_is_the_published_one():
    least, wanted = BENDS["least_radius"], BENDS["least_radius_of_step"]
    assert step_in_bend(analysed(), least - 1e-3) == 0.0 < step_in_bend(analysed(), least)
    assert step_in_bend(analysed(), wanted - 1e-3) < BENDS["step"] < step_in_bend(analysed(), wanted)


def test_a_bend_is_refused_with_an_offset_claw_and_the_reason_names_it():
    run = load_pipe("bend-300")
    why = refusal(run, analysed(claw_offset=0.08))
    assert "claw's offset hz of 80 mm" in why
    enough = re.search(r"reached with hz of (\d+) mm", why)
    assert enough is not None and 0 <= int(enough[1]) < 80
    assert coarse(run, analysed(claw_offset=0.0)).complete


def test_a_bend_to_the_level_is_refused_to_jaws_that_tilt_and_says_so():
    """With rows of pads 25 mm apart one gripper cannot hold 2 kg beside it: in physics it slips in the bend."""
    run, short = load_pipe("bend-300"), changed(ROBOT, "build", jaw_length=0.040)
    why = refusal(run, short)
    assert "friction of 0.3 with 40 N a jaw" in why and "jaws of" in why
    plan = coarse(run)
    assert any("slips or tilts" in fault for fault in faults(plan, run, short))


def test_in_the_bend_the_workspace_is_toward_plus_x_alone():
    assert step_in_bend(analysed(), BENDS["radius"], side=1) == 0.0 < step_in_bend(analysed(), BENDS["radius"])


def test_a_bend_toward_minus_x_is_passed_by_turning_first_and_refused_without():
    run = replace(load_pipe("bend-300"), start_clock=math.pi)
    plan = coarse(run)
    assert plan.complete
    assert faults(plan, run, ROBOT) == []
    in_bend = [phase for phase in plan.phases if abs(phase.end[2]) > 0.1]
    assert all(phase.end[2] > 0.0 for phase in in_bend)
    stiff = changed(ROBOT, "rcm", limit=1e-3)
    assert "linkage's range of 0.0573 deg" in refusal(run, stiff)


def test_a_collar_higher_than_the_clearance_is_refused_and_says_how_much_is_needed():
    run = load_pipe("flange")
    run = replace(run, obstacles=tuple(replace(one, height=0.020) for one in run.obstacles))
    why = refusal(run)
    assert "clearance about the pipe of 12 mm" in why
    enough = re.search(r"a clearance of (\d+) mm", why)
    assert enough and 20 <= int(enough[1]) <= 22  # halved down to it


def test_a_collar_longer_than_a_stride_less_a_row_of_pads_is_refused():
    """Between its rows a closed jaw bridges it; a row of 15 mm has to come from one side to the other in a stride."""
    run = load_pipe("flange")
    for length, passes in ((0.0345, True), (0.0352, False)):
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


@pytest.mark.parametrize(("payload", "servo"), [(0.14, 1.96), (0.0, 0.23)])
def test_turning_near_a_limit_is_judged_where_the_turn_is(payload: float, servo: float):
    """Grip, or the servo's torque, within 1 % of what there is: up a vertical pipe a turn changes next to nothing."""
    run, robot = load_pipe("around"), changed(ROBOT, "build", servo_torque=servo)
    plan = plan_climb(run, robot, payload)
    assert plan.complete and faults(plan, run, robot, payload) == []


def test_a_servo_too_weak_to_turn_is_what_a_refusal_names():
    assert "torque of the linkage's servo" in refusal(load_pipe("around"), changed(ROBOT, "build", servo_torque=0.2))


def test_the_planar_cross_needs_the_mechanisms_whole_reach_and_tilt():
    run, free = load_pipe("planar-cross"), load_pipe_climber("pipe-climber-cross")
    plan = coarse(run, free)
    assert plan.complete
    assert faults(plan, run, free) == []
    assert {phase.pipe_lower for phase in plan.phases} == {"main", "level"}
    crossing = [phase for phase in plan.phases if phase.crosses]
    assert len(crossing) == 6 and all("crosses" in phase.why for phase in crossing)
    why = refusal(run)
    assert "tilt of 30 deg" in why and "the goal is reached with the shipped robot pipe-climber-cross" in why


def test_a_change_of_diameter_takes_friction():
    """Across the step the jaws, stiff as they are, touch with one row of pads."""
    run = load_pipe("reducer")
    why = refusal(run)
    enough = re.search(r"reached with friction of ([\d.]+)", why)
    assert "friction of 0.3" in why and enough is not None and 0.55 < float(enough[1]) < 0.58
    grippy = changed(ROBOT, "gripper", friction=0.7)
    plan = coarse(run, grippy)
    assert plan.complete and faults(plan, run, grippy) == []
    step = run.pipes[0].parts[1].start
    across = [phase for phase in plan.phases if abs(phase.s_lower - step) < 0.5 * ROBOT.build.jaw_length]
    assert across
    assert any("slips or tilts" in fault for fault in faults(plan, run, ROBOT))


def test_the_reserve_of_grip_binds_where_it_is_what_is_missing():
    run = load_pipe("flange")
    assert not climb(run, Machine.of(ROBOT, 0.25), (5,)).complete
    why = refusal(run, payload_kg=0.25)
    assert "limit is the 5 % of the grip that are kept in reserve" in why and "a reserve of" in why
    bold = changed(ROBOT, "gait", reserve=0.0)
    assert climb(run, Machine.of(bold, 0.25), (5,)).complete


def test_too_little_friction_is_refused_and_the_amount_is_the_least():
    run, slippery = load_pipe("straight-vertical"), changed(ROBOT, "gripper", friction=0.2)
    why = refusal(run, slippery)
    enough = re.search(r"limit is the friction of 0.2 with 40 N a jaw; .* with friction of ([\d.]+)", why)
    assert enough is not None
    for part, complete in ((1.0, True), (1.0 / 1.03, False)):
        assert coarse(run, changed(ROBOT, "gripper", friction=part * float(enough[1]))).complete is complete


def test_more_friction_is_asked_for_short_of_jamming_only():
    """With 10 kg it is not enough, and pads of 1.7 are next to jamming on the 50 mm the grippers go down to."""
    run, grippy = load_pipe("straight-vertical"), changed(ROBOT, "gripper", friction=1.0)
    amounts = [float(one) for one in re.findall(r"friction of ([\d.]+)", refusal(run, grippy, payload_kg=10.0))]
    assert max(amounts, default=0.0) < 0.9 * ROBOT.build.jamming_friction(0.025) + 1e-3
    assert "friction of" not in refusal(run, changed(ROBOT, "gripper", friction=1.7), payload_kg=12.0)


@pytest.mark.parametrize(
    ("name", "start", "why", "place"),
    [("straight-vertical", 0.0, "end of the pipe", 0.0375), ("flange", 0.315, "obstacle", 0.3325)],
)
def test_a_start_that_grippers_cannot_close_at_names_the_next_one(name: str, start: float, why: str, place: float):
    run = replace(load_pipe(name), start_s=start)
    said = f"cannot begin at {start:.3f} m ({why} under the lower gripper); it can begin at {place:.4f} m"
    assert refusal(run) == said
    assert coarse(replace(run, start_s=place)).complete
    assert not coarse(replace(run, start_s=place - 1e-4)).phases


@pytest.mark.parametrize("seed", [0, *range(2, 9)])
def test_random_runs_are_climbed_within_limits_or_not_passed_by_sampling(seed: int):
    """500 of them: `python tests/planning/climb_cases.py trials.jsonl`. Run 1 takes half a minute of finer lattices."""
    assert trial(seed, 1500)["wrong"] == []


@pytest.mark.parametrize("how", CRIPPLED)
def test_sampling_notices_what_a_planner_leaves_out(how: str):
    """Of the wrong refusals of a planner that cannot do something nearly all are noticed."""
    found = [one for seed in MUTATED[how] if (one := noticed(seed, CRIPPLED[how], 1800)) is not None]
    assert len(found) == len(MUTATED[how]) and all(found)


def test_a_replay_sees_what_is_wrong():
    run = load_pipe("flange")
    plan = coarse(run)
    swapped = replace(plan, phases=(plan.phases[1], plan.phases[0], *plan.phases[2:]))
    assert faults(swapped, run, ROBOT)
    fast = replace(plan, phases=tuple(replace(phase, times=0.5 * phase.times) for phase in plan.phases))
    assert any("m/s" in fault for fault in faults(fast, run, ROBOT))
    assert any("obstacle" in fault for fault in faults(plan, replace(run, obstacles=(
        PipeObstacle("main", 0.20, 0.30, 0.012, None, "collar"),)), ROBOT))  # fmt: skip
    weak = changed(ROBOT, "cylinders", force=1.0)
    assert any("a cylinder is too weak" in fault for fault in faults(plan, run, weak))
    assert faults(replace(plan, phases=plan.phases[:-1]), run, ROBOT)


def test_a_load_no_cylinder_lifts_is_refused_by_name() -> None:
    """On pads that hold it. On those of the robot the grip is too little besides, and the refusal names both."""
    run, rubbing = load_pipe("straight-vertical"), changed(ROBOT, "gripper", friction=1.0)
    plan = plan_climb(run, ROBOT, payload_kg=6.0)
    assert plan.blocked is not None and "none of these changes that by itself" in plan.blocked
    times = re.search(
        r"takes at least ([\d.]+) times the grip .* and ([\d.]+) times the cylinders' force", plan.blocked
    )
    assert times is not None
    hanging = friction_needed(ROBOT.gripper, 8.0 * 9.81) / ROBOT.gripper.friction / (1.0 - ROBOT.gait.reserve)
    assert float(times[1]) >= hanging - 0.1 and float(times[2]) > 1.0
    plan = plan_climb(run, rubbing, payload_kg=6.0)
    assert plan.blocked is not None and "limit is the cylinders' force of 50 N" in plan.blocked
    enough = re.search(r"the goal is reached with cylinders of ([\d.]+) N", plan.blocked)
    assert enough is not None
    for part, climbs in ((1.0, True), (1.0 / 1.03, False)):
        strong = changed(rubbing, "cylinders", force=part * float(enough[1]))
        assert climb(run, Machine.of(strong, 6.0), (5,)).complete is climbs


@pytest.mark.parametrize(
    ("diameter", "payload", "gravity", "said"),
    [
        (0.018, 0.0, 9.81, ["diameter under the lower gripper", "hold none of 20 mm or less"]),
        (0.060, 50.0, 0.0, ["times the grip that may be used and", "times the servo's torque of 1.96 N m"]),
        (0.060, 0.0, 100.0, ["times the grip that may be used and", "times the cylinders' force of 50 N"]),
        (0.060, 1e6, 9.81, ["1e5 times the grip that may be used, 1e5 times the cylinders' force of 50 N and"]),
        (0.040, 0.0, 50.0, ["pipe diameters, 50 to 80 mm (without it holding alone takes at least 4."]),
    ],
)
def test_what_no_limit_alone_is_to_blame_for_is_told(
    diameter: float, payload: float, gravity: float, said: list[str]
) -> None:
    """Pipes, loads and gravities far beyond the robot: what is too little, by how much, and what was tried."""
    run = load_pipe("straight-vertical")
    pipe = run.pipes[0]
    pipe = replace(pipe, parts=tuple(replace(part, diameter=diameter) for part in pipe.parts))
    why = refusal(replace(run, pipes=(pipe,), gravity=(0.0, 0.0, -gravity)), ROBOT, payload)
    assert all(part in why for part in said) and "none of these changes that by itself" in why


def test_bars_that_meet_a_pipe_the_grippers_would_hold_are_named():
    run = load_pipe("straight-vertical")
    pipe = replace(run.pipes[0], parts=tuple(replace(part, diameter=0.14) for part in run.pipes[0].parts))
    wide = changed(ROBOT, "gripper", pipe_diameter=(0.05, 0.2))
    why = refusal(replace(run, pipes=(pipe,)), wide)
    assert "limit is the bars, which pass pipes of up to 84 mm; the goal is reached with bars 29 mm further out" in why


TWO_LUGS = (
    PipeObstacle("main", 0.2545, 0.2595, 0.0204, (math.radians(193.58), math.radians(311.27)), "lug"),
    PipeObstacle("main", 0.3102, 0.3152, 0.0214, (math.radians(247.94), math.radians(364.40)), "lug"),
)
"""Passed only where the mechanism stands at the end of its range of clocks and the other gripper a whole turn away."""


@pytest.mark.parametrize(("length", "climbs"), [(0.70, True), (0.50, False)])
def test_two_lugs_are_passed_and_a_pipe_that_ends_behind_them_is_what_a_refusal_names(length: float, climbs: bool):
    run = load_pipe("straight-vertical")
    pipe = replace(run.pipes[0], parts=tuple(replace(part, length=length) for part in run.pipes[0].parts))
    run = replace(run, pipes=(pipe,), obstacles=TWO_LUGS, goal_s=0.4)
    assert climb(run, Machine.of(ROBOT), (5,)).complete is climbs
    if not climbs:
        assert "limit is the length of the pipe beyond the goal" in refusal(run)
