"""The lazily planned chain of stances against every chain there is."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np
import pytest

from steeplejack.planning.cell import Candidate
from steeplejack.planning.chain import Planned, best_chain
from steeplejack.planning.outlook import Limits, Outlook, Step, as_bits
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


def solved(
    given: Problem, limits: Limits = FREE, outcome_of: Callable[[tuple[Step, ...]], Outcome | None] | None = None
) -> tuple[Planned[tuple[Step, ...]], list[tuple[Step, ...]]]:
    """The chain found, and the chains whose last move was planned for it in order; the state is the chain itself."""
    pools, wanted, _truth = given
    outcome_of = outcome_of or by_edge(given)
    asked: list[tuple[Step, ...]] = []

    def move(
        state: tuple[Step, ...], step: Step, left: np.ndarray
    ) -> tuple[tuple[Step, ...], np.ndarray, float] | None:
        asked.append((*state, step))
        outcome = outcome_of((*state, step))
        return None if outcome is None else ((*state, step), left & outcome[0], outcome[1])

    return best_chain(pools, wanted, (), move, limits), asked


def cost(chain: Planned[tuple[Step, ...]]) -> tuple[int, float, float]:
    return sum(int(left.sum()) for left in chain.left), -round(chain.margin, 6), round(chain.driven, 6)


def chains(
    given: Problem, outcome_of: Callable[[tuple[Step, ...]], Outcome | None], least: int = 1
) -> Iterator[tuple[int, float, float]]:
    """Costs of all chains: at most two stances of a cell, every one adding at least that much, or all that is left."""
    pools, wanted, _truth = given
    whole = sum(int(flags.sum()) for flags in wanted)

    def onward(
        steps: tuple[Step, ...],
        cell: int,
        used: tuple[int, ...],
        left: np.ndarray,
        seen: int,
        margin: float,
        far: float,
    ) -> Iterator[tuple[int, float, float]]:
        yield whole - seen, -round(margin, 6), round(far, 6)
        for c in range(cell, len(pools)):
            mine, rest = (used, left) if c == cell else ((), wanted[c])
            for k, candidate in enumerate(pools[c]):
                if k in mine or len(mine) == FREE.per_cell:
                    continue
                outcome = outcome_of((*steps, (c, k)))
                if outcome is None or (rest & outcome[0]).sum() < max(1, min(least, rest.sum())):
                    continue
                way = 0.0
                if steps:
                    before = pools[steps[-1][0]][steps[-1][1]]
                    way = float(np.sum(np.abs(np.subtract(candidate.stance.s, before.stance.s))))
                gained = int((rest & outcome[0]).sum())
                after = rest & ~outcome[0]
                margin_then = min(margin, outcome[1])
                yield from onward((*steps, (c, k)), c, (*mine, k), after, seen + gained, margin_then, far + way)

    return onward((), 0, (), wanted[0], 0, 1.0, 0.0)


def by_edge(given: Problem) -> Callable[[tuple[Step, ...]], Outcome | None]:
    """What the last move of a chain comes to where only its two stances count."""
    truth = given[2]
    return lambda steps: truth[steps[-2] if len(steps) > 1 else None, steps[-1]]


def by_prefix(given: Problem, seed: int) -> Callable[[tuple[Step, ...]], Outcome | None]:
    """What it comes to where all that came before does: at times nothing, at times less than foreseen."""
    pools = given[0]

    def outcome(steps: tuple[Step, ...]) -> Outcome | None:
        rng = np.random.default_rng([seed, *(number for step in steps for number in step)])
        foreseen = pools[steps[-1][0]][steps[-1][1]]
        if rng.random() < 0.15:
            return None
        seen = foreseen.held & (rng.random(STATIONS) < 0.9)
        return seen, min(foreseen.margin, 0.05 + 0.01 * int(rng.integers(0, 12)))

    return outcome


@pytest.mark.parametrize("seed", [*range(40), 88, 137])
def test_finds_the_best_of_all_chains(seed: int) -> None:
    """At seeds 88 and 137 a stance of the best adds nothing unless one before it sees less than foreseen."""
    given = problem(np.random.default_rng(seed))
    found, _asked = solved(given)
    assert cost(found) == min(chains(given, by_edge(given)))


@pytest.mark.parametrize("seed", [*range(30), 47, 89])
def test_finds_the_best_of_stances_that_add_enough(seed: int) -> None:
    """Or a better one, whose stances were to add enough and did not."""
    given = problem(np.random.default_rng(seed))
    found, _asked = solved(given, Limits(2, 2, 10_000))
    truth = by_edge(given)
    assert min(chains(given, truth)) <= cost(found) <= min(chains(given, truth, least=2))


def test_what_is_foreseen_is_planned_once(rng: np.random.Generator) -> None:
    """Where every move does what it should, only those of the best chain are planned."""
    for _ in range(10):
        found, asked = solved(problem(rng, cells=5, surprise=0.0))
        assert asked == [found.steps[: n + 1] for n in range(len(found.steps))]


@pytest.mark.parametrize("prefixes", [False, True])
def test_moves_to_a_cell_are_limited(prefixes: bool) -> None:
    """From whatever stance and start; where they run out, the chain that takes what holds most adds its own."""
    for seed in range(5 if prefixes else 10):
        given = problem(np.random.default_rng(seed), surprise=0.6)
        truth = by_prefix(given, seed) if prefixes else by_edge(given)
        found, asked = solved(given, Limits(1, 2, 2), truth)
        greedy, alone = solved(given, Limits(1, 2, 0), truth)
        cells, of_greedy = ([steps[-1][0] for steps in each] for each in (asked, alone))
        assert all(cells.count(cell) <= 2 + of_greedy.count(cell) for cell in range(3))
        assert min(chains(given, truth)) <= cost(found) <= cost(greedy)
        assert len(set(asked)) == len(asked)


def test_outcomes_that_depend_on_what_came_before() -> None:
    """There the answer is a chain as it was planned, and mostly, not always, one that misses least of all there are."""
    least_missed = 0
    for seed in range(12):
        given = problem(np.random.default_rng(seed))
        truth = by_prefix(given, seed)
        found, _asked = solved(given, FREE, truth)
        outcomes = [truth(found.steps[: n + 1]) for n in range(len(found.steps))]
        left = [wanted.copy() for wanted in given[1]]
        for step, outcome in zip(found.steps, outcomes, strict=True):
            assert outcome is not None
            left[step[0]] &= ~outcome[0]
        assert cost(found)[0] == sum(int(each.sum()) for each in left)
        assert found.margin == pytest.approx(min(outcome[1] for outcome in outcomes if outcome))
        least = min(chains(given, truth))
        assert least <= cost(found)
        assert cost(found)[0] <= least[0] + 1
        least_missed += cost(found)[0] == least[0]
    assert least_missed >= 9


def test_same_chain_every_time() -> None:
    first, second = (solved(problem(np.random.default_rng(4))) for _ in range(2))
    assert first[0].steps == second[0].steps
    assert first[1] == second[1]


def candidate(stations: Iterable[int], margin: float = 0.2) -> Candidate:
    """One that holds these stations of a cell."""
    return Candidate(Stance((0.0,) * 4, (0.0,) * 4), np.isin(np.arange(STATIONS), list(stations)), margin)


def test_a_stance_that_adds_too_little_is_not_taken() -> None:
    """Two stations are too few where three are left, and enough where they are all that is left."""
    most, rest = candidate(range(4)), candidate(range(2, 6))
    for wanted, taken in ((range(7), 1), (range(6), 2)):
        flags = np.isin(np.arange(STATIONS), list(wanted))
        truth = {(now, (0, k)): (one.held, 0.2) for now in (None, (0, 0), (0, 1)) for k, one in enumerate((most, rest))}
        found, _asked = solved(([[most, rest]], [flags], truth), Limits(3, 3, 100))
        assert len(found.steps) == taken


def test_where_moves_run_out_what_holds_most_of_what_can_be_reached_is_taken() -> None:
    """The one move that may be planned comes to nothing."""
    whole, most, some = candidate(range(7)), candidate(range(6)), candidate(range(5))
    truth = {(None, (0, 0)): None, (None, (0, 1)): (some.held, 0.2), (None, (0, 2)): (most.held, 0.2)}
    found, asked = solved(([[whole, some, most]], [np.ones(STATIONS, bool)], truth), Limits(2, 1, 1))
    assert asked == [((0, 0),), ((0, 2),)]
    assert cost(found) == (1, -0.2, 0.0)


def test_costs_rise_with_what_is_learned() -> None:
    """Less is seen, then with less margin, then nothing."""
    wanted = np.ones(STATIONS, bool)
    outlook = Outlook([[candidate(range(7))]], [wanted], FREE)
    node, some = (0, as_bits(wanted), None, 0), as_bits(np.arange(STATIONS) < 4)
    assert outlook.at_best(node, 1.0) == (0, 0.2, 0.0)
    for outcome, best in (((some, 0.2), (3, 0.2, 0.0)), ((some, 0.1), (3, 0.1, 0.0)), (None, (7, 1.0, 0.0))):
        outlook.learn(None, (0, 0), outcome)
        assert outlook.at_best(node, 1.0) == best


def test_empty_pools_leave_everything(rng: np.random.Generator) -> None:
    _pools, wanted, _truth = problem(rng)
    found, asked = solved(([[] for _ in wanted], wanted, {}))
    assert found.steps == ()
    assert asked == []
    assert cost(found)[0] == sum(int(flags.sum()) for flags in wanted)
