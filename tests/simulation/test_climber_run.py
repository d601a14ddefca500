"""Climbs in physics: turning, handing over, slipping once, being stopped, and the log of it all."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hung_climber import GRAVITY, LAYOUT, LOW, ROBOT, RUN, STROKE, nothing, started, strides, turns

from steeplejack.errors import SteeplejackError
from steeplejack.report.climb import is_climb, read_climb, write_climb_report
from steeplejack.robots.pipe_climber.bearing import holding_forces
from steeplejack.simulation.climber import run as runs
from steeplejack.simulation.climber.session import ClimbSession

pytestmark = pytest.mark.long


@pytest.mark.parametrize("angles", [(math.pi / 6, math.pi / 6), (-math.pi / 6, -math.pi / 6)])
def test_turning_about_the_pipe_in_steps_of_30_degrees(angles: tuple[float, float]) -> None:
    """Both directions: poses within 1 mm and 0.5 degrees where grippers close, the robot where it should be."""
    course, plant, watch = started(turns(*angles))
    end = course.run(nothing)
    assert end.completed and end.safe and end.slips == 0 and end.collisions == 0
    closed = [grip for grip in watch.grips if grip.phase > 0]
    assert [grip.gripper for grip in closed] == ["upper", "lower"] * 2
    assert max(grip.error_m for grip in closed) < 1e-3
    assert max(grip.error_rad for grip in closed) < math.radians(0.5)
    lower = plant.truth().lower
    assert math.atan2(lower[1, 0], lower[0, 0]) == pytest.approx(sum(angles), abs=math.radians(0.5))
    assert abs(lower[2, 3] - 0.05) < 1e-3


def test_the_load_is_handed_over_before_a_gripper_opens() -> None:
    """Nothing swings when one lets go: forces of the cylinders stay within what either gripper alone makes them."""
    course, plant, watch = started(strides(1))
    course.run(nothing)
    pose = np.array([0.0, LOW + STROKE, 0.0, 0.0])
    alone = np.abs(holding_forces(ROBOT, LAYOUT, pose, GRAVITY)).max()
    opening = [np.abs(sample.forces_n).max() for sample in watch.samples if sample.act in ("shift the load", "open")]
    assert len(opening) >= 4
    assert max(opening) < 1.25 * alone
    assert min(one for sample in watch.samples for one in sample.margin if one is not None) > 0.1


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


def test_the_log_alone_gives_the_report(tmp_path: Path) -> None:
    log, page = tmp_path / "climb.mcap", tmp_path / "climb.html"
    end = ClimbSession(strides(1), RUN, ROBOT, LAYOUT, (0.3, 0.3)).simulate(log, False, False, nothing)
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
