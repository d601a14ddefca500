"""Stances: the closed form of the inner problem against HiGHS, and the search against differential evolution, one run.

Run ``python benchmarks/stances.py`` for a table, with ``--json`` for one JSON object.
"""

from __future__ import annotations

import argparse
import json
import time

import numpy as np
from scipy.optimize import differential_evolution, linprog

from steeplejack.design.stances import Statics, choose_stance, straight
from steeplejack.design.stances.inner import least_scale

STANCES = 200


def inner() -> dict[str, float]:
    """Time of one slip margin in the closed form and by linear program [us], and their largest difference [1]."""
    rng = np.random.default_rng(0)
    columns = rng.normal(size=(STANCES, 4, 3))
    loads = -np.einsum("nmk,nm->nk", columns, rng.uniform(20.0, 200.0, (STANCES, 4)))[:, None]
    lower, cap, scale = np.full(4, 10.0), np.full(4, 400.0), np.full(4, 245.25)
    least_scale(columns[0], False, loads[0], lower, cap, scale)
    began = time.perf_counter()
    ours = [least_scale(u, False, w, lower, cap, scale) for u, w in zip(columns, loads, strict=True)]
    middle = time.perf_counter()
    theirs = [
        linprog(
            [0.0] * 4 + [1.0],
            A_ub=np.column_stack([np.eye(4), -scale]),
            b_ub=np.zeros(4),
            A_eq=np.column_stack([u.T, np.zeros(3)]),
            b_eq=-w[0],
            bounds=[(10.0, 400.0)] * 4 + [(0.0, None)],
        ).fun
        for u, w in zip(columns, loads, strict=True)
    ]
    ended = time.perf_counter()
    apart = max(abs(a - b) for a, b in zip(ours, theirs, strict=True))
    each = 1e6 / STANCES
    return {"closed_form_us": each * (middle - began), "highs_us": each * (ended - middle), "largest_difference": apart}


def outer() -> dict[str, float]:
    """Margin and time [s] of the search and of differential evolution at one place, four bases free within 20 m."""
    along, across = np.array([np.cos(0.6), np.sin(0.6)]), np.array([np.sin(0.6), -np.cos(0.6)])
    lower = np.array([np.zeros(2), 20.0 * across, 20.0 * across, np.zeros(2)])
    ground = straight(lower, lower + 120.0 * along, (10.0, 400.0), 245.25, spacing=0.6)
    place, weight, now = 60.0 * along + 7.0 * across, [0.0, -294.3], np.array([50.0, 50.0, 70.0, 70.0])

    def worst(s: np.ndarray) -> float:
        worth = choose_stance(ground, place, weight, s, 0.0, Statics.POINT).worth
        return -worth if np.isfinite(worth) else 10.0

    worst(now)
    began = time.perf_counter()
    ours = choose_stance(ground, place, weight, now, 20.0, Statics.POINT).worth
    middle = time.perf_counter()
    theirs = differential_evolution(worst, [(s - 20.0, s + 20.0) for s in now], seed=0, maxiter=60, polish=False)
    ended = time.perf_counter()
    return {
        "search_margin": ours,
        "search_s": middle - began,
        "evolution_margin": -float(theirs.fun),
        "evolution_s": ended - middle,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    figures = inner() | outer()
    if parser.parse_args().json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f"{name:<20}{value:.6g}")


if __name__ == "__main__":
    main()
