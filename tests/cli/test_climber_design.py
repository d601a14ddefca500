"""The commands reach, transmission and dimensions: their contract, the reference, what they write and refuse."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from command_line import Outcome

from steeplejack.design import climber as design

pytestmark = pytest.mark.long

Run = Callable[..., Outcome]

REFERENCE: dict[str, Any] = tomllib.loads(
    (Path(__file__).parents[1] / "reference" / "pipe_climber_design.toml").read_text()
)
RECTANGLE = ("--rectangle", *map(str, REFERENCE["dimensions"]["rectangle"]))
PAPER = ("--dims", 0.1, 0.1, 0.075, 0.065)


@pytest.mark.parametrize(("convention", "neutral"), [("text", "none"), ("equations", "home")])
def test_reach(steeplejack: Run, convention: str, neutral: str) -> None:
    options = ("--convention", convention, "--joint-neutral", neutral)
    outcome = steeplejack("reach", "--alpha-deg", 0, "--step-m", 0.0005, *options, "--json")
    assert (outcome.code, outcome.err) == (0, "")
    answer = outcome.answer
    assert answer["area_m2"] == pytest.approx(REFERENCE["area"][f"{convention}_{neutral}"], abs=0.6e-6)
    assert answer["exact_area_m2"] == pytest.approx(REFERENCE["area"]["exact"][f"{convention}_{neutral}"], abs=2e-9)
    assert answer["volume_m2_rad"] > 0.3 * answer["area_m2"]
    assert answer["reachable_area_m2"] > answer["area_m2"]


def test_transmission(steeplejack: Run) -> None:
    answer = steeplejack("transmission", "--alpha-deg", 0, "--step-m", 0.0005, "--json").answer
    one = REFERENCE["workspace"]
    assert (answer["gti"], answer["mean"]) == pytest.approx((one["gti"], one["mean"]), abs=5e-4)
    assert answer["max"] == pytest.approx(
        {"lti": one["max"], "x_m": one["max_at"][0], "w_m": one["max_at"][1]}, abs=5e-4
    )
    assert set(answer["min"]) == {"lti", "x_m", "w_m"}
    other = steeplejack(
        "transmission", "--alpha-deg", 0, "--step-m", 0.001, *RECTANGLE, *PAPER, "--moving", "base", "--json"
    )
    assert other.answer["gti"] != pytest.approx(REFERENCE["dimensions"]["paper"], abs=0.01)


def test_dimensions(steeplejack: Run) -> None:
    one = REFERENCE["dimensions"]
    answer = steeplejack("dimensions", *RECTANGLE, "--dims", 0.1, 0.1, 0.1, 0.049, "--json").answer
    assert set(answer) == {"best", "paper", "original", "given", "designs", "seconds"}
    assert answer["best"]["gti"] == pytest.approx(one["best"], abs=5e-5)
    assert answer["best"]["ratio"] == pytest.approx([1.0, 1.0, one["best_third"], one["best_fourth"]], abs=0.005)
    assert answer["paper"]["gti"] == pytest.approx(one["paper"], abs=5e-5)
    assert answer["original"] == {"ratio": [1.0, 1.0, 0.75, 0.75], "gti": pytest.approx(one["original"], abs=5e-5)}
    assert answer["given"]["gti"] == pytest.approx(answer["best"]["gti"])
    assert answer["designs"] == 96 * 96


def test_a_study_searches_the_whole_space_and_resumes(steeplejack: Run, folder: Path) -> None:
    options = ("--step", 0.19, "--step-m", 0.005, "--study", "study", "--json")
    first = steeplejack("dimensions", *RECTANGLE, *options)
    assert first.code == 0
    assert first.answer["designs"] == 6 * 6 * 7 // 2
    written = {path: path.stat().st_mtime_ns for path in (folder / "study").glob("chunk-*.npy")}
    again = steeplejack("dimensions", *RECTANGLE, *options)
    assert again.answer["best"] == first.answer["best"]
    assert written == {path: path.stat().st_mtime_ns for path in (folder / "study").glob("chunk-*.npy")}
    for change in (("--scale", "sum"), ("--step", 0.18)):
        other = steeplejack("dimensions", *RECTANGLE, *options, *change)
        assert other.code == 2
        assert "another study" in other.err
        assert other.err.count("\n") == 1


def test_a_study_draws_the_whole_space_too(steeplejack: Run) -> None:
    options = ("--step", 0.19, "--step-m", 0.01, "--study", "study", "--out", "out", "--json")
    answer = steeplejack("dimensions", *RECTANGLE, *options).answer
    assert Path(answer["space_figure"]).name == "space.svg"
    assert Path(answer["space_figure"]).read_text().startswith("<?xml")


def test_a_lost_cluster_is_an_early_end_in_one_line(
    steeplejack: Run, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def lost(*_arguments: object) -> None:
        raise design.LostClusterError("study: the cluster is lost (KilledWorker); finished chunks are kept")

    monkeypatch.setattr(design, "run_study", lost)
    outcome = steeplejack("dimensions", *RECTANGLE, "--step", 0.19, "--step-m", 0.01, "--study", "study", "--json")
    assert (outcome.code, outcome.out) == (4, "")
    assert outcome.err.rstrip().splitlines()[-1].endswith("finished chunks are kept")


def test_a_study_in_a_file_is_named(steeplejack: Run, folder: Path) -> None:
    (folder / "file").write_text("")
    outcome = steeplejack("dimensions", *RECTANGLE, "--step", 0.19, "--study", "file")
    assert outcome.code == 2
    assert outcome.err.startswith("--study: ")


@pytest.mark.parametrize(
    "words",
    [
        ("reach", "--alpha-deg", 0, "--step-m", 0.01),
        ("transmission", "--alpha-deg", -20, "--step-m", 0.01),
        ("dimensions", *RECTANGLE, "--step", 0.1, "--step-m", 0.01),
    ],
)
def test_figures(steeplejack: Run, words: tuple[Any, ...]) -> None:
    answer = steeplejack(*words, "--out", "a/b", "--json").answer
    assert Path(answer["figure"]).name == f"{words[0]}.svg"
    assert Path(answer["figure"]).read_text().startswith("<?xml")


def test_a_person_gets_lines(steeplejack: Run) -> None:
    lines = steeplejack("reach", "--alpha-deg", 0, "--step-m", 0.01).out.splitlines()
    assert [line.split()[0] for line in lines][:2] == ["area_m2", "volume_m2_rad"]
    best, paper, *_ = steeplejack("dimensions", *RECTANGLE).out.splitlines()
    assert best.split(maxsplit=1)[1] == "1 : 1 : 1 : 0.49, GTI 0.7469"
    assert paper.split(maxsplit=1)[1] == "1 : 1 : 0.75 : 0.65, GTI 0.4706, 26% of the designs are better"
    lines = steeplejack("transmission", "--alpha-deg", 0, "--step-m", 0.01).out.splitlines()
    assert [line.split()[0] for line in lines] == ["gti", "mean", "min", "max", "cells", "within_limits"]
    assert " at x " in lines[2]


@pytest.mark.parametrize("command", ["reach", "transmission"])
def test_an_empty_workspace_names_its_limit(steeplejack: Run, command: str) -> None:
    outcome = steeplejack(command, "--alpha-deg", 30, "--step-m", 0.001, "--joint-neutral", "normal", "--json")
    assert outcome.code == 3
    assert outcome.answer["feasible"] is False
    assert outcome.answer["binding"] == "joint limits of 30 deg counted from 'normal'"
    assert outcome.err.count("\n") == 1


GRID = ("--alpha-deg", 0, "--step-m", 0.001)


@pytest.mark.parametrize(
    "words",
    [
        ("reach", "--alpha-deg", math.nan, "--step-m", 0.001),
        ("reach", "--alpha-deg", 200, "--step-m", 0.001),
        ("reach", "--alpha-deg", 0, "--step-m", 0.1),
        ("reach", "--alpha-deg", 0, "--step-m", 1e-7),
        ("reach", "--alpha-deg", 0, "--step-m", math.nan),
        ("reach", "--alpha-deg", 0, "--step-m", -0.001),
        ("reach", *GRID, "--dims", 0.1, 0.1, -0.075, 0.075),
        ("reach", *GRID, "--dims", 0.1, 0.1, math.nan, 0.075),
        ("reach", *GRID, "--dims", 1e200, 0.1, 0.1, 0.1),
        ("transmission", *GRID, "--dims", 1e60, 0.1, 0.1, 0.1),
        ("transmission", "--alpha-deg", 0, "--step-m", 1e-201, "--rectangle", 0, 1e-200, 0.1, 0.2),
        ("transmission", *GRID, "--rectangle", 0, 1e200, 0.1, 0.2),
        ("reach", *GRID, "--joint-neutral", "zero"),
        ("reach", *GRID, "--robot", "no-such.toml"),
        ("transmission", *GRID, "--rectangle", 0.05, -0.05, 0.13, 0.2),
        ("transmission", *GRID, "--rectangle", -0.05, 0.05, 0.2, 0.13),
        ("transmission", *GRID, "--rectangle", -0.05, 0.05, -0.1, 0.13),
        ("transmission", *GRID, "--rectangle", -0.05, math.inf, 0.1, 0.13),
        ("transmission", "--alpha-deg", 0, "--step-m", 0.09, *RECTANGLE),
        ("dimensions", *RECTANGLE, "--step", 0),
        ("dimensions", *RECTANGLE, "--step", 1),
        ("dimensions", *RECTANGLE, "--step", math.nan),
        ("dimensions", *RECTANGLE, "--scale", "l2"),
        ("dimensions", *RECTANGLE, "--workers", 2),
        ("dimensions", *RECTANGLE, "--workers", -1, "--study", "study"),
        ("dimensions", "--rectangle", 0, 0, 0.1, 0.2),
    ],
)
def test_what_it_refuses(steeplejack: Run, folder: Path, words: tuple[Any, ...]) -> None:
    outcome = steeplejack(*words, "--json")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.count("\n") == 1
    assert not list(folder.iterdir())
