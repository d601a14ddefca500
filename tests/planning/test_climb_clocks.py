"""Clocks worth standing at, and what turns take on their way: against every clock asked for itself."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from climb_cases import ROBOT, changed

from steeplejack.planning.climb.clocks import CELLS, near_clocks, wanted_clocks
from steeplejack.planning.climb.collide import meets
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.solids import AIR, obstacles_of
from steeplejack.planning.climb.turns import APART, swing, turns_of
from steeplejack.robots.pipe_climber.bars import mechanism_bars
from steeplejack.worksite.pipe_builtin import load_pipe
from steeplejack.worksite.pipe_run import PipeObstacle, PipeRun

MACHINE = Machine.of(ROBOT)
CELL = 2.0 * math.pi / CELLS


def lug(height: float, middle: float, width: float) -> PipeRun:
    """A vertical pipe with something on part of its clock, middle and width in degrees."""
    clock = (math.radians(middle - 0.5 * width), math.radians(middle + 0.5 * width))
    return replace(load_pipe("straight-vertical"), obstacles=(PipeObstacle("main", 0.5, 0.507, height, clock, "lug"),))


def passes(run: PipeRun, clocks: np.ndarray) -> np.ndarray:
    """Whether all of the mechanism goes past what stands on a pipe at a clock, every millimetre asked for."""
    gap = MACHINE.straight_gaps[1]
    s = 0.5035 - np.arange(-0.06, gap + 0.06, 0.001)
    points, frames = run.pipes[0].centre_line(s)
    bars, radii = mechanism_bars(ROBOT, MACHINE.layout, np.array([[0.0, gap, 0.0]] * len(s)))
    every = np.broadcast_to(clocks, (len(s), len(clocks)))
    return ~meets(obstacles_of(run), points, frames, every, bars, radii, AIR).any(axis=0)


@pytest.mark.parametrize("middle", [-72.3, 0.0, 107.0, 179.0])
def test_ends_of_ranges_in_which_the_mechanism_passes_are_clocks(middle: float):
    """Clear themselves, blocked a few cells further, and what the linkage reaches from them besides."""
    run = lug(0.018, middle, 60.0)
    clocks = wanted_clocks(run, MACHINE)
    fine = CELL * np.arange(CELLS)
    free = passes(run, fine)
    assert free.any() and not free.all()
    ends = fine[free & ~(np.roll(free, 1) & np.roll(free, -1))]
    for end in ends:
        apart = np.abs((clocks - end + math.pi) % (2.0 * math.pi) - math.pi)
        nearest = clocks[apart <= 2.5 * CELL]
        assert passes(run, nearest).any()
        reached = [
            np.abs((clocks - one - turn + math.pi) % (2.0 * math.pi) - math.pi).min()
            for one in nearest
            for turn in (-ROBOT.rcm.limit, ROBOT.rcm.limit)
        ]
        assert sorted(reached)[1] < 1e-9


def test_what_the_mechanism_passes_anywhere_or_nowhere_gives_no_clocks():
    low, all_round = lug(0.0121, 30.0, 10.0), lug(0.06, 30.0, 350.0)
    assert passes(low, CELL * np.arange(CELLS)).all() and not passes(all_round, CELL * np.arange(CELLS)).any()
    for run in (low, all_round):
        assert len(wanted_clocks(run, MACHINE)) <= 12  # steps of 30 degrees, the palm's edges none


@pytest.mark.parametrize("limit", [30.0, 50.0])
def test_turns_take_what_sampling_them_says(limit: float, rng: np.random.Generator):
    """Loads that turn, in several places: a fixed part and one that goes round, either gripper turning."""
    limit = math.radians(limit)
    clocks = np.sort(rng.uniform(0.0, 2.0 * math.pi, 14))
    near = near_clocks(clocks, limit)
    turns = turns_of(clocks, near)
    lean = rng.uniform(0.0, 2.0 * math.pi, 3)

    def judge(which: np.ndarray, high: np.ndarray, low: np.ndarray) -> np.ndarray:
        held = np.stack((np.abs(np.cos(2.0 * high - low - lean[which])), np.abs(np.cos(high - 2.0 * low))), axis=-1)
        moved = np.stack((0.05 * np.cos(high - low), 0.05 * np.sin(high + low)), axis=-1)
        return np.stack((0.9 * held + moved, 0.5 * held, 0.5 * held), axis=-1)

    which = rng.integers(0, 3, len(turns.gripper))
    rows = np.arange(len(which))
    high, low = turns.clocks.T
    ends = [judge(which, high + t * turns.by[:, 0], low + t * turns.by[:, 1]) for t in (0.0, 1.0)]
    taken = np.stack([one[rows, turns.gripper].max(axis=-1) for one in ends], axis=-1)
    found, scarce = swing(turns, which, taken, judge, 1e9, limit)
    sampled = np.max(
        [
            judge(which, high + t * turns.by[:, 0], low + t * turns.by[:, 1])[rows, turns.gripper].max(axis=-1)
            for t in np.linspace(0.0, 1.0, 61)
        ],
        axis=0,
    )
    most = taken.max(axis=1)
    looked_at = most <= 1.0
    assert looked_at.sum() > 20 and (found[~looked_at] == 1.0).all()
    np.testing.assert_allclose((found * most)[looked_at], sampled[looked_at], rtol=0.0, atol=2.0 * APART**2)
    assert (found[looked_at] > 1.001).any() and scarce <= {"grip", "force", "servo"}


def test_a_robot_that_stands_on_no_straight_has_no_such_clocks():
    """One cylinder is longer than its limb's hinges ever need, another too short to reach."""
    cylinders = ROBOT.cylinders
    odd = changed(ROBOT, "cylinders", retracted=(cylinders.reach[0], cylinders.reach[1] - 0.01, 0.12), stroke=0.01)
    machine = Machine.of(odd)
    assert machine.straight_gaps[1] < machine.straight_gaps[0]
    assert len(wanted_clocks(lug(0.018, 0.0, 60.0), machine)) <= 14


def test_a_linkage_that_hardly_turns_gives_no_steps():
    stiff = Machine.of(changed(ROBOT, "rcm", limit=math.radians(2.0)))
    run = load_pipe("around")
    assert len(wanted_clocks(run, stiff)) < len(wanted_clocks(run, MACHINE))
