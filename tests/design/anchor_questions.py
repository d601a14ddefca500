"""Questions the anchor tests share: the paper's case by movable anchors, and random robots that are not symmetric."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from steeplejack.design.anchors import Reconfiguration, eq28

DIRECTIONS = np.array([[1.0, -1.0], [1.0, -0.65213], [1.0, -0.65213], [1.0, -1.0]])


def table_iii(reference, movable, width=0.05) -> Reconfiguration:
    """Table III along Eq. 28, anchors numbered from 1 movable by a width either way."""
    table = reference["table_iii"]
    anchors = np.array(table["anchors"])
    directions = DIRECTIONS.copy()
    directions[1:3, 1] = (anchors[2, 1] - anchors[1, 1]) / (anchors[2, 0] - anchors[1, 0])
    windows = np.where(np.isin(np.arange(1, 5), movable)[:, None], [-width, width], 0.0)
    return Reconfiguration(anchors, directions, table["attachments"], windows, eq28())


def through_an_attachment(rng, problem, anchor, offset) -> Reconfiguration:
    """The same robot where an anchor at an offset is its own attachment, so that its stay passes through it."""
    phi = problem.poses[0, 2] + rng.normal(0.0, 0.1)
    turn = np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]])
    where = problem.placed(np.full(4, offset))[anchor] - turn @ problem.attachments[anchor]
    windows = problem.windows.copy()
    windows[anchor] = offset - 0.1, offset + 0.15
    return replace(problem, windows=windows, poses=[*where, phi])


def random_problem(rng, poses=3) -> Reconfiguration:
    """Anchors about a unit square on stays of any slope, windows off centre, one anchor in five fixed."""
    anchors = np.array([[0.0, 0.0], [1.0, 0.1], [0.9, 1.0], [-0.1, 0.8]]) + rng.normal(0.0, 0.2, (4, 2))
    corners = np.array([[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]) + rng.normal(0.0, 0.05, (4, 2))
    middle, half = rng.uniform(0.0, 0.2, 4), rng.uniform(0.0, 0.3, 4) * (rng.random(4) < 0.8)
    path = np.column_stack((rng.uniform(0.25, 0.75, (poses, 2)), rng.uniform(-0.4, 0.4, poses)))
    directions = np.stack((np.ones(4), rng.normal(0.0, 1.0, 4)), axis=1)
    return Reconfiguration(anchors, directions, corners, np.stack((middle - half, middle + half), axis=1), path)
