"""Stations of a stance chart by equilibria on the sagging stays, at stand-offs over the camera's range."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.stances.ground import Ground
from steeplejack.design.stances.held import HELD, UNKNOWN
from steeplejack.design.stances.rules import COUNT, TOLERANCE, ChartRules
from steeplejack.design.stances.search import Room, compass
from steeplejack.design.stances.weigh import Equilibria, by_forces, known
from steeplejack.design.stances.worth import SLIP, SPACE
from steeplejack.robots.squad import Bay, Squad
from steeplejack.worksite import Bridge

Array = NDArray[np.float64]

CERTIFIED = 64
"""Stances of the grid whose equilibrium is looked at before a place counts as not held."""
AT_ONCE = 8
"""Of them, judged in one call."""
SWING = 0.05
"""Kept from both ends of the camera's range [m]: off the face the platform swings."""
AROUND = 25.0
"""Stay beyond the outermost base that clearances are checked against [m]."""
NODE = 4.0
"""Nodes of the stays that clearances are checked against [m]."""


def in_space(
    bridge: Bridge,
    bay: Bay,
    k: int,
    squad: Squad,
    rules: ChartRules,
    ground: Ground,
    limits: Array,
    s: Array,
    room: Room,
    fixed: Array,
) -> dict[str, Array]:
    """Stations of one stay by equilibria in space; a row is a station, a stand-off and a phase."""
    near, far = squad.camera.stand_off
    off = np.linspace(near + SWING, far - SWING, rules.levels)
    shape = len(s), len(off), len(limits)
    each = [np.ravel(values) for values in np.broadcast_arrays(*np.ix_(s, off, np.arange(len(limits))))]
    positions = bay.place(np.full(each[0].shape, float(k)), each[0], each[1] + bay.radius(k))
    guesses = np.repeat(np.stack([bay.frame(float(k), float(value)) for value in s]), shape[1] * shape[2], axis=0)
    room = replace(room, windows=np.repeat(room.windows, shape[1] * shape[2], axis=0))
    rows = np.arange(len(positions))
    attachments, weight = np.array(squad.platform.attachments), rules.mass * np.asarray(bridge.gravity)
    arms = attachments @ np.swapaxes(guesses, -1, -2)
    forces = by_forces(SLIP, SPACE, ground, room, positions, arms, weight[None], limits[each[2].astype(int)])
    platform = attachments, weight, np.array(squad.platform.centre_of_mass)
    truth = Equilibria(
        ground, room, positions, guesses, limits[each[2].astype(int)], platform, _surroundings(bay, squad, rules, s)
    )
    grid = room.grid(COUNT)
    values = forces(rows, grid)
    stances, margins, reasons = _ranked(truth, values, grid)
    level = np.argmax(margins.reshape(shape), axis=1)
    best = np.ravel((np.arange(shape[0])[:, None] * shape[1] + level) * shape[2] + np.arange(shape[2]))
    chosen = truth.of(best)
    mesh = float(np.max(room.windows[..., 1] - room.windows[..., 0])) / (COUNT - 1)
    stance, margin = compass(
        chosen.margin, chosen.room, stances[best], margins[best], 0.5 * mesh, TOLERANCE, together=False
    )
    level = np.where(np.isfinite(margin), each[1][best], np.nan)
    standing = replace(room, windows=np.broadcast_to([-np.inf, np.inf], room.windows.shape))
    others = truth.on(standing).margin(rows, np.repeat(fixed, shape[1] * shape[2], axis=0)[:, None])
    out = {
        "margin": known(margin),
        "fixed_margin": known(others.reshape(shape).max(axis=1)),
        "force_margin": known(values.max(axis=1).reshape(shape).max(axis=1)),
        "stand_off": level,
        "reason": reasons[best].astype(float),
    }
    return {"stance": stance.reshape(shape[0], shape[2], 4)} | {
        name: of.reshape(shape[0], shape[2]) for name, of in out.items()
    }


def _ranked(truth: Equilibria, values: Array, grid: Array) -> tuple[Array, Array, NDArray[np.int64]]:
    """For each row the first stance of the grid (n, c, 4), in the order of its worth by forces, that truly holds.

    Returns:
        Stances (n, 4) [m], their margins (n,), ``-inf`` where none of those looked at holds, and why the first did not.
    """
    order = np.argsort(-values, axis=1, kind="stable")[:, :CERTIFIED]
    stances, margins = np.full((len(values), 4), np.nan), np.full(len(values), -np.inf)
    reasons = np.full(len(values), UNKNOWN)
    left = np.arange(len(values))
    for begin in range(0, order.shape[1], AT_ONCE):
        some = order[left, begin : begin + AT_ONCE]
        # Below 0 by forces nothing holds; one stance is judged all the same for the reason.
        open_ = values[left, some[:, 0]] >= (-np.inf if begin == 0 else 0.0)
        left, some = left[open_], some[open_]
        if not len(left):
            break
        trial = np.take_along_axis(grid[left], some[..., None], axis=1)
        found, why = truth.judge(left, trial)
        if begin == 0:
            reasons[left] = why[:, 0]
        good = why == HELD
        first = np.argmax(good, axis=1)
        hit = good[np.arange(len(left)), first]
        stances[left[hit]], margins[left[hit]] = trial[hit, first[hit]], found[hit, first[hit]]
        reasons[left[hit]] = HELD
        left = left[~hit]
    return stances, margins, reasons


def _surroundings(bay: Bay, squad: Squad, rules: ChartRules, s: Array) -> tuple[Array, Array, NDArray[np.int64], Array]:
    """Stays as polylines about the stations (k, n, 3) [m], their radii [m], each base's own, and what is asked."""
    low, high = max(0.0, float(np.min(s)) - rules.within - AROUND), float(np.max(s)) + rules.within + AROUND
    nodes = max(2, int(np.ceil((high - low) / NODE)) + 1)
    lines = [stay.position(np.linspace(min(low, stay.length), min(high, stay.length), nodes)) for stay in bay.stays]
    asked = [squad.cable.axial_stiffness, rules.dexterity, squad.winch.stored_length, rules.cable_clearance]
    radii = np.array([bay.radius(i) for i in range(len(bay.stays))])
    return np.stack(lines), radii, np.array(bay.carriers), np.array([*asked, squad.platform.clearance])
