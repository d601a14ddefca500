"""Design of the pipe climber: transmission maps and performance charts against vectorised NumPy, in one run.

Run ``python benchmarks/climber_design.py`` for the table, with ``--json`` for one JSON object, with ``--study`` to rate
the whole design space too, a million designs, in this process and on a dask cluster of two workers.

- *Local transmission index*: poses a second on one thread, at one orientation. The NumPy side evaluates the same closed
  form on whole arrays, in pieces that stay in the cache; both must agree to 1e-12.
- *Chart*: seconds for the GTI of 10,000 designs over 1,750 poses, on two threads.
- *Strips*: microseconds for an area, against counting cells of 0.1 mm, and what either gets.

Neither MuJoCo nor Pinocchio has transmission indices; what they could supply is the Jacobian, one pose at a time.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np

from steeplejack.design.climber import (
    PRESCRIBED,
    Comparison,
    Study,
    local_cluster,
    rate,
    run_study,
    transmission_grid,
    workspace_area,
    workspace_cells,
)
from steeplejack.robots.pipe_climber import Layout

TEXT = Layout((0.100, 0.100, 0.075, 0.075))
SIDE = 1000
PIECE = 16  # rows that NumPy takes at once: fastest of 4 to 1000 here


def numpy_index(layout: Layout, x: np.ndarray, w: np.ndarray, alpha: float) -> np.ndarray:
    """The closed form of `steeplejack.design.climber.transmission`, on arrays."""
    c, s = np.cos(alpha), np.sin(alpha)
    b, p = layout.base, layout.platform
    along, across = x * c - w[:, None] * s, x * s + w[:, None] * c
    a = [along + p[i] - b[i] * c for i in range(3)]
    h = [across - b[i] * s for i in range(3)]
    top, product = None, None
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        side = a[k] * h[j] * (p[j] - p[i]) - a[j] * h[k] * (p[k] - p[i])
        height = h[j] * h[k] * (p[j] - p[k])
        square = (a[i] * a[i] + h[i] * h[i]) * (side * side + height * height)
        if top is None:
            top, product = square, a[i] * height - h[i] * side
        else:
            top = np.maximum(top, square)
    return np.abs(product) / np.sqrt(top)


def best_of(run: Callable[[], object], rounds: int) -> float:
    """Least seconds of some rounds, after one that is not timed."""
    run()
    found = np.inf
    for _ in range(rounds):
        began = time.perf_counter()
        run()
        found = min(found, time.perf_counter() - began)
    return float(found)


def measure_maps(rounds: int = 7) -> dict[str, float]:
    numba.set_num_threads(1)
    x, w = np.linspace(-0.2, 0.2, SIDE), np.linspace(0.01, 0.24, SIDE)
    found: dict[str, float] = {}
    for name, alpha in (("parallel", 0.0), ("tilted", 0.3)):
        pieces = [w[k : k + PIECE] for k in range(0, SIDE, PIECE)]
        difference = transmission_grid(TEXT, x, w, alpha) - numpy_index(TEXT, x, w, alpha)
        assert np.abs(difference).max() < 1e-12
        own = best_of(lambda alpha=alpha: transmission_grid(TEXT, x, w, alpha), rounds)
        peer = best_of(lambda alpha=alpha, pieces=pieces: [numpy_index(TEXT, x, w=w, alpha=alpha) for w in pieces], 3)
        found |= {f"{name}_per_second": SIDE**2 / own, f"{name}_numpy_per_second": SIDE**2 / peer}
    return found


def measure_chart() -> dict[str, float]:
    numba.set_num_threads(min(2, numba.config.NUMBA_NUM_THREADS))
    axis = np.linspace(0.05, 1.0, 100)
    third, fourth = (grid.ravel() for grid in np.meshgrid(axis, axis))
    ratios = np.stack((np.ones(10_000), np.ones(10_000), third, fourth), axis=-1)
    asked = Comparison(PRESCRIBED, step=0.002)
    x, w = PRESCRIBED.cells(asked.step)
    own = best_of(lambda: rate(ratios, asked), 3)
    few = ratios[::50]

    def by_numpy() -> np.ndarray:
        return np.array([(numpy_index(asked.layout(tuple(one)), x, w, 0.0) >= 0.5).mean() for one in few])

    assert np.abs(by_numpy() - rate(few, asked).gti).max() < 1.5 / (x.size * w.size)
    peer = best_of(by_numpy, 2) * len(ratios) / len(few)
    return {"designs": len(ratios), "poses": x.size * w.size, "seconds": own, "numpy_seconds": peer}


def measure_areas() -> dict[str, float]:
    strips = best_of(lambda: workspace_area(TEXT), 5)
    cells = best_of(lambda: workspace_cells(TEXT, 0.0, 1e-4), 3)
    return {
        "strips_us": strips * 1e6,
        "cells_us": cells * 1e6,
        "strips_mm2": workspace_area(TEXT) * 1e6,
        "cells_mm2": float(workspace_cells(TEXT, 0.0, 1e-4)[0]) * 1e-2,
    }


def measure_study() -> dict[str, float]:
    study = Study(Comparison(PRESCRIBED, step=0.002))
    found: dict[str, float] = {"chunks": study.chunks}
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        chart = run_study(study, Path(folder) / "alone")
        found |= {"designs": len(chart.ratios), "in_process_seconds": time.perf_counter() - began}
        with local_cluster(2) as client:
            began = time.perf_counter()
            run_study(study, Path(folder) / "cluster", client)
            found["two_workers_seconds"] = time.perf_counter() - began
        began = time.perf_counter()
        run_study(study, Path(folder) / "cluster")
        found["resumed_seconds"] = time.perf_counter() - began
    return found


def table(result: dict[str, dict[str, float]]) -> str:
    maps, chart, areas = result["maps"], result["chart"], result["areas"]
    lines = ["| what | this project | NumPy | ratio |", "| --- | ---: | ---: | ---: |"]
    for name in ("parallel", "tilted"):
        own, peer = maps[f"{name}_per_second"], maps[f"{name}_numpy_per_second"]
        lines.append(
            f"| LTI, platforms {name}, one thread | {own / 1e6:.0f} M/s | {peer / 1e6:.1f} M/s | {own / peer:.0f} |"
        )
    own, peer = chart["seconds"], chart["numpy_seconds"]
    name = f"GTI chart, {chart['designs']:,} designs over {chart['poses']:,} poses, two threads"
    lines.append(f"| {name} | {own:.3f} s | {peer:.2f} s | {peer / own:.0f} |")
    lines += [
        "",
        f"Area by strips {areas['strips_us']:.0f} us, {areas['strips_mm2']:.4f} mm2; by cells of 0.1 mm "
        f"{areas['cells_us']:.0f} us, {areas['cells_mm2']:.4f} mm2.",
    ]
    if "study" in result:
        one = result["study"]
        lines.append(
            f"{one['designs']:,} designs in {one['chunks']} chunks: {one['in_process_seconds']:.1f} s in this process, "
            f"{one['two_workers_seconds']:.1f} s on two workers, {one['resumed_seconds']:.2f} s to find all done."
        )
    return "\n".join(lines)


def main() -> None:
    options = argparse.ArgumentParser(description="Pipe climber: transmission maps, charts, areas.")
    options.add_argument("--json", action="store_true", help="one JSON object instead of the table")
    options.add_argument("--study", action="store_true", help="a million designs too, also on a dask cluster")
    given = options.parse_args()
    result = {"maps": measure_maps(), "chart": measure_chart(), "areas": measure_areas()}
    if given.study:
        result["study"] = measure_study()
    print(json.dumps(result) if given.json else table(result))


if __name__ == "__main__":
    main()
