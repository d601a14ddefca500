"""All questions of one batch of poses asked at once, and what their answers owe each other."""

from __future__ import annotations

import numpy as np

from steeplejack.mechanics.cable import (
    ClosureStatus,
    DistributionStatus,
    FeasibilityStatus,
    RankStatus,
    certificate_gap,
    distribute,
    in_wrench_closure,
    is_singular,
    null_space,
    tension_factor,
    tension_polygon,
    wrench_closure,
    wrench_feasible,
)

CLOSE = 1e-6  # share of a tension factor by which the tensions asked for are below or above it


def assert_consistent(structures, wrenches, lower, upper):
    """Ask everything about (k, n, m) matrices under (k, n) wrenches and (k, m) windows; the closure status (k,)."""
    n, m = structures.shape[1:]
    closure, held = wrench_closure(structures), wrench_feasible(structures, lower, upper, wrenches)
    singular, undefined = closure.status == ClosureStatus.SINGULAR, closure.status == ClosureStatus.UNDEFINED
    np.testing.assert_array_equal(held.status == FeasibilityStatus.SINGULAR, singular)
    np.testing.assert_array_equal(held.status == FeasibilityStatus.UNDEFINED, undefined)
    np.testing.assert_array_equal(is_singular(structures), singular | undefined)
    np.testing.assert_array_equal(in_wrench_closure(structures), closure.inside)
    np.testing.assert_allclose(tension_factor(structures), closure.factor, rtol=1e-6, atol=1e-9)
    if m >= n:
        rank = null_space(structures).status
        np.testing.assert_array_equal(rank == RankStatus.SINGULAR, singular)
        np.testing.assert_array_equal(rank == RankStatus.UNDEFINED, undefined)
        chosen = distribute(structures, wrenches, lower, upper, "min-norm")
        np.testing.assert_array_equal(chosen.status, held.status)
        assert (certificate_gap(chosen.certificate, structures, wrenches, lower, upper)[chosen.status == 1] > 0.0).all()
        np.testing.assert_array_equal(chosen.margin >= 0.0, chosen.feasible)
        assert_closure_is_distribution(structures, wrenches, closure)
    if m == n + 2:
        polygon = tension_polygon(structures, wrenches, lower, upper)
        np.testing.assert_array_equal(polygon.status, chosen.status)
        np.testing.assert_array_equal(polygon.count > 0, chosen.feasible)
    return closure.status


def assert_closure_is_distribution(structures, wrenches, closure):
    """Inside, all cables pull as evenly as the tension factor says and no more, and open windows hold any load."""
    here = np.flatnonzero(closure.inside)
    if not here.size:
        return
    matrices, factor = structures[here], closure.factor[here, None]
    nothing = np.zeros(structures.shape[1])
    assert distribute(matrices, nothing, (1.0 - CLOSE) * factor, 1.0, "min-norm").feasible.all()
    beyond = distribute(matrices, nothing, np.minimum((1.0 + CLOSE) * factor, 1.0), 1.0, "min-norm")
    assert (beyond.status == DistributionStatus.INFEASIBLE)[factor[:, 0] < 1.0 - 2.0 * CLOSE].all()
    loose = distribute(matrices, wrenches[here], 0.0, np.inf, "min-norm")
    assert loose.feasible.all()
    assert np.isposinf(loose.margin).all()
    assert wrench_feasible(matrices, 0.0, np.inf, wrenches[here]).feasible.all()
