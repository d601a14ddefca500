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

import pytest
from command_line import PROGRAM, Outcome

from steeplejack.cli.inspect import show_summary
from steeplejack.planning import decode
from steeplejack.report import read_log

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
    nothing = {key: dict.fromkeys(kind) for key, kind in KEYS.items() if isinstance(kind, set)}
    gap = {"stay": "T1L-M06", "from_m": 30.0, "to_m": 32.0, "why": "the run ended early"}
    show_summary(answer | nothing | {"coverage_fraction": 0.0, "not_covered": [gap]})
    early = capsys.readouterr().out
    assert "mean ?, max ? mm" in early
    assert early.endswith("not covered: T1L-M06 30.0-32.0 m: the run ended early\n")


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
