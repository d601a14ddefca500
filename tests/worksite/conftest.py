"""Published figures for the worksite, with their provenance."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="session")
def worksite_reference() -> dict[str, Any]:
    """Content of tests/reference/worksite.toml."""
    return tomllib.loads((Path(__file__).parents[1] / "reference" / "worksite.toml").read_text())
