"""The gait's state machine, over every state, every act and every sequence of acts."""

from __future__ import annotations

from itertools import product

import pytest

from steeplejack.errors import InputError
from steeplejack.planning.climb.gait import BEARS, KINDS, NEXT, acts, after, walk
from steeplejack.planning.climb.plan import Hold

CLOSED = {Hold.BOTH: {"lower", "upper"}, Hold.LOWER: {"lower"}, Hold.UPPER: {"upper"}}


@pytest.mark.parametrize(("hold", "kind"), list(product(Hold, KINDS)))
def test_every_act_in_every_state(hold, kind):
    closed = set(CLOSED[hold])
    verb, _, end = kind.partition("-")
    legal = {"move": len(closed) == 1, "grip": end not in closed, "release": len(closed) == 2}[verb]
    if not legal:
        with pytest.raises(InputError, match=f"{kind} while {hold.value} hold") as error:
            after(hold, kind)
        assert "\n" not in str(error.value)
        return
    closed = closed | {end} if verb == "grip" else closed - {end} if verb == "release" else closed
    assert CLOSED[after(hold, kind)] == closed
    # A gripper that closes or opens bears nothing meanwhile.
    assert CLOSED[BEARS[hold, kind]] == (CLOSED[hold] if verb == "move" else CLOSED[hold] - {end} or closed - {end})


def test_no_sequence_of_acts_opens_both():
    for length in range(1, 8):
        for kinds in product(KINDS, repeat=length):
            try:
                hold = walk(kinds)
            except InputError:
                continue
            assert CLOSED[hold]


def test_every_state_leads_back_to_both_closed():
    for hold in Hold:
        reached, border = {hold}, [hold]
        while border:
            now = border.pop()
            new = {NEXT[now, kind] for kind in KINDS if (now, kind) in NEXT} - reached
            reached |= new
            border += new
        assert reached == set(Hold)


def test_a_step_is_release_move_grip_of_one_end():
    assert walk(acts(Hold.UPPER)) is Hold.BOTH
    assert walk((*acts(Hold.UPPER), *acts(Hold.LOWER))) is Hold.BOTH
    assert acts(Hold.LOWER) == ("release-lower", "move", "grip-lower")
    with pytest.raises(InputError, match="both"):
        acts(Hold.BOTH)
