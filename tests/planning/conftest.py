"""A small mission on real-sized stays, planned once, and what is needed to check it from outside the planner."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.planning import Mission, Request, Rules, Scene, plan
from steeplejack.robots.squad import Bay, Squad
from steeplejack.worksite import Bridge

WINDOW = (20.0, 250.0)


@pytest.fixture(scope="session")
def request_of_two_cells(bridge: Bridge, squad: Squad) -> Request:
    """One interior stay over 20 m: two cells of 10 m, so at least one move of the squad."""
    return Request(bridge.name, squad.name, "T1L-main", (5, 7), 30.0, 50.0, "under", 0.0, WINDOW)


@pytest.fixture(scope="session")
def mission(bridge: Bridge, squad: Squad, bay: Bay, request_of_two_cells: Request) -> Mission:
    scene = Scene.of(bay, squad, Rules(tension=WINDOW), np.array(bridge.gravity))
    return plan(scene, request_of_two_cells, ("diameter: as a test assumes",), lambda _done: None)
