"""The lazily planned chain of stances against every chain there is."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from steeplejack.planning.cell import Candidate
from steeplejack.planning.chain import Limits, Planned, Step, best_chain
from steeplejack.robots.squad.anchorage import Stance

STATIONS = 7
FREE = Limits(least_gain=1, per_cell=2, moves=10_000)
Outcome = tuple[np.ndarray, float]  # stations that can be seen, margin
Problem = tuple[list[list[Candidate]], list[np.ndarray], dict[tuple[Step | None, Step], Outcome | None]]


def problem(rng: np.random.Generator, cells: int = 3, each: int = 3, surprise: float = 0.3) -> Problem:
    """Pools, stations wanted and what every move truly comes to: at times nothing, at times less than foreseen."""
    pools = [
        [
            Candidate(
                Stance(tuple(rng.uniform(0.0, 30.0, 4) + 10.0 * cell), (0.0,) * 4),
                rng.random(STATIONS) < 0.7,
                0.1 + 0.01 * int(rng.integers(0, 8)),
            )
            for _ in range(each)
        ]
        for cell in range(cells)
    ]
    wanted = [rng.random(STATIONS) < 0.9 for _ in pools]
    truth: dict[tuple[Step | None, Step], Outcome | None] = {}
    steps = [(cell, k) for cell, pool in enumerate(pools) for k in range(len(pool))]
    for then in steps:
        foreseen = pools[then[0]][then[1]]
        for now in [None, *steps]:
            luck = rng.random()
            seen = foreseen.held & (rng.random(STATIONS) < 0.8) if luck < 2.0 * surprise else foreseen.held
            margin = (
                min(foreseen.margin, 0.05 + 0.01 * int(rng.integers(0, 12))) if luck < surprise else foreseen.margin
            )
            truth[now, then] = None if luck < 0.5 * surprise else (seen, margin)
    return pools, wanted, truth


def solved(given: Problem, limits: Limits = FREE) -> tuple[Planned[Step | None], list[tuple[Step | None, Step]]]:
    """The chain found, and the moves planned for it in order; the state is the stance itself."""
    pools, wanted, truth = given
    asked: list[tuple[Step | None, Step]] = []

    def move(state: Step | None, step: Step, left: np.ndarray) -> tuple[Step | None, np.ndarray, float] | None:
        asked.append((state, step))
        outcome = truth[state, step]
        return None if outcome is None else (step, left & outcome[0], outcome[1])

    return best_chain(pools, wanted, None, move, limits), asked


def cost(chain: Planned[Step | None]) -> tuple[int, float, float]:
    return sum(int(left.sum()) for left in chain.left), -round(chain.margin, 6), round(chain.driven, 6)


def chains(given: Problem) -> Iterator[tuple[int, float, float]]:
    """Costs of all chains: at most two stances of a cell, every one adding something."""
    pools, wanted, truth = given
    whole = sum(int(flags.sum()) for flags in wanted)

    def onward(
        last: Step | None, cell: int, used: tuple[int, ...], left: np.ndarray, seen: int, margin: float, driven: float
    ) -> Iterator[tuple[int, float, float]]:
        yield whole - seen, -round(margin, 6), round(driven, 6)
        for c in range(cell, len(pools)):
            mine, rest = (used, left) if c == cell else ((), wanted[c])
            for k, candidate in enumerate(pools[c]):
                outcome = truth[last, (c, k)]
                if k in mine or len(mine) == FREE.per_cell or outcome is None or not (rest & outcome[0]).any():
                    continue
                way = 0.0
                if last is not None:
                    way = float(np.sum(np.abs(np.subtract(candidate.stance.s, pools[last[0]][last[1]].stance.s))))
                gained = int((rest & outcome[0]).sum())
                after = rest & ~outcome[0]
                yield from onward((c, k), c, (*mine, k), after, seen + gained, min(margin, outcome[1]), driven + way)

    return onward(None, 0, (), wanted[0], 0, 1.0, 0.0)


@pytest.mark.parametrize("seed", range(40))
def test_finds_the_best_of_all_chains(seed: int) -> None:
    given = problem(np.random.default_rng(seed))
    found, _asked = solved(given)
    assert cost(found) == min(chains(given))


def test_what_is_foreseen_is_planned_once(rng: np.random.Generator) -> None:
    """Where every move does what it should, only those of the best chain are planned."""
    for _ in range(10):
        found, asked = solved(problem(rng, cells=5, surprise=0.0))
        assert [step for _state, step in asked] == list(found.steps)


def test_moves_to_a_cell_are_limited(rng: np.random.Generator) -> None:
    """Those of the search; where they run out, the chain that takes what holds most bounds the outcome."""
    for _ in range(20):
        given = problem(rng, surprise=0.6)
        found, asked = solved(given, Limits(1, 2, 2))
        greedy, alone = solved(given, Limits(1, 2, 0))
        cells, of_greedy = ([step[0] for _state, step in each] for each in (asked, alone))
        assert all(cells.count(cell) <= 2 + of_greedy.count(cell) for cell in range(3))
        assert min(chains(given)) <= cost(found) <= cost(greedy)


def test_same_chain_every_time() -> None:
    first, second = (solved(problem(np.random.default_rng(4))) for _ in range(2))
    assert first[0].steps == second[0].steps
    assert first[1] == second[1]


def test_a_stance_that_adds_too_little_is_not_taken(rng: np.random.Generator) -> None:
    pools, wanted, truth = problem(rng, cells=1, surprise=0.0)
    found, _asked = solved((pools, wanted, truth), Limits(3, 3, 100))
    left = wanted[0]
    for cell, k in found.steps:
        gained = left & pools[cell][k].held
        assert gained.sum() >= min(3, left.sum())
        left = left & ~gained


def test_empty_pools_leave_everything(rng: np.random.Generator) -> None:
    _pools, wanted, _truth = problem(rng)
    found, asked = solved(([[] for _ in wanted], wanted, {}))
    assert found.steps == ()
    assert asked == []
    assert cost(found)[0] == sum(int(flags.sum()) for flags in wanted)
