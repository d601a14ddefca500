"""What a stay knows of itself: clock, intervals, gaps in the data, its chord."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from random_schedules import stays

from steeplejack.worksite import Interval, Stay
from steeplejack.worksite.stay import with_end_zones

STAY = Stay(
    id="T1L-M09",
    tower="1",
    plane="L",
    side="main",
    index=9,
    lower=(-180.0, 14.0, 50.0),
    upper=(-310.0, 4.0, 144.0),
    diameter=0.12,
    weight=588.6,
    tension=3.576e6,
)


@given(stays())
@settings(max_examples=100, deadline=None)
def test_clock_frame_is_orthonormal_and_right_handed(stay: Stay):
    s = np.linspace(0.0, stay.length, 5)
    tangent, (twelve, three) = stay.tangent(s), stay.clock_frame(s)
    frame = np.stack([twelve, three, tangent], axis=-2)
    np.testing.assert_allclose(frame @ frame.swapaxes(-1, -2), np.broadcast_to(np.eye(3), frame.shape), atol=1e-8)
    np.testing.assert_allclose(np.cross(tangent, twelve), three, atol=1e-8)


def test_twelve_is_the_highest_point_of_the_circumference():
    twelve, three = STAY.clock_frame(60.0)
    angles = np.linspace(-math.pi, math.pi, 3601)[:, None]
    heights = (np.cos(angles) * twelve + np.sin(angles) * three)[:, 2]
    assert abs(angles[np.argmax(heights), 0]) < 2e-3


def test_three_is_on_the_right_looking_up():
    """A stay that rises towards +x, seen from its foot, has -y on its right."""
    stay = replace(STAY, lower=(0.0, 0.0, 0.0), upper=(80.0, 0.0, 60.0))
    np.testing.assert_allclose(stay.clock_frame(10.0)[1], [0.0, -1.0, 0.0], atol=1e-12)


def test_clock_of_a_vertical_stay_is_defined():
    twelve, three = replace(STAY, lower=(1.0, 2.0, 0.0), upper=(1.0, 2.0, 90.0)).clock_frame(10.0)
    np.testing.assert_allclose(twelve, [-1.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(three, [0.0, -1.0, 0.0], atol=1e-12)


def test_plain_numbers():
    assert STAY.fan == "T1L-main"
    assert STAY.radius == 0.06
    assert STAY.inclination == pytest.approx(math.atan2(94.0, math.hypot(130.0, 10.0)))
    assert STAY.length > math.dist(STAY.lower, STAY.upper)


@pytest.mark.parametrize("missing", ["weight", "tension"])
def test_without_weight_or_tension_it_is_the_chord(missing):
    stay = replace(STAY, **{missing: None})
    assert stay.unknown == (missing,)
    assert stay.sag == 0.0
    assert stay.length == pytest.approx(math.dist(stay.lower, stay.upper), abs=1e-12)


def test_unknown_lists_everything_missing():
    assert STAY.unknown == ()
    bare = replace(STAY, diameter=None, weight=None, tension=None)
    assert bare.unknown == ("diameter", "weight", "tension")
    assert bare.radius is None


def test_a_chord_asked_for_misses_neither_weight_nor_tension():
    straight = replace(STAY, weight=None, tension=None).as_chord()
    assert straight.unknown == ()
    assert replace(straight, diameter=None).unknown == ("diameter",)


def test_free_intervals_leave_out_zones_and_obstacles():
    collar = Interval(40.0, 40.5, "obstacle", 0.02, "collar")
    fillet = Interval(60.0, 61.0, "obstacle", 0.004, "coupler of the fillet")
    odd = Interval(80.0, 82.0, "obstacle", None, "something")
    stay = replace(with_end_zones(STAY, 2.5, 3.0, "estimate"), intervals=(odd, collar, fillet))
    stay = with_end_zones(stay, 2.5, 3.0, "estimate")
    end = stay.length - 3.0
    expected = ((2.5, 40.0), (40.5, 60.0), (61.0, 80.0), (82.0, end))
    np.testing.assert_allclose(stay.free_intervals(0.0, 1e3), expected)
    np.testing.assert_allclose(stay.free_intervals(-5.0, 1e3, passable=0.005)[1], (40.5, 80.0))
    assert stay.free_intervals(40.1, 40.4) == ()
    assert stay.free_intervals(39.0, 40.2) == ((39.0, 40.0),)
    assert stay.free_intervals(50.0, 50.0) == ()


def test_overlapping_intervals_count_once():
    blocks = tuple(Interval(a, b, "obstacle") for a, b in ((10.0, 30.0), (12.0, 15.0), (25.0, 40.0)))
    assert replace(STAY, intervals=blocks).free_intervals(0.0, 50.0) == ((0.0, 10.0), (40.0, 50.0))


@given(stays())
@settings(max_examples=50, deadline=None)
def test_end_zones_never_overlap_and_follow_the_chord(stay: Stay):
    zoned = with_end_zones(stay, 2.5, 2.5, "estimate")
    assert all(zone.kind == "end zone" for zone in zoned.intervals)
    lower, upper = zoned.intervals
    assert 0.0 == lower.start < lower.end <= upper.start + 1e-9 < upper.end == zoned.length
    straight = zoned.as_chord()
    assert straight.sag == 0.0
    assert straight.intervals[1].end == pytest.approx(straight.length)
    assert straight.intervals[1].end == pytest.approx(math.dist(stay.lower, stay.upper))


def test_end_zones_replace_those_before():
    twice = with_end_zones(with_end_zones(STAY, 1.0, 1.0, "drawing"), 4.0, 5.0, "survey")
    assert [(zone.note, round(zone.end - zone.start, 9)) for zone in twice.intervals] == [
        ("survey", 4.0),
        ("survey", 5.0),
    ]
