"""Runs of pipes: the built-in ones, their geometry against finite differences, and files good and bad."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.worksite.pipe_builtin import PIPES, list_pipes, load_pipe
from steeplejack.worksite.pipe_file import decode_pipes
from steeplejack.worksite.pipe_generate import encode_pipes, random_pipes
from steeplejack.worksite.pipe_run import build_run, place_with_bends, with_bends, with_end

DOCS = Path(__file__).parents[2] / "docs"
GOOD = """kind = "pipes"
name = "n"
description = "d"
source = "s"
start = { s = 0.05, clock_deg = 30.0 }
goal = { s = 0.6 }
[main]
diameter = 0.06
[[main.parts]]
kind = "straight"
length = 0.4
[[main.parts]]
kind = "bend"
radius = 0.3
angle_deg = 90.0
toward_deg = 30.0
diameter = 0.055
[[main.parts]]
kind = "straight"
length = 0.5
[[obstacles]]
start = 0.1
end = 0.11
height = 0.02
clock_deg = [-30.0, 30.0]
note = "lug"
[[crossings]]
name = "rail"
at = 0.2
angle_deg = 60.0
toward_deg = 40.0
diameter = 0.05
before = 0.1
after = 0.2
"""


def run_of(text: str, where: str = "file"):
    return build_run(decode_pipes(text.encode(errors="surrogateescape"), where), where)


def test_built_in_runs_are_listed_and_loaded():
    assert tuple(row.name for row in list_pipes()) == PIPES
    for name in PIPES:
        run = load_pipe(name)
        assert run.name == name
        assert run.description and run.source
        assert run.gravity == (0.0, 0.0, -9.81)


def test_tangent_and_frame_follow_the_centre_line():
    run = run_of(GOOD)
    s = np.linspace(0.01, run.pipes[0].length - 0.01, 301)
    h = 1e-6
    ahead, behind = run.centre_line(s + h)[0], run.centre_line(s - h)[0]
    frames = run.centre_line(s)[1]
    np.testing.assert_allclose((ahead - behind) / (2.0 * h), frames[..., 2], atol=1e-5)
    np.testing.assert_allclose(
        frames @ np.swapaxes(frames, -1, -2), np.broadcast_to(np.eye(3), frames.shape), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1.0)
    tangents, curvatures = np.moveaxis(run.pipes[0].lines(s), -2, 0)
    np.testing.assert_array_equal(tangents, frames[..., 2])
    # No twist: the frame's rate of turn has no part along the tangent.
    rate = (run.centre_line(s + h)[1] - run.centre_line(s - h)[1]) / (2.0 * h)
    np.testing.assert_allclose(np.einsum("kij,kij->k", np.stack((rate[..., 0],), -1), frames[..., 1:2]), 0.0, atol=1e-6)
    apart = np.abs(s[:, None] - [part.end for part in run.pipes[0].parts]).min(axis=1) > h
    np.testing.assert_allclose(curvatures[apart], rate[apart, :, 2], atol=1e-6)


def test_a_bend_ends_where_its_circle_does():
    run = load_pipe("bend-300")
    point, frame = run.centre_line(0.35 + 0.3 * math.pi / 2)
    np.testing.assert_allclose(point, [0.3, 0.0, 0.65], atol=1e-12)
    np.testing.assert_allclose(frame[:, 2], [1.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(frame[:, 1], [0.0, 1.0, 0.0], atol=1e-12)


def test_diameters_and_crossings():
    run = run_of(GOOD)
    np.testing.assert_allclose(run.radius([0.1, 0.5, 1.0]), [0.03, 0.0275, 0.0275])
    rail, crossing = run.pipe("rail"), run.crossings[0]
    np.testing.assert_allclose(rail.centre_line(0.1)[0], run.centre_line(0.2)[0], atol=1e-12)
    across, along = rail.centre_line(0.1)[1][:, 2], run.centre_line(0.2)[1]
    assert math.degrees(math.acos(across @ along[:, 2])) == pytest.approx(60.0)
    aside = along.T @ across
    assert math.degrees(math.atan2(aside[1], aside[0])) == pytest.approx(40.0)
    assert crossing.through


def test_wider_bends_and_a_longer_end_keep_the_rest():
    run = run_of(GOOD)
    wide = with_bends(run, 2.0)
    assert wide.pipes[0].parts[1].radius == pytest.approx(0.6)
    assert wide.goal_s == pytest.approx(0.4 + 2.0 * (run.goal_s - 0.4))
    assert (wide.start_s, wide.obstacles) == (run.start_s, run.obstacles)
    assert place_with_bends(wide, 0.5, wide.goal_s) == pytest.approx(run.goal_s)
    assert with_end(run, 0.5).pipes[0].length == pytest.approx(run.pipes[0].length + 0.5)


def test_a_pipe_that_crosses_behind_a_bend_goes_along_when_it_gets_wider():
    run = run_of(GOOD.replace("at = 0.2", "at = 1.0"))
    wide = with_bends(run, 3.0)
    assert wide.crossings[0].at == pytest.approx(1.0 + 2.0 * 0.3 * math.pi / 2)
    seen = []
    for one in (run, wide):
        crossing, rail = one.crossings[0], one.pipes[1]
        (point, frame), (end, axes) = one.centre_line(crossing.at), rail.centre_line(np.array([0.0, 0.3]))
        np.testing.assert_allclose(rail.centre_line(crossing.at_other)[0], point, atol=1e-12)
        seen.append((frame.T @ (end - point).T, frame.T @ axes[0]))
    for before, after in zip(*seen, strict=True):
        np.testing.assert_allclose(after, before, atol=1e-12)


def test_random_runs_are_read_back_as_written(tmp_path: Path):
    for seed in range(40):
        file = random_pipes(np.random.default_rng(seed))
        assert file == random_pipes(np.random.default_rng(seed))
        assert decode_pipes(encode_pipes(file).encode(), "again") == file
        (tmp_path / "run.toml").write_text(encode_pipes(file))
        assert load_pipe(tmp_path / "run.toml").goal_s == file.goal.s


@pytest.mark.parametrize(("text", "said"), [
    ("", "an empty file"),
    ("kind = ", "Invalid"),
    ("\udcff", "decode"),
    (GOOD.replace("pipes", "bridge", 1), "kind"),
    (GOOD + "colour = 1\n", "$.crossings[0]"),
    (GOOD.replace("radius = 0.3", "radius = -0.3"), "$.main.parts[1].radius"),
    (GOOD.replace("radius = 0.3", "radius = 0.02"), "main.parts[1].radius: 0.02 m"),
    (GOOD.replace("angle_deg = 90.0", "angle_deg = 270.0"), "$.main.parts[1].angle_deg"),
    (GOOD.replace("length = 0.4", "length = inf"), "$.main.parts[0].length"),
    (GOOD.replace("length = 0.4", "length = 4e4"), "over 1 km"),
    (GOOD.replace('"straight"', '"stairs"', 1), "$.main.parts[0]"),
    (GOOD.replace("[main]\n", "[main]\ndirection = [0.0, 0.0, 0.0]\n"), "main.direction: no length"),
    (GOOD.replace("[main]\n", "[main]\nx_axis = [0.0, 0.0, 2.0]\n"), "main.x_axis"),
    (GOOD.replace("goal = { s = 0.6 }", "goal = { s = 0.01 }"), "goal.s: 0.01 m; beyond the start"),
    (GOOD.replace("goal = { s = 0.6 }", "goal = { s = 9.0 }"), "goal.s: 9 m; on the pipe"),
    (GOOD.replace("goal = { s = 0.6 }", 'goal = { s = 0.6, pipe = "x" }'), "goal.pipe: no pipe 'x'"),
    (GOOD.replace("s = 0.05", "s = 5.0"), "start.s: 5 m"),
    (GOOD.replace("end = 0.11", "end = 0.09"), "obstacles[0]: from 0.1 to 0.09 m"),
    (GOOD.replace("[-30.0, 30.0]", "[30.0, -30.0]"), "obstacles[0].clock_deg"),
    (GOOD.replace("height = 0.02", 'height = 0.02\npipe = "y"'), "obstacles[0].pipe: no pipe 'y'"),
    (GOOD.replace("at = 0.2", "at = 0.5"), "crossings[0].at: 0.5 m, in a bend"),
    (GOOD.replace("at = 0.2", "at = 7.0"), "crossings[0].at: 7 m"),
    (GOOD.replace('name = "rail"', 'name = "main"'), "crossings[0].name: 'main' stands twice"),
    (GOOD.replace("height = 0.02", "height = nan"), "obstacles[0].height"),
    (GOOD.replace("height = 0.02", "height = 1e9"), "$.obstacles[0].height"),
    (GOOD.replace("diameter = 0.06", "diameter = 1e22"), "$.main.diameter"),
    (GOOD.replace("length = 0.4", "length = 5e-324"), "$.main.parts[0].length"),
    (GOOD.replace("[main]\n", "[main]\ndirection = [1e200, 0.0, 1e200]\n"), "$.main.direction[0]"),
    (GOOD.replace("[main]\n", "[main]\npoint = [1e300, 0.0, 0.0]\n"), "$.main.point[0]"),
    ("gravity = [0.0, 0.0, -1e300]\n" + GOOD, "$.gravity[2]"),
    ("gravity = [0.0, nan, 0.0]\n" + GOOD, "gravity[1]"),
    (GOOD.replace("clock_deg = 30.0", "clock_deg = 1e300"), "$.start.clock_deg"),
    (GOOD.replace("[-30.0, 30.0]", "[-180.0, 180.0]"), "obstacles[0].clock_deg: -180 to 180; rising by less than 360"),
    (GOOD.replace("[-30.0, 30.0]", "[-30.0, 30.0, 60.0]"), "$.obstacles[0].clock_deg"),
    (GOOD.replace("angle_deg = 60.0", "angle_deg = 1e-300"), "$.crossings[0].angle_deg"),
    (GOOD.replace("before = 0.1", "before = inf"), "crossings[0].before"),
    (GOOD.replace('name = "rail"', 'name = "ra\\nil"'), "$.crossings[0].name"),
    (GOOD.replace("s = 0.6 }", 's = 0.6, pipe = "' + 9999 * "x" + '" }'), "$.goal.pipe"),
    (GOOD.replace("s = 0.05", "s = 1979-05-27"), "$.start.s"),
    (GOOD.replace("s = 0.05", "s = true"), "$.start.s"),
    (GOOD.replace("diameter = 0.06\n", 'diameter = "0.06"\n'), "$.main.diameter"),
    (GOOD + 'name = "rail"\n', "overwrite"),
    (GOOD.split("[[obstacles]]")[0] + 201 * "[[main.parts]]\nkind = 'straight'\nlength = 0.1\n", "$.main.parts"),
    (GOOD.replace("diameter = 0.06\n", "diameter = 60\n"), "`float` <= 10.0, got 60 - at `$.main.diameter`"),
    (GOOD.replace("radius = 0.3", "radius = nan"), "got nan - at `$.main.parts[1].radius`"),
    (GOOD.replace("at = 0.2", "at = -0.2"), "got -0.2 - at `$.crossings[0].at`"),
    (GOOD.replace('name = "n"', 'name = ""'), "got '' - at `$.name`"),
    (GOOD.replace('name = "n"', 'name = "' + 5000 * "n" + '"'), "nnn ... nnn"),
    (GOOD.replace("s = 0.05", "s = 0.05, at = 0"), "unknown field `at` - at `$.start`"),
    (GOOD.replace("goal = { s = 0.6 }", "goal = 0.6"), "got `float` - at `$.goal`"),
    (GOOD.replace('name = "n"\n', ""), "missing required field `name`"),
    (GOOD.split("[[main.parts]]")[0] + "parts = []\n", "got 0 - at `$.main.parts`"),
    ("\0\0" + GOOD, "Invalid"),
    ("a = " + 100000 * "[", "recursion"),
])  # fmt: skip
def test_a_bad_file_is_refused_in_one_line(text, said):
    with pytest.raises(InputError) as error:
        run_of(text)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_what_the_schema_refuses_names_a_file_to_open():
    with pytest.raises(InputError) as error:
        run_of(GOOD.replace("radius = 0.3", "radius = true"))
    path = next(word for word in str(error.value).split() if word.endswith(".toml"))
    assert load_pipe(path).name == "bend-300"
    assert "docs/climbing.md" in str(error.value) and (DOCS / "climbing.md").is_file()


def test_the_example_of_the_docs_is_a_run_with_every_field():
    block = re.search(r"^```toml\n(.*?)^```", (DOCS / "climbing.md").read_text(), flags=re.MULTILINE | re.DOTALL)
    assert block
    file = decode_pipes(block[1].encode(), "docs")
    for entry in (file, file.main, file.start, file.goal, *file.main.parts, *file.obstacles, *file.crossings):
        for name in entry.__struct_fields__:
            assert re.search(rf"\b{name}\b", block[1]), name
    run = build_run(file, "docs")
    assert run.crossings[0].through and not run.crossings[1].through
    assert [part.straight for part in run.pipes[0].parts] == [True, False, True]
    assert {one.clock is None for one in run.obstacles} == {True, False}
    np.testing.assert_allclose(run.centre_line(0.0)[1][:, 2], np.array([0.1, 0.0, 1.0]) / math.hypot(0.1, 1.0))


def test_files_broken_anywhere_give_one_line_or_a_run():
    rng = np.random.default_rng(5)
    original = GOOD.encode()
    for _ in range(400):
        content = bytearray(original)
        for _ in range(int(rng.integers(1, 4))):
            at = int(rng.integers(len(content)))
            how = int(rng.integers(3))
            if how == 0:
                content[at] = int(rng.integers(256))
            elif how == 1:
                del content[at : at + int(rng.integers(1, 30))]
            else:
                content[at:at] = rng.choice([b"-", b"9", b"e9", b"nan", b'"', b"[", b"\n", b"inf"])
        try:
            build_run(decode_pipes(bytes(content), "fuzzed"), "fuzzed")
        except InputError as error:
            assert "\n" not in str(error)


@pytest.mark.parametrize("name", ["bend", "", "none.toml", "run.csv"])
def test_unknown_names_are_refused_with_the_names(name):
    with pytest.raises(InputError, match="straight-vertical"):
        load_pipe(name)


def test_a_chord_touches_the_centre_line_at_both_ends():
    """Of a bend: half a chord to either side, in by its sagitta; of a straight: the centre line itself."""
    run = load_pipe("bend-300")
    pipe, half = run.pipes[0], 0.03
    s = np.array([0.2, 0.36, 0.5, 0.34])
    points, frames = pipe.chord(s, half)
    ends = [pipe.centre_line(s + side * half)[0] for side in (-1.0, 1.0)]
    np.testing.assert_allclose(points, 0.5 * (ends[0] + ends[1]), atol=1e-15)
    along = ends[1] - ends[0]
    np.testing.assert_allclose(frames[..., 2], along / np.linalg.norm(along, axis=-1, keepdims=True), atol=1e-12)
    np.testing.assert_allclose(frames @ np.swapaxes(frames, -1, -2), np.broadcast_to(np.eye(3), (4, 3, 3)), atol=1e-12)
    sagitta = np.linalg.norm(points - pipe.centre_line(s)[0], axis=-1)
    np.testing.assert_allclose(sagitta[[0, 2]], [0.0, 0.3 * (1.0 - math.cos(half / 0.3))], atol=1e-12)
    np.testing.assert_allclose(pipe.chord(s, 0.0)[1], pipe.centre_line(s)[1])
