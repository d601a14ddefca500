"""What is inspected when the user leaves it open, and what cannot be asked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from steeplejack.errors import InfeasibleError, InputError
from steeplejack.planning import (
    Request,
    Rules,
    Scene,
    asked_stretch,
    choose_bay,
    choose_stretch,
    plan,
    request,
    verdicts,
)
from steeplejack.planning.inspection import held_fraction
from steeplejack.robots.squad import Bay, Squad
from steeplejack.runtime.recorder import StayRecord
from steeplejack.worksite import Bridge, Interval, load_worksite

STRAIGHT = "unknown, so stays without it are straight chords"
AS_ASKED = "shape: straight chords, as asked for"
RULES = Rules(tension=(20.0, 250.0))


def loaded(name: str) -> Bridge:
    site = load_worksite(name)
    assert isinstance(site, Bridge)
    return site


def altered(bridge: Bridge, **changes: object) -> Bridge:
    """The bridge with some fields of some stays replaced: ``id=dict(field=value)`` or ``every=dict(...)``."""
    every = changes.pop("every", {})
    by_id = {name.replace("_", "-"): change for name, change in changes.items()}
    stays = [replace(stay, **every, **by_id.get(stay.id, {})) for stay in bridge.stays]  # pyright: ignore
    return replace(bridge, stays=tuple(stays))


def test_usual_bay_without_options(bridge: Bridge, squad: Squad) -> None:
    fan, bounds, assumed = choose_bay(bridge, squad, None, None, False)
    assert (fan.id, bounds, assumed) == ("T1L-main", (5, 9), ())


def test_bay_as_asked(bridge: Bridge, squad: Squad) -> None:
    fan, bounds, _ = choose_bay(bridge, squad, "T2R-side", (3, 6), False)
    assert (fan.id, bounds) == ("T2R-side", (3, 6))


def test_a_bay_that_fits_is_found_beside_stays_that_do_not(bridge: Bridge, squad: Squad) -> None:
    thick = altered(bridge, T1L_M07={"diameter": 0.140})
    fan, (first, last), _ = choose_bay(thick, squad, "T1L-main", None, False)
    assert fan.id == "T1L-main"
    assert last - first >= 2
    assert not first <= 7 <= last


def test_sutong_is_infeasible_by_diameter(squad: Squad) -> None:
    with pytest.raises(InfeasibleError) as error:
        choose_bay(loaded("sutong-like"), squad, None, None, True)
    assert error.value.binding == "stay T1L-M05: diameter 142.6 mm outside 90-120 mm"


def test_unknown_diameter_stops_it_unless_accepted(squad: Squad) -> None:
    russky = loaded("russky-like")
    with pytest.raises(
        InputError, match="stay T1L-M05: diameter unknown, weight unknown, tension unknown; .*--accept-unknown"
    ):
        choose_bay(russky, squad, None, None, False)
    _fan, _bounds, assumed = choose_bay(russky, squad, None, None, True)
    assert assumed == ("diameter: the machine's largest, 120 mm", f"tension: {STRAIGHT}", f"weight: {STRAIGHT}")


def test_unknown_obstacle_height_is_not_taken_for_a_diameter(bridge: Bridge, squad: Squad) -> None:
    zones = (Interval(40.0, 40.6, "obstacle"),)
    collar = altered(bridge, T1L_M06={"intervals": zones})
    with pytest.raises(InputError, match="height of the obstacle at 40.0-40.6 m unknown"):
        choose_bay(collar, squad, "T1L-main", (5, 7), False)
    _fan, _bounds, assumed = choose_bay(collar, squad, "T1L-main", (5, 7), True)
    assert assumed == ("height of the obstacle at 40.0-40.6 m: unknown, so no base passes it",)


@pytest.mark.parametrize("name", ["weight", "tension"])
def test_what_shapes_a_stay_stops_it_unless_accepted(bridge: Bridge, squad: Squad, name: str) -> None:
    """Not even one stay is silently taken for its chord."""
    bare = altered(bridge, T1L_M06={name: None})
    with pytest.raises(InputError, match=f"stay T1L-M06: {name} unknown; .*--chord .*--accept-unknown"):
        choose_bay(bare, squad, "T1L-main", (5, 7), False)
    _fan, _bounds, assumed = choose_bay(bare, squad, "T1L-main", (5, 7), True)
    assert assumed == (f"{name}: {STRAIGHT}",)


def test_a_bay_whose_data_are_known_is_found_beside_one_whose_are_not(bridge: Bridge, squad: Squad) -> None:
    _fan, (first, last), assumed = choose_bay(altered(bridge, T1L_M07={"weight": None}), squad, None, None, False)
    assert not first <= 7 <= last
    assert assumed == ()


def test_chords_asked_for_need_no_weight_and_say_so(bridge: Bridge, squad: Squad) -> None:
    bare = altered(bridge, every={"weight": None, "tension": None})
    _fan, _bounds, assumed = choose_bay(bare.as_chords(), squad, "T1L-main", (5, 7), False)
    assert assumed == (AS_ASKED,)
    with pytest.raises(InputError, match="stay T1L-M05: diameter unknown; the missing data, or --accept-unknown"):
        choose_bay(loaded("russky-like").as_chords(), squad, None, None, False)
    _fan, _bounds, both = choose_bay(loaded("russky-like").as_chords(), squad, None, None, True)
    assert both == ("diameter: the machine's largest, 120 mm", AS_ASKED)


def test_plan_run_and_report_use_the_chords_asked_for(bridge: Bridge, squad: Squad) -> None:
    """The catenary of these stays sags by decimetres; nothing of it is left in the plan or in what the log keeps."""
    fan, bounds, assumed = choose_bay(bridge.as_chords(), squad, "T1L-main", (5, 7), False)
    bay = Bay.of(fan, *bounds, "under", squad)
    scene = Scene.of(bay, squad, RULES, np.array(bridge.gravity))
    asked = Request(bridge.name, squad.name, fan.id, bounds, 30.0, 33.0, "under", 0.0, RULES.tension)
    mission = plan(scene, asked, assumed, lambda _done: None)
    assert mission.assumed == (AS_ASKED,)
    for curves in (bay.stays, tuple(StayRecord.of(stay).stay() for stay in bay.stays)):
        for stay, hanging in zip(curves, bridge.fan("T1L-main").between(*bounds), strict=True):
            assert stay.length == pytest.approx(np.linalg.norm(np.subtract(stay.upper, stay.lower)))
            assert np.linalg.norm(stay.position(0.5 * stay.length) - hanging.position(0.5 * hanging.length)) > 0.05
    for point in (point for leg in mission.legs for point in leg.waypoints):
        np.testing.assert_allclose(point.position_m, bay.place(*point.place), atol=1e-9)


def test_fans_without_the_stays_asked_for_are_passed_over(bridge: Bridge, squad: Squad) -> None:
    """Regression of issue 2: the first fan decided for all."""
    first = next(iter(bridge.fans))
    short = replace(bridge, stays=tuple(s for s in bridge.stays if s.fan != first or s.index < 5))
    fan, bounds, _ = choose_bay(short, squad, None, (5, 9), False)
    assert (fan.id, bounds) == (list(bridge.fans)[1], (5, 9))


def test_fans_without_a_stay_between_are_passed_over(bridge: Bridge, squad: Squad) -> None:
    first = next(iter(bridge.fans))
    sparse = replace(bridge, stays=tuple(s for s in bridge.stays if s.fan != first or s.index in (5, 9)))
    assert choose_bay(sparse, squad, None, (5, 9), False)[0].id == list(bridge.fans)[1]


def test_stays_that_no_fan_has_are_answered_by_those_there_are(bridge: Bridge, squad: Squad) -> None:
    with pytest.raises(InputError) as error:
        choose_bay(bridge, squad, None, (5, 99), False)
    assert error.value.where == "--stays"
    assert "no fan of ecs620-like has both 5 and 99" in error.value.what
    for fan in bridge.fans.values():
        assert f"{fan.id} {fan.stays[0].index}-{fan.stays[-1].index}" in error.value.valid


@pytest.mark.parametrize(
    ("fan", "stays", "words"),
    [
        ("T9L-main", None, "no fan T9L-main"),
        ("T1L-main", (5, 6), "no interior stay"),
        ("T1L-main", (5, 99), "no stays 5:99"),
        ("T1L-main", (9, 5), "no stays 9:5"),
        (None, (5, 6), "no interior stay"),
    ],
)
def test_bays_that_do_not_exist(
    bridge: Bridge, squad: Squad, fan: str | None, stays: tuple[int, int] | None, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        choose_bay(bridge, squad, fan, stays, False)


def test_numbers_far_apart_with_nothing_between_have_no_interior(bridge: Bridge, squad: Squad) -> None:
    few = replace(bridge, stays=tuple(s for s in bridge.stays if s.index in (5, 9)))
    with pytest.raises(InputError, match="no interior stay"):
        choose_bay(few, squad, "T1L-main", (5, 9), False)
    with pytest.raises(InfeasibleError, match="no fan has three stays in a row"):
        choose_bay(few, squad, None, None, False)


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (-1.0, 40.0, "--from-m"),
        (1e4, None, "--from-m"),
        (30.0, 1e4, "--to-m"),
        (40.0, 30.0, "at least 1 m"),
        (40.0, 40.5, "at least 1 m"),
        (float("nan"), 40.0, "--from-m"),
        (30.0, float("nan"), "--to-m"),
    ],
)
def test_stretches_outside_the_stays(bay: Bay, low: float, high: float | None, words: str) -> None:
    with pytest.raises(InputError, match=words):
        asked_stretch(bay, low, high)


def test_stretch_as_asked_and_half_asked(bridge: Bridge, squad: Squad) -> None:
    bay = Bay.of(bridge.fan("T1L-main"), 5, 9, "under", squad)  # three interior stays
    assert asked_stretch(bay, 30.0, 45.0) == (30.0, 45.0)
    assert asked_stretch(bay, 30.0, None) == pytest.approx((30.0, 30.0 + 100.0 / 3.0))
    assert asked_stretch(bay, None, 60.0) == pytest.approx((60.0 - 100.0 / 3.0, 60.0))
    assert asked_stretch(bay, None, 20.0) == (0.0, 20.0)
    assert asked_stretch(bay, None, None) is None
    end = bay.reach
    assert asked_stretch(bay, end - 5.0, None) == (end - 5.0, end)


@pytest.mark.parametrize(
    ("shares", "begins"), [({}, 20.0), ({20.0: 0.9}, 30.0), (dict.fromkeys(request.STARTS, 0.5) | {50.0: 0.8}, 50.0)]
)
def test_stretch_left_open_is_about_100_m_where_most_is_held(
    bridge: Bridge, squad: Squad, monkeypatch: pytest.MonkeyPatch, shares: dict[float, float], begins: float
) -> None:
    """The first stretch held all along, else the one held most; what a stretch holds is told here, not searched."""
    bay = Bay.of(bridge.fan("T1L-main"), 5, 9, "under", squad)
    monkeypatch.setattr(request, "held_fraction", lambda _scene, low, _high: shares.get(low, 1.0))
    low, high = choose_stretch(bridge, bay, squad, RULES)
    assert low == begins
    assert (high - low) * len(bay.interior) == pytest.approx(100.0)
    assert high <= bay.reach


def test_held_fraction_of_a_short_stretch(bridge: Bridge, squad: Squad, bay: Bay) -> None:
    scene = Scene.of(bay, squad, RULES, np.array(bridge.gravity))
    assert held_fraction(scene, 30.0, 33.0) == 1.0
    assert held_fraction(scene, bay.reach - 2.0, bay.reach) == 0.0  # an end zone holds nothing to inspect


def test_verdicts_cover_every_stay_once(bridge: Bridge, squad: Squad) -> None:
    found = verdicts(bridge, squad)
    assert sorted(verdict.stay for verdict in found) == sorted(stay.id for stay in bridge.stays)


def test_upper_face_names_the_limit_that_binds(bridge: Bridge, squad: Squad) -> None:
    """On the upper face gravity presses the platform into the stays."""
    bay = Bay.of(bridge.fan("T1L-main"), 5, 7, "upper", squad)
    scene = Scene.of(bay, squad, RULES, np.array(bridge.gravity))
    asked = Request(bridge.name, squad.name, "T1L-main", (5, 7), 30.0, 33.0, "upper", 0.0, RULES.tension)
    with pytest.raises(InfeasibleError) as error:
        plan(scene, asked, (), lambda _done: None)
    assert "(5, 7)" in error.value.what
    assert "cable" in error.value.binding or "base" in error.value.binding
