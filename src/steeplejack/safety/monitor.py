"""The safety monitor: it knows the machine's limits and nothing of the controller.

Every command and the measurements it answers are checked before the command leaves. A breach names one cause; the
runtime then stops the squad on its brakes. Pulls along a stay are computed here from measured tensions and the places
of the bases, not taken over from anyone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.suspension import directions
from steeplejack.robots.squad.parameters import Squad

Array = NDArray[np.float64]

# What each code means; 0 is "all well".
BREACHES = (
    "",
    "command or measurement is not a number",
    "commanded tension outside the working window",
    "measured tension above the working window",
    "cable slack",
    "pull along the stay above the limit of a gripped base",
    "pull along the stay above the limit of a base under way",
    "winch faster than its limit",
    "base faster than its limit",
    "platform outside its fence",
    "grip lost: a base that should stand moves",
)


class Limits(NamedTuple):
    """Declared limits of one run."""

    commanded: Array  # least and largest commanded winch pull [N]
    tension: Array  # least (slack) and largest measured tension [N]
    hold: float  # [N] pull along the stay, gripped
    drive: float  # [N] pull along the stay, driving
    winch_speed: float  # [m/s]
    base_speed: float  # [m/s]
    fence: float  # [m] from the reference
    creep: float  # [m/s] of a gripped base

    @classmethod
    def of(cls, squad: Squad, tension: tuple[float, float]) -> Limits:
        """The limits of a machine and a working window.

        Winch pulls may leave the window by the friction and inertia they overcome; measured tensions may exceed it by
        the controller's own corrections and noise, 10 %, before that is a breach.
        """
        low, high = tension
        slack = 2.0 * squad.winch.friction
        return cls(
            np.array([max(0.0, low - 3.0 * slack), high + 3.0 * slack]),
            np.array([0.25 * low, 1.1 * high]),
            squad.base.hold_force,
            squad.base.drive_force,
            squad.winch.max_speed,
            squad.base.max_speed,
            0.5,
            0.02,
        )


def check(
    pull: Array,
    tension: Array,
    pay_rate: Array,
    s_rate: Array,
    moving: NDArray[np.bool_],
    exits: Array,
    tangents: Array,
    attachments: Array,
    position: Array,
    rotation: Array,
    goal: Array,
    limits: Limits,
) -> tuple[int, int]:
    """Code of the first breach and the cable or base it concerns, 0 to 3 or -1 for neither; (0, -1) if all is well.

    The fence comes last. A number that is not finite, measured or commanded, is a breach of its own.

    Args:
        pull: Commanded winch pulls (4,) [N].
        tension: Measured tensions (4,) [N].
        pay_rate: Winch rates (4,) [m/s].
        s_rate: Base rates (4,) [m/s].
        moving: Bases with open palms (4,).
        exits: Winch exits (4, 3) [m].
        tangents: Stay tangents there (4, 3).
        attachments: Attachments (4, 3) [m].
        position: Estimated position (3,) [m].
        rotation: Estimated orientation (3, 3).
        goal: Reference position (3,) [m].
        limits: Declared limits.
    """
    # Taken apart here: handing a named tuple to compiled code costs more than the check itself.
    return _check(
        pull,
        tension,
        pay_rate,
        s_rate,
        moving,
        exits,
        tangents,
        attachments,
        position,
        rotation,
        goal,
        limits.commanded,
        limits.tension,
        limits.hold,
        limits.drive,
        limits.winch_speed,
        limits.base_speed,
        limits.fence,
        limits.creep,
    )


@njit(cache=True)
def _check(
    pull: Array,
    tension: Array,
    pay_rate: Array,
    s_rate: Array,
    moving: NDArray[np.bool_],
    exits: Array,
    tangents: Array,
    attachments: Array,
    position: Array,
    rotation: Array,
    goal: Array,
    commanded: Array,
    window: Array,
    hold: float,
    drive: float,
    winch_speed: float,
    base_speed: float,
    fence: float,
    creep: float,
) -> tuple[int, int]:
    u, _lengths = directions(exits, attachments, position, rotation)
    away = np.sqrt((position[0] - goal[0]) ** 2 + (position[1] - goal[1]) ** 2 + (position[2] - goal[2]) ** 2)
    if not np.isfinite(away):
        return 1, -1
    for i in range(4):
        along = tension[i] * abs(u[i, 0] * tangents[i, 0] + u[i, 1] * tangents[i, 1] + u[i, 2] * tangents[i, 2])
        # One number that is not finite makes the sum so; comparisons with it below would all be false.
        if not np.isfinite(pull[i] + along + pay_rate[i] + s_rate[i]):
            return 1, i
        if pull[i] < commanded[0] or pull[i] > commanded[1]:
            return 2, i
        if tension[i] > window[1]:
            return 3, i
        if tension[i] < window[0]:
            return 4, i
        if not moving[i] and along > hold:
            return 5, i
        if moving[i] and along > drive:
            return 6, i
        if abs(pay_rate[i]) > winch_speed:
            return 7, i
        if abs(s_rate[i]) > base_speed:
            return 8, i
        if not moving[i] and abs(s_rate[i]) > creep:
            return 10, i
    if away > fence:
        return 9, -1
    return 0, -1
