"""Commands of the pipe climber's kinematics: the contract, the reference, exit codes and refusals."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from command_line import Outcome

Run = Callable[..., Outcome]

REFERENCE: dict[str, Any] = tomllib.loads((Path(__file__).parents[1] / "reference" / "pipe_climber.toml").read_text())
ROBOT = files("steeplejack.robots.pipe_climber").joinpath("pipe_climber.toml").read_text()


@pytest.mark.parametrize("case", REFERENCE["inverse"])
def test_legs(steeplejack: Run, case: dict[str, Any]) -> None:
    outcome = steeplejack("legs", "--pose", *case["pose"], "--convention", case["convention"], "--json")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.answer["q_m"] == pytest.approx(case["lengths"], abs=5e-10)
    assert outcome.answer["exceeded"] == []


def test_legs_out_of_reach_answer_and_name_the_limit(steeplejack: Run) -> None:
    outcome = steeplejack("legs", "--pose", 0, 0.119, 0, "--json")
    assert outcome.code == 3
    assert outcome.answer["q_m"][2] == pytest.approx(0.119)
    (only,) = outcome.answer["exceeded"]
    assert only == {"limb": 3, "what": "length", "value_m": pytest.approx(0.119), "limit_m": 0.12}
    assert "length of limb 3 is 0.119 m, least 0.12 m" in outcome.err
    hinge = steeplejack("legs", "--pose", 0, 0.15, 20, "--joint-neutral", "normal", "--json")
    assert hinge.code == 3
    assert hinge.answer["exceeded"][0]["limit_deg"] == pytest.approx(-30.0)


def test_platform(steeplejack: Run) -> None:
    lengths = steeplejack("legs", "--pose", 0.02, 0.15, 0, "--json").answer["q_m"]
    answer = steeplejack("platform", "--q-m", *lengths, "--json").answer
    assert answer["certified"] is True
    modes = [one["working_mode"] for one in answer["solutions"]]
    assert modes == ["home", "across", "home-mirrored", "across-mirrored"]
    for one, (x, w, alpha) in zip(answer["solutions"], REFERENCE["forward"]["solutions"], strict=False):
        assert (one["x_m"], one["w_m"]) == pytest.approx((x, w), abs=5e-9)
        assert one["alpha_deg"] == pytest.approx(alpha, abs=5e-6)
    assert "4 real solutions, proved" in steeplejack("platform", "--q-m", *lengths).out


def test_lengths_that_do_not_close_have_no_solutions(steeplejack: Run) -> None:
    outcome = steeplejack("platform", "--q-m", 0.1, 0.2, 0.9, "--json")
    assert (outcome.code, outcome.err.count("\n")) == (3, 1)
    binding = "the limbs do not close: no pose has these lengths"
    listed = [
        {"limb": 1, "what": "length", "value_m": 0.1, "limit_m": 0.12},
        {"limb": 3, "what": "length", "value_m": 0.9, "limit_m": 0.24},
    ]
    assert outcome.answer == {"solutions": [], "certified": True, "exceeded": listed, "binding": binding}
    within = steeplejack("platform", "--q-m", 0.12, 0.18, 0.24, "--json")
    assert (within.code, within.answer["exceeded"]) == (3, [])
    assert within.err == binding + "\n"


def test_lengths_out_of_reach_keep_their_poses_and_name_the_limit(steeplejack: Run) -> None:
    lengths = steeplejack("legs", "--pose", 0, 0.119, 0, "--json").answer["q_m"]
    outcome = steeplejack("platform", "--q-m", *lengths, "--json")
    assert outcome.code == 3
    assert len(outcome.answer["solutions"]) >= 2
    assert [one["limb"] for one in outcome.answer["exceeded"]] == [3]
    assert "binding" not in outcome.answer
    assert "length of limb 3 is 0.119 m, least 0.12 m" in outcome.err


def test_windows_of_the_cylinders_are_told_and_no_failure(steeplejack: Run) -> None:
    outcome = steeplejack("legs", "--pose", 0, 0.140, 0, "--json")
    assert (outcome.code, outcome.answer["exceeded"]) == (0, [])
    assert outcome.answer["outside_stroke"][-1] == {"limb": 3, "value_m": pytest.approx(0.14), "limit_m": 0.15}
    assert steeplejack("legs", "--pose", 0, 0.160, 0, "--json").answer["outside_stroke"] == []
    *_, last = steeplejack("legs", "--pose", 0, 0.140, 0).out.splitlines()
    assert last == "limb 3 is 0.14 m long, its own cylinder ends at 0.15 m"
    assert len(steeplejack("legs", "--pose", 0, 0.160, 0).out.splitlines()) == 1


def test_motion(steeplejack: Run) -> None:
    case = REFERENCE["motion"]
    answer = steeplejack("motion", "eq27", "--hz-m", case["claw_offset"], "--at", case["time"], "--json").answer
    assert answer["q_m"] == pytest.approx(case["lengths"], abs=5e-9)
    assert answer["qd_m_s"] == pytest.approx(case["speeds"], abs=5e-9)
    assert answer["qdd_m_s2"] == pytest.approx(case["accelerations"], abs=5e-9)
    keys = {"limb", "what", "from_s", "to_s", "at_s", "value", "limit", "unit"}
    assert all(set(one) == keys for one in answer["violations"])
    fastest = max(one["value"] for one in answer["violations"] if one["what"] == "speed")
    assert fastest == pytest.approx(case["needed_speed"], abs=5e-4)
    assert "violated: limb 3 speed" in steeplejack("motion", "eq27", "--at", 5).out


def test_motion_from_a_file(steeplejack: Run, folder: Path) -> None:
    (folder / "still.toml").write_text('name = "still"\nduration_s = 1.0\nx_m = [0.0]\nz_m = [0.16]\n')
    answer = steeplejack("motion", "still.toml", "--at", 0.5, "--json").answer
    assert answer["violations"] == []
    assert answer["qd_m_s"] == [0.0, 0.0, 0.0]
    (folder / "rise.csv").write_text("t_s,x_m,z_m\n" + "".join(f"{k},0,{0.15 + 0.02 * k}\n" for k in range(5)))
    answer = steeplejack("motion", "rise.csv", "--at", 0.5, "--json").answer
    assert answer["qd_m_s"][2] == pytest.approx(0.02)
    assert {(one["limb"], one["what"]) for one in answer["violations"]} >= {(3, "speed"), (3, "stroke")}


def test_singularity(steeplejack: Run, folder: Path) -> None:
    answer = steeplejack("singularity", "--alpha-deg", -30, "--out", "a/b", "--json").answer
    assert answer["min_abs_det"] == pytest.approx(REFERENCE["singularity"]["least_det_per_l1"], abs=0.005)
    assert (answer["sign_changes"], answer["signs"]) == (0, [-1])
    heights = [w for w, _ in answer["x_of_w"]]
    assert heights == [round(w, 3) for w in heights]
    assert Path(answer["figure"]).read_text().startswith("<?xml")
    assert [path.name for path in (folder / "a" / "b").iterdir()] == ["singularity.svg"]
    level = steeplejack("singularity", "--alpha-deg", 0, "--json").answer
    assert level["x_of_w"] == []


@pytest.mark.parametrize(
    "arguments",
    [
        ("legs", "--pose", "nan", 0.16, 0),
        ("legs", "--pose", 0, 0.16, 0, "--dims", 0.1, 0.1, 0.0, 0.1),
        ("legs", "--pose", 0, 0.16, 0, "--dims", 0.1, "inf", 0.1, 0.1),
        ("legs", "--pose", 0, 0.16, 0, "--dims", 1e200, 0.1, 0.1, 0.1),
        ("legs", "--pose", 0, 0.16, 0, "--dims", 0.5, 0.5, 0.4, 0.4, "--joint-neutral", "home"),
        ("legs", "--pose", 1e200, 0.16, 0),
        ("platform", "--q-m", 1e200, 0.1, 0.1),
        ("platform", "--q-m", 1e-200, 0.1, 0.1),
        ("motion", "eq27", "--at", 5, "--hz-m", 1e200),
        ("legs", "--pose", 0, 0.16, 0, "--convention", "figure"),
        ("legs", "--pose", 0, 0.16, 0, "--robot", "nowhere.toml"),
        ("platform", "--q-m", -0.1, 0.1, 0.1),
        ("platform", "--q-m", 0.1, "nan", 0.1),
        ("platform", "--q-m", 0.1, 0.1, 0.1, "--dims", 0.0625, 0.125, 0.125, 0.25),
        ("motion", "eq27", "--at", 11),
        ("motion", "eq27", "--at", "nan"),
        ("motion", "eq27", "--at", 5, "--hz-m", "inf"),
        ("motion", "nowhere.toml", "--at", 0),
        ("singularity", "--alpha-deg", "nan"),
    ],
    ids=lambda arguments: " ".join(map(str, arguments)),
)
def test_bad_input_is_one_line_and_exit_2(steeplejack: Run, arguments: tuple[object, ...]) -> None:
    outcome = steeplejack(*arguments)
    assert outcome.code == 2
    assert outcome.out == ""
    assert outcome.err.count("\n") == 1


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("lengths = [0.100, 0.100", "lengths = [-0.100, 0.100", "lengths"),
        ("lengths = [0.100, 0.100", "lengths = [nan, 0.100", "lengths"),
        ("reach = [0.120, 0.240]", "reach = [0.240, 0.120]", "reach"),
        ("speed = 0.017", "sped = 0.017", "sped"),
        ("claw_offset = 0.0 ", "claw_offset = nan ", "claw_offset"),
        ("home = [0.0, 0.160, 0.0]", "home = [0.0, nan, 0.0]", "home"),
        ("stroke = 0.050 ", "stroke = inf ", "stroke"),
        ("jaws = 2", "jaws = 0", "jaws"),
        ("retracted = [0.1677", "retracted = [0.2677", "retracted"),
        ("retracted = [0.1677", "retracted = [0.0500", "retracted"),
        ('neutral = "none"                        #', 'neutral = "home"\nhome = [0.0, 0.0, 0.0]\n#', "home"),
        ('neutral = "none"                        #', 'neutral = "home"\nhome = [0.0, 9.0, 0.0]\n#', "home"),
        ("home = [0.0, 0.160, 0.0]", "home = [0.0, 1e200, 0.0]", "home"),
        ("reach = [0.120, 0.240]", "reach = [0.120, 1e200]", "reach"),
    ],
)
def test_robot_files_that_cannot_be(steeplejack: Run, folder: Path, old: str, new: str, named: str) -> None:
    assert old in ROBOT
    text = ROBOT.replace(old, new)
    if "\nhome" in new:  # in place of the file's own
        text = text.replace("home = [0.0, 0.160, 0.0]", "")
    (folder / "robot.toml").write_text(text)
    outcome = steeplejack("motion", "eq27", "--at", 5, "--robot", "robot.toml")
    assert outcome.code == 2
    assert named in outcome.err
    assert outcome.err.count("\n") == 1


def test_an_alpha_nobody_reaches_is_infeasible(steeplejack: Run, folder: Path) -> None:
    short = ROBOT.replace("reach = [0.120, 0.240]", "reach = [0.120, 0.125]")
    (folder / "short.toml").write_text(short.replace("[0.1677, 0.1677, 0.1500]", "[0.120, 0.120, 0.120]"))
    outcome = steeplejack("singularity", "--alpha-deg", 60, "--robot", "short.toml", "--json")
    assert outcome.code == 3
    assert "0.12 to 0.125 m" in outcome.answer["binding"]
