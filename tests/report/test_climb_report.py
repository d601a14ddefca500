"""The report of a climb from a log made by hand: figures, pictures, film, and how it ended."""

from __future__ import annotations

import dataclasses
import io
import re
from base64 import b64decode
from pathlib import Path

import msgspec
import numpy as np
import pytest
from PIL import Image

from steeplejack.errors import InputError
from steeplejack.report.climb import film_of, is_climb, read_climb, summarise, write_climb_report
from steeplejack.report.climb import page as pages
from steeplejack.report.climb.analysis import Least
from steeplejack.robots.pipe_climber import load_pipe_climber
from steeplejack.runtime.climb_record import (
    ClimbSample,
    EndRecord,
    GripRecord,
    PhaseRecord,
    PlanRecord,
    RunRecord,
    SolidRecord,
)
from steeplejack.runtime.recorder import Picture, Recorder

ROBOT = load_pipe_climber()
LOW, HIGH = (0.0, 0.15, 0.0, 0.0), (0.0, 0.20, 0.0, 0.0)
END = EndRecord(True, True, "", 6.0, 0.05, 0, 0, 0)


def phase(kind: str, hold: str, duration: float, start: tuple[float, ...], end: tuple[float, ...]) -> PhaseRecord:
    return PhaseRecord(kind, hold, duration, start, end, 0.05, 0.2, 0.0, "main", "main", "up")  # pyright: ignore


PHASES = (
    phase("move", "lower", 3.0, LOW, HIGH), phase("grip-upper", "lower", 0.05, HIGH, HIGH),
    phase("move", "upper", 2.9, HIGH, LOW), phase("grip-lower", "upper", 0.05, LOW, LOW),
)  # fmt: skip


def sample(time: float) -> ClimbSample:
    share = min(time / 6.0, 1.0)
    up = time < 3.0
    w = 0.15 + 0.05 * (time / 3.0 if up else 2.0 - time / 3.0)
    at = (0.0, w, 0.0, 0.0)
    closing = abs(time - 3.0) < 1e-6
    margins = (0.05, None) if closing else (0.2, None) if up else (None, 0.15)
    return ClimbSample(
        time_s=time, phase=0 if up else 2, act="close" if closing else "move", closed=(up, not up),
        reference=at, actual=at, lengths_m=(w, w, w), speeds_m_s=(0.017, 0.017, 0.017),
        forces_n=(4.0, 4.0, -1.0), max_force_n=5.0, grip_n=(40.0 * up, 40.0 * (not up)), margin=margins,
        slip_m=(0.0, 0.0), lower_m=(0.0, 0.0, 0.05), upper_m=(0.0, 0.0, 0.05 + w), travelled_m=0.05 * share,
        energy_j=share, collisions=0,
    )  # fmt: skip


def picture(form: str) -> Picture:
    stream = io.BytesIO()
    Image.new("RGB", (8, 8), (10, 20, 30)).save(stream, form.upper())
    return Picture({"sec": 1, "nsec": 0}, f"a {form}", stream.getvalue(), form)


def logged(path: Path, end: EndRecord | None = END, pictures: tuple[Picture, ...] = (), film: bool = False) -> Path:
    """A climb of one stroke."""
    recorder = Recorder(path)
    solids = (SolidRecord("pipe", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.03),)
    recorder.write(
        "/run", RunRecord("r<1>", "a pipe", "test", (0.0, 0.0, -9.81), (0.3, 0.3), solids, "0", 0.25, 7), 0.0
    )
    recorder.write("/robot", ROBOT, 0.0)
    recorder.write("/plan", PlanRecord(PHASES, 6.0, 0.05, True, None), 0.0)
    for time in np.arange(0.0, 6.01, 0.1):
        recorder.write("/climb", sample(float(time)), float(time))
    recorder.write("/grip", GripRecord(3.1, 1, "upper", 2e-4, 1e-3, 3e-4, 40.0), 3.1)
    recorder.write("/grip", GripRecord(6.0, 3, "lower", 4e-4, 5e-4, 3e-4, 40.0), 6.0)
    for one in pictures:
        recorder.write("/camera", one, 1.0)
    if film:
        recorder.write("/film", picture("webp"), 6.0)
    if end is not None:
        recorder.write("/end", end, 6.0)
    recorder.close()
    return path


def test_figures_are_those_of_the_log(tmp_path: Path) -> None:
    log = read_climb(logged(tmp_path / "a.mcap"))
    found = summarise(log)
    assert found.summary.distance_m == pytest.approx(0.05) and found.summary.steps == 1
    assert found.summary.mean_speed_mm_s == pytest.approx(50.0 / 6.0)
    assert found.summary.max_actuator_force_n == 5.0
    assert found.summary.min_friction_margin == 0.05 and found.summary.min_friction_margin_moving == 0.15
    assert found.least == Least(0.05, pytest.approx(3.0), 0, "close")
    assert found.least_moving == Least(0.15, pytest.approx(3.1), 1, "move")
    assert found.largest_error == (4e-4, 1e-3)
    cylinders, grip = ROBOT.cylinders, ROBOT.gripper.close_time
    assert found.bound == pytest.approx(cylinders.stroke / (2 * cylinders.stroke / cylinders.speed + 4 * grip))


def test_the_page_is_whole_and_fetches_nothing(tmp_path: Path) -> None:
    log, page = logged(tmp_path / "a.mcap", pictures=(picture("jpeg"),), film=True), tmp_path / "a.html"
    write_climb_report(log, page)
    text = page.read_text()
    assert "r&lt;1&gt;" in text and "r<1>" not in text
    assert "0.25 kg on the upper gripper" in text and "with errors, seed 7" in text and "Climbed to the goal" in text
    assert len(re.findall(r"<img ", text)) == 2
    assert not re.search(r"(src|href)=\"(?!data:|#)", text)
    shown = [b64decode(data) for data in re.findall(r"data:image/webp;base64,([^\"]+)", text)]
    assert shown == [film_of(log)]
    assert is_climb(log)


def test_a_climb_that_slid_back_has_no_speed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    without_figures(monkeypatch)
    log = read_climb(logged(tmp_path / "a.mcap"))
    slid = dataclasses.replace(
        log, samples=dataclasses.replace(log.samples, travelled=-log.samples.travelled), grips=()
    )
    found = summarise(slid)
    assert found.summary.distance_m == pytest.approx(-0.05) and found.summary.mean_speed_mm_s == 0.0
    text = pages.climb_page(slid, found)
    assert (
        "slid back" in text and "nothing climbed" in text and "no gripper closed" in text and "\u2013\u00b0" not in text
    )


def test_the_page_tells_the_friction_of_physics_from_the_plan_s(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    without_figures(monkeypatch)
    log = read_climb(logged(tmp_path / "a.mcap"))
    other = dataclasses.replace(log, run=msgspec.structs.replace(log.run, friction=(0.2, 0.2)))
    assert "planned for" not in pages.climb_page(log, summarise(log))
    assert "0.2 in physics, planned for 0.3" in pages.climb_page(other, summarise(other))


def without_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawing takes seconds, and one test has looked at it."""
    for name in ("progress_figure", "loads_figure", "mechanism_figure"):
        monkeypatch.setattr(pages, name, lambda *_: "")


@pytest.mark.parametrize(
    ("end", "said"),
    [
        (None, "breaks off"),
        (msgspec.structs.replace(END, completed=False, why="lower gripper slips"), "ended early: lower gripper slips"),
        (msgspec.structs.replace(END, completed=False, safe=False, why="a cylinder lags"), "not at rest"),
        (msgspec.structs.replace(END, slips=2, regrips=1), "Slips: 2"),
    ],
)
def test_the_page_says_how_it_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, end: EndRecord | None, said: str
) -> None:
    without_figures(monkeypatch)
    page = tmp_path / "a.html"
    write_climb_report(logged(tmp_path / "a.mcap", end), page)
    assert said in page.read_text()


def test_without_pictures_the_page_says_so_and_there_is_no_film(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    without_figures(monkeypatch)
    log, page = logged(tmp_path / "a.mcap"), tmp_path / "a.html"
    write_climb_report(log, page)
    assert "no pictures" in page.read_text() and film_of(log) is None


def test_a_log_without_samples_is_refused(tmp_path: Path) -> None:
    Recorder(tmp_path / "b.mcap").close()
    with pytest.raises(InputError, match="no samples"):
        read_climb(tmp_path / "b.mcap")
