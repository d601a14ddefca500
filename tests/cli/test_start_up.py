"""The command line starts without the libraries only some commands need."""

from __future__ import annotations

import subprocess
import sys


def test_the_command_line_starts_without_physics_and_plots() -> None:
    program = (
        "import sys, steeplejack.cli; "
        "print(*(name for name in ('mujoco', 'matplotlib', 'xarray', 'netCDF4', 'mcap') if name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout == "\n"
