"""A planned mission obeys every rule, checked from its file alone by statics of our own."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from statics import Pose, poses, potential_hessian

from steeplejack.planning import Mission, Request, Rules, Scene, plan, visits
from steeplejack.planning.certificate import hold, meets
from steeplejack.robots.squad import Bay, Squad
from steeplejack.worksite import Bridge

RULES = Rules(tension=(20.0, 250.0))
SHARE = 1.0 - RULES.reserve


@pytest.fixture(scope="module")
def waypoints(mission: Mission, bridge: Bridge, squad: Squad) -> list[Pose]:
    return poses(mission, bridge, squad)


@pytest.fixture(scope="module")
def weight(bridge: Bridge, squad: Squad) -> np.ndarray:
    return squad.platform.mass * np.array(bridge.gravity)


def test_has_every_kind_of_leg(mission: Mission) -> None:
    assert {leg.kind for leg in mission.legs} == {"inspect", "fly", "drive", "brace"}
    assert mission.stances == 2
    assert mission.moves == 1
    assert mission.uncovered == ()


def test_inspects_the_whole_stretch(mission: Mission) -> None:
    spans = sorted(sorted((leg.waypoints[0].place[1], leg.waypoints[-1].place[1])) for leg in mission.legs if leg.stay)
    assert spans[0][0] == pytest.approx(30.0)
    assert spans[-1][1] == pytest.approx(50.0)
    for before, after in itertools.pairwise(spans):
        assert after[0] <= before[1] + 1e-6


def test_forces_and_moments_balance(waypoints: list[Pose], weight: np.ndarray, squad: Squad) -> None:
    centre = np.array(squad.platform.centre_of_mass)
    for pose in waypoints:
        force = pose.forces.sum(axis=0) + weight
        moment = np.cross(pose.ends - pose.position, pose.forces).sum(axis=0)
        moment += np.cross(pose.rotation @ centre, weight)
        assert np.linalg.norm(force) < 2e-3  # [N]: tensions are written to 1e-4 N
        assert np.linalg.norm(moment) < 1e-4  # [N m]


def test_tensions_keep_the_window_less_reserve(waypoints: list[Pose]) -> None:
    low, high = RULES.tension
    for pose in waypoints:
        assert np.min(pose.tension) >= low * (1.0 + RULES.reserve) - 1e-3
        assert np.max(pose.tension) <= high * SHARE + 1e-3


def test_pull_along_the_stay_keeps_its_limit(waypoints: list[Pose], squad: Squad) -> None:
    """25 kg gripped; 15 kg for the base under way, whose own acceleration counts."""
    base = squad.base
    for pose in waypoints:
        along = np.abs(np.sum(pose.forces * pose.tangents, axis=1))
        limit = np.full(4, SHARE * base.hold_force)
        if pose.leg.base is not None:
            limit[pose.leg.base - 1] = SHARE * base.drive_force - base.mass * base.max_acceleration
        assert np.all(along <= limit + 1e-3), (pose.leg.kind, along, limit)


def test_twist_about_the_stay_keeps_the_palms(waypoints: list[Pose], squad: Squad) -> None:
    for pose in waypoints:
        moment = np.sum(np.cross(pose.arms, -pose.forces) * pose.tangents, axis=1)
        assert np.all(np.abs(moment) <= SHARE * squad.base.twist_torque + 1e-3)


def test_bases_stand_apart_and_clear_of_end_zones(mission: Mission, bridge: Bridge, squad: Squad) -> None:
    half = 0.5 * squad.base.length
    for leg in mission.legs:
        for point in leg.waypoints:
            for (i, one), (j, other) in itertools.combinations(enumerate(mission.carriers), 2):
                if one == other:
                    assert abs(point.base_s_m[i] - point.base_s_m[j]) >= squad.base.spacing - 1e-6
            for name, s in zip(mission.carriers, point.base_s_m, strict=True):
                for zone in bridge.stay(name).intervals:
                    assert s + half <= zone.start + 1e-6 or s - half >= zone.end - 1e-6


def test_one_base_moves_at_a_time(mission: Mission) -> None:
    for leg in mission.legs:
        for name in ("base_s_m", "base_clock_deg"):
            values = np.array([getattr(point, name) for point in leg.waypoints])
            moving = {int(i) + 1 for i in np.flatnonzero(np.ptp(values, axis=0) > 1e-9)}
            assert moving <= ({leg.base} if leg.kind == "drive" else set()), (leg.kind, name)
        if leg.kind == "drive":
            travelled = np.abs(np.array([point.base_s_m[leg.base - 1] for point in leg.waypoints]))
            np.testing.assert_allclose(np.abs(travelled - travelled[0]), [p.travel for p in leg.waypoints], atol=1e-5)
            assert np.ptp([point.position_m for point in leg.waypoints], axis=0).max() == 0.0  # platform parked
        else:
            assert leg.base is None


def test_stand_off_is_in_the_camera_s_range(mission: Mission, bridge: Bridge, squad: Squad) -> None:
    near, far = squad.camera.stand_off
    for leg in mission.legs:
        if leg.kind != "inspect":
            continue
        stay = bridge.stay(leg.stay)
        _s, distance = stay.nearest(np.array([point.position_m for point in leg.waypoints]))
        assert np.all(distance - stay.radius >= near - 1e-3)
        assert np.all(distance - stay.radius <= far + 1e-3)


def test_camera_looks_at_the_inspected_stay(waypoints: list[Pose], bridge: Bridge, squad: Squad) -> None:
    for pose in waypoints:
        if pose.leg.kind == "inspect":
            stay = bridge.stay(pose.leg.stay)
            s, distance = stay.nearest(pose.position)
            cosine = (stay.position(s) - pose.position) @ pose.rotation[:, 2] / distance
            assert math.acos(min(1.0, cosine)) < 0.5 * squad.camera.field_of_view


def test_cables_and_platform_clear_every_stay(
    waypoints: list[Pose], mission: Mission, bridge: Bridge, squad: Squad
) -> None:
    """Dense points along every cable against the true curves; its own stay it leaves without touching."""
    share = np.linspace(0.0, 1.0, 120)[:, None, None]
    names = (mission.boundary[0], *mission.interior, mission.boundary[1])
    own = np.array(mission.carriers)
    for pose in waypoints[::3]:
        points = pose.exits + share * (pose.ends - pose.exits)
        for name in names:
            stay = bridge.stay(name)
            gap = np.min(stay.nearest(points)[1], axis=0) - stay.radius
            assert np.all(gap[own != name] >= RULES.cable_clearance - 1e-3)
            assert np.all(gap[own == name] > 0.0)
            assert stay.nearest(pose.position)[1] - stay.radius >= squad.platform.clearance - 1e-3


def test_cables_are_long_enough(waypoints: list[Pose], squad: Squad) -> None:
    for pose in waypoints:
        assert np.max(np.linalg.norm(pose.exits - pose.ends, axis=1)) <= squad.winch.stored_length


def test_every_equilibrium_is_stable(waypoints: list[Pose], weight: np.ndarray, squad: Squad) -> None:
    """Least eigenvalue of the Hessian of the potential energy, by finite differences, above its own error."""
    for pose in waypoints:
        hessian = potential_hessian(pose, squad, weight)
        assert np.min(np.linalg.eigvalsh(0.5 * (hessian + hessian.T))) > 0.01, (pose.leg.kind, pose.waypoint.place)


def test_legs_join(mission: Mission) -> None:
    for before, after in itertools.pairwise(mission.legs):
        end, start = before.waypoints[-1], after.waypoints[0]
        np.testing.assert_allclose(start.position_m, end.position_m, atol=2e-6)
        np.testing.assert_allclose(start.base_s_m, end.base_s_m, atol=2e-6)
        turn = np.subtract(start.base_clock_deg, end.base_clock_deg)
        np.testing.assert_allclose((turn + 180.0) % 360.0 - 180.0, 0.0, atol=1e-5)
        np.testing.assert_allclose(start.tension_n, end.tension_n, atol=0.5 + 1e-3)  # the jump a brace takes up
        assert abs(np.dot(start.quaternion, end.quaternion)) > math.cos(0.5 * 0.02)


def test_travel_is_the_distance(mission: Mission) -> None:
    for leg in mission.legs:
        travel = np.array([point.travel for point in leg.waypoints])
        assert travel[0] == 0.0
        assert np.all(np.diff(travel) > 0.0)
        if leg.kind in ("inspect", "fly"):
            steps = np.linalg.norm(np.diff([point.position_m for point in leg.waypoints], axis=0), axis=1)
            np.testing.assert_allclose(np.diff(travel), steps, atol=5e-6)
            assert np.max(steps) < 0.5


def test_speeds_are_the_machine_s(mission: Mission, squad: Squad) -> None:
    motion, base = squad.motion, squad.base
    wanted = {
        "inspect": (motion.speed, motion.acceleration),
        "fly": (motion.transit_speed, motion.acceleration),
        "drive": (motion.drive_speed, base.max_acceleration),
    }
    for leg in mission.legs:
        if leg.kind in wanted:
            assert (leg.speed, leg.acceleration) == wanted[leg.kind]
    assert motion.speed == 0.25  # Table I: 15 m/min


def test_shared_stay_order(mission: Mission) -> None:
    """Bases 1 and 4 share one boundary stay, 2 and 3 the other, the first of each pair below."""
    a, b, c, d = mission.carriers
    assert a == d != b == c
    assert {a, b} == set(mission.boundary)
    for leg in mission.legs:
        for point in leg.waypoints:
            s = point.base_s_m
            assert s[0] < s[3] and s[1] < s[2]


def test_a_run_is_certified_as_it_is_flown(
    bridge: Bridge, bay: Bay, squad: Squad, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However strongly the stand-off is smoothed, what leaves the certified set is not planned smoothed."""
    monkeypatch.setattr(visits, "SMOOTHING", 61)
    rules = replace(RULES, payload=12.0)
    scene = Scene.of(bay, squad, rules, np.array(bridge.gravity))
    request = Request(bridge.name, squad.name, "T1L-main", (5, 7), 30.0, 42.0, "under", 12.0, rules.tension)
    heavy = plan(scene, request, (), lambda _done: None)
    flown = [leg for leg in heavy.legs if leg.kind == "inspect"]
    assert flown
    for leg in flown:
        first = leg.waypoints[0]
        anchors, pull = scene.anchors(np.array(first.base_s_m), np.radians(first.base_clock_deg))
        held = hold(scene, anchors, pull, np.array([point.place for point in leg.waypoints]))
        assert meets(scene, held.quality, 1e-3).all()
