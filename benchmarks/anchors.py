"""Optimal anchors: the exact method and Algorithm 2 on its grid against plain transcriptions, one thread, one run.

Run ``python benchmarks/anchors.py`` for a table, with ``--json`` for one JSON object. Every row is the 51 poses of Eq.
28, Table III, windows of 5 cm either way, all four anchors.

- ``exact, gap ...``: `optimal_anchors`, continuous offsets with a certificate.
- ``grid``: `algorithm_2` at 1 cm, 11^4 combinations a pose.
- ``pseudo-code``: Algorithm 2 literally, four nested Python loops, J~ by NumPy determinants; some combinations of one
  pose, scaled up.
- ``numpy, vectorised``: all combinations of a pose at once by this package's general functions.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import time
from collections.abc import Callable

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np  # noqa: E402

from steeplejack.design.anchors import Reconfiguration, algorithm_2, eq28, optimal_anchors  # noqa: E402
from steeplejack.mechanics.cable import planar_structure_matrix, tension_factor  # noqa: E402

ANCHORS = np.array([[0.0, 0.0], [0.4024, 0.4045], [-0.3522, 0.8966], [-0.6244, 0.6244]])
ATTACHMENTS = np.array([[-0.095, -0.095], [0.095, -0.095], [0.095, 0.095], [-0.095, 0.095]])
UPPER = (0.8966 - 0.4045) / (-0.3522 - 0.4024)
DIRECTIONS = np.array([[1.0, -1.0], [1.0, UPPER], [1.0, UPPER], [1.0, -1.0]])
PROBLEM = Reconfiguration(ANCHORS, DIRECTIONS, ATTACHMENTS, np.tile([-0.05, 0.05], (4, 1)), eq28())
AXIS = np.arange(-5, 6) * 0.01
VECTOR_POSES = 5


def pseudo_code(pose: np.ndarray, axes: list[np.ndarray]) -> float:
    """Lines 3-23 of Algorithm 2 at one pose, the empty set counted as 0."""
    x, y, phi = pose
    rotation = np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]])
    found = []
    for u1 in axes[0]:
        for u2 in axes[1]:
            for u3 in axes[2]:
                for u4 in axes[3]:
                    columns = []
                    for i, u in enumerate((u1, u2, u3, u4)):
                        b = rotation @ ATTACHMENTS[i]
                        q = ANCHORS[i] + u * DIRECTIONS[i] - b - np.array([x, y])
                        columns.append(np.array([q[0], q[1], b[0] * q[1] - b[1] * q[0]]))
                    jt = np.stack(columns, axis=1)
                    null = np.array([(-1) ** i * np.linalg.det(np.delete(jt, i, axis=1)) for i in range(4)])
                    null *= np.linalg.norm(jt[:2], axis=0)
                    if (null > 0).all() or (null < 0).all():
                        found.append(np.abs(null).min() / np.abs(null).max())
    return max(found, default=0.0)


def vectorised(poses: np.ndarray) -> np.ndarray:
    offsets = np.stack(np.meshgrid(AXIS, AXIS, AXIS, AXIS, indexing="ij"), axis=-1).reshape(-1, 4)
    placed = PROBLEM.placed(offsets)
    return np.array([tension_factor(planar_structure_matrix(placed, ATTACHMENTS, pose)).max() for pose in poses])


def best_seconds(run: Callable[[], object], rounds: int) -> float:
    run()
    best = math.inf
    for _ in range(rounds):
        began = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - began)
    return best


def measure(rounds: int) -> dict[str, object]:
    poses, count = PROBLEM.poses, len(PROBLEM.poses)
    grid = algorithm_2(PROBLEM, 0.01)
    np.testing.assert_allclose(vectorised(poses[:2]), grid.tension_factor[:2], atol=1e-12)
    few = [AXIS[[0, 5]], AXIS[[0, 5]], AXIS[[0, 10]], AXIS[[0, 10]]]
    share = 16 / AXIS.size**4
    seconds = {f"exact, gap {gap:g}": best_seconds(lambda gap=gap: optimal_anchors(PROBLEM, gap), rounds)
               for gap in (1e-4, 1e-6, 1e-9)}  # fmt: skip
    seconds["grid"] = best_seconds(lambda: algorithm_2(PROBLEM, 0.01), rounds)
    seconds["numpy, vectorised"] = best_seconds(lambda: vectorised(poses[:VECTOR_POSES]), 2) * count / VECTOR_POSES
    seconds["pseudo-code"] = best_seconds(lambda: pseudo_code(poses[0], few), rounds) * count / share
    optimum = optimal_anchors(PROBLEM)
    return {
        "poses": count,
        "threads": 1,
        "milliseconds": {name: 1e3 * value for name, value in seconds.items()},
        "ratios": {
            "pseudo_code_over_grid": seconds["pseudo-code"] / seconds["grid"],
            "vectorised_over_grid": seconds["numpy, vectorised"] / seconds["grid"],
            "pseudo_code_over_exact_1e-6": seconds["pseudo-code"] / seconds["exact, gap 1e-06"],
            "vectorised_over_exact_1e-6": seconds["numpy, vectorised"] / seconds["exact, gap 1e-06"],
        },
        "mean_tension_factor": {"grid": grid.tension_factor.mean(), "exact": optimum.tension_factor.mean()},
        "certified_gap": float(optimum.gap.max()),
        "boxes": int(optimum.boxes.sum()),
    }


def table(result: dict) -> str:
    lines = ["| route | 51 poses [ms] | pseudo-code takes |", "| --- | ---: | ---: |"]
    slowest = result["milliseconds"]["pseudo-code"]
    for name, value in sorted(result["milliseconds"].items(), key=lambda item: item[1]):
        lines.append(f"| {name} | {value:,.3g} | {slowest / value:,.0f} x |")
    means = result["mean_tension_factor"]
    lines.append(
        f"\nmean tension factor: grid {means['grid']:.6f}, exact {means['exact']:.6f}; largest certified gap "
        f"{result['certified_gap']:.1e} in {result['boxes']} boxes"
    )
    return "\n".join(lines)


def main() -> None:
    options = argparse.ArgumentParser(description="Optimal anchors against transcriptions of Algorithm 2.")
    options.add_argument("--json", action="store_true", help="one JSON object instead of the table")
    options.add_argument("--rounds", type=int, default=20, help="turns of each fast route")
    given = options.parse_args()
    result = measure(given.rounds)
    print(json.dumps(result) if given.json else table(result))


if __name__ == "__main__":
    main()
