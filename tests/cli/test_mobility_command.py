"""The mobility command: its contract, the reference, linkages in files and what it refuses."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from command_line import Outcome

from steeplejack.mechanics.limb import LINKAGES

Run = Callable[..., Outcome]

REFERENCE: dict[str, dict[str, Any]] = tomllib.loads(
    (Path(__file__).parents[1] / "reference" / "mobility.toml").read_text()
)
KEYS = {"parallel", "rcm", "robot", "freedoms", "constraints", "parts"}


@pytest.mark.parametrize("options", [
    [], ["--convention", "equations"], ["--fixed", "upper"], ["--dims", "0.1", "0.1", "0.075", "0.065"],
])  # fmt: skip
def test_the_climber(steeplejack: Run, options: list[str]) -> None:
    outcome = steeplejack("mobility", *options, "--json")
    answer = outcome.answer
    assert (outcome.code, outcome.err, set(answer)) == (0, "", KEYS)
    assert (answer["parallel"], answer["rcm"], answer["robot"]) == (3, 1, 4)
    assert answer["freedoms"] == REFERENCE["pipe-climber"]["freedoms"]
    assert answer["constraints"] == REFERENCE["pipe-climber"]["constraints"]
    for name, part in {"3-rpr": "parallel", "rcm": "rcm", "pipe-climber": "robot"}.items():
        found, expected = answer["parts"][part], REFERENCE[name]
        assert (found["freedoms"], found["constraints"]) == (expected["freedoms"], expected["constraints"])
        assert found["by_reciprocal_screws"] == found["by_closure"] == found["kutzbach"]["mobility"]
        assert (found["kutzbach"]["redundant"], found["agree"]) == (expected["redundant"], True)


@pytest.mark.parametrize("name", LINKAGES)
def test_a_linkage(steeplejack: Run, folder: Path, name: str) -> None:
    """By its name, and as a file of the reader's own."""
    (folder / "own.toml").write_bytes(files("steeplejack.mechanics.limb").joinpath("data", f"{name}.toml").read_bytes())
    answer = steeplejack("mobility", "--mechanism", name, "--json").answer
    assert steeplejack("mobility", "--mechanism", "own.toml", "--json").answer == answer
    assert (answer["name"], answer["mobility"], answer["kind"]) == (name, REFERENCE[name]["mobility"], "full cycle")
    assert answer["agree"] is True


def test_a_person_gets_every_route(steeplejack: Run) -> None:
    out = steeplejack("mobility").out
    assert "3 (6 - 8 - 1) + 8 + 2 = 1" in out
    assert "rotation about Y; rotation about Z; translation along X; translation along Z" in out
    assert "  limb 1" in steeplejack("mobility", "--mechanism", "3-rrs").out


REFUSED = {
    "dimension of nothing": (["--dims", "0.1", "0", "0.075", "0.075"], ("--dims", "four finite lengths")),
    "dimension of no number": (["--dims", "0.1", "nan", "0.075", "0.075"], ("four finite lengths",)),
    "three dimensions": (["--dims", "0.1", "0.1", "0.075"], ("--dims",)),
    "unknown convention": (["--convention", "figure"], ("--convention",)),
    "unknown end": (["--fixed", "both"], ("--fixed",)),
    "unknown robot": (["--robot", "nobody.toml"], ("nobody.toml",)),
    "unknown linkage": (["--mechanism", "benett"], ("benett", "one of", "bennett")),
    "a linkage with dimensions": (["--mechanism", "bennett", "--dims", "1", "1", "1", "1"], ("--dims",)),
    "a linkage held at one end": (["--mechanism", "bennett", "--fixed", "upper"], ("--fixed",)),
}


@pytest.mark.parametrize("name", REFUSED)
def test_bad_mobility_input_is_one_line(steeplejack: Run, folder: Path, name: str) -> None:
    options, words = REFUSED[name]
    outcome = steeplejack("mobility", *options, "--json")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.count("\n") == 1
    for word in words:
        assert word in outcome.err


def test_a_file_with_a_link_that_is_not_there(steeplejack: Run, folder: Path) -> None:
    text = files("steeplejack.mechanics.limb").joinpath("data", "sarrus.toml").read_text()
    (folder / "own.toml").write_text(text.replace('"front_upper", "plate"]\npoint', '"front_upper", "plait"]\npoint'))
    outcome = steeplejack("mobility", "--mechanism", "own.toml")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("own.toml, joint 'A3': unknown link 'plait'; one of 'base'")
