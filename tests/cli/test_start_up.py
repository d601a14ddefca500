"""Importing the package is quick and brings no heavy library along."""

from __future__ import annotations

import subprocess
import sys

HEAVY = ("numpy", "scipy", "numba", "mujoco", "matplotlib", "xarray", "netCDF4", "mcap", "typer", "rich")


def python(program: str) -> str:
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout


def test_import_is_quick_and_light() -> None:
    program = (
        "import sys, time; began = time.perf_counter(); import steeplejack; "
        f"print(time.perf_counter() - began, *(name for name in {HEAVY} if name in sys.modules))"
    )
    seconds, *heavy = python(program).split()
    assert heavy == []
    assert float(seconds) < 0.3


def test_the_command_line_starts_without_physics_and_plots() -> None:
    program = (
        "import sys, steeplejack.cli; "
        "print(*(name for name in ('mujoco', 'matplotlib', 'xarray', 'netCDF4', 'mcap') if name in sys.modules))"
    )
    assert python(program).split() == []
