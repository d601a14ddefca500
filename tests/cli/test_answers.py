"""Answers as JSON: the keys of the contract and the values of Table III."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from command_line import Outcome

from steeplejack.cli import COMMANDS
from steeplejack.mechanics.cable import METHODS

Run = Callable[..., Outcome]

REFERENCE: dict[str, Any] = tomllib.loads(
    (Path(__file__).parents[1] / "reference" / "squad_table_iii.toml").read_text()
)
MAP_KEYS = {"nodes", "inside", "area_m2", "max", "mean_tension_factor", "seconds"}
LENGTHS = REFERENCE["lengths"]["lengths"]
WINDOW = ("--tension-n", "10", "250")


def test_check_of_a_bridge_that_fits(steeplejack: Run) -> None:
    outcome = steeplejack("check", "ecs620-like", "--json")
    answer = outcome.answer
    assert (outcome.code, outcome.err) == (0, "")
    assert set(answer) == {"stays", "fit", "unfit", "undecided"}
    assert all(set(stay) == {"id", "fits", "reasons", "unknown"} for stay in answer["stays"])
    assert answer["fit"] == len(answer["stays"]) == 168
    assert answer["unfit"] == answer["undecided"] == 0
    assert all(stay["fits"] is True and stay["reasons"] == stay["unknown"] == [] for stay in answer["stays"])


def test_check_of_a_bridge_that_does_not(steeplejack: Run) -> None:
    outcome = steeplejack("check", "sutong-like", "--json")
    assert outcome.code == 3
    assert outcome.answer["unfit"] == len(outcome.answer["stays"]) == 272
    assert all("outside 90-120 mm" in stay["reasons"][0] for stay in outcome.answer["stays"])
    assert "no stay of sutong-like fits ccrobot-s: diameter 140 mm" in outcome.err


def test_check_of_a_bridge_that_does_not_tell(steeplejack: Run) -> None:
    outcome = steeplejack("check", "russky-like", "--json")
    assert outcome.code == 0
    assert outcome.answer["undecided"] == len(outcome.answer["stays"]) == 168
    assert all(stay["fits"] is None and stay["unknown"] == ["diameter"] for stay in outcome.answer["stays"])


def test_check_for_a_person(steeplejack: Run) -> None:
    lines = steeplejack("check", "russky-like").out.splitlines()
    assert lines[0].split()[1:] == ["unknown", "diameter", "unknown"]
    assert lines[-1] == "russky-like: 0 fit, 0 do not, 168 undecided"


def test_inspect_of_a_bridge_that_does_not_fit_names_the_limit(steeplejack: Run, folder: Path) -> None:
    outcome = steeplejack("inspect", "sutong-like", "--accept-unknown", "--json")
    assert outcome.code == 3
    assert outcome.answer["feasible"] is False
    assert "outside 90-120 mm" in outcome.answer["binding"]
    assert list(folder.iterdir()) == []


def test_inspect_of_the_upper_face_names_the_limit(steeplejack: Run, folder: Path) -> None:
    stretch = ("--stays", "5:7", "--from-m", "30", "--to-m", "33", "--face", "upper")
    outcome = steeplejack("inspect", "ecs620-like", "--fan", "T1L-main", *stretch, "--json")
    assert outcome.code == 3
    assert outcome.answer["binding"]
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("case", REFERENCE["map"], ids=lambda case: f"{case['phi_deg']:g}")
def test_map_of_table_iii(steeplejack: Run, case: dict[str, Any]) -> None:
    outcome = steeplejack("map", "table-iii", "--phi-deg", f"{case['phi_deg']:g}", "--step-m", "0.01", "--json")
    answer = outcome.answer
    assert (outcome.code, outcome.err) == (0, "")
    assert set(answer) == MAP_KEYS
    assert set(answer["max"]) == {"tension_factor", "x_m", "y_m"}
    assert answer["inside"] == case["inside"]
    assert answer["max"]["tension_factor"] == pytest.approx(case["max"], abs=1e-6)
    assert answer["mean_tension_factor"] == pytest.approx(case["mean"], abs=1e-6)
    assert answer["area_m2"] == pytest.approx(1e-4 * case["inside"])
    if "at" in case:
        assert (answer["max"]["x_m"], answer["max"]["y_m"]) == pytest.approx(tuple(case["at"]), abs=1e-9)


def test_map_that_holds_a_mass(steeplejack: Run) -> None:
    load = ("--criterion", "wrench-feasible", "--mass-kg", "30", *WINDOW)
    answer = steeplejack("map", "table-iii", "--phi-deg", "50", "--step-m", "0.01", *load, "--json").answer
    assert set(answer) == MAP_KEYS | {"inside_wrench_closure"}
    assert answer["inside_wrench_closure"] == 276
    assert answer["inside"] >= 276


def test_map_over_a_range_pools_its_means(steeplejack: Run) -> None:
    step = ("--step-m", "0.01", "--json")
    single = [steeplejack("map", "table-iii", "--phi-deg", phi, *step).answer for phi in ("44", "50", "56")]
    pooled = steeplejack("map", "table-iii", "--phi-deg", "44:56:6", *step).answer
    inside = [answer["inside"] for answer in single]
    mean = sum(n * answer["mean_tension_factor"] for n, answer in zip(inside, single, strict=True)) / sum(inside)
    assert pooled["mean_tension_factor"] == pytest.approx(mean, rel=1e-9)
    assert pooled["max"]["phi_deg"] == pytest.approx(50.0)


def test_map_of_other_anchors(steeplejack: Run, folder: Path) -> None:
    anchors = REFERENCE["table_iii"]["anchors"]
    (folder / "anchors.csv").write_text("".join(f"{x}, {y}\n" for x, y in anchors))
    same = steeplejack("map", "table-iii", "--phi-deg", "50", "--step-m", "0.01", "--anchors", "anchors.csv", "--json")
    assert same.answer["inside"] == 1610


def test_map_writes_where_it_is_told(steeplejack: Run, folder: Path) -> None:
    answer = steeplejack("map", "table-iii", "--phi-deg", "50", "--step-m", "0.05", "--out", "a/b", "--json").answer
    assert {path.name for path in (folder / "a" / "b").iterdir()} == {"map.nc", "map.svg"}
    assert Path(answer["map"]).is_file() and Path(answer["figure"]).is_file()


def test_pose_of_table_iii(steeplejack: Run) -> None:
    answer = steeplejack("pose", "table-iii", "--lengths-m", *LENGTHS, "--json").answer
    assert set(answer) == {"x_m", "y_m", "phi_deg", "residual_m", "iterations", "unique"}
    assert (answer["x_m"], answer["y_m"]) == pytest.approx((-0.10, 0.45), abs=1e-7)
    assert answer["phi_deg"] == pytest.approx(50.0, rel=1e-6)
    assert answer["unique"] is True
    assert answer["residual_m"] < 1e-7
    assert answer["iterations"] <= 9


@pytest.mark.parametrize("method", METHODS)
def test_tensions_hold_the_weight(steeplejack: Run, method: str) -> None:
    answer = steeplejack(
        *("tensions", "table-iii", "--pose", "-0.1", "0.45", "50", "--mass-kg", "8", *WINDOW),
        *("--method", method, "--json"),
    ).answer
    assert set(answer) == {"tensions_n", "feasible", "margin", "certificate"}
    assert answer["feasible"] is True
    assert all(10.0 - 1e-9 <= tension <= 250.0 for tension in answer["tensions_n"])
    assert answer["certificate"] is None


def test_tensions_that_do_not_exist_come_with_their_proof(steeplejack: Run) -> None:
    """30 kg at the best pose needs 409 N."""
    best = ("--pose", "-0.23074604", "0.55283179", "50")
    outcome = steeplejack("tensions", "table-iii", *best, "--mass-kg", "30", *WINDOW, "--json")
    assert outcome.code == 3
    assert outcome.answer["feasible"] is False
    assert outcome.answer["tensions_n"] is None
    assert len(outcome.answer["certificate"]) == 3
    enough = steeplejack("tensions", "table-iii", *best, "--mass-kg", "30", "--tension-n", "10", "410", "--json")
    assert enough.answer["feasible"] is True
    assert max(enough.answer["tensions_n"]) == pytest.approx(REFERENCE["workspace"]["needs"], abs=0.5)


def test_grip_of_the_paper(steeplejack: Run) -> None:
    reference = REFERENCE["grip"]
    shape = ("--radius-m", "0.05", "--inclination-deg", "45", "--palm-m", "0.09")
    answer = steeplejack("grip", *shape, "--sign", "+", "--json").answer
    assert set(answer) == {"min_force_n", "gamma_deg"}
    assert answer["min_force_n"] == pytest.approx(reference["min_force"], rel=1e-6)
    assert steeplejack("grip", *shape, "--sign", "-", "--json").answer["min_force_n"] < answer["min_force_n"]


def test_lists_name_their_sources(steeplejack: Run) -> None:
    robots = steeplejack("robots", "--json").answer["robots"]
    assert [robot["name"] for robot in robots] == ["ccrobot-s", "pipe-climber", "pipe-climber-cross"]
    sites = steeplejack("worksites", "--json").answer["worksites"]
    names = ["table-iii", "ecs620-like", "russky-like", "sutong-like", "stonecutters-like", "emerson-like"]
    pipes = ["straight-vertical", "around", "bend-300", "flange", "clock-obstacle", "reducer", "planar-cross"]
    assert [site["name"] for site in sites] == names + pipes
    for entry in (*robots, *sites):
        assert entry["source"]
    for name in names:
        assert name in steeplejack("worksites").out
    assert "ccrobot-s" in steeplejack("robots").out


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_an_example(steeplejack: Run, command: str) -> None:
    outcome = steeplejack(command, "--help")
    assert (outcome.code, outcome.err) == (0, "")
    assert "Example:" in outcome.out
    assert f"steeplejack {command}" in outcome.out
    assert "--json" in outcome.out


def test_commands_are_those_of_the_contract() -> None:
    built = {
        "check",
        "inspect",
        "map",
        "pose",
        "tensions",
        "lost-cable",
        "anchors",
        "grasp",
        "mobility",
        "legs",
        "platform",
        "motion",
        "singularity",
        "reach",
        "transmission",
        "dimensions",
        "climb",
        "grip",
        "report",
        "robots",
        "worksites",
        "warmup",
    }
    assert built == set(COMMANDS)


def test_a_person_gets_a_table(steeplejack: Run) -> None:
    out = steeplejack("grip", "--radius-m", "0.05", "--inclination-deg", "45", "--palm-m", "0.09", "--sign", "+").out
    assert [line.split()[0] for line in out.splitlines()] == ["min_force_n", "gamma_deg"]


def test_a_lost_cable_by_the_page_of_definitions(steeplejack: Run) -> None:
    """Cable 2 lost at the best-TF pose with 30 kg: squad.md, in cm, deg and N."""
    answer = steeplejack(
        *("lost-cable", "table-iii", "--pose", "-0.23074604", "0.55283179", "50"),
        *("--cable", "2", "--mass-kg", "30", "--json"),
    ).answer
    assert set(answer) == {"x_m", "y_m", "phi_deg", "tensions_n", "taut", "drop_m"}
    assert answer["x_m"] == pytest.approx(-0.2814942, abs=1e-6)
    assert answer["y_m"] == pytest.approx(0.5325171, abs=1e-6)
    assert answer["phi_deg"] == pytest.approx(59.2922, abs=1e-4)
    assert answer["tensions_n"] == pytest.approx([121.53, 0.0, 402.81, 0.0], abs=5e-3)
    assert answer["taut"] == [1, 3]
    assert answer["drop_m"] == pytest.approx(0.55283179 - answer["y_m"], abs=1e-9)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--cable", "5", "--mass-kg", "30"], "--cable: 5"),
        (["--cable", "2", "--mass-kg", "-1"], "--mass-kg"),
        (["--cable", "2", "--mass-kg", "nan"], "--mass-kg"),
    ],
)
def test_a_lost_cable_that_makes_no_sense(steeplejack: Run, options: list[str], words: str) -> None:
    ended = steeplejack("lost-cable", "table-iii", "--pose", "-0.2", "0.5", "50", *options)
    assert ended.code == 2
    assert words in ended.err
