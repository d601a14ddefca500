"""Runs of pipes by name: the built-in ones and files."""

from __future__ import annotations

from pathlib import Path

from steeplejack.errors import InputError
from steeplejack.files import read_source
from steeplejack.worksite.builtin import DATA, Listing
from steeplejack.worksite.pipe_file import decode_pipes
from steeplejack.worksite.pipe_run import PipeRun, build_run

PIPES = ("straight-vertical", "around", "bend-300", "flange", "clock-obstacle", "reducer", "planar-cross")


def list_pipes() -> tuple[Listing, ...]:
    """Every built-in run of pipes with its source."""
    runs = [decode_pipes(_file(name).read_bytes(), name) for name in PIPES]
    return tuple(Listing(run.name, run.description, run.source) for run in runs)


def load_pipe(pipe: str | Path) -> PipeRun:
    """Read a run of pipes.

    Args:
        pipe: A built-in name or a TOML file.

    Returns:
        The run, SI and radians.

    Raises:
        InputError: No such run, or a file that cannot be used; the message names the entry.
    """
    valid = f"a .toml file, or one of {', '.join(PIPES)}"
    if str(pipe) in PIPES:
        return build_run(decode_pipes(_file(str(pipe)).read_bytes(), str(pipe)), str(pipe))
    path = Path(pipe)
    if path.suffix.lower() != ".toml":
        what = f"a file of unknown kind {path.suffix or '(no suffix)'}" if path.is_file() else "no such name"
        raise InputError(f"pipe {pipe}", "a folder" if path.is_dir() else what, valid)
    return build_run(decode_pipes(read_source(path, valid), str(pipe)), str(pipe))


def _file(name: str) -> Path:
    return DATA / f"pipe-{name}.toml"
