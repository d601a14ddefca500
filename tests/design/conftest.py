"""Reference values of the planar machine, with their provenance."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest


@pytest.fixture(scope="session")
def reference() -> dict[str, Any]:
    """Content of tests/reference/squad_table_iii.toml."""
    return tomllib.loads((Path(__file__).parents[1] / "reference" / "squad_table_iii.toml").read_text())


@pytest.fixture
def rng() -> np.random.Generator:
    """A generator with a fixed seed."""
    return np.random.default_rng(20260)
