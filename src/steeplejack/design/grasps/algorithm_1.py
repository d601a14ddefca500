"""Algorithm 1: the grasp on a grid, nearest to the axis among those of nearly the largest tension factor.

A threshold falls from 1 in steps of ``kappa`` until a node of the region in wrench closure reaches it; of the nodes
that do, the one nearest to the axis is the answer. So it trades up to one step of tension factor for distance.

Read differently from the print: line 6 means the tension factor of the node (Eq. 12), not its maximum (Eq. 13); the
distance of line 17 is perpendicular; the step of the threshold is a number of its own (``epsilon`` is also a side of
the region); a region without a node in wrench closure is an answer instead of a loop without end. The first threshold
reached follows from the largest tension factor, so nothing is repeated for it. Of nodes equally near, the one with the
larger tension factor counts.

Source: Zheng et al., CCRobot-S, IEEE T-RO, Algorithm 1 and Eq. 19-20.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.grasps.question import Grasp, GraspQuestion
from steeplejack.errors import InputError
from steeplejack.mechanics.cable.region.grid import grid_nodes, tension_factor_grid

Array = NDArray[np.float64]

MOST_NODES = 20_000_000  # [1] of the box about the region; a few arrays of that size are held
MOST_STEPS = 1e8  # [1] of the threshold, beyond which it is as good as continuous
ROUNDING = 1e-9  # [1] of a step: how far outside a node on the border may seem to lie


def grasp_on_grid(question: GraspQuestion, step: float, kappa: float) -> Grasp:
    """Algorithm 1 on nodes at the integer multiples of a step, counted from the worksite's origin.

    Args:
        question: Robot, orientation and region.
        step: Distance of nodes [m].
        kappa: Step of the threshold [1].

    Returns:
        The grasp; ``evaluations`` counts the nodes in the region.

    Raises:
        InputError: A step that is not positive or too fine for memory, a kappa that is not positive.
        InfeasibleError: No node in the region, or none of them in wrench closure.
    """
    xs, ys = _axes(question, step)
    if not 0.0 < kappa < math.inf:
        raise InputError("kappa", f"{kappa:g}", "a finite number above 0")
    x, y = np.meshgrid(xs, ys)
    region = question.region
    away = np.abs(region.coordinates(np.stack((x, y), axis=-1)))
    inside = np.all(away <= np.array([region.half_length, region.half_width]) + ROUNDING * step, axis=-1)
    nodes = np.stack((x[inside], y[inside]), axis=-1)
    if not len(nodes):
        raise question.no_grasp(f"no node of the grid of {step:g} m lies in the region")
    factors = tension_factor_grid(question.anchors, question.attachments, question.phi, xs, ys)[inside]
    if not factors.max() > 0.0:
        raise question.no_grasp(f"none of the {len(nodes)} nodes in the region is in wrench closure")
    reached = np.flatnonzero((factors > 0.0) & (factors >= _threshold(float(factors.max()), kappa)))
    # Nodes either side of the axis are equally far but for rounding.
    rank = np.rint(away[inside][reached, 1] / (ROUNDING * step))
    best = reached[np.lexsort((-factors[reached], rank))[0]]
    where = nodes[best]
    return Grasp(where, float(factors[best]), float(region.distance(where)), len(nodes), None)


def _threshold(most: float, kappa: float) -> float:
    """The first of ``1 - kappa, 1 - 2 kappa, ...`` that is not above the largest tension factor."""
    steps = (1.0 - most) / kappa
    if not steps < MOST_STEPS:
        return most
    count = max(1, math.ceil(steps * (1.0 - ROUNDING)))
    return min(1.0 - count * kappa, most)


def _axes(question: GraspQuestion, step: float) -> tuple[Array, Array]:
    """Nodes along x and y of the box about the region."""
    if not 0.0 < step < math.inf:
        raise InputError("step", f"{step:g} m", "positive and finite")
    low, high = question.region.corners.min(axis=0), question.region.corners.max(axis=0)
    width, height = (high - low).tolist()
    count = (width / step + 1.0) * (height / step + 1.0)
    if not count <= MOST_NODES:
        raise InputError("step", f"{step:g} m makes {count:.3g} nodes", f"at most {MOST_NODES:.0e} nodes")
    return grid_nodes(low[0], high[0], step), grid_nodes(low[1], high[1], step)
