"""Five thousand robots nobody would build: every answer about their poses is right, or says why there is none."""

from __future__ import annotations

import numpy as np
import oracles
import pytest
from one_pose import assert_consistent
from published_robots import rotations

from steeplejack.mechanics.cable import (
    ClosureStatus,
    distribute,
    planar_structure_matrix,
    spatial_structure_matrix,
    tension_factor,
)

pytestmark = pytest.mark.long

COUNT = 500
SHAPES = [(n, m) for n in (3, 6) for m in range(n, n + 5)]
CHECKED = 40
"""Robots of each shape that are put to a linear program, and to rational arithmetic where that is close."""

WHOLE, SAME_ANCHOR, SAME_CABLE, MEETING, LENGTHLESS, NO_NUMBER, ENDLESS = range(7)


def drawn(rng, n, m):
    """Structure matrices, wrenches, windows and what was done to each robot; lengths and forces over 18 decades."""
    d = 2 if n == 3 else 3
    length, force = 10.0 ** rng.uniform(-9.0, 9.0, (2, COUNT))
    anchors, arms = rng.uniform(-1.0, 1.0, (COUNT, m, d)), 0.3 * rng.uniform(-1.0, 1.0, (COUNT, m, d))
    what = np.where(rng.uniform(size=COUNT) < 0.5, WHOLE, rng.integers(1, 7, COUNT))
    anchors[what == SAME_ANCHOR, 1] = anchors[what == SAME_ANCHOR, 0]
    anchors[what == SAME_CABLE, 1] = anchors[what == SAME_CABLE, 0]
    arms[what == SAME_CABLE, 1] = arms[what == SAME_CABLE, 0]
    arms[what == MEETING] = 0.2 * anchors[what == MEETING]
    place, turn = rng.uniform(-0.3, 0.3, (COUNT, d)), rng.uniform(-1.0, 1.0, (COUNT, 3))
    place[what == MEETING] = 0.0
    turn[what == MEETING] = 0.0
    matrices = rotations(turn)[:, :d, :d] if d == 3 else rotations(turn * [0.0, 0.0, 1.0])[:, :2, :2]
    ends = place[:, None] + np.einsum("kij,kmj->kmi", matrices, arms)
    anchors[what == LENGTHLESS, 0] = ends[what == LENGTHLESS, 0]
    anchors[what == NO_NUMBER, 0, 0] = np.nan
    anchors[what == ENDLESS, 0, 0] = np.inf
    structures = np.empty((COUNT, n, m))
    for k, (unit, roots, local) in enumerate(zip(length, anchors, arms, strict=True)):
        if d == 2:
            pose = [*(unit * place[k]), turn[k, 2]]
            structures[k] = planar_structure_matrix(unit * roots, unit * local, pose)
        else:
            structures[k] = spatial_structure_matrix(unit * roots, unit * local, unit * place[k], matrices[k])
    lower = rng.uniform(0.0, 1.0, (COUNT, m))
    upper = lower + rng.uniform(0.5, 5.0, (COUNT, m))
    inside = lower + rng.uniform(-0.2, 1.2, (COUNT, m)) * (upper - lower)
    wrenches = -np.einsum("kij,kj->ki", structures, inside)
    wrenches = np.where(np.isfinite(wrenches), wrenches, 0.0)
    return structures, force[:, None] * wrenches, force[:, None] * lower, force[:, None] * upper, what


@pytest.mark.parametrize(("n", "m"), SHAPES)
def test_fuzzed_robots_are_judged_rightly_and_alike(n, m, rng):
    structures, wrenches, lower, upper, what = drawn(rng, n, m)
    status = assert_consistent(structures, wrenches, lower, upper)
    nowhere = np.isin(what, (LENGTHLESS, NO_NUMBER, ENDLESS))
    np.testing.assert_array_equal(status == ClosureStatus.UNDEFINED, nowhere)
    assert (status[what == MEETING] == ClosureStatus.SINGULAR).all()
    if m == n:
        assert (status[what == SAME_CABLE] == ClosureStatus.SINGULAR).all()
    clean = np.flatnonzero(np.isin(status, (ClosureStatus.INSIDE, ClosureStatus.OUTSIDE)))[:CHECKED]
    assert clean.size == CHECKED
    factors = tension_factor(structures)
    feasible = distribute(structures, wrenches, lower, upper, "qp").feasible
    for k in clean:
        assert (factors[k] > 0.0) == closes(structures[k])
        asked = structures[k], wrenches[k], lower[k], upper[k]
        assert feasible[k] == holds(*asked)


def closes(structure):
    """Wrench closure by linear program, or exactly where that is close."""
    margin = oracles.closure_margin(structure)
    return margin > 0.0 if abs(margin) > oracles.BAND else oracles.closes_exactly(structure)


def holds(structure, wrench, lower, upper):
    """Feasibility by linear program, or exactly where that is close; in windows of one newton."""
    unit = upper.max()
    asked = structure, wrench / unit, lower / unit, upper / unit
    if structure.shape[0] == structure.shape[1]:
        size = np.abs(structure).max(axis=1)
        tensions = -np.linalg.solve(structure / size[:, None], wrench / unit / size)
        return bool(((tensions >= asked[2] - 1e-9) & (tensions <= asked[3] + 1e-9)).all())
    margin = oracles.window_margin(*asked)
    return margin > 0.0 if abs(margin) > oracles.BAND else oracles.holds_exactly(*asked)
