"""The supervisor before physics: steps must divide, and a breach ends on the brakes with palms closed, in the log."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest
from mcap.reader import make_reader

from steeplejack.errors import InputError, SteeplejackError
from steeplejack.planning import Mission
from steeplejack.robots.squad import Bay, Squad
from steeplejack.robots.squad.anchorage import exits
from steeplejack.runtime import Command, Measurement, Recorder, Supervisor, Truth
from steeplejack.runtime.recorder import Event
from steeplejack.spatial import from_quaternion
from steeplejack.worksite import Bridge


class Still:
    """A plant that stands at the first waypoint whatever it is told; after some readings one sensor lies."""

    def __init__(self, mission: Mission, bay: Bay, squad: Squad, step: float = 1e-3) -> None:
        point = mission.legs[0].waypoints[0]
        self.step, self.lie, self.readings = step, ("pull", 0, 0.0), 0
        self.lies_after = 10**9
        self.commands: list[Command] = []
        self.advanced = 0
        s, clock = np.array(point.base_s_m), np.radians(point.base_clock_deg)
        ends = np.array(point.position_m)
        ends = ends + np.array(squad.platform.attachments) @ from_quaternion(np.array(point.quaternion)).T
        lengths = np.linalg.norm(exits(bay, squad, s, clock)[0] - ends, axis=1)
        self.tension = np.array(point.tension_n)
        self.measurement = Measurement()
        self.measurement.paid[:] = lengths / (1.0 + self.tension / squad.cable.axial_stiffness)
        self.measurement.pull[:], self.measurement.s[:] = self.tension, s
        self.measurement.clock[:], self.measurement.palm[:] = clock, squad.gripper.force

    def measure(self) -> Measurement:
        """The one reading, with the lie from its time on."""
        self.readings += 1
        if self.readings > self.lies_after:
            name, index, value = self.lie
            getattr(self.measurement, name)[index] = value
        return self.measurement

    def apply(self, command: Command) -> None:
        """Keep the command."""
        fields = (command.pull, command.drive, command.turn, command.grip, command.brake, command.wheel_brake)
        self.commands.append(Command(*(field.copy() for field in fields)))

    def advance(self, steps: int) -> None:
        """Count the steps."""
        self.advanced += steps

    def extremes(self) -> tuple[np.ndarray, np.ndarray]:
        """What it stands with."""
        return self.tension, self.tension

    def truth(self) -> Truth | None:
        """Nobody knows."""
        return None


def supervisor(
    plant: Still, mission: Mission, bridge: Bridge, bay: Bay, squad: Squad, path: Path
) -> tuple[Supervisor, Recorder]:
    recorder = Recorder(path)
    return Supervisor(mission, bay, squad, plant, np.array(bridge.gravity), recorder), recorder


@pytest.mark.parametrize("step", [3e-4, 2e-3, 7e-4, 1.0000001e-3])
def test_steps_that_do_not_divide_stop_the_start(
    mission: Mission, bridge: Bridge, bay: Bay, squad: Squad, tmp_path: Path, step: float
) -> None:
    recorder = Recorder(tmp_path / "run.mcap")
    plant = Still(mission, bay, squad, step)
    with pytest.raises(SteeplejackError, match="not a multiple"):
        Supervisor(mission, bay, squad, plant, np.array(bridge.gravity), recorder)
    recorder.close()
    assert (plant.readings, plant.commands) == (0, [])


@pytest.mark.parametrize("step", [1e-3, 5e-4, 2e-4, 1e-3 / 3.0])
def test_steps_that_divide_do_not(
    mission: Mission, bridge: Bridge, bay: Bay, squad: Squad, tmp_path: Path, step: float
) -> None:
    made, recorder = supervisor(Still(mission, bay, squad, step), mission, bridge, bay, squad, tmp_path / "run.mcap")
    recorder.close()
    assert made.time == 0.0


LIES = {
    "a winch that runs away": (("pay_rate", 1, 3.0), "(2)"),
    "a base that runs away": (("s_rate", 3, -3.0), "a base that should stand moves (4)"),
    "a gripped base that creeps": (("s_rate", 0, 0.05), "grip lost: a base that should stand moves (1)"),
    "a cable far too tight": (("pull", 0, 5e3), "working window"),
    "a winch that has lost count": (("paid", 0, 1.0), "fence"),
    "palms that let go of a standing base": (
        ("palm", 2, 100.0),
        "palms of a base that should stand read below their preload (3)",
    ),
    "a standing base that turns about its stay": (("clock", 3, 9.0), "turns about its stay (4)"),
    "a current that is not a number": (("pull", 2, np.nan), "not a number"),
    "a wheel that is not a number": (("s", 1, np.nan), "not a number"),
}


@pytest.mark.parametrize("name", LIES)
def test_a_breach_ends_on_the_brakes(
    mission: Mission, bridge: Bridge, bay: Bay, squad: Squad, tmp_path: Path, name: str
) -> None:
    lie, words = LIES[name]
    path = tmp_path / "run.mcap"
    plant = Still(mission, bay, squad, 5e-4)
    plant.lie, plant.lies_after = lie, 60
    made, recorder = supervisor(plant, mission, bridge, bay, squad, path)
    result = made.run(lambda _time: None)
    recorder.close()
    assert not result.completed
    assert len(result.faults) == 1
    assert words in result.faults[0]
    last = plant.commands[-1]
    assert last.brake.all() and last.grip.all()
    for idle in (last.pull, last.drive, last.turn):
        np.testing.assert_array_equal(idle, 0.0)
    for command in plant.commands[:-1]:
        assert np.isfinite(command.pull).all()
        assert not command.brake.any()
    # On the brakes it is watched until the palms had time to close, and a second more.
    assert plant.advanced * plant.step == pytest.approx(result.duration, abs=2e-3)
    settle = squad.gripper.close_time + 1.0
    assert settle < result.duration < settle + 0.6
    with path.open("rb") as file:
        found = [msgspec.json.decode(m.data, type=Event) for _s, _c, m in make_reader(file).iter_messages(["/event"])]
    assert [event.kind for event in found] == ["phase", "breach", "stop"]
    assert found[1].text == result.faults[0]
    loose = "palms that let go" in name
    assert found[2].text == ("stopped on brakes, " + ("palms of base 3 not closed" if loose else "palms closed"))


def test_the_operator_stops_it(mission: Mission, bridge: Bridge, bay: Bay, squad: Squad, tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap")
    plant = Still(mission, bay, squad, 5e-4)
    gravity = np.array(bridge.gravity)
    made = Supervisor(
        mission, bay, squad, plant, gravity, recorder, asked_to_stop=lambda: plant.advanced * plant.step > 0.2
    )
    result = made.run(lambda _time: None)
    recorder.close()
    assert (result.completed, result.faults) == (False, ("interrupted by the operator",))
    assert plant.commands[-1].brake.all() and plant.commands[-1].wheel_brake.all()


def test_a_mission_edited_since_planning_does_not_run(
    mission: Mission, bridge: Bridge, bay: Bay, squad: Squad, tmp_path: Path
) -> None:
    edited = msgspec.structs.replace(mission, reserve=0.0)
    recorder = Recorder(tmp_path / "run.mcap")
    with pytest.raises(InputError, match="sha256"):
        Supervisor(edited, bay, squad, Still(mission, bay, squad), np.array(bridge.gravity), recorder)
    recorder.close()
