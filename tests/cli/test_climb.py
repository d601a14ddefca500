"""``climb``: its answer, its files, and how it ends when it cannot or may not go on."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import Outcome

from steeplejack.cli.climb import show_summary
from steeplejack.planning.climb import faults, plan_climb
from steeplejack.robots.pipe_climber import load_pipe_climber
from steeplejack.worksite.pipe_builtin import load_pipe

LONG = pytest.mark.long

Steeplejack = Callable[..., Outcome]

KEYS = {
    "distance_m", "steps", "duration_s", "mean_speed_mm_s", "max_actuator_force_n", "min_transmission",
    "min_friction_margin", "min_friction_margin_moving", "slips", "collisions", "log", "report",
}  # fmt: skip
SHORT = """kind = "pipes"
name = "short"
description = "a vertical pipe, climbed for one stroke"
source = "test"
start = { s = 0.05 }
goal = { s = 0.10 }

[main]
diameter = 0.060
[[main.parts]]
kind = "straight"
length = 0.40
"""


def test_a_climb_of_one_stride_whose_plan_has_no_fault(steeplejack: Steeplejack, folder: Path) -> None:
    """What CI runs of the command: the contract's keys, log and report, with sensors of another seed."""
    (folder / "short.toml").write_text(SHORT.replace("0.10", "0.07"))
    done = steeplejack("climb", "short.toml", "--seed", 3, "--no-pictures", "--out", "out", "--json")
    assert done.code == 0 and set(done.answer) == KEYS
    assert done.answer["distance_m"] == pytest.approx(0.02, abs=1e-3) and done.answer["collisions"] == 0
    assert done.answer["slips"] == 0
    assert (folder / done.answer["log"]).stat().st_size > 0
    assert "with errors, seed 3" in (folder / done.answer["report"]).read_text()
    run, robot = load_pipe(folder / "short.toml"), load_pipe_climber()
    plan = plan_climb(run, robot)
    assert plan.complete and plan.steps == done.answer["steps"]
    assert faults(plan, run, robot) == []


@LONG
def test_a_short_climb(steeplejack: Steeplejack, folder: Path) -> None:
    (folder / "short.toml").write_text(SHORT)
    done = steeplejack("climb", "short.toml", "--no-pictures", "--out", "out", "--json")
    assert done.code == 0
    answer = done.answer
    assert set(answer) == KEYS
    assert answer["distance_m"] == pytest.approx(0.05, abs=1e-3)
    assert answer["steps"] == 1 and answer["collisions"] == 0
    assert answer["mean_speed_mm_s"] >= 8.07
    assert 0.0 < answer["max_actuator_force_n"] <= 50.0
    assert 0.0 <= answer["min_friction_margin"] <= answer["min_friction_margin_moving"]
    assert 0.0 < answer["min_friction_margin_moving"] < 1.0 - 0.24525 / 0.3 + 0.01  # what hanging by one gripper leaves
    assert (folder / answer["log"]).is_file() and (folder / answer["report"]).is_file()
    again = steeplejack("report", answer["log"], "--out", "again", "--json")
    assert again.code == 0 and again.answer["duration_s"] == answer["duration_s"]


@LONG
def test_too_little_friction_ends_early_but_safely(steeplejack: Steeplejack, folder: Path) -> None:
    (folder / "short.toml").write_text(SHORT)
    done = steeplejack("climb", "short.toml", "--mu-in-physics", "0.2", "--no-pictures", "--out", "out", "--json")
    assert done.code == 4 and "in physics mu = 0.2" in done.err
    assert set(done.answer) == KEYS
    assert done.answer["distance_m"] < 0.0 and done.answer["mean_speed_mm_s"] == 0.0
    assert "hanging safely with both grippers closed" in done.err and "slip" in done.err
    assert "Traceback" not in done.err


@LONG
def test_the_plan_says_that_too_little_friction_does_not_hold(steeplejack: Steeplejack, folder: Path) -> None:
    (folder / "short.toml").write_text(SHORT)
    done = steeplejack("climb", "short.toml", "--mu", "0.2", "--no-pictures", "--out", "out", "--json")
    assert done.code == 3 and "friction of 0.2 with 40 N a jaw" in done.answer["binding"]
    assert not (folder / "out").exists()


@LONG
def test_a_pipe_too_thick_has_no_climb(steeplejack: Steeplejack, folder: Path) -> None:
    (folder / "thick.toml").write_text(SHORT.replace("0.060", "0.120"))
    done = steeplejack("climb", "thick.toml", "--no-pictures", "--out", "out", "--json")
    assert done.code == 3
    assert done.answer["feasible"] is False and done.answer["binding"]
    assert not (folder / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "word"),
    [(("nowhere",), "straight-vertical"), (("straight-vertical", "--mu", "0"), "--mu"),
     (("straight-vertical", "--mu", "nan"), "--mu"), (("straight-vertical", "--seed", "-1"), "--seed"),
     (("straight-vertical", "--seed", "one"), "--seed"), (("straight-vertical", "--payload-kg", "nan"), "--payload-kg"),
     (("straight-vertical", "--robot", "none.toml"), "none.toml")],
)  # fmt: skip
def test_bad_input_is_one_line(steeplejack: Steeplejack, folder: Path, arguments: tuple[str, ...], word: str) -> None:
    done = steeplejack("climb", *arguments, "--json")
    assert done.code == 2 and word in done.err and done.err.count("\n") == 1
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    ("content", "said"),
    [("", "an empty file"), ("\x00\x01", "Invalid"),
     (SHORT.replace("0.060", "60.0"), "got 60.0 - at `$.main.diameter`"),
     (SHORT.replace("s = 0.10", "s = 9.0"), "goal.s: 9 m; on the pipe, 0 to 0.4 m")],
)  # fmt: skip
def test_a_wrong_pipe_file_is_one_line(steeplejack: Steeplejack, folder: Path, content: str, said: str) -> None:
    (folder / "wrong.toml").write_text(content)
    done = steeplejack("climb", "wrong.toml", "--json")
    assert done.code == 2 and done.err.startswith("wrong.toml") and said in done.err and done.err.count("\n") == 1
    assert [path.name for path in folder.iterdir()] == ["wrong.toml"]


def test_a_person_reads_how_far_it_slid_back(capsys: pytest.CaptureFixture[str]) -> None:
    answer = dict.fromkeys(KEYS, 0.0) | {"distance_m": -0.0123, "steps": 0}
    show_summary(answer)
    assert "nothing: slid back 12 mm" in capsys.readouterr().out
    show_summary(answer | {"distance_m": -1e-5, "steps": 1})
    assert "climbed                 0.000 m in 1 step\n" in capsys.readouterr().out
