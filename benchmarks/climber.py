"""Kinematics of the pipe climber: poses or triples a second, one thread, one run, ratios to the peers.

    python benchmarks/climber.py [--json]

- ``forward``: every real pose of three lengths, polished. Peers: the same cubic by ``numpy.roots`` for each triple and
  Newton's method on the lengths, and the same algebra in NumPy over the whole batch, Newton's method included.
  Bound of the requirement: 2 M triples a second.
- ``inverse``: limb lengths of poses; peers: NumPy over the whole batch, and MuJoCo's forward position kinematics of the
  same mechanism (which does more: frames of every body).
- ``jacobian``: peer: NumPy over the whole batch.
- ``certified``: the proof with FLINT, for scale.

All routes are checked against each other before they are timed. Times are of this process (CPU), the best of several
rounds taken in turns, so that other work on the machine counts less.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable

os.environ.setdefault("OMP_NUM_THREADS", "1")

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

from steeplejack.robots.pipe_climber import Layout  # noqa: E402
from steeplejack.robots.pipe_climber.certificate import certified_poses  # noqa: E402
from steeplejack.robots.pipe_climber.forward import forward_kinematics  # noqa: E402
from steeplejack.robots.pipe_climber.inverse import limb_lengths  # noqa: E402
from steeplejack.robots.pipe_climber.jacobian import jacobian  # noqa: E402

LAYOUT = Layout((0.100, 0.100, 0.075, 0.075))
L1, L2, L3, L4 = LAYOUT.lengths
B2, B3 = L3, L1
K = B2 * (L2 - L4) + B3 * L4
BATCH, FEW, ROUNDS = 500_000, 400, 5
BOUND = 2e6  # [triples/s]
MODEL = """<mujoco><worldbody>
  {limbs}
  <body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>
  <geom size="0.01"/></body>
</worldbody></mujoco>"""
LIMB = """<body pos="{b} 0 0"><joint type="hinge" axis="0 1 0"/><geom size="0.01"/>
  <body><joint type="slide" axis="0 0 1"/><geom size="0.01"/></body></body>"""


def fastest(contestants: dict[str, tuple[Callable[[], object], int]]) -> dict[str, float]:
    """Best rate of each [1/s], rounds taken in turns; the first call, which compiles, does not count."""
    for call, _ in contestants.values():
        call()
    best = dict.fromkeys(contestants, np.inf)
    for _ in range(ROUNDS):
        for name, (call, count) in contestants.items():
            began = time.process_time()
            call()
            best[name] = min(best[name], (time.process_time() - began) / count)
    return {name: 1.0 / seconds for name, seconds in best.items()}


def cubic(lengths: np.ndarray) -> tuple[np.ndarray, ...]:
    """Coefficients of the cubic in cos(alpha), and R, x, v at 0 and their slopes."""
    g1, g2, g3 = (lengths**2 - [L4**2, B2**2, L2**2 + B3**2]).T
    r0, slope = (L2 * B2 * g1 + B3 * L4 * g2 - L4 * B2 * g3) / K, -2.0 * B2 * B3 * L2 * L4 / K
    x0, v0, xs, vs = (g2 - r0) / (2 * B2), (r0 - g1) / (2 * L4), -slope / (2 * B2), slope / (2 * L4)
    a3 = np.full_like(r0, 2 * xs * vs - slope)
    a2, a1 = 2 * (x0 * vs + xs * v0) - r0 - xs**2 - vs**2, slope + 2 * (x0 * v0 - x0 * xs - v0 * vs)
    return a3, a2, a1, r0 - x0**2 - v0**2, x0, np.full_like(r0, xs), v0, np.full_like(r0, vs)


def newton(lengths: np.ndarray, pose: np.ndarray, steps: int) -> np.ndarray:
    """Newton's method on the lengths over a batch."""
    for _ in range(steps):
        step = np.linalg.solve(numpy_jacobian(pose), (numpy_lengths(pose) - lengths)[..., None])[..., 0]
        pose = pose - np.where(np.isfinite(step), step, 0.0)
    return pose


def one_by_one(lengths: np.ndarray) -> list[np.ndarray]:
    """numpy.roots for each triple, and Newton's method from every root."""
    found = []
    for triple, *coefficients in zip(lengths, *cubic(lengths), strict=True):
        a3, a2, a1, a0, x0, xs, v0, vs = coefficients
        roots = np.roots([a3, a2, a1, a0])
        c = np.sort(roots[(np.abs(roots.imag) < 1e-9) & (np.abs(roots) <= 1.0 + 1e-12)].real)[::-1].clip(-1.0, 1.0)
        s = np.maximum(np.sqrt(1.0 - c**2), 1e-9)
        product = (x0 + xs * c) * c - v0 - vs * c
        pose = np.stack((x0 + xs * c, np.abs(product) / s, np.copysign(np.arccos(c), product)), axis=-1)
        if len(pose):
            pose = newton(triple, pose, 2)
        found.append(np.concatenate((pose, pose * [1.0, -1.0, -1.0])))
    return found


def vectorised(lengths: np.ndarray) -> np.ndarray:
    """The same algebra over the whole batch: trigonometric roots of the cubic, then Newton's method."""
    a3, a2, a1, a0, x0, xs, v0, vs = cubic(lengths)
    with np.errstate(all="ignore"):
        p, q = a2 / (3 * a3), a1 / a3
        spread = np.sqrt(p * p - q / 3)
        angle = np.arccos(-(2 * p**3 - p * q + a0 / a3) / (2 * spread**3)) / 3
        roots = 2 * spread * np.cos(angle - 2 * np.pi / 3 * np.arange(3)[:, None]) - p
        roots = np.sort(np.where(np.abs(roots) <= 1.0 + 1e-12, roots, -np.inf), axis=0)[:0:-1].clip(-1.0, 1.0)
        c = np.where(np.isfinite(angle), roots, np.nan)
        s = np.maximum(np.sqrt(1.0 - c * c), 1e-9)
        product = (x0 + xs * c) * c - v0 - vs * c
        pose = np.stack((x0 + xs * c, np.abs(product) / s, np.copysign(np.arccos(c), product)), axis=-1)
        alive = np.isfinite(pose[0, :, 0])
        polished = np.full_like(pose, np.nan)
        polished[:, alive] = newton(lengths[alive], pose[:, alive], 2)
    return np.concatenate((polished, polished * [1.0, -1.0, -1.0])).swapaxes(0, 1)


def numpy_lengths(poses: np.ndarray) -> np.ndarray:
    x, w, alpha = np.moveaxis(poses, -1, 0)[..., None]
    return np.hypot(x + LAYOUT.platform * np.cos(alpha) - LAYOUT.base, w - LAYOUT.platform * np.sin(alpha))


def numpy_jacobian(poses: np.ndarray) -> np.ndarray:
    x, w, alpha = np.moveaxis(poses, -1, 0)[..., None]
    r_x, r_z = LAYOUT.platform * np.cos(alpha), -LAYOUT.platform * np.sin(alpha)
    d_x, d_z = x + r_x - LAYOUT.base, w + r_z
    length = np.hypot(d_x, d_z)
    return np.stack((d_x, d_z, r_z * d_x - r_x * d_z), axis=-1) / length[..., None]


def engine(poses: np.ndarray) -> Callable[[], None]:
    """MuJoCo's position kinematics of limbs and platform, a pose at a time."""
    model = mujoco.MjModel.from_xml_string(MODEL.format(limbs="".join(LIMB.format(b=b) for b in LAYOUT.base)))
    data = mujoco.MjData(model)

    def call() -> None:
        for pose in poses:
            data.qpos[-3:] = pose
            mujoco.mj_kinematics(model, data)

    return call


def triples(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Poses of the working mode, small turns, and their lengths."""
    poses = rng.uniform([-0.06, 0.10, -0.6], [0.06, 0.22, 0.6], (BATCH, 3))
    return poses, limb_lengths(LAYOUT, poses)


def check(poses: np.ndarray, lengths: np.ndarray) -> None:
    """Every route finds the pose the lengths were made from."""
    assert np.abs(forward_kinematics(LAYOUT, lengths).of("home") - poses).max() < 1e-9
    assert np.abs(vectorised(lengths)[:, 0] - forward_kinematics(LAYOUT, lengths).of("home")).max() < 1e-8
    roots = np.array([found[0] for found in one_by_one(lengths[:FEW])])
    assert np.abs(roots - poses[:FEW]).max() < 1e-8
    assert np.abs(numpy_lengths(poses) - lengths).max() < 1e-15
    assert np.abs(numpy_jacobian(poses) - jacobian(LAYOUT, poses)).max() < 1e-14


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of the table")
    as_json = parser.parse_args().json
    poses, lengths = triples(np.random.default_rng(5))
    check(poses, lengths)
    certified = [triple.tolist() for triple in lengths[:FEW]]
    groups = {
        "forward": {
            "kernel": (lambda: forward_kinematics(LAYOUT, lengths), BATCH),
            "numpy, same algebra": (lambda: vectorised(lengths), BATCH),
            "numpy.roots and Newton": (lambda: one_by_one(lengths[:FEW]), FEW),
            "FLINT, proved": (lambda: [certified_poses(LAYOUT, triple) for triple in certified], FEW),
        },
        "inverse": {
            "kernel": (lambda: limb_lengths(LAYOUT, poses), BATCH),
            "numpy": (lambda: numpy_lengths(poses), BATCH),
            "MuJoCo": (engine(poses[:20_000]), 20_000),
        },
        "jacobian": {
            "kernel": (lambda: jacobian(LAYOUT, poses), BATCH),
            "numpy": (lambda: numpy_jacobian(poses), BATCH),
        },
    }
    rates = {group: fastest(contestants) for group, contestants in groups.items()}
    if as_json:
        print(json.dumps({"bound_triples_s": BOUND, **rates}))
        return
    for group, found in rates.items():
        for name, rate in found.items():
            print(f"{group:<10}{name:<26}{rate / 1e6:10.4f} M/s   kernel is {found['kernel'] / rate:8.1f} x")
    print(f"forward kernel against the bound of {BOUND / 1e6:g} M/s: {rates['forward']['kernel'] / BOUND:.2f} x")


if __name__ == "__main__":
    main()
