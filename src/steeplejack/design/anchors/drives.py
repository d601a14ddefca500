"""Drives between poses: in which order the bases may move on, one at a time, without the platform being let go.

With wrench closure asked for, both ends of a drive settle it: with columns left un-normalised every cofactor is affine
in the offset of one anchor, so one sign at both ends is one sign all the way. Under a load the way is sampled.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, permutations

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.anchors.problem import Reconfiguration
from steeplejack.design.anchors.worth import GRIPPED, Duty, worth_of

Array = NDArray[np.float64]

SAMPLES = 9  # places looked at along a drive, ends included
STILL = 1e-9  # [m] a shorter drive is none


def driven(problem: Reconfiguration, offsets: Array) -> Array:
    """How far each base drives before each pose, along its stay.

    Args:
        problem: Anchors and their directions.
        offsets: Along x, (k, 4) [m].

    Returns:
        (k - 1, 4) [m], not negative.
    """
    return np.abs(np.diff(offsets, axis=0)) * np.hypot(problem.directions[:, 0], problem.directions[:, 1])


def drive_orders(problem: Reconfiguration, offsets: Array, duty: Duty) -> list[tuple[int, ...] | None]:
    """Orders in which the bases may drive while the platform stands at the pose they leave.

    Args:
        problem: Anchors, platform and k poses.
        offsets: Along x, (k, 4) [m].
        duty: What is borne.

    Returns:
        k - 1 orders of base indices, empty where none drives; None where every order lets the platform go, or where
        it is not held to begin with.
    """
    return [
        _order(replace(problem, poses=pose[None]), before, after, duty)
        for pose, (before, after) in zip(problem.poses[:-1], pairwise(offsets), strict=True)
    ]


def _order(problem: Reconfiguration, before: Array, after: Array, duty: Duty) -> tuple[int, ...] | None:
    """The first order of the bases that move which holds at one pose."""
    moving = np.flatnonzero(np.abs(after - before) > STILL)
    return next((order for order in permutations(moving.tolist()) if _held(problem, before, after, order, duty)), None)


def _held(problem: Reconfiguration, before: Array, after: Array, order: tuple[int, ...], duty: Duty) -> bool:
    """Whether one order holds at one pose, each base on its own limit while it drives."""
    at = before.copy()
    for base in order:
        way = np.tile(at, (SAMPLES, 1))
        way[:, base] = np.linspace(before[base], after[base], SAMPLES)
        _value, flags = worth_of(replace(problem, poses=np.tile(problem.poses, (SAMPLES, 1))), way, duty)
        needed = GRIPPED | np.uint8(1 << base)
        if np.any(flags & needed != needed):
            return False
        at[base] = after[base]
    return True
