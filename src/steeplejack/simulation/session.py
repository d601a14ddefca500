"""Run a mission in physics and leave one log."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np

from steeplejack.planning.compatibility import Verdict
from steeplejack.planning.mission import Mission
from steeplejack.robots.squad.anchorage import Stance
from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.comparison import differing
from steeplejack.robots.squad.parameters import Squad
from steeplejack.runtime.recorder import Recorder, Seed, Site, StayRecord, VerdictRecord
from steeplejack.runtime.reference import LegReference
from steeplejack.runtime.run import Result, Supervisor
from steeplejack.simulation.camera import Photographer
from steeplejack.simulation.plant import SquadPlant
from steeplejack.spatial import from_quaternion
from steeplejack.worksite import Bridge

MARGIN = 2.0  # [m] of rail beyond the places the mission drives to


@dataclass(frozen=True)
class Session:
    """What it takes to run a mission in physics.

    ``actual`` is the machine as it is where it differs from ``squad``, the machine that plan, controller and safety
    believe in; the log then holds both, and names what differs.
    """

    mission: Mission
    bridge: Bridge
    bay: Bay
    squad: Squad
    verdicts: tuple[Verdict, ...]
    seed: int = 0
    actual: Squad | None = None

    @property
    def _starts(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Expected start of every leg and end of the last [s]."""
        extra = 2.0 * self.squad.gripper.close_time + 0.5
        durations = [
            LegReference.of(leg).timing.duration + (extra if leg.kind == "drive" else 0.0) for leg in self.mission.legs
        ]
        return np.concatenate([[0.0], np.cumsum(durations)])

    @property
    def expected_duration(self) -> float:
        """How long the run will take in plant time [s]."""
        return float(self._starts[-1])

    def plant(self) -> SquadPlant:
        """The squad at the mission's first waypoint, in physics."""
        first = self.mission.legs[0].waypoints[0]
        places = np.array([point.base_s_m for leg in self.mission.legs for point in leg.waypoints])
        a, b, c, d = (float(np.radians(angle)) for angle in first.base_clock_deg)
        ranges = [
            (max(0.0, float(low) - MARGIN), float(high) + MARGIN)
            for low, high in zip(places.min(axis=0), places.max(axis=0), strict=True)
        ]
        return SquadPlant(
            self.bay,
            self.actual or self.squad,
            Stance(first.base_s_m, (a, b, c, d)),
            ranges,
            np.array(first.position_m),
            from_quaternion(np.array(first.quaternion)),
            np.array(first.tension_n),
            (self.actual or self.squad).platform.mass + self.mission.request.payload_kg,
            np.array(self.bridge.gravity),
            np.random.default_rng(self.seed),
        )

    def run(
        self,
        log: Path,
        pictures: bool,
        step: Callable[[float], None],
        asked_to_stop: Callable[[], bool] = lambda: False,
    ) -> Result:
        """Run in physics, recording to ``log``.

        ``step`` is called with the time [s] at each sample; the squad stops on its brakes when ``asked_to_stop`` says
        so.

        Pictures need an OpenGL platform that draws without a screen; where there is none the log has none, and says so.
        """
        recorder = Recorder(log)
        photographer = None
        try:
            self._head(recorder)
            plant = self.plant()
            if pictures:
                normal = self.bay.normal(0.5 * (len(self.bay.stays) - 1), self.mission.request.from_m)
                try:
                    photographer = Photographer(plant, self.mission.legs, self._starts, normal)
                except Exception as error:  # noqa: BLE001  # whatever OpenGL raises, a run without pictures is a run
                    recorder.note(0.0, f"no pictures: {type(error).__name__}: {error}")
            gravity = np.array(self.bridge.gravity)
            supervisor = Supervisor(
                self.mission, self.bay, self.squad, plant, gravity, recorder, photographer, asked_to_stop
            )
            return supervisor.run(step)
        finally:
            if photographer is not None:
                photographer.close()
            recorder.close()

    def _head(self, recorder: Recorder) -> None:
        bridge = self.bridge
        x, y, z = bridge.gravity
        stays = tuple(StayRecord.of(stay) for stay in self.bay.stays)
        verdicts = tuple(VerdictRecord(v.stay, v.fits, v.reasons, v.unknown) for v in self.verdicts)
        recorder.write("/worksite", Site(bridge.name, bridge.source, (x, y, z), stays, verdicts), 0.0)
        recorder.write("/robot", self.squad, 0.0)
        if self.actual is not None and (names := differing(self.squad, self.actual)):
            recorder.write("/robot/actual", self.actual, 0.0)
            recorder.note(0.0, f"physics ran a machine other than the file: {', '.join(names)}")
        recorder.write("/mission", self.mission, 0.0)
        recorder.write("/seed", Seed(self.seed, version("steeplejack")), 0.0)
