"""Continuity along paths: a step that does not shrink when its piece of path is halved is a jump."""

from __future__ import annotations

import numpy as np
import pytest
from published_robots import COGIRO, GRAVITY, IPANEMA_2, PLANAR_4_4, rotations
from tension_questions import drawn

from steeplejack.mechanics.cable import METHODS, distribute, planar_structure_matrix, spatial_structure_matrix

pytestmark = pytest.mark.long

NODES = 500
HALVINGS = 25
ROOM = 1e-3  # [1] margin below which a path is not followed: there the feasible set itself may vanish


class Mixed:
    """From one random question to another; rows, loads and windows all change."""

    def __init__(self, rng, n, m):
        self.ends = [(array[0], array[1]) for array in drawn(rng, n, m, 2, outside=-10.0)]

    def __call__(self, share):
        """Structures, wrenches, lower and upper at shares of the path (k,)."""
        return [a + np.expand_dims(share, tuple(range(1, a.ndim + 1))) * (b - a) for a, b in self.ends]


class Flight:
    """A published robot under gravity on a curved path, turning."""

    def __init__(self, robot, rng):
        self.robot, self.phase = robot, rng.uniform(0.0, 2.0 * np.pi, (robot.low.size, 2))

    def __call__(self, share):
        """Structures, wrenches, lower and upper at shares of the path (k,)."""
        robot = self.robot
        angle = 2.0 * np.pi * share[:, None, None] * [1.0, 2.0] + self.phase
        middle, half = 0.5 * (robot.low + robot.high), 0.5 * (robot.high - robot.low)
        pose = middle + half * (np.sin(angle) * [0.5, 0.25]).sum(axis=-1)
        force = robot.mass * GRAVITY
        if robot.dimension == 2:
            structures = planar_structure_matrix(robot.anchors, robot.attachments, pose)
            wrench = np.array([0.0, -force, 0.0])
        else:
            turned = rotations(pose[:, 3:] * np.array([0.3, -0.8, 0.5]))
            structures = spatial_structure_matrix(robot.anchors, robot.attachments, pose[:, :3], turned)
            wrench = np.array([0.0, 0.0, 0.0, 0.0, 0.0, -force])
        shape = (len(share), len(robot.anchors))
        return [structures, np.tile(wrench, (len(share), 1)), *(np.full(shape, bound) for bound in robot.window)]


class Closed(Mixed):
    """Four cables at ease with each other: the null vector stays positive, so the whole line grows with pretension."""

    def __init__(self, rng):
        super().__init__(rng, 3, 4)
        closed = []
        for null in rng.uniform(0.3, 1.0, (2, 4)):
            turned = np.linalg.svd(null[None])[2][1:]
            closed.append(turned * np.sign(np.linalg.det(np.vstack((turned, null)))))
        self.ends[0] = tuple(closed)

    def __call__(self, share):
        """Structures, wrenches, lower and upper at shares of the path (k,)."""
        structures, wrenches, lower, upper = super().__call__(share)
        null = np.stack([np.linalg.svd(matrix)[2][-1] for matrix in structures])
        assert (np.abs(np.sign(null).sum(axis=-1)) == 4.0).all()
        return structures, wrenches, lower, upper


def paths(rng):
    for robot in (PLANAR_4_4, IPANEMA_2, COGIRO):
        yield from (Flight(robot, rng) for _ in range(3))
    for n, m in ((3, 4), (3, 5), (6, 8), (6, 9)):
        yield from (Mixed(rng, n, m) for _ in range(12))


def largest_jump(path, method):
    """Change of tension that stays when the steepest pieces of a path are halved again and again, over the window."""
    low = np.linspace(0.0, 1.0, NODES + 1)[:-1]
    high = low + 1.0 / NODES
    ends = [_answer(path, share, method) for share in (low, high)]
    followed = np.isfinite(ends[0]).all(axis=-1) & np.isfinite(ends[1]).all(axis=-1)
    change = np.where(followed, np.abs(ends[1] - ends[0]).max(axis=-1), 0.0)
    steep = np.argsort(change)[-10:]
    low, high, first, last = low[steep], high[steep], ends[0][steep], ends[1][steep]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        tensions = _answer(path, middle, method)
        before = np.abs(tensions - first).max(axis=-1) > np.abs(last - tensions).max(axis=-1)
        low, high = np.where(before, low, middle), np.where(before, middle, high)
        first, last = (np.where(before[:, None], kept, new) for kept, new in ((first, tensions), (tensions, last)))
    left = np.abs(last - first).max(axis=-1)
    return left[np.isfinite(left)].max(initial=0.0)


def _answer(path, share, method):
    """Tensions over the widest window; not a number where the margin is too small to follow."""
    asked = path(share)
    answer = distribute(*asked, method)
    window = (asked[3] - asked[2]).max(axis=-1, keepdims=True)
    return np.where(answer.margin[:, None] > ROOM, answer.tensions / window, np.nan)


def jumps(method):
    """Largest jump on every path the method takes."""
    most = METHODS[method].most_redundancy
    for path in paths(np.random.default_rng(5)):
        n, m = path(np.zeros(1))[0].shape[1:]
        if most is None or m - n <= most:
            yield largest_jump(path, method)


@pytest.mark.parametrize("method", [name for name, record in METHODS.items() if record.continuous])
def test_methods_that_claim_continuity_do_not_jump(method):
    assert max(jumps(method)) < 1e-5


@pytest.mark.parametrize("method", [name for name, record in METHODS.items() if not record.continuous])
def test_methods_that_do_not_are_seen_to_jump(method):
    assert any(jump > 0.01 for jump in jumps(method))


@pytest.mark.parametrize("method", ["min-max", "max-margin", "lp"])
def test_with_one_cable_too_many_and_in_wrench_closure_no_method_jumps(method):
    for seed in range(5):
        assert largest_jump(Closed(np.random.default_rng(seed)), method) < 1e-5
