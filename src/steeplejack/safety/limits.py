"""Declared limits of one run, and the check of one command against them."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.rest.statics import directions
from steeplejack.robots.squad.parameters import Squad

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

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
    "commanded wheel traction above its limit, or on a base that should stand",
    "commanded turning rate above its limit, or on a base that should stand",
    "grip lost: a base that should stand turns about its stay",
    "palms of a base that should stand are told to open",
    "more than one base under way",
    "commanded pull along the stay above the limit of its base",
    "the cables do not balance the weight: the platform touches something or is far off its place",
)
NOT_A_NUMBER = 1

# Share of the preload below which a closed palm counts as lost. Noise lets "closed" be seen from 0.92 on, seven
# standard deviations of the sensor above; 0.87 of the preload still holds a base at its rated pull on every stay of
# Table IV.
HELD = 0.87


@dataclass(frozen=True)
class Limits:
    """Declared limits of one run."""

    commanded: tuple[float, float]  # [N] least and largest commanded winch pull
    tension: tuple[float, float]  # [N] least (slack) and largest measured tension
    hold: float  # [N] pull along the stay, gripped
    drive: float  # [N] pull along the stay, driving; wheel traction
    allowance: float  # [N] of a commanded pull, for the friction and inertia it overcomes
    winch_speed: float  # [m/s]
    base_speed: float  # [m/s]
    fence: float  # [m] of a cable's length from the one its place asks for
    creep: float  # [m/s] of a gripped base
    palm: float  # [N] least preload of a gripped base
    turn_rate: float  # [rad/s] commanded, of a base about its stay
    turn: float  # [rad] of a gripped base from where it gripped
    imbalance: float  # [N] of measured tensions and weight

    @classmethod
    def of(cls, squad: Squad, tension: tuple[float, float], weight: float) -> Limits:
        """The limits of a machine, a working window [N] and the weight of platform and payload [N]."""
        (low, high), base, safety = tension, squad.base, squad.safety
        allowance = safety.pull_allowance * squad.winch.friction
        return cls(
            commanded=(max(0.0, low - allowance), high + allowance),
            tension=(safety.slack_share * low, (1.0 + safety.tension_excess) * high),
            hold=base.hold_force,
            drive=base.drive_force,
            allowance=allowance,
            winch_speed=squad.winch.max_speed,
            base_speed=base.max_speed,
            fence=safety.fence,
            creep=safety.creep,
            palm=HELD * squad.gripper.force,
            turn_rate=base.max_turn_rate,
            turn=safety.turn,
            imbalance=safety.imbalance * weight,
        )

    @property
    def vector(self) -> Array:
        """Every limit (15,) in the order of the fields, for the compiled check."""
        return np.hstack([np.ravel(getattr(self, field.name)) for field in fields(self)])


@njit(cache=True)
def check(
    command: Array,
    grip: Flags,
    tension: Array,
    pay_rate: Array,
    s_rate: Array,
    palm: Array,
    turned: Array,
    moving: Flags,
    exits: Array,
    tangents: Array,
    attachments: Array,
    lengths: Array,
    weight: Array,
    goal: Array,
    goal_rotation: Array,
    limits: Array,
) -> tuple[int, int]:
    """Code of the first breach and the cable or base it concerns, 0 to 3, or -1; (0, -1) if all is well.

    Cables run from their exits to the attachments of the platform at its goal. How far off it the platform can be and
    still pass: half a metre in the plane of the cables, where lengths tell; out of that plane lengths change little and
    only the balance of forces tells, by metres. A number that is not finite is a breach of its own.

    Args:
        command: Winch pulls [N], wheel tractions [N], turning rates [rad/s] (3, 4).
        grip: Palms told to be closed (4,).
        tension: Measured tensions (4,) [N].
        pay_rate: Winch rates (4,) [m/s].
        s_rate: Base rates (4,) [m/s].
        palm: Palm preloads (4,) [N].
        turned: Clock angles less those at which the bases gripped (4,) [rad].
        moving: Bases under way (4,).
        exits: Winch exits (4, 3) [m].
        tangents: Stay tangents there (4, 3).
        attachments: Attachments (4, 3) [m], platform frame.
        lengths: Loaded cable lengths as measured (4,) [m].
        weight: Gravity force on platform and payload (3,) [N].
        goal: Reference position (3,) [m].
        goal_rotation: Reference orientation (3, 3).
        limits: See ``Limits.vector``.
    """
    (least, most, slack, tight, hold, drive, allowance, winch_speed, base_speed,
     fence, creep, preload, turn_rate, turn, imbalance) = limits  # fmt: skip
    u, asked = directions(exits, attachments, goal, goal_rotation)
    under_way = 0
    for i in range(4):
        pull, traction, turning = command[0, i], command[1, i], command[2, i]
        share = abs(u[i, 0] * tangents[i, 0] + u[i, 1] * tangents[i, 1] + u[i, 2] * tangents[i, 2])
        along, away = tension[i] * share, abs(lengths[i] - asked[i])
        # One number that is not finite makes the sum so; comparisons with it below would all be false.
        numbers = pull + traction + turning + along + away + pay_rate[i] + s_rate[i] + palm[i] + turned[i]
        if not np.isfinite(numbers):
            return 1, i
        if pull < least or pull > most:
            return 2, i
        if abs(traction) > (drive if moving[i] else 0.0):
            return 12, i
        if abs(turning) > (turn_rate if moving[i] else 0.0):
            return 13, i
        if not moving[i] and not grip[i]:
            return 15, i
        if tension[i] > tight:
            return 3, i
        if tension[i] < slack:
            return 4, i
        if not moving[i] and along > hold:
            return 5, i
        if moving[i] and along > drive:
            return 6, i
        if (pull - allowance) * share > (drive if moving[i] else hold):
            return 17, i
        if abs(pay_rate[i]) > winch_speed:
            return 7, i
        if abs(s_rate[i]) > base_speed:
            return 8, i
        if not moving[i] and palm[i] < preload:
            return 11, i
        if not moving[i] and abs(s_rate[i]) > creep:
            return 10, i
        if not moving[i] and abs(turned[i]) > turn:
            return 14, i
        if away > fence:
            return 9, i
        under_way += 1 if moving[i] else 0
    if under_way > 1:
        return 16, -1
    return (18, -1) if unbalanced(u, tension, weight) > imbalance else (0, -1)


@njit(cache=True)
def unbalanced(u: Array, tension: Array, weight: Array) -> float:
    """Size of the force [N] that four tensions along ``u`` (4, 3) leave of a weight (3,) [N]."""
    square = 0.0
    for k in range(3):
        force = weight[k]
        for i in range(4):
            force += tension[i] * u[i, k]
        square += force * force
    return np.sqrt(square)
