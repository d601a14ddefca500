"""Paths of the platform that anchors are reconfigured for: the paper's Eq. 28, or a file of poses."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import InputError
from steeplejack.files import read_source

Array = NDArray[np.float64]

COLUMNS = ("x_m", "y_m", "phi_deg")
VALID = "a CSV file with columns x_m, y_m, phi_deg"


def eq28(times: Array | None = None) -> Array:
    """The paper's path along the track stay: ``(2 - t, 0.8693 t + 23.7107) cm`` at 49 deg.

    Source: Zheng et al., CCRobot-S, IEEE T-RO, Eq. 28.

    Args:
        times: (k,) [s]; by default 0, 1, ... 50, the paper's 51 poses.

    Returns:
        Poses (k, 3) [m, m, rad].
    """
    t = np.arange(51.0) if times is None else np.asarray(times, dtype=np.float64)
    return np.stack([0.02 - 0.01 * t, 0.008693 * t + 0.237107, np.full(t.shape, math.radians(49.0))], axis=-1)


def read_path(path: str | Path) -> Array:
    """Read poses from a CSV file with the columns ``x_m, y_m, phi_deg``; further columns are ignored.

    Args:
        path: The file.

    Returns:
        Poses (k, 3) [m, m, rad].

    Raises:
        InputError: Not readable, a column missing, a cell that is no finite number, no rows.
    """
    try:
        text = read_source(path, VALID).decode()
        rows = list(csv.DictReader(text.splitlines(), strict=True))
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"path {path}", str(error), VALID) from None
    if not rows:
        raise InputError(f"path {path}", "no rows", "a header x_m,y_m,phi_deg and a row a pose")
    for name in COLUMNS:
        if name not in rows[0]:
            raise InputError(f"path {path}", f"no column {name}", "columns x_m, y_m, phi_deg")
    poses = np.array(
        [[_number(row.get(name), path, line, name) for name in COLUMNS] for line, row in enumerate(rows, 2)]
    )
    poses[:, 2] = np.deg2rad(poses[:, 2])
    return poses


def _number(cell: str | None, path: str | Path, line: int, column: str) -> float:
    """One cell as a finite number."""
    try:
        value = float(cell or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"path {path} line {line} {column}", repr(cell), "a finite number")
    return value
