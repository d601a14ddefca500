"""A small planned mission whose legs the runtime follows."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.planning import Mission, Request, Rules, Scene, plan
from steeplejack.robots.squad import Bay, Squad
from steeplejack.worksite import Bridge


@pytest.fixture(scope="session")
def mission(bridge: Bridge, squad: Squad, bay: Bay) -> Mission:
    """Two cells on one interior stay: inspection, flights, braces and the drives of a squad move."""
    rules = Rules(tension=(20.0, 250.0))
    asked = Request(bridge.name, squad.name, "T1L-main", (5, 7), 30.0, 50.0, "under", 0.0, rules.tension)
    return plan(Scene.of(bay, squad, rules, np.array(bridge.gravity)), asked, (), lambda _done: None)
