"""Imports point one way: the table of rooms, as data, against every import in the package."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "src" / "steeplejack"

# A room may import what stands before it. Rooms of one tier do not import each other, but for what EXTRA allows.
TIERS = [
    {"errors", "files", "spatial"},
    {"mechanics"},
    {"worksite"},
    {"robots"},
    {"design", "planning", "control", "safety"},
    {"runtime"},
    {"simulation", "link", "report"},
    {"console"},
    {"cli"},
    {"__init__"},  # the package's own public names
]
# The same within the room of cable mechanics: what a part may import beside itself and the ground
# all of them stand on.
CABLE_GROUND = {"arguments", "cholesky", "degeneracy", "status", "structure", "pulleys"}
CABLE = {
    "arguments": set[str](),
    "cholesky": set[str](),
    "degeneracy": set[str](),
    "status": set[str](),
    "structure": set[str](),
    "pulleys": set[str](),
    "tension": set[str](),
    "wrench": {"tension"},
    "region": {"tension", "wrench"},
    "pose": set[str](),
    "rest": {"pose"},
    "measure": {"tension", "wrench", "rest"},
}
EXTRA = {("planning", "design"), ("spatial", "errors"), ("files", "errors")}
LIBRARIES = {
    "mujoco": {"simulation"},
    "matplotlib": {"report", "design/charts"},
    "nicegui": {"console"},
    "socket": {"link"},
    "cryptography": {"link"},
}
FILES = sorted(PACKAGE.rglob("*.py"))


def room(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports(path: Path) -> list[str]:
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            found.append(node.module or "")
            found += [f"{node.module}.{alias.name}" for alias in node.names]
    return found


def tier(name: str) -> int:
    return next(i for i, rooms in enumerate(TIERS) if name in rooms)


def allowed(source: str, target: str) -> bool:
    return source == target or (source, target) in EXTRA or tier(target) < tier(source)


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_point_one_way(path: Path) -> None:
    source = room(path)
    for name in imports(path):
        parts = name.split(".")
        if (
            parts[0] == "steeplejack"
            and len(parts) > 1
            and (PACKAGE / parts[1]).exists() | (PACKAGE / f"{parts[1]}.py").exists()
        ):
            assert allowed(source, parts[1]), f"{source} may not import {parts[1]}"
        if parts[0] == "steeplejack" and parts[1:2] == ["robots"] and source == "robots":
            here = path.relative_to(PACKAGE).parts[1]
            machine = (PACKAGE / "robots" / (parts[2:3] or [""])[0]).is_dir() and parts[2:3]
            assert machine in (False, [], [here]), "one robot may not import another"
        if parts[0] in LIBRARIES:
            place = path.relative_to(PACKAGE)
            where = {part.as_posix() for part in place.parents}
            assert where & LIBRARIES[parts[0]], f"{place} may not import {parts[0]}"


def test_every_room_is_in_the_table() -> None:
    rooms = {room(path) for path in FILES} - {"__init__"}
    assert rooms <= set().union(*TIERS)


def test_the_checker_sees_a_wrong_arrow() -> None:
    assert not allowed("mechanics", "robots")
    assert not allowed("control", "planning")
    assert allowed("planning", "design")


@pytest.mark.parametrize("part", CABLE)
def test_parts_of_cable_mechanics_import_one_way(part: str) -> None:
    root = PACKAGE / "mechanics" / "cable"
    files = [root / f"{part}.py"] if (root / f"{part}.py").exists() else sorted((root / part).glob("*.py"))
    found = {
        name.split(".")[3]
        for path in files
        for name in imports(path)
        if name.startswith("steeplejack.mechanics.cable.")
    }
    assert found <= CABLE[part] | CABLE_GROUND | {part}


def test_every_part_of_cable_mechanics_is_in_the_table() -> None:
    root = PACKAGE / "mechanics" / "cable"
    parts = {path.stem for path in root.iterdir() if not path.name.startswith("__")}
    assert parts == set(CABLE)
