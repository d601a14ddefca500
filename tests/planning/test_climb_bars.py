"""Bars against pipes and obstacles: distances by brute force, and tables over clocks against one clock at a time."""

from __future__ import annotations

import math

import numpy as np
import pytest
from climb_cases import ROBOT

from steeplejack.planning.climb.around import blocked_clocks
from steeplejack.planning.climb.collide import meets
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.solids import AIR, obstacles_of
from steeplejack.robots.pipe_climber.bars import inner_radius, linkage_bars, mechanism_bars
from steeplejack.worksite.pipe_builtin import load_pipe
from steeplejack.worksite.pipe_run import PipeRun

MACHINE = Machine.of(ROBOT)


def cloud(run: PipeRun, spacing: float = 1.5e-3) -> np.ndarray:
    """Points all over pipes and obstacles."""
    out = []
    for pipe in run.pipes:
        s = np.arange(0.0, pipe.length, spacing)
        for clock in np.arange(0.0, 2.0 * math.pi, spacing / 0.03):
            out.append(on(run, pipe.name, s, clock, pipe.radius(s)))
    for one in run.obstacles:
        first, last = one.clock if one.clock is not None else (-math.pi, math.pi)
        s = np.linspace(one.start, one.end, 7)
        for clock in np.linspace(first, last, max(2, int((last - first) * 0.05 / spacing))):
            for reach in np.linspace(0.03, 0.03 + one.height, 14):
                out.append(on(run, one.pipe, s, float(clock), np.full(7, reach)))
    return np.concatenate(out)


def on(run: PipeRun, pipe: str, s: np.ndarray, clock: float, reach: np.ndarray) -> np.ndarray:
    points, frames = run.centre_line(s, pipe)
    return points + reach[:, None] * (math.cos(clock) * frames[..., 0] + math.sin(clock) * frames[..., 1])


def distance(points: np.ndarray, bar: np.ndarray) -> float:
    way = bar[1] - bar[0]
    share = np.clip((points - bar[0]) @ way / (way @ way), 0.0, 1.0)
    return float(np.linalg.norm(points - bar[0] - share[:, None] * way, axis=1).min())


@pytest.mark.parametrize("name", ["clock-obstacle", "bend-300", "planar-cross", "flange"])
def test_meeting_is_being_nearer_than_radius_and_air(name: str, rng: np.random.Generator):
    run = load_pipe(name)
    solids, points = obstacles_of(run), cloud(run)
    checked = 0
    for _ in range(60):
        middle = points[rng.integers(len(points))] + rng.normal(0.0, 0.05, 3)
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        bar = rng.uniform(-0.06, 0.06, (1, 1, 2, 3))
        ends = bar[0, 0] @ turn.T + middle
        gap = distance(points, ends) - 0.008
        if abs(gap - AIR) < 2e-3:  # closer than the brute force is fine
            continue
        inside = any(np.linalg.norm(p - run.centre_line(s)[0]) < 0.03 for s in (0.35,) for p in ends)
        found = meets(solids, middle[None], turn[None], np.zeros((1, 1)), bar, np.array([0.008]), AIR)[0, 0]
        if not inside and gap > 0.0:
            assert found == (gap < AIR)
            checked += 1
    assert checked > 20


def test_a_table_of_clocks_is_one_clock_at_a_time():
    run = load_pipe("around")
    solids, s = obstacles_of(run), np.array([0.15, 0.2, 0.26, 0.33, 0.407, 0.41])
    points, frames = run.pipes[0].chord(s, MACHINE.row)
    poses = np.column_stack((np.zeros(6), np.linspace(0.15, 0.2, 6), np.zeros(6)))
    clocks = np.broadcast_to(2.0 * math.pi * np.arange(48) / 48, (6, 48))
    ring = np.repeat(linkage_bars(ROBOT, 0.5)[0], 6, axis=0)
    for bars, radii in (mechanism_bars(ROBOT, MACHINE.layout, poses), (ring, linkage_bars(ROBOT, 0.5)[1])):
        table = blocked_clocks(solids, points, frames, bars, radii, AIR, 48)
        one = meets(solids, points, frames, clocks, bars, radii, AIR)
        assert table.any() and not table.all()
        assert (table != one).mean() < 0.02  # cells whose edge falls between two samples of a bar


def test_on_a_straight_nothing_low_is_met():
    run = load_pipe("flange")
    assert run.obstacles[0].height + 0.03 <= inner_radius(ROBOT) - AIR + 1e-9
    points, frames = run.pipes[0].chord(np.linspace(0.1, 0.5, 41), MACHINE.row)
    poses = np.tile([0.0, 0.17, 0.0], (41, 1))
    clocks = np.broadcast_to(np.linspace(0.0, 6.0, 13), (41, 13))
    bars, radii = mechanism_bars(ROBOT, MACHINE.layout, poses)
    assert not meets(obstacles_of(run), points, frames, clocks, bars, radii, AIR - 1e-6).any()
