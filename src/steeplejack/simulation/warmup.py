"""Compile every kernel once and keep it on disk: run a small instance of each."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from steeplejack.design import summarise, tension_map
from steeplejack.design.anchors import (
    Duty,
    Reconfiguration,
    algorithm_2,
    anchor_path,
    anchors_along,
    eq28,
    optimal_anchors,
)
from steeplejack.design.climber import (
    PRESCRIBED,
    Comparison,
    design_plane,
    front,
    local_transmission,
    orientations,
    performance_chart,
    require_poses,
    transmission_map,
    workspace_cells,
)
from steeplejack.design.grasps import GraspQuestion, GraspRegion, best_grasp, grasp_front, grasp_on_grid
from steeplejack.planning import Request, Rules, Scene, plan, verdicts
from steeplejack.planning.climb import plan_climb
from steeplejack.robots.pipe_climber import Layout, load_pipe_climber
from steeplejack.robots.pipe_climber.forward import forward_kinematics
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.motion import eq27, limb_states
from steeplejack.robots.pipe_climber.singular_slice import singular_slice
from steeplejack.robots.pipe_climber.violations import violations
from steeplejack.robots.squad import Bay, Squad, load_squad
from steeplejack.robots.squad.planar import PlanarSquad, planar_attachments, stay_directions
from steeplejack.simulation.session import Session
from steeplejack.worksite import Bridge, PlanarSite, load_worksite
from steeplejack.worksite.pipe_builtin import load_pipe


class _Enough(Exception):
    """The run has gone far enough to have compiled everything."""


def warm() -> None:
    """Map, solve, place anchors, plan and fly a few metres, design a climber and plan its climb: every command once."""
    squad = load_squad()
    site = load_worksite("table-iii")
    if isinstance(site, PlanarSite):
        summarise(tension_map(site.anchors, planar_attachments(squad), 0.9, 0.05))
        robot = PlanarSquad.of(squad, site.anchors)
        robot.tensions((-0.1, 0.45, 0.87), 8.0, (10.0, 250.0), site.gravity)
        robot.pose(robot.lengths((-0.1, 0.45, 0.87)))
        _place_anchors(site, squad)
        _grasp(site, squad)
    bridge = load_worksite("ecs620-like")
    if isinstance(bridge, Bridge):
        _fly(bridge)
    _design_climber()
    plan_climb(load_pipe("straight-vertical"), load_pipe_climber())


def _place_anchors(site: PlanarSite, squad: Squad) -> None:
    """Anchors along two poses: exact and on a grid, with a price, and under a load."""
    along = stay_directions(site.anchors, site.stays)
    windows = np.tile([-0.02, 0.02], (4, 1))
    problem = Reconfiguration(site.anchors, along / along[:, :1], planar_attachments(squad), windows, eq28()[:2])
    anchor_path(problem, optimal_anchors(problem).offsets, Duty())
    algorithm_2(problem, 0.02)
    loaded = Duty("slip-margin", 8.0, (10.0, 250.0), site.gravity, squad.base.hold_force, squad.base.drive_force)
    for duty in (Duty(), loaded):
        anchors_along(problem, duty, 0.02, None, continuous=True)


def _grasp(site: PlanarSite, squad: Squad) -> None:
    """A grasp, by both methods, and the front."""
    slope, intercept = site.stays["3"]
    region = GraspRegion.eq19((-0.1, intercept - 0.1 * slope), (1.0, slope), 0.03, 0.05)
    question = GraspQuestion(site.anchors, planar_attachments(squad), 0.87, region)
    best_grasp(question)
    grasp_on_grid(question, 0.01, 0.1)
    grasp_front(question, np.array([0.0, 0.03]))


def _design_climber() -> None:
    """Positions, rates, singularities, workspace, transmission and dimensions of the pipe climber, coarsely."""
    machine = load_pipe_climber()
    layout = replace(Layout.of(machine), neutral="home")
    forward_kinematics(layout, limb_lengths(layout, layout.home))
    motion = eq27()
    limb_states(layout, motion, 5.0, 0.1)
    violations(machine, layout, motion, 0.1)
    singular_slice(layout, -0.5)
    require_poses(layout, 0.0)
    orientations(layout, 0.02)
    workspace_cells(layout, 0.0, 0.02)
    local_transmission(layout, layout.home)
    for region in (PRESCRIBED, None):
        transmission_map(layout, 0.01, rectangle=region)
        chart = performance_chart(design_plane(0.5), Comparison(region, step=0.01))
    front(chart, 0.01)


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
