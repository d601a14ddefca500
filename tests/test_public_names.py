"""The names a user writes first: all there, all documented, none loaded before it is used."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import steeplejack

HEAVY = ("numpy", "scipy", "numba", "mujoco", "matplotlib", "xarray", "netCDF4", "mcap", "typer", "rich")


def python(program: str) -> str:
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout


def test_about_twenty_names_in_one_table() -> None:
    assert sorted(steeplejack.__all__) == sorted([*steeplejack.ROOM_OF, "__version__"])
    assert 15 <= len(steeplejack.__all__) <= 25
    assert dir(steeplejack) == sorted(steeplejack.__all__)


def test_the_table_says_what_type_checkers_are_told() -> None:
    tree = ast.parse(Path(str(steeplejack.__file__)).read_text())
    guarded = next(node for node in tree.body if isinstance(node, ast.If))
    told = {
        alias.name: str(node.module).removeprefix("steeplejack.")
        for node in guarded.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert told == steeplejack.ROOM_OF


@pytest.mark.parametrize("name", steeplejack.ROOM_OF)
def test_a_name_is_the_one_its_room_exports(name: str) -> None:
    room = importlib.import_module(f"steeplejack.{steeplejack.ROOM_OF[name]}")
    found = getattr(steeplejack, name)
    assert found is getattr(room, name)
    assert found.__doc__
    assert name in getattr(room, "__all__", [name])


def test_star_import_brings_them_all() -> None:
    assert python("from steeplejack import *; print(load_squad().name, len(list_worksites()))").split() == [
        "ccrobot-s",
        "6",
    ]


def test_other_names_are_refused() -> None:
    with pytest.raises(AttributeError, match="'steeplejack' has no attribute 'climb'"):
        _ = steeplejack.climb  # pyright: ignore[reportAttributeAccessIssue]


def test_import_is_quick_and_light() -> None:
    program = (
        "import sys, time; began = time.perf_counter(); import steeplejack; steeplejack.__version__; "
        f"print(time.perf_counter() - began, *(name for name in {HEAVY} if name in sys.modules))"
    )
    seconds, *heavy = python(program).split()
    assert heavy == []
    assert float(seconds) < 0.3


def test_data_of_bridges_and_machines_need_no_compiler_and_no_physics() -> None:
    program = (
        "import sys, steeplejack; steeplejack.load_squad(); steeplejack.load_worksite('ecs620-like'); "
        "print(*(name for name in ('numba', 'mujoco', 'matplotlib') if name in sys.modules))"
    )
    assert python(program).split() == []
