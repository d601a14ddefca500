"""Climbs in physics: straight up at the declared speed, on grips that hold, that slip once, and that cannot hold."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hung_climber import LAYOUT, ROBOT, RUN, started, strides

from steeplejack.control.climber import TRANSITIONS, Act, ClimberController, Measurement, Outcome, Reference, closed_in
from steeplejack.errors import SteeplejackError
from steeplejack.report.climb import is_climb, read_climb, write_climb_report
from steeplejack.simulation.climber import run as runs
from steeplejack.simulation.climber.session import ClimbSession

pytestmark = pytest.mark.long


def nothing(_time: float) -> None:
    """No progress to show."""


def test_straight_up_at_the_declared_speed_without_slip() -> None:
    """50 mm steps at 17 mm/s: at least 8.07 mm/s, poses within 1 mm and 0.5 degrees where grippers close."""
    course, plant, watch = started(strides(1))
    before = plant.truth()
    end = course.run(nothing)
    assert end.completed and end.safe and end.slips == 0 and end.collisions == 0
    rise = plant.truth().lower[2, 3] - before.lower[2, 3]
    assert rise == pytest.approx(0.050, abs=5e-4)
    assert 1e3 * rise / end.duration_s >= 8.07
    assert end.travelled_m == pytest.approx(rise, abs=1e-4)
    closed = [grip for grip in watch.grips if grip.phase > 0]
    assert [grip.gripper for grip in closed] == ["upper", "lower"]
    assert max(grip.error_m for grip in closed) < 1e-3
    assert max(grip.error_rad for grip in closed) < math.radians(0.5)
    assert min(grip.force_n for grip in closed) >= 0.95 * ROBOT.gripper.force
    assert max(max(sample.slip_m) for sample in watch.samples) < 2e-4
    assert max(max(map(abs, sample.speeds_m_s)) for sample in watch.samples) < 1.05 * ROBOT.cylinders.speed
    assert min(one for sample in watch.samples for one in sample.margin if one is not None) > 0.0


def test_grippers_that_cannot_hold_end_the_climb_safely() -> None:
    """At mu = 0.2 one gripper cannot bear 2 kg and two can: the slip is seen, met, and nothing falls."""
    course, plant, _watch = started(strides(1), mu=0.2)
    before = plant.truth()
    end = course.run(nothing)
    assert not end.completed and end.safe
    assert "slip" in end.why and end.slips >= 2
    assert np.linalg.norm(plant.truth().lower[:3, 3] - before.lower[:3, 3]) < 0.03
    still = plant.truth().lower[2, 3]
    plant.advance(1000)
    assert abs(plant.truth().lower[2, 3] - still) < 1e-4


def test_a_slip_that_passes_is_recovered() -> None:
    """A greasy moment while the robot moves: both close, the one that slipped grips again, the climb goes on."""
    course, plant, _watch = started(strides(1))

    def grease(time: float) -> None:
        plant.set_friction(*((0.2, 0.2) if 1.0 < time < 1.2 else (0.3, 0.3)))

    end = course.run(grease)
    assert end.completed and end.slips >= 1 and end.regrips >= 1
    assert plant.truth().normal.min() > 70.0


def test_the_operator_stops_it_with_both_grippers_closed() -> None:
    plan = strides(1)
    _, plant, watch = started(plan)
    course = runs.ClimbRun(plan, RUN, ROBOT, LAYOUT, plant, watch, lambda: plant.time > 0.5)
    end = course.run(nothing)
    assert not end.completed and end.safe and end.why == runs.BY_OPERATOR
    assert plant.truth().normal.min() > 70.0


def test_control_and_physics_steps_must_divide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs, "CONTROL_STEP", 0.7e-3)
    with pytest.raises(SteeplejackError, match="multiple"):
        started(strides(1))


def test_no_act_opens_both_grippers_and_every_act_ends() -> None:
    """Every act with everything a phase can want, and every way through the table."""
    wanted = {Act.MOVE: [(True, False), (False, True)], Act.CLOSE: [(True, True)]}
    for act in Act:
        for phase in wanted.get(act, [(True, False), (False, True), (True, True)]):
            for slipped in (0, 1):
                assert any(closed_in(act, phase, slipped))
    running = [act for act in Act if act not in (Act.DONE, Act.STOPPED)]
    for act in running:
        assert TRANSITIONS[act, Outcome.FAILED] is Act.STOPPED
        assert (act, Outcome.REACHED) in TRANSITIONS
    assert {act for act, _ in TRANSITIONS} == set(running)


def _measured(**changes: object) -> Measurement:
    values = {
        "lengths": np.full(3, 0.18), "forces": np.zeros(3), "beta": 0.0, "jaws": np.full(2, 0.0316),
        "grip": np.full(2, 40.0), "passed": np.zeros((2, 2)),
    }  # fmt: skip
    return Measurement(**{**values, **changes})  # pyright: ignore[reportArgumentType]


def test_the_controller_counts_a_grip_by_its_force_and_sees_it_slip() -> None:
    controller = ClimberController(ROBOT)
    hold = Reference(np.full(3, 0.18), np.zeros(3), 0.0, 0.0, np.array([True, False]), np.full(2, 0.03))
    weak = _measured(grip=np.array([30.0, 0.0]))
    state, _, status = controller.step(controller.begin(weak), hold, weak, 4e-3)
    assert not status.held.any()
    firm = _measured()
    state, command, status = controller.step(state, hold, firm, 4e-3)
    assert status.held.tolist() == [True, False] and not status.slipping.any()
    passed = _measured(passed=np.array([[-6e-4, 0.0], [0.0, 0.0]]))
    _, _, status = controller.step(state, hold, passed, 4e-3)
    assert status.slipping.tolist() == [True, False]
    assert np.abs(command.speeds).max() < 1e-12


def test_the_controller_keeps_the_cylinders_speed_and_stops_on_nonsense() -> None:
    controller = ClimberController(ROBOT)
    far = Reference(np.full(3, 0.20), np.full(3, 0.017), 0.0, 0.0, np.array([True, False]), np.full(2, 0.03))
    measured = _measured()
    _, command, status = controller.step(controller.begin(measured), far, measured, 4e-3)
    assert np.abs(command.speeds).max() == pytest.approx(ROBOT.cylinders.speed)
    assert status.lost
    broken = _measured(lengths=np.array([np.nan, 0.18, 0.18]))
    _, command, status = controller.step(controller.begin(measured), far, broken, 4e-3)
    assert not status.readable and command.closed.all() and not command.speeds.any()


def test_the_log_alone_gives_the_report(tmp_path: Path) -> None:
    log, page = tmp_path / "climb.mcap", tmp_path / "climb.html"
    end = ClimbSession(strides(1), RUN, ROBOT, LAYOUT, (0.3, 0.3)).simulate(log, False, nothing)
    assert is_climb(log)
    summary = write_climb_report(log, page)
    assert summary.steps == 1 and summary.collisions == 0
    assert summary.distance_m == pytest.approx(end.travelled_m)
    assert summary.min_transmission == pytest.approx(0.437, abs=0.01)
    text = page.read_text()
    assert "Climbed to the goal" in text and "http" not in text.replace("http-equiv", "").replace(
        "http://www.w3.org", ""
    )
    whole = log.read_bytes()
    log.write_bytes(whole[: len(whole) // 2])
    assert read_climb(log).end is None
    assert write_climb_report(log, page).duration_s < end.duration_s
