"""The equilibrium in space behind a stance's margin: four cables, the orientation its own, stable, clear, steered.

The tensions are those of the largest slip margin. With them the platform turns until no moment is left, which moves
the attachments and so the tensions: a fixed point, reached in a few rounds as the attachments are close to each other
next to the length of the cables.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.design.stances.inner import least_scale
from steeplejack.design.stances.worth import NOTHING, SPACE, bounds, stand
from steeplejack.mechanics.cable.region import clearance
from steeplejack.mechanics.cable.rest import statics
from steeplejack.robots.squad import in_plane, suspension

Array = NDArray[np.float64]

ROUNDS = 40
"""Rounds of tensions and orientation before an equilibrium counts as not found."""
SETTLED = 1e-9
"""Largest change of the rotation's entries at the end."""
HAIR = 1e-12
"""Share of a tension by which the bounds of the optimum are opened: rounding."""
HELD, SLIPS, UNBALANCED, UNSTABLE, UNSTEERED, LONG, CABLE_MEETS, BODY_MEETS, UNKNOWN = range(9)
"""Why a stance does not hold the platform; `HELD` where it does."""


@njit(cache=True, error_model="numpy")
def held(
    stood: Array,
    position: Array,
    guess: Array,
    attachments: Array,
    weight: Array,
    centre: Array,
    limits: Array,
    machine: Array,
    axes: Array,
    radii: Array,
    own: NDArray[np.int64],
    asked: Array,
) -> tuple[float, int]:
    """Slip margin of the equilibrium with the largest one, and why it does not hold.

    Args:
        stood: From `stand` (4, 3, 3).
        position: Of the platform (3,) [m].
        guess: Orientation to start from (3, 3).
        attachments: In the platform's frame (4, 3) [m].
        weight: Gravity force (3,) [N].
        centre: Of mass, in the platform's frame (3,) [m].
        limits: See `worth`.
        machine: See `worth`.
        axes: Stays as polylines (k, n, 3) [m].
        radii: Their radii (k,) [m].
        own: Stay of each base (4,).
        asked: EA of a cable [N], least dexterity [1], longest cable [m], gap of a cable and of the platform's centre
            from a stay [m] (5,).

    Returns:
        Margin [1] and reason; with any reason but `HELD` and `SLIPS` the margin is below `NOTHING`.
    """
    loads = weight.copy().reshape(1, 3)
    rotation = guess.copy()
    arms, forces, stiff = np.empty((4, 3)), np.empty((4, 3)), np.empty(4)
    exits = np.ascontiguousarray(stood[:, 0])
    lower = limits[:, 0].copy()
    tensions = lower
    t, change = np.inf, np.inf
    for _ in range(ROUNDS):
        for i in range(4):
            for k in range(3):
                arms[i, k] = (
                    rotation[k, 0] * attachments[i, 0]
                    + rotation[k, 1] * attachments[i, 1]
                    + rotation[k, 2] * attachments[i, 2]
                )
        columns, cap, scale = bounds(SPACE, stood, position, arms, limits, machine)
        t = least_scale(columns, False, loads, lower, cap, scale)
        particular, null, independent = suspension.force_family(columns, weight)
        if t == np.inf or not independent:
            return 2.0 * NOTHING, UNBALANCED
        for i in range(4):
            cap[i] = min(cap[i], t * scale[i]) * (1.0 + HAIR)
        low, high, _a, _b = suspension.interval(particular, null, lower, cap)
        tensions = particular + 0.5 * (low + high) * null
        for i in range(4):
            for k in range(3):
                forces[i, k] = tensions[i] * columns[i, k]
        before = rotation
        rotation = statics.balanced_rotation(forces, attachments, weight, centre, before)
        change = np.max(np.abs(rotation - before))
        if change < SETTLED:
            break
    if change >= SETTLED:
        return 2.0 * NOTHING, UNBALANCED
    if t > 1.0:
        return 1.0 - t, SLIPS
    u, lengths = statics.directions(exits, attachments, position, rotation)
    for i in range(4):
        stiff[i] = asked[0] / lengths[i]
    hessian = statics.stiffness(attachments, weight, centre, rotation, u, lengths, tensions, stiff)
    if statics.least_pivot(hessian) <= 0.0:
        return 2.0 * NOTHING, UNSTABLE
    if np.max(lengths) > asked[2]:
        return 2.0 * NOTHING, LONG
    matrix, _scale = in_plane.plane_matrix(u, rotation, attachments)
    if in_plane.dexterity(matrix) < asked[1]:
        return 2.0 * NOTHING, UNSTEERED
    for i in range(4):
        for k in range(3):
            forces[i, k] = exits[i, k] - u[i, k] * lengths[i]  # attachments in the world
    cables, body = clearance.cable_gap(exits, forces, axes, radii, own)
    if cables < asked[3]:
        return 2.0 * NOTHING, CABLE_MEETS
    if body < asked[4]:
        return 2.0 * NOTHING, BODY_MEETS
    return 1.0 - t, HELD


@njit(cache=True, error_model="numpy", nogil=True)
def helds(
    axes: Array,
    tangents: Array,
    step: Array,
    positions: Array,
    guesses: Array,
    attachments: Array,
    weight: Array,
    centre: Array,
    limits: Array,
    machine: Array,
    stays: Array,
    radii: Array,
    own: NDArray[np.int64],
    asked: Array,
    stances: Array,
    admitted: NDArray[np.bool_],
) -> tuple[Array, NDArray[np.int64]]:
    """Margins and reasons (n, c) of c stances (n, c, 4) [m] at each of n places, ``-inf`` where not admitted (n, c).

    Positions (n, 3), guesses (n, 3, 3) and limits (n, 4, 3) are each place's own, the rest as in :func:`held` and
    `stand`, with ``stays`` for its polylines.
    """
    margins, reasons = np.full(admitted.shape, -np.inf), np.full(admitted.shape, UNKNOWN)
    stood = np.empty((4, 3, 3))
    for j in range(stances.shape[0]):
        for c in range(stances.shape[1]):
            if admitted[j, c]:
                stand(axes, tangents, step, stances[j, c], positions[j], machine[0], stood)
                margins[j, c], reasons[j, c] = held(
                    stood,
                    positions[j],
                    guesses[j],
                    attachments,
                    weight,
                    centre,
                    limits[j],
                    machine,
                    stays,
                    radii,
                    own,
                    asked,
                )
    return margins, reasons
