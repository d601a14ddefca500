"""Standings that the oracle asked about, held against the planner's own answer.

What only one of the two refuses need not change how far a climb comes. A few accepted and a few rejected standings of
each trial are therefore asked again of the planner's `uses.states`.
"""

from __future__ import annotations

import numpy as np
from oracle_bodies import Array
from oracle_loads import drives
from oracle_rules import Asked, Rules

from steeplejack.planning.climb.alone import KINDS, either_way
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.places import places_on
from steeplejack.planning.climb.uses import directions, states

AUDITED = 20  # of the accepted, and of the rejected standings
SAME = 0.01  # by which uses may differ, in parts of 1 or of the use


def disagreements(rules: Rules, rng: np.random.Generator) -> list[str]:
    """Where what the planner says that holding alone takes is not what the oracle says."""
    if not rules.asked:
        return []
    asked = _drawn(rules.asked, rng)
    own, theirs = by_oracle(rules, asked), by_planner(rules, asked)
    apart = np.abs(theirs - own) / np.maximum(own, 1.0)
    return [
        f"{KINDS[kind]} with the {'upper' if asked.upper[k] else 'lower'} gripper holding at "
        f"{asked.standings[k].round(5).tolist()}: {own[k, kind]:.4f}, by the planner {theirs[k, kind]:.4f}"
        for k, kind in zip(*np.nonzero(~(apart < SAME)), strict=True)
    ]


def by_oracle(rules: Rules, asked: Asked) -> Array:
    """Parts of grip, cylinders' force and servo's torque that standings take, (n, 3)."""
    found = np.column_stack((asked.use, np.empty((len(asked.use), 2))))
    for end in (False, True):
        rows = asked.upper == end
        found[rows, 1:] = drives(rules.bodies, *rules.motions(asked.standings[rows], end), end)
    return found


def _drawn(asked: list[Asked], rng: np.random.Generator) -> Asked:
    """Some of what was accepted and some of what was not."""
    standings, upper, use = (
        np.concatenate([getattr(one, name) for one in asked]) for name in ("standings", "upper", "use")
    )
    kinds = (np.flatnonzero(use <= 1.0), np.flatnonzero(use > 1.0))
    some = np.concatenate([rng.choice(kind, min(AUDITED, len(kind)), replace=False) for kind in kinds])
    return Asked(standings[some], upper[some], use[some])


def by_planner(rules: Rules, asked: Asked) -> Array:
    """The planner's answer to the same, (n, 3)."""
    machine = Machine.of(rules.robot)
    low, high, clock_low, clock_high = asked.standings.T
    pose = rules.poses(asked.standings[:, :2], clock_high)[0]
    lower, upper = (places_on(rules.run, machine, 0, s) for s in (low, high))
    ways = directions(rules.run, machine, lower, upper, clock_high)
    moving = either_way(machine, pose, ways)
    uses = states(rules.run, machine, lower, upper, pose, moving, np.arange(len(low)), clock_high, clock_low)
    return uses[np.arange(len(low)), asked.upper.astype(int)]
