"""Geometry of the published robots the tests share, and seeded random poses inside each.

Planar 4-4, IPAnema 2: CASPR models `4_4_CDPR_planar` and `IPAnema_2` (set original). KNTU planar: Aref et al. CoGiRo:
Gouttefarde et al. CCRobot-S: Zheng et al., IEEE T-RO, Table III. Metres, newtons, kilograms.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

GRAVITY = 9.81


@dataclass(frozen=True)
class Published:
    """A robot, the box its test poses are drawn from, its tension window and the load it carries."""

    name: str
    anchors: np.ndarray
    attachments: np.ndarray
    low: np.ndarray  # position [m], then angle [rad]: planar heading, or the largest turn about a random axis
    high: np.ndarray
    window: tuple[float, float]
    mass: float
    centre: np.ndarray

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return self.anchors.shape[1]

    def poses(self, rng: np.random.Generator, count: int):
        """Random poses: planar (k, 3); spatial positions (k, 3) and rotations (k, 3, 3)."""
        drawn = rng.uniform(self.low, self.high, (count, self.low.size))
        if self.dimension == 2:
            return drawn
        axis = rng.normal(size=(count, 3))
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        return drawn[:, :3], rotations(axis * drawn[:, 3:])


def rotations(vectors):
    """Rotation matrices of rotation vectors (k, 3) by Rodrigues' formula."""
    angle = np.linalg.norm(vectors, axis=-1)[:, None, None]
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    skew = np.stack((zero, -z, y, z, zero, -x, -y, x, zero), axis=-1).reshape(-1, 3, 3)
    return np.eye(3) + np.sinc(angle / np.pi) * skew + 0.5 * np.sinc(angle / 2.0 / np.pi) ** 2 * skew @ skew


def _robot(name, anchors, attachments, low, high, window, mass, centre):
    return Published(
        name, *(np.array(v, dtype=float) for v in (anchors, attachments, low, high)), window, mass, np.array(centre)
    )


PLANAR_4_4 = _robot(
    "planar 4-4",
    [[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [0.0, 6.0]],
    [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]],
    [0.1, 0.1, -0.3],
    [9.9, 5.9, 0.3],
    (10.0, 500.0),
    20.0,
    [0.03, 0.02],
)
KNTU = _robot(
    "KNTU planar",
    [[-1.12, -1.05], [-1.12, 1.05], [1.12, -1.05], [1.12, 1.05]],
    [[-0.15, 0.0], [-0.15, 0.0], [0.15, 0.0], [0.15, 0.0]],
    [-1.1, -1.0, -0.6],
    [1.1, 1.0, 0.6],
    (5.0, 200.0),
    4.5,
    [0.0, 0.01],
)
TABLE_III = _robot(
    "CCRobot-S Table III",
    [[0.0, 0.0], [0.4024, 0.4045], [-0.3522, 0.8966], [-0.6244, 0.6244]],
    [[-0.095, -0.095], [0.095, -0.095], [0.095, 0.095], [-0.095, 0.095]],
    [-0.6, 0.05, np.deg2rad(30.0)],
    [0.35, 0.85, np.deg2rad(70.0)],
    (10.0, 500.0),
    30.0,
    [0.0, 0.0],
)
IPANEMA_2 = _robot(
    "IPAnema 2",
    [[x, y, z] for z in (5.0, 1.0) for x, y in ((-4.0, 3.0), (4.0, 3.0), (4.0, -3.0), (-4.0, -3.0))],
    [[x, y, 0.25] for x, y in ((-0.65, 0.125), (0.65, 0.125), (0.65, -0.125), (-0.65, -0.125))]
    + [[x, y, 0.75] for x, y in ((-0.75, 0.10), (0.75, 0.10), (0.75, -0.10), (-0.75, -0.10))],
    [-3.5, -2.7, 0.5, -0.5],
    [3.5, 2.7, 4.5, 0.5],
    (0.0, 200.0),
    10.0,
    [0.0, 0.0, 0.0],
)
COGIRO = _robot(
    "CoGiRo",
    [
        [-7.1775, -5.4361, 5.3911], [-7.4594, -5.1504, 5.3999], [-7.3911, 5.1940, 5.3976], [-7.1026, 5.4753, 5.4094],
        [7.2398, 5.3759, 5.4093], [7.5208, 5.0851, 5.4200], [7.4461, -5.2539, 5.3874], [7.1608, -5.5342, 5.3973],
    ],
    [
        [0.5032, -0.4928, 0.0], [-0.5097, 0.3508, 0.9976], [-0.5032, -0.27, 0.0], [0.4960, 0.3561, 0.9996],
        [-0.5032, 0.4928, 0.0], [0.4998, -0.3404, 0.9991], [0.5021, 0.2750, -0.0007], [-0.5045, -0.3463, 0.9976],
    ],
    [-6.5, -4.5, 0.0, -0.4],
    [6.5, 4.5, 4.0, 0.4],
    (100.0, 5000.0),
    91.058,
    [-0.034, -0.013, 0.264],
)  # fmt: skip

PLANAR = (PLANAR_4_4, KNTU, TABLE_III)
SPATIAL = (IPANEMA_2, COGIRO)
