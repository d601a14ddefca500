"""Keeps the log of a climb: what was wanted, what the sensors said, and what the plant knows to be true."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from steeplejack.control.climber import Act, Measurement, Status
from steeplejack.control.climber.signals import Flags
from steeplejack.planning.climb.plan import Phase
from steeplejack.robots.pipe_climber.grippers import free_gripper
from steeplejack.robots.pipe_climber.pads import pad_row
from steeplejack.runtime.climb_record import ClimbSample, GripRecord, pair, pose_record, triple
from steeplejack.runtime.recorder import Picture, Recorder
from steeplejack.simulation.climber.friction_left import friction_left
from steeplejack.simulation.climber.pipe import frame_at
from steeplejack.simulation.climber.plant import ClimberPlant
from steeplejack.simulation.climber.reference import Array
from steeplejack.simulation.climber.truth import ENDS, Truth
from steeplejack.worksite.pipe_run import PipeRun

STILL = 1e-3  # [m/s] of a gripper on a pipe: slower, and it hangs
PRESSED = 0.9  # [1] of what its jaws press with: less, and a gripper is not closed


class Watch:
    """Looks at the plant at every sample and writes down what it sees.

    Args:
        plant: The robot in physics.
        run: The pipes.
        recorder: The log; None keeps nothing but the figures.
    """

    def __init__(self, plant: ClimberPlant, run: PipeRun, recorder: Recorder | None) -> None:
        self._plant, self._run, self._recorder = plant, run, recorder
        self.collisions, self.travelled = 0, 0.0
        self.samples: list[ClimbSample] = []
        self.grips: list[GripRecord] = []
        self._touching: set[tuple[str, str]] = set()
        self._lengths, self._at = plant.measure().lengths, 0.0
        truth = plant.truth()
        self._middle = 0.5 * (truth.lower[:3, 3] + truth.upper[:3, 3])
        self._ends, self._speed = np.stack((truth.lower[:3, 3], truth.upper[:3, 3])), 0.0
        self.picture: Callable[[float], Picture | None] = lambda _time: None
        self.look: Callable[[float], None] = lambda _time: None

    @property
    def hanging(self) -> bool:
        """Whether both grippers pressed on their pipes and stood still at the last sample."""
        robot, truth = self._plant.robot, self._plant.truth()
        places = self._plant.measure().jaws
        # Of their force what acts along the jaws' way where they stand; jaws that met nothing stand anywhere.
        share = places / np.hypot(places, 0.5 * robot.build.jaw_width)
        pressed = truth.press >= PRESSED * robot.gripper.jaws * robot.gripper.force * share
        return bool(self._speed < STILL and np.all(pressed & (truth.press > 0.0)))

    def note(self, at: float, text: str, kind: str) -> None:
        """Write down that something happened."""
        if self._recorder is not None:
            self._recorder.note(at, text, kind)

    def gripped(self, at: float, index: int, phase: Phase, end: int, pose: Array, measured: Measurement) -> None:
        """Write down how well a gripper that has just closed stands."""
        truth, offset = self._plant.truth(), self._plant.robot.linkage.claw_offset
        wanted, actual = free_gripper(pose, offset), np.linalg.solve(truth.lower, truth.upper)
        away = float(np.linalg.norm(wanted[:3, 3] - actual[:3, 3]))
        cosine = 0.5 * (np.trace(wanted[:3, :3].T @ actual[:3, :3]) - 1.0)
        s, pipe = ((phase.s_lower, phase.pipe_lower), (phase.s_upper, phase.pipe_upper))[end]
        place = frame_at(self._run.pipe(pipe), s, 0.0, pad_row(self._plant.robot))
        missed = float(np.linalg.norm((truth.lower, truth.upper)[end][:3, 3] - place[:3, 3]))
        turned = math.acos(min(1.0, max(-1.0, float(cosine))))
        record = GripRecord(at, index, ENDS[end], away, turned, missed, float(measured.grip[end]))
        self.grips.append(record)
        if self._recorder is not None:
            self._recorder.write("/grip", record, at)

    def sample(
        self,
        at: float,
        index: int,
        act: Act,
        closed: tuple[bool, bool],
        pose: Array,
        measured: Measurement,
        status: Status,
    ) -> None:
        """Write one sample."""
        truth, elapsed = self._plant.truth(), max(at - self._at, 1e-9)
        new = set(truth.touching) - self._touching
        self.collisions += len(new)
        for first, second in sorted(new):
            self.note(at, f"{first} touches {second}", "collision")
        self._touching = set(truth.touching)
        ends = np.stack((truth.lower[:3, 3], truth.upper[:3, 3]))
        self._speed = float(np.max(np.linalg.norm(ends - self._ends, axis=1))) / elapsed
        self._ends = ends
        middle = ends.mean(axis=0)
        forward = 0.5 * (truth.lower[:3, 2] + truth.upper[:3, 2])
        self.travelled += float((middle - self._middle) @ forward)
        self._middle = middle
        sample = ClimbSample(
            time_s=at,
            phase=index,
            act=act.value,
            closed=closed,
            reference=pose_record(pose),
            actual=pose_record(_pose_of(truth, self._plant.robot.linkage.claw_offset)),
            lengths_m=triple(measured.lengths),
            speeds_m_s=triple((measured.lengths - self._lengths) / elapsed),
            forces_n=triple(truth.forces),
            max_force_n=float(self._plant.strongest()),
            grip_n=pair(measured.grip),
            margin=_margins(truth, status.held),
            slip_m=pair(status.slip),
            lower_m=triple(truth.lower[:3, 3]),
            upper_m=triple(truth.upper[:3, 3]),
            travelled_m=self.travelled,
            energy_j=self._plant.work,
            collisions=self.collisions,
        )
        self._lengths, self._at = measured.lengths, at
        self.samples.append(sample)
        if self._recorder is not None:
            self._recorder.write("/climb", sample, at)
            self.look(at)
            picture = self.picture(at)
            if picture is not None:
                self._recorder.write("/camera", picture, at)


def _margins(truth: Truth, held: Flags) -> tuple[float | None, float | None]:
    """Friction left to each gripper that is counted on; None of the others."""
    left = friction_left(truth)
    lower, upper = (float(left[i]) if held[i] and np.isfinite(left[i]) else None for i in range(2))
    return lower, upper


def _pose_of(truth: Truth, claw_offset: float) -> Array:
    """(x, w, alpha, beta) nearest to where the upper gripper is from the lower one (4,)."""
    upper = np.linalg.solve(truth.lower, truth.upper)
    beta = math.atan2(-upper[0, 1], upper[1, 1])
    alpha = math.atan2(-upper[2, 0], upper[2, 2])
    out = upper[0, 3] * math.cos(beta) + upper[1, 3] * math.sin(beta)
    return np.array([out - claw_offset * math.sin(alpha), upper[2, 3] - claw_offset * math.cos(alpha), alpha, beta])
