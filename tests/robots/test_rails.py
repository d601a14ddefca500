"""Tabulated stays: the tables against a straight line, and against the catenaries they stand for."""

from __future__ import annotations

import numpy as np

from steeplejack.robots.squad import Bay, Squad
from steeplejack.robots.squad.anchorage import exits
from steeplejack.robots.squad.rails import RAIL_STEP, tabulate, winch_exits


def test_winch_exits_follow_the_tables() -> None:
    s = np.arange(30.0)
    table = np.zeros((4, 30, 12))
    table[..., 0], table[..., 3], table[..., 8], table[..., 10] = s, 1.0, 1.0, -1.0
    points, tangents = winch_exits(table, 1.0, 0.2, np.array([3.25, 7.0, 10.5, 28.9]), np.array([0, 0.5, 1, 2.0]))
    assert np.allclose(points[:, 0], [3.25, 7.0, 10.5, 28.9])
    assert np.allclose(points[:, 2], 0.2 * np.cos([0, 0.5, 1, 2.0]))
    assert np.allclose(points[:, 1], -0.2 * np.sin([0, 0.5, 1, 2.0]))
    assert np.allclose(tangents, [1.0, 0.0, 0.0])


def test_tables_stand_for_the_stays(bay: Bay, squad: Squad, rng: np.random.Generator) -> None:
    rails = tabulate(bay)
    for _ in range(50):
        s, clock = rng.uniform(0.0, bay.reach, 4), rng.uniform(-np.pi, np.pi, 4)
        points, tangents = winch_exits(rails, RAIL_STEP, squad.base.exit_offset, s, clock)
        wanted, along, _arms = exits(bay, squad, s, clock)
        np.testing.assert_allclose(points, wanted, atol=5e-5)
        np.testing.assert_allclose(tangents, along, atol=1e-6)
