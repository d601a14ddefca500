"""What several rooms' tests share: reference values with their provenance, and a small bay with its machine."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from steeplejack.robots.squad import Bay, Squad, load_squad
from steeplejack.worksite import Bridge, load_worksite


@pytest.fixture(scope="session")
def reference() -> dict[str, Any]:
    """Content of tests/reference/squad_table_iii.toml."""
    return tomllib.loads((Path(__file__).parent / "reference" / "squad_table_iii.toml").read_text())


@pytest.fixture
def rng() -> np.random.Generator:
    """A generator with a fixed seed."""
    return np.random.default_rng(20260)


@pytest.fixture(scope="session")
def squad() -> Squad:
    return load_squad()


@pytest.fixture(scope="session")
def bridge() -> Bridge:
    site = load_worksite("ecs620-like")
    assert isinstance(site, Bridge)
    return site


@pytest.fixture(scope="session")
def bay(bridge: Bridge, squad: Squad) -> Bay:
    return Bay.of(bridge.fan("T1L-main"), 5, 7, "under", squad)
