"""A whole small mission in physics under closed-loop control, and a stop on the brakes."""

import json
from dataclasses import replace
from typing import Any, NamedTuple

import msgspec
import numpy as np
import pytest
from mcap.reader import make_reader

from steeplejack.report import Log, analyse, read_log
from steeplejack.report.limits import limits
from steeplejack.robots.squad import Squad
from steeplejack.runtime import Result


class Run(NamedTuple):
    """A run, its log as the report reads it, and its samples as any MCAP reader does."""

    result: Result
    log: Log
    states: list[dict[str, Any]]


@pytest.fixture(scope="module")
def run(case, tmp_path_factory) -> Run:
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    result = case.session.run(path, False, lambda _time: None)
    with path.open("rb") as file:
        states = [json.loads(m.data) for _s, _c, m in make_reader(file).iter_messages(topics=["/state"])]
    return Run(result, read_log(path), states)


def test_mission_completes_with_a_squad_move(case, run) -> None:
    assert run.result.completed, run.result.faults
    assert case.mission.moves >= 1
    assert {"fly", "open palms", "drive", "close palms", "verify grip"} <= {state["phase"] for state in run.states}


def test_limits_hold_at_every_step(run) -> None:
    assert max(state["max_tension_n"] for state in run.states) <= 250.0
    assert min(state["min_tension_n"] for state in run.states) > 5.0
    assert min(state["min_slip_margin"] for state in run.states) > 0.0


def test_every_limit_of_the_report_holds_as_flown(run) -> None:
    assert [limit for limit in limits(run.log, analyse(run.log)) if not limit.held] == []


def test_platform_follows_the_plan(run) -> None:
    """Relative to the true anchors; stand-off is not controlled, and the absolute error includes odometry drift."""
    summary = analyse(run.log).summary
    for spread in (summary.error_along_mm, summary.error_across_mm):
        assert abs(spread.mean) < 2.0
        assert spread.std < 2.0
    assert abs(summary.error_stand_off_mm.mean) < 5.0
    assert summary.error_stand_off_mm.std < 12.0
    assert summary.absolute_error_mm.mean < 12.0
    assert summary.absolute_error_mm.max < 40.0


def test_a_log_of_the_machine_in_the_file_names_no_other(run) -> None:
    assert run.log.actual == run.log.squad
    assert not any("other than the file" in event.text for event in run.log.events)


def test_the_controller_never_sees_the_truth(case, run) -> None:
    """Estimates differ from the truth by sensor errors: millimetres in the plane of the cables, decimetres out of it.

    Out of the plane only the balance of measured tensions says where the platform hangs, and it swings there.
    """
    bay = case.bay
    gap = np.array([np.subtract(s["estimated_position_m"], s["actual_position_m"]) for s in run.states])
    normal = bay.normal(2.0, 30.0)
    off = gap @ normal
    plane = np.linalg.norm(gap - off[:, None] * normal, axis=1)
    assert 1e-4 < plane.max() < 0.03
    assert np.abs(off).max() < 0.2


@pytest.fixture(scope="module")
def lost(case, tmp_path_factory) -> tuple[Squad, Log]:
    """The bases hold half of what the file says, less than base 2 is asked for: it slips at once."""
    base = msgspec.structs.replace(case.squad.base, hold_force=0.5 * case.squad.base.hold_force)
    weak = msgspec.structs.replace(case.squad, base=base)
    path = tmp_path_factory.mktemp("lost") / "run.mcap"
    assert not replace(case.session, actual=weak).run(path, False, lambda _time: None).completed
    return weak, read_log(path)


def test_a_lost_grip_stops_the_squad_on_its_brakes(lost) -> None:
    """The monitor sees it within a tenth of a second; wheel brakes hold the base, and nothing falls."""
    _weak, log = lost
    told = [event for event in log.events if event.kind in ("breach", "stop")]
    assert [event.kind for event in told] == ["breach", "stop"]
    assert told[0].text == "grip lost: a base that should stand moves (2)"
    assert told[0].time_s < 0.1
    assert told[1].text == "stopped on brakes, palms closed"
    states = log.states
    slid = np.ptp(states.actual_s, axis=0)
    assert 1e-3 < slid[1] < 0.05
    assert slid[[0, 2, 3]].max() < 1e-4
    away = np.linalg.norm(states.actual_position - states.desired_position, axis=1)
    assert away.max() < 0.4
    assert away[-1] < 0.2
    assert states.min_tension.min() > 5.0


def test_the_log_says_what_machine_physics_ran(case, lost) -> None:
    weak, log = lost
    assert (log.squad, log.actual) == (case.squad, weak)
    notes = [event.text for event in log.events if event.kind == "note"]
    assert notes == ["physics ran a machine other than the file: base.hold_force"]


def test_the_same_machine_is_no_other(case, tmp_path) -> None:
    """An ``actual`` equal to the file's machine leaves no trace."""
    session = replace(case.session, actual=msgspec.structs.replace(case.squad))
    session.run(tmp_path / "run.mcap", False, lambda _time: None, lambda: True)
    log = read_log(tmp_path / "run.mcap")
    assert log.actual == log.squad == case.squad
    assert not any(event.kind == "note" for event in log.events)
