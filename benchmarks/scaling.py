"""Regions over two processes: how much faster than over one, and what this machine allows, in one run.

Run ``python benchmarks/scaling.py`` for a table, with ``--json`` for one JSON object. Maps and certified regions hold
no state, so a region is cut into pieces and those go to a pool of processes. The pool is started and its kernels are
loaded before the clock runs; the same pieces are then done by one process and by two, in turns, best time of each.

- ``spatial map``: `spatial_feasibility_map` of CoGiRo with its weight, in slabs.
- ``spatial closure``: `spatial_closure_map` of IPAnema 2, in slabs.
- ``certified region``: `certify` on slabs of the same hall; inner and outer volumes of slabs add up.
- ``spin``: a pure Python loop in each process, which shares nothing: the bound. Where the two cores of a machine are
  two threads of one, it is well below 2.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import time
from concurrent.futures import ProcessPoolExecutor

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np  # noqa: E402

from steeplejack.mechanics.cable import (  # noqa: E402
    certify,
    gravity_wrench,
    spatial_closure_map,
    spatial_facets,
    spatial_feasibility_map,
)
from steeplejack.robots.cable_robot import load_cable_robot  # noqa: E402

COGIRO, IPANEMA = load_cable_robot("cogiro"), load_cable_robot("ipanema-2")
WEIGHT = gravity_wrench(COGIRO.mass, [0.0, 0.0, -9.81], COGIRO.centre_of_mass)
HALL = np.array([[-6.5, 6.5], [-4.5, 4.5], [0.0, 4.0]])
PIECES = 32


def positions(piece: int, box: np.ndarray, side: int) -> np.ndarray:
    """Nodes of one slab of a box."""
    x = np.linspace(*box[0], side * PIECES)[piece::PIECES]
    return np.stack(np.meshgrid(x, np.linspace(*box[1], side), np.linspace(*box[2], side)), axis=-1)


def feasibility(piece: int) -> float:
    nodes = positions(piece, HALL, 16)
    found = spatial_feasibility_map(
        COGIRO.anchors, COGIRO.attachments, nodes, np.eye(3), COGIRO.lower, COGIRO.upper, WEIGHT
    )
    return float(found.feasible.sum())


def closure(piece: int) -> float:
    nodes = positions(piece, np.array([[-3.5, 3.5], [-2.7, 2.7], [0.5, 4.5]]), 64)
    turn = np.array([[0.995, -0.0998, 0.0], [0.0998, 0.995, 0.0], [0.0, 0.0, 1.0]])
    turn[:2, :2] /= math.hypot(0.995, 0.0998)
    return float((spatial_closure_map(IPANEMA.anchors, IPANEMA.attachments, nodes, turn) > 0.0).sum())


def certified(piece: int) -> float:
    edges = np.linspace(*HALL[0], PIECES + 1)
    slab = np.vstack((edges[piece : piece + 2], HALL[1:]))
    facets = spatial_facets(COGIRO.anchors, COGIRO.attachments, np.eye(3), WEIGHT, COGIRO.lower, COGIRO.upper)
    return certify(facets, slab, 0.1).inner


def spin(piece: int) -> float:
    total = piece
    for k in range(2_000_000):
        total += k & 3
    return float(total)


JOBS = {"spatial map": feasibility, "spatial closure": closure, "certified region": certified, "spin": spin}


def elapsed(pool: ProcessPoolExecutor, name: str) -> tuple[float, float]:
    """Seconds of all pieces of a job, and the sum of their answers."""
    began = time.perf_counter()
    answers = list(pool.map(JOBS[name], range(PIECES)))
    return time.perf_counter() - began, math.fsum(answers)


def measure(rounds: int) -> dict[str, object]:
    context = multiprocessing.get_context("spawn")
    ratios: dict[str, float] = {}
    seconds: dict[str, list[float]] = {}
    with (
        ProcessPoolExecutor(1, mp_context=context) as one,
        ProcessPoolExecutor(2, mp_context=context) as two,
    ):
        for name in JOBS:
            best, sums = [math.inf, math.inf], [0.0, 0.0]
            for turn in range(rounds + 1):  # the first round loads the kernels
                for k, pool in enumerate((one, two)):
                    took, sums[k] = elapsed(pool, name)
                    best[k] = min(best[k], took) if turn else best[k]
            assert sums[0] == sums[1], f"{name}: two processes answer {sums[1]}, one {sums[0]}"
            seconds[name], ratios[name] = best, best[0] / best[1]
    return {"processors": os.cpu_count(), "load": os.getloadavg()[0], "seconds": seconds, "ratios": ratios}


def table(result: dict) -> str:
    lines = ["| job | one process | two processes | ratio | of the bound |", "| --- | ---: | ---: | ---: | ---: |"]
    bound = result["ratios"]["spin"]
    for name, (one, two) in result["seconds"].items():
        ratio = result["ratios"][name]
        lines.append(f"| {name} | {one:.2f} s | {two:.2f} s | {ratio:.2f} | {100.0 * ratio / bound:.0f} % |")
    load = f"{result['processors']} processors, load {result['load']:.1f} at the end"
    return "\n".join(
        [*lines, "", f"{load}; the bound is the ratio of a pure Python loop, which two free cores bring to 2."]
    )


def main() -> None:
    options = argparse.ArgumentParser(description="Maps and certified regions over two processes against one.")
    options.add_argument("--json", action="store_true", help="one JSON object instead of the table")
    options.add_argument("--rounds", type=int, default=5, help="turns of each job")
    given = options.parse_args()
    result = measure(given.rounds)
    print(json.dumps(result) if given.json else table(result))


if __name__ == "__main__":
    main()
