"""A small planned mission on a real-sized bay, shared by the physics tests."""

from dataclasses import dataclass

import numpy as np
import pytest

from steeplejack.planning import Mission, Request, Rules, Scene, plan, verdicts
from steeplejack.robots.squad import Bay, Squad, Stance, load_squad
from steeplejack.simulation import Session
from steeplejack.simulation.plant import SquadPlant
from steeplejack.spatial import from_quaternion
from steeplejack.worksite import Bridge, load_worksite


@dataclass(frozen=True)
class Case:
    """A planned mission and what it was planned on."""

    bridge: Bridge
    bay: Bay
    squad: Squad
    mission: Mission

    @property
    def session(self) -> Session:
        """The mission, ready to run."""
        return Session(self.mission, self.bridge, self.bay, self.squad, verdicts(self.bridge, self.squad), 4)

    def plant(self, leg: int, point: int) -> SquadPlant:
        """The squad at rest at a waypoint."""
        at = self.mission.legs[leg].waypoints[point]
        clock = tuple(np.radians(at.base_clock_deg))
        return SquadPlant(
            self.bay,
            self.squad,
            Stance(at.base_s_m, clock),
            [(s - 5.0, s + 5.0) for s in at.base_s_m],
            np.array(at.position_m),
            from_quaternion(np.array(at.quaternion)),
            np.array(at.tension_n),
            self.squad.platform.mass,
            np.array(self.bridge.gravity),
            np.random.default_rng(1),
        )


@pytest.fixture(scope="session")
def case() -> Case:
    """Stays 6 and 7 of the default fan, 27-33 m in two cells: every kind of leg."""
    bridge, squad = load_worksite("ecs620-like"), load_squad()
    assert isinstance(bridge, Bridge)
    bay = Bay.of(bridge.fan("T1L-main"), 5, 8, "under", squad)
    rules = Rules(tension=(20.0, 250.0), cell_length=3.0)
    request = Request(bridge.name, squad.name, "T1L-main", (5, 8), 27.0, 33.0, "under", 0.0, rules.tension)
    scene = Scene.of(bay, squad, rules, np.array(bridge.gravity))
    return Case(bridge, bay, squad, plan(scene, request, (), lambda _done: None))
