"""The remote-centre-of-motion linkage: two parallelograms that turn the platform about the pipe without touching it.

In the plane across the pipe, origin at the remote centre O3 on the pipe's axis (Fig. 4 of Ye et al., Robotica 2024):

    M_k = (-+ coupler / 2, 0)                        middle pivots of the cranks G1 and G2, either side of the pipe
    A_k = M_k + crank u,  C_k = M_k - crank u        their ends, u = (-sin beta, cos beta)
    E_3 = (A_1 + A_2) / 2,  E_4 = (C_1 + C_2) / 2    pins of the platform, in the middles of the couplers G3 and G4

A parallelogram keeps its couplers parallel to M1 M2, so ``E_3 = crank u`` and ``E_4 = -crank u``: the platform turns
about O3 by beta, the angle of the cranks, whatever beta is. Servo angle and beta are one number, and so are their
rates. Two of the six closure equations say nothing new: hence v = 2 in Eq. 4, and one freedom.

At beta = +-90 degrees the cranks lie along the couplers and the linkage could fold over into a crossed one; within
that range the parallelogram is the only way the platform's two pins fit.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.parameters import Rcm
from steeplejack.robots.pipe_climber.poses import Array

FOLDED = 0.5 * math.pi
"""Where the parallelogram lies flat [rad]."""


def linkage_joints(rcm: Rcm, beta: ArrayLike) -> Array:
    """Places of the eight joints in the plane across the pipe, from the remote centre.

    Args:
        rcm: The linkage.
        beta: Turn about the pipe, (...), within 90 degrees [rad].

    Returns:
        M1, M2, A1, A2, C1, C2, E3, E4, (..., 8, 2) [m].

    Raises:
        InputError: An angle at or beyond the fold, or not a number.
    """
    turn = _within_fold(beta)
    crank = rcm.crank * np.stack((-np.sin(turn), np.cos(turn)), axis=-1)[..., None, :]
    pivots = np.array([[-0.5 * rcm.coupler, 0.0], [0.5 * rcm.coupler, 0.0]])
    middle = np.broadcast_to(pivots, (*turn.shape, 2, 2))
    return np.concatenate((middle, middle + crank, middle - crank, crank, -crank), axis=-2)


def linkage_angles(rcm: Rcm, beta: ArrayLike) -> Array:
    """Angles of the five moving links, G1 to G4 and the platform, from where they are at beta = 0: (..., 5) [rad]."""
    turn = _within_fold(beta)
    still = np.zeros_like(turn)
    return np.stack((turn, turn, still, still, turn), axis=-1)


def linkage_closure(rcm: Rcm, angles: ArrayLike) -> Array:
    """By how much the three loops fail to close at any angles of the links.

    Loops: M1 A1 A2 M2, M1 C1 C2 M2, and M1 A1 E3 E4 C1 through the platform.

    Args:
        rcm: The linkage.
        angles: G1, G2, G3, G4 and platform, (..., 5) [rad].

    Returns:
        (..., 3 loops, 2) [m]. Its derivative has rank 4 of 6 wherever the linkage is a parallelogram: five angles less
        four conditions leave one freedom, and two conditions are redundant.
    """
    first, second, upper, lower, platform = np.moveaxis(np.asarray(angles, dtype=np.float64), -1, 0)
    gripper = np.array([rcm.coupler, 0.0])
    loops = (
        rcm.crank * _across(first) + rcm.coupler * _along(upper) - rcm.crank * _across(second) - gripper,
        -rcm.crank * _across(first) + rcm.coupler * _along(lower) + rcm.crank * _across(second) - gripper,
        2.0 * rcm.crank * (_across(first) - _across(platform)) + 0.5 * rcm.coupler * (_along(upper) - _along(lower)),
    )
    return np.stack(loops, axis=-2)


def beta_of(rcm: Rcm, joints: ArrayLike) -> Array:
    """Turn about the pipe from where the two pins of the platform are: inverse of `linkage_joints`.

    Args:
        rcm: The linkage.
        joints: (..., 8, 2), from the remote centre [m].

    Returns:
        (...) [rad].
    """
    given = np.asarray(joints, dtype=np.float64)
    across = given[..., 6, :] - given[..., 7, :]
    return np.arctan2(-across[..., 0], across[..., 1])


def _within_fold(beta: ArrayLike) -> Array:
    turn = np.asarray(beta, dtype=np.float64)
    if not (np.abs(turn) < FOLDED).all():
        worst = float(np.degrees(turn.flat[np.argmax(~(np.abs(turn) < FOLDED))]))
        raise InputError("beta", f"{worst:g} deg", "within 90 deg, where the parallelogram folds")
    return turn


def _along(angle: Array) -> Array:
    return np.stack((np.cos(angle), np.sin(angle)), axis=-1)


def _across(angle: Array) -> Array:
    return np.stack((-np.sin(angle), np.cos(angle)), axis=-1)
