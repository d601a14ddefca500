"""``climb`` with a load and with a film."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import Outcome
from PIL import Image
from test_climb import KEYS, SHORT

pytestmark = pytest.mark.long

Steeplejack = Callable[..., Outcome]


def test_a_load_beyond_the_grip_has_no_climb(steeplejack: Steeplejack, folder: Path) -> None:
    (folder / "short.toml").write_text(SHORT)
    done = steeplejack("climb", "short.toml", "--payload-kg", "0.6", "--no-pictures", "--out", "out", "--json")
    assert done.code == 3
    assert "friction" in done.answer["binding"] or "grip" in done.answer["binding"]
    assert not (folder / "out").exists()


@pytest.mark.parametrize("payload", ["-1", "nan"])
def test_a_load_that_is_none_is_refused(steeplejack: Steeplejack, folder: Path, payload: str) -> None:
    (folder / "short.toml").write_text(SHORT)
    done = steeplejack("climb", "short.toml", "--payload-kg", payload, "--json")
    assert done.code == 2 and "--payload-kg" in done.err and done.err.count("\n") == 1


def test_a_film_of_a_climb_with_a_load(steeplejack: Steeplejack, folder: Path) -> None:
    """The film is in the log, on the page and beside it; where OpenGL cannot draw there is none and nothing fails."""
    (folder / "short.toml").write_text(SHORT.replace("0.10", "0.06"))
    arguments = ("--payload-kg", "0.1", "--no-pictures", "--video", "--out", "out", "--json")
    done = steeplejack("climb", "short.toml", *arguments)
    assert done.code == 0
    assert set(done.answer) - {"video"} == KEYS
    if "video" in done.answer:
        with Image.open(folder / done.answer["video"]) as film:
            assert film.format == "WEBP" and getattr(film, "n_frames", 1) > 10
        assert "data:image/webp" in (folder / done.answer["report"]).read_text()
