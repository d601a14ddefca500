"""The inner problem of a stance against linear programs: largest slip margin, least largest tension, capacity."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linprog

from steeplejack.design.stances.inner import capacity, least_scale
from steeplejack.mechanics.cable import capacity_margin

pytestmark = pytest.mark.long

Array = NDArray[np.float64]


def least_by_lp(columns: Array, size: int, loads: Array, lower: Array, cap: Array, scale: Array) -> float:
    """The least t by HiGHS, the worst over the loads."""
    m, worst = len(columns), 0.0
    for load in loads:
        answer = linprog(
            np.append(np.zeros(m), 1.0),
            A_ub=np.column_stack([np.eye(m), -scale]),
            b_ub=np.zeros(m),
            A_eq=np.column_stack([columns[:, :size].T, np.zeros(size)]),
            b_eq=-load[:size],
            bounds=[*zip(lower, cap, strict=True), (0.0, None)],
        )
        worst = max(worst, answer.fun if answer.status == 0 else np.inf)
    return worst


@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("vertices", [1, 3])
def test_least_scale_is_the_linear_programs(size: int, vertices: int) -> None:
    rng = np.random.default_rng(size + 10 * vertices)
    found = 0
    for _ in range(150):
        m = int(rng.integers(size, 7))
        columns = np.zeros((m, 3))
        columns[:, :size] = rng.normal(size=(m, size))
        lower = rng.uniform(0.0, 30.0, m)
        cap, scale = lower + rng.uniform(0.0, 300.0, m), rng.uniform(50.0, 400.0, m)
        loads = -(columns.T @ rng.uniform(0.0, 200.0, (m, vertices))).T
        loads[:, :size] += rng.normal(0.0, 5.0, (vertices, size))
        here = least_scale(columns, size == 2, loads, lower, cap, scale)
        there = least_by_lp(columns, size, loads, lower, cap, scale)
        assert np.isfinite(here) == np.isfinite(there)
        if np.isfinite(there):
            found += 1
            assert here == pytest.approx(there, abs=1e-8, rel=1e-8)
    assert 10 < found < 150


def test_capacity_is_the_margin_of_the_available_wrench_set() -> None:
    rng = np.random.default_rng(3)
    for _ in range(100):
        m = int(rng.integers(3, 7))
        columns, lower = rng.normal(size=(m, 3)), rng.uniform(0.0, 30.0, m)
        cap, load = lower + rng.uniform(1.0, 300.0, m), rng.normal(0.0, 100.0, 3)
        there = capacity_margin(columns.T, lower, cap, load)
        assert capacity(columns, False, load[None], lower, cap) == pytest.approx(float(there), abs=1e-7)


def test_dependent_cables_hold_nothing() -> None:
    """All cables in one plane, the load in it too: no facet bounds the forces, so the answer is a refusal."""
    columns = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.6, 0.8, 0.0], [0.6, 0.8, 0.0]])
    load, lower, cap = np.array([[0.0, -50.0, 0.0]]), np.full(4, 10.0), np.full(4, 200.0)
    assert least_scale(columns, False, load, lower, cap, cap) == np.inf
    assert capacity(columns, False, load, lower, cap) == -np.inf
    assert least_scale(columns, True, load, lower, cap, cap) < 1.0
    along = np.array([[1.0, 0.0, 0.0], [-2.0, 0.0, 0.0]])
    assert least_scale(along, True, load, lower[:2], cap[:2], cap[:2]) == np.inf


def test_least_tension_alone_sets_the_scale() -> None:
    """Two upright cables share 100 N; each may be slack down to 10 N, so the scale follows the weaker base."""
    columns = np.array([[0.0, 1.0, 0.0], [0.1, 1.0, 0.0], [-0.1, 1.0, 0.0]])
    t = least_scale(columns, True, np.array([[0.0, -100.0, 0.0]]), np.full(3, 10.0), np.full(3, 90.0), np.full(3, 50.0))
    assert t == pytest.approx(2.0 / 3.0)
    t = least_scale(columns, True, np.array([[0.0, -30.0, 0.0]]), np.full(3, 10.0), np.full(3, 90.0), np.full(3, 50.0))
    assert t == pytest.approx(0.2)
    assert (
        least_scale(columns, True, np.array([[0.0, -29.0, 0.0]]), np.full(3, 10.0), np.full(3, 90.0), np.full(3, 50.0))
        == np.inf
    )
