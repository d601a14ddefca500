"""Compiled branch and bound for every pose that explains cable lengths; `every_pose` is its public face.

Unknowns ``(x, y, z, a, b, c)``: the position and the turns of ``R = Rz(c) Ry(b) Rx(a) R_0``; planar robots move x, y
and c. A box of them is thrown away where a test of `krawczyk` proves that it holds no pose that explains the lengths,
or where it lies in the box of a solution already certified. What is left is halved along the unknown that moves the
lengths most. Source: Merlet, "Solving the forward kinematics of a Gough-type parallel manipulator with interval
analysis", IJRR 23(3), 2004.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.pose.bounds import enclose
from steeplejack.mechanics.cable.pose.krawczyk import (
    Asked,
    Robot,
    Room,
    certify,
    contraction,
    defect,
    missed,
    narrowed,
    polish,
    precondition,
    room,
)

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Results = tuple[Array, Array, Array, Array]

SWEEPS = 3  # contractions of a box before it is halved
SHRUNK = 0.7  # [1] a contraction that leaves more of the widest side than this is not repeated
DEEP = 4096  # boxes waiting at most


@njit(cache=True)
def search(
    low: Array, high: Array, free: Ints, anchors: Array, axes: Array, radii: Array, local: Array, lengths: Array,
    weights: Array, tolerance: float, narrow: float, budget: int, seeds: Array, solutions: Array, boxes: Array,
    residuals: Array, spreads: Array, undecided: Array,
) -> tuple[int, int, int]:  # fmt: skip
    """Every pose of a box that explains the lengths.

    Args:
        low: (6,).
        high: (6,).
        free: Which unknowns move (n,).
        anchors: (m, 3).
        axes: Unit swivel axes (m, 3).
        radii: Of the pulleys (m,).
        local: (m, 3).
        lengths: (m,).
        weights: Of the unknowns in norms, 1 for places, 1 / reach for angles (6,).
        tolerance: On the lengths, in the Euclidean norm.
        narrow: Width over weight below which a box is given up as undecided.
        budget: Boxes examined at most.
        seeds: Poses to try first (k, 6).
        solutions: Gets poses (s, 6).
        boxes: Gets their boxes (s, 2, 6).
        residuals: Gets upper bounds of their residuals (s,).
        spreads: Gets what `certify` returns (s,).
        undecided: Gets boxes given up (u, 2, 6).

    Returns:
        Numbers of solutions, of boxes undecided (with those left when the budget or the space ran out) and of boxes
        examined.
    """
    robot, asked = (anchors, axes, radii, local), (lengths, weights, free, tolerance)
    results = (solutions, boxes, residuals, spreads)
    space, aside = room(free.shape[0], lengths.shape[0]), room(free.shape[0], lengths.shape[0])
    where, box_low, box_high, stack = np.empty(6), np.empty(6), np.empty(6), np.empty((DEEP, 2, 6))
    found, open_boxes, examined, depth = 0, 0, 0, 1
    stack[0, 0], stack[0, 1] = low, high
    for k in range(seeds.shape[0]):
        where[:] = seeds[k]
        found = _try(where, robot, asked, aside, found, results)
    while depth > 0:
        depth -= 1
        box_low[:], box_high[:] = stack[depth, 0], stack[depth, 1]
        examined += 1
        if _swept(box_low, box_high, robot, asked, space, aside, boxes, found, where):
            continue
        width, split = _widest(box_low, box_high, space[1], asked)
        if width < narrow or (width < 1.0 and contraction(space[7], weights, free) < 1.0):
            for a in range(6):
                where[a] = 0.5 * (box_low[a] + box_high[a])
            before = found
            found = _try(where, robot, asked, aside, found, results)
            if found > before and _known(box_low, box_high, boxes, found, free):
                continue
        if width < narrow or examined >= budget or depth + 2 > DEEP:
            if open_boxes < undecided.shape[0]:
                undecided[open_boxes, 0], undecided[open_boxes, 1] = box_low, box_high
            open_boxes += 1
            if examined >= budget:
                return found, open_boxes + depth, examined
            continue
        cut = 0.5 * (box_low[split] + box_high[split])
        for side in range(2):
            stack[depth, 0], stack[depth, 1] = box_low, box_high
            stack[depth, 1 - side, split] = cut
            depth += 1
    return found, open_boxes, examined


@njit(cache=True)
def _swept(
    low: Array,
    high: Array,
    robot: Robot,
    asked: Asked,
    space: Room,
    aside: Room,
    boxes: Array,
    found: int,
    middle: Array,
) -> bool:
    """Contract a box in place; whether nothing is left of it, or it lies in the box of a solution."""
    anchors, axes, radii, local = robot
    lengths, _weights, free, tolerance = asked
    squares, slopes, inverse, rest = space[0], space[1], space[6], space[7]
    for _sweep in range(SWEEPS):
        if _known(low, high, boxes, found, free):
            return True
        enclose(low, high, anchors, axes, radii, local, squares, slopes)
        if missed(squares, lengths, tolerance):
            return True
        if not precondition(slopes, free, space):
            return False
        for a in range(6):
            middle[a] = 0.5 * (low[a] + high[a])
        enclose(middle, middle, anchors, axes, radii, local, aside[0], aside[1])
        defect(slopes, free, inverse, rest)
        left = narrowed(low, high, middle, aside[0], asked, space)
        if left < 0.0:
            return True
        if left > SHRUNK:
            return False
    return False


@njit(cache=True)
def _widest(low: Array, high: Array, slopes: Array, asked: Asked) -> tuple[float, int]:
    """Widest side over its weight, and the unknown that moves the lengths most, or is widest where none is known to."""
    _lengths, weights, free, _tolerance = asked
    width, longest, split, widest = 0.0, 0.0, -1, free[0]
    for a in range(free.shape[0]):
        j = free[a]
        side = float((high[j] - low[j]) / weights[j])
        if side > width:
            width, widest = side, j
        smear = 0.0
        for i in range(slopes.shape[0]):
            smear = max(smear, abs(slopes[i, j, 0]), abs(slopes[i, j, 1]))
        smear *= high[j] - low[j]
        if smear > longest:
            longest, split = smear, j
    return width, (split if split >= 0 else widest)


@njit(cache=True)
def _try(where: Array, robot: Robot, asked: Asked, space: Room, found: int, results: Results) -> int:
    """Polish a pose and keep it if it is a new solution with a certificate; how many are kept then."""
    solutions, boxes, residuals, spreads = results
    residual = polish(where, robot, asked, space)
    if residual <= asked[3] and found < solutions.shape[0] and not _known(where, where, boxes, found, asked[2]):
        spread = certify(where, 1.0, robot, asked, space, boxes[found, 0], boxes[found, 1])
        if spread >= 0.0:
            solutions[found], residuals[found], spreads[found] = where, residual, spread
            return found + 1
    return found


@njit(cache=True)
def _known(low: Array, high: Array, boxes: Array, found: int, free: Ints) -> bool:
    """Whether a box lies in that of a solution."""
    for s in range(found):
        inside = True
        for a in range(free.shape[0]):
            j = free[a]
            if low[j] < boxes[s, 0, j] or high[j] > boxes[s, 1, j]:
                inside = False
                break
        if inside:
            return True
    return False
