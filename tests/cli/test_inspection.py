"""The main job from the command line: two metres of stay, one answer, three files; and Ctrl-C on the way."""

from __future__ import annotations

import json
import signal
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from command_line import PROGRAM, Outcome

from steeplejack.cli.inspect import show_summary
from steeplejack.cli.terminal import emit
from steeplejack.planning import decode
from steeplejack.planning.mission import Uncovered
from steeplejack.report import Summary, analyse, read_log
from steeplejack.report.analysis import Range, Size, Spread
from steeplejack.report.limits import limits

BAY = "inspect ecs620-like --fan T1L-main --stays 5:7 --from-m 30 --no-pictures --out out --json".split()
SPREAD = {"mean", "std"}
KEYS: dict[str, set[str] | type | tuple[type, ...]] = {
    "coverage_fraction": float,
    "clock_coverage": float,
    "not_covered": list,
    "duration_s": float,
    "real_time_factor": float,
    "distance_m": float,
    "stances": int,
    "moves": int,
    "max_tension_n": float,
    "min_slip_margin": float,
    "min_tension_factor": float,
    "stand_off_m": {"min", "max"},
    "error_along_mm": SPREAD,
    "error_across_mm": SPREAD,
    "error_stand_off_mm": SPREAD,
    "absolute_error_mm": {"mean", "max"},
    "faults": list,
    "log": str,
    "report": str,
    "mission": str,
}
GUO = Path(__file__).parents[2].parent / "shared" / "data" / "guo2019" / "stays.csv"
REAL = pytest.param(
    str(GUO),
    id="guo2019",
    marks=pytest.mark.skipif(not GUO.exists(), reason="../shared/data/guo2019/stays.csv is not here"),
)
PATIENCE = 240.0  # [s] compiling every kernel included


@dataclass(frozen=True)
class Run:
    """What a command in a folder left behind."""

    code: int
    out: str
    err: list[str]
    folder: Path

    @property
    def answer(self) -> dict[str, Any]:
        """The one JSON object on stdout."""
        assert self.out.count("\n") == 1
        return json.loads(self.out)


def complete(run: Run) -> None:
    """Every key of the contract with a value of its kind, and the three files it names."""
    answer = run.answer
    assert set(answer) == set(KEYS)
    for key, kind in KEYS.items():
        if isinstance(kind, set):
            assert set(answer[key]) == kind, key
        else:
            assert isinstance(answer[key], kind), key
    assert {path.name for path in (run.folder / "out").iterdir()} == {
        Path(answer[key]).name for key in ("log", "report", "mission")
    }
    assert "</html>" in (run.folder / answer["report"]).read_text()
    mission = decode((run.folder / answer["mission"]).read_bytes(), "mission")
    assert read_log(run.folder / answer["log"]).mission == mission


@pytest.fixture(scope="module")
def inspection(tmp_path_factory: pytest.TempPathFactory) -> Run:
    folder = tmp_path_factory.mktemp("inspection")
    command = [*PROGRAM, *BAY, "--to-m", "32"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=PATIENCE)
    return Run(done.returncode, done.stdout, done.stderr.splitlines(), folder)


def test_the_whole_job(inspection: Run) -> None:
    assert inspection.code == 0, inspection.err
    complete(inspection)
    answer = inspection.answer
    assert answer["coverage_fraction"] > 0.95
    assert answer["faults"] == answer["not_covered"] == []
    assert answer["min_slip_margin"] > 0.0
    assert answer["max_tension_n"] <= 250.0
    assert answer["real_time_factor"] > 0.0


@pytest.mark.long
@pytest.mark.parametrize("worksite", [REAL, "russky-like"])
def test_the_same_command_on_other_bridges(tmp_path: Path, worksite: str) -> None:
    """Three metres of a real bridge's leaning, curved plane, and of one of which little is known."""
    options = "--stays 5:7 --from-m 25 --to-m 28 --accept-unknown --no-pictures --out out --json".split()
    command = [*PROGRAM, "inspect", worksite, *options]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    run = Run(done.returncode, done.stdout, done.stderr.splitlines(), tmp_path)
    complete(run)
    answer = run.answer
    assert answer["faults"] == answer["not_covered"] == []
    assert answer["coverage_fraction"] == pytest.approx(1.0)
    assert answer["min_slip_margin"] > 0.1
    for key, mean, std in (("along", 2.0, 2.0), ("across", 2.0, 2.0), ("stand_off", 3.0, 5.0)):
        error = answer[f"error_{key}_mm"]
        assert abs(error["mean"]) < mean and error["std"] < std, key
    assert answer["absolute_error_mm"]["max"] < 15.0
    log = read_log(tmp_path / "out" / "run.mcap")
    assert any("diameter: the machine's largest, 120 mm" in words for words in log.mission.assumed)
    assert all(limit.held for limit in limits(log, analyse(log)))


def test_the_window_is_the_robot_files(inspection: Run, squad: Any) -> None:
    log = read_log(inspection.folder / inspection.answer["log"])
    assert log.mission.request.tension_n == squad.cable.tension
    assert log.mission.assumed == ()
    assert not any(stay.chord_only for stay in log.bay.stays)


def test_the_report_again_from_the_log_alone(inspection: Run, steeplejack: Callable[..., Outcome]) -> None:
    log = inspection.folder / "out" / "run.mcap"
    again = steeplejack("report", log, "--out", "again", "--json").answer
    first = inspection.answer
    assert {key: first[key] for key in again if key not in ("log", "report")} == {
        key: value for key, value in again.items() if key not in ("log", "report")
    }
    assert Path(again["report"]).is_file()


def test_a_person_gets_the_same_in_words(inspection: Run, capsys: pytest.CaptureFixture[str]) -> None:
    answer = inspection.answer
    show_summary(answer)
    whole = capsys.readouterr().out
    assert "covered, faced sector   100.0 %" in whole
    assert all(answer[key] in whole for key in ("log", "report", "mission"))


@pytest.fixture
def nothing() -> dict[str, Any]:
    """The answer of a run that ended before it saw anything, made as the command makes it."""
    spread = Spread(np.nan, np.nan)
    summary = Summary(
        coverage_fraction=0.0,
        clock_coverage=0.0,
        not_covered=(Uncovered("T1L-M06", 30.0, 32.0, "the run ended early"),),
        duration_s=0.05,
        distance_m=0.0,
        stances=0,
        moves=0,
        max_tension_n=120.0,
        min_slip_margin=0.4,
        min_tension_factor=np.nan,
        stand_off_m=Range(np.nan, np.nan),
        error_along_mm=spread,
        error_across_mm=spread,
        error_stand_off_mm=spread,
        absolute_error_mm=Size(np.nan, np.nan),
        faults=("cable slack (4)",),
    )
    files = {name: f"out/{name}" for name in ("log", "report", "mission")}
    return msgspec.to_builtins(summary) | {"real_time_factor": 0.1} | files


def test_a_person_is_shown_no_nan(nothing: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    show_summary(nothing)
    early = capsys.readouterr().out
    assert "nan" not in early
    assert "stand-off               ? m\n" in early
    assert "error along the stay    ? +- ? mm\n" in early
    assert "mean ?, max ? mm" in early
    assert early.endswith("not covered: T1L-M06 30.0-32.0 m: the run ended early\n")


@pytest.mark.parametrize(("span", "words"), [((0.548, 0.551), "0.55 m"), ((0.548, 0.62), "0.55-0.62 m")])
def test_one_figure_where_both_ends_are_printed_alike(
    nothing: dict[str, Any], span: tuple[float, float], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    show_summary(nothing | {"stand_off_m": dict(zip(("min", "max"), span, strict=True))})
    assert f"stand-off               {words}\n" in capsys.readouterr().out


def test_what_is_not_a_number_is_null_to_a_program(nothing: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    emit(nothing)
    answer = Outcome(0, *capsys.readouterr()).answer  # refuses NaN, which is no JSON
    assert answer["min_tension_factor"] is None
    assert answer["stand_off_m"] == {"min": None, "max": None}
    assert answer["error_along_mm"] == answer["error_stand_off_mm"] == {"mean": None, "std": None}


def interrupted(folder: Path, arguments: list[str], when: Callable[[], bool]) -> Run:
    """Run a command and press Ctrl-C as soon as ``when`` holds."""
    with (folder / "err").open("w") as err:
        job = subprocess.Popen([*PROGRAM, *arguments], cwd=folder, stdout=subprocess.PIPE, stderr=err, text=True)
        end = time.monotonic() + PATIENCE
        while not when():
            assert job.poll() is None and time.monotonic() < end, (folder / "err").read_text()
            time.sleep(0.02)
        job.send_signal(signal.SIGINT)
        out, _ = job.communicate(timeout=PATIENCE)
    return Run(job.returncode, out, (folder / "err").read_text().splitlines(), folder)


def test_ctrl_c_while_planning_leaves_nothing(tmp_path: Path) -> None:
    run = interrupted(tmp_path, [*BAY, "--to-m", "60"], lambda: "under face" in (tmp_path / "err").read_text())
    assert run.code == 130
    assert run.out == ""
    assert run.err[-1] == "interrupted"
    assert not any("Traceback" in line for line in run.err)
    assert not (tmp_path / "out").exists()


def test_ctrl_c_in_the_air_stops_the_squad_and_keeps_the_run(tmp_path: Path) -> None:
    """On chords, to see that what was asked for reaches the log."""
    log = tmp_path / "out" / "run.mcap"
    under_way = 100_000  # [bytes] of log: the mission and some seconds of the run
    run = interrupted(
        tmp_path, [*BAY, "--to-m", "42", "--chord"], lambda: log.exists() and log.stat().st_size > under_way
    )
    assert run.code == 4, run.err
    assert not any("Traceback" in line for line in run.err)
    assert run.err[-1].startswith("the run ended early but safely: interrupted by the operator")
    complete(run)
    assert run.answer["faults"] == ["interrupted by the operator"]
    assert 0.0 < run.answer["coverage_fraction"] < 1.0
    kept = read_log(log)
    assert kept.complete
    assert kept.states.stopped[-1]
    assert kept.mission.assumed == ("shape: straight chords, as asked for",)
    assert all(stay.chord_only and stay.sag == 0.0 for stay in kept.bay.stays)
    assert "straight chords, as asked for" in (tmp_path / "out" / "report.html").read_text()
