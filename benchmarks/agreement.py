"""Wrench closure and feasibility against a linear program, pose by pose: how often they disagree, and who is right.

Run ``python benchmarks/agreement.py`` for a table (10,000 random poses a robot take some ten minutes),
``--poses 500`` for a quick look, ``--json`` for one JSON object. For each robot and pose, turned and off centre:

- *closure*: `wrench_closure` against HiGHS for the largest ``t`` with ``structure f = 0``, ``t <= f <= 1``, and how far
  the tension factors are apart;
- *feasible*: `wrench_feasible` under gravity against HiGHS for the greatest depth inside all tension windows;
- *band*: poses with a margin within 1e-6 of zero, where rational arithmetic decides instead of the linear program
  (for closure every pose outside: the best its program can do there is no tensions at all);
- *proofs*: every "no" comes with a certificate, checked by multiplication with the structure matrix;
- *pycapacity*: the largest difference of the capacity margin from pycapacity's, planar robots, if it is installed.

The linear programs, the rational arithmetic and the checks are those of the tests (tests/mechanics/oracles.py), which
use nothing of this package.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import sys
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "mechanics"))

import numpy as np  # noqa: E402
import oracles  # noqa: E402
from published_robots import GRAVITY, PLANAR, SPATIAL, Published  # noqa: E402

from steeplejack.mechanics.cable import (  # noqa: E402
    capacity_margin,
    gravity_wrench,
    planar_structure_matrix,
    spatial_structure_matrix,
    wrench_closure,
    wrench_feasible,
)

SAMPLE = 500  # poses compared with pycapacity


def questions(robot: Published, count: int):
    """Structure matrices at random poses, and gravity's wrench there."""
    poses = robot.poses(np.random.default_rng(3), count)
    if robot.dimension == 3:
        weight = gravity_wrench(robot.mass, [0.0, 0.0, -GRAVITY], poses[1] @ robot.centre)
        return spatial_structure_matrix(robot.anchors, robot.attachments, *poses), weight
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    x, y = robot.centre
    weight = gravity_wrench(robot.mass, [0.0, -GRAVITY], np.stack((cos * x - sin * y, sin * x + cos * y), axis=-1))
    return planar_structure_matrix(robot.anchors, robot.attachments, poses), weight


def closure(matrices) -> dict[str, float]:
    answer = wrench_closure(matrices)
    wrong = band = proofs = 0
    apart = 0.0
    for matrix, inside, factor, z in zip(matrices, answer.inside, answer.factor, answer.certificate, strict=True):
        margin = oracles.closure_margin(matrix)
        apart = max(apart, abs(factor - max(margin, 0.0)))
        close = abs(margin) < oracles.BAND  # outside the optimum is 0, no tensions at all: always settled exactly
        wrong += inside != (oracles.closes_exactly(matrix) if close else margin > 0.0)
        band += close
        proofs += not inside and not oracles.separates(z, matrix)
    return {
        "inside": int(answer.inside.sum()),
        "band": int(band),
        "disagreements": int(wrong),
        "bad_proofs": int(proofs),
        "factor_apart": float(apart),
    }


def feasibility(matrices, weights, low, high) -> dict[str, int]:
    answer = wrench_feasible(matrices, low, high, weights)
    wrong = band = proofs = 0
    for matrix, weight, held, z in zip(matrices, weights, answer.feasible, answer.certificate, strict=True):
        margin = oracles.window_margin(matrix, weight, low, high)
        close = abs(margin) < oracles.BAND
        wrong += held != (oracles.holds_exactly(matrix, weight, low, high) if close else margin > 0.0)
        band += close
        proofs += not held and not oracles.certified_gap(z, matrix, weight, low, high) > 0.0
    return {
        "feasible": int(answer.feasible.sum()),
        "band": int(band),
        "disagreements": int(wrong),
        "bad_proofs": int(proofs),
    }


def pycapacity_difference(matrices, weights, low, high) -> float:
    from pycapacity.algorithms import hyper_plane_shift_method

    ours = capacity_margin(matrices, low, high, weights)
    theirs = []
    for matrix, weight in zip(matrices, weights, strict=True):
        normals, reaches = hyper_plane_shift_method(matrix, low, high)
        theirs.append(np.min((np.ravel(reaches) + normals @ weight) / np.linalg.norm(normals, axis=1)))
    return float(np.abs(ours - theirs).max())


def measure(robot: Published, count: int) -> dict[str, object]:
    matrices, weights = questions(robot, count)
    low, high = (np.full(matrices.shape[-1], bound) for bound in robot.window)
    installed = importlib.util.find_spec("pycapacity") is not None
    compared = robot.dimension == 2 and installed
    return {
        "robot": robot.name,
        "poses": count,
        "closure": closure(matrices),
        "feasibility": feasibility(matrices, weights, low, high),
        "pycapacity_apart": pycapacity_difference(matrices[:SAMPLE], weights[:SAMPLE], low, high) if compared else None,
    }


def table(results: list[dict]) -> str:
    lines = [
        "| robot | poses | inside | TF apart | feasible | in the bands | disagreements | bad proofs | pycapacity [N] |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for result in results:
        closed, held = result["closure"], result["feasibility"]
        apart = result["pycapacity_apart"]
        lines.append(
            f"| {result['robot']} | {result['poses']:,} | {closed['inside']:,} | {closed['factor_apart']:.1e} "
            f"| {held['feasible']:,} | {closed['band'] + held['band']} "
            f"| {closed['disagreements'] + held['disagreements']} | {closed['bad_proofs'] + held['bad_proofs']} "
            f"| {'' if apart is None else format(apart, '.1e')} |"
        )
    return "\n".join(lines)


def main() -> None:
    options = argparse.ArgumentParser(description="Closure and feasibility against a linear program.")
    options.add_argument("--json", action="store_true", help="one JSON object instead of the table")
    options.add_argument("--poses", type=int, default=10000, help="random poses a robot")
    given = options.parse_args()
    results = [measure(robot, given.poses) for robot in (*PLANAR, *SPATIAL)]
    print(json.dumps({"robots": results}) if given.json else table(results))


if __name__ == "__main__":
    main()
