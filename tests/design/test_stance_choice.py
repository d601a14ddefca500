"""The best stance at a place: against brute force, what more freedom gives, what less driving costs."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from steeplejack.design.stances import Ground, Objective, Statics, choose_stance, on_bay, straight
from steeplejack.errors import InputError
from steeplejack.robots.squad import Bay, load_squad
from steeplejack.worksite import Bridge, load_worksite

pytestmark = pytest.mark.long

UNIT = np.array([np.cos(0.55), np.sin(0.55)])
ACROSS = np.array([UNIT[1], -UNIT[0]])
PLACE = 40.0 * UNIT + 6.0 * ACROSS
WEIGHT = np.array([0.0, -30.0 * 9.81])
NOW = np.array([30.0, 33.0, 55.0, 52.0])
ARMS = np.array([[-0.095, -0.095], [0.095, -0.095], [0.095, 0.095], [-0.095, 0.095]])
TURN = np.column_stack([ACROSS, UNIT])


def ground(hold: float = 245.25) -> Ground:
    """Two straight stays 15 m apart at 31.5 deg; bases 1 and 4 on the one, 2 and 3 on the other."""
    lower = np.array([np.zeros(2), 15.0 * ACROSS, 15.0 * ACROSS, np.zeros(2)])
    return straight(lower, lower + 90.0 * UNIT, (10.0, 400.0), hold, spacing=0.6)


def test_no_worse_than_a_fine_grid() -> None:
    """Two movable bases, all places a quarter of a metre apart: the search finds at least the grid's best."""
    answer = choose_stance(ground(), PLACE, WEIGHT, NOW, 10.0, Statics.POINT, movable=(2, 3))
    fixed = [
        choose_stance(ground(), PLACE, WEIGHT, [30.0, 33.0, a, b], 0.0, Statics.POINT).worth
        for a, b in itertools.product(np.linspace(45.0, 65.0, 21), np.linspace(42.0, 62.0, 21))
    ]
    assert answer.held
    assert answer.worth >= max(fixed) - 1e-9
    assert answer.worth <= max(fixed) + 0.05
    np.testing.assert_array_equal(answer.s[:2], NOW[:2])


@pytest.mark.parametrize("objective", Objective)
def test_more_freedom_is_never_worse(objective: Objective) -> None:
    """Every further movable base and every wider window adds stances and takes none away."""
    loads = np.column_stack([np.tile(WEIGHT, (2, 1)), [4.0, -4.0]])
    worths = [
        choose_stance(ground(), PLACE, loads, NOW, 8.0, Statics.BODY, objective, ARMS @ TURN.T, movable).worth
        for movable in ((), (2,), (2, 3), (0, 1, 2, 3))
    ]
    assert all(more >= less - 1e-3 * abs(worths[-1]) for less, more in itertools.pairwise(worths))
    assert worths[-1] > worths[0]


def test_a_harder_wrench_set_is_never_better() -> None:
    """Gravity; gravity with a wind box; and with a tool's force as well."""
    wind = WEIGHT + np.array([[x, y] for x in (-15.0, 15.0) for y in (-15.0, 15.0)])
    tool = np.concatenate([wind, wind + 30.0 * ACROSS])
    worths = [choose_stance(ground(), PLACE, load, NOW, 15.0, Statics.POINT).worth for load in (WEIGHT, wind, tool)]
    assert worths[0] > worths[1] > worths[2] > 0.0


def test_less_driving_for_a_known_price() -> None:
    best = choose_stance(ground(), PLACE, WEIGHT, NOW, 15.0, Statics.POINT)
    near = choose_stance(ground(), PLACE, WEIGHT, NOW, 15.0, Statics.POINT, slack=0.05)
    assert near.driving < best.driving
    assert near.worth >= near.best - 0.05
    assert near.best == pytest.approx(best.best)
    stays = choose_stance(ground(), PLACE, WEIGHT, best.s, 15.0, Statics.POINT, slack=0.05)
    assert stays.driving < 1e-9


def test_what_nothing_holds_is_said() -> None:
    heavy = choose_stance(ground(), PLACE, 20.0 * WEIGHT, NOW, 15.0, Statics.POINT)
    assert not heavy.held
    assert heavy.worth == -np.inf
    weak = choose_stance(ground(20.0), PLACE, WEIGHT, NOW, 15.0, Statics.POINT)
    assert not weak.held
    assert weak.worth < 0.0
    nowhere = choose_stance(ground(), PLACE, WEIGHT, [30.0, 33.0, 33.0, 30.0], 0.0, Statics.POINT)
    assert not nowhere.held
    assert np.isnan(nowhere.s).all()


@pytest.mark.parametrize(
    "wrong",
    [
        {"position": [1.0, np.nan]},
        {"now": NOW[:3]},
        {"movable": (4,)},
        {"within": -1.0},
        {"loads": np.zeros((0, 2))},
        {"slack": np.inf},
    ],
    ids=str,
)
def test_bad_questions_are_refused(wrong: dict[str, Any]) -> None:
    asked: dict[str, Any] = {
        "position": PLACE,
        "loads": WEIGHT,
        "now": NOW,
        "within": 5.0,
        "statics": Statics.POINT,
    } | wrong
    with pytest.raises(InputError):
        choose_stance(ground(), **asked)
    with pytest.raises(InputError):
        straight(np.zeros((4, 2)), np.zeros((4, 2)), (10.0, 400.0), 245.25)
    with pytest.raises(InputError):
        straight(np.zeros((4, 2)), np.ones((4, 2)), (400.0, 10.0), 245.25)


def test_in_space_on_a_sagging_bay() -> None:
    """Tensions and slip of the answer recomputed from the stays themselves."""
    bridge, squad = load_worksite("ecs620-like"), load_squad()
    assert isinstance(bridge, Bridge)
    bay = Bay.of(bridge.fan("T1L-main"), 5, 9, "under", squad)
    place = bay.place(2.0, 60.0, 0.7)
    floor, weight = on_bay(bay, squad, (10.0, 400.0)), np.array([0.0, 0.0, -30.0 * 9.81])
    answer = choose_stance(floor, place, weight, [55.0, 55.0, 75.0, 75.0], 20.0, Statics.SPACE, arms=np.zeros((4, 3)))
    assert answer.held
    assert np.all(np.abs(answer.s - [55.0, 55.0, 75.0, 75.0]) <= 20.0 + 1e-9)
    exits, tangents = [], []
    for base, k in enumerate(bay.carriers):
        axis, tangent = bay.stays[k].position(answer.s[base]), bay.stays[k].tangent(answer.s[base])
        out = place - axis - ((place - axis) @ tangent) * tangent
        exits.append(axis + squad.base.exit_offset * out / np.linalg.norm(out))
        tangents.append(tangent)
    pulls = np.array(exits) - place
    pulls /= np.linalg.norm(pulls, axis=-1, keepdims=True)
    share = np.abs(np.sum(pulls * np.array(tangents), axis=-1))
    null = np.linalg.svd(pulls.T)[2][-1]
    some = np.linalg.lstsq(pulls.T, -weight, rcond=None)[0]
    line = some + np.linspace(-600.0, 600.0, 120_001)[:, None] * null
    good = np.all((line >= 10.0) & (line <= 400.0), axis=-1)
    margin = np.max(np.min(1.0 - line[good] * share / squad.base.hold_force, axis=-1))
    assert answer.worth == pytest.approx(margin, abs=2e-4)
