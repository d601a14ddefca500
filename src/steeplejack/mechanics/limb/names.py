"""Screw systems in words: "rotation about Y", "translation along X", "force along Y", "couple about X".

A system has many bases; the one that is named is unique. Screws without a direction part of their own (translations,
couples) are split off first; the rest is brought to reduced row echelon form in its directions, so that the axes of the
frame come out wherever the system contains them, and cleared of the first kind. What is left of the other half says
where the axis lies and with what pitch.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from steeplejack.mechanics.limb.systems import Gauge, basis, null_space, row_space

Array = NDArray[np.float64]

AXES = "XYZ"
NOUGHT = 1e-7
"""What is shown as zero: a component of a direction [1], or a distance of the characteristic length [1]."""


def freedoms_in_words(twists: Array, gauge: Gauge) -> list[str]:
    """Names of the freedoms of a system of twists (k, 6) in a gauge: rotations first, then translations."""
    rotations, translations = _canonical(_at_origin(twists, gauge))
    return [
        *(_line("rotation about", "screw motion about", row, gauge.length) for row in rotations),
        *(f"translation along {_direction(row)}" for row in translations),
    ]


def constraints_in_words(wrenches: Array, gauge: Gauge) -> list[str]:
    """Names of the constraints of a system of wrenches (k, 6) in a gauge: forces first, then couples."""
    swapped = np.roll(wrenches, 3, axis=1)  # (force; moment): from here on the algebra is that of twists
    forces, couples = _canonical(_at_origin(swapped, gauge))
    return [
        *(_line("force along", "wrench along", row, gauge.length) for row in forces),
        *(f"couple about {_direction(row)}" for row in couples),
    ]


def _at_origin(screws: Array, gauge: Gauge) -> Array:
    """(Direction; moment) of screws (k, 6) at the origin of the frame instead of the gauge's."""
    lever = np.cross(gauge.origin / gauge.length, screws[:, :3])
    return np.concatenate((screws[:, :3], screws[:, 3:] + lever), axis=1)


def _canonical(screws: Array) -> tuple[Array, Array]:
    """Screws with a direction (r, 6) and free vectors (t, 3) of a system (k, 6), the unique bases named above."""
    rows = basis(screws)
    free = _echelon(null_space(rows[:, :3].T) @ rows[:, 3:]) if len(rows) else np.empty((0, 3))
    lines = _echelon(row_space(rows[:, :3]))
    if len(lines) == 0:
        return np.empty((0, 6)), free
    weights = np.linalg.lstsq(rows[:, :3].T, lines.T, rcond=None)[0].T
    moments = weights @ rows[:, 3:]
    along = row_space(free)
    return np.concatenate((lines, moments - moments @ along.T @ along), axis=1), free


def _echelon(vectors: Array) -> Array:
    """Unit rows of the reduced row echelon form of vectors (k, 3) of full row rank."""
    rows, top = row_space(vectors).copy(), 0
    for column in range(3):
        if top == len(rows):
            break
        pivot = top + int(np.argmax(np.abs(rows[top:, column])))
        if abs(rows[pivot, column]) <= NOUGHT:
            continue
        rows[[top, pivot]] = rows[[pivot, top]]
        rows[top] /= rows[top, column]
        others = np.arange(len(rows)) != top
        rows[others] -= np.outer(rows[others, column], rows[top])
        top += 1
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def _line(pure: str, pitched: str, screw: Array, length: float) -> str:
    """A screw with a direction in words: where its axis lies if off the origin, and its pitch if it has one."""
    s, moment = screw[:3], screw[3:]
    pitch = float(s @ moment)
    point = np.cross(s, moment)
    place = f" through ({_numbers(point * length, length)}) m" if np.linalg.norm(point) > NOUGHT else ""
    if abs(pitch) <= NOUGHT:
        return f"{pure} {_direction(s)}{place}"
    return f"{pitched} {_direction(s)}{place} with a pitch of {pitch * length:.4g} m/rad"


def _direction(vector: Array) -> str:
    """An axis of the frame by its letter, another direction by its unit vector."""
    axis = int(np.argmax(np.abs(vector)))
    rest = np.delete(vector, axis)
    return AXES[axis] if np.all(np.abs(rest) <= NOUGHT) else f"({_numbers(vector, 1.0)})"


def _numbers(vector: Array, length: float) -> str:
    cleared = np.where(np.abs(vector) <= NOUGHT * length, 0.0, vector)
    return ", ".join(f"{value:.4g}" for value in cleared)
