"""The elastic catenary against an ODE found by shooting, its limits, and its own geometry."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from random_schedules import stays
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from steeplejack.worksite import Catenary, Chord, Stay, hang

# lower, upper, weight [N/m], tension [N], axial stiffness [N]: heavy, steep and turned, slack, very elastic, rising -y
CASES = [
    ((0.0, 0.0, 50.0), (290.0, 5.0, 191.0), 588.6, 3.576e6, None),
    ((0.0, 0.0, 50.0), (290.0, 5.0, 191.0), 588.6, 3.576e6, 195e9 * 0.0075),
    ((-292.0, 14.0, 50.0), (-310.0, 4.0, 110.0), 588.6, 3.576e6, 1.4e9),
    ((3.0, -2.0, 1.0), (5.0, -102.0, 40.0), 800.0, 1.1e5, 1e9),
    ((0.0, 0.0, 0.0), (80.0, 60.0, 120.0), 1500.0, 4.0e5, 1.0e7),
    ((0.0, 0.0, 0.0), (1e-3, 2e-3, 100.0), 600.0, 2.0e6, 1e9),
]


def shot(lower, upper, weight, tension, stiffness, grid):
    """Points at fractions ``grid`` of the loaded length by integrating equilibrium from a shot lower end.

    Unknown are the vertical force at the lower end and the unstressed length; the state is (x, z, loaded length).
    """
    span, rise = math.hypot(upper[0] - lower[0], upper[1] - lower[1]), upper[2] - lower[2]
    chord = math.hypot(span, rise)
    horizontal = tension * span / chord

    def slope(s0, _state, vertical):
        force = np.array([horizontal, vertical + weight * s0])
        size = math.hypot(*force)
        stretch = 1.0 + (size / stiffness if stiffness else 0.0)
        return np.array([*(stretch * force / size), stretch])

    def shoot(vertical, length, **options):
        return solve_ivp(slope, (0.0, length), np.zeros(3), args=(vertical,), rtol=1e-12, atol=1e-12, **options)

    def miss(unknown):
        end = shoot(unknown[0] * tension, unknown[1] * chord).y[:2, -1]
        return [(end[0] - span) / chord, (end[1] - rise) / chord]

    found = root(miss, [(rise - 0.5 * weight * chord * chord / tension) / chord, 1.0], tol=1e-13).x
    path = shoot(found[0] * tension, found[1] * chord, dense_output=True, method="DOP853")
    loaded = path.y[2, -1]
    at = [brentq(lambda s0, f=f: path.sol(s0)[2] - f * loaded, 0.0, path.t[-1], xtol=1e-12) for f in grid]
    along, up = path.sol(np.array(at))[:2]
    return along, up, loaded, found[1] * chord


@pytest.mark.parametrize("case", CASES)
def test_matches_equilibrium_integrated_and_shot(case):
    lower, upper, *_ = case
    grid = np.linspace(0.05, 0.95, 7)
    along, up, loaded, unstressed = shot(*case, grid)
    curve = hang(*case)
    assert isinstance(curve, Catenary)
    points = curve.position(grid * curve.length) - lower
    towards = np.array([upper[0] - lower[0], upper[1] - lower[1]]) / math.hypot(
        upper[0] - lower[0], upper[1] - lower[1]
    )
    np.testing.assert_allclose(points[:, :2] @ towards, along, atol=1e-9)
    np.testing.assert_allclose(points[:, 2], up, atol=1e-9)
    assert curve.length == pytest.approx(loaded, abs=1e-9)
    assert curve.unstressed_length == pytest.approx(unstressed, abs=1e-9)


def test_heavy_tension_tends_to_the_parabola_at_second_order():
    lower, upper, weight = (1.0, 2.0, 3.0), (91.0, -40.0, 60.0), 600.0
    chord = math.dist(lower, upper)
    theta = math.asin((upper[2] - lower[2]) / chord)

    def error(tension):
        parabola = weight * math.cos(theta) * chord**2 / (8.0 * tension)
        return abs(hang(lower, upper, weight, tension).sag / parabola - 1.0)

    ratios = [error(t) / error(2.0 * t) for t in (2e5, 4e5, 8e5)]
    np.testing.assert_allclose(ratios, 4.0, rtol=0.05)
    assert error(3.6e6) < 1e-4


def test_secant_of_two_states_is_ernsts_modulus():
    """A stay of fixed unstressed length, pulled a little more and a little less, has Ernst's tangent stiffness."""
    lower, direction, weight, stiffness = (0.0, 0.0, 0.0), np.array([0.9, 0.0, 0.435889894354]), 800.0, 1.5e9
    chord, tension = 400.0, 3.0e6

    def at(length, pull):
        return hang(lower, tuple((length * direction).tolist()), weight, pull, stiffness).unstressed_length

    unstressed, step = at(chord, tension), 1e3
    longer, shorter = (
        brentq(lambda c, t=t: at(c, t) - unstressed, chord - 1.0, chord + 1.0, xtol=1e-12)
        for t in (tension + step, tension - step)
    )
    stiff = 2.0 * step / (longer - shorter) * chord
    ernst = stiffness / (1.0 + (weight * chord * direction[0]) ** 2 * stiffness / (12.0 * tension**3))
    assert ernst < 0.75 * stiffness
    neglected = tension / stiffness + (weight * chord / tension) ** 2  # what Ernst's formula leaves out
    assert stiff == pytest.approx(ernst, rel=0.5 * neglected)


def test_elastic_tends_to_inextensible():
    lower, upper, weight, tension, _ = CASES[0]
    rigid = hang(lower, upper, weight, tension)
    s = np.linspace(0.0, rigid.length, 11)
    for stiffness in (1e10, 1e12, 1e15):
        gap = np.abs(hang(lower, upper, weight, tension, stiffness).position(s) - rigid.position(s)).max()
        assert gap < 2.0 * tension / stiffness


@pytest.mark.parametrize("offset", [0.0, 1e-13, 1e-8, 1e-6, 1e-4])
def test_towards_the_vertical_it_becomes_the_chord(offset):
    lower, upper = (4.0, 5.0, 6.0), (4.0 + offset, 5.0, 126.0)
    curve, chord = hang(lower, upper, 600.0, 2e6, 1e9), Chord(lower, upper)
    s = np.linspace(0.0, 120.0, 13)
    np.testing.assert_allclose(curve.position(s), chord.position(s), atol=1e-6)
    assert np.isfinite(curve.tangent(s)).all()


def test_weightless_stay_is_its_chord():
    assert isinstance(hang((0.0, 0.0, 0.0), (50.0, 0.0, 50.0), 1e-6, 1e6), Chord)


def test_next_to_weightless_stay_keeps_its_digits():
    lower, upper, tension = (0.0, 0.0, 0.0), (60.0, 0.0, 80.0), 1e6
    curve = hang(lower, upper, 0.1, tension)
    assert isinstance(curve, Catenary)
    s = np.linspace(0.0, 100.0, 201)
    np.testing.assert_allclose(curve.nearest(curve.position(s))[0], s, atol=1e-10)
    assert curve.sag == pytest.approx(0.1 * 0.6 * 100.0**2 / (8.0 * tension), rel=1e-4)


@given(stays(complete=True))
@settings(max_examples=150, deadline=None)
def test_passes_through_both_anchorages(stay: Stay):
    np.testing.assert_allclose(stay.position(0.0), stay.lower, atol=1e-9)
    np.testing.assert_allclose(stay.position(stay.length), stay.upper, atol=1e-9)
    assert stay.length >= math.dist(stay.lower, stay.upper) - 1e-9


@given(stays())
@settings(max_examples=150, deadline=None)
def test_nearest_point_of_a_point_on_the_stay_is_that_point(stay: Stay):
    s = np.linspace(0.0, stay.length, 17).reshape(1, 17)
    found, distance = stay.nearest(stay.position(s))
    np.testing.assert_allclose(found, s, atol=1e-8)
    np.testing.assert_allclose(distance, 0.0, atol=1e-8)


@given(stays(complete=True))
@settings(max_examples=150, deadline=None)
def test_tangent_is_a_unit_vector_and_the_derivative_of_position(stay: Stay):
    s, h = np.linspace(0.0, stay.length, 9), 1e-4 * stay.length
    tangent = stay.tangent(s)
    np.testing.assert_allclose(np.linalg.norm(tangent, axis=-1), 1.0, atol=1e-12)
    np.testing.assert_allclose((stay.position(s + h) - stay.position(s - h)) / (2.0 * h), tangent, atol=2e-7)


def test_nearest_leaves_a_perpendicular_off_the_stay():
    curve = hang(*CASES[3])
    p = curve.position(np.array([20.0, 50.0, 90.0])) + np.array([[3.0, 0.5, -2.0], [-8.0, 0.0, 9.0], [0.3, 0.2, 0.0]])
    s, distance = curve.nearest(p)
    gap = p - curve.position(s)
    np.testing.assert_allclose(np.sum(gap * curve.tangent(s), axis=-1), 0.0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(gap, axis=-1), distance, atol=1e-12)
    dense = np.linspace(0.0, curve.length, 200_001)
    brute = [np.linalg.norm(curve.position(dense) - q, axis=-1).min() for q in p]
    np.testing.assert_allclose(distance, brute, atol=1e-6)


@pytest.mark.parametrize("case", CASES)
def test_nearest_stops_at_the_anchorages(case):
    curve = hang(*case)
    beyond = np.array([curve.lower - 3.0 * curve.tangent(0.0), curve.upper + 3.0 * curve.tangent(curve.length)])
    s, distance = curve.nearest(beyond)
    np.testing.assert_allclose(s, [0.0, curve.length], atol=1e-9)
    np.testing.assert_allclose(distance, 3.0, atol=1e-9)


def test_batch_axes_are_kept():
    lower, upper, weight, tension, stiffness = CASES[1]
    stay = Stay("a", "1", "L", "main", 1, lower, upper, None, weight, tension, stiffness)
    for one in (stay, replace(stay, chord_only=True)):
        s = np.full((2, 3), 10.0)
        assert one.position(s).shape == one.tangent(s).shape == (2, 3, 3)
        assert one.position(10.0).shape == one.tangent(10.0).shape == (3,)
        found, distance = one.nearest(one.position(s))
        assert found.shape == distance.shape == (2, 3)
        assert [axis.shape for axis in one.clock_frame(s)] == [(2, 3, 3)] * 2
