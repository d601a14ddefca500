"""Python in the documentation runs as it stands, block after block of a page, and prints what the page says."""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
PAGES = (
    "wrench-closure.md",
    pytest.param("workspaces.md", marks=pytest.mark.long),
    pytest.param("cable-robots.md", marks=pytest.mark.long),
    pytest.param("anchors-along-a-path.md", marks=pytest.mark.long),
    "anchors.md",
    pytest.param("climbing.md", marks=pytest.mark.long),
    pytest.param("equilibria.md", marks=pytest.mark.long),
    "grasps.md",
    "interference.md",
    "mobility.md",
    "pipe-climber.md",
    "quality.md",
    pytest.param("stances.md", marks=pytest.mark.long),
)


@pytest.mark.parametrize("page", PAGES)
def test_page(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(
        r"^```python\n(.*?)^```(?:\n\n```text\n(.*?)^```)?", (DOCS / page).read_text(), flags=re.MULTILINE | re.DOTALL
    )
    assert blocks
    known: dict[str, object] = {}
    for block, printed in blocks:
        if "models/" not in block:  # a folder of the reader's own
            exec(compile(block, page, "exec"), known)
            out = capsys.readouterr().out
            assert not printed or out == printed
