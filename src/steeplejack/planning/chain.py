"""Which stances to take, cell by cell: a shortest path whose moves are planned only when it asks for them.

A chain visits stances of the cells in order, several of one cell where one does not hold all of it. What a stance
holds is known beforehand; what the squad can do there, and whether it gets there, only after its move has been planned,
which is dear. So the best chain is found with every move not yet planned taken to come to what is foreseen, its first
such move is planned, what came of it is kept, and so on until the best chain is planned throughout (lazy shortest path:
Dellin and Srinivasa, ICAPS 2016). Objective, in this order: stations missed, least slip margin of the stances
in steps of 0.01, metres driven.

What a move between two stances came to is taken to be the same wherever the platform starts from, until it is planned
from there; one that failed is not planned again, for what fails from one start mostly fails from all, and the moves to
a cell would be used up. So the answer is the best of these candidates as far as that holds.

A stance counts with the worst station it holds, even where another stance shows that station and it is not flown from
this one: its margin is no better than foreseen, so that what is learned never makes a chain cheaper. The margin of what
is flown may be larger than the one that chains were compared by.

No more than ``moves`` moves to a cell are planned, from whatever stance and start. Where they run out and stations are
missed that could be held, the chain that takes in each cell the stance that holds most is planned as well, as far as it
was not, and the better is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.cell import Candidate
from steeplejack.planning.outlook import Limits, Outlook, Step, as_bits, in_steps

Flags = NDArray[np.bool_]
Cost = tuple[int, float, float]  # stations missed, minus the least margin, metres driven
State = TypeVar("State")
Move = Callable[[State, Step, Flags], tuple[State, Flags, float] | None]
"""Plans the move from a state to a candidate with stations left to see: state after it, stations seen, least margin."""


@dataclass(frozen=True, eq=False)
class Planned(Generic[State]):
    """A chain whose moves are planned."""

    steps: tuple[Step, ...]
    state: State
    left: tuple[Flags, ...]  # stations of every cell not seen
    margin: float
    driven: float  # [m]

    @property
    def last(self) -> Step | None:
        """Where the squad stands; None before it stands anywhere."""
        return self.steps[-1] if self.steps else None

    @property
    def cell(self) -> int:
        """The cell it stands at."""
        return self.steps[-1][0] if self.steps else 0

    @property
    def cost(self) -> Cost:
        """What it costs if it ends here."""
        return sum(int(np.sum(left)) for left in self.left), -in_steps(self.margin), self.driven


def best_chain(
    pools: Sequence[Sequence[Candidate]],
    wanted: Sequence[Flags],
    start: State,
    move: Move[State],
    limits: Limits,
) -> Planned[State]:
    """The best chain of stances over cells with candidates each, planned throughout.

    Args:
        pools: Candidates of every cell.
        wanted: Stations of every cell to be seen, in any shape.
        start: State before the first stance.
        move: Plans a move; None where there is none.
        limits: How far to go.
    """
    search = _Search(pools, wanted, move, limits)
    first = Planned((), start, tuple(wanted), 1.0, 0.0)
    found = search.lazily(first)
    for cell, pool in enumerate(pools):
        if search.outlook.ran_out and any(np.any(found.left[cell] & each.held) for each in pool):
            return min(found, search.greedily(first), key=lambda chain: chain.cost)
    return found


class _Search(Generic[State]):
    """The chains planned so far, none twice."""

    def __init__(
        self, pools: Sequence[Sequence[Candidate]], wanted: Sequence[Flags], move: Move[State], limits: Limits
    ) -> None:
        self._pools, self._move, self._limits = pools, move, limits
        self._planned: dict[tuple[Step, ...], Planned[State] | None] = {}
        self._tried: dict[tuple[Step, ...], set[Step]] = {}  # next steps of chains
        self.outlook = Outlook(pools, wanted, limits)

    def lazily(self, first: Planned[State]) -> Planned[State]:
        """The best chain, planned throughout, within the limit of moves."""
        chains, best = [first], [self.next(first)]
        while True:
            rank = min(range(len(chains)), key=lambda k: (best[k][0], -len(chains[k].steps), k))
            fresh = self.next(chains[rank])
            if fresh != best[rank]:  # what was learned since made it dearer, never cheaper
                best[rank] = fresh
                continue
            if fresh[1] is None:
                return chains[rank]
            grown = self.grow(chains[rank], fresh[1])
            best[rank] = self.next(chains[rank])
            if grown is not None:
                chains.append(grown)
                best.append(self.next(grown))

    def greedily(self, first: Planned[State]) -> Planned[State]:
        """The chain that takes in every cell what holds most of what is left, of what can be reached."""
        chain = first
        for cell, pool in enumerate(self._pools):
            for _ in range(self._limits.per_cell):
                left = chain.left[cell]
                gains = [int(np.sum(left & each.held)) for each in pool]
                least = max(1, min(self._limits.least_gain, int(np.sum(left))))
                order = sorted((k for k, gain in enumerate(gains) if gain >= least), key=lambda k: -gains[k])
                grown = (self.grow(chain, (cell, k)) for k in order if (cell, k) != chain.last)
                further = next((each for each in grown if each is not None), None)
                if further is None:
                    break
                chain = further
        return chain

    def next(self, chain: Planned[State]) -> tuple[Cost, Step | None]:
        """The least a chain can cost, and the step not planned from it yet that it goes on with; None where it ends."""
        own, last = in_steps(chain.margin), chain.last
        left = [as_bits(flags) for flags in chain.left]
        missed = sum(bits.bit_count() for bits in left[: chain.cell])
        options: list[tuple[Cost, Step | None]] = [(chain.cost, None)]
        tried = self._tried.get(chain.steps, set())
        beyond = max((step[0] for step in tried), default=chain.cell)  # after it the outlook knows all there is
        for cell in range(chain.cell, beyond + 1):
            used = sum(step[0] == cell for step in chain.steps)
            for way in self.outlook.moves((cell, left[cell], last, used)):
                assert way.step and way.outcome and way.onward
                if way.step not in tried and way.step not in chain.steps:
                    more, level, far = self.outlook.at_best(way.onward, min(own, way.outcome[1]))
                    options.append(((missed + more, -level, chain.driven + way.driven + far), way.step))
            missed += left[cell].bit_count()
        node = self.outlook.after(beyond, last)
        if node is not None:
            more, level, far = self.outlook.at_best(node, own)
            options.append(((missed + more, -level, chain.driven + far), self.outlook.first(node, level)))
        return min(options, key=lambda option: option[0])

    def grow(self, chain: Planned[State], step: Step) -> Planned[State] | None:
        """The chain with one more move; None where that came to nothing. Planned once, and learned from."""
        steps = *chain.steps, step
        if steps not in self._planned:
            self._tried.setdefault(chain.steps, set()).add(step)
            self._planned[steps] = self._grown(chain, step)
        return self._planned[steps]

    def _grown(self, chain: Planned[State], step: Step) -> Planned[State] | None:
        cell, k = step
        left = chain.left[cell]
        found = self._move(chain.state, step, left)
        if found is None:
            self.outlook.learn(chain.last, step, None)
            return None
        state, seen, margin = found
        margin = min(margin, self._pools[cell][k].margin)  # no better than foreseen, so that costs never fall
        self.outlook.learn(chain.last, step, (as_bits(~left | seen), in_steps(margin)))
        if not np.any(left & seen):
            return None
        after = (*chain.left[:cell], left & ~seen, *chain.left[cell + 1 :])
        driven = chain.driven + self.outlook.driven(chain.last, step)
        return Planned((*chain.steps, step), state, after, min(chain.margin, margin), driven)
