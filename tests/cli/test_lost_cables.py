"""The lost-cable command over a grid and along a mission: the worst of each cable, its files, and what it refuses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from command_line import Outcome

from steeplejack.planning import Leg, Mission, Request, Waypoint, write

pytestmark = pytest.mark.long

Run = Callable[..., Outcome]

GRID = ("lost-cable", "table-iii", "--phi-deg", "50", "--step-m", "0.1", "--mass-kg", "30")
EXTREMES = {"max_drop_m", "at", "max_tension_n", "max_tension_at", "lowest_m", "lowest_at"}
WORST = EXTREMES | {"cable", "settles", "stays_above", "unsettled", "unsettled_tension_n"}


def waypoint(travel: float, x: float, y: float, z: float, tension: tuple[float, float, float, float]) -> Waypoint:
    """One of the first waypoints of a mission planned on ecs620-like, to the digits of its file."""
    quaternion = (-0.047204226, 0.035525559, 0.636001542, 0.769422988)
    clock = (175.912835, -12.25507, -12.099571, 175.924412)
    bases = (24.0, 24.0, 71.111111, 51.111111)
    return Waypoint(travel, (1.0, 20.0 + travel, 0.91), (x, y, z), quaternion, tension, bases, clock)


@pytest.fixture
def mission(folder: Path) -> Path:
    """A mission of two waypoints."""
    points = (
        waypoint(0.0, -235.324638, 11.439102, 63.210102, (146.9181, 186.3298, 65.928, 122.2219)),
        waypoint(0.246918, -235.507444, 11.418656, 63.374821, (144.9821, 182.4873, 70.4062, 123.7866)),
    )
    request = Request("ecs620-like", "ccrobot-s", "T1L-main", (5, 9), 20.0, 53.0, "under", 0.0, (20.0, 250.0))
    stays = ("T1L-M09", "T1L-M05", "T1L-M05", "T1L-M09")
    leg = Leg("inspect", 0, "T1L-M06", None, 0.25, 0.1, points)
    plan = Mission(
        "steeplejack-mission-1",
        request,
        ("T1L-M05", "T1L-M09"),
        ("T1L-M06", "T1L-M07", "T1L-M08"),
        stays,
        0.1,
        (),
        (leg,),
        (),
    )
    path = folder / "some.mission.json"
    write(plan.sealed(), path)
    return path


def test_a_grid_answers_for_every_cable_as_single_poses_do(steeplejack: Run) -> None:
    outcome = steeplejack(*GRID, "--floor-m", "0", "--json")
    answer = outcome.answer
    assert outcome.code == 0
    assert set(answer) == {"poses", "cables", "seconds"}
    assert answer["poses"] == 16
    assert [one["cable"] for one in answer["cables"]] == [1, 2, 3, 4]
    for one in answer["cables"]:
        assert set(one) == WORST and set(one["at"]) == {"x_m", "y_m", "phi_deg"}
        assert one["stays_above"] is (one["lowest_m"] >= 0.0)
        assert one["unsettled"] == 0 and one["unsettled_tension_n"] is None
    for worst, cable in ((worst, str(worst["cable"])) for worst in answer["cables"]):
        deepest, tautest = (
            steeplejack(
                *("lost-cable", "table-iii", "--cable", cable, "--mass-kg", "30", "--json", "--pose"),
                *(f"{worst[at][name]:.17g}" for name in ("x_m", "y_m", "phi_deg")),
            ).answer
            for at in ("at", "max_tension_at")
        )
        assert deepest["drop_m"] == pytest.approx(worst["max_drop_m"], abs=1e-9)
        assert max(tautest["tensions_n"]) == pytest.approx(worst["max_tension_n"], rel=1e-9)


def test_a_grid_leaves_a_labelled_dataset_and_a_figure(steeplejack: Run, folder: Path) -> None:
    answer = steeplejack(*GRID, "--cable", "2", "--floor-m", "0.2", "--out", "maps", "--json").answer
    assert (folder / answer["figure"]).read_text().startswith("<?xml")
    with xr.open_dataset(folder / answer["dataset"]) as data:
        assert dict(data.sizes) == {"pose": 16, "cable": 1, "survivor": 4, "bound": 2, "axis": 2}
        assert data["cable"].to_numpy().tolist() == [2]
        assert {str(data[name].attrs["units"]) for name in ("drop", "lowest", "sweep", "x")} == {"m"}
        worst, phi = answer["cables"][0], np.rad2deg(data["phi"].to_numpy())
        places = list(zip(data["x"].to_numpy(), data["y"].to_numpy(), phi, strict=True))
        for at, extreme, name in (("at", "max_drop_m", "drop"), ("lowest_at", "lowest_m", "lowest")):
            row = next(k for k, place in enumerate(places) if place == pytest.approx(tuple(worst[at].values())))
            assert float(data[name][row, 0]) == pytest.approx(worst[extreme])
        assert float(data["drop"].max()) == pytest.approx(worst["max_drop_m"])
        assert np.all(data["tension"].to_numpy()[:, 0, 1] == 0.0)
        sweep, y = data["sweep"].to_numpy()[:, 0], data["y"].to_numpy()
        assert np.all(sweep[:, 0] <= sweep[:, 1]) and np.all((sweep[:, 0, 1] < y) & (y < sweep[:, 1, 1]))
        np.testing.assert_array_equal(data["lowest"].to_numpy()[:, 0], sweep[:, 0, 1])
        above = data["stays_above"].to_numpy()[:, 0].astype(bool)
        np.testing.assert_array_equal(above, sweep[:, 0, 1] >= 0.2)
        assert data.attrs["Conventions"] == "CF-1.11" and data.attrs["floor"] == 0.2


def test_a_mission_answers_in_space(steeplejack: Run, mission: Path, folder: Path) -> None:
    """Drops of the first waypoint, 3.8 cm of the 1311-waypoint plan it comes from; the weight alone pulls 174 N."""
    options = ("lost-cable", "ecs620-like", "--mission", mission, "--floor-m", "60", "--out", "maps", "--json")
    answer = steeplejack(*options).answer
    assert answer["poses"] == 2 and [one["settles"] for one in answer["cables"]] == [2, 2, 2, 2]
    assert set(answer["cables"][0]["at"]) == {"x_m", "y_m", "z_m", "leg", "kind", "travel"}
    assert all(-0.05 < one["max_drop_m"] < 0.5 and 60.0 < one["lowest_m"] < 63.4 for one in answer["cables"])
    assert all(one["stays_above"] is True and one["max_tension_n"] > 100.0 for one in answer["cables"])
    with xr.open_dataset(folder / answer["dataset"]) as data:
        assert dict(data.sizes) == {"pose": 2, "cable": 4, "survivor": 4, "bound": 2, "axis": 3}
        assert data["kind"].to_numpy().tolist() == ["inspect", "inspect"]


def test_a_person_gets_the_worst_of_each_cable(steeplejack: Run, mission: Path) -> None:
    lines = steeplejack("lost-cable", "ecs620-like", "--mission", mission).out.splitlines()
    assert lines[0].split()[:2] == ["cable", "lost"]
    assert [line.split()[0] for line in lines[1:13:3]] == ["1", "2", "3", "4"]
    assert all("z_m" in line and "kind inspect" in line for line in lines[1:13])
    assert lines[13].startswith("2 poses")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((), "one of --pose, --phi-deg and --mission"),
        (("--pose", "0", "0.5", "50", "--phi-deg", "50"), "one of --pose, --phi-deg and --mission"),
        (("--pose", "0", "0.5", "50", "--cable", "2"), "--mass-kg"),
        (("--pose", "0", "0.5", "50", "--mass-kg", "30"), "--cable"),
        (("--pose", "0", "0.5", "50", "--mass-kg", "30", "--cable", "1", "--out", "x"), "--out"),
        (("--phi-deg", "50", "--mass-kg", "30"), "--step-m"),
        (("--phi-deg", "50", "--step-m", "0.1"), "--mass-kg"),
        (("--phi-deg", "fifty", "--step-m", "0.1", "--mass-kg", "30"), "--phi-deg"),
        (("--phi-deg", "50", "--step-m", "-1", "--mass-kg", "30"), "step"),
        (("--phi-deg", "50", "--step-m", "1e-7", "--mass-kg", "30"), "step"),
        (("--phi-deg", "50", "--step-m", "0.1", "--mass-kg", "30", "--floor-m", "nan"), "--floor-m"),
        (("--mission", "none.json"), "No such file"),
        (("--mission", "none.json", "--mass-kg", "3"), "neither"),
    ],
)
def test_what_makes_no_sense_is_refused(steeplejack: Run, folder: Path, options: tuple[str, ...], words: str) -> None:
    ended = steeplejack("lost-cable", "table-iii", *options)
    assert ended.code == 2 and words in ended.err and ended.err.count("\n") == 1
    assert list(folder.iterdir()) == []


def test_a_grid_outside_wrench_closure_has_no_answer(steeplejack: Run) -> None:
    ended = steeplejack("lost-cable", "table-iii", "--phi-deg", "120", "--step-m", "0.1", "--mass-kg", "30")
    assert ended.code == 3 and "wrench closure" in ended.err
