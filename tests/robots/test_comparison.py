"""Which values of two machines differ."""

from __future__ import annotations

import msgspec

from steeplejack.robots.squad import Squad
from steeplejack.robots.squad.comparison import differing


def test_a_machine_does_not_differ_from_itself(squad: Squad) -> None:
    assert differing(squad, squad) == ()


def test_every_value_that_differs_is_named_in_the_order_of_the_file(squad: Squad) -> None:
    other = msgspec.structs.replace(
        squad,
        name="other",
        winch=msgspec.structs.replace(squad.winch, friction=6.0, ratio=10.0),
        platform=msgspec.structs.replace(squad.platform, inertia=(0.1, 0.1, 0.1)),
    )
    assert differing(squad, other) == differing(other, squad)
    assert differing(squad, other) == ("name", "platform.inertia", "winch.ratio", "winch.friction")


def test_another_source_is_no_other_machine(squad: Squad) -> None:
    winch = msgspec.structs.replace(squad.winch, source=squad.winch.source | {"friction": "measured"})
    assert differing(squad, msgspec.structs.replace(squad, winch=winch)) == ()
