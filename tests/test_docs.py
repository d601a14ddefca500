"""Python in the documentation runs as it stands, block after block of a page."""

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
    "grasps.md",
    "interference.md",
    "mobility.md",
    "quality.md",
    pytest.param("stances.md", marks=pytest.mark.long),
)


@pytest.mark.parametrize("page", PAGES)
def test_page(page: str) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", (DOCS / page).read_text(), flags=re.MULTILINE | re.DOTALL)
    assert blocks
    known: dict[str, object] = {}
    for block in blocks:
        if "models/" not in block:  # a folder of the reader's own
            exec(compile(block, page, "exec"), known)
