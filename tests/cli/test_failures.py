"""Failures of the machine it runs on, and of the program itself: one line where foreseeable, a traceback where not."""

from __future__ import annotations

import errno
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import PROGRAM, Outcome

from steeplejack.cli import main
from steeplejack.cli.terminal import stoppable
from steeplejack.errors import SteeplejackError

Run = Callable[..., Outcome]
LONG = "check ecs620-like --json".split()  # more than a pipe's buffer in this process holds
SHORT = ["robots"]
SMALL = 1024  # [bytes] a file may grow to where the disk is "full"


def raising(error: Exception) -> Callable[..., None]:
    def fail(*_arguments: object) -> None:
        raise error

    return fail


def test_an_error_without_a_kind_of_its_own_is_one_line(steeplejack: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("steeplejack.cli.sites.load_squad", raising(SteeplejackError("steps do not\ndivide")))
    outcome = steeplejack("check", "ecs620-like")
    assert (outcome.code, outcome.out, outcome.err) == (2, "", "steps do not divide\n")


def test_what_the_operating_system_refuses_is_named(steeplejack: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    refusal = PermissionError(13, "Permission denied", "robots/mine.toml")
    monkeypatch.setattr("steeplejack.cli.sites.load_squad", raising(refusal))
    outcome = steeplejack("check", "ecs620-like")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err == "robots/mine.toml: Permission denied; a file you have permission for\n"


@pytest.mark.parametrize(
    ("number", "valid"),
    [
        (errno.ENOSPC, "a disk with room"),
        (errno.EACCES, "a file you have permission for"),
        (errno.EPERM, "a file you have permission for"),
        (errno.ENOENT, "a file that exists"),
        (errno.EISDIR, "a file, not a folder"),
        (errno.EIO, "a file that can be read, in a place that can be written to"),
    ],
)
def test_what_would_be_valid_depends_on_what_was_refused(
    steeplejack: Run, monkeypatch: pytest.MonkeyPatch, number: int, valid: str
) -> None:
    refusal = OSError(number, os.strerror(number), "out/map.nc")
    monkeypatch.setattr("steeplejack.cli.sites.load_squad", raising(refusal))
    outcome = steeplejack("check", "ecs620-like")
    assert (outcome.code, outcome.out, outcome.err) == (2, "", f"out/map.nc: {os.strerror(number)}; {valid}\n")


def test_a_bug_is_not_hidden(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("steeplejack.cli.sites.load_squad", raising(ZeroDivisionError("a bug")))
    monkeypatch.setattr(sys, "argv", ["steeplejack", "check", "ecs620-like"])
    with pytest.raises(ZeroDivisionError, match="a bug"):
        main()


def test_ctrl_c_is_one_word(steeplejack: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def press(*_arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("steeplejack.cli.sites.load_squad", press)
    outcome = steeplejack("check", "ecs620-like")
    assert (outcome.code, outcome.out, outcome.err) == (130, "", "interrupted\n")


def test_the_first_ctrl_c_asks_and_the_second_interrupts() -> None:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with stoppable() as asked_to_stop:
            assert not asked_to_stop()
            signal.raise_signal(signal.SIGINT)
            assert asked_to_stop()
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
        with stoppable() as asked_to_stop:
            assert not asked_to_stop()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)


def test_sigterm_asks_like_ctrl_c_and_both_are_given_back() -> None:
    came: list[int] = []
    before = signal.signal(signal.SIGTERM, lambda number, _frame: came.append(number))
    handler = signal.getsignal(signal.SIGTERM)
    try:
        with stoppable() as asked_to_stop:
            signal.raise_signal(signal.SIGTERM)
            assert asked_to_stop()
            assert came == []
            signal.raise_signal(signal.SIGTERM)
            assert came == [signal.SIGTERM]
        assert signal.getsignal(signal.SIGTERM) is handler
    finally:
        signal.signal(signal.SIGTERM, before)


@pytest.mark.parametrize("ignored", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_the_program_was_started_to_ignore_stays_ignored(ignored: signal.Signals) -> None:
    before = signal.signal(ignored, signal.SIG_IGN)
    try:
        with stoppable() as asked_to_stop:
            signal.raise_signal(ignored)
            assert not asked_to_stop()
            assert signal.getsignal(ignored) is signal.SIG_IGN
        assert signal.getsignal(ignored) is signal.SIG_IGN
    finally:
        signal.signal(ignored, before)


def test_a_signal_handled_outside_python_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """For such a handler Python has no name, so it could not be put back."""
    monkeypatch.setattr("steeplejack.cli.terminal.signal.getsignal", lambda _number: None)
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        with stoppable() as asked_to_stop:
            signal.raise_signal(signal.SIGTERM)
            assert not asked_to_stop()
    finally:
        signal.signal(signal.SIGTERM, before)


@pytest.mark.parametrize("arguments", [LONG, SHORT], ids=lambda a: a[0])
def test_a_reader_that_has_gone(folder: Path, arguments: list[str]) -> None:
    """As in `steeplejack check ... | head -1`: within the command, or when what is left is written at its end."""
    reader, writer = os.pipe()
    os.close(reader)
    run = subprocess.run([*PROGRAM, *arguments], stdout=writer, stderr=subprocess.PIPE, text=True)
    os.close(writer)
    assert (run.returncode, run.stderr) == (1, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full, a device that is always full")
@pytest.mark.parametrize("arguments", [LONG, SHORT], ids=lambda a: a[0])
def test_output_to_a_full_disk(folder: Path, arguments: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        run = subprocess.run([*PROGRAM, *arguments], stdout=full, stderr=subprocess.PIPE, text=True)
    assert run.returncode == 2
    assert run.stderr == "output: No space left on device; a disk with room\n"


def test_files_on_a_full_disk(steeplejack: Run) -> None:
    """Only the command's own files: its kernels are compiled and kept before, and byte code cut off would be kept."""
    arguments = "map table-iii --phi-deg 50 --step-m 0.05 --out".split()
    assert steeplejack(*arguments, "before").code == 0
    run = subprocess.run(
        [*PROGRAM, *arguments, "out"],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (SMALL, SMALL)),
    )
    assert run.returncode == 2
    assert "out/map.nc: " in run.stderr
    assert "Traceback" not in run.stderr


def test_a_folder_name_that_cannot_be(steeplejack: Run, folder: Path) -> None:
    outcome = steeplejack("map", "table-iii", "--phi-deg", "50", "--step-m", "0.05", "--out", 300 * "a")
    assert outcome.code == 2
    assert 300 * "a" + ": File name too long" in outcome.err
    assert list(folder.iterdir()) == []
