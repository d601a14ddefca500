"""The page: self-contained, escaped, complete."""

from __future__ import annotations

import re
from html import escape
from html.parser import HTMLParser
from pathlib import Path

import msgspec
import numpy as np
import pytest
from small_run import FROM, SQUAD, TO, Run, png, write_run

from steeplejack.errors import InputError
from steeplejack.planning.mission import Uncovered
from steeplejack.report import Summary, analyse, read_log, write_report
from steeplejack.report.analysis import Spread
from steeplejack.report.figures.accuracy import path_figure
from steeplejack.report.figures.style import spells, thin
from steeplejack.report.html import Markup, element, table, text
from steeplejack.report.notation import between, clock, minutes, number, spread
from steeplejack.report.verdict import headline

EVIL = '<script>alert("1")</script>&$x_{\'"><img src=http://evil.example/x>'
REASON = 'twist <b>about</b> the stay of base 2 & "more"'
VOID = {"meta", "img", "br", "hr", "link", "input"}


class Reader(HTMLParser):
    """Checks that tags close in order and keeps every attribute."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.tags: set[str] = set()
        self.attributes: list[tuple[str, str]] = []
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep the tag open until its end."""
        self.tags.add(tag)
        self.attributes += [(name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """A tag that closes itself."""
        self.tags.add(tag)
        self.attributes += [(name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        """Tags close in order."""
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        """Text."""
        self.text.append(data)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Summary]:
    """A run with hostile names, a reason, a fault and pictures."""
    folder = tmp_path_factory.mktemp("page")
    reason = Uncovered(EVIL, 20.0, 26.0, REASON)
    run = Run(
        names=("B0", EVIL, "S2", "B3"),
        legs=(1, 2, 3),
        uncovered=(reason,),
        breach=EVIL,
        until=14.0,
        picture=png(),
        assumed=(f"diameter of {EVIL}",),
    )
    summary = write_report(write_run(folder / "run.mcap", run), folder / "report.html")
    return (folder / "report.html").read_text(encoding="utf-8"), summary


@pytest.fixture(scope="module")
def reader(page: tuple[str, Summary]) -> Reader:
    reader = Reader()
    reader.feed(page[0])
    reader.close()
    assert reader.open == []
    return reader


def test_nothing_is_fetched_from_outside(page: tuple[str, Summary], reader: Reader):
    html, _summary = page
    assert not re.search(r"""<[^<>]*\b(?:src|href|action|poster)\s*=\s*["']?\s*(?:https?:)?//""", html)
    assert not re.search(r"@import|url\(\s*['\"]?(?!#)", html)
    links = [value for name, value in reader.attributes if name in ("src", "href", "xlink:href")]
    assert links and all(link.startswith(("#", "data:image/")) for link in links)
    assert "default-src 'none'" in html


def test_no_scripts_and_no_event_handlers(reader: Reader):
    assert not reader.tags & {"script", "iframe", "object", "embed", "link", "base", "form"}
    assert not [name for name, _value in reader.attributes if name.startswith("on")]


def test_hostile_names_are_text(page: tuple[str, Summary], reader: Reader):
    html, _summary = page
    assert "<script" not in html and "<img src=http" not in html
    assert escape(EVIL, quote=True) in html
    assert EVIL in "".join(reader.text)


def test_every_uncovered_stretch_stands_in_the_page_with_its_reason(page: tuple[str, Summary], reader: Reader):
    _html, summary = page
    words = "".join(reader.text)
    assert len(summary.not_covered) >= 2
    assert {gap.stay for gap in summary.not_covered} == {EVIL, "S2"}
    for gap in summary.not_covered:
        assert f"{number(gap.from_m)}–{number(gap.to_m)} m: {gap.why}" in words
    assert REASON in words


def test_drawings_point_at_their_own_parts(page: tuple[str, Summary], reader: Reader):
    ids = [value for name, value in reader.attributes if name == "id"]
    assert len(ids) == len(set(ids))
    targets = set(re.findall(r"url\(#([^)]+)\)", page[0]))
    targets |= {value[1:] for name, value in reader.attributes if name == "xlink:href" and value.startswith("#")}
    assert targets <= set(ids)
    assert len(re.findall("<svg", page[0])) == 6


def test_the_page_says_what_matters(page: tuple[str, Summary], reader: Reader):
    words = " ".join(reader.text)
    for phrase in (
        "The run ended early",
        "Stay by stay",
        "Accuracy",
        "cable.axial_stiffness",
        "unknown",
        "far",
        "SHA-256",
    ):
        assert phrase in words
    assert len(page[0]) < 2_000_000


def test_the_same_log_gives_the_same_page(tmp_path: Path):
    log = write_run(tmp_path / "run.mcap")
    for name in ("a.html", "b.html"):
        write_report(log, tmp_path / name)
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def told(path: Path, run: Run) -> str:
    log = read_log(write_run(path / "run.mcap", run))
    return headline(log, analyse(log))


def test_the_headline_of_a_whole_run(tmp_path: Path):
    assert "Inspected: 12.0 m of 12.0 m asked for (100.0 %), and every limit held" in told(tmp_path, Run())


def test_the_headline_says_what_one_face_shows(tmp_path: Path):
    words = told(tmp_path, Run())
    assert re.search(r"Seen all round: \d\d\.\d %, about what one face can show\.", words)


def test_the_headline_names_where_physics_ran_another_machine(tmp_path: Path):
    assert "other than the file" not in told(tmp_path, Run())
    changed = {"friction": 6.0, "current_noise": 0.2}
    other = msgspec.structs.replace(SQUAD, winch=msgspec.structs.replace(SQUAD.winch, **changed))
    words = told(tmp_path, Run(actual=other))
    assert "Physics ran a machine other than the file: winch.friction, winch.current_noise." in words


def test_the_headline_of_a_partial_plan(tmp_path: Path):
    words = told(tmp_path, Run(legs=(0,), uncovered=(Uncovered("S2", FROM, TO, "slack"),)))
    assert "Partly inspected" in words and "1 stretch not covered" in words


def test_a_limit_that_did_not_hold_is_the_headline(tmp_path: Path):
    words = told(tmp_path, Run(margin=-0.02))
    assert "not every limit held" in words and "Not held: pull along the stays" in words


@pytest.fixture(scope="module")
def narrow(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One interior stay, flown along once."""
    return write_run(tmp_path_factory.mktemp("narrow") / "run.mcap", Run(names=("B0", "S1", "B2"), legs=(0,)))


def test_one_interior_stay_is_drawn_as_large_as_many(narrow: Path, tmp_path: Path):
    """In one scale both ways it would be a line of no height."""
    heights = [
        float(re.search(r'<svg[^>]* height="([\d.]+)pt"', path_figure(read_log(log)))[1])  # pyright: ignore
        for log in (narrow, write_run(tmp_path / "run.mcap"))
    ]
    assert heights[0] == pytest.approx(heights[1], rel=0.2)
    assert "across [m], to a larger scale" in path_figure(read_log(narrow))
    assert "to a larger scale" not in path_figure(read_log(tmp_path / "run.mcap"))


def test_words_for_one_of_a_thing(narrow: Path, tmp_path: Path):
    write_report(narrow, tmp_path / "report.html")
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Phases of the run: 1<" in html
    assert "0.60 <small>m</small>" in html
    assert "0.60–0.60" not in html


def test_a_run_that_inspected_nothing_still_has_a_report_and_strange_pictures_are_left_out(tmp_path: Path):
    run = Run(legs=(1, 2), picture=b"<svg onload=alert(1)>", picture_format="svg+xml")
    write_report(write_run(tmp_path / "run.mcap", run), tmp_path / "report.html")
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "ended before anything was inspected" in html
    assert "data:image/svg" not in html and "no pictures" in html


def test_a_bad_log_writes_nothing(tmp_path: Path):
    (tmp_path / "run.mcap").write_bytes(b"nonsense")
    with pytest.raises(InputError):
        write_report(tmp_path / "run.mcap", tmp_path / "report.html")
    assert not (tmp_path / "report.html").exists()


def test_thinning_keeps_every_extreme():
    rng = np.random.default_rng(0)
    x, y = np.arange(50_000.0), rng.normal(size=50_000)
    y[12_345], y[43_210] = 40.0, -40.0
    xs, ys = thin(x, y, 1000)
    assert len(xs) <= 1000 and np.all(np.diff(xs) > 0.0)
    assert (ys.max(), ys.min()) == (40.0, -40.0)
    short = thin(x[:10], y[:10])
    np.testing.assert_array_equal(short[1], y[:10])


def test_spells_are_runs_of_true():
    assert spells(np.array([True, True, False, True, False, True])) == [(0, 1), (3, 3), (5, 5)]
    assert spells(np.zeros(3, bool)) == []


def test_notation():
    assert (number(-0.01), spread(Spread(-0.01, 2.0)), spread(Spread(np.nan, np.nan))) == ("0.0", "+0.0 ± 2.0", "–")
    assert (between(0.548, 0.551, 2), between(-0.5, 0.62), between(np.nan, np.nan)) == ("0.55", "−0.5–0.6", "–")
    assert (number(-1.25), number(float("nan")), minutes(179.6), clock(59.96)) == ("−1.2", "–", "3 min 00 s", "1:00.0")


def test_text_is_escaped_once_and_markup_is_not():
    assert text("<&>") == "&lt;&amp;&gt;"
    assert element("p", "a<b", Markup("<i>c</i>"), cls='x"y') == '<p class="x&quot;y">a&lt;b<i>c</i></p>'
    assert '<td class="n">1</td>' in table(("a", "b"), [("<", 1)], numeric=(1,))
