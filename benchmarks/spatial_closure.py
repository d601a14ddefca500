"""Wrench closure of an eight-cable robot in space: this package against NumPy and an LP solver, one thread, one run.

Run ``python benchmarks/spatial_closure.py`` for a table, with ``--json`` for one JSON object. Every row answers for the
same random poses of IPAnema 2 (turned by up to 0.5 rad), structure matrices included. Contestants take turns, so that a
busy machine slows all alike, and the best time of each counts.

- ``map``: `spatial_closure_map`, which gives the tension factor, not only yes or no.
- ``matrices``: `tension_factor` of given structure matrices, these from NumPy.
- ``certificates``: `wrench_closure` of the same, with a separating wrench for every pose outside.
- ``numpy, null space``: null space by batched SVD, then whether its rows leave an open half plane; the best chunk.
- ``numpy, six columns``: the first six columns solved for the last two, without pivoting or any check of rank, then
  the interval of their ratio; the best chunk. The fastest NumPy found, and wrong where those six are dependent.
- ``numpy, factor``: the same with the tension factor from all 56 triples, the map's question; the best chunk.
- ``HiGHS``: the largest ``t`` with ``structure f = 0`` and ``t <= f <= 1``, on a sample.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import os
import time
from collections.abc import Callable

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np  # noqa: E402
from scipy.optimize import linprog  # noqa: E402

from steeplejack.mechanics.cable import (  # noqa: E402
    spatial_closure_map,
    spatial_structure_matrix,
    tension_factor,
    wrench_closure,
)
from steeplejack.robots.cable_robot import load_cable_robot  # noqa: E402

ROBOT = load_cable_robot("ipanema-2")
CHUNKS = (64, 256, 1024)
LP_POSES = 100
TRIPLES = np.array(list(itertools.combinations(range(8), 3))).T


def random_poses(count: int):
    """Positions in the frame and rotations about random axes by up to 0.5 rad."""
    rng = np.random.default_rng(0)
    positions = rng.uniform([-3.5, -2.7, 0.5], [3.5, 2.7, 4.5], (count, 3))
    axes = rng.normal(size=(count, 3))
    x, y, z = (axes / np.linalg.norm(axes, axis=1, keepdims=True)).T
    angle, zero = rng.uniform(-0.5, 0.5, count)[:, None, None], np.zeros(count)
    skew = np.stack((zero, -z, y, z, zero, -x, -y, x, zero), axis=-1).reshape(-1, 3, 3)
    return positions, np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew


def structures(positions, rotations):
    return spatial_structure_matrix(ROBOT.anchors, ROBOT.attachments, positions, rotations)


def by_null_space(matrices):
    rows = np.linalg.svd(matrices)[2][:, 6:]
    angles = np.sort(np.arctan2(rows[:, 1], rows[:, 0]), axis=1)
    gaps = np.diff(np.concatenate((angles, angles[:, :1] + 2.0 * np.pi), axis=1), axis=1)
    return gaps.max(axis=1) > np.pi


def six_columns(matrices):
    """Rows of the null space for the first six cables, and whether any ratio suits them all."""
    rows = -np.linalg.solve(matrices[:, :, :6], matrices[:, :, 6:])
    bound, rising = -rows[..., 0] / rows[..., 1], rows[..., 1] > 0.0
    low, high = np.where(rising, bound, 0.0).max(axis=1), np.where(rising, np.inf, bound).min(axis=1)
    return rows, np.maximum(low, 0.0) < high


def by_six_columns(matrices):
    return six_columns(matrices)[1]


def factor_by_six_columns(matrices):
    rows, inside = six_columns(matrices)
    x, y = np.concatenate((rows, np.broadcast_to(np.eye(2), (len(rows), 2, 2))), axis=1).transpose(2, 1, 0)
    turns = x[:, None] * y[None] - x[None] * y[:, None]
    i, j, k = TRIPLES
    ij, jk, ki = turns[i, j], turns[j, k], turns[k, i]
    net, size = np.abs(ij + jk + ki), np.abs(ij) + np.abs(jk) + np.abs(ki)
    return np.where(inside, ((size - net) / (size + net)).min(axis=0), 0.0)


def chunked(route, poses, chunk):
    """A route over all poses, chunk by chunk, structure matrices included."""
    parts = [route(structures(*(values[k : k + chunk] for values in poses))) for k in range(0, len(poses[0]), chunk)]
    return np.concatenate(parts)


def highs(poses):
    factors = []
    for matrix in structures(*(values[:LP_POSES] for values in poses)):
        answer = linprog(
            np.append(np.zeros(8), -1.0),
            A_ub=np.hstack((-np.eye(8), np.ones((8, 1)))),
            b_ub=np.zeros(8),
            A_eq=np.hstack((matrix, np.zeros((6, 1)))),
            b_eq=np.zeros(6),
            bounds=[(None, 1.0)] * 8 + [(None, None)],
        )
        factors.append(-answer.fun)
    return np.array(factors)


def race(contestants: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Best seconds of each, taking turns."""
    best = dict.fromkeys(contestants, math.inf)
    for _ in range(rounds):
        for name, run in contestants.items():
            began = time.perf_counter()
            run()
            best[name] = min(best[name], time.perf_counter() - began)
    return best


def check(poses) -> None:
    """Every route gives the same answer before any is timed."""
    factors = spatial_closure_map(ROBOT.anchors, ROBOT.attachments, *poses)
    for route in (by_null_space, by_six_columns):
        assert np.array_equal(chunked(route, poses, 1024), factors > 0.0)
    assert np.allclose(chunked(factor_by_six_columns, poses, 1024), factors, atol=1e-9)
    assert np.allclose(highs(poses), factors[:LP_POSES], atol=1e-6)


def measure(count: int, rounds: int) -> dict[str, object]:
    poses = random_poses(count)
    check(poses)
    routes = {
        "numpy, null space": by_null_space,
        "numpy, six columns": by_six_columns,
        "numpy, factor": factor_by_six_columns,
    }
    contestants: dict[str, Callable[[], object]] = {
        "map": lambda: spatial_closure_map(ROBOT.anchors, ROBOT.attachments, *poses),
        "matrices": lambda: tension_factor(structures(*poses)),
        "certificates": lambda: wrench_closure(structures(*poses)),
    }
    for name, route in routes.items():
        for chunk in CHUNKS:
            contestants[f"{name}, chunk {chunk}"] = lambda route=route, chunk=chunk: chunked(route, poses, chunk)
    rates: dict[str, float] = {}
    for name, seconds in race(contestants, rounds).items():
        route = name.partition(", chunk ")[0]
        rates[route] = max(rates.get(route, 0.0), count / seconds)
    rates["HiGHS"] = LP_POSES / race({"HiGHS": lambda: highs(poses)}, 3)["HiGHS"]
    return {
        "poses": count,
        "threads": 1,
        "poses_per_second": {name: round(rate) for name, rate in rates.items()},
        "ratios": {f"map_over_{name}": rates["map"] / rate for name, rate in rates.items()},
    }


def table(result: dict) -> str:
    rates = result["poses_per_second"]
    lines = ["| route | poses/s, one thread | map is |", "| --- | ---: | ---: |"]
    for route, rate in sorted(rates.items(), key=lambda item: -item[1]):
        lines.append(f"| {route} | {rate / 1e3:,.4g} k | {rates['map'] / rate:,.3g} x |")
    return "\n".join(lines)


def main() -> None:
    options = argparse.ArgumentParser(description="Spatial wrench closure against NumPy and HiGHS.")
    options.add_argument("--json", action="store_true", help="one JSON object instead of the table")
    options.add_argument("--poses", type=int, default=20000, help="random poses")
    options.add_argument("--rounds", type=int, default=7, help="turns of each route")
    given = options.parse_args()
    result = measure(given.poses, given.rounds)
    print(json.dumps(result) if given.json else table(result))


if __name__ == "__main__":
    main()
