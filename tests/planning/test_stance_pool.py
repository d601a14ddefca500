"""Candidates for a cell: their stations and margins by statics of our own, and what the search adds to the grid."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from steeplejack.planning import Rules, Scene, inspection
from steeplejack.planning.cell import AMPLE, Candidate, Cell, Judge, worth
from steeplejack.planning.certificate import hold
from steeplejack.planning.lattice import Lattice, visible_levels
from steeplejack.planning.pool import pools
from steeplejack.planning.stances import find, why_not
from steeplejack.robots.squad import Bay, Squad
from steeplejack.robots.squad.anchorage import Stance, admissible, exits
from steeplejack.worksite import Bridge

EDGES = 40.0, 46.0, 52.0
Site = tuple[Scene, Cell, Lattice]


@pytest.fixture(scope="module")
def sites(bridge: Bridge, squad: Squad, bay: Bay) -> list[Site]:
    scene = Scene.of(bay, squad, Rules(tension=(20.0, 250.0)), np.array(bridge.gravity))
    lattices = [Lattice.over(scene, low, high) for low, high in zip(EDGES[:-1], EDGES[1:], strict=True)]
    return [
        (scene, Cell(lattice.s[0], lattice.s[-1], np.ones((1, len(lattice.s)), bool)), lattice) for lattice in lattices
    ]


@pytest.fixture(scope="module")
def found(sites: list[Site]) -> list[tuple[Candidate, ...]]:
    return pools(sites, lambda _share: None)


def best(pool: tuple[Candidate, ...]) -> Candidate:
    return max(pool, key=worth)


def driving(one: Candidate, other: Candidate) -> float:
    return float(np.sum(np.abs(np.subtract(one.stance.s, other.stance.s))))


def test_stations_held_are_those_with_a_good_place(sites: list[Site], found: list[tuple[Candidate, ...]]) -> None:
    """Station by station on the lattice."""
    scene, _cell, lattice = sites[0]
    levels = lattice.d[visible_levels(scene, lattice, 1)]
    for one in found[0][:2]:
        anchors, pull = scene.anchors(np.array(one.stance.s), np.array(one.stance.clock))
        for j, s in enumerate(lattice.s):
            places = np.column_stack([np.ones(len(levels)), np.full(len(levels), s), levels])
            assert hold(scene, anchors, pull, places).good.any() == one.held[0, j]


def test_margin_is_the_least_over_stations_of_the_best_place(
    sites: list[Site], found: list[tuple[Candidate, ...]], squad: Squad
) -> None:
    """From forces on the bases along their stays, written out."""
    scene, _cell, lattice = sites[0]
    levels = lattice.d[visible_levels(scene, lattice, 1)]
    one = found[0][0]
    anchors, pull = scene.anchors(np.array(one.stance.s), np.array(one.stance.clock))
    points, tangents, _arms = exits(scene.bay, squad, np.array(one.stance.s), np.array(one.stance.clock))
    least = 1.0
    for s in lattice.s[one.held[0]]:
        places = np.column_stack([np.ones(len(levels)), np.full(len(levels), s), levels])
        held = hold(scene, anchors, pull, places)
        margins = []
        for j in np.flatnonzero(held.good):
            ends = scene.bay.place(*places[j]) + scene.attachments @ held.rotation[j].T
            forces = held.tension[j][:, None] * (ends - points) / np.linalg.norm(ends - points, axis=1)[:, None]
            margins.append(1.0 - np.max(np.abs(np.sum(forces * tangents, axis=1))) / squad.base.hold_force)
        least = min(least, max(margins))
    assert one.margin == pytest.approx(min(least, AMPLE), abs=1e-6)  # equilibria start from another guess


def test_search_is_no_worse_than_the_grid(sites: list[Site], found: list[tuple[Candidate, ...]]) -> None:
    for site, pool in zip(sites, found, strict=True):
        first = find(*site)
        assert first is not None
        assert pool[0].stance == first.stance
        assert worth(best(pool)) >= worth(first)


def test_search_finds_margin_that_the_grid_has_not(sites: list[Site], found: list[tuple[Candidate, ...]]) -> None:
    """Where the grid's stance keeps the bare reserve."""
    first = find(*sites[0])
    assert first is not None
    top = best(found[0])
    assert top.held.sum() >= first.held.sum()
    assert top.margin >= min(AMPLE, first.margin + 0.01)


def test_bases_stand_where_they_may(sites: list[Site], found: list[tuple[Candidate, ...]], squad: Squad) -> None:
    scene = sites[0][0]
    for one in [candidate for pool in found for candidate in pool]:
        s = one.stance.s
        assert all(bool(admissible(scene.bay, squad, base, np.array(s[base]))) for base in range(4))
        assert s[3] - s[0] >= squad.base.spacing
        assert s[2] - s[1] >= squad.base.spacing


def test_no_two_stand_alike(found: list[tuple[Candidate, ...]]) -> None:
    for pool in found:
        assert len({tuple(np.round(one.stance.s, 2)) for one in pool}) == len(pool)


def test_a_standing_base_keeps_its_clock_angle(sites: list[Site], found: list[tuple[Candidate, ...]]) -> None:
    scene, cell, lattice = sites[0]
    s, clock = np.array(found[0][0].stance.s), np.array(found[0][0].stance.clock)
    now = Stance((float(s[0]), 1.0, 2.0, 3.0), (0.123, 0.0, 0.0, 0.0))
    turned = Judge.of(scene, cell, lattice, now).clock(s)
    assert turned[0] == 0.123
    np.testing.assert_allclose(turned[1:], clock[1:])


def test_nothing_wanted_has_no_candidates(sites: list[Site]) -> None:
    scene, cell, lattice = sites[0]
    nothing = replace(cell, wanted=np.zeros_like(cell.wanted))
    assert pools([(scene, nothing, lattice)], lambda _share: None) == [()]
    assert find(scene, nothing, lattice) is None


def test_what_stays_uncovered_is_told_limit_by_limit(sites: list[Site]) -> None:
    """Every station lies in a stretch that names what binds there, and neighbours share one where that is the same."""
    scene, cell, lattice = sites[0]
    tight = replace(scene, rules=replace(scene.rules, tension=(20.0, 60.0)))  # too weak for any of it
    told = inspection._reasons(tight, cell, lattice)
    names = np.array([stretch.why for stretch in told])
    assert 1 < len(told) < len(lattice.s)
    assert np.all(names[1:] != names[:-1])
    assert (told[0].from_m, told[-1].to_m) == (cell.low, cell.high)
    assert all(one.to_m == pytest.approx(other.from_m) for one, other in itertools.pairwise(told))
    for j, s in enumerate(lattice.s):
        here = next(stretch.why for stretch in told if stretch.from_m <= s <= stretch.to_m)
        assert [here] == why_not(tight, cell, lattice, 0, [j])
