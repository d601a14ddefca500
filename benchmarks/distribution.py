"""Tension distributions: every method of the family, and other people's solvers, on the same poses in one run.

Run ``python benchmarks/distribution.py`` for the tables, with ``--json`` for one JSON object, with ``--figure FILE``
for the picture of the documentation. One thread.

- *found*: poses where a method returns tensions inside the box, of those where a linear program (HiGHS) finds some.
- *jump*: largest change of a tension that stays when the steepest pieces of ten flights are halved again and again,
  over the window; zero for a continuous method.
- *time*: per pose, structure matrix given, in one batch; contestants take turns and the best time of each counts. Peers
  solve one pose a call, as their interfaces ask: ``HiGHS`` is SciPy's; ``daqp``, where it is installed, gets the null
  space and the least-norm tensions for nothing.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import os
import time
from collections.abc import Callable

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np  # noqa: E402
from scipy.optimize import linprog  # noqa: E402

from steeplejack.mechanics.cable import (  # noqa: E402
    METHODS,
    distribute,
    null_space,
    planar_structure_matrix,
    spatial_structure_matrix,
)

POSES = 4000
TIMED = 1000
PEER_POSES = 200
ROUNDS = 80
PATHS = 10

PLANAR = {
    "name": "planar 4-4, r = 1",
    "anchors": np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [0.0, 6.0]]),
    "attachments": np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]),
    "low": np.array([0.1, 0.1, -0.3]),
    "high": np.array([9.9, 5.9, 0.3]),
    "window": (10.0, 500.0),
    "wrench": np.array([0.0, -20.0 * 9.81, 0.0]),
}
IPANEMA = {
    "name": "IPAnema 2, r = 2",
    "anchors": np.array([[x, y, z] for z in (5.0, 1.0) for x, y in ((-4, 3), (4, 3), (4, -3), (-4, -3))]),
    "attachments": np.array(
        [[x, y, 0.25] for x, y in ((-0.65, 0.125), (0.65, 0.125), (0.65, -0.125), (-0.65, -0.125))]
        + [[x, y, 0.75] for x, y in ((-0.75, 0.1), (0.75, 0.1), (0.75, -0.1), (-0.75, -0.1))]
    ),
    "low": np.array([-3.5, -2.7, 0.5, -0.5]),
    "high": np.array([3.5, 2.7, 4.5, 0.5]),
    "window": (5.0, 200.0),
    "wrench": np.array([0.0, 0.0, 0.0, 0.0, 0.0, -10.0 * 9.81]),
}
ROBOTS = (PLANAR, IPANEMA)


def structures(robot, pose):
    """Structure matrices at poses: x, y and heading, or x, y, z and the size of a turn about a fixed axis."""
    if robot["anchors"].shape[1] == 2:
        return planar_structure_matrix(robot["anchors"], robot["attachments"], pose)
    x, y, z = np.array([0.3, -0.8, 0.5]) / math.sqrt(0.98)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = pose[:, 3, None, None]
    turned = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return spatial_structure_matrix(robot["anchors"], robot["attachments"], pose[:, :3], turned)


def random_poses(robot, count):
    rng = np.random.default_rng(1)
    return rng.uniform(robot["low"], robot["high"], (count, robot["low"].size))


def flight(robot, seed):
    """A closed curve through the poses, as a function of the share flown."""
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (robot["low"].size, 2))
    middle, half = 0.5 * (robot["low"] + robot["high"]), 0.5 * (robot["high"] - robot["low"])
    return lambda share: (
        middle + half * (np.sin(2.0 * np.pi * share[:, None, None] * [1.0, 2.0] + phase) * [0.5, 0.25]).sum(axis=-1)
    )


def jump(robot, method, path):
    """What is left of the largest change between neighbours after 30 halvings; margins below 1e-3 are not followed."""
    window = robot["window"][1] - robot["window"][0]

    def tensions(share):
        answer = distribute(structures(robot, path(share)), robot["wrench"], *robot["window"], method)
        return np.where(answer.margin[:, None] > 1e-3, answer.tensions / window, np.nan)

    share = np.linspace(0.0, 1.0, 2001)
    along = tensions(share)
    change = np.nan_to_num(np.abs(np.diff(along, axis=0)).max(axis=-1))
    steep = np.argsort(change)[-20:]
    low, high, first, last = share[steep], share[steep + 1], along[steep], along[steep + 1]
    for _ in range(30):
        middle = 0.5 * (low + high)
        new = tensions(middle)
        before = np.abs(new - first).max(axis=-1) > np.abs(last - new).max(axis=-1)
        low, high = np.where(before, low, middle), np.where(before, middle, high)
        first, last = np.where(before[:, None], first, new), np.where(before[:, None], new, last)
    return float(np.nan_to_num(np.abs(last - first).max(axis=-1)).max())


def least_sum(structure, robot):
    """HiGHS: the least sum of tensions; a program of the kind, whether feasible or not."""
    bounds = [robot["window"]] * structure.shape[1]
    return linprog(np.ones(structure.shape[1]), A_eq=structure, b_eq=-robot["wrench"], bounds=bounds).status == 0


def in_null_space(structure, robot):
    """The QP of ``qp`` in the null space, ready for a solver."""
    basis = null_space(structure).basis
    start = -np.linalg.pinv(structure) @ robot["wrench"]
    low, high = robot["window"]
    wanted = basis.T @ (0.5 * (low + high) - start)
    rows, kinds = np.ascontiguousarray(basis), np.zeros(len(start), dtype=np.int32)
    return np.eye(basis.shape[1]), -wanted, rows, high - start, low - start, kinds


def race(contestants: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Best seconds of each, taking turns."""
    best = dict.fromkeys(contestants, math.inf)
    for run in contestants.values():
        run()
    for _ in range(rounds):
        for name, run in contestants.items():
            began = time.perf_counter()
            run()
            best[name] = min(best[name], time.perf_counter() - began)
    return best


def measure(robot) -> dict[str, dict[str, float]]:
    """Every method and peer on one robot."""
    matrices = structures(robot, random_poses(robot, POSES))
    possible = np.array([least_sum(matrix, robot) for matrix in matrices])
    redundancy = matrices.shape[2] - matrices.shape[1]
    taken = [name for name, record in METHODS.items() if redundancy <= (record.most_redundancy or redundancy)]
    asked = robot["wrench"], *robot["window"]
    batch = matrices[:TIMED]
    seconds = race({name: lambda name=name: distribute(batch, *asked, name) for name in taken}, ROUNDS)
    rows = {}
    for name in taken:
        answer = distribute(matrices, *asked, name)
        rows[name] = {
            "found": int(np.count_nonzero(answer.feasible & possible)),
            "possible": int(np.count_nonzero(possible)),
            "jump": max(jump(robot, name, flight(robot, seed)) for seed in range(PATHS)),
            "us": 1e6 * seconds[name] / TIMED,
        }
    few = matrices[:PEER_POSES]
    peers = {"HiGHS, least sum": lambda: [least_sum(matrix, robot) for matrix in few]}
    if importlib.util.find_spec("daqp"):
        import daqp

        ready = [in_null_space(matrix, robot) for matrix in few]
        peers["daqp, as qp, null space given"] = lambda: [daqp.solve(*question) for question in ready]
    slow = race(peers, 3)
    return rows | {name: {"us": 1e6 * value / PEER_POSES} for name, value in slow.items()}


def table(rows: dict[str, dict[str, float]]) -> str:
    lines = ["| method | found | jump / window | us per pose |", "| --- | ---: | ---: | ---: |"]
    for name, row in rows.items():
        found = f"{row['found']} of {row['possible']}" if "found" in row else ""
        step = "" if "jump" not in row else "none" if row["jump"] < 1e-6 else f"{row['jump']:.2f}"
        lines.append(f"| {name} | {found} | {step} | {row['us']:.1f} |")
    return "\n".join(lines)


def draw(path: str) -> None:
    """The tensions of IPAnema 2 along one flight, by method."""
    import matplotlib.pyplot as plt

    plt.rcParams["svg.hashsalt"] = "distribution"
    shown = ("closed-form", "min-norm", "qp", "barycentre", "min-max", "max-margin")
    share = np.linspace(0.0, 1.0, 701)
    matrices = structures(IPANEMA, flight(IPANEMA, 2)(share))
    figure, axes = plt.subplots(2, 3, figsize=(9.0, 4.6), sharex=True, sharey=True, layout="constrained")
    for axis, method in zip(axes.flat, shown, strict=True):
        answer, record = distribute(matrices, IPANEMA["wrench"], *IPANEMA["window"], method), METHODS[method]
        missed = int(np.count_nonzero(~answer.feasible))
        says = "jumps" if not record.continuous else f"outside on {missed / 7.01:.0f} %" if missed else "continuous"
        for bound in IPANEMA["window"]:
            axis.axhline(bound, color="black", linewidth=0.6, linestyle=":")
        axis.plot(share, answer.tensions, linewidth=0.9)
        axis.set_title(f"{method}: {says}", fontsize=9, loc="left")
        axis.grid(alpha=0.3)
    figure.supxlabel("share of the flight", fontsize=9)
    figure.supylabel("tensions of the eight cables [N]", fontsize=9)
    figure.savefig(path, metadata={"Date": None} if path.endswith(".svg") else None, dpi=110)


def main() -> None:
    options = argparse.ArgumentParser(description="Tension distributions against each other and against solvers.")
    options.add_argument("--json", action="store_true", help="one JSON object instead of the tables")
    options.add_argument("--figure", help="write the picture of the documentation to this file and stop")
    given = options.parse_args()
    if given.figure:
        draw(given.figure)
        return
    result = {robot["name"]: measure(robot) for robot in ROBOTS}
    if given.json:
        print(json.dumps(result))
        return
    for name, rows in result.items():
        print(f"{name}\n\n{table(rows)}\n")


if __name__ == "__main__":
    main()
