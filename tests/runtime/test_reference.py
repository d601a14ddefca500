"""References of a planned mission: joined, at rest at both ends, within limits, differentiable, in equilibrium."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from steeplejack.control.controller import Setpoint
from steeplejack.planning import Leg, Mission
from steeplejack.robots.squad import Bay, Squad
from steeplejack.robots.squad.anchorage import exits
from steeplejack.runtime.reference import LegReference
from steeplejack.spatial import to_vector
from steeplejack.worksite import Bridge

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def references(mission: Mission) -> list[LegReference]:
    return [LegReference.of(leg) for leg in mission.legs]


def samples(reference: LegReference, count: int = 200) -> list[Setpoint]:
    return [reference.at(time) for time in np.linspace(0.0, reference.timing.duration, count)]


def rows(setpoint: Setpoint) -> dict[str, Array]:
    """Everything a setpoint says that has a rate, by name."""
    platform = {name: getattr(setpoint, name) for name in ("position", "velocity", "acceleration")}
    return platform | dict(zip(("s", "s_rate", "s_acceleration", "clock", "clock_rate"), setpoint.bases, strict=True))


def test_the_mission_has_every_kind_of_leg(mission: Mission) -> None:
    assert {leg.kind for leg in mission.legs} == {"inspect", "fly", "drive", "brace"}


def test_goes_through_its_waypoints(references: list[LegReference]) -> None:
    for reference in references:
        for end, point in ((0.0, reference.leg.waypoints[0]), (1e3, reference.leg.waypoints[-1])):
            setpoint = reference.at(end)
            np.testing.assert_allclose(setpoint.position, point.position_m, atol=1e-9)
            np.testing.assert_allclose(setpoint.tension, point.tension_n, atol=1e-9)
            np.testing.assert_allclose(setpoint.s, point.base_s_m, atol=1e-9)


def test_continuous_from_leg_to_leg(references: list[LegReference]) -> None:
    for before, after in itertools.pairwise(references):
        end, start = before.at(before.timing.duration), after.at(0.0)
        np.testing.assert_allclose(start.position, end.position, atol=2e-6)
        np.testing.assert_allclose(start.s, end.s, atol=2e-6)
        assert np.linalg.norm(to_vector(start.rotation @ end.rotation.T)) < 1e-3  # [rad]
        np.testing.assert_allclose(start.tension, end.tension, atol=0.5)  # [N]
        turn = rows(start)["clock"] - rows(end)["clock"]
        np.testing.assert_allclose(np.sin(0.5 * turn), 0.0, atol=1e-6)


def test_at_rest_at_both_ends(references: list[LegReference]) -> None:
    for reference in references:
        for time in (-1.0, 0.0, reference.timing.duration, reference.timing.duration + 5.0):
            setpoint = reference.at(time)
            now = rows(setpoint)
            for rate in ("velocity", "s_rate", "clock_rate"):
                np.testing.assert_array_equal(now[rate], 0.0)
            for second in ("acceleration", "s_acceleration"):
                np.testing.assert_allclose(now[second], 0.0, atol=1e-12)


def test_speed_and_acceleration_keep_the_machine_s_limits(references: list[LegReference], squad: Squad) -> None:
    motion, base = squad.motion, squad.base
    for reference in references:
        points = samples(reference)
        speed = max(np.linalg.norm(point.velocity) for point in points)
        s_rate = max(np.max(np.abs(rows(point)["s_rate"])) for point in points)
        s_acceleration = max(np.max(np.abs(rows(point)["s_acceleration"])) for point in points)
        # The travel keeps its limit exactly; the curve through the waypoints bends a little about it.
        largest = {"inspect": motion.speed, "fly": motion.transit_speed}.get(reference.leg.kind, 0.0)
        assert speed <= 1.02 * largest + 1e-9
        acceleration = max(np.linalg.norm(point.acceleration) for point in points)
        assert acceleration <= (1.25 * motion.acceleration if largest else 0.0) + 1e-9
        driven = reference.leg.kind == "drive"
        assert s_rate <= (1.0 + 1e-6) * motion.drive_speed * driven
        assert s_acceleration <= (1.0 + 1e-6) * base.max_acceleration * driven


def test_rates_by_finite_differences(references: list[LegReference]) -> None:
    h = 1e-5
    for reference in references:
        duration = reference.timing.duration
        for time in np.linspace(0.03, 0.97, 9) * duration:
            before, here, after = (rows(reference.at(time + k * h)) for k in (-1, 0, 1))
            for value, rate in (("position", "velocity"), ("s", "s_rate"), ("clock", "clock_rate")):
                numeric = (after[value] - before[value]) / (2.0 * h)
                np.testing.assert_allclose(numeric, here[rate], atol=1e-6)
            for rate, second in (("velocity", "acceleration"), ("s_rate", "s_acceleration")):
                numeric = (after[rate] - before[rate]) / (2.0 * h)
                np.testing.assert_allclose(numeric, here[second], atol=1e-5)


def test_rotations_stay_rotations(references: list[LegReference]) -> None:
    for reference in references:
        for setpoint in samples(reference, 30):
            np.testing.assert_allclose(setpoint.rotation @ setpoint.rotation.T, np.eye(3), atol=1e-12)


def test_between_the_waypoints_it_hangs_in_balance_too(
    references: list[LegReference], bridge: Bridge, bay: Bay, squad: Squad
) -> None:
    """Interpolated position, orientation and tensions leave less than 0.1 N of force and 0.05 N m of moment over."""
    weight = squad.platform.mass * np.array(bridge.gravity)
    attachments = np.array(squad.platform.attachments)
    for reference in references:
        for setpoint in samples(reference, 60):
            anchors, _tangents, _arms = exits(bay, squad, setpoint.s, rows(setpoint)["clock"])
            arms = attachments @ setpoint.rotation.T
            cables = anchors - setpoint.position - arms
            forces = setpoint.tension[:, None] * cables / np.linalg.norm(cables, axis=1, keepdims=True)
            assert np.linalg.norm(forces.sum(axis=0) + weight) < 0.1
            assert np.linalg.norm(np.cross(arms, forces).sum(axis=0)) < 0.05


def test_a_full_turn_of_the_clock_is_no_jump(mission: Mission) -> None:
    """179 and -179 deg are neighbours."""
    leg = next(leg for leg in mission.legs if leg.kind == "drive")
    assert leg.base is not None
    turned = []
    for k, point in enumerate(leg.waypoints):
        angle = 170.0 + 0.5 * k
        clock = tuple((angle + 180.0) % 360.0 - 180.0 if i == leg.base - 1 else 0.0 for i in range(4))
        turned.append(type(point)(*(getattr(point, name) for name in point.__struct_fields__[:-1]), clock))
    reference = LegReference.of(Leg("drive", 0, None, leg.base, leg.speed, leg.acceleration, tuple(turned)))
    rates = [rows(point)["clock_rate"][leg.base - 1] for point in samples(reference)]
    assert max(np.abs(rates)) < 0.1
