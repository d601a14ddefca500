"""This package against packages pip can install, question by question, one thread, one run.

Run ``python benchmarks/peers.py`` for a table, with ``--json`` for one JSON object. A peer that is not installed is
left out, and the last lines say how to install it. Every pair answers the same poses before it is timed; *apart* is
how far their answers are from each other at most. Contestants take turns and the best time of each counts.

- *capacity margin*, structure matrices given: pycapacity's hyperplane shifting, one pose a call, and the convex hull
  of the wrenches of all corners of the window by SciPy's Qhull;
- *wrench feasibility* under gravity, ours with a certificate for every no: HiGHS asked whether tensions exist. *Apart*
  counts the poses judged differently, those with a margin below 1e-6 N left out;
- *forward kinematics* of a stream of lengths, each from the pose before: SciPy's ``least_squares``, with our analytic
  derivative in the plane and differences in space, and basic-robotics' Newton for six legs.

cdpyr is on no package index and uses names that NumPy dropped before the release this package needs, so that the two
cannot be imported together.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib.util
import io
import itertools
import json
import math
import os
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "mechanics"))

import numpy as np  # noqa: E402
from published_robots import COGIRO, IPANEMA_2, KNTU, PLANAR_4_4, TABLE_III, Published  # noqa: E402
from scipy.optimize import least_squares, linprog  # noqa: E402
from scipy.spatial import ConvexHull  # noqa: E402
from tension_questions import published  # noqa: E402

from steeplejack.mechanics.cable import (  # noqa: E402
    capacity_margin,
    planar_lengths,
    planar_structure_matrix,
    spatial_lengths,
    track_planar,
    track_spatial,
    wrench_feasible,
)
from steeplejack.spatial import from_vector  # noqa: E402

PEERS = {"pycapacity": "pycapacity", "basic_robotics": "basic-robotics"}
"""Modules of the peers, and what pip calls them."""

POSES = 2000
FEW = 30  # poses for peers that take one a call
ROUNDS = 5
BAND = 1e-6


@dataclass(frozen=True)
class Row:
    """One question to us and to a peer.

    Attributes:
        question: What was asked.
        robot: Of which robot.
        peer: Who else.
        ours: Poses a second.
        theirs: Poses a second.
        apart: Greatest difference of the answers, in the unit named; a count for yes or no.
        unit: Of ``apart``.
    """

    question: str
    robot: str
    peer: str
    ours: float
    theirs: float
    apart: float
    unit: str


def installed(module: str) -> bool:
    return importlib.util.find_spec(module) is not None


def race(ours: Callable[[], object], theirs: Callable[[], object], poses: tuple[int, int]) -> tuple[float, float]:
    """Poses a second of either, taking turns; both have run before, so that nothing is compiled here."""
    best = [math.inf, math.inf]
    for _ in range(ROUNDS):
        for side, run in enumerate((ours, theirs)):
            began = time.perf_counter()
            run()
            best[side] = min(best[side], time.perf_counter() - began)
    return poses[0] / best[0], poses[1] / best[1]


def by_pycapacity(structure, wrench, lower, upper):
    from pycapacity.algorithms import hyper_plane_shift_method

    normals, reaches = hyper_plane_shift_method(structure, lower, upper)
    return np.min((np.ravel(reaches) + normals @ wrench) / np.linalg.norm(normals, axis=1))


def by_hull(structure, wrench, lower, upper):
    corners = np.array(list(itertools.product(*zip(lower, upper, strict=True))))
    planes = ConvexHull(corners @ structure.T).equations
    return np.min(planes[:, :-1] @ wrench - planes[:, -1])


def by_highs(structure, wrench, lower, upper):
    bounds = list(zip(lower, upper, strict=True))
    return linprog(np.zeros(lower.size), A_eq=structure, b_eq=-wrench, bounds=bounds).status == 0


def margins(robot: Published) -> list[Row]:
    """Capacity margins at random poses, under gravity."""
    asked = published(robot, np.random.default_rng(5), POSES)
    structures, weights, lower, upper = asked
    routes = {"SciPy, Qhull": by_hull} | ({"pycapacity": by_pycapacity} if installed("pycapacity") else {})
    ours = capacity_margin(structures, lower, upper, weights)
    rows = []
    for peer, route in routes.items():

        def each(route=route):
            return [route(*question) for question in itertools.islice(zip(*asked, strict=True), FEW)]

        apart = float(np.abs(np.array(each()) - ours[:FEW]).max())
        rates = race(lambda: capacity_margin(structures, lower, upper, weights), each, (POSES, FEW))
        rows.append(Row("capacity margin", robot.name, peer, *rates, apart, "N"))
    return rows


def feasibility(robot: Published) -> list[Row]:
    """Whether gravity is held at random poses."""
    asked = published(robot, np.random.default_rng(6), POSES)
    structures, weights, lower, upper = asked
    ours = wrench_feasible(structures, lower, upper, weights)

    def each():
        return [by_highs(*question) for question in itertools.islice(zip(*asked, strict=True), FEW)]

    different = (np.array(each()) != ours.feasible[:FEW]) & (np.abs(ours.margin[:FEW]) > BAND)
    rates = race(lambda: wrench_feasible(structures, lower, upper, weights), each, (POSES, FEW))
    return [Row("wrench feasibility", robot.name, "HiGHS (SciPy)", *rates, int(different.sum()), "poses")]


def planar_tracking() -> Row:
    """A stream of lengths of Table III."""
    t, robot = np.linspace(0.0, 5.0, POSES), (TABLE_III.anchors, TABLE_III.attachments)
    poses = np.stack((-0.1 + 0.05 * np.sin(t / 3), 0.45 + 0.05 * np.cos(t / 2), 0.87 + 0.05 * np.sin(t)), axis=-1)
    lengths = planar_lengths(*robot, poses)

    def scipy():
        found = [poses[0]]
        for wanted in lengths[:FEW]:
            answer = least_squares(
                lambda x, wanted=wanted: planar_lengths(*robot, x) - wanted,
                found[-1],
                jac=lambda x: -planar_structure_matrix(*robot, x).T,
                method="lm",
            )
            found.append(answer.x)
        return np.array(found[1:])

    ours = track_planar(lengths, *robot, poses[0], follow=True)
    apart = float(np.abs(ours.pose[:FEW, :2] - scipy()[:, :2]).max())
    rates = race(lambda: track_planar(lengths, *robot, poses[0], follow=True), scipy, (POSES, FEW))
    return Row("forward kinematics", "Table III, 4 cables", "SciPy, least_squares", *rates, apart, "m")


def six_legs():
    """A platform on six legs, a path of it, and its lengths: what both cables and struts can be asked."""
    ground, top = (np.deg2rad(angles) for angles in ([10, 110, 130, 230, 250, 350], [50, 70, 170, 190, 290, 310]))
    anchors, attachments = (
        np.stack((radius * np.cos(a), radius * np.sin(a), 0.0 * a), axis=-1)
        for radius, a in ((2.0, ground), (1.0, top))
    )
    t = np.linspace(0.0, 5.0, POSES)
    places = np.stack((0.3 * np.sin(t), 0.3 * np.cos(t / 2), 3.0 + 0.2 * np.sin(t / 3)), axis=-1)
    turns = np.array([from_vector(0.1 * np.array([np.sin(s), np.cos(s / 2), np.sin(s / 7)])) for s in t])
    return anchors, attachments, places, turns, spatial_lengths(anchors, attachments, places, turns)


def by_least_squares(anchors, attachments, places, turns, lengths):
    def left(x, wanted):
        return spatial_lengths(anchors, attachments, x[:3], from_vector(x[3:]) @ turns[0]) - wanted

    found = [np.append(places[0], np.zeros(3))]
    for wanted in lengths[:FEW]:
        found.append(least_squares(left, found[-1], args=(wanted,), method="lm").x)
    return np.array(found[1:])[:, :3]


def by_basic_robotics(anchors, attachments, places, _turns, _lengths):
    """A function that follows the lengths; the object is made, and its kernels compiled, beforehand."""
    from basic_robotics.general import tm
    from basic_robotics.kinematics.sp_model import SP

    start = tm([*places[0], 0.0, 0.0, 0.0])
    machine = SP(anchors.T.copy(), attachments.T.copy(), tm(), start, 0.5, 9.0, 0.0, 0.0, "six legs")

    def follow(lengths):
        return np.array([machine.FK(wanted, protect=True)[0].TM[:3, 3] for wanted in lengths[:FEW]])

    return follow


def spatial_tracking() -> list[Row]:
    """A stream of six lengths."""
    question = six_legs()
    anchors, attachments, places, turns, lengths = question
    peers: dict[str, Callable[[], np.ndarray]] = {"SciPy, least_squares": lambda: by_least_squares(*question)}
    if installed("basic_robotics"):
        follow = by_basic_robotics(*question)
        peers["basic-robotics"] = lambda: follow(lengths)

    def ours():
        return track_spatial(lengths, anchors, attachments, places[0], turns[0], follow=True)

    rows = []
    for peer, run in peers.items():
        run()
        apart = float(np.abs(ours().position[:FEW] - run()).max())
        rows.append(Row("forward kinematics", "six legs", peer, *race(ours, run, (POSES, FEW)), apart, "m"))
    return rows


def measure() -> list[Row]:
    rows: list[Row] = []
    for robot in (PLANAR_4_4, KNTU, IPANEMA_2, COGIRO):
        rows += margins(robot)
    for robot in (PLANAR_4_4, IPANEMA_2, COGIRO):
        rows += feasibility(robot)
    return [*rows, planar_tracking(), *spatial_tracking()]


def table(rows: list[Row]) -> str:
    lines = [
        "| question | robot | peer | its poses/s | ours | ratio | apart |",
        "| --- | --- | --- | ---: | ---: | ---: | ---: |",
    ]
    for row in rows:
        apart = f"{row.apart:d}" if isinstance(row.apart, int) else f"{row.apart:.0e}"
        lines.append(
            f"| {row.question} | {row.robot} | {row.peer} | {row.theirs:,.3g} | {row.ours / 1e3:,.4g} k "
            f"| {row.ours / row.theirs:,.3g} x | {apart} {row.unit} |"
        )
    return "\n".join(lines)


def main() -> None:
    options = argparse.ArgumentParser(description="This package against others that pip can install.")
    options.add_argument("--json", action="store_true", help="one JSON object instead of the table")
    given = options.parse_args()
    missing = [f"{name}: not installed, left out; pip install {name}" for m, name in PEERS.items() if not installed(m)]
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):  # what peers say on their own
        warnings.simplefilter("ignore")
        rows = measure()
    if given.json:
        print(json.dumps({"rows": [asdict(row) for row in rows], "left_out": missing}))
        return
    print("\n".join((table(rows), *missing)))


if __name__ == "__main__":
    main()
