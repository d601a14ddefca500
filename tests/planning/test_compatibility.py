"""Fits, does not fit and why, or cannot be told and what is missing."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from steeplejack.errors import InfeasibleError, InputError
from steeplejack.planning import Verdict, check, choose_bay, verdicts
from steeplejack.planning.compatibility import holding_force
from steeplejack.robots.squad import Squad
from steeplejack.robots.squad.adhesion import min_grip_force
from steeplejack.worksite import Bridge, Interval, Stay
from steeplejack.worksite.chord import Point

GRAVITY = (0.0, 0.0, -9.81)
STAY = Stay("T1L-M05", "1", "L", "main", 5, (40.0, 14.0, 50.0), (0.0, 12.0, 110.0), diameter=0.110)


def with_palms(squad: Squad, **changes: float) -> Squad:
    return msgspec.structs.replace(squad, gripper=msgspec.structs.replace(squad.gripper, **changes))


def with_diameter(diameter: float | None) -> Stay:
    return replace(STAY, diameter=diameter)


@pytest.mark.parametrize("diameter", [0.090, 0.105, 0.120])
def test_both_ends_of_the_range_fit(diameter: float, squad: Squad) -> None:
    verdict = check(with_diameter(diameter), squad, GRAVITY)
    assert verdict == Verdict(STAY.id, (), ())
    assert verdict.fits is True


@pytest.mark.parametrize("diameter", [math.nextafter(0.090, 0.0), math.nextafter(0.120, 1.0), 0.0895, 0.1204, 0.140])
def test_just_outside_does_not(diameter: float, squad: Squad) -> None:
    verdict = check(with_diameter(diameter), squad, GRAVITY)
    assert verdict.fits is False
    assert "outside 90-120 mm" in verdict.reasons[0]


def test_the_reason_does_not_contradict_itself(squad: Squad) -> None:
    """120.4 mm must not be printed as 120 mm outside 90-120 mm."""
    assert check(with_diameter(0.1204), squad, GRAVITY).reasons == ("diameter 120.4 mm outside 90-120 mm",)
    assert check(with_diameter(0.140), squad, GRAVITY).reasons == ("diameter 140 mm outside 90-120 mm",)


def test_unknown_diameter_is_undecided(squad: Squad) -> None:
    verdict = check(with_diameter(None), squad, GRAVITY)
    assert verdict.fits is None
    assert verdict.unknown == ("diameter",)


def test_weight_and_tension_decide_nothing(squad: Squad) -> None:
    assert STAY.unknown == ("weight", "tension")
    assert check(STAY, squad, GRAVITY).fits is True


def test_obstacle_of_unknown_height_is_listed(squad: Squad) -> None:
    collar = Interval(20.0, 20.6, "obstacle")
    verdict = check(replace(STAY, intervals=(collar,)), squad, GRAVITY)
    assert verdict.fits is None
    assert verdict.unknown == ("height of the obstacle at 20.0-20.6 m",)


@pytest.mark.parametrize("height", [0.004, 0.005, 0.5])
def test_obstacle_of_known_height_leaves_the_rest_of_the_stay(height: float, squad: Squad) -> None:
    assert check(replace(STAY, intervals=(Interval(20.0, 20.6, "obstacle", height),)), squad, GRAVITY).fits is True


def test_nothing_free_does_not_fit_even_where_data_are_missing(squad: Squad) -> None:
    tube = Interval(0.0, 1e3, "end zone")
    verdict = check(replace(STAY, diameter=None, intervals=(tube,)), squad, GRAVITY)
    assert verdict.fits is False
    assert verdict.reasons == ("no stretch free of end zones and obstacles",)
    assert verdict.unknown == ("diameter",)


def test_low_sleeve_over_the_whole_stay_is_passed(squad: Squad) -> None:
    sleeve = replace(STAY, intervals=(Interval(0.0, 1e3, "obstacle", 0.005),))
    assert check(sleeve, squad, GRAVITY).fits is True
    higher = replace(STAY, intervals=(Interval(0.0, 1e3, "obstacle", math.nextafter(0.005, 1.0)),))
    assert check(higher, squad, GRAVITY).fits is False


def test_inclination_limit_includes_the_vertical(squad: Squad) -> None:
    vertical = replace(STAY, lower=(0.0, 14.0, 50.0), upper=(0.0, 14.0, 110.0))
    assert check(vertical, squad, GRAVITY).fits is True


def test_palms_that_press_too_little_do_not_hold(squad: Squad) -> None:
    """Eq. 17 at the base's rated pull along the stay and its own weight."""
    needed = holding_force(squad, 0.055, STAY.inclination, GRAVITY)
    for force, fits in ((needed * (1.0 + 1e-9), True), (needed * (1.0 - 1e-9), False)):
        verdict = check(STAY, with_palms(squad, force=force), GRAVITY)
        assert verdict.fits is fits
    assert check(STAY, with_palms(squad, force=500.0), GRAVITY).reasons == (
        f"palms press 500 N, a base at its rated pull needs {needed:.0f} N there",
    )


def test_the_machine_holds_its_rated_pull_wherever_it_fits(squad: Squad) -> None:
    """Table IV: 25 kg on stays of 90-120 mm, up to 90 deg, down to where a palm counts as lost."""
    low, high = squad.base.stay_diameter
    needed = [
        holding_force(squad, radius, inclination, GRAVITY)
        for radius in np.linspace(0.5 * low, 0.5 * high, 7)
        for inclination in np.linspace(0.0, squad.base.max_inclination, 91)
    ]
    assert max(needed) < 0.87 * squad.gripper.force < 1.05 * max(needed)


def test_holding_force_of_a_vertical_stay_carries_34_kg(squad: Squad) -> None:
    """The full form of squad.md: 25 kg beyond the base's own 9 kg."""
    gripper = squad.gripper
    whole = min_grip_force(34.0 * 9.81, 0.05, 0.5 * math.pi, gripper.palm_length, "+").min_force
    assert holding_force(squad, 0.05, 0.5 * math.pi, GRAVITY) == pytest.approx(whole, rel=1e-12)


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -1.62), (0.0, 0.0, -9.83), (3.0, 0.0, -24.0)])
def test_a_base_weighs_what_the_worksites_gravity_makes_it(gravity: Point, squad: Squad) -> None:
    """The rated pull is a force of Table IV and stays; the base's own weight is linear in gravity."""
    none = holding_force(squad, 0.05, STAY.inclination, (0.0, 0.0, 0.0))
    usual = holding_force(squad, 0.05, STAY.inclination, GRAVITY)
    there = holding_force(squad, 0.05, STAY.inclination, gravity)
    assert there - none == pytest.approx((usual - none) * math.hypot(*gravity) / 9.81, rel=1e-12)


def test_a_bridge_is_judged_and_a_bay_chosen_by_its_own_gravity(bridge: Bridge, squad: Squad) -> None:
    heavy = replace(bridge, gravity=(0.0, 0.0, -40.0))
    assert all(verdict.fits for verdict in verdicts(bridge, squad))
    assert all("palms press" in verdict.reasons[0] for verdict in verdicts(heavy, squad))
    with pytest.raises(InfeasibleError, match="palms press"):
        choose_bay(heavy, squad, None, None, False)


def test_palms_that_do_not_close_around_the_stay_are_bad_input(squad: Squad) -> None:
    with pytest.raises(InputError, match="palm length: 0.03 m"):
        check(STAY, with_palms(squad, palm_length=0.03), GRAVITY)
    assert check(with_diameter(0.2), with_palms(squad, palm_length=0.03), GRAVITY).fits is False


def test_every_reason_is_given(squad: Squad) -> None:
    verdict = check(replace(STAY, diameter=0.2, intervals=(Interval(0.0, 1e3, "end zone"),)), squad, GRAVITY)
    assert len(verdict.reasons) == 2
