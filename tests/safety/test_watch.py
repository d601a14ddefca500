"""What the monitor makes of raw readings: tensions, winch exits and cable lengths of its own."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from steeplejack.robots.squad import Bay, Squad
from steeplejack.robots.squad.anchorage import exits, facing
from steeplejack.safety import BREACHES, Monitor
from steeplejack.safety.monitor import filter_readings

DT = 1e-3
GRIPPED, STILL = np.ones(4, bool), np.zeros(4, bool)
Array = np.ndarray[tuple[int, ...], np.dtype[np.float64]]


@pytest.mark.parametrize(("tension", "motor"), [(120.0, 100.0), (80.0, 130.0), (50.0, 50.0)])
def test_tension_of_a_rotor_under_way(tension: float, motor: float) -> None:
    """m_r dv/dt = t - F - friction sign(v): the tension comes back while the rotor accelerates."""
    friction, reflected, rate = 3.0, 12.0, np.sign(tension - motor) * 1e-6
    state, found = np.concatenate([np.full(4, motor), np.zeros(16)]), np.zeros(4)
    reading = np.zeros((7, 4))
    for _ in range(300):
        resisting = friction * np.tanh(rate / 0.005)
        rate += DT * (tension - motor - resisting) / reflected
        reading[1], reading[2] = rate, motor
        after = np.zeros(20)
        filter_readings(state, reading, friction, reflected, DT, after, found)
        state = after
    np.testing.assert_allclose(found, tension, atol=0.5)


def unweighed(squad: Squad) -> Squad:
    """The machine with no limit on unbalanced forces, which would speak first."""
    return msgspec.structs.replace(squad, safety=msgspec.structs.replace(squad.safety, imbalance=1e3))


class Standing:
    """A squad on the bay, at rest with every reading true."""

    def __init__(self, bay: Bay, squad: Squad) -> None:
        s = np.array([24.0, 26.0, 52.0, 55.0])
        self.goal = bay.place(np.array([2.0]), np.array([35.0]), np.array([0.7]))[0]
        self.rotation = bay.frame(2.0, 35.0)
        self.clock = clock = facing(bay, s, self.goal)
        points, _tangents, _arms = exits(bay, squad, s, clock)
        ends = self.goal + np.array(squad.platform.attachments) @ self.rotation.T
        self.tension = np.array([40.0, 60.0, 110.0, 120.0])
        # Whatever these tensions carry is the weight: the monitor takes both as they come.
        self.weight = -self.tension @ ((points - ends) / np.linalg.norm(points - ends, axis=1)[:, None])
        lengths = np.linalg.norm(points - ends, axis=1)
        self.reading = np.zeros((7, 4))
        self.reading[0] = lengths / (1.0 + self.tension / squad.cable.axial_stiffness)
        self.reading[2], self.reading[3], self.reading[5] = self.tension, s, clock
        self.reading[6] = squad.gripper.force
        self.command = np.zeros((3, 4))
        self.command[0] = self.tension
        self.monitor = Monitor(bay, squad, self.weight, squad.cable.tension)

    def first_breach(self, steps: int) -> tuple[str, int, int]:
        """Words, cable and step of the first breach within so many steps."""
        state = self.monitor.begin(self.tension, self.clock)
        for step in range(steps):
            verdict = self.monitor.step(state, self.reading, self.command, GRIPPED, STILL, self.goal, self.rotation, DT)
            if verdict.code:
                return BREACHES[verdict.code], verdict.where, step
            state = verdict.state
        return "", -1, steps


def test_well_is_well(bay: Bay, squad: Squad) -> None:
    assert Standing(bay, squad).first_breach(1000) == ("", -1, 1000)


def test_an_overload_is_seen_within_milliseconds(bay: Bay, squad: Squad) -> None:
    standing = Standing(bay, unweighed(squad))
    standing.reading[2, 1] = 1.3 * squad.cable.tension[1]
    words, where, step = standing.first_breach(100)
    assert (words, where) == ("measured tension above the working window", 1)
    assert step < 25


def test_a_cable_gone_slack_is_seen(bay: Bay, squad: Squad) -> None:
    standing = Standing(bay, unweighed(squad))
    standing.reading[2, 3] = 0.0
    words, where, step = standing.first_breach(200)
    assert (words, where) == ("cable slack", 3)
    assert step < 50


def test_cable_miscounted_by_more_than_the_fence_breaks_it_whatever_the_controller_believes(
    bay: Bay, squad: Squad
) -> None:
    for cable in range(4):
        standing = Standing(bay, squad)
        standing.reading[0, cable] += 0.6
        words, where, step = standing.first_breach(10)
        assert (where, step) == (cable, 0)
        assert "fence" in words


def test_a_base_slipping_under_steps_of_its_encoder(bay: Bay, squad: Squad) -> None:
    """A slow slip reads as zero and full grains by turns: its mean counts."""
    standing = Standing(bay, squad)
    for mean, breach in ((0.012, False), (0.05, True)):
        state, found = standing.monitor.begin(standing.tension, standing.clock), 0
        for step in range(400):
            standing.reading[4, 2] = 0.1 if step % round(0.1 / mean) == 0 else 0.0
            verdict = standing.monitor.step(
                state, standing.reading, standing.command, GRIPPED, STILL, standing.goal, standing.rotation, DT
            )
            state, found = verdict.state, found or verdict.code
        assert (found != 0) == breach


def test_a_base_that_turns_about_its_stay(bay: Bay, squad: Squad) -> None:
    standing = Standing(bay, squad)
    for off, words in ((0.04, ""), (0.08, "grip lost: a base that should stand turns about its stay")):
        standing.reading[5] = standing.clock + np.array([0.0, 0.0, off, 0.0])
        assert standing.first_breach(500)[0] == words


def test_a_weight_the_cables_do_not_carry(bay: Bay, squad: Squad) -> None:
    """A platform that rests on something, or hangs far out of the plane: what is left over says so."""
    for share, words in ((0.9, ""), (0.7, "the cables do not balance the weight")):
        standing = Standing(bay, squad)
        standing.monitor = Monitor(bay, squad, standing.weight / share, squad.cable.tension)
        assert standing.first_breach(5)[0].startswith(words)
        assert bool(standing.first_breach(5)[0]) == bool(words)


def test_far_towards_the_stays_is_seen_by_forces_alone(bay: Bay, squad: Squad) -> None:
    """Lengths hardly change out of the plane of the cables; how far the monitor lets the platform go there."""
    standing = Standing(bay, squad)
    normal = standing.rotation[:, 2]
    points = exits(bay, squad, standing.reading[3], standing.reading[5])[0]
    seen = []
    for sign in (-1.0, 1.0):
        for off in np.arange(0.0, 6.0, 0.05):
            ends = standing.goal + sign * off * normal + np.array(squad.platform.attachments) @ standing.rotation.T
            lengths = np.linalg.norm(points - ends, axis=1)
            standing.reading[0] = lengths / (1.0 + standing.tension / squad.cable.axial_stiffness)
            if standing.first_breach(1)[0]:
                break
        seen.append(off)
    assert 0.5 < min(seen) < max(seen) < 4.0  # [m]: stated in `limits.check`
