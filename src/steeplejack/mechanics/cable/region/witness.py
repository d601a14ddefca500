"""Compiled decisions over boxes of spatial poses, orientations included: one witness, carried over the whole box.

Determinants of a platform that turns are no low polynomials, and there are many hyperplanes. One witness at the middle
of a box decides as well, for any number of cables: `balance` finds it, `models` say how everything changes over the
box, `proofs` carry the witness over it.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.region.balance import balance
from steeplejack.mechanics.cable.region.enclosure import INSIDE, OUTSIDE, UNDECIDED
from steeplejack.mechanics.cable.region.models import ROUNDING, column_models, frame, load_models
from steeplejack.mechanics.cable.region.proofs import held, refused

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

TIGHT = (0.3, 0.05, 0.005, 0.0005)
"""How much narrower than its window a witness is looked for, the safest first, over half the window [1]."""

THIN = 1.0 / 16.0
"""A side shorter than this share of the longest one, both relative to the search box, is not cut [1]."""

LATTICE = 64
"""Steps across each side of a box of orientations; the smallest piece looked at is two steps wide."""

ROOM = 128
"""Pieces of a box of orientations that may wait at a time."""


@njit(cache=True, error_model="numpy")
def classify_poses(
    anchors: Array, arms: Array, wrenches: Array, centre: Array, lower: Array, upper: Array,
    middles: Array, halves: Array, root: Array, labels: Integers, proofs: Integers, cuts: Integers,
) -> None:  # fmt: skip
    """Decide boxes of poses: inside, outside, or which side to cut.

    Args:
        anchors: (m, 3), scaled.
        arms: Attachments turned by the reference rotation, (m, 3), scaled.
        wrenches: (k, 6), scaled; none for wrench closure.
        centre: Where their forces act, turned by the reference rotation, (3,), scaled.
        lower: Least tensions, (m,), scaled; none for wrench closure.
        upper: Greatest tensions, (m,), scaled; none for wrench closure.
        middles: Positions and rotation vectors, (b, 6).
        halves: Half sides, (b, 6).
        root: Half sides of the search box, (6,).
        labels: Written, (b,).
        proofs: Written, (b,): the wrench that is not held where outside, 0 for wrench closure; else -1.
        cuts: Written, (b,): the side to cut where undecided; else -1.
    """
    weights = np.empty(6)
    for b in range(middles.shape[0]):
        labels[b], proofs[b] = judge(
            anchors, arms, wrenches, centre, lower, upper, middles[b], halves[b], root, weights
        )
        cuts[b] = cut(halves[b], root, weights) if labels[b] == UNDECIDED else -1


@njit(cache=True, error_model="numpy")
def classify_positions(
    anchors: Array, arms: Array, wrenches: Array, centre: Array, lower: Array, upper: Array,
    middles: Array, halves: Array, turns: Array, root: Array, labels: Integers, proofs: Integers, cuts: Integers,
) -> None:  # fmt: skip
    """Decide boxes of positions for all orientations of a range at once.

    Args:
        anchors: (m, 3), scaled.
        arms: Attachments turned by the reference rotation, (m, 3), scaled.
        wrenches: (k, 6), scaled; none for wrench closure.
        centre: Where their forces act, turned by the reference rotation, (3,), scaled.
        lower: Least tensions, (m,), scaled; none for wrench closure.
        upper: Greatest tensions, (m,), scaled; none for wrench closure.
        middles: Positions, (b, 3).
        halves: Half sides, (b, 3).
        turns: Lower and upper end of each component of the rotation vector, (3, 2).
        root: Half sides of the search box, rotation vectors included, (6,).
        labels: Written, (b,): inside for every orientation, or outside for one of them.
        proofs: Written, (b,): that one where outside, ``(i (LATTICE + 1) + j) (LATTICE + 1) + k``; else -1.
        cuts: Written, (b,): the side to cut where undecided; else -1.
    """
    weights, pieces = np.empty(6), np.empty((ROOM, 6), dtype=np.int64)
    middle, half = np.empty(6), np.empty(6)
    step = (turns[:, 1] - turns[:, 0]) / LATTICE
    for b in range(middles.shape[0]):
        middle[:3], half[:3] = middles[b], halves[b]
        labels[b], proofs[b], cuts[b] = INSIDE, -1, -1
        waiting = 1
        for k in range(3):
            pieces[0, k], pieces[0, 3 + k] = 0, LATTICE
        while waiting > 0:
            waiting -= 1
            place, size = pieces[waiting, :3].copy(), pieces[waiting, 3:].copy()
            for k in range(3):
                middle[3 + k] = turns[k, 0] + step[k] * (place[k] + 0.5 * size[k])
                half[3 + k] = 0.5 * step[k] * size[k] * (1.0 + ROUNDING) + (ROUNDING if step[k] > 0.0 else 0.0)
            label, _ = judge(anchors, arms, wrenches, centre, lower, upper, middle, half, root, weights)
            if label == INSIDE:
                continue
            side = cut(half, root, weights)
            witness = _witness(
                anchors, arms, wrenches, centre, lower, upper, middle, half, turns, place, size, root, waiting == 0
            )
            if witness >= 0:
                labels[b], proofs[b] = OUTSIDE, witness
                break
            if side < 3 or size[side - 3] <= 2 or waiting + 2 > ROOM:
                labels[b], cuts[b] = UNDECIDED, _position_side(half, root, weights)
                break
            for h in range(2):
                for k in range(3):
                    pieces[waiting, k], pieces[waiting, 3 + k] = place[k], size[k]
                pieces[waiting, 3 + side - 3] = size[side - 3] // 2
                pieces[waiting, side - 3] = place[side - 3] + h * (size[side - 3] // 2)
                waiting += 1


@njit(cache=True, error_model="numpy")
def _witness(
    anchors: Array, arms: Array, wrenches: Array, centre: Array, lower: Array, upper: Array,
    middle: Array, half: Array, turns: Array, place: Integers, size: Integers, root: Array, corners: bool,
) -> int:  # fmt: skip
    """An orientation of a piece, its middle or a corner, at which no position of the box is inside; -1 for none."""
    pose, still, weights = middle.copy(), half.copy(), np.empty(6)
    for corner in range(9 if corners else 1):
        index = 0
        for k in range(3):
            step = (turns[k, 1] - turns[k, 0]) / LATTICE
            at = place[k] + (size[k] // 2 if corner == 0 else size[k] * (((corner - 1) >> k) & 1))
            if step == 0.0:
                at = 0
            pose[3 + k] = turns[k, 0] + step * at
            still[3 + k] = ROUNDING if step > 0.0 else 0.0
            index = index * (LATTICE + 1) + at
        label, _ = judge(anchors, arms, wrenches, centre, lower, upper, pose, still, root, weights)
        if label == OUTSIDE:
            return index
    return -1


@njit(cache=True, error_model="numpy")
def cut(half: Array, root: Array, weights: Array) -> int:
    """The side that contributes most to the doubt, or the longest where that one has become thin beside it."""
    longest, best = -1, -1
    for k in range(half.size):
        if root[k] > 0.0:
            if longest < 0 or half[k] * root[longest] > half[longest] * root[k]:
                longest = k
            if best < 0 or weights[k] > weights[best]:
                best = k
    if weights[best] > 0.0 and half[best] * root[longest] > THIN * half[longest] * root[best]:
        return best
    return longest


@njit(cache=True, error_model="numpy")
def _position_side(half: Array, root: Array, weights: Array) -> int:
    """The side of the positions to cut."""
    return cut(half[:3], root[:3], weights[:3])


@njit(cache=True, error_model="numpy")
def judge(
    anchors: Array, arms: Array, wrenches: Array, centre: Array, lower: Array, upper: Array,
    middle: Array, half: Array, root: Array, weights: Array,
) -> tuple[int, int]:  # fmt: skip
    """Label of one box of poses, and the wrench that is not held; ``weights`` gets each coordinate's share of doubt."""
    count = anchors.shape[0]
    closure = lower.size == 0
    columns, inverse = np.empty((count, 6, 8)), np.empty((count, 8))
    load, turned = np.zeros((6, 8)), np.empty((4, 3))
    tensions, z, window = np.empty(count), np.empty(6), np.empty((2, count))
    weights[:] = 0.0
    lever = frame(middle, arms, turned)
    if not column_models(anchors, arms, turned, lever, middle, half, columns, inverse):
        weights[:] = half / np.where(root > 0.0, root, np.inf)
        return UNDECIDED, -1
    label = INSIDE
    for k in range(1 if closure else wrenches.shape[0]):
        if closure:
            window[0], window[1] = 0.0, np.inf
        else:
            window[0], window[1] = lower, upper
            load_models(wrenches[k], centre, turned, lever, half, load)
        if not balance(columns, load, window, closure, 0.0, tensions, z):
            if refused(columns, inverse, load, window, closure, tensions, z, half, root, weights):
                return OUTSIDE, k
            return UNDECIDED, -1
        proved = False
        for tight in TIGHT:
            if balance(columns, load, window, closure, tight, tensions, z):
                proved = held(columns, inverse, load, window, closure, tensions, half, root, weights)
                break
        if not proved:
            label = UNDECIDED
            if weights.max() == 0.0:
                weights[:] = half / np.where(root > 0.0, root, np.inf)
    return label, -1
