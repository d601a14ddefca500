"""The gait core as an explicit table: which phase a leg is in, and what ends it.

A flight has one phase. A drive opens the palms of one base, drives, closes them, and verifies the grip before anything
else moves: the palm sensor reads the preload and the wheel stands still for a while under the cable's pull, wheels off.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from steeplejack.safety import HELD

Array = NDArray[np.float64]


class Phase(Enum):
    """What the squad is doing."""

    FLY = "fly"
    OPEN = "open palms"
    DRIVE = "drive"
    CLOSE = "close palms"
    VERIFY = "verify grip"
    DONE = "done"
    STOPPED = "stopped on brakes"


class Outcome(Enum):
    """What a phase ended with."""

    REACHED = "reached"
    TIMEOUT = "timeout"
    BREACH = "breach"


# The whole gait: (phase, outcome) -> next phase. DONE means the leg is over.
TRANSITIONS: dict[tuple[Phase, Outcome], Phase] = {
    (Phase.FLY, Outcome.REACHED): Phase.DONE,
    (Phase.OPEN, Outcome.REACHED): Phase.DRIVE,
    (Phase.OPEN, Outcome.TIMEOUT): Phase.STOPPED,
    (Phase.DRIVE, Outcome.REACHED): Phase.CLOSE,
    (Phase.DRIVE, Outcome.TIMEOUT): Phase.STOPPED,
    (Phase.CLOSE, Outcome.REACHED): Phase.VERIFY,
    (Phase.CLOSE, Outcome.TIMEOUT): Phase.STOPPED,
    (Phase.VERIFY, Outcome.REACHED): Phase.DONE,
    (Phase.VERIFY, Outcome.TIMEOUT): Phase.STOPPED,
    **{(phase, Outcome.BREACH): Phase.STOPPED for phase in Phase if phase not in (Phase.DONE, Phase.STOPPED)},
}

OPENED, CLOSED = 0.05, 0.95  # shares of the palm preload that count as open and closed
STILL = 5e-4  # [m] a wheel may move while its grip is verified
VERIFY_TIME = 0.5  # [s]
ARRIVED = 0.01  # [m] from the end of the drive
PATIENCE = 5.0  # [s] beyond the expected time of a phase


@dataclass(frozen=True)
class Progress:
    """Where in a leg the squad is."""

    phase: Phase
    since: float  # [s] when the phase began
    mark: float = 0.0  # [m] wheel reading when the phase began


def judge(
    progress: Progress, now: float, duration: float, palm: float, s: float, goal: float, close_time: float
) -> Outcome | None:
    """Whether the current phase is over, from measurements alone.

    Args:
        progress: The phase and when it began.
        now: Time [s].
        duration: Of the leg's motion [s].
        palm: Palm preload of the base under way as a share of the nominal [1].
        s: Its wheel reading [m].
        goal: Where its drive ends [m].
        close_time: Palms open to closed [s].
    """
    elapsed = now - progress.since
    match progress.phase:
        case Phase.FLY:
            return Outcome.REACHED if elapsed >= duration else None
        case Phase.OPEN:
            if palm <= OPENED:
                return Outcome.REACHED
            return Outcome.TIMEOUT if elapsed > close_time + PATIENCE else None
        case Phase.DRIVE:
            if elapsed >= duration and abs(s - goal) <= ARRIVED:
                return Outcome.REACHED
            return Outcome.TIMEOUT if elapsed > duration + PATIENCE else None
        case Phase.CLOSE:
            if palm >= CLOSED:
                return Outcome.REACHED
            return Outcome.TIMEOUT if elapsed > close_time + PATIENCE else None
        case Phase.VERIFY:
            if not (palm >= HELD and abs(s - progress.mark) <= STILL):  # also where a reading is not a number
                return Outcome.TIMEOUT
            return Outcome.REACHED if elapsed >= VERIFY_TIME else None
        case _:
            return None
