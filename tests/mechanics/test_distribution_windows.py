"""Windows that differ by a billion: every bound is as hard as its own numbers make it, against linear programs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog
from tension_questions import balanced_by

from steeplejack.mechanics.cable import METHODS, DistributionStatus, certificate_gap, distribute, wrench_feasible

pytestmark = pytest.mark.long

BAND = 1e-3  # [N] excess below which the solver's own rounding may decide; the narrow windows are 1 N wide or more
SHAPES = [(3, 4), (3, 5), (3, 6), (6, 7), (6, 8), (6, 9)]


def taken(n, m):
    """Complete methods that take so many cables."""
    return [
        name
        for name, record in METHODS.items()
        if record.complete and (record.most_redundancy is None or m - n <= record.most_redundancy)
    ]


def mixed(rng, n, m, count):
    """Random structures whose last one to m - n + 1 windows are a billion times wider than the others."""
    structures = rng.normal(size=(count, n, m))
    lower, window = rng.uniform(0.0, 2.0, (count, m)), rng.uniform(1.0, 3.0, (count, m))
    wide = np.arange(m) >= m - rng.integers(1, m - n + 2, (count, 1))
    inside = lower + rng.uniform(-0.4, 1.4, (count, m)) * window
    return structures, balanced_by(structures, inside), lower, lower + np.where(wide, 1e9, 1.0) * window


def least_excess(structure, wrench, lower, upper):
    """How far the worst tension must leave its window, by HiGHS; 0 where none must [N]."""
    m = lower.size
    program = linprog(
        np.append(np.zeros(m), 1.0),
        A_ub=np.column_stack((np.vstack((-np.eye(m), np.eye(m))), -np.ones(2 * m))),
        b_ub=np.concatenate((-lower, upper)),
        A_eq=np.column_stack((structure, np.zeros(wrench.size))),
        b_eq=-wrench,
        bounds=[(None, None)] * m + [(0.0, None)],
    )
    return program.fun


@pytest.mark.parametrize(("n", "m"), SHAPES)
def test_mixed_windows_agree_with_highs(n, m, rng):
    structures, wrenches, lower, upper = asked = mixed(rng, n, m, 150)
    worst = np.array([least_excess(*question) for question in zip(*asked, strict=True)])
    held, refused = worst == 0.0, worst > BAND
    assert min(np.count_nonzero(held), np.count_nonzero(refused)) > 10
    for name in taken(n, m):
        answer = distribute(*asked, name)
        assert answer.feasible[held].all()
        assert (answer.status[refused] == DistributionStatus.INFEASIBLE).all()
        assert (certificate_gap(answer.certificate, *asked)[refused] > 0.0).all()
        size = np.abs(answer.tensions).max(axis=-1, keepdims=True)
        allowed = 1e-8 + 1e-12 * size
        inside = (answer.tensions >= lower - allowed) & (answer.tensions <= upper + allowed)
        assert inside[answer.feasible].all()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("width", [1.0, 1e3, 1e6, 1e9])
def test_a_wide_window_makes_no_other_soft(method, width):
    structure = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0], [0.5, 0.5, -0.5, -0.5]])
    for load, feasible in ((-1.2, False), (-1.0 - 1e-6, False), (-1.0, True), (-0.8, True)):
        asked = structure, [0.0, load, 0.0], 0.0, [width, 1.0, 1.0, 1.0]
        answer = distribute(*asked, method)
        assert (answer.status != DistributionStatus.INFEASIBLE) == feasible
        assert wrench_feasible(structure, 0.0, asked[3], asked[1]).feasible == feasible
        if METHODS[method].complete:
            assert answer.feasible == feasible


def test_the_wide_window_itself_is_not_soft_either():
    structure = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, -1.0]])
    for tension, feasible in ((-0.1, False), (-1e-6, False), (0.0, True)):
        answer = distribute(structure, [-tension, 0.0], 0.0, [1e9, 1.0, 1.0], "qp")
        assert answer.feasible == feasible
