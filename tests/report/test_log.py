"""Reading logs: whole, cut off anywhere, damaged, and things that are no logs at all."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest
from small_run import SQUAD, Run, bay_of, png, write_run

from steeplejack.errors import InputError
from steeplejack.report import analyse, read_log
from steeplejack.runtime.recorder import Recorder, Seed


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_run(tmp_path_factory.mktemp("log") / "run.mcap", Run(picture=png()))


def test_a_log_comes_back_as_it_was_written(whole: Path):
    log = read_log(whole)
    assert log.complete and log.accomplished and log.faults == ()
    assert log.squad == SQUAD
    assert log.bay == bay_of()
    assert log.mission.sha256 == log.mission.sealed().sha256
    assert log.seed.seed == 7
    assert len(log.states.time) == 480
    assert log.states.actual_rotation.shape == (480, 3, 3)
    np.testing.assert_allclose(np.diff(log.states.time), 0.05)
    assert [picture.data for picture in log.pictures] == [png()]


def test_the_machine_that_physics_ran_comes_back_where_it_was_another(whole: Path, tmp_path: Path):
    assert read_log(whole).actual == SQUAD
    other = msgspec.structs.replace(SQUAD, winch=msgspec.structs.replace(SQUAD.winch, friction=6.0))
    log = read_log(write_run(tmp_path / "run.mcap", Run(actual=other)))
    assert (log.squad, log.actual) == (SQUAD, other)


@pytest.mark.parametrize("share", np.linspace(0.0, 0.999, 23).tolist())
def test_a_log_cut_off_anywhere_is_read_up_to_there_or_refused(whole: Path, tmp_path: Path, share: float):
    content = whole.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(content[: int(share * len(content))])
    try:
        log = read_log(cut)
    except InputError as error:
        assert str(cut) in str(error) and "\n" not in str(error)
        assert share < 0.5
        return
    assert not log.complete
    assert 0 < len(log.states.time) <= 480


def test_a_killed_run_says_so(whole: Path, tmp_path: Path):
    cut = tmp_path / "killed.mcap"
    cut.write_bytes(whole.read_bytes()[: int(0.6 * whole.stat().st_size)])
    log = read_log(cut)
    assert log.faults == ("the log breaks off before the run's end",)
    summary = analyse(log).summary
    assert summary.faults == log.faults
    assert summary.coverage_fraction < 1.0
    assert {gap.why for gap in summary.not_covered} == {"the run ended early"}


@pytest.mark.parametrize("seed", range(8))
def test_damage_ends_the_reading_and_nothing_worse(whole: Path, tmp_path: Path, seed: int):
    rng = np.random.default_rng(seed)
    content = bytearray(whole.read_bytes())
    for place in rng.integers(len(content) // 2, len(content), 40):
        content[place] ^= 0x5A
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(bytes(content))
    assert not read_log(damaged).complete


def test_a_run_left_before_its_end_is_a_fault_though_the_log_is_whole(tmp_path: Path):
    log = read_log(write_run(tmp_path / "run.mcap", Run(note="interrupted")))
    assert log.complete
    assert log.faults == ("the run ended before the mission did",)


@pytest.mark.parametrize(
    ("content", "what"),
    [(b"", "empty"), (b"{}", "not an MCAP"), (b"\x00" * 5000, "not an MCAP"), (b"time,x\n0,1\n" * 99, "not an MCAP")],
)
def test_what_is_no_log_is_refused_in_one_line(tmp_path: Path, content: bytes, what: str):
    path = tmp_path / "file.mcap"
    path.write_bytes(content)
    with pytest.raises(InputError, match=what) as caught:
        read_log(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_missing_files_and_folders_are_refused(tmp_path: Path):
    for path in (tmp_path / "none.mcap", tmp_path):
        with pytest.raises(InputError, match=str(path)):
            read_log(path)


def test_a_log_of_something_else_is_refused_by_topic(tmp_path: Path):
    path = tmp_path / "other.mcap"
    recorder = Recorder(path)
    recorder.write("/seed", Seed(0, "0"), 0.0)
    recorder.close()
    with pytest.raises(InputError, match="no /worksite"):
        read_log(path)


def test_a_log_without_samples_is_refused(tmp_path: Path):
    with pytest.raises(InputError, match="no samples in /state"):
        read_log(write_run(tmp_path / "run.mcap", Run(legs=())))


def test_a_message_of_the_wrong_form_is_refused_with_its_topic(tmp_path: Path):
    path = tmp_path / "other.mcap"
    recorder = Recorder(path)
    recorder.write("/worksite", Seed(0, "0"), 0.0)
    recorder.close()
    with pytest.raises(InputError, match="/worksite"):
        read_log(path)
