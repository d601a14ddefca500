"""Run a plan in physics: references in, commands out, grips verified before the other end lets go, slips met."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from steeplejack.control.climber import (
    FIRST,
    TRANSITIONS,
    Act,
    ClimberController,
    Measurement,
    Outcome,
    Reference,
    State,
    Status,
    closed_in,
    taken_up,
)
from steeplejack.control.climber.gait import ALLOWED
from steeplejack.errors import SteeplejackError
from steeplejack.planning.climb.plan import ClimbPlan, Hold, Phase
from steeplejack.robots.pipe_climber import Layout, PipeClimber
from steeplejack.robots.pipe_climber.bearing import holding_forces
from steeplejack.runtime.climb_record import EndRecord
from steeplejack.simulation.climber.odometry import Odometer
from steeplejack.simulation.climber.pipe import clearing
from steeplejack.simulation.climber.plant import ClimberPlant
from steeplejack.simulation.climber.reference import Array, MoveReference
from steeplejack.simulation.climber.truth import ENDS
from steeplejack.simulation.climber.watch import Watch
from steeplejack.worksite.pipe_run import PipeRun

CONTROL_STEP = 4e-3  # [s]
SAMPLE_EVERY = 5  # control steps between samples of the log
ARRIVED = 1e-4  # [m] from a length at the end of a move
TURNED = 5e-3  # [rad] from a turn at the end of a move, a little over what the linkage's servo counts in
PATIENCE = 2.0  # [s] beyond the expected time of an act
CALM = 0.2  # [s] in which nothing may slip after a rescue
SHIFTED = 5.0  # [N] by which a cylinder's force may miss what it should be when a gripper opens
STEADY = 8e-3  # [s] for which it may not miss it by more
SHIFT = 0.1  # [s] after which one opens in any case
SETTLE = 0.5  # [s] recorded after the end, to see that the robot hangs still
BY_OPERATOR = "interrupted by the operator"


@dataclass
class _Course:
    """Where in a phase the robot is."""

    phase: Phase
    reference: MoveReference
    radius: Array
    loads: Array  # (2, 3) [N] of the cylinders at its beginning with the lower, with the upper gripper alone
    act: Act
    since: float  # [s] when the act began
    calm: float  # [s] since when, in a rescue, nothing slips, or the load is what it should be
    moved: int = 0  # control steps into the move
    slips: int = 0
    slipped: int = 0
    why: str = ""


class ClimbRun:
    """Drives one robot through one plan.

    Args:
        plan: What to do.
        run: The pipes.
        robot: The machine.
        layout: Hinges of its limbs.
        plant: The robot, in physics.
        watch: Keeps the log.
        asked_to_stop: Called at each step; the robot stops with both grippers closed when it says so.

    Raises:
        SteeplejackError: Control and physics steps do not divide.
    """

    def __init__(
        self,
        plan: ClimbPlan,
        run: PipeRun,
        robot: PipeClimber,
        layout: Layout,
        plant: ClimberPlant,
        watch: Watch,
        asked_to_stop: Callable[[], bool] = lambda: False,
    ) -> None:
        ratio = CONTROL_STEP / plant.step
        if abs(ratio - round(ratio)) > 1e-9 or round(ratio) < 1:
            raise SteeplejackError(f"control step {CONTROL_STEP} s is not a multiple of the plant's {plant.step} s")
        self._substeps = round(ratio)
        self._plan, self._run, self._robot, self._layout = plan, run, robot, layout
        self._plant, self._watch, self._asked_to_stop = plant, watch, asked_to_stop
        self._controller = ClimberController(robot)
        self._state: State = self._controller.begin(plant.measure())
        self._odometer = Odometer(robot, layout, plant.measure().passed[:, 0])
        self._steps, self._slips, self._regrips = 0, 0, 0

    @property
    def time(self) -> float:
        """Since the start [s]."""
        return self._steps * CONTROL_STEP

    def run(self, step: Callable[[float], None]) -> EndRecord:
        """Run every phase; ``step`` is called with the time [s] at each sample."""
        index, course = self._climb(step)
        ended, why = self.time, course.why if course.act is Act.STOPPED else ""
        if why:
            self._watch.note(ended, why, "stop")
        self._settle(index, course, step)
        return EndRecord(
            not why and self._plan.complete, self._watch.hanging, why, ended, self._watch.travelled,
            self._watch.collisions, self._slips, self._regrips,
        )  # fmt: skip

    def _climb(self, step: Callable[[float], None]) -> tuple[int, _Course]:
        """Run phases up to the last one or to a stop; which it was and where in it the robot is."""
        index = 0
        while True:
            course = self._begin(index, self._plan.phases[index])
            while course.act not in (Act.DONE, Act.STOPPED):
                self._advance(index, course, step)
            if course.act is Act.DONE and course.phase.kind == "move":
                lengths = self._plant.measure().lengths
                self._odometer.moved(course.phase, course.reference, lengths, self._together(index))
            if course.act is Act.STOPPED or index + 1 == len(self._plan.phases):
                return index, course
            index += 1

    def _begin(self, index: int, phase: Phase) -> _Course:
        reference = MoveReference.of(self._layout, phase, CONTROL_STEP)
        aside = phase.crosses and phase.kind == "move"
        self._plant.set_aside(aside and phase.hold is Hold.UPPER, aside and phase.hold is Hold.LOWER)
        measured = self._plant.measure()
        if phase.kind == "move":
            reference = self._odometer.corrected(reference, phase, measured.lengths, self._together(index))
        # Open jaws clear what lies between where their gripper comes from and where it goes.
        later, half = self._plan.phases[index : index + 3], 0.5 * self._robot.build.jaw_length
        radius = max(clearing(self._run, a, b, half) for a, b in zip((phase, *later), later, strict=False))
        pose = np.array(phase.start)
        loads = holding_forces(self._robot, self._layout, pose, measured.gravity, self._plant.payload)
        return _Course(phase, reference, np.full(2, radius), loads, FIRST[phase.kind], self.time, self.time)

    def _together(self, index: int) -> bool:
        """Whether both grippers are on one pipe when a phase has ended."""
        after = self._plan.phases[min(index + 1, len(self._plan.phases) - 1)]
        return after.pipe_lower == after.pipe_upper

    def _load(self, course: _Course) -> Array | None:
        """What the cylinders should bear (3,) [N]: what comes next when one opens, half and half after a slip."""
        if course.act in (Act.SHIFT, Act.OPEN):
            return course.loads[1 if course.phase.hold is Hold.UPPER else 0]
        return course.loads.mean(axis=0) if course.act in (Act.RESCUE, Act.STOPPED) else None

    def _closed(self, course: _Course) -> tuple[bool, bool]:
        kind, hold = course.phase.kind, course.phase.hold
        if kind.startswith("grip") or hold is Hold.BOTH and kind == "move":
            wanted = (True, True)
        elif kind.startswith("release"):
            wanted = (kind == "release-upper", kind == "release-lower")
        else:
            wanted = (hold is Hold.LOWER, hold is Hold.UPPER)
        return closed_in(course.act, wanted, course.slipped)

    def _advance(self, index: int, course: _Course, step: Callable[[float], None]) -> None:
        """One control step: measure, control, judge, command, let time pass."""
        closed = self._closed(course)
        moving, joints = course.act is Act.MOVE, course.reference.joints[course.moved]
        rates = course.reference.rates[course.moved] if moving else np.zeros(4)
        reference = Reference(
            joints[:3], rates[:3], joints[3], float(rates[3]), np.array(closed), course.radius, self._load(course)
        )
        measured = self._plant.measure()
        self._odometer.count(np.array(closed), measured.passed[:, 0])
        before = self._state.held
        self._state, command, status = self._controller.step(self._state, reference, measured, CONTROL_STEP)
        self._plant.apply(command)
        self._plant.advance(self._substeps)
        self._steps += 1
        course.moved = min(course.moved + moving, course.reference.last)
        pose = course.reference.poses[course.moved]
        fresh = status.held & ~before & (course.act in (Act.CLOSE, Act.RECLOSE))
        for end in np.flatnonzero(fresh):
            self._watch.gripped(self.time, index, course.phase, int(end), pose, measured)
        if self._steps % SAMPLE_EVERY == 0:
            self._watch.sample(self.time, index, course.act, closed, pose, measured, status)
            step(self.time)
        outcome = self._judge(course, status, closed)
        if outcome is not None:
            self._change(index, course, outcome, status)

    def _judge(self, course: _Course, status: Status, closed: tuple[bool, bool]) -> Outcome | None:
        """Whether the act is over, from measurements alone."""
        elapsed, act = self.time - course.since, course.act
        if not status.readable or self._asked_to_stop():
            course.why = BY_OPERATOR if status.readable else "a sensor gave no number"
            return Outcome.FAILED
        if status.slipping.any() and act is not Act.RESCUE:
            return Outcome.SLIPPED
        if status.lost:
            course.why = f"a cylinder lags {1e3 * status.lag:.1f} mm behind: more force than it has"
            return Outcome.FAILED
        firm = bool((status.held | ~np.array(closed)).all())
        clear = bool((status.open | np.array(closed)).all())
        match act:
            case Act.MOVE:
                expected = course.reference.duration
                arrived = status.lag <= ARRIVED and status.turn_lag <= TURNED
                reached = course.moved == course.reference.last and arrived
            case Act.CLOSE | Act.RECLOSE:
                expected, reached = self._robot.gripper.close_time, firm
            case Act.SHIFT:
                course.calm = self.time if status.burden > SHIFTED else course.calm
                expected, reached = SHIFT, self.time - course.calm >= STEADY or elapsed >= SHIFT
            case Act.RESCUE:
                expected, reached = CALM, self._calm(course, status, firm)
            case _:
                expected, reached = self._robot.gripper.close_time, firm and clear
        if reached:
            return Outcome.REACHED
        if elapsed > expected + PATIENCE:
            course.why = f"{act.value}: not done after {elapsed:.1f} s"
            return Outcome.FAILED
        return None

    def _calm(self, course: _Course, status: Status, firm: bool) -> bool:
        """Whether both grippers have held for a while; grips that still slide count from here again."""
        if not firm or status.slipping.any():
            course.calm = self.time
        if status.slipping.any():
            self._state = replace(self._state, held=np.zeros(2, bool))
        return self.time - course.calm >= CALM

    def _change(self, index: int, course: _Course, outcome: Outcome, status: Status) -> None:
        """Go on to what the table says."""
        was = course.act
        if outcome is Outcome.SLIPPED:
            course.slipped = int(np.argmax(status.slip))
            course.slips += 1
            self._slips += 1
            what = f"{ENDS[course.slipped]} gripper slips, {1e3 * status.slip[course.slipped]:.2f} mm"
            self._watch.note(self.time, f"{was.value}: {what}", "slip")
            course.why = f"{what}, slip {course.slips} of this phase"
            # Holding grippers count from here again, or one slip would be reported for ever.
            self._state = replace(self._state, held=np.zeros(2, bool))
        act = TRANSITIONS[was, outcome]
        if act is Act.REOPEN and course.slips > ALLOWED:
            act = Act.STOPPED
        if was is Act.RESUME and act is Act.MOVE:
            act = taken_up(course.phase.kind)
        self._regrips += act is Act.RECLOSE
        if act is not Act.DONE:
            self._watch.note(self.time, f"phase {index}: {act.value}", "act")
        course.act, course.since, course.calm = act, self.time, self.time

    def _settle(self, index: int, course: _Course, step: Callable[[float], None]) -> None:
        """Hold with both grippers, screws standing, and keep recording for a while."""
        pose, joints = course.reference.poses[course.moved], course.reference.joints[course.moved]
        both, load = np.ones(2, bool), self._load(course)
        reference = Reference(joints[:3], np.zeros(3), joints[3], 0.0, both, course.radius, load)
        for _ in range(round(SETTLE / CONTROL_STEP)):
            measured: Measurement = self._plant.measure()
            self._state, command, status = self._controller.step(self._state, reference, measured, CONTROL_STEP)
            self._plant.apply(command)
            self._plant.advance(self._substeps)
            self._steps += 1
            if self._steps % SAMPLE_EVERY == 0:
                self._watch.sample(self.time, index, course.act, (True, True), pose, measured, status)
                step(self.time)
