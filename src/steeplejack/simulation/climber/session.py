"""Run a plan of a climb in physics and leave one log."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np

from steeplejack.errors import InputError
from steeplejack.planning.climb.plan import ClimbPlan, Hold, Phase
from steeplejack.robots.pipe_climber import Layout, PipeClimber
from steeplejack.robots.pipe_climber.pads import pad_row
from steeplejack.runtime.climb_record import (
    EndRecord,
    PhaseRecord,
    PlanRecord,
    RunRecord,
    SolidRecord,
    pose_record,
    triple,
)
from steeplejack.runtime.recorder import Recorder
from steeplejack.simulation.climber.camera import Camera, Film, Strip
from steeplejack.simulation.climber.pipe import lower_frame, resting, solids_of
from steeplejack.simulation.climber.plant import ClimberPlant, Start
from steeplejack.simulation.climber.run import ClimbRun
from steeplejack.simulation.climber.sensors import SensorErrors
from steeplejack.simulation.climber.watch import Watch
from steeplejack.worksite.pipe_run import PipeRun

PICTURES = 8


@dataclass(frozen=True)
class ClimbSession:
    """What it takes to run a climb in physics.

    Attributes:
        plan: What to do.
        run: The pipes.
        robot: The machine.
        layout: Hinges of its limbs.
        friction: Of the pads of the lower and the upper gripper on the pipe [1].
        payload: On the upper gripper [kg].
        seed: Of the sensors' errors; None for sensors without.
    """

    plan: ClimbPlan
    run: PipeRun
    robot: PipeClimber
    layout: Layout
    friction: tuple[float, float]
    payload: float = 0.0
    seed: int | None = 0

    def plant(self) -> ClimberPlant:
        """The robot where the plan begins, in physics, both grippers closed.

        Raises:
            InputError: A plan without phases.
        """
        if not self.plan.phases:
            raise InputError("plan", "no phases", "a plan that moves the robot")
        first = self.plan.phases[0]
        under, _rows = resting(self.run, first, self.robot)
        start = Start(lower_frame(self.run, first, pad_row(self.robot)), np.array(first.start), under)
        gravity = np.array(self.run.gravity)
        errors = SensorErrors.drawn(np.random.default_rng(self.seed)) if self.seed is not None else None
        solids = solids_of(self.run)
        return ClimberPlant(self.robot, self.layout, solids, gravity, start, self.friction, self.payload, errors)

    def simulate(
        self,
        log: Path,
        pictures: bool,
        film: bool,
        step: Callable[[float], None],
        asked_to_stop: Callable[[], bool] = lambda: False,
    ) -> EndRecord:
        """Run in physics, recording to ``log``.

        Args:
            log: File to create.
            pictures: Whether to render pictures into it; where OpenGL cannot, the log has none and says so.
            film: Whether to render a film into it, likewise.
            step: Called with the time [s] at each sample.
            asked_to_stop: The robot stops with both grippers closed when it says so.

        Returns:
            How it ended.
        """
        recorder, camera = Recorder(log), None
        try:
            self._head(recorder)
            plant = self.plant()
            watch = Watch(plant, self.run, recorder)
            camera = _camera(plant, recorder) if pictures or film else None
            reel = Film(camera, self.plan.duration) if camera is not None and film else None
            if camera is not None and pictures:
                watch.picture = Strip(camera, self.plan.duration, PICTURES)
            if reel is not None:
                watch.look = reel
            end = ClimbRun(self.plan, self.run, self.robot, self.layout, plant, watch, asked_to_stop).run(step)
            shown = reel.finished(end.duration_s) if reel is not None else None
            if shown is not None:
                recorder.write("/film", shown, end.duration_s)
            recorder.write("/end", end, end.duration_s)
            return end
        finally:
            if camera is not None:
                camera.close()
            recorder.close()

    def _head(self, recorder: Recorder) -> None:
        """What the report has to know beside the samples."""
        run, plan = self.run, self.plan
        solids = tuple(SolidRecord(one.kind, triple(one.start), triple(one.end), one.radius) for one in solids_of(run))
        head = RunRecord(
            run.name, run.description, run.source, run.gravity, self.friction, solids, version("steeplejack"),
            self.payload, self.seed,
        )  # fmt: skip
        recorder.write("/run", head, 0.0)
        recorder.write("/robot", self.robot, 0.0)
        phases = tuple(_recorded(phase) for phase in plan.phases)
        recorder.write(
            "/plan", PlanRecord(phases, float(plan.duration), float(plan.reached_m), plan.complete, plan.blocked), 0.0
        )


def _camera(plant: ClimberPlant, recorder: Recorder) -> Camera | None:
    """A camera, or a note why there is none."""
    try:
        return Camera(plant)
    except Exception as error:  # noqa: BLE001  # whatever OpenGL raises, a run without pictures is a run
        recorder.note(0.0, f"no pictures: {type(error).__name__}: {error}")
        return None


def _recorded(phase: Phase) -> PhaseRecord:
    hold: Hold = phase.hold
    start, end = pose_record(phase.start), pose_record(phase.end)
    places = float(phase.s_lower), float(phase.s_upper), float(phase.clock)
    pipes = phase.pipe_lower, phase.pipe_upper
    return PhaseRecord(phase.kind, hold.value, float(phase.duration), start, end, *places, *pipes, phase.why)
