"""Loads and gaps as flown, by second routes: moments about the axis, and points strewn along every cable."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from small_run import SQUAD, TENSION, Run, write_run

from steeplejack.report import Log, analyse, read_log
from steeplejack.report.flown import Flown
from steeplejack.report.limits import Limit, limits
from steeplejack.spatial import from_vector

Array = NDArray[np.float64]
SAMPLES = (0, 57, 200, 359)  # up the first stay, over, while base 3 drives
TURN = from_vector(np.array([0.3, -0.2, 0.5]))


def wander(sample: int, axes: Array) -> Array:
    """Up to a few decimetres off in every direction."""
    return axes @ np.array([0.2 * np.sin(0.1 * sample), 0.1, 0.15 * np.cos(0.07 * sample)])


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Log:
    """A platform that is askew and off its path, on bases that are not where they believe to be."""
    drift = np.array([[0.05, 0.02, -0.03], [0.0, -0.06, 0.0], [0.02, 0.0, 0.08], [-0.04, 0.04, 0.0]])
    run = Run(offset=wander, drift=drift, turn=TURN)
    return read_log(write_run(tmp_path_factory.mktemp("flown") / "run.mcap", run))


def ends(log: Log, sample: int) -> Array:
    states = log.states
    return states.actual_position[sample] + np.array(SQUAD.platform.attachments) @ states.actual_rotation[sample].T


def test_twist_is_the_moment_of_the_cable_about_the_axis(log: Log):
    flown = Flown.of(log)
    for sample in SAMPLES:
        for i, k in enumerate(log.bay.carriers):
            exit_, stay = log.states.exits_actual[sample, i], log.bay.stays[k]
            pull = ends(log, sample)[i] - exit_
            pull *= TENSION[i] / np.linalg.norm(pull)
            s, _distance = stay.nearest(exit_)
            moment = np.cross(exit_ - stay.position(s), pull) @ stay.tangent(s)
            assert flown.twist[sample, i] == pytest.approx(abs(moment), abs=1e-6)
    assert flown.twist.min() >= 0.0
    assert np.ptp(flown.twist[:, 2]) > 0.1


def test_gaps_are_those_of_points_strewn_along_the_cables(log: Log):
    flown, bay = Flown.of(log), log.bay
    share = np.linspace(0.0, 1.0, 4001)[:, None]
    for sample in SAMPLES:
        cables = []
        for i, end in enumerate(ends(log, sample)):
            points = end + share * (log.states.exits_actual[sample, i] - end)
            others = [k for k in range(len(bay.stays)) if k != bay.carriers[i]]
            cables += [bay.stays[k].nearest(points)[1].min() - bay.radius(k) for k in others]
        assert flown.cable_gap[sample] == pytest.approx(min(cables), abs=1e-4)
        centre = log.states.actual_position[sample]
        body = min(float(stay.nearest(centre)[1]) - bay.radius(k) for k, stay in enumerate(bay.stays))
        assert flown.body_gap[sample] == pytest.approx(body, abs=1e-9)


def rows(path: Path, run: Run) -> dict[str, Limit]:
    log = read_log(write_run(path / "run.mcap", run))
    return {row.name: row for row in limits(log, analyse(log))}


def test_a_clean_run_holds_every_limit_and_says_when_it_came_closest(tmp_path: Path):
    found = rows(tmp_path, Run())
    assert all(row.held for row in found.values())
    assert list(found) == [
        "largest cable tension",
        "no slack cable",
        "pull along the stays",
        "twist about the stays",
        "driving cables clear of the stays",
        "platform's centre clear of the stays",
        "stand-off while inspecting",
    ]
    assert all(" at 0 min " in row.worst for row in found.values())
    assert found["stand-off while inspecting"].worst.startswith("0.60 m, nearest a limit at ")


def from_sample(number: int, distance: float) -> Callable[[int, Array], Array]:
    """Towards the stays, from one sample of a leg on."""
    return lambda sample, axes: (distance if sample >= number else 0.0) * axes[:, 2]


def test_a_base_turned_under_its_cable_does_not_hold(tmp_path: Path):
    """Its exit stands out to the side, half a metre from the axis: only the true exits show it."""
    drift = np.zeros((4, 3))
    drift[1] = [0.0, 0.0, -0.5]
    row = rows(tmp_path, Run(drift=drift))["twist about the stays"]
    assert not row.held
    assert row.limit == "at most 17 N m"
    assert ", base 2 gripped, at " in row.worst


def test_a_platform_against_a_stay_does_not_hold(tmp_path: Path):
    """From 3 s into every leg it is within 20 cm of the stay: the first time is while it inspects."""
    found = rows(tmp_path, Run(offset=from_sample(60, 0.4)))
    body = found["platform's centre clear of the stays"]
    assert not body.held
    assert body.limit == "at least 0.30 m from their surface"
    assert body.worst.startswith("0.20 m at 0 min ")
    assert not found["stand-off while inspecting"].held
    assert found["stand-off while inspecting"].worst.startswith("0.20–0.60 m, nearest a limit at ")


def test_a_cable_against_a_stay_does_not_hold(tmp_path: Path):
    """The platform is behind the stays, and its cables pass between them."""
    found = rows(tmp_path, Run(offset=from_sample(0, 0.65)))
    cables = found["driving cables clear of the stays"]
    assert not cables.held
    assert cables.limit == "at least 0.02 m from their surface"


def test_a_run_that_inspected_nothing_has_no_stand_off_to_judge(tmp_path: Path):
    row = rows(tmp_path, Run(legs=(1, 2)))["stand-off while inspecting"]
    assert (row.worst, row.held) == ("nothing was inspected", True)
