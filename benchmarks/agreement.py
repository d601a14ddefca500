"""Closure, feasibility and every tension distribution against a linear program, pose by pose: how often they disagree.

Run ``python benchmarks/agreement.py`` for the tables (10,000 random poses a robot take a quarter of an hour),
``--poses 500`` for a quick look, ``--json`` for one JSON object. For each robot and pose, turned and off centre:

- *closure*: `wrench_closure` against HiGHS for the largest ``t`` with ``structure f = 0``, ``t <= f <= 1``, and how far
  the tension factors are apart;
- *feasible*: `wrench_feasible` under gravity against HiGHS for the greatest depth inside all tension windows;
- *distributions*: every method against the same verdicts. A complete one must find tensions exactly where there are
  some; another may miss, and must then say that there are some. What is found must be inside every window (to 1e-9 of
  it) and in balance (to 1e-11 of what is added up);
- *band*: poses with a margin within 1e-6 of zero, where rational arithmetic decides instead of the linear program
  (for closure every pose outside: the best its program can do there is no tensions at all);
- *proofs*: every "no" comes with a certificate, checked by multiplication with the structure matrix;
- *pycapacity*: the largest difference of the capacity margin from pycapacity's, planar robots, if it is installed.

The linear programs, the rational arithmetic and the checks are those of the tests (tests/mechanics/oracles.py and
verdicts.py); the oracles use nothing of this package.
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
from published_robots import PLANAR, SPATIAL, Published  # noqa: E402
from tension_questions import published  # noqa: E402
from verdicts import Verdicts, shortcomings, taken  # noqa: E402

from steeplejack.mechanics.cable import (  # noqa: E402
    METHODS,
    capacity_margin,
    distribute,
    wrench_closure,
    wrench_feasible,
)

SAMPLE = 500  # poses compared with pycapacity


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


def feasibility(asked, verdicts: Verdicts) -> dict[str, int]:
    matrices, weights, low, high = asked
    answer = wrench_feasible(matrices, low, high, weights)
    no = np.flatnonzero(~answer.feasible)
    gaps = [oracles.certified_gap(answer.certificate[k], *(value[k] for value in asked)) for k in no]
    return {
        "feasible": int(answer.feasible.sum()),
        "band": int(verdicts.close.sum()),
        "disagreements": int(np.count_nonzero(answer.feasible != verdicts.held)),
        "bad_proofs": sum(not gap > 0.0 for gap in gaps),
    }


def pycapacity_difference(matrices, weights, low, high) -> float:
    from pycapacity.algorithms import hyper_plane_shift_method

    ours = capacity_margin(matrices, low, high, weights)
    theirs = []
    for matrix, weight, least, most in zip(matrices, weights, low, high, strict=True):
        normals, reaches = hyper_plane_shift_method(matrix, least, most)
        theirs.append(np.min((np.ravel(reaches) + normals @ weight) / np.linalg.norm(normals, axis=1)))
    return float(np.abs(ours - theirs).max())


def measure(robot: Published, count: int) -> dict[str, object]:
    asked = published(robot, np.random.default_rng(3), count)
    installed = importlib.util.find_spec("pycapacity") is not None
    compared = robot.dimension == 2 and installed
    verdicts = Verdicts.of(*asked)
    methods = [method for method in METHODS if taken(method, asked[0])]
    return {
        "robot": robot.name,
        "poses": count,
        "closure": closure(asked[0]),
        "feasibility": feasibility(asked, verdicts),
        "pycapacity_apart": pycapacity_difference(*(value[:SAMPLE] for value in asked)) if compared else None,
        "distributions": {name: shortcomings(name, distribute(*asked, name), asked, verdicts) for name in methods},
    }


def regions(results: list[dict]) -> str:
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


def distributions(results: list[dict]) -> str:
    robots = " | ".join(result["robot"] for result in results)
    lines = [
        f"| found | {robots} | disagreements | bad tensions | bad proofs | worst excess | worst residual |",
        f"| --- |{' ---: |' * (len(results) + 5)}",
    ]
    for name in METHODS:
        rows = [result["distributions"].get(name) for result in results]
        known = [row for row in rows if row is not None]
        found = " | ".join("" if row is None else f"{row['found']:,}" for row in rows)
        counts = " | ".join(
            str(sum(row[key] for row in known)) for key in ("disagreements", "bad_tensions", "bad_proofs")
        )
        worst = " | ".join(f"{max(row[key] for row in known):.1e}" for key in ("excess", "residual"))
        claims = "" if METHODS[name].complete else ", may miss"
        lines.append(f"| `{name}`{claims} | {found} | {counts} | {worst} |")
    return "\n".join(lines)


def main() -> None:
    options = argparse.ArgumentParser(description="Closure, feasibility and distributions against a linear program.")
    options.add_argument("--json", action="store_true", help="one JSON object instead of the tables")
    options.add_argument("--poses", type=int, default=10000, help="random poses a robot")
    given = options.parse_args()
    results = [measure(robot, given.poses) for robot in (*PLANAR, *SPATIAL)]
    print(json.dumps({"robots": results}) if given.json else f"{regions(results)}\n\n{distributions(results)}")


if __name__ == "__main__":
    main()
