"""Bad input: one clear line on stderr that names the place, exit 2, nothing written and nothing on stdout."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import pytest
from command_line import Outcome

Run = Callable[..., Outcome]

COLUMNS = (
    "cable_id,tower,plane,side,index,x_deck_m,y_deck_m,z_deck_m,x_tower_m,y_tower_m,z_tower_m,"
    "diameter_m,area_m2,force_kN,w_kN_per_m"
)
GOOD = [
    f"T1L-M0{k},1,L,main,{k},{15.0 + 12.0 * k},14.0,50.0,0.0,12.0,{110.0 + 2.0 * k},0.110,0.0075,3500,0.6"
    for k in range(1, 6)
]


def schedule(row: str | None = None, columns: str = COLUMNS) -> bytes:
    """Five good stays, the third one replaced."""
    rows = [*GOOD[:2], row, *GOOD[3:]] if row else GOOD
    return "\n".join([columns, *rows, ""]).encode()


def edited(column: str, value: str) -> bytes:
    cells = GOOD[2].split(",")
    cells[COLUMNS.split(",").index(column)] = value
    return schedule(",".join(cells))


SCHEDULES = {
    "missing column": (schedule(columns=COLUMNS.replace("z_tower_m", "height")), ("missing column z_tower_m",)),
    "text in a number": (edited("z_deck_m", "fifty"), ("line 4", "column z_deck_m", "'fifty'")),
    "zero-length stay": (
        schedule("T1L-M03,1,L,main,3,51,14,50,51,14,50,0.110,0.0075,3500,0.6"),
        ("line 4", "T1L-M03", "zero length"),
    ),
    "tower anchorage below deck": (edited("z_tower_m", "20"), ("line 4", "column z_tower_m", "T1L-M03")),
    "duplicate id": (edited("cable_id", "T1L-M01"), ("line 4", "column cable_id", "line 2")),
    "duplicate place": (edited("index", "1"), ("line 4", "column index", "line 2")),
    "negative diameter": (edited("diameter_m", "-0.1"), ("line 4", "column diameter_m", "above 0")),
    "not a number": (edited("force_kN", "nan"), ("line 4", "column force_kN")),
    "empty": (b"", ("an empty file",)),
    "header alone": (COLUMNS.encode(), ("no stays",)),
    "binary": (bytes(range(256)) * 4, ("a binary file",)),
    "not text": (b"\xff\xfe" * 40, ("not text",)),
}
ROBOT = files("steeplejack.robots.squad").joinpath("ccrobot_s.toml").read_text()
ROBOTS = {
    "unknown key": (ROBOT.replace("[platform]\n", "[platform]\nwings = 2.0\n"), ("wings", "$.platform")),
    "negative mass": (ROBOT.replace("mass = 17.7 ", "mass = -17.7 "), ("$.platform.mass", "> 0")),
    "window upside down": (ROBOT.replace("tension = [20.0, 250.0]", "tension = [250.0, 20.0]"), ("upside down",)),
    "text in a number": (ROBOT.replace("spacing = 0.6 ", 'spacing = "wide" '), ("$.base.spacing",)),
    "value without a source": (ROBOT.replace('hold_force = "Table IV', 'held = "Table IV'), ("held", "$.base")),
    "empty": ("", ("an empty file",)),
    "no TOML": ("mass: 17.7", ("see the built-in",)),
}


def refused(run: Run, folder: Path, arguments: list[object], words: tuple[str, ...]) -> None:
    before = sorted(folder.rglob("*"))
    outcome = run(*arguments)
    assert outcome.code == 2, outcome
    assert outcome.out == ""
    assert outcome.err.endswith("\n")
    assert outcome.err.count("\n") == 1, outcome.err
    assert "Traceback" not in outcome.err
    for word in words:
        assert word in outcome.err
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("command", ["check", "inspect"])
@pytest.mark.parametrize("name", SCHEDULES)
def test_schedules(steeplejack: Run, folder: Path, command: str, name: str) -> None:
    content, words = SCHEDULES[name]
    (folder / "stays.csv").write_bytes(content)
    refused(steeplejack, folder, [command, "stays.csv", "--json"], ("stays.csv", *words))


def test_the_schedule_they_are_made_from_is_good(steeplejack: Run, folder: Path) -> None:
    (folder / "stays.csv").write_bytes(schedule())
    assert steeplejack("check", "stays.csv").code == 0


@pytest.mark.parametrize("command", [["check", "ecs620-like"], ["inspect", "ecs620-like"]], ids=lambda c: c[0])
@pytest.mark.parametrize("name", ROBOTS)
def test_robots(steeplejack: Run, folder: Path, command: list[str], name: str) -> None:
    content, words = ROBOTS[name]
    assert content != ROBOT
    (folder / "robot.toml").write_text(content)
    refused(steeplejack, folder, [*command, "--robot", "robot.toml"], ("robot.toml", *words))


@pytest.mark.parametrize(("column", "name"), [("w_kN_per_m", "weight"), ("force_kN", "tension")])
def test_what_shapes_a_stay_is_not_guessed_in_silence(steeplejack: Run, folder: Path, column: str, name: str) -> None:
    """One stay of unknown sag stops the job, and is no matter for the check."""
    (folder / "stays.csv").write_bytes(edited(column, ""))
    words = (f"stay T1L-M03: {name} unknown", "--chord", "--accept-unknown")
    refused(steeplejack, folder, ["inspect", "stays.csv", "--stays", "2:4"], words)
    assert steeplejack("check", "stays.csv").code == 0


def test_a_window_without_end_in_the_robot_file(steeplejack: Run, folder: Path) -> None:
    (folder / "robot.toml").write_text(ROBOT.replace("tension = [20.0, 250.0]", "tension = [20.0, inf]"))
    refused(
        steeplejack, folder, [*BAY, "--robot", "robot.toml"], ("robot.toml: `tension` = (20.0, inf) is not finite",)
    )


@pytest.mark.parametrize(("low", "high", "words"), [
    ("3.9", "250.0", ("[cable] tension: 3.9 N", "from 4 N")),
    ("20.0", "478.1", ("[cable] tension: 478.1 N", "up to 478 N")),
])  # fmt: skip
def test_a_window_the_winches_cannot_keep_in_the_robot_file(
    steeplejack: Run, folder: Path, low: str, high: str, words: tuple[str, ...]
) -> None:
    (folder / "robot.toml").write_text(ROBOT.replace("tension = [20.0, 250.0]", f"tension = [{low}, {high}]"))
    refused(steeplejack, folder, [*BAY, "--robot", "robot.toml"], words)
    assert steeplejack("check", "ecs620-like", "--robot", "robot.toml").code == 0


def test_the_window_asked_for_takes_the_place_of_the_robot_files(steeplejack: Run, folder: Path) -> None:
    """Both ends included: from twice the friction to all the winch pulls; the next mistake is then found."""
    (folder / "robot.toml").write_text(ROBOT.replace("tension = [20.0, 250.0]", "tension = [0.0, 1e6]"))
    robot = ["--robot", "robot.toml", "--tension-n", "4", "478", "--payload-kg", "-1"]
    refused(steeplejack, folder, [*BAY, *robot], ("--payload-kg",))


INSPECT = ["inspect", "ecs620-like", "--fan", "T1L-main"]
BAY = [*INSPECT, "--stays", "5:9"]
MAP = ["map", "table-iii", "--phi-deg", "50", "--step-m", "0.05"]
POSE = ["--pose", "-0.1", "0.45", "50"]
TENSIONS = ["tensions", "table-iii", "--mass-kg", "8"]
OPTIONS = {
    "stays out of range": ([*INSPECT, "--stays", "5:99"], ("no stays 5:99",)),
    "stays the wrong way round": ([*INSPECT, "--stays", "9:5"], ("--stays", "9:5")),
    "stays of one number": ([*INSPECT, "--stays", "5"], ("--stays",)),
    "stays in words": ([*INSPECT, "--stays", "five:nine"], ("--stays",)),
    "stays in superscript": ([*INSPECT, "--stays", "²:9"], ("--stays",)),
    "stays with none between": ([*INSPECT, "--stays", "5:6"], ("no interior stay",)),
    "no such fan": (["inspect", "ecs620-like", "--fan", "T9X-main"], ("no fan T9X-main",)),
    "stretch below the stays": ([*BAY, "--from-m", "-3", "--to-m", "20"], ("--from-m", "-3")),
    "stretch beyond the stays": ([*BAY, "--from-m", "20", "--to-m", "1e5"], ("--to-m",)),
    "stretch upside down": ([*BAY, "--from-m", "40", "--to-m", "30"], ("40 to 30",)),
    "stretch of no number": ([*BAY, "--from-m", "nan", "--to-m", "30"], ("--from-m",)),
    "tension upside down": ([*BAY, "--tension-n", "250", "20"], ("--tension-n", "250 20")),
    "tension below nothing": ([*BAY, "--tension-n", "-5", "250"], ("--tension-n",)),
    "tension of no number": ([*BAY, "--tension-n", "nan", "250"], ("--tension-n",)),
    "tension without end": ([*BAY, "--tension-n", "20", "inf"], ("--tension-n",)),
    "tension no current tells from slack": (
        [*BAY, "--tension-n", "0", "250"],
        ("--tension-n: 0 N", "from 4 N", "slack"),
    ),
    "tension no winch pulls": ([*BAY, "--tension-n", "20", "1e6"], ("--tension-n: 1e+06 N", "up to 478 N")),
    "negative payload": ([*BAY, "--payload-kg", "-1"], ("--payload-kg", "-1")),
    "payload of no number": ([*BAY, "--payload-kg", "nan"], ("--payload-kg",)),
    "unknown face": ([*BAY, "--face", "left"], ("--face",)),
    "unknown diameter not accepted": (["inspect", "russky-like"], ("diameter unknown", "--accept-unknown")),
    "stays that no fan has": (["inspect", "ecs620-like", "--stays", "5:99"], ("--stays", "5 and 99", "T2R-main 1-21")),
    "unknown diameter on chords": (["inspect", "russky-like", "--chord"], ("diameter unknown", "--accept-unknown")),
    "planar worksite to inspect": (["inspect", "table-iii"], ("planar",)),
    "planar worksite to check": (["check", "table-iii"], ("planar",)),
    "bridge to map": (["map", "ecs620-like", "--phi-deg", "50", "--step-m", "0.01"], ("is a bridge",)),
    "no such worksite": (["check", "nowhere"], ("worksite nowhere", "ecs620-like")),
    "no such file": (["check", "nowhere.csv"], ("nowhere.csv", "No such file")),
    "no such robot": (["check", "ecs620-like", "--robot", "nobody"], ("nobody", "ccrobot-s")),
    "a folder for a worksite": (["check", "."], ("worksite .: a folder", ".toml or .csv")),
    "a folder for a robot": (["check", "ecs620-like", "--robot", "."], ("folder",)),
    "no such log": (["report", "nowhere.mcap"], ("nowhere.mcap", "no such file")),
    "no such command": (["fly"], ("fly",)),
    "no such option": (["check", "ecs620-like", "--colour"], ("--colour",)),
    "no worksite": (["inspect"], ("see --help",)),
    "text for a number": (["map", "table-iii", "--phi-deg", "50", "--step-m", "wide"], ("--step-m",)),
    "no step": ([*MAP[:4], "--step-m", "0"], ("step",)),
    "backward step": ([*MAP[:4], "--step-m", "-0.01"], ("step",)),
    "step of no number": ([*MAP[:4], "--step-m", "nan"], ("step",)),
    "angle in words": (["map", "table-iii", "--phi-deg", "steep", "--step-m", "0.05"], ("--phi-deg", "steep")),
    "angle of no number": (
        ["map", "table-iii", "--phi-deg", "nan", "--step-m", "0.05"],
        ("--phi-deg", "nan", "finite"),
    ),
    "angles without end": (["map", "table-iii", "--phi-deg", "0:inf:1", "--step-m", "0.05"], ("--phi-deg", "finite")),
    "too many angles": (["map", "table-iii", "--phi-deg", "0:360:1e-9", "--step-m", "0.05"], ("--phi-deg", "at most")),
    "range the wrong way": (["map", "table-iii", "--phi-deg", "60:50:1", "--step-m", "0.05"], ("--phi-deg",)),
    "range without a step": (["map", "table-iii", "--phi-deg", "50:60:0", "--step-m", "0.05"], ("--phi-deg",)),
    "mass for wrench closure": ([*MAP, "--mass-kg", "8"], ("--mass-kg", "wrench-feasible")),
    "window for wrench closure": ([*MAP, "--tension-n", "10", "250"], ("--tension-n", "wrench-feasible")),
    "slip force for wrench closure": ([*MAP, "--slip-n", "245"], ("--slip-n", "wrench-feasible")),
    "no mass": ([*MAP, "--criterion", "wrench-feasible"], ("--mass-kg M --tension-n A B",)),
    "negative map mass": (
        [*MAP, "--criterion", "wrench-feasible", "--mass-kg", "-1", "--tension-n", "1", "2"],
        ("--mass-kg", "-1 kg"),
    ),
    "map mass of no number": (
        [*MAP, "--criterion", "wrench-feasible", "--mass-kg", "nan", "--tension-n", "1", "2"],
        ("--mass-kg", "nan kg"),
    ),
    "no slip force": (
        [*MAP, "--criterion", "wrench-feasible", "--mass-kg", "1", "--tension-n", "1", "2", "--slip-n", "0"],
        ("--slip-n",),
    ),
    "no anchors": ([*MAP, "--anchors", "nowhere.txt"], ("nowhere.txt",)),
    "a length below nothing": (["pose", "table-iii", "--lengths-m", "0.3", "0.3", "-0.3", "0.4"], ("lengths",)),
    "three lengths": (["pose", "table-iii", "--lengths-m", "0.3", "0.3", "0.3"], ("--lengths-m",)),
    "mass below nothing": (
        ["tensions", "table-iii", *POSE, "--mass-kg", "-8", "--tension-n", "10", "250"],
        ("--mass-kg",),
    ),
    "mass of no number": (
        ["tensions", "table-iii", *POSE, "--mass-kg", "nan", "--tension-n", "10", "250"],
        ("--mass-kg",),
    ),
    "pose of no number": ([*TENSIONS, "--pose", "nan", "0.45", "50", "--tension-n", "10", "250"], ("--pose",)),
    "window upside down": ([*TENSIONS, *POSE, "--tension-n", "250", "10"], ("--tension-n",)),
    "a radius below nothing": (
        ["grip", "--radius-m", "-0.05", "--inclination-deg", "45", "--palm-m", "0.09", "--sign", "+"],
        ("radius",),
    ),
    "a palm too short to close": (
        ["grip", "--radius-m", "0.05", "--inclination-deg", "45", "--palm-m", "0.01", "--sign", "+"],
        ("palm",),
    ),
    "no such sign": (
        ["grip", "--radius-m", "0.05", "--inclination-deg", "45", "--palm-m", "0.09", "--sign", "*"],
        ("--sign",),
    ),
}


@pytest.mark.parametrize("name", OPTIONS)
def test_options(steeplejack: Run, folder: Path, name: str) -> None:
    arguments, words = OPTIONS[name]
    refused(steeplejack, folder, list(arguments), words)


@pytest.mark.parametrize(("name", "kind"), [("stays.xlsx", ".xlsx"), ("stays", "(no suffix)")])
@pytest.mark.parametrize("command", ["check", "inspect"])
def test_a_worksite_file_of_unknown_kind(steeplejack: Run, folder: Path, command: str, name: str, kind: str) -> None:
    """It is there, so it is not told that it is not."""
    (folder / name).write_bytes(schedule())
    refused(steeplejack, folder, [command, name], (f"{name}: a file of unknown kind {kind}; a .toml or .csv file",))


@pytest.mark.parametrize("content", [b"", b"\x00" * 64, b"\x89MCAP0\r\n", b"cable_id,tower\n"])
def test_logs(steeplejack: Run, folder: Path, content: bytes) -> None:
    (folder / "run.mcap").write_bytes(content)
    refused(steeplejack, folder, ["report", "run.mcap"], ("run.mcap",))


@pytest.mark.parametrize("lines", ["", "0 0\n1 1\n", "0 0\n1 1\n2 2\n3\n", "a b\n" * 4, "0 0 0\n" * 4])
def test_anchor_files(steeplejack: Run, folder: Path, lines: str) -> None:
    (folder / "anchors.txt").write_text(lines)
    refused(steeplejack, folder, [*MAP, "--anchors", "anchors.txt"], ("anchors.txt",))


@pytest.mark.parametrize("out", ["taken", "taken/deeper"])
@pytest.mark.parametrize("command", [MAP, [*BAY, "--from-m", "30", "--to-m", "33"]], ids=lambda c: c[0])
def test_output_folder_that_is_a_file(steeplejack: Run, folder: Path, command: list[str], out: str) -> None:
    (folder / "taken").write_text("here already")
    refused(steeplejack, folder, [*command, "--out", out], ("--out", "taken is a file"))
    assert (folder / "taken").read_text() == "here already"


def test_no_command_at_all_shows_the_help(steeplejack: Run) -> None:
    outcome = steeplejack()
    assert outcome.code == 2
    assert "inspect" in outcome.out
    assert outcome.err == "no command given; see --help\n"
