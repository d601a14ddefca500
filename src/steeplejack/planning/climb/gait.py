"""The gait as a state machine: which gripper holds, and which acts are possible then.

    BOTH  --release-upper-->  LOWER  --move-->  LOWER  --grip-upper-->  BOTH
    BOTH  --release-lower-->  UPPER  --move-->  UPPER  --grip-lower-->  BOTH

`NEXT` is the whole machine: an act that is not in it does not exist. As there is no state without a gripper closed, no
sequence of acts opens both.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import get_args

from steeplejack.errors import InputError
from steeplejack.planning.climb.plan import Hold, Kind

KINDS: tuple[Kind, ...] = get_args(Kind)

NEXT: dict[tuple[Hold, Kind], Hold] = {
    (Hold.BOTH, "release-upper"): Hold.LOWER,
    (Hold.LOWER, "move"): Hold.LOWER,
    (Hold.LOWER, "grip-upper"): Hold.BOTH,
    (Hold.BOTH, "release-lower"): Hold.UPPER,
    (Hold.UPPER, "move"): Hold.UPPER,
    (Hold.UPPER, "grip-lower"): Hold.BOTH,
}
"""What holds after an act, by what holds before it."""

BEARS: dict[tuple[Hold, Kind], Hold] = {
    (before, kind): before if after is Hold.BOTH else after for (before, kind), after in NEXT.items()
}
"""What holds throughout an act: a gripper that closes or opens does not count."""


def after(hold: Hold, kind: Kind) -> Hold:
    """What holds after an act.

    Args:
        hold: What holds before it.
        kind: The act.

    Returns:
        What holds then.

    Raises:
        InputError: An act that is not possible then; the message names those that are.
    """
    found = NEXT.get((hold, kind))
    if found is None:
        possible = ", ".join(other for state, other in NEXT if state is hold)
        raise InputError("gait", f"{kind} while {hold.value} hold", possible)
    return found


def walk(kinds: Iterable[Kind], start: Hold = Hold.BOTH) -> Hold:
    """What holds after a sequence of acts; raises as `after` does."""
    hold = start
    for kind in kinds:
        hold = after(hold, kind)
    return hold


def acts(moves: Hold) -> tuple[Kind, Kind, Kind]:
    """The acts of one step in which the gripper that ``moves`` is the only one to open.

    Raises:
        InputError: Both grippers.
    """
    if moves is Hold.BOTH:
        raise InputError("gait", "both grippers to move", "one of them")
    return ("release-upper", "move", "grip-upper") if moves is Hold.UPPER else ("release-lower", "move", "grip-lower")
