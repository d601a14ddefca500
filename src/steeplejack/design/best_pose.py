"""The pose of the largest tension factor, exactly: the continuous maximum behind a map's best node (Eq. 13).

TF is a ratio of a smallest and a largest component, so its maximum sits on a kink where gradients jump. In the form
"largest t with ``n_i >= t n_j`` for every pair" all functions are smooth, and sequential quadratic programming started
at the best node of a coarse grid reaches it in a few steps. TF = 1 exactly where ``J^T (1, 1, 1, 1) = 0``.

Source: Zheng et al., CCRobot-S, IEEE T-RO, Eq. 10-13, with the sign of Eq. 12 kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InfeasibleError
from steeplejack.mechanics.cable.region.grid import best_node
from steeplejack.mechanics.cable.structure import planar_structure_matrix
from steeplejack.mechanics.cable.wrench.closure import null_vector, tension_factor

Array = NDArray[np.float64]

PAIRS = ~np.eye(4, dtype=np.bool_)
ORIENTATIONS = np.deg2rad(np.arange(-180.0, 180.0, 3.0))


@dataclass(frozen=True)
class BestPose:
    """A pose and its tension factor.

    Attributes:
        pose: ``(x, y, phi)``, (3,) [m, m, rad].
        tension_factor: TF there [1].
    """

    pose: Array
    tension_factor: float


def best_pose(anchors: ArrayLike, attachments: ArrayLike, phi: float | None = None) -> BestPose:
    """Pose of the largest tension factor inside the anchors' box.

    Args:
        anchors: (4, 2) [m].
        attachments: In the platform frame, (4, 2) [m].
        phi: Orientation to keep [rad]; free if None.

    Returns:
        The maximum nearest to the best node of a coarse grid.

    Raises:
        InfeasibleError: No node of the grid is in wrench closure.
    """
    fixed, local = np.asarray(anchors, dtype=np.float64), np.asarray(attachments, dtype=np.float64)
    node, coarse = best_node(fixed, local, ORIENTATIONS if phi is None else [phi])
    if coarse == 0.0:
        where = "any orientation" if phi is None else f"phi = {np.rad2deg(phi):g} deg"
        raise InfeasibleError("best pose", f"no pose inside the anchors' box is in wrench closure at {where}")
    pose = _climb(fixed, local, node, 2 if phi is not None else 3)
    factor = float(tension_factor(planar_structure_matrix(fixed, local, pose)))
    return BestPose(pose, factor) if factor >= coarse else BestPose(node, coarse)


def _climb(anchors: Array, attachments: Array, start: Array, free: int) -> Array:
    """Largest t with ``n_i >= t n_j``, over the first ``free`` pose coordinates, from a pose in wrench closure."""
    from scipy.optimize import minimize  # heavy, and only searches need it

    scale = np.array([*np.ptp(anchors, axis=0), 1.0])[:free]

    def pose(unknowns: Array) -> Array:
        return start + np.concatenate((unknowns[:-1] * scale, np.zeros(3 - free)))

    def slack(unknowns: Array) -> Array:
        null = null_vector(planar_structure_matrix(anchors, attachments, pose(unknowns)))
        share = null / null.sum()
        return (share[:, None] - unknowns[-1] * share)[PAIRS]

    slope = np.concatenate((np.zeros(free), [-1.0]))
    guess = np.concatenate((np.zeros(free), [tension_factor(planar_structure_matrix(anchors, attachments, start))]))
    found = minimize(
        lambda unknowns: -unknowns[-1],
        guess,
        jac=lambda _: slope,
        method="SLSQP",
        constraints={"type": "ineq", "fun": slack},
        options={"ftol": 1e-15, "maxiter": 200},
    )
    return pose(found.x)
