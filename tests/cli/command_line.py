"""Runs the command line in this process, as ``steeplejack ...`` would, and says how to run it in another."""

from __future__ import annotations

import json
import sys
from typing import Any, NamedTuple

import pytest

from steeplejack.cli import main

# A test run in the background ignores Ctrl-C, and its children would inherit that.
_MAIN = (
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from steeplejack.cli import main; main()"
)
PROGRAM = (sys.executable, "-c", _MAIN)  # arguments of the command follow


class Outcome(NamedTuple):
    """What a command left behind."""

    code: int
    out: str
    err: str

    @property
    def answer(self) -> dict[str, Any]:
        """The one JSON object on stdout."""
        assert self.out.count("\n") == 1
        return json.loads(self.out, parse_constant=_refuse)


def _refuse(name: str) -> float:
    raise AssertionError(f"{name} is no JSON")


def call(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, arguments: list[str]) -> Outcome:
    """Run one command."""
    monkeypatch.setattr(sys, "argv", ["steeplejack", *arguments])
    with pytest.raises(SystemExit) as end:
        main()
    captured = capsys.readouterr()
    assert isinstance(end.value.code, int)
    return Outcome(end.value.code, captured.out, captured.err)
