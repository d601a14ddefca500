"""Fans, their order, and the lean of their plane."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.worksite import Bridge, Fan, Stay, lean, under_normal


def fan_of(tilt: float, turn: float = 0.0, count: int = 6, y: float = 12.0) -> tuple[Stay, ...]:
    """Stays in a plane through (0, y, 0) tilted by ``tilt`` to -y and turned by ``turn`` about the vertical [rad]."""
    c, s = math.cos(turn), math.sin(turn)

    def place(along: float, up: float) -> tuple[float, float, float]:
        across, height = -up * math.sin(tilt), up * math.cos(tilt)
        return (c * along - s * across, y + s * along + c * across, height)

    return tuple(
        Stay(f"s{i}", "1", "L", "main", i, place(10.0 * i, 0.0), place(0.0, 60.0 + 4.0 * i))
        for i in range(1, count + 1)
    )


@pytest.mark.parametrize("tilt", [0.01, 0.1, 0.3])
@pytest.mark.parametrize("turn", [0.0, 0.7, -2.5])
def test_lean_and_under_face_of_a_plane_fan(tilt, turn):
    fan = Fan("T1L-main", fan_of(tilt, turn))
    assert fan.lean == pytest.approx(tilt, abs=1e-12)
    normal = np.array([math.sin(turn) * math.cos(tilt), -math.cos(turn) * math.cos(tilt), -math.sin(tilt)])
    np.testing.assert_allclose(fan.under_normal, normal, atol=1e-12)


@pytest.mark.parametrize(
    ("y", "centreline", "sense"), [(12.0, 0.0, 1.0), (-12.0, 0.0, -1.0), (12.0, 30.0, -1.0), (7.0, 7.0, 1.0)]
)
def test_upright_fan_looks_away_from_the_centreline(y, centreline, sense):
    normal = under_normal(fan_of(0.001, y=y), centreline)
    assert normal[1] * sense > 0.999


def test_upright_transverse_fan_looks_towards_x():
    assert under_normal(fan_of(0.0, math.pi / 2))[0] == pytest.approx(1.0)


def test_single_stay_stands_in_its_vertical_plane():
    stays = fan_of(0.0, 0.4, count=1)
    assert lean(stays) == 0.0
    assert abs(under_normal(stays) @ np.subtract(stays[0].upper, stays[0].lower)) < 1e-9


def test_fans_are_named_and_ordered_by_index():
    stays = fan_of(0.1)
    other = tuple(replace(s, id=f"r{s.index}", plane="R", side="side") for s in stays)
    bridge = Bridge("b", (*reversed(stays), *other), "test")
    assert list(bridge.fans) == ["T1L-main", "T1R-side"]
    assert [s.index for s in bridge.fan("T1L-main").stays] == [1, 2, 3, 4, 5, 6]
    assert [s.index for s in bridge.fan("T1R-side").between(2, 4)] == [2, 3, 4]
    assert bridge.stay("r3") is other[2]
    assert bridge.gravity == (0.0, 0.0, -9.81)


def test_chords_of_a_bridge_keep_everything_but_the_sag():
    hanging = tuple(replace(s, weight=600.0, tension=3e6) for s in fan_of(0.1))
    bridge = Bridge("b", hanging, "test", ("a note",))
    straight = bridge.as_chords()
    assert all(stay.sag > 0.0 for stay in bridge.stays)
    assert all(stay.sag == 0.0 for stay in straight.stays)
    for stay in straight.stays:
        assert stay.length == pytest.approx(math.dist(stay.lower, stay.upper), rel=1e-12)
    assert [stay.id for stay in straight.fan("T1L-main").stays] == [stay.id for stay in hanging]
    assert replace(straight, stays=bridge.stays) == bridge


def test_centreline_is_the_middle_of_the_tower():
    right = tuple(replace(s, id=f"r{s.index}", plane="R") for s in fan_of(0.0, y=40.0))
    bridge = Bridge("b", (*fan_of(0.0, y=20.0), *right), "test")
    assert bridge.fan("T1L-main").under_normal[1] == pytest.approx(-1.0)
    assert bridge.fan("T1R-main").under_normal[1] == pytest.approx(1.0)


@pytest.mark.parametrize(("ask", "valid"), [
    (lambda bridge: bridge.fan("T9L-main"), "one of T1L-main"),
    (lambda bridge: bridge.stay("s99"), "one of its 6, s1 to s6"),
    (lambda bridge: bridge.fan("T1L-main").between(5, 9), "two indices of 1 to 6, the smaller one first"),
    (lambda bridge: bridge.fan("T1L-main").between(5, 2), "two indices of 1 to 6, the smaller one first"),
])  # fmt: skip
def test_what_is_not_there_is_named_with_what_is(ask, valid):
    with pytest.raises(InputError) as error:
        ask(Bridge("b", fan_of(0.1), "test"))
    assert error.value.valid == valid
