"""Which values of one machine differ from those of another."""

from __future__ import annotations

from steeplejack.robots.sourced import Sourced
from steeplejack.robots.squad.parameters import Squad


def differing(one: Squad, other: Squad) -> tuple[str, ...]:
    """Names of the values in which two machines differ, such as ``winch.friction``; sources do not count."""
    names: list[str] = []
    for table in one.__struct_fields__:
        mine, theirs = getattr(one, table), getattr(other, table)
        if isinstance(mine, Sourced):
            fields = (field for field in mine.__struct_fields__ if field != "source")
            names += [f"{table}.{field}" for field in fields if getattr(mine, field) != getattr(theirs, field)]
        elif mine != theirs:
            names.append(table)
    return tuple(names)
