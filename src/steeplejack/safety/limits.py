"""Declared limits of one run, and the check of one command against them."""

from __future__ import annotations

from dataclasses import dataclass

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
    "platform outside its fence: a cable is far from the length its place asks for",
    "grip lost: a base that should stand moves",
    "grip lost: palms of a base that should stand read below their preload",
    "commanded wheel traction above its limit",
    "commanded turning rate above its limit",
)

# Share of the preload below which a closed palm counts as lost. Noise lets "closed" be seen from 0.92 on, seven standard
# deviations of the sensor above; and 0.87 of the preload still holds a base at its rated pull on every stay of Table IV.
HELD = 0.87


@dataclass(frozen=True)
class Limits:
    """Declared limits of one run."""

    commanded: tuple[float, float]  # [N] least and largest commanded winch pull
    tension: tuple[float, float]  # [N] least (slack) and largest measured tension
    hold: float  # [N] pull along the stay, gripped
    drive: float  # [N] pull along the stay, driving; wheel traction
    winch_speed: float  # [m/s]
    base_speed: float  # [m/s]
    fence: float  # [m] of a cable's length from the one its place asks for
    creep: float  # [m/s] of a gripped base
    palm: float  # [N] least preload of a gripped base
    turn_rate: float  # [rad/s] commanded, of a base about its stay

    @classmethod
    def of(cls, squad: Squad, tension: tuple[float, float]) -> Limits:
        """The limits of a machine and a working window.

        Winch pulls may leave the window by the friction and inertia they overcome; measured tensions may exceed it by
        the controller's own corrections and noise, 10 %, before that is a breach.
        """
        low, high = tension
        slack, base = 2.0 * squad.winch.friction, squad.base
        return cls(
            commanded=(max(0.0, low - 3.0 * slack), high + 3.0 * slack),
            tension=(0.25 * low, 1.1 * high),
            hold=base.hold_force,
            drive=base.drive_force,
            winch_speed=squad.winch.max_speed,
            base_speed=base.max_speed,
            fence=0.5,
            creep=0.02,
            palm=HELD * squad.gripper.force,
            turn_rate=base.max_turn_rate,
        )

    @property
    def windows(self) -> Array:
        """Least and largest commanded pull, least and largest measured tension (2, 2) [N], for the compiled check."""
        return np.array([self.commanded, self.tension])

    @property
    def most(self) -> Array:
        """The other limits (8,) in the order of the fields, for the compiled check."""
        return np.array(
            [
                self.hold,
                self.drive,
                self.winch_speed,
                self.base_speed,
                self.fence,
                self.creep,
                self.palm,
                self.turn_rate,
            ]
        )


@njit(cache=True)
def check(
    command: Array,
    tension: Array,
    pay_rate: Array,
    s_rate: Array,
    palm: Array,
    moving: NDArray[np.bool_],
    exits: Array,
    tangents: Array,
    attachments: Array,
    lengths: Array,
    goal: Array,
    goal_rotation: Array,
    windows: Array,
    most: Array,
) -> tuple[int, int]:
    """Code of the first breach and the cable or base it concerns, 0 to 3; (0, -1) if all is well.

    Cables run from their exits to the attachments of the platform at its goal: within the fence that turns a cable of
    10 m by 3 deg at most. A number that is not finite, measured or commanded, is a breach of its own.

    Args:
        command: Winch pulls [N], wheel tractions [N], turning rates [rad/s] (3, 4).
        tension: Measured tensions (4,) [N].
        pay_rate: Winch rates (4,) [m/s].
        s_rate: Base rates (4,) [m/s].
        palm: Palm preloads (4,) [N].
        moving: Bases under way (4,).
        exits: Winch exits (4, 3) [m].
        tangents: Stay tangents there (4, 3).
        attachments: Attachments (4, 3) [m], platform frame.
        lengths: Loaded cable lengths as measured (4,) [m].
        goal: Reference position (3,) [m].
        goal_rotation: Reference orientation (3, 3).
        windows: See ``Limits.windows``.
        most: See ``Limits.most``.
    """
    hold, drive, winch_speed, base_speed, fence, creep, preload, turn_rate = most
    u, asked = directions(exits, attachments, goal, goal_rotation)
    for i in range(4):
        pull, traction, turn = command[0, i], command[1, i], command[2, i]
        along = tension[i] * abs(u[i, 0] * tangents[i, 0] + u[i, 1] * tangents[i, 1] + u[i, 2] * tangents[i, 2])
        away = abs(lengths[i] - asked[i])
        # One number that is not finite makes the sum so; comparisons with it below would all be false.
        if not np.isfinite(pull + traction + turn + along + away + pay_rate[i] + s_rate[i] + palm[i]):
            return 1, i
        if pull < windows[0, 0] or pull > windows[0, 1]:
            return 2, i
        if abs(traction) > drive:
            return 12, i
        if abs(turn) > turn_rate:
            return 13, i
        if tension[i] > windows[1, 1]:
            return 3, i
        if tension[i] < windows[1, 0]:
            return 4, i
        if not moving[i] and along > hold:
            return 5, i
        if moving[i] and along > drive:
            return 6, i
        if abs(pay_rate[i]) > winch_speed:
            return 7, i
        if abs(s_rate[i]) > base_speed:
            return 8, i
        if not moving[i] and palm[i] < preload:
            return 11, i
        if not moving[i] and abs(s_rate[i]) > creep:
            return 10, i
        if away > fence:
            return 9, i
    return 0, -1
