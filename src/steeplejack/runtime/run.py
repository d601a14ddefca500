"""Run a mission on a plant: references in, commands out, everything checked and recorded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.control.controller import PlatformController, Setpoint, State
from steeplejack.errors import InputError, SteeplejackError
from steeplejack.mechanics.cable.rest.statics import directions
from steeplejack.planning.mission import Mission
from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Squad
from steeplejack.robots.squad.suspension import force_family
from steeplejack.runtime import recorder as log
from steeplejack.runtime.gait import TRANSITIONS, Phase, Progress, judge
from steeplejack.runtime.plant import Command, Measurement, Plant
from steeplejack.runtime.reference import LegReference
from steeplejack.safety import BREACHES, HELD, NOT_A_NUMBER, Monitor
from steeplejack.spatial import to_quaternion

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

BY_OPERATOR = "interrupted by the operator"
CONTROL_STEP = 1e-3  # [s]
SAMPLE_EVERY = 50  # control steps between samples of the log
SETTLE = 1.0  # [s] on the brakes with the palms closed, recorded, after a stop


@dataclass(frozen=True)
class Result:
    """How a run ended."""

    completed: bool
    duration: float  # [s] of plant time
    faults: tuple[str, ...]


class Supervisor:
    """Drives one squad through one mission, step by step.

    Args:
        mission: What to do.
        bay: The stays.
        squad: The machine.
        plant: The squad itself, or its simulation.
        gravity: Of the worksite (3,) [m/s2].
        recorder: Where everything is kept.
        picture: Called at each sample with the time [s]; a picture to log, or None.
        asked_to_stop: Called at each step; the squad stops on its brakes when it says so.

    Raises:
        SteeplejackError: Control and plant steps do not divide.
        InputError: The mission is not the one that was planned.
    """

    def __init__(
        self,
        mission: Mission,
        bay: Bay,
        squad: Squad,
        plant: Plant,
        gravity: Array,
        recorder: log.Recorder,
        picture: Callable[[float], log.Picture | None] | None = None,
        asked_to_stop: Callable[[], bool] = lambda: False,
    ) -> None:
        if not mission.intact:
            raise InputError("mission", "content does not match its sha256", "a mission not edited since planning")
        ratio = CONTROL_STEP / plant.step
        if abs(ratio - round(ratio)) > 1e-9 or round(ratio) < 1:
            raise SteeplejackError(f"control step {CONTROL_STEP} s is not a multiple of the plant's {plant.step} s")
        self._substeps = round(ratio)
        self._mission, self._squad, self._plant, self._recorder = mission, squad, plant, recorder
        self._picture, self._asked_to_stop = picture, asked_to_stop
        request = mission.request
        mass = squad.platform.mass + request.payload_kg
        self._controller = PlatformController(bay, squad, mass, gravity, request.tension_n)
        self._monitor = Monitor(bay, squad, mass * gravity, request.tension_n)
        self._attachments = np.array(squad.platform.attachments)
        self._references = [LegReference.of(leg) for leg in mission.legs]
        self._command = Command(np.zeros(4), np.zeros(4), np.zeros(4), np.ones(4, bool), np.zeros(4, bool))
        self._steps = 0
        self._watch, self._tension = np.empty(0), np.zeros(4)
        self._residual, self._status = 0.0, 0

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self._steps * CONTROL_STEP

    def run(self, step: Callable[[float], None]) -> Result:
        """Run every leg; ``step`` is called with the time [s] at each sample. Stops on the brakes at a breach."""
        measured = self._plant.measure()
        first = self._references[0].at(0.0)
        state = self._controller.begin(first, measured.values)
        self._watch, self._tension = self._monitor.begin(first.tension, measured.clock), first.tension
        for index, reference in enumerate(self._references):
            state, setpoint, phase, why = self._leg(index, reference, state, step)
            if phase is Phase.STOPPED:
                self._stop(index, reference, state, setpoint, why)
                return Result(False, self.time, (why,))
        self._recorder.note(self.time, "mission complete")
        return Result(True, self.time, ())

    def _leg(
        self, index: int, reference: LegReference, state: State, step: Callable[[float], None]
    ) -> tuple[State, Setpoint, Phase, str]:
        leg = reference.leg
        base = None if leg.base is None else leg.base - 1
        progress = Progress(Phase.FLY if base is None else Phase.OPEN, self.time)
        self._note(progress.phase, index)
        moving = np.zeros(4, bool)
        goal = 0.0 if base is None else leg.waypoints[-1].base_s_m[base]
        nominal, close_time = self._squad.gripper.force, self._squad.gripper.close_time
        duration = reference.timing.duration
        while True:
            elapsed = self.time - progress.since
            under_way = progress.phase is Phase.FLY or progress.phase is Phase.DRIVE
            setpoint = reference.at(elapsed if under_way else 0.0 if progress.phase is Phase.OPEN else duration)
            if base is not None:
                moving[base] = True
                self._command.grip[base] = progress.phase in (Phase.CLOSE, Phase.VERIFY)
            # The wheels carry the base until its palms are closed; the grip is verified without them.
            driven = moving & (progress.phase is not Phase.VERIFY)
            state, measured, breach = self._step(state, setpoint, moving, driven)
            if self._steps % SAMPLE_EVERY == 0:
                self._sample(index, reference, progress.phase, state, setpoint, measured, moving)
                step(self.time)
            if breach:
                return state, setpoint, Phase.STOPPED, breach
            palm = 1.0 if base is None else measured.palm[base] / nominal
            s = 0.0 if base is None else float(measured.s[base])
            outcome = judge(progress, self.time, duration, float(palm), s, goal, close_time)
            if outcome is None:
                continue
            phase = TRANSITIONS[progress.phase, outcome]
            if phase is Phase.STOPPED:
                return state, setpoint, phase, f"{progress.phase.value}: {outcome.value}"
            if phase is Phase.DONE:
                self._command.grip[:] = True
                return state, setpoint, phase, ""
            progress = Progress(phase, self.time, s)
            self._note(phase, index)

    def _step(self, state: State, setpoint: Setpoint, moving: Flags, driven: Flags) -> tuple[State, Measurement, str]:
        """Measure, control, check, command, advance; the breach in words, or nothing."""
        measured = self._plant.measure()
        if not measured.readable:
            # Nothing can be computed from such a reading; the squad stops on what it knew before.
            self._steps += 1
            return state, measured, BREACHES[NOT_A_NUMBER]
        after, output = self._controller.step(state, setpoint, measured.values, driven, CONTROL_STEP)
        self._status, self._residual = output.status, output.residual
        verdict = self._monitor.step(
            self._watch,
            measured.values,
            output.command,
            self._command.grip,
            moving,
            setpoint.position,
            setpoint.rotation,
            CONTROL_STEP,
        )
        self._watch, self._tension = verdict.state, verdict.tension
        self._steps += 1
        if verdict.code:
            where = f" ({verdict.where + 1})" if verdict.where >= 0 else ""
            return after, measured, BREACHES[verdict.code] + where
        if self._asked_to_stop():
            return after, measured, BY_OPERATOR
        command = self._command
        command.pull, command.drive, command.turn = output.command
        self._plant.apply(command)
        self._plant.advance(self._substeps)
        return after, measured, ""

    def _stop(self, index: int, reference: LegReference, state: State, setpoint: Setpoint, why: str) -> None:
        """Brakes of winches and wheels on, palms closing: hold there, and keep recording for a while."""
        self._recorder.note(self.time, why, "breach")
        self._command.brake[:], self._command.wheel_brake[:], self._command.grip[:] = True, True, True
        self._command.drive, self._command.turn = np.zeros(4), np.zeros(4)
        self._command.pull = np.zeros(4)
        self._plant.apply(self._command)
        preload = HELD * self._squad.gripper.force
        for _ in range(round((self._squad.gripper.close_time + SETTLE) / CONTROL_STEP)):
            self._plant.advance(self._substeps)
            self._steps += 1
            if self._steps % SAMPLE_EVERY == 0:
                measured = self._plant.measure()
                self._sample(index, reference, Phase.STOPPED, state, setpoint, measured, measured.palm < preload)
        loose = np.flatnonzero(~(self._plant.measure().palm >= preload)) + 1
        palms = f"palms of base {', '.join(map(str, loose))} not closed" if len(loose) else "palms closed"
        self._recorder.note(self.time, f"stopped on brakes, {palms}", "stop")

    def _note(self, phase: Phase, index: int) -> None:
        leg = self._mission.legs[index]
        what = f"base {leg.base}" if leg.base else (leg.stay or "platform")
        self._recorder.note(self.time, f"leg {index}: {phase.value}, {what}", "phase")

    def _sample(
        self,
        index: int,
        reference: LegReference,
        phase: Phase,
        state: State,
        setpoint: Setpoint,
        measured: Measurement,
        moving: Flags,
    ) -> None:
        """Write one sample of everything; what the plant knows to be true comes before what is estimated."""
        truth = self._plant.truth()
        least, largest = self._plant.extremes()
        actual = truth if truth is not None else state
        u, _lengths = directions(actual.exits, self._attachments, actual.position, actual.rotation)
        along = np.abs(np.sum(u * state.tangents, axis=1))
        limit = np.where(moving, self._squad.base.drive_force, self._squad.base.hold_force)
        margin = 1.0 - largest * along / limit
        velocity = truth.velocity if truth is not None else state.velocity[3:]
        s = truth.s if truth is not None else measured.s
        base = reference.leg.base if moving.any() else None
        sample = log.State(
            self.time,
            index,
            phase.value,
            reference.leg.stay or "",
            base or 0,
            setpoint.position.tolist(),
            state.position.tolist(),
            actual.position.tolist(),
            to_quaternion(setpoint.rotation).tolist(),
            to_quaternion(state.rotation).tolist(),
            to_quaternion(actual.rotation).tolist(),
            velocity.tolist(),
            setpoint.tension.tolist(),
            self._tension.tolist(),
            actual.tension.tolist(),
            float(largest.max()),
            float(least.min()),
            float(margin.min()),
            margin.tolist(),
            planar_tension_factor(u, actual.rotation, setpoint.rotation, self._attachments),
            setpoint.s.tolist(),
            np.where(np.isfinite(measured.s), measured.s, setpoint.s).tolist(),  # JSON has no word for NaN
            s.tolist(),
            state.exits.tolist(),
            actual.exits.tolist(),
            float(self._residual),
            int(self._status),
        )
        self._recorder.write("/state", sample, self.time)
        if self._picture is not None:
            picture = self._picture(self.time)
            if picture is not None:
                self._recorder.write("/camera", picture, self.time)


def planar_tension_factor(u: Array, rotation: Array, plane: Array, attachments: Array) -> float:
    """Tension factor (Eq. 12) of the squad in the plane of its cables, 0 outside wrench closure.

    Args:
        u: Cable directions (4, 3).
        rotation: Platform orientation (3, 3).
        plane: Rotation whose first two columns span the plane (3, 3).
        attachments: Attachments (4, 3) [m], platform frame.
    """
    arms = attachments @ rotation.T
    rows = np.column_stack([u @ plane[:, 0], u @ plane[:, 1], np.cross(arms, u) @ plane[:, 2]])
    rows[:, 2] /= np.mean(np.linalg.norm(attachments, axis=1))
    _particular, null, independent = force_family(np.ascontiguousarray(rows), np.zeros(3))
    if not independent or null.min() * null.max() <= 0.0:
        return 0.0
    return float(np.abs(null).min() / np.abs(null).max())
