"""Plans are of settled equilibria that lead into one another, and legs that are not held come to nothing."""

from __future__ import annotations

import itertools
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from statics import poses

from steeplejack.planning import Mission, Request, Rules, Scene, certificate, moves, plan
from steeplejack.planning.certificate import LEAP, binding, hold
from steeplejack.planning.lattice import Lattice
from steeplejack.planning.legs import BRACED, TURNED, driving, flight, four, joined
from steeplejack.planning.mission import Leg, Waypoint
from steeplejack.planning.moves import Drive
from steeplejack.robots.squad import Bay, Squad, load_squad
from steeplejack.robots.squad.anchorage import ALONG, Stance, exits
from steeplejack.spatial import from_quaternion, from_vector, to_quaternion
from steeplejack.worksite import Bridge, load_worksite

WINDOW = (20.0, 250.0)


@pytest.fixture(scope="module")
def steep() -> tuple[Mission, Bridge, Squad]:
    """High in a fan where equilibria are near to turning over, with a squad move."""
    bridge, squad = load_worksite("russky-like"), load_squad()
    assert isinstance(bridge, Bridge)
    bay, rules = Bay.of(bridge.fan("T1L-main"), 8, 11, "under", squad), Rules(squad.cable.tension, cell_length=8.0)
    request = Request(bridge.name, squad.name, bay.fan, (8, 11), 90.0, 106.0, "under", 0.0, rules.tension)
    mission = plan(Scene.of(bay, squad, rules, np.array(bridge.gravity)), request, (), lambda _done: None)
    assert mission.moves == 1
    assert mission.uncovered == ()
    return mission, bridge, squad


def turned(one: Waypoint, other: Waypoint) -> float:
    """Angle between two orientations [rad]."""
    return 2.0 * float(np.arccos(min(1.0, abs(np.dot(one.quaternion, other.quaternion)))))


def test_every_place_is_a_settled_equilibrium(steep: tuple[Mission, Bridge, Squad]) -> None:
    mission, bridge, squad = steep
    weight = squad.platform.mass * np.array(bridge.gravity)
    for pose in poses(mission, bridge, squad):
        centre = pose.rotation @ np.array(squad.platform.centre_of_mass)
        moment = np.cross(pose.ends - pose.position, pose.forces).sum(axis=0) + np.cross(centre, weight)
        assert np.linalg.norm(pose.forces.sum(axis=0) + weight) < 2e-3  # [N]: tensions are written to 1e-4 N
        assert np.linalg.norm(moment) < 1e-3  # [N m]


def test_neighbouring_places_turn_little(steep: tuple[Mission, Bridge, Squad]) -> None:
    for leg in steep[0].legs:
        assert max(turned(*pair) for pair in itertools.pairwise(leg.waypoints)) < LEAP


def test_legs_join_without_a_jump(steep: tuple[Mission, Bridge, Squad]) -> None:
    for before, after in itertools.pairwise(steep[0].legs):
        end, start = before.waypoints[-1], after.waypoints[0]
        np.testing.assert_allclose(start.position_m, end.position_m, atol=2e-6)
        np.testing.assert_allclose(start.base_s_m, end.base_s_m, atol=2e-6)
        np.testing.assert_allclose(start.tension_n, end.tension_n, atol=BRACED + 1e-3)
        assert turned(end, start) < 0.02


@pytest.fixture(scope="module")
def scene(bridge: Bridge, squad: Squad, bay: Bay) -> Scene:
    return Scene.of(bay, squad, Rules(tension=WINDOW), np.array(bridge.gravity))


def stance_of(leg: Leg) -> Stance:
    first = leg.waypoints[0]
    return Stance(first.base_s_m, tuple(np.radians(first.base_clock_deg)))  # pyright: ignore[reportArgumentType]


def way_of(leg: Leg) -> np.ndarray:
    return np.array([point.place for point in leg.waypoints])


def test_a_flight_through_a_place_not_held_is_none(scene: Scene, mission: Mission) -> None:
    leg = mission.legs[0]
    way = way_of(leg)
    assert flight(scene, stance_of(leg), way, 0, "inspect", leg.stay) is not None
    way[len(way) // 2, 2] = 0.0  # on the stay's axis
    assert flight(scene, stance_of(leg), way, 0, "inspect", leg.stay) is None


def test_a_flight_that_turns_at_once_is_none(scene: Scene, mission: Mission, monkeypatch: pytest.MonkeyPatch) -> None:
    leg = mission.legs[0]
    ends = way_of(leg)[[0, -1]]
    turn = turned(leg.waypoints[0], leg.waypoints[-1])
    for limit, planned in ((1.1 * turn, True), (0.9 * turn, False)):
        monkeypatch.setattr(certificate, "LEAP", limit)
        assert (flight(scene, stance_of(leg), ends, 0, "fly", None) is not None) == planned


@pytest.fixture(scope="module")
def drive(scene: Scene, mission: Mission) -> Drive:
    """The first of the mission."""
    leg = next(leg for leg in mission.legs if leg.kind == "drive")
    assert leg.base is not None
    s, clock = np.array([p.base_s_m for p in leg.waypoints]), np.radians([p.base_clock_deg for p in leg.waypoints])
    _anchors, pull = scene.anchors(s, clock, leg.base - 1)
    return Drive(leg.base - 1, (), np.array(leg.waypoints[0].place), s, clock, stance_of(leg), pull)


def test_a_drive_from_a_park_too_near_a_stay_is_none(scene: Scene, drive: Drive) -> None:
    assert driving(scene, drive, 0) is not None
    assert driving(scene, replace(drive, park=drive.park + np.array([0.0, 0.0, -drive.park[2]])), 0) is None


def test_a_drive_against_more_than_the_base_pulls_is_none(scene: Scene, drive: Drive) -> None:
    """As much as its planned tensions need along the stay is enough; a fifth of it is not, and that is what binds."""
    anchors, pull = scene.anchors(drive.s, drive.clock, drive.base)
    planned = hold(scene, anchors, pull, np.tile(drive.park, (len(anchors), 1)))
    point = scene.bay.place(*drive.park)
    towards = point + planned.rotation @ scene.attachments[drive.base] - anchors[:, drive.base]
    force = planned.tension[:, drive.base, None] * towards / np.linalg.norm(towards, axis=1)[:, None]
    tangents = exits(scene.bay, scene.squad, drive.s, drive.clock)[1][:, drive.base]
    needed = float(np.max(np.abs(np.sum(force * tangents, axis=1))))
    assert needed < scene.squad.base.drive_force
    for allowed, goes in ((1.01 * needed, True), (0.2 * needed, False)):
        limited = pull.copy()
        limited[:, ALONG, drive.base, 3] = allowed
        assert (driving(scene, replace(drive, pull=limited), 0) is not None) == goes
    where = {binding(scene, anchors[j], limited[j], drive.park) for j in range(len(anchors))} - {"none"}
    assert where
    assert all(f"pull along the stay of base {drive.base + 1}" in why for why in where)


def test_parks_that_spare_pull_come_first(scene: Scene, drive: Drive, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that hold with less than the base pulls, and with that limit; then those that hold only with all of it."""
    lattice = Lattice.over(scene, 30.0, 50.0, coarse=2)
    anchors, pull = scene.anchors(drive.s, drive.clock, drive.base)
    given = scene, lattice, drive.base, drive.s, drive.clock, drive.park
    monkeypatch.setattr(moves, "SPARE", 0.4)  # at which some of these parks are ruled out
    limited = pull.copy()
    limited[:, ALONG, drive.base, 3] -= 0.4 * scene.squad.base.drive_force

    def held(park: np.ndarray, limits: np.ndarray) -> bool:
        return bool(hold(scene, anchors, limits, np.tile(park, (len(anchors), 1))).along.all())

    parks = list(moves._parks(*given))
    sparing = [park for park in parks if held(park, limited)]
    others = [park for park in parks if not held(park, limited) and held(park, pull)]
    assert others
    assert not np.array_equal(parks, [*sparing, *others])  # so that the order tells
    found = list(moves._held_parks(*given))
    np.testing.assert_array_equal([park for park, _limits in found], [*sparing, *others])
    for (_park, limits), expected in zip(found, [limited] * len(sparing) + [pull] * len(others), strict=True):
        np.testing.assert_array_equal(limits, expected)


def test_legs_whose_tensions_no_brace_joins_are_none(scene: Scene, mission: Mission) -> None:
    """A jump to tensions that are none of the place's equilibria."""
    whole = mission.legs
    assert joined(scene, tuple(leg for leg in whole if leg.kind != "brace")) is not None
    first = whole[1].waypoints[0]
    pulled = msgspec.structs.replace(first, tension_n=tuple(np.add(first.tension_n, (100.0, 0.0, 0.0, 0.0))))
    after = msgspec.structs.replace(whole[1], waypoints=(pulled, *whole[1].waypoints[1:]))
    assert joined(scene, (whole[0], after)) is None


def test_legs_that_turn_at_once_are_none(scene: Scene, mission: Mission) -> None:
    """At the same tensions, where no brace is, and at those a brace would lead to."""
    before, brace, after = next(
        legs for legs in zip(mission.legs, mission.legs[1:], mission.legs[2:], strict=False) if legs[1].kind == "brace"
    )
    assert joined(scene, (before, after)) is not None
    near, far = (rolled(after, angle) for angle in (0.5 * TURNED, 2.0 * TURNED))
    assert joined(scene, (before, near)) is not None
    assert joined(scene, (before, far)) is None
    assert joined(scene, (brace, near)) is not None
    assert joined(scene, (brace, far)) is None


def rolled(leg: Leg, angle: float) -> Leg:
    """A leg whose first place is turned about a tilted axis [rad], all else as it was."""
    first = leg.waypoints[0]
    axis = np.array([0.48, 0.6, 0.64])
    turn = from_vector(angle * axis) @ from_quaternion(np.array(first.quaternion))
    start = msgspec.structs.replace(first, quaternion=four(to_quaternion(turn)))
    return msgspec.structs.replace(leg, waypoints=(start, *leg.waypoints[1:]))
