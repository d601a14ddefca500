"""Forward kinematics and its relatives: time for each answer, one thread, one run, against SciPy where it has a route.

    python benchmarks/forward.py [--json]

- ``track``: a stream of noisy lengths followed from pose to pose; SciPy's ``least_squares`` with the analytic
  derivative on a sample of the same stream is the peer. Bound of the requirement: 5 us a pose.
- ``every pose``: branch and bound over all poses there are (planar), over a stated box (spatial), straight and over
  pulleys.
- ``forward``: one answer of `forward_kinematics`, several hundred starts included.
- ``settle`` and ``lost cable``: equilibria on locked winches; SciPy's SLSQP on the same lost cable is the peer.

Times are of this process (CPU), the best of several rounds, so that other work on the machine counts less.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np  # noqa: E402
from scipy.optimize import least_squares, minimize  # noqa: E402

from steeplejack.mechanics.cable import (  # noqa: E402
    LockedPlatform,
    every_planar_pose,
    every_spatial_pose,
    forward_kinematics,
    locked_at,
    lost_cable_map,
    planar_lengths,
    planar_structure_matrix,
    pulley_runs,
    settle,
    spatial_lengths,
    track_planar,
    track_spatial,
)
from steeplejack.spatial import from_vector  # noqa: E402

ANCHORS = np.array([[0.0, 0.0], [0.4024, 0.4045], [-0.3522, 0.8966], [-0.6244, 0.6244]])
ATTACHMENTS = np.array([[-0.095, -0.095], [0.095, -0.095], [0.095, 0.095], [-0.095, 0.095]])
CORNERS = np.array([[-1, 1], [1, 1], [1, -1], [-1, -1]])
IPANEMA = np.array([[4.0 * x, 3.0 * y, z] for z in (5.0, 1.0) for x, y in CORNERS])
UPPER, LOWER = ((0.65, 0.125, 0.25), (0.75, 0.1, 0.75))
IPANEMA_LOCAL = np.array([[a * x, b * y, z] for a, b, z in (UPPER, LOWER) for x, y in CORNERS])
POSES, ROUNDS = 20_000, 5


def best(call: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Least CPU time of several calls [s], after one that compiles."""
    call()
    times = []
    for _ in range(rounds):
        began = time.process_time()
        call()
        times.append(time.process_time() - began)
    return min(times)


def planar(rng: np.random.Generator) -> dict[str, float]:
    """Tracking Table III, and SciPy on a sample."""
    t = np.linspace(0.0, 50.0, POSES)
    poses = np.stack((-0.1 + 0.05 * np.sin(t / 3), 0.45 + 0.05 * np.cos(t / 2), 0.87 + 0.05 * np.sin(t)), axis=-1)
    lengths = planar_lengths(ANCHORS, ATTACHMENTS, poses) + rng.normal(0.0, 1e-5, (POSES, 4))
    ours = best(lambda: track_planar(lengths, ANCHORS, ATTACHMENTS, poses[0], follow=True)) / POSES

    def peer() -> None:
        x = poses[0]
        for k in range(200):
            x = least_squares(
                lambda x, k=k: planar_lengths(ANCHORS, ATTACHMENTS, x) - lengths[k],
                x,
                jac=lambda x: -planar_structure_matrix(ANCHORS, ATTACHMENTS, x).T,
                method="lm",
            ).x

    theirs = best(peer, 2) / 200
    every = best(lambda: every_planar_pose(lengths[0], ANCHORS, ATTACHMENTS, tolerance=1e-4))
    once = best(lambda: forward_kinematics(lengths[0], ANCHORS, ATTACHMENTS, poses[0]))
    return {
        "forward_planar_ms": 1e3 * once,
        "track_planar_us": 1e6 * ours,
        "scipy_least_squares_planar_us": 1e6 * theirs,
        "every_pose_planar_ms": 1e3 * every,
    }


def spatial(rng: np.random.Generator) -> dict[str, float]:
    """Tracking IPAnema 2, straight and over pulleys, and every pose of two boxes."""
    t = np.linspace(0.0, 50.0, POSES)
    positions = np.stack((np.sin(t / 3), np.cos(t / 2), 2.5 + 0.5 * np.sin(t / 5)), axis=-1)
    turns = 0.1 * np.stack((np.sin(t), np.cos(t / 2), np.sin(t / 7)), axis=-1)
    rotations = np.array([from_vector(turn) for turn in turns])
    start, robot = (positions[0], rotations[0]), (IPANEMA, IPANEMA_LOCAL)
    lengths = spatial_lengths(IPANEMA, IPANEMA_LOCAL, positions, rotations) + rng.normal(0.0, 1e-4, (POSES, 8))
    straight = best(lambda: track_spatial(lengths, IPANEMA, IPANEMA_LOCAL, *start, follow=True)) / POSES
    ends = positions[:, None] + np.einsum("kij,mj->kmi", rotations, IPANEMA_LOCAL)
    wheels = {"radii": np.full(8, 0.05), "axes": np.tile([0.0, 0.0, 1.0], (8, 1))}
    wound, _along = pulley_runs(IPANEMA, wheels["axes"], wheels["radii"], ends)
    pulleys = best(lambda: track_spatial(wound, IPANEMA, IPANEMA_LOCAL, *start, follow=True, **wheels)) / POSES
    boxes = [
        best(lambda w=w, a=a: every_spatial_pose(lengths[0], *robot, start[0], np.eye(3), w, a, tolerance=1e-3), 2)
        for w, a in ((0.3, 0.3), (1.0, 0.7))
    ]
    once = best(lambda: forward_kinematics(lengths[0], *robot, start[0]))
    narrow = (start[0], np.eye(3), 0.3, 0.3)
    over_pulleys = best(lambda: every_spatial_pose(wound[0], *robot, *narrow, tolerance=1e-3, **wheels), 2)
    return {
        "forward_spatial_ms": 1e3 * once,
        "every_pose_spatial_pulleys_0.3m_0.3rad_ms": 1e3 * over_pulleys,
        "track_spatial_us": 1e6 * straight,
        "track_spatial_pulleys_us": 1e6 * pulleys,
        "every_pose_spatial_0.3m_0.3rad_ms": 1e3 * boxes[0],
        "every_pose_spatial_1m_0.7rad_ms": 1e3 * boxes[1],
    }


def resting() -> dict[str, float]:
    """Equilibria of IPAnema 2 on elastic cables, and lost cables over a grid of Table III."""
    place, turn = np.array([0.3, -0.2, 2.4]), np.eye(3)
    hung = LockedPlatform.spatial(IPANEMA, IPANEMA_LOCAL, 1.0, [0.0, 0.0, -98.1], axial_stiffness=1e5)
    hung = locked_at(hung, place, turn, 20.0)
    rest = best(lambda: settle(hung, place, turn))
    x, y = np.meshgrid(np.arange(-0.5, 0.3, 0.05), np.arange(0.1, 0.9, 0.05))
    places, angles = np.stack((x.ravel(), y.ravel()), axis=-1), np.full(x.size, np.deg2rad(50.0))
    platform = LockedPlatform.planar(ANCHORS, ATTACHMENTS, 1.0, [0.0, -294.3])
    falls = best(lambda: lost_cable_map(platform, places, angles), 2) / (4 * x.size)
    pose = np.array([-0.23074604, 0.55283179, np.deg2rad(50.0)])
    locked = planar_lengths(ANCHORS, ATTACHMENTS, pose)
    keep = [0, 2, 3]
    ends = {"type": "ineq", "fun": lambda x: (locked - planar_lengths(ANCHORS, ATTACHMENTS, x))[keep]}
    slsqp = best(lambda: minimize(lambda x: x[1], pose, constraints=ends, method="SLSQP"), 2)
    return {
        "settle_spatial_us": 1e6 * rest,
        "lost_cable_planar_us": 1e6 * falls,
        "scipy_slsqp_lost_cable_us": 1e6 * slsqp,
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    rng = np.random.default_rng(0)
    rows = {name: round(value, 3) for name, value in (planar(rng) | spatial(rng) | resting()).items()}
    if asked.json:
        print(json.dumps(rows))
        return
    for name, value in rows.items():
        print(f"{name:<44}{value:>12.2f}")


if __name__ == "__main__":
    main()
