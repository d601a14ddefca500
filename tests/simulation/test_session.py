"""A whole small mission in physics under closed-loop control, and a stop on the brakes."""

import json

import numpy as np
import pytest
from mcap.reader import make_reader


@pytest.fixture(scope="module")
def run(case, tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    result = case.session.run(path, False, lambda _time: None)
    with path.open("rb") as file:
        messages = [(c.topic, json.loads(m.data)) for _s, c, m in make_reader(file).iter_messages()]
    return result, [data for topic, data in messages if topic == "/state"], messages


def test_mission_completes_with_a_squad_move(case, run) -> None:
    result, states, _messages = run
    assert result.completed, result.faults
    assert case.mission.moves >= 1
    assert {"fly", "open palms", "drive", "close palms", "verify grip"} <= {state["phase"] for state in states}


def test_limits_hold_at_every_step(run) -> None:
    _result, states, _messages = run
    assert max(state["max_tension_n"] for state in states) <= 250.0
    assert min(state["min_tension_n"] for state in states) > 5.0
    assert min(state["min_slip_margin"] for state in states) > 0.0


def test_platform_follows_the_plan(case, run) -> None:
    _result, states, _messages = run
    bay = case.bay
    inspecting = [state for state in states if state["stay"]]
    error = np.array([np.subtract(s["actual_position_m"], s["desired_position_m"]) for s in inspecting])
    along = bay.stays[2].tangent(30.0)
    across = np.cross(along, bay.normal(2.0, 30.0))
    for axis in (along, across):
        assert abs(np.mean(error @ axis)) < 5e-3
        assert np.std(error @ axis) < 11e-3


def test_the_controller_never_sees_the_truth(case, run) -> None:
    """Estimates differ from the truth by sensor errors: millimetres in the plane of the cables, decimetres out of it.

    Out of the plane only the balance of measured tensions says where the platform hangs, and it swings there.
    """
    _result, states, _messages = run
    bay = case.bay
    gap = np.array([np.subtract(s["estimated_position_m"], s["actual_position_m"]) for s in states])
    normal = bay.normal(2.0, 30.0)
    off = gap @ normal
    plane = np.linalg.norm(gap - off[:, None] * normal, axis=1)
    assert 1e-4 < plane.max() < 0.03
    assert np.abs(off).max() < 0.2


def test_a_lost_grip_stops_the_squad_on_its_brakes(case, tmp_path, monkeypatch) -> None:
    """A base whose palms hold a quarter of what they should slips; the run ends early and nothing falls."""
    from steeplejack.simulation.plant import SquadPlant

    weak = SquadPlant._set_friction

    def slippery(self) -> None:
        weak(self)
        if self.data.time > 1.0:
            self.model.dof_frictionloss[self._along_dof[2]] = 0.25 * case.squad.base.hold_force

    original = SquadPlant.advance

    def advance(self, steps: int) -> None:
        slippery(self)
        original(self, steps)

    monkeypatch.setattr(SquadPlant, "advance", advance)
    path = tmp_path / "run.mcap"
    result = case.session.run(path, False, lambda _time: None)
    assert not result.completed
    with path.open("rb") as file:
        messages = [(c.topic, json.loads(m.data)) for _s, c, m in make_reader(file).iter_messages()]
    kinds = [data["kind"] for topic, data in messages if topic == "/event"]
    assert "breach" in kinds
    assert "stop" in kinds
    last = [data for topic, data in messages if topic == "/state"][-1]
    assert np.linalg.norm(np.subtract(last["actual_position_m"], last["desired_position_m"])) < 2.0
