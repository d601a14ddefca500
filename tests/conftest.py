"""What several rooms' tests share: reference values with their provenance, and a small bay with its machine."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from xdist.remote import Producer
from xdist.scheduler import LoadFileScheduling

from steeplejack.robots.squad import Bay, Squad, load_squad
from steeplejack.worksite import Bridge, load_worksite

SHARED = re.compile(r"tests/((control|planning|report|runtime|safety|simulation)/test_(?!climb)|robots/test_squad)")
"""Tests of the squad, which compile the same kernels."""


class Sharing(LoadFileScheduling):
    """Files stay with one worker, and so do all of the squad: two workers at once would compile the same kernels.

    Examples are programs of their own. They come last, and either worker takes the next.
    """

    def _split_scope(self, nodeid: str) -> str:
        if nodeid.startswith("tests/test_examples.py"):
            return nodeid
        return "squad" if SHARED.match(nodeid) else super()._split_scope(nodeid)


def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> Sharing:
    """What gives the workers of ``pytest -n`` their tests."""
    return Sharing(config, log)


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
