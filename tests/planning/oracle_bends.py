"""What a closed gripper holds where its pipe bends, for the oracle: jaws closed onto the centre line, pad by pad.

Each pad goes in along its jaw's way until it is a pad's and the pipe's radius from the nearest point of the centre line
of the whole pipe. Every place bends otherwise, so that a linear programme is asked instead of facets: one for all loads
of a call, by HiGHS.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from oracle_bodies import Array
from oracle_grips import Pads
from scipy.optimize import linprog
from scipy.sparse import block_diag

from steeplejack.robots.pipe_climber.pads import EDGES, FIRST, LAST
from steeplejack.worksite.pipe_line import Pipe

CLOSING = 15  # steps in which a jaw closes
CHUNK = 40  # loads in one programme


def wrenches(pads: Pads, pipe: Pipe, s: Array, frames: tuple[Array, Array], radius: float, rows: int) -> Array:
    """Corners of what pads give to grippers at places (k,) along a pipe, in their frames, (k, j, 6) [N m, N].

    Args:
        pads: Of a gripper.
        pipe: It closes on.
        s: Of its middle [m].
        frames: Its middle (k, 3) [m] and axes (k, 3, 3).
        radius: Of the pipe [m].
        rows: As of `Pads.wrenches`.
    """
    points, axes = frames
    ends = {FIRST: [-1.0], LAST: [1.0]}.get(rows, [-1.0, 1.0])
    jaw, side, end = np.array(list(product((1.0, -1.0), (1.0, -1.0), ends))).T
    out = np.tile(jaw * math.sqrt((radius + pads.size) ** 2 - pads.aside**2), (len(s), 1))
    along = s[:, None] + pads.row * end
    for _ in range(CLOSING):
        seen = np.stack((out, out * 0.0 + side * pads.aside, out * 0.0 + end * pads.row), axis=-1)
        pad = points[:, None] + np.einsum("kij,kpj->kpi", axes, seen)
        middle, lines = pipe.centre_line(along)
        along = along + ((pad - middle) * lines[..., 2]).sum(axis=-1)
        middle = pipe.centre_line(along)[0]
        normal = pad - middle
        away = np.linalg.norm(normal, axis=-1)
        normal /= away[..., None]
        out += (radius + pads.size - away) / np.einsum("kpi,ki->kp", normal, axes[..., 0])
    assert np.abs(away - radius - pads.size).max() < 1e-9
    around = np.cross(pipe.centre_line(along)[1][..., 2], normal)
    clock = 2.0 * math.pi * np.arange(EDGES)[:, None] / EDGES
    rub = np.cos(clock) * around[:, :, None] + np.sin(clock) * np.cross(normal, around)[:, :, None]
    force = normal[:, :, None] + pads.friction * rub
    push = np.einsum("kpei,ki->kpe", force, axes[..., 0]) * jaw[:, None]
    press = pads.force * math.cos(math.asin(pads.aside / (radius + pads.size)))
    force *= press / push[..., None]
    arms = middle + radius * normal - points[:, None]
    both = np.stack((np.cross(arms[:, :, None], force), force), axis=-2)
    return np.einsum("kpevi,kij->kpevj", both, axes).reshape(len(s), -1, 6)


def used(corners: Array, weight: Array, pushes: Array) -> Array:
    """Part of grips (k, j, 6) that weights (k, 6) take with the worst of pushes (k, m, 6) to either side, (k,)."""
    signs = np.array(list(product((1.0, -1.0), repeat=pushes.shape[1])))
    tried = weight[:, None] + np.einsum("cm,kmi->kci", signs, pushes)
    which, loads = np.repeat(np.arange(len(weight)), len(signs)), tried.reshape(-1, 6)
    found = [
        _programme(corners[which[first : first + CHUNK]], loads[first : first + CHUNK])
        for first in range(0, len(loads), CHUNK)
    ]
    return np.concatenate(found).reshape(len(weight), -1).max(axis=1)


def _programme(corners: Array, loads: Array) -> Array:
    scale = np.abs(corners).max(axis=(0, 1))
    blocks = block_diag([(one / scale).T for one in corners], format="csc")
    found = linprog(np.ones(blocks.shape[1]), A_eq=blocks, b_eq=-(loads / scale).ravel(), bounds=(0.0, None))
    assert found.status == 0
    return found.x.reshape(len(loads), -1).sum(axis=1)
