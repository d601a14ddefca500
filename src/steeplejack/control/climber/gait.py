"""The gait core as an explicit table: what the climber is doing, and what comes after it.

A plan's phases move the robot, close a gripper or open one; before one opens, the other takes over its load. Where the
gripper that holds slips, both are closed at once; then the one that slipped is opened and closed again, the other one
let go as before, and what was interrupted goes on. No entry of the table leads to an act in which both grippers are
open.
"""

from __future__ import annotations

from enum import Enum


class Act(Enum):
    """What the climber is doing."""

    MOVE = "move"
    CLOSE = "close"
    SHIFT = "shift the load"
    OPEN = "open"
    RESCUE = "close both"
    REOPEN = "open the one that slipped"
    RECLOSE = "close the one that slipped"
    RESUME = "let go again"
    DONE = "done"
    STOPPED = "stopped, both closed"


class Outcome(Enum):
    """What an act ended with."""

    REACHED = "reached"
    SLIPPED = "slipped"
    FAILED = "failed"


# (act, outcome) -> next act. DONE means the phase is over. After RESUME the phase goes on, see `taken_up`.
TRANSITIONS: dict[tuple[Act, Outcome], Act] = {
    (Act.MOVE, Outcome.REACHED): Act.DONE,
    (Act.CLOSE, Outcome.REACHED): Act.DONE,
    (Act.SHIFT, Outcome.REACHED): Act.OPEN,
    (Act.OPEN, Outcome.REACHED): Act.DONE,
    (Act.RESCUE, Outcome.REACHED): Act.REOPEN,
    (Act.REOPEN, Outcome.REACHED): Act.RECLOSE,
    (Act.RECLOSE, Outcome.REACHED): Act.RESUME,
    (Act.RESUME, Outcome.REACHED): Act.MOVE,
    **{
        (act, Outcome.SLIPPED): Act.RESCUE
        for act in (Act.MOVE, Act.CLOSE, Act.SHIFT, Act.OPEN, Act.REOPEN, Act.RECLOSE, Act.RESUME)
    },
    **{(act, Outcome.FAILED): Act.STOPPED for act in Act if act not in (Act.DONE, Act.STOPPED)},
}

FIRST: dict[str, Act] = {
    "move": Act.MOVE, "grip-lower": Act.CLOSE, "grip-upper": Act.CLOSE, "release-lower": Act.SHIFT,
    "release-upper": Act.SHIFT,
}  # fmt: skip
"""What a phase of each kind begins with."""

ALLOWED = 2
"""Slips of one gripper in one phase after which it is tried again; the next one ends the climb."""


def taken_up(kind: str) -> Act:
    """What a phase goes on with after a rescue: RESUME has already opened what a release opens."""
    return Act.OPEN if FIRST[kind] is Act.SHIFT else FIRST[kind]


def closed_in(act: Act, phase_closed: tuple[bool, bool], slipped: int) -> tuple[bool, bool]:
    """Which grippers are told to be closed.

    Args:
        act: What is done.
        phase_closed: What the phase of the plan wants at its end.
        slipped: The gripper that slipped last, 0 for the lower one, 1 for the upper one; used after a rescue only.

    Returns:
        Lower and upper gripper; never neither.
    """
    if act in (Act.SHIFT, Act.RESCUE, Act.RECLOSE, Act.STOPPED):
        return True, True
    if act is Act.REOPEN:
        return slipped != 0, slipped != 1
    return phase_closed
