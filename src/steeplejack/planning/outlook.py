"""What a chain of stances can still come to, by what is known of the moves between them.

Shortest path on an acyclic graph whose nodes say which cell is worked, what is left to see of it, on what stance the
squad stands and how many stances it took there. Moves not planned yet count as foreseen, which is the most they can
come to. What is left beyond the first such move is therefore the least that can be: a stance that would add too little
to it may add enough to what is left in the end, and is allowed for. So where a move comes to the same wherever the
chain before it began, costs are lower bounds, and as more is learned they only rise. Hence a least cost found earlier
is still the least as long as the way it was found by costs the same, and only ways that became dearer are searched
again.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.cell import Candidate

Flags = NDArray[np.bool_]
Step = tuple[int, int]  # cell, candidate of its pool
Outcome = tuple[int, float]  # stations that can be seen, as bits of an integer, and margin in steps
Node = tuple[int, int, Step | None, int]  # cell, stations left there, stance stood on, stances taken there
Rest = tuple[int, float]  # stations missed from a node on, metres driven

STEPS = 100.0  # of the margin in 1


@dataclass(frozen=True)
class Limits:
    """How far a search goes: what a stance must add, how many a cell may have, how many moves to it are planned."""

    least_gain: int  # stations, or all that are left
    per_cell: int
    moves: int


@dataclass(frozen=True)
class Way:
    """A first move from a node, or none to leave its cell, and where that leads; no node where all cells are done."""

    step: Step | None
    outcome: Outcome | None
    missed: int  # stations given up
    driven: float  # [m]
    onward: Node | None


@dataclass
class _Found:
    """The least cost from a node on, the way it is had by, what that costs after its move, and when it was checked."""

    rest: Rest
    way: Way
    beyond: Rest
    checked: int


class Outlook:
    """Least costs from nodes on; what moves come to is told by ``learn``."""

    def __init__(self, pools: Sequence[Sequence[Candidate]], wanted: Sequence[Flags], limits: Limits) -> None:
        self._pools, self._limits = pools, limits
        self._wanted = [as_bits(flags) for flags in wanted]
        self._foreseen = [[(as_bits(each.held), in_steps(each.margin)) for each in pool] for pool in pools]
        self._learned: dict[tuple[Step | None, Step], Outcome | None] = {}
        self._moves = [0] * len(pools)
        self._levels = {margin for pool in self._foreseen for _held, margin in pool}
        self._found: dict[tuple[Node, float], _Found] = {}
        self._driven: dict[tuple[Step, Step], float] = {}
        self._age = 0

    @property
    def ran_out(self) -> bool:
        """Whether no more moves are planned to some cell."""
        return max(self._moves, default=0) >= self._limits.moves

    def learn(self, last: Step | None, step: Step, outcome: Outcome | None) -> None:
        """A move was planned; what is known of it is the worst it ever came to, and no better than foreseen."""
        self._moves[step[0]] += 1
        known = self._learned.get((last, step), self._foreseen[step[0]][step[1]])
        worst = None if known is None or outcome is None else (known[0] & outcome[0], min(known[1], outcome[1]))
        self._learned[last, step] = worst
        if worst is not None:
            self._levels.add(worst[1])
        self._age += 1

    def expected(self, last: Step | None, step: Step) -> Outcome | None:
        """What a move comes to as far as is known; None where it fails, or no more are planned to its cell."""
        if self._moves[step[0]] >= self._limits.moves:
            return None
        return self._learned.get((last, step), self._foreseen[step[0]][step[1]])

    def driven(self, last: Step | None, step: Step) -> float:
        """Metres the bases drive from one candidate to another."""
        if last is None:
            return 0.0
        if (last, step) not in self._driven:
            here, there = (self._pools[cell][k].stance.s for cell, k in (last, step))
            self._driven[last, step] = sum(abs(a - b) for a, b in zip(here, there, strict=True))
        return self._driven[last, step]

    def moves(self, node: Node, sure: bool = True) -> Iterator[Way]:
        """Moves to stances of a node's cell that add enough, or may where what is left there is not ``sure``."""
        cell, left, last, used = node
        if used >= self._limits.per_cell:
            return
        most = left if sure else self._wanted[cell]
        for k in range(len(self._pools[cell])):
            step = cell, k
            outcome = self.expected(last, step)
            if step != last and outcome is not None and self._enough(outcome[0], left, most):
                onward = cell, left & ~outcome[0], step, used + 1
                yield Way(step, outcome, 0, self.driven(last, step), onward)

    def _enough(self, held: int, least: int, most: int) -> bool:
        """Whether a stance that holds these stations adds enough to some that lie between the least and the most."""
        gain = (held & most).bit_count()
        return gain >= max(1, self._limits.least_gain) or (gain > 0 and not least & ~held)

    def after(self, cell: int, last: Step | None) -> Node | None:
        """The node that a cell is left to; None after the last cell."""
        return (cell + 1, self._wanted[cell + 1], last, 0) if cell + 1 < len(self._pools) else None

    def at_best(self, node: Node, most: float) -> tuple[int, float, float]:
        """Stations missed from a node on, the largest least margin for that, ``most`` at most, and metres driven."""
        levels = [*sorted(level for level in self._levels if level < most), most]
        least = self.rest(node, levels[0])[0]
        low, high = 0, len(levels) - 1  # fewer stations are missed where less margin is asked for
        while low < high:
            middle = (low + high + 1) // 2
            low, high = (middle, high) if self.rest(node, levels[middle])[0] == least else (low, middle - 1)
        return least, levels[low], self.rest(node, levels[low])[1]

    def first(self, node: Node | None, level: float) -> Step | None:
        """The first move of the least way from a node that `at_best` was asked about; None where it has none."""
        while node is not None:
            way = self._found[node, level].way
            if way.step is not None:
                return way.step
            node = way.onward
        return None

    def rest(self, node: Node, level: float) -> Rest:
        """Least stations missed from a node on, and metres driven for that, with margins of at least a level."""
        open_ = [node]
        while open_:
            here = open_[-1]
            stale = self._stale(here, level)
            if stale:
                open_ += stale
            else:
                open_.pop()
        return self._found[node, level].rest

    def _stale(self, node: Node, level: float) -> list[Node]:
        """Nodes to be seen to before this one; none where it could be, and has been, brought up to date."""
        found = self._found.get((node, level))
        if found is not None and found.checked == self._age:
            return []
        if found is not None and self._goes(found.way, node[2], level):
            onward = found.way.onward
            if onward is not None and not self._fresh(onward, level):
                return [onward]
            if self._beyond(onward, level) == found.beyond:
                found.checked = self._age
                return []
        ways = [self._leave(node), *self._allowed(node, level)]
        stale = [way.onward for way in ways if way.onward is not None and not self._fresh(way.onward, level)]
        if not stale:
            self._found[node, level] = min((self._by(way, level) for way in ways), key=lambda each: each.rest)
        return stale

    def _leave(self, node: Node) -> Way:
        cell, left, last, _used = node
        return Way(None, None, left.bit_count(), 0.0, self.after(cell, last))

    def _allowed(self, node: Node, level: float) -> Iterator[Way]:
        return (way for way in self.moves(node, sure=False) if way.outcome and way.outcome[1] >= level)

    def _goes(self, way: Way, last: Step | None, level: float) -> bool:
        """Whether a way found earlier still is one."""
        if way.step is None:
            return True
        now = self.expected(last, way.step)
        return now is not None and way.outcome is not None and now[0] == way.outcome[0] and now[1] >= level

    def _fresh(self, node: Node, level: float) -> bool:
        found = self._found.get((node, level))
        return found is not None and found.checked == self._age

    def _beyond(self, node: Node | None, level: float) -> Rest:
        return (0, 0.0) if node is None else self._found[node, level].rest

    def _by(self, way: Way, level: float) -> _Found:
        beyond = self._beyond(way.onward, level)
        return _Found((way.missed + beyond[0], way.driven + beyond[1]), way, beyond, self._age)


def as_bits(flags: Flags) -> int:
    """Flags of any shape as the bits of an integer."""
    return int.from_bytes(np.packbits(flags).tobytes())


def in_steps(margin: float) -> float:
    """A margin rounded down to the steps that count."""
    return float(np.floor(STEPS * margin + 1e-6)) / STEPS
