"""The gait table, exhaustively: what can happen is in it, what is not in it cannot happen."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from steeplejack.robots.squad import Squad
from steeplejack.robots.squad.adhesion import min_grip_force
from steeplejack.runtime.gait import (
    ARRIVED,
    CLOSED,
    HELD,
    OPENED,
    PATIENCE,
    STILL,
    TRANSITIONS,
    VERIFY_TIME,
    Outcome,
    Phase,
    Progress,
    judge,
)

DURATION, CLOSE_TIME, GOAL = 20.0, 4.0, 50.0
ENDS = (Phase.DONE, Phase.STOPPED)
NUMBERS = st.floats(allow_nan=True, allow_infinity=True)


def judged(
    phase: Phase, elapsed: float, palm: float = 1.0, s: float = GOAL, mark: float = GOAL, began: float = 100.0
) -> Outcome | None:
    return judge(Progress(phase, began, mark), began + elapsed, DURATION, palm, s, GOAL, CLOSE_TIME)


def test_pairs_outside_the_table_cannot_happen() -> None:
    """A leg that is over or stopped judges nothing, and a flight is over by time alone."""
    missing = set(itertools.product(Phase, Outcome)) - set(TRANSITIONS)
    assert missing == {(end, outcome) for end in ENDS for outcome in Outcome} | {(Phase.FLY, Outcome.TIMEOUT)}
    readings = (-math.inf, -1.0, 0.0, OPENED, 0.5, HELD, CLOSED, 1.0, 2.0, math.inf, math.nan)
    times = (0.0, 0.1, VERIFY_TIME, CLOSE_TIME, DURATION, DURATION + PATIENCE, 1e6)
    for phase, elapsed, palm, s in itertools.product(Phase, times, readings, (GOAL, 0.0, math.inf, math.nan)):
        outcome = judged(phase, elapsed, palm, s)
        assert outcome is not Outcome.BREACH  # breaches come from the safety monitor, not from here
        if outcome is not None:
            assert (phase, outcome) in TRANSITIONS


@given(st.sampled_from(Phase), NUMBERS, NUMBERS, NUMBERS, NUMBERS)
def test_whatever_the_sensors_say_there_is_a_next_phase(
    phase: Phase, elapsed: float, palm: float, s: float, mark: float
) -> None:
    outcome = judged(phase, elapsed, palm, s, mark, began=0.0)
    assert outcome is None or (phase, outcome) in TRANSITIONS


def test_a_breach_always_stops() -> None:
    for phase in Phase:
        if phase not in ENDS:
            assert TRANSITIONS[phase, Outcome.BREACH] is Phase.STOPPED


def test_a_timeout_always_stops() -> None:
    for (_phase, outcome), then in TRANSITIONS.items():
        if outcome is Outcome.TIMEOUT:
            assert then is Phase.STOPPED


def paths(phase: Phase) -> list[tuple[Phase, ...]]:
    """Every way through the table from a phase to its end."""
    onward = {then for (here, _outcome), then in TRANSITIONS.items() if here is phase}
    return [(phase,)] if not onward else [(phase, *rest) for then in onward for rest in paths(then)]


def test_no_drive_is_over_without_a_verified_grip() -> None:
    for start in (Phase.OPEN, Phase.DRIVE, Phase.CLOSE, Phase.VERIFY):
        for path in paths(start):
            assert path[-1] in ENDS
            assert len(set(path)) == len(path)
            if path[-1] is Phase.DONE:
                assert path[-2] is Phase.VERIFY
    whole = (Phase.OPEN, Phase.DRIVE, Phase.CLOSE, Phase.VERIFY, Phase.DONE)
    assert [path for path in paths(Phase.OPEN) if path[-1] is Phase.DONE] == [whole]


def test_a_flight_never_opens_a_palm() -> None:
    assert {phase for path in paths(Phase.FLY) for phase in path} == {Phase.FLY, Phase.DONE, Phase.STOPPED}


def test_flight_ends_with_its_time() -> None:
    assert judged(Phase.FLY, DURATION - 1e-9) is None
    assert judged(Phase.FLY, DURATION) is Outcome.REACHED


def test_palms_open() -> None:
    assert judged(Phase.OPEN, 1.0, palm=math.nextafter(OPENED, 1.0)) is None
    assert judged(Phase.OPEN, 1.0, palm=OPENED) is Outcome.REACHED
    assert judged(Phase.OPEN, CLOSE_TIME + PATIENCE, palm=0.5) is None
    assert judged(Phase.OPEN, CLOSE_TIME + PATIENCE + 1e-6, palm=0.5) is Outcome.TIMEOUT


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_drive_ends_at_its_goal_and_not_before_its_time(side: float) -> None:
    near, far = GOAL + side * (ARRIVED - 1e-9), GOAL + side * (ARRIVED + 1e-9)
    assert judged(Phase.DRIVE, DURATION - 1e-6, s=near) is None
    assert judged(Phase.DRIVE, DURATION, s=near) is Outcome.REACHED
    assert judged(Phase.DRIVE, DURATION, s=far) is None
    assert judged(Phase.DRIVE, DURATION + PATIENCE, s=far) is None
    assert judged(Phase.DRIVE, DURATION + PATIENCE + 1e-6, s=far) is Outcome.TIMEOUT


def test_palms_close() -> None:
    assert judged(Phase.CLOSE, 1.0, palm=math.nextafter(CLOSED, 0.0)) is None
    assert judged(Phase.CLOSE, 1.0, palm=CLOSED) is Outcome.REACHED
    assert judged(Phase.CLOSE, CLOSE_TIME + PATIENCE + 1e-6, palm=0.9) is Outcome.TIMEOUT


def test_grip_is_held_and_still_for_a_while() -> None:
    assert judged(Phase.VERIFY, VERIFY_TIME - 1e-6) is None
    assert judged(Phase.VERIFY, VERIFY_TIME) is Outcome.REACHED
    assert judged(Phase.VERIFY, 0.1, palm=HELD) is None
    assert judged(Phase.VERIFY, 0.1, palm=math.nextafter(HELD, 0.0)) is Outcome.TIMEOUT


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_wheel_that_creeps_fails_the_grip(side: float) -> None:
    assert judged(Phase.VERIFY, VERIFY_TIME, s=side * 0.9 * STILL, mark=0.0) is Outcome.REACHED
    assert judged(Phase.VERIFY, VERIFY_TIME, s=side * 1.1 * STILL, mark=0.0) is Outcome.TIMEOUT


@pytest.mark.parametrize("phase", [Phase.OPEN, Phase.DRIVE, Phase.CLOSE, Phase.VERIFY])
def test_a_sensor_that_says_nothing_never_lets_a_drive_go_on(phase: Phase) -> None:
    """Comparisons with nan are false: none of them may read as success."""
    palm = math.nan if phase is not Phase.DRIVE else 0.0
    for elapsed in (0.0, VERIFY_TIME, 3.0, DURATION + 2.0 * PATIENCE):
        assert judged(phase, elapsed, palm=palm, s=math.nan) is not Outcome.REACHED
    assert judged(phase, DURATION + 2.0 * PATIENCE, palm=palm, s=math.nan) is Outcome.TIMEOUT
    assert judged(Phase.VERIFY, 0.1, s=math.nan) is Outcome.TIMEOUT


def test_noise_of_the_palm_sensor_does_not_lose_a_good_grip(squad: Squad) -> None:
    """Palms that close in 4 s, read at 1 kHz: noise shows CLOSED too early and must not take the grip away again."""
    rng = np.random.default_rng(7)
    gripper = squad.gripper
    noise, rate = gripper.palm_noise / gripper.force, 1e-3 / gripper.close_time
    for _trial in range(1000):
        ramp = np.minimum(1.0, 0.88 + rate * np.arange(1000)) + rng.normal(0.0, noise, 1000)
        first = int(np.argmax(ramp >= CLOSED))
        assert judged(Phase.CLOSE, 1.0, palm=ramp[first]) is Outcome.REACHED
        assert np.min(ramp[first : first + 501]) >= HELD


def test_noise_does_not_hide_a_lost_grip() -> None:
    rng = np.random.default_rng(11)
    readings = 0.86 + rng.normal(0.0, 5.0 / 600.0, 500)
    assert any(judged(Phase.VERIFY, 1e-3 * k, palm=palm) is Outcome.TIMEOUT for k, palm in enumerate(readings))


def test_a_palm_that_counts_as_held_holds(squad: Squad) -> None:
    """What Eq. 17 asks for on the paper's example (483 N) is less than the least preload that passes."""
    gripper = squad.gripper
    shape = (gripper.friction, gripper.joint_distance, gripper.joint_height)
    needed = min_grip_force(300.0, 0.050, math.radians(45.0), gripper.palm_length, "+", *shape).min_force
    assert HELD * gripper.force > needed
    assert OPENED < HELD < CLOSED < 1.0
