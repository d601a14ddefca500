"""Motions by name or from a file: TOML with polynomials of time, or CSV with samples.

TOML has coefficients in rising powers of t [s]:

    name = "lift"
    duration_s = 2.0
    offset = "turning"               # hz turns with alpha, or "along-z" as in Eq. 8 (default "turning")
    x_m = [0.0]
    z_m = [0.150, 0.0, 0.075, -0.025]
    alpha_deg = [0.0]
    beta_deg = [0.0]                 # optional, as alpha_deg is

CSV has columns t_s, x_m, z_m and, optional, alpha_deg and beta_deg, a row a sample, from t = 0 on; hz turns with alpha.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np

from steeplejack.errors import InputError
from steeplejack.files import decode_toml, read_source, shortened
from steeplejack.robots.pipe_climber.motion import Motion, Trajectory, eq27, eq27_printed
from steeplejack.robots.pipe_climber.poses import Array, Offset
from steeplejack.robots.pipe_climber.sampled_motion import LEAST_SAMPLES, SampledMotion

Coefficients = Annotated[tuple[float, ...], msgspec.Meta(min_length=1)]

NAMED = {"eq27": eq27, "eq27-printed": eq27_printed}
VALID = "eq27, eq27-printed, a TOML file of polynomials or a CSV file of samples"
COLUMNS = ("t_s", "x_m", "z_m", "alpha_deg", "beta_deg")
NEEDED = 3  # of the columns
MOST_BYTES = 1 << 23
"""Of a file: samples of a quarter of an hour at 100 Hz."""
SHORTEST, LONGEST = 1e-3, 1e6
"""Durations a motion may have [s]."""
LEAST_GAP = 1e-6
"""Between two samples [s]."""
LARGEST = 1e6
"""What each term of a polynomial may come to within the motion, in the file's unit: no machine, and no overflow."""


class MotionFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The file as it is written, lengths in metres and angles in degrees."""

    name: str
    duration_s: Annotated[float, msgspec.Meta(gt=0.0)]
    x_m: Coefficients
    z_m: Coefficients
    alpha_deg: Coefficients = (0.0,)
    beta_deg: Coefficients = (0.0,)
    offset: Offset = "turning"


def load_motion(motion: str | Path) -> Trajectory:
    """A motion by name, ``eq27`` or ``eq27-printed``, or from a TOML or CSV file.

    Raises:
        InputError: No such file, an unknown or missing key or column, a number that is not finite or of no machine.
    """
    if str(motion) in NAMED:
        return NAMED[str(motion)]()
    content = read_source(motion, VALID, MOST_BYTES)
    return _sampled(motion, content) if Path(motion).suffix.lower() == ".csv" else _polynomials(motion, content)


def _polynomials(motion: str | Path, content: bytes) -> Motion:
    """The motion of a TOML file."""
    valid = "name, duration_s, x_m, z_m and, optional, alpha_deg, beta_deg, offset"
    given = decode_toml(content, MotionFile, str(motion), valid)
    _require_sizes(str(motion), given)
    alpha, beta = (tuple(math.radians(one) for one in turn) for turn in (given.alpha_deg, given.beta_deg))
    return Motion(given.name, given.duration_s, given.x_m, given.z_m, alpha, beta, given.offset)


def _sampled(motion: str | Path, content: bytes) -> SampledMotion:
    """The motion of a CSV file."""
    valid = f"columns {', '.join(COLUMNS[:NEEDED])} and, optional, {', '.join(COLUMNS[NEEDED:])}"
    try:
        rows = list(csv.reader(content.decode().splitlines(), strict=True, skipinitialspace=True))
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(str(motion), shortened(str(error)), valid) from None
    header = [name.strip() for name in rows[0]] if rows else []
    unlike = len(set(header)) < len(header) or not set(COLUMNS[:NEEDED]) <= set(header) <= set(COLUMNS)
    if unlike:
        raise InputError(str(motion), shortened(f"columns {', '.join(header) or 'none'}"), valid)
    samples = np.zeros((len(rows) - 1, len(COLUMNS)))
    columns = [COLUMNS.index(name) for name in header]
    for line, (sample, row) in enumerate(zip(samples, rows[1:], strict=True), 2):
        sample[columns] = _numbers(f"{motion} line {line}", header, row)
    _require_times(str(motion), samples[:, 0])
    samples[:, NEEDED:] = np.radians(samples[:, NEEDED:])
    return SampledMotion(Path(motion).stem, samples[:, 0], samples[:, 1:])


def _numbers(where: str, header: list[str], row: list[str]) -> list[float]:
    """A row as finite numbers, a cell a column."""
    if len(row) != len(header):
        raise InputError(where, f"{len(row)} cells", f"{len(header)} cells, as the header has")
    found: list[float] = []
    for name, cell in zip(header, row, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not abs(value) <= LARGEST:
            raise InputError(f"{where} {name}", shortened(repr(cell)), f"a number of at most {LARGEST:g}")
        found.append(value)
    return found


def _require_times(where: str, times: Array) -> None:
    """Refuse samples that no spline goes through."""
    if len(times) < LEAST_SAMPLES:
        raise InputError(where, f"{len(times)} samples", f"{LEAST_SAMPLES} or more")
    if times[0] != 0.0:
        raise InputError(f"{where} line 2 t_s", f"{times[0]:g} s", "0 s, where a motion begins")
    close = np.flatnonzero(np.diff(times) < LEAST_GAP)
    if close.size:
        line = int(close[0]) + 3
        valid = f"times that rise by {LEAST_GAP:g} s and more"
        raise InputError(f"{where} line {line} t_s", f"{times[line - 2]:g} s after {times[line - 3]:g} s", valid)


def _require_sizes(where: str, given: MotionFile) -> None:
    """Refuse numbers that are not finite, and those so large that no polynomial of a machine has them."""
    fields = ("x_m", "z_m", "alpha_deg", "beta_deg")
    for field in ("duration_s", *fields):
        if not np.isfinite(getattr(given, field)).all():
            raise InputError(where, f"`{field}` is not finite", "finite numbers")
    if not SHORTEST <= given.duration_s <= LONGEST:
        raise InputError(where, f"`duration_s` is {given.duration_s:g} s", f"{SHORTEST:g} to {LONGEST:g} s")
    for field in fields:
        for power, one in enumerate(getattr(given, field)):
            # In logarithms, because the power itself may overflow.
            if one and math.log10(abs(one)) + power * math.log10(given.duration_s) > math.log10(LARGEST):
                what = f"`{field}` has {one:g} t^{power}, with t up to {given.duration_s:g} s"
                raise InputError(where, what, f"terms of at most {LARGEST:g} within the motion")
