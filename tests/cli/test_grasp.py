"""The grasp command: its contract, the reference, what it writes and what it refuses."""

from __future__ import annotations

import csv
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import Outcome

Run = Callable[..., Outcome]

REFERENCE: dict[str, Any] = tomllib.loads(
    (Path(__file__).parents[1] / "reference" / "grasp_table_iii.toml").read_text()
)
KEYS = {"x_m", "y_m", "tension_factor", "distance_m", "evaluations"}
OPTIONS = {"--stay": "3", "--x-m": "-0.10", "--half-width-m": "0.03", "--half-length-m": "0.05", "--phi-deg": "50"}


def command(**changes: str) -> list[str]:
    """The reference's command with options changed, added, or dropped where empty; ``x_m`` means ``--x-m``."""
    options = OPTIONS | {f"--{name.replace('_', '-')}": value for name, value in changes.items()}
    return ["grasp", "table-iii", *[word for option, value in options.items() if value for word in (option, value)]]


def test_the_exact_grasp(steeplejack: Run) -> None:
    outcome = steeplejack(*command(), "--json")
    answer = outcome.answer
    assert (outcome.code, outcome.err) == (0, "")
    assert set(answer) == KEYS | {"certified_gap"}
    assert (answer["x_m"], answer["y_m"]) == pytest.approx(REFERENCE["exact"]["position"], abs=1e-7)
    assert answer["tension_factor"] == pytest.approx(REFERENCE["exact"]["factor"], abs=1e-8)
    assert answer["certified_gap"] <= 1e-6


def test_algorithm_1(steeplejack: Run) -> None:
    answer = steeplejack(*command(method="algorithm-1", step_m="0.01", kappa="0.01"), "--json").answer
    assert set(answer) == KEYS
    assert (answer["x_m"], answer["y_m"]) == pytest.approx(REFERENCE["algorithm_1"]["position"], abs=1e-12)
    assert answer["tension_factor"] == pytest.approx(REFERENCE["algorithm_1"]["factor"], abs=5e-7)


def test_it_writes_the_figure_and_the_front(steeplejack: Run, folder: Path) -> None:
    answer = steeplejack(*command(), "--out", "a/b", "--json").answer
    assert {path.name for path in (folder / "a" / "b").iterdir()} == {"grasp.svg", "front.csv"}
    assert Path(answer["figure"]).read_text().startswith("<?xml")
    rows = list(csv.DictReader(Path(answer["front"]).read_text().splitlines()))
    factors = [float(row["tension_factor"]) for row in rows]
    assert len(rows) == 61
    assert (np.diff(factors) >= 0.0).all()
    assert factors[-1] == pytest.approx(answer["tension_factor"], abs=1e-8)
    assert float(rows[-1]["distance_m"]) >= answer["distance_m"] - 1e-9


def test_a_person_gets_a_table(steeplejack: Run) -> None:
    assert [line.split()[0] for line in steeplejack(*command()).out.splitlines()][:2] == ["x_m", "y_m"]


@pytest.mark.parametrize(("changes", "binding"), [
    ({"x_m": "5"}, "no position of the region is in wrench closure, proved"),
    ({"phi_deg": "0"}, "no position of the region is in wrench closure, proved"),
    ({"x_m": "5", "method": "algorithm-1", "step_m": "0.01", "kappa": "0.01"}, "nodes in the region is in"),
    ({"method": "algorithm-1", "step_m": "0.5", "kappa": "0.01"}, "no node of the grid of 0.5 m lies in the region"),
])  # fmt: skip
def test_no_grasp_names_the_limit(steeplejack: Run, folder: Path, changes: dict[str, str], binding: str) -> None:
    outcome = steeplejack(*command(**changes), "--out", "out", "--json")
    assert outcome.code == 3
    assert outcome.answer["feasible"] is False
    assert binding in outcome.answer["binding"]
    assert outcome.err.count("\n") == 1
    assert list(folder.iterdir()) == []


REFUSED = {
    "unknown stay": ({"stay": "9"}, ("--stay", "one of 1, 2, 3")),
    "negative width": ({"half_width_m": "-0.03"}, ("--half-width-m", "-0.03")),
    "width of no number": ({"half_width_m": "nan"}, ("--half-width-m",)),
    "negative length": ({"half_length_m": "-1"}, ("--half-length-m",)),
    "length without end": ({"half_length_m": "inf"}, ("--half-length-m",)),
    "place of no number": ({"x_m": "nan"}, ("--x-m",)),
    "place in words": ({"x_m": "left"}, ("--x-m",)),
    "turn without end": ({"phi_deg": "inf"}, ("--phi-deg",)),
    "unknown method": ({"method": "guess"}, ("--method",)),
    "no kappa": ({"method": "algorithm-1", "step_m": "0.01"}, ("--method algorithm-1", "no --kappa")),
    "no step": ({"method": "algorithm-1", "kappa": "0.01"}, ("no --step-m",)),
    "kappa of nothing": ({"method": "algorithm-1", "step_m": "0.01", "kappa": "0"}, ("--kappa", "above 0")),
    "kappa of no number": ({"method": "algorithm-1", "step_m": "0.01", "kappa": "nan"}, ("--kappa",)),
    "step of nothing": ({"method": "algorithm-1", "step_m": "0", "kappa": "0.01"}, ("--step-m", "above 0 m")),
    "step too fine": ({"method": "algorithm-1", "step_m": "1e-9", "kappa": "0.01"}, ("step", "nodes")),
    "a step the exact method has no use for": ({"step_m": "0.01"}, ("--step-m", "algorithm-1 only")),
    "width beyond all cables": ({"half_width_m": "1e200"}, ("half_width of the grasp region", "at most 1e+06 times")),
    "place beyond all cables": ({"x_m": "1e300"}, ("distance of the grasp region", "at most 1e+06 times")),
    "place beyond all numbers": ({"x_m": "1.7e308"}, ("the grasp region",)),
    "place beyond a grid": (
        {"x_m": "1e300", "method": "algorithm-1", "step_m": "0.01", "kappa": "0.01"},
        ("distance of the grasp region",),
    ),
    "no stay": ({"stay": ""}, ("--stay",)),
}


@pytest.mark.parametrize("name", REFUSED)
def test_bad_input_is_one_line(steeplejack: Run, folder: Path, name: str) -> None:
    changes, words = REFUSED[name]
    outcome = steeplejack(*command(**changes), "--out", "out", "--json")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.count("\n") == 1
    for word in words:
        assert word in outcome.err
    assert list(folder.iterdir()) == []


def test_a_bridge_has_no_plane(steeplejack: Run) -> None:
    outcome = steeplejack("grasp", "ecs620-like", *command()[2:])
    assert outcome.code == 2
    assert "is a bridge" in outcome.err
