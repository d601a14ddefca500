"""Motions of the claw: Eq. 27 printed and corrected, files, and what they ask of the machine."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from climber_cases import REFERENCE, layout

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber import Layout, load_pipe_climber
from steeplejack.robots.pipe_climber.motion import Motion, eq27, eq27_printed, limb_states, states
from steeplejack.robots.pipe_climber.motion_file import load_motion
from steeplejack.robots.pipe_climber.sampled_motion import SampledMotion
from steeplejack.robots.pipe_climber.violations import Violation, violations

ROBOT = load_pipe_climber()
CASE = REFERENCE["motion"]
LIFT = """name = "lift"
duration_s = 4.0
x_m = [0.0]
z_m = [0.155, 0.0, 0.00375, -0.000625]
"""


def test_the_reference_moment_of_eq27() -> None:
    lengths, speeds, accelerations = limb_states(layout(), eq27(), CASE["time"], CASE["claw_offset"])
    assert lengths == pytest.approx(CASE["lengths"], abs=5e-9)
    assert speeds == pytest.approx(CASE["speeds"], abs=5e-9)
    assert accelerations == pytest.approx(CASE["accelerations"], abs=5e-9)


def test_eq27_rests_at_both_ends_only_when_corrected() -> None:
    for motion, rests in ((eq27(), True), (eq27_printed(), False)):
        end = states(motion, [0.0, motion.duration], 0.1)
        assert bool(np.abs(end.velocity).max() < 1e-12) is rests
        assert end.beta[:, 1] == pytest.approx([0.0, 0.0], abs=1e-14)
    last = states(eq27_printed(), 10.0, 0.1)
    assert math.degrees(last.pose[2]) == pytest.approx(CASE["printed_end_deg"])
    assert math.degrees(last.velocity[2]) == pytest.approx(CASE["printed_end_deg_s"])
    assert math.degrees(states(eq27(), 10.0, 0.1).pose[2]) == pytest.approx(45.0)


@pytest.mark.parametrize("offset", ["turning", "along-z"])
def test_derivatives_of_states_and_limbs(offset: str) -> None:
    motion, step = replace(eq27(), offset=offset), 1e-3  # pyright: ignore[reportArgumentType]
    times = np.linspace(1.0, 9.0, 17)
    before, here, after = (limb_states(layout(), motion, times + shift, 0.08) for shift in (-step, 0.0, step))
    assert (after[0] - before[0]) / (2 * step) == pytest.approx(here[1], abs=1e-7)
    assert (after[1] - before[1]) / (2 * step) == pytest.approx(here[2], abs=1e-7)
    poses = [states(motion, times + shift, 0.08) for shift in (-step, 0.0, step)]
    assert (poses[2].pose - poses[0].pose) / (2 * step) == pytest.approx(poses[1].velocity, abs=1e-6)
    assert (poses[2].velocity - poses[0].velocity) / (2 * step) == pytest.approx(poses[1].acceleration, abs=1e-6)


def of(found: list[Violation], what: str) -> list[Violation]:
    return [one for one in found if one.what == what]


def test_eq27_leaves_the_reach_for_every_hz_and_needs_43_mm_s() -> None:
    for hz in np.arange(0.0, 0.25, 0.05):
        assert of(violations(ROBOT, layout(), eq27(), float(hz)), "length")
    found = violations(ROBOT, layout(), eq27(), CASE["claw_offset"])
    speeds = of(found, "speed")
    assert {one.limb for one in speeds} == {1, 2, 3}
    assert max(one.value for one in speeds) == pytest.approx(CASE["needed_speed"], abs=5e-4)
    times = np.linspace(0.0, 10.0, 20_001)
    lengths, rates, _ = limb_states(layout(), eq27(), times, CASE["claw_offset"])
    for one in found:
        assert one.limb is not None
        column = {"length": lengths, "speed": np.abs(rates), "stroke": lengths}[one.what][:, one.limb - 1]
        if one.what == "stroke":
            assert one.value == pytest.approx(np.ptp(column), abs=1e-9)
            continue
        inside = (times >= one.from_s) & (times <= one.to_s)
        below = one.limit == 0.120
        assert one.value == pytest.approx(column[inside].min() if below else column[inside].max(), abs=1e-9)
        for edge in (one.from_s, one.to_s):
            if 0.0 < edge < 10.0:
                at = limb_states(layout(), eq27(), edge, CASE["claw_offset"])[0 if one.what == "length" else 1]
                assert abs(at[one.limb - 1]) == pytest.approx(one.limit, abs=1e-9)
    covered = [
        sum(one.from_s <= t <= one.to_s for one in of(found, "length") if one.limb == 3) for t in (1.0, 4.0, 8.0)
    ]
    assert covered == [1, 0, 1]


def test_a_gentle_motion_violates_nothing(tmp_path: Path) -> None:
    path = tmp_path / "lift.toml"
    path.write_text(LIFT)
    motion = load_motion(path)
    assert isinstance(motion, Motion)
    assert (motion.name, motion.duration, motion.alpha, motion.offset) == ("lift", 4.0, (0.0,), "turning")
    assert violations(ROBOT, layout(), motion, 0.0) == []


def test_hinges_and_the_linkage_have_limits_too() -> None:
    turning = Motion("turn", 2.0, (0.0,), (0.15,), (0.0, 0.4), (0.0, 0.3))
    none = violations(ROBOT, layout(), turning, 0.0)
    assert [(one.limb, one.what) for one in none if one.what == "linkage"] == [(None, "linkage")]
    assert of(none, "linkage")[0].from_s == pytest.approx(math.radians(30.0) / 0.3, abs=1e-9)
    normal = violations(ROBOT, layout(neutral="normal"), turning, 0.0)
    assert of(normal, "hinge at the platform")
    assert not of(none, "hinge at the platform")


def test_a_motion_through_a_singularity_is_told() -> None:
    turning = Motion("over", 4.0, (0.0,), (0.16,), (0.0, -0.6))
    (found,) = of(violations(ROBOT, layout(), turning, 0.0), "singularity")
    assert found.limb is None
    assert 0.0 < found.from_s < found.to_s < 4.0
    assert of(violations(ROBOT, layout(), replace(turning, offset="along-z"), 0.0), "singularity")


@pytest.mark.parametrize(
    ("text", "field"),
    [
        (LIFT.replace("duration_s = 4.0", "duration_s = 0"), "duration_s"),
        (LIFT.replace("x_m = [0.0]", "x_m = []"), "x_m"),
        (LIFT.replace("x_m = [0.0]", "x_m = [nan]"), "x_m"),
        (LIFT.replace("duration_s = 4.0", "duration_s = inf"), "duration_s"),
        (LIFT.replace("duration_s = 4.0", "duration_s = 1e-9"), "duration_s"),
        (LIFT.replace("duration_s = 4.0", "duration_s = 1e300"), "duration_s"),
        (LIFT.replace("x_m = [0.0]", "x_m = [0.0, -1e300]"), "x_m"),
        (LIFT.replace("x_m = [0.0]", "x_m = [0.0, 0.0, 1e5]"), "x_m"),
        (LIFT + "alpha_deg = [1e9]\n", "alpha_deg"),
        (LIFT + "beta_deg = [0.0, 1e308]\n", "beta_deg"),
        (LIFT + "speed = 3\n", "speed"),
        (LIFT + 'offset = "sideways"\n', "offset"),
        ("name = ", "Invalid"),
        ("x_m = " + "[" * 5000, "motion"),
        ("duration_s = " + "9" * 5000, "motion"),
        ("\xff", "motion"),
    ],
)
def test_files_that_are_no_motion(tmp_path: Path, text: str, field: str) -> None:
    path = tmp_path / "motion.toml"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match=field) as refused:
        load_motion(path)
    assert "\n" not in str(refused.value)


def sampled(motion: Motion, step: float) -> SampledMotion:
    times = np.arange(0.0, motion.duration + 0.5 * step, step)
    return SampledMotion(motion.name, times, motion.coordinates(times)[..., 0], motion.offset)


def test_samples_of_eq27_ask_for_what_eq27_asks_for() -> None:
    claw = CASE["claw_offset"]
    times = np.linspace(0.0, 10.0, 4001)  # seven of eight between two samples, where the spline is not exact by itself
    exact = limb_states(layout(), eq27(), times, claw)
    coarse, fine = (limb_states(layout(), sampled(eq27(), step), times, claw) for step in (0.2, 0.02))
    for order, tolerance in enumerate((4e-11, 1.2e-8, 2.3e-6)):
        assert np.abs(fine[order] - exact[order]).max() < tolerance
        # Ten times as many samples: of the order h^4, h^3, h^2.
        assert (
            np.abs(coarse[order] - exact[order]).max()
            > 0.5 * 10.0 ** (4 - order) * np.abs(fine[order] - exact[order]).max()
        )
    found, expected = (violations(ROBOT, layout(), one, claw) for one in (sampled(eq27(), 0.02), eq27()))
    assert [(one.limb, one.what, one.limit) for one in found] == [(one.limb, one.what, one.limit) for one in expected]
    assert [one.value for one in found] == pytest.approx([one.value for one in expected], abs=1e-7)
    assert [one.from_s for one in found] == pytest.approx([one.from_s for one in expected], abs=1e-5)


def test_a_singularity_between_samples_is_placed_in_time() -> None:
    turning = Motion("over", 4.0, (0.0,), (0.16,), (0.0, -0.6))
    for offset in ("turning", "along-z"):
        exact, found = (
            of(violations(ROBOT, layout(), one, 0.03), "singularity")[0]
            for one in (replace(turning, offset=offset), sampled(replace(turning, offset=offset), 0.25))
        )
        assert found.from_s == pytest.approx(exact.from_s, abs=1e-6)


SAMPLES = "t_s, x_m, z_m, alpha_deg\n0, 0, 0.15, 0\n1, 0, 0.16, 2\n2, 0, 0.17, 4\n3, 0, 0.18, 6\n"


def test_samples_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "lift.csv"
    for text in (SAMPLES, "\ufeff" + SAMPLES.replace("\n", "\r\n")):
        path.write_bytes(text.encode())
        motion = load_motion(path)
        assert (motion.name, motion.duration, motion.offset) == ("lift", 3.0, "turning")
        state = states(motion, 1.5, 0.0)
        assert state.pose == pytest.approx([0.0, 0.165, math.radians(3.0)])
        assert state.velocity == pytest.approx([0.0, 0.01, math.radians(2.0)])
        assert state.beta == pytest.approx([0.0, 0.0, 0.0])
    assert violations(ROBOT, layout(), motion, 0.0) == []


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "columns none"),
        (SAMPLES.replace("z_m", "y_m"), "columns t_s, x_m, y_m"),
        (SAMPLES.replace("alpha_deg", "x_m"), "columns t_s, x_m, z_m, x_m"),
        (SAMPLES.replace("0.16", "nan"), "line 3 z_m"),
        (SAMPLES.replace("0.16", "high"), "line 3 z_m: 'high'"),
        (SAMPLES.replace("0.16", "1e300"), "line 3 z_m"),
        (SAMPLES.replace("0.16, 2", "0.16"), "line 3: 3 cells"),
        (SAMPLES.replace("\n2,", "\n1,"), "line 4 t_s: 1 s after 1 s"),
        (SAMPLES.replace("\n2,", "\n0.5,"), "line 4 t_s: 0.5 s after 1 s"),
        (SAMPLES.replace("\n0,", "\n0.1,"), "line 2 t_s"),
        (SAMPLES.rsplit("3,", 1)[0], "3 samples"),
        ("t_s, x_m, z_m\n", "0 samples"),
        ('t_s, x_m, z_m\n0, 0, "0.15\n', "end of data"),
        ("\x00,\xff", "motion"),
        ("a" * 500_000, "motion"),
    ],
)
def test_files_that_are_no_samples(tmp_path: Path, text: str, named: str) -> None:
    path = tmp_path / "motion.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=named) as refused:
        load_motion(path)
    assert "\n" not in str(refused.value)


def test_missing_files_and_moments_outside() -> None:
    with pytest.raises(InputError, match="eq27"):
        load_motion("eq28")
    for time in (-1e-9, 10.1, math.nan):
        with pytest.raises(InputError, match="within the motion"):
            limb_states(layout(), eq27(), time, 0.0)


def test_the_equations_convention_moves_other_limbs() -> None:
    here = limb_states(layout(), eq27(), 5.0, 0.1)[0]
    there = limb_states(Layout(layout().lengths, "equations"), eq27(), 5.0, 0.1)[0]
    assert here[0] == there[0]
    assert abs(here[1] - there[1]) > 1e-3
