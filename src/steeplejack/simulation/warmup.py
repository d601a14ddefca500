"""Compile every kernel once and keep it on disk: run a small instance of each."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from steeplejack.design import summarise, tension_map
from steeplejack.planning import Request, Rules, Scene, plan, verdicts
from steeplejack.robots.squad import Bay, load_squad
from steeplejack.robots.squad.planar import PlanarSquad, planar_attachments
from steeplejack.simulation.session import Session
from steeplejack.worksite import Bridge, PlanarSite, load_worksite


class _Enough(Exception):
    """The run has gone far enough to have compiled everything."""


def warm() -> None:
    """Map, solve, plan and fly a few metres, so that every kernel is compiled into its cache."""
    squad = load_squad()
    site = load_worksite("table-iii")
    if isinstance(site, PlanarSite):
        summarise(tension_map(site.anchors, planar_attachments(squad), 0.9, 0.05))
        robot = PlanarSquad.of(squad, site.anchors)
        robot.tensions((-0.1, 0.45, 0.87), 8.0, (10.0, 250.0), site.gravity)
        robot.pose(robot.lengths((-0.1, 0.45, 0.87)))
    bridge = load_worksite("ecs620-like")
    if isinstance(bridge, Bridge):
        _fly(bridge)


def _fly(bridge: Bridge) -> None:
    squad = load_squad()
    bay = Bay.of(bridge.fan("T1L-main"), 5, 7, "under", squad)
    rules = Rules(tension=(20.0, 250.0))
    request = Request(bridge.name, squad.name, "T1L-main", (5, 7), 30.0, 33.0, "under", 0.0, rules.tension)
    mission = plan(Scene.of(bay, squad, rules, np.array(bridge.gravity)), request, (), lambda _done: None)

    def stop(time: float) -> None:
        if time > 0.2:
            raise _Enough

    with tempfile.TemporaryDirectory() as folder:
        try:
            Session(mission, bridge, bay, squad, verdicts(bridge, squad)).run(Path(folder) / "run.mcap", False, stop)
        except _Enough:
            return
