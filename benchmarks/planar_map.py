"""Planar tension-factor map: this package against NumPy, an LP solver and the machine, one thread, one run.

Run ``python benchmarks/planar_map.py`` for a table, with ``--json`` for one JSON object. Every row maps Table III of
the CCRobot-S paper at 50 degrees over the same grid. Contestants take turns, so that a busy machine slows all alike,
and the best time of each counts.

- ``kernel``: `tension_factor_grid`, what the package calls for every map. All routes write to the same array.
- ``numpy, same algebra``: the kernel's formulas, line by line, in chunks of rows; the best chunk of several.
- ``numpy, same algebra, in place``: the same again with every temporary reused by hand.
- ``numpy, general functions``: structure matrix, cofactors and ratio of `closure`, in chunks; the best chunk.
- ``HiGHS``: is there a tension vector >= 1 in the null space; SciPy's linear program, on a sample of the grid.
- ``bound``: one division and one square root a node and nothing else, compiled alike, writing the same array. The
  kernel may come out level with it, as its other arithmetic runs while the divider is busy.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import time
from collections.abc import Callable

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numba  # noqa: E402
import numpy as np  # noqa: E402
import scipy  # noqa: E402
from numba import njit, prange  # noqa: E402
from scipy.optimize import linprog  # noqa: E402

from steeplejack.mechanics.cable import planar_structure_matrix, tension_factor, tension_factor_grid  # noqa: E402
from steeplejack.mechanics.cable.structure import planar_arms  # noqa: E402

ANCHORS = np.array([[0.0, 0.0], [0.4024, 0.4045], [-0.3522, 0.8966], [-0.6244, 0.6244]])
ATTACHMENTS = np.array([[-0.095, -0.095], [0.095, -0.095], [0.095, 0.095], [-0.095, 0.095]])
PHI = math.radians(50.0)
CHUNKS = (4, 8, 16, 32, 64, 128, 256)
LP_POSES = 200


def rows(ys):
    """What the kernel prepares a row: coefficients of each cofactor, root in x and squared height of its cable."""
    arms = planar_arms(ATTACHMENTS, PHI)
    bx, by = arms.T
    x, y = (ANCHORS - arms)[:, 0], (ANCHORS - arms)[:, 1, None] - ys
    moment = bx[:, None] * y - by[:, None] * x[:, None]
    for cable, (i, j, k) in enumerate(((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))):
        p = q = r = 0.0
        for a, b, c in ((i, j, k), (j, k, i), (k, i, j)):
            cross, slope = x[b] * y[c] - x[c] * y[b], y[b] - y[c]
            p = p + moment[a] * cross
            q = q + moment[a] * slope + by[a] * cross
            r = r + by[a] * slope
        yield p[:, None], q[:, None], r[:, None], x[cable], (y[cable] ** 2)[:, None]


def numpy_same(xs, ys, factors, chunk):
    for j in range(0, len(ys), chunk):
        squares = []
        for p, q, r, x, w in rows(ys[j : j + chunk]):
            n = p + xs * (q + xs * r)
            squares.append(n * np.abs(n) * ((x - xs) ** 2 + w))
        s1, s2, s3, s4 = squares
        least, most = (
            np.minimum(np.minimum(s1, s2), np.minimum(s3, s4)),
            np.maximum(np.maximum(s1, s2), np.maximum(s3, s4)),
        )
        small, large = np.maximum(least, -most), np.maximum(most, -least)
        factors[j : j + chunk] = np.sqrt(np.where(small > 1e-18 * large, small / large, 0.0))


def numpy_in_place(xs, ys, factors, chunk):
    buffers = np.empty((4, chunk, len(xs)))
    for j in range(0, len(ys), chunk):
        n, t, least, most = buffers[:, : len(ys[j : j + chunk])]
        for cable, (p, q, r, x, w) in enumerate(rows(ys[j : j + chunk])):
            np.multiply(r, xs, out=n)
            n += q
            n *= xs
            n += p
            np.abs(n, out=t)
            n *= t
            np.add((x - xs) ** 2, w, out=t)
            n *= t
            np.minimum(least, n, out=least) if cable else np.copyto(least, n)
            np.maximum(most, n, out=most) if cable else np.copyto(most, n)
        np.maximum(least, np.negative(most, out=t), out=n)
        np.maximum(most, np.negative(least, out=t), out=t)
        np.maximum(n, 0.0, out=n)
        np.divide(n, t, out=n)
        np.sqrt(n, out=factors[j : j + chunk])


def numpy_general(xs, ys, factors, chunk):
    for j in range(0, len(ys), chunk):
        x, y = np.meshgrid(xs, ys[j : j + chunk])
        poses = np.stack((x, y, np.full(x.shape, PHI)), axis=-1)
        factors[j : j + chunk] = tension_factor(planar_structure_matrix(ANCHORS, ATTACHMENTS, poses))


def highs(poses):
    structures = planar_structure_matrix(ANCHORS, ATTACHMENTS, poses)
    return [linprog(np.zeros(4), A_eq=s, b_eq=np.zeros(3), bounds=(1.0, None)).status == 0 for s in structures]


@njit(parallel=True, error_model="numpy", fastmath={"contract", "nsz", "nnan", "ninf"})
def divide_and_root(xs, ys, factors):
    for j in prange(ys.size):
        for i in range(xs.size):
            factors[j, i] = math.sqrt(ys[j] / xs[i])


def race(contestants: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Best seconds of each, taking turns."""
    for run in contestants.values():
        run()
    best = dict.fromkeys(contestants, math.inf)
    for _ in range(rounds):
        for name, run in contestants.items():
            began = time.perf_counter()
            run()
            best[name] = min(best[name], time.perf_counter() - began)
    return best


def measure(side: int, rounds: int) -> dict[str, object]:
    numba.set_num_threads(1)
    (left, bottom), (right, top) = ANCHORS.min(axis=0), ANCHORS.max(axis=0)
    xs, ys = np.linspace(left, right, side), np.linspace(bottom, top, side)
    factors, sample = np.empty((side, side)), np.random.default_rng(0).integers(0, side, (LP_POSES, 2))
    poses = np.stack((xs[sample[:, 0]], ys[sample[:, 1]], np.full(LP_POSES, PHI)), axis=-1)

    truth = tension_factor_grid(ANCHORS, ATTACHMENTS, PHI, xs, ys)
    for route in (numpy_same, numpy_in_place, numpy_general):
        route(xs, ys, factors, 64)
        np.testing.assert_allclose(factors, truth, atol=1e-9)
    np.testing.assert_array_equal(highs(poses), truth[sample[:, 1], sample[:, 0]] > 0.0)

    fast = race(
        {
            "kernel": lambda: tension_factor_grid(ANCHORS, ATTACHMENTS, PHI, xs, ys, out=factors),
            "bound": lambda: divide_and_root(xs + 1.0, ys + 1.0, factors),
        }
        | {
            f"{name}, chunk {chunk}": lambda route=route, chunk=chunk: route(xs, ys, factors, chunk)
            for name, route in (("numpy, same algebra", numpy_same), ("numpy, same algebra, in place", numpy_in_place))
            for chunk in CHUNKS
        },
        rounds,
    )
    slow = race(
        {f"numpy, general functions, chunk {c}": lambda c=c: numpy_general(xs, ys, factors, c) for c in CHUNKS[::2]}, 1
    )
    lp = race({"HiGHS linear program": lambda: highs(poses)}, 1)
    rates = {name: side * side / seconds for name, seconds in (fast | slow).items()}
    rates |= {name: LP_POSES / seconds for name, seconds in lp.items()}
    return summary(rates, side)


def summary(rates: dict[str, float], side: int) -> dict[str, object]:
    """Best chunk of each route, and the ratios that are asked for."""
    best: dict[str, tuple[float, str]] = {}
    for name, rate in rates.items():
        route, _, chunk = name.partition(", chunk ")
        best[route] = max(best.get(route, (0.0, "")), (rate, chunk))
    kernel = best["kernel"][0]
    return {
        "poses": side * side,
        "threads": 1,
        "machine": {
            "python": platform.python_version(),
            "numpy": np.__version__,
            "scipy": scipy.__version__,
            "numba": numba.__version__,
        },
        "poses_per_second": {route: round(rate) for route, (rate, _) in best.items()},
        "best_chunk_rows": {route: int(chunk) for route, (_, chunk) in best.items() if chunk},
        "ratios": {
            "kernel_over_numpy": kernel / best["numpy, same algebra"][0],
            "kernel_over_numpy_in_place": kernel / best["numpy, same algebra, in place"][0],
            "kernel_over_numpy_general": kernel / best["numpy, general functions"][0],
            "kernel_over_highs": kernel / best["HiGHS linear program"][0],
            "kernel_over_bound": kernel / best["bound"][0],
        },
    }


def table(result: dict) -> str:
    kernel = result["poses_per_second"]["kernel"]
    lines = ["| route | poses/s, one thread | kernel is | best chunk |", "| --- | ---: | ---: | ---: |"]
    for route, rate in sorted(result["poses_per_second"].items(), key=lambda item: -item[1]):
        shown = f"{rate / 1e6:.4g} M" if rate >= 1e5 else f"{rate / 1e3:.3g} k"
        ratio = kernel / rate
        times = "" if route == "kernel" else f"{ratio:.3g} x" if ratio < 1e4 else f"{ratio:,.0f} x"
        lines.append(f"| {route} | {shown} | {times} | {result['best_chunk_rows'].get(route, '')} |")
    return "\n".join(lines)


def main() -> None:
    options = argparse.ArgumentParser(description="Planar tension-factor map against NumPy, HiGHS and the machine.")
    options.add_argument("--json", action="store_true", help="one JSON object instead of the table")
    options.add_argument("--side", type=int, default=1000, help="nodes along each side of the grid")
    options.add_argument("--rounds", type=int, default=20, help="turns of each fast route")
    given = options.parse_args()
    result = measure(given.side, given.rounds)
    print(json.dumps(result) if given.json else table(result))


if __name__ == "__main__":
    main()
