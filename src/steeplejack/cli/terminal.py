"""What every command shares: options, exit codes, JSON on stdout, progress and errors on stderr."""

from __future__ import annotations

import math
import os
import signal
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Annotated, Any, cast

import msgspec
import typer

from steeplejack.errors import InputError, SteeplejackError
from steeplejack.worksite import Bridge, PlanarSite, load_worksite

CLOSED_PIPE, BAD_INPUT, INFEASIBLE, ENDED_EARLY, INTERRUPTED = 1, 2, 3, 4, 130
MOST_ANGLES = 100_000

Json = Annotated[bool, typer.Option("--json", help="One JSON object on stdout, everything else on stderr.")]
Out = Annotated[Path, typer.Option("--out", help="Folder for the files it writes.")]
Worksite = Annotated[str, typer.Argument(help="Built-in name, TOML worksite or CSV stay schedule.")]
Robot = Annotated[str, typer.Option("--robot", help="ccrobot-s or a TOML robot file.")]


class Ended(SteeplejackError):
    """A run that ended early but safely."""


def emit(answer: Any) -> None:
    """Print one JSON object."""
    print(msgspec.json.encode(answer).decode())


def show(answer: dict[str, Any]) -> None:
    """Print an answer for a person, a line each."""
    width = max((24, *(len(name) + 1 for name in answer)))
    for name, value in answer.items():
        print(f"{name:<{width}}{'-' if value is None else _rounded(value)}")


def _rounded(value: object) -> object:
    """A value for a person: numbers without the digits nobody reads."""
    if isinstance(value, list) and all(isinstance(one, float) for one in cast("list[object]", value)):
        return ", ".join(f"{one:.9g}" for one in cast("list[float]", value))
    return f"{value:.9g}" if isinstance(value, float) else value


def say(text: str) -> None:
    """Tell a person, on stderr."""
    print(text, file=sys.stderr)


@contextmanager
def bar(title: str, total: float | None) -> Generator[Callable[[float], None]]:
    """A progress bar on stderr; the callable takes how far the work is. Without a total it only shows that it runs."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description:<10}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True)) as progress:
        task = progress.add_task(title, total=total)
        yield lambda done: progress.update(task, completed=done)
        progress.update(task, total=total or 1.0, completed=total or 1.0)


@contextmanager
def stoppable() -> Generator[Callable[[], bool]]:
    """While it lasts, the first Ctrl-C and the first SIGTERM are only noted: the callable tells whether one came.

    A second one does what it would have done before. A signal that whoever started the program had it ignore, or that
    something outside Python handles, is left alone.
    """
    asked = False
    found = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    before = {number: handler for number, handler in found.items() if handler not in (None, signal.SIG_IGN)}

    def note(number: int, _frame: FrameType | None) -> None:
        nonlocal asked
        asked = True
        signal.signal(number, before[signal.Signals(number)])

    for number in before:
        signal.signal(number, note)
    try:
        yield lambda: asked
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def bridge(worksite: str) -> Bridge:
    """A worksite that is a bridge."""
    site = load_worksite(worksite)
    if not isinstance(site, Bridge):
        raise InputError("WORKSITE", f"{worksite} is a planar example", "a bridge or a stay schedule")
    return site


def planar(worksite: str) -> PlanarSite:
    """A worksite in the plane."""
    site = load_worksite(worksite)
    if not isinstance(site, PlanarSite):
        raise InputError("WORKSITE", f"{worksite} is a bridge", "a planar worksite such as table-iii")
    return site


def positive(option: str, value: float, unit: str) -> float:
    """An option that must be above 0."""
    if not value > 0.0:
        raise InputError(option, f"{value:g} {unit}", f"above 0 {unit}")
    return value


def mass(option: str, value: float) -> float:
    """A mass [kg]: a finite number, not negative."""
    if not 0.0 <= value < float("inf"):
        raise InputError(option, f"{value:g} kg", "a finite mass, 0 or more")
    return value


def target(folder: Path, option: str = "--out") -> None:
    """Refuse an output folder that is, or lies below, a file, or that cannot be made or written to; leaves nothing."""
    paths = folder, *folder.absolute().parents
    level = next(k for k, path in enumerate(paths) if path.exists())
    there = paths[level]
    if not there.is_dir():
        raise InputError(option, f"{there} is a file", "a folder, made where it does not exist yet")
    if not os.access(there, os.W_OK | os.X_OK):
        raise InputError(option, f"{there} cannot be written to", "a folder you may write to")
    if level > 0:
        try:  # rights do not tell: nobody makes folders in /proc
            paths[level - 1].mkdir()
            paths[level - 1].rmdir()
        except OSError as error:
            raise InputError(option, f"{paths[level - 1]}: {error.strerror}", "a folder that can be made") from error


@contextmanager
def writing(path: Path) -> Generator[None]:
    """Lets a failure to write name its file, which a full disk does not."""
    try:
        yield
    except OSError as error:
        if error.filename is None and not isinstance(error, BrokenPipeError):
            error.filename = str(path)
        raise


def window(option: str, low: float, high: float) -> tuple[float, float]:
    """A tension window [N], the smaller first."""
    if not 0.0 <= low < high < float("inf"):
        raise InputError(option, f"{low:g} {high:g}", "two tensions in N, the smaller first, not negative")
    return float(low), float(high)


def angles(text: str) -> list[float]:
    """What ``--phi-deg`` says: one orientation P or a range A:B:S, both ends included [rad]."""
    parts = text.split(":")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = []
    finite = all(math.isfinite(number) for number in numbers)
    if finite and len(numbers) == 1:
        return [math.radians(numbers[0])]
    if finite and len(numbers) == 3 and numbers[2] > 0.0 and numbers[0] <= numbers[1]:
        low, high, step = numbers
        if (high - low) / step < MOST_ANGLES:
            count = math.floor((high - low) / step + 1e-9) + 1
            return [math.radians(low + k * step) for k in range(count)]
        raise InputError("--phi-deg", text, f"a step that makes at most {MOST_ANGLES} orientations")
    raise InputError("--phi-deg", text, "P or A:B:S with A <= B and S > 0, finite, in degrees")
