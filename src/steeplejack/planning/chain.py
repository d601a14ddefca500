"""Which stances to take, cell by cell: a shortest path whose moves are planned only when it asks for them.

A chain visits stances of the cells in order, several of one cell where one does not hold all of it. What a stance
holds is known beforehand; what the squad can do there, and whether it gets there, only after its move has been planned,
which is dear. So the best chain is found with every move not yet planned taken to succeed, its first such move is
planned, what came of it is kept, and so on until the best chain is planned throughout (lazy shortest path: Dellin and
Srinivasa, ICAPS 2016). Objective, in this order: stations missed, least slip margin in steps of 0.01, metres driven.

What a move between two stances came to is taken to be the same wherever the platform starts from, until it is planned
from there; one that failed is not planned again. So the answer is the best of these candidates as far as that holds,
and no more than ``moves`` different moves to a cell are planned. Where they run out and stations are missed that
could be held, the chain that takes in each cell the stance that holds most is planned as well, and the better is
taken.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.cell import Candidate

Flags = NDArray[np.bool_]
Step = tuple[int, int]  # cell, candidate of its pool
Cost = tuple[int, float, float]  # stations missed, minus the least margin, metres driven
State = TypeVar("State")
Move = Callable[[State, Step, Flags], tuple[State, Flags, float] | None]
"""Plans the move from a state to a candidate with stations left to see: state after it, stations seen, least margin."""

STEPS = 100.0  # of the margin in 1


@dataclass(frozen=True)
class Limits:
    """How far a search goes: what a stance must add, how many a cell may have, how many moves to it are planned."""

    least_gain: int  # stations, or all that are left
    per_cell: int
    moves: int


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
        if search.ran_out and any(np.any(found.left[cell] & each.held) for each in pool):
            return min(found, search.greedily(first), key=_cost)
    return found


class _Search(Generic[State]):
    """What is known of the moves, and what chains cost by it. Stations are bits of an integer here."""

    def __init__(
        self, pools: Sequence[Sequence[Candidate]], wanted: Sequence[Flags], move: Move[State], limits: Limits
    ) -> None:
        self._pools, self._move, self._limits = pools, move, limits
        self._wanted = [_bits(flags) for flags in wanted]
        self._held = [[_bits(each.held) for each in pool] for pool in pools]
        self._learned: dict[tuple[Step | None, Step], tuple[int, float] | None] = {}
        self._moves = [0] * len(pools)
        self._tried: set[tuple[Step, ...]] = set()
        self._rests: dict[tuple[int, int, Step, int, float], tuple[int, float]] = {}
        self._levels = sorted({_steps(each.margin) for pool in pools for each in pool})

    @property
    def ran_out(self) -> bool:
        """Whether no more moves may be planned to some cell."""
        return max(self._moves) >= self._limits.moves

    def lazily(self, first: Planned[State]) -> Planned[State]:
        """The best chain, planned throughout, within the limit of moves."""
        planned, best = [first], [self.next(first)]
        while True:
            rank = min(range(len(planned)), key=lambda k: (best[k][0], -len(planned[k].steps), k))
            fresh = self.next(planned[rank])
            if fresh != best[rank]:  # what was learned since made it dearer, never cheaper
                best[rank] = fresh
                continue
            if fresh[1] is None:
                return planned[rank]
            grown = self.grow(planned[rank], fresh[1])
            best[rank] = self.next(planned[rank])
            if grown is not None:
                planned.append(grown)
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
        """The least a chain can cost, and the step not planned yet that it goes on with; None where it ends."""
        own = _steps(chain.margin)
        left = [_bits(flags) for flags in chain.left]
        missed = sum(bits.bit_count() for bits in left[: chain.cell])
        best: tuple[Cost, Step | None] = (sum(bits.bit_count() for bits in left), -own, chain.driven), None
        for cell in range(chain.cell, len(self._pools)):
            used = sum(step[0] == cell for step in chain.steps)
            for step, held, margin, driven in self._open(left[cell], cell, chain.last, used):
                if (*chain.steps, step) in self._tried or step in chain.steps:
                    continue
                rest = cell, left[cell] & ~held, step, used + 1
                more, level, far = self._at_best(rest, min(own, margin))
                cost = missed + more, -level, chain.driven + driven + far
                if cost < best[0]:
                    best = cost, step
            missed += left[cell].bit_count()
        return best

    def _at_best(self, rest: tuple[int, int, Step, int], most: float) -> tuple[int, float, float]:
        """Stations missed by the rest of a chain, its least margin if no more than ``most``, metres driven for that."""
        levels = [*(level for level in self._levels if level < most), most]
        least, _far = self._rest(*rest, levels[0])
        low, high = 0, len(levels) - 1  # fewer stations are missed where less margin is asked for
        while low < high:
            middle = (low + high + 1) // 2
            low, high = (middle, high) if self._rest(*rest, levels[middle])[0] == least else (low, middle - 1)
        return least, levels[low], self._rest(*rest, levels[low])[1]

    def _open(self, left: int, cell: int, last: Step | None, used: int) -> Iterator[tuple[Step, int, float, float]]:
        """Candidates of a cell that may come next: step, what it holds, its margin, metres driven there."""
        if used >= self._limits.per_cell or not left:
            return
        least = min(self._limits.least_gain, left.bit_count())
        for k, candidate in enumerate(self._pools[cell]):
            step = cell, k
            found = self._held[cell][k], candidate.margin
            if (last, step) in self._learned:
                found = self._learned[last, step]
            elif self._moves[cell] >= self._limits.moves:
                continue
            if found is not None and step != last and (found[0] & left).bit_count() >= least:
                yield step, found[0], _steps(found[1]), self._between(last, step)

    def _between(self, last: Step | None, step: Step) -> float:
        """Metres the bases drive from one candidate to another."""
        if last is None:
            return 0.0
        here, there = (self._pools[cell][k].stance.s for cell, k in (last, step))
        return sum(abs(a - b) for a, b in zip(here, there, strict=True))

    def _rest(self, cell: int, left: int, last: Step, used: int, level: float) -> tuple[int, float]:
        """Least stations missed, and metres driven for that, from a candidate on with margins of at least a level."""
        key = cell, left, last, used, level
        if key in self._rests:
            return self._rests[key]
        more, far = 0, 0.0
        if cell + 1 < len(self._pools):
            more, far = self._rest(cell + 1, self._wanted[cell + 1], last, 0, level)
        best = left.bit_count() + more, far
        for step, held, margin, driven in self._open(left, cell, last, used):
            if margin >= level:
                more, far = self._rest(cell, left & ~held, step, used + 1, level)
                best = min(best, (more, driven + far))
        self._rests[key] = best
        return best

    def grow(self, chain: Planned[State], step: Step) -> Planned[State] | None:
        """The chain with one more move planned; None where that came to nothing."""
        cell, k = step
        self._tried.add((*chain.steps, step))
        self._moves[cell] += 1
        self._rests = {key: rest for key, rest in self._rests.items() if key[0] > cell}
        left, candidate = chain.left[cell], self._pools[cell][k]
        found = self._move(chain.state, step, left)
        if found is None:
            self._learned[chain.last, step] = None
            return None
        state, seen, margin = found
        # No better than foreseen, so that what chains cost never falls.
        margin = min(margin, candidate.margin)
        bits = self._held[cell][k] & ~_bits(left & ~seen)
        before = self._learned.get((chain.last, step))
        if before is not None:
            bits, margin = bits & before[0], min(margin, before[1])
        self._learned[chain.last, step] = bits, margin
        self._levels = sorted({*self._levels, _steps(margin)})
        if not np.any(left & seen):
            return None
        after = (*chain.left[:cell], left & ~seen, *chain.left[cell + 1 :])
        driven = chain.driven + self._between(chain.last, step)
        return Planned((*chain.steps, step), state, after, min(chain.margin, margin), driven)


def _cost(chain: Planned[State]) -> Cost:
    """What a chain that ends here costs."""
    return sum(int(np.sum(left)) for left in chain.left), -_steps(chain.margin), chain.driven


def _bits(flags: Flags) -> int:
    """Flags of any shape as the bits of an integer."""
    return int.from_bytes(np.packbits(flags).tobytes())


def _steps(margin: float) -> float:
    """A margin rounded down to the steps that count."""
    return float(np.floor(STEPS * margin + 1e-6)) / STEPS
