"""Time scaling: the whole length, at rest at both ends, within speed and acceleration, and consistent derivatives."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from steeplejack.spatial import Profile, profile


def between(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_subnormal=False)


LENGTHS, SPEEDS, ACCELERATIONS = between(1e-6, 1e3), between(1e-3, 10.0), between(1e-3, 10.0)


@given(LENGTHS, SPEEDS, ACCELERATIONS)
def test_covers_the_length_from_rest_to_rest(length: float, speed: float, acceleration: float) -> None:
    motion = profile(length, speed, acceleration)
    assert motion.at(0.0) == motion.at(-1.0) == (0.0, 0.0, 0.0)
    assert motion.at(motion.duration) == motion.at(motion.duration + 1.0) == (length, 0.0, 0.0)
    travel, rate, _ = motion.at(motion.duration - 1e-4 * motion.ramp)
    assert travel == pytest.approx(length, rel=1e-6)
    assert rate == pytest.approx(0.0, abs=1e-6 * speed)


@given(LENGTHS, SPEEDS, ACCELERATIONS)
def test_keeps_speed_and_acceleration(length: float, speed: float, acceleration: float) -> None:
    motion = profile(length, speed, acceleration)
    samples = np.array([motion.at(t) for t in np.linspace(0.0, motion.duration, 400)])
    assert np.all(np.diff(samples[:, 0]) >= -1e-12 * length)
    assert np.all(samples[:, 1] >= -1e-12)
    assert np.max(samples[:, 1]) <= speed * (1.0 + 1e-9)
    assert np.max(np.abs(samples[:, 2])) <= acceleration * (1.0 + 1e-9)


@given(LENGTHS, SPEEDS, ACCELERATIONS)
def test_reaches_a_limit(length: float, speed: float, acceleration: float) -> None:
    """The fastest of its kind: it runs at the largest speed or, where the length is too short, at no cruise at all."""
    motion = profile(length, speed, acceleration)
    assert motion.speed == speed or motion.cruise == pytest.approx(0.0, abs=1e-9 * motion.ramp)
    assert motion.at(0.5 * motion.ramp)[2] == pytest.approx(acceleration, rel=1e-9)


@given(LENGTHS, SPEEDS, ACCELERATIONS, between(0.0, 1.0))
def test_derivatives_are_consistent(length: float, speed: float, acceleration: float, share: float) -> None:
    motion = profile(length, speed, acceleration)
    h = 1e-5 * motion.ramp
    time = h + share * (motion.duration - 2.0 * h)
    before, here, after = (motion.at(time + k * h) for k in (-1, 0, 1))
    # The jerk jumps at the seams between ramps, cruise and rest: one step of it is the error of a difference there.
    jerk = acceleration * math.pi / motion.ramp
    assert (after[0] - before[0]) / (2.0 * h) == pytest.approx(
        here[1], rel=1e-6, abs=h * acceleration + 1e-9 * length / h
    )
    assert (after[1] - before[1]) / (2.0 * h) == pytest.approx(here[2], abs=h * jerk + 1e-9 * motion.speed / h)


@given(LENGTHS, SPEEDS, ACCELERATIONS)
def test_no_jump_at_the_seams(length: float, speed: float, acceleration: float) -> None:
    motion = profile(length, speed, acceleration)
    for seam in (0.0, motion.ramp, motion.ramp + motion.cruise, motion.duration):
        h = 1e-6 * motion.ramp + 1e-15 * motion.duration
        share = h / motion.ramp
        before, after = motion.at(seam - h), motion.at(seam + h)
        assert after[0] == pytest.approx(before[0], abs=3.0 * h * motion.speed + 1e-15 * length)
        assert after[1] == pytest.approx(before[1], abs=4.0 * share * motion.speed)
        assert after[2] == pytest.approx(before[2], abs=8.0 * share * acceleration)


@given(LENGTHS, SPEEDS, ACCELERATIONS, between(0.0, 1.0))
def test_the_way_back_mirrors_the_way_there(length: float, speed: float, acceleration: float, share: float) -> None:
    motion = profile(length, speed, acceleration)
    there, back = motion.at(share * motion.duration), motion.at((1.0 - share) * motion.duration)
    assert there[0] + back[0] == pytest.approx(length, rel=1e-9)
    assert there[1] == pytest.approx(back[1], abs=1e-9 * motion.speed)


@pytest.mark.parametrize(("speed", "acceleration"), [(0.25, 0.1), (1e-3, 10.0)])
def test_no_length_takes_no_time(speed: float, acceleration: float) -> None:
    motion = profile(0.0, speed, acceleration)
    assert motion == Profile(0.0, 0.0, 0.0, 0.0)
    assert motion.duration == 0.0
    assert motion.at(0.0) == motion.at(1.0) == (0.0, 0.0, 0.0)
