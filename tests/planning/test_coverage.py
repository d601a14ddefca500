"""Coverage against closed forms on straight stays, and against a plain search over every pose and cell."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from steeplejack.planning.coverage import UNSEEN, clock_coverage, coverage_fraction, not_covered, observe
from steeplejack.planning.mission import Uncovered
from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import load_squad
from steeplejack.spatial import from_vector
from steeplejack.worksite import Fan, Interval, Stay

Array = NDArray[np.float64]

SQUAD = load_squad()
CAMERA = SQUAD.camera
RADIUS = 0.055
HEADING, RISE, SPACING, LEAN = math.radians(37.0), math.radians(33.0), 3.0, math.radians(20.0)


def straight_stay(number: int, intervals: tuple[Interval, ...] = ()) -> Stay:
    """One of several parallel stays of 60 m in a leaning plane, turned about the vertical."""
    along = np.array([math.cos(RISE) * math.cos(HEADING), math.cos(RISE) * math.sin(HEADING), math.sin(RISE)])
    level = np.array([-math.sin(HEADING), math.cos(HEADING), 0.0])
    across = math.cos(LEAN) * np.cross(along, level) + math.sin(LEAN) * level
    lower = number * SPACING * across
    ends = [(float(x), float(y), float(z)) for x, y, z in (lower, lower + 60.0 * along)]
    return Stay(f"S{number}", "1", "L", "main", number, ends[0], ends[1], diameter=2.0 * RADIUS, intervals=intervals)


def straight_bay(intervals: tuple[Interval, ...] = (), interior: int = 1) -> Bay:
    stays = [straight_stay(k, intervals if 0 < k <= interior else ()) for k in range(interior + 2)]
    return Bay.of(Fan("T1L-main", tuple(stays)), 0, interior + 1, "under", SQUAD)


BAY = straight_bay()


def poses(bay: Bay, s: Array, stand_off: float, k: int = 1, tilt: float = 0.0) -> tuple[Array, Array]:
    """Cameras ``stand_off`` [m] from the surface of stay ``k``, looking at it, tilted up the stay by ``tilt`` [rad]."""
    position = bay.place(np.full(len(s), float(k)), s, bay.radius(k) + stand_off)
    frame = bay.frame(float(k), 30.0)
    return position, np.tile(from_vector(-tilt * frame[:, 0]) @ frame, (len(s), 1, 1))


def interval(flags: NDArray[np.bool_], edges: Array) -> tuple[float, float]:
    """First and last border of the cells that are set; they must be in one piece."""
    cells = np.flatnonzero(flags)
    assert len(cells) == cells[-1] - cells[0] + 1
    return float(edges[cells[0]]), float(edges[cells[-1] + 1])


def test_seen_interval_is_the_flown_one_and_half_a_footprint_at_either_end():
    stand_off = 0.6
    (seen,) = observe(BAY, CAMERA, *poses(BAY, np.arange(20.0, 30.0, 0.05), stand_off), 10.0, 40.0, station=0.01)
    nearest = int(np.argmin(np.abs((seen.clock - seen.facing[0] + np.pi) % (2.0 * np.pi) - np.pi)))
    low, high = interval(seen.seen[:, nearest], seen.edges)
    half = stand_off * math.tan(0.5 * CAMERA.field_of_view)
    assert (low, high) == pytest.approx((20.0 - half, 29.95 + half), abs=0.015)


def test_a_tilted_camera_sees_ahead():
    tilt, stand_off = 0.3, 0.5
    (seen,) = observe(
        BAY,
        CAMERA,
        *poses(BAY, np.array([25.0]), stand_off, tilt=tilt),
        10.0,
        40.0,
        station=0.005,
        sector=math.radians(1.0),
    )
    nearest = int(np.argmin(np.abs((seen.clock - seen.facing[0] + np.pi) % (2.0 * np.pi) - np.pi)))
    low, high = interval(seen.seen[:, nearest], seen.edges)
    half = 0.5 * CAMERA.field_of_view
    expected = (25.0 + stand_off * math.tan(tilt - half), 25.0 + stand_off * math.tan(tilt + half))
    assert (low, high) == pytest.approx(expected, abs=0.01)


def test_the_largest_incidence_bounds_the_seen_stretch_of_a_wide_lens():
    wide = msgspec.structs.replace(CAMERA, field_of_view=3.0, max_incidence=0.9)
    (seen,) = observe(
        BAY, wide, *poses(BAY, np.array([25.0]), 0.8), 10.0, 40.0, station=0.005, sector=math.radians(1.0)
    )
    nearest = int(np.argmin(np.abs((seen.clock - seen.facing[0] + np.pi) % (2.0 * np.pi) - np.pi)))
    low, high = interval(seen.seen[:, nearest], seen.edges)
    assert (low, high) == pytest.approx((25.0 - 0.8 * math.tan(0.9), 25.0 + 0.8 * math.tan(0.9)), abs=0.01)


@pytest.mark.parametrize("stand_off", [0.31, 0.6, 0.99])
def test_seen_clock_sector_ends_at_the_largest_incidence(stand_off: float):
    """Law of sines in the triangle of axis, surface point and camera: phi = i - asin(r sin(i) / D)."""
    step = math.radians(0.5)
    (seen,) = observe(BAY, CAMERA, *poses(BAY, np.array([25.0]), stand_off), 24.99, 25.01, sector=step)
    i = CAMERA.max_incidence
    half = i - math.asin(RADIUS * math.sin(i) / (RADIUS + stand_off))
    assert np.mean(seen.seen) == pytest.approx(half / np.pi, abs=1.5 * step / np.pi)
    away = np.abs((seen.clock - seen.facing[0] + np.pi) % (2.0 * np.pi) - np.pi)
    assert away[seen.seen[0]].max() == pytest.approx(half, abs=1.5 * step)


def test_the_face_of_a_leaning_plane_is_told_by_the_clock():
    """The outward normal of the under face, put together by hand from the lean."""
    (seen,) = observe(BAY, CAMERA, *poses(BAY, np.array([25.0]), 0.5), 10.0, 40.0)
    stay = BAY.stays[1]
    twelve, three = stay.clock_frame(25.0)
    outward = np.cross(stay.tangent(25.0), np.subtract(BAY.stays[2].lower, stay.lower))
    outward *= -math.copysign(1.0, outward[2])
    assert outward @ (math.cos(seen.facing[0]) * twelve + math.sin(seen.facing[0]) * three) == pytest.approx(SPACING)


@pytest.mark.parametrize("stand_off", [0.29, 1.01, 4.0])
def test_nothing_is_seen_out_of_range(stand_off: float):
    (seen,) = observe(BAY, CAMERA, *poses(BAY, np.arange(10.0, 40.0, 0.1), stand_off), 10.0, 40.0)
    assert not seen.seen.any()
    assert coverage_fraction([seen]) == 0.0


def test_nothing_is_seen_with_the_camera_turned_away():
    position, rotation = poses(BAY, np.arange(10.0, 40.0, 0.1), 0.6)
    (seen,) = observe(BAY, CAMERA, position, rotation * np.array([-1.0, 1.0, -1.0]), 10.0, 40.0)
    assert not seen.seen.any()


def test_a_whole_flight_covers_the_faced_sector_and_not_the_far_side():
    (seen,) = observe(BAY, CAMERA, *poses(BAY, np.arange(10.0, 40.0, 0.1), 0.6), 10.0, 40.0)
    assert coverage_fraction([seen]) == pytest.approx(1.0)
    assert 0.25 < clock_coverage([seen]) < 0.5
    assert not_covered([seen], ()) == ()


def test_a_partial_flight_leaves_a_gap_of_the_rest():
    s = np.arange(10.0, 25.0, 0.02)
    (seen,) = observe(BAY, CAMERA, *poses(BAY, s, 0.6), 10.0, 40.0, station=0.01)
    (gap,) = not_covered([seen], ())
    assert (gap.stay, gap.to_m, gap.why) == ("S1", 40.0, UNSEEN)
    # At the edge of the sector the line of sight is longer, but the cone cuts it off a little earlier than in front.
    assert 25.0 < gap.from_m < 25.0 + 0.6 * math.tan(0.5 * CAMERA.field_of_view) + RADIUS
    assert coverage_fraction([seen]) == pytest.approx((gap.from_m - 10.0) / 30.0, abs=1e-9)


def test_end_zones_and_obstacles_are_neither_asked_for_nor_gaps():
    zones = (
        Interval(0.0, 12.34, "end zone"),
        Interval(20.0, 20.55, "obstacle", 0.02),
        Interval(38.0, 60.0, "end zone"),
    )
    bay = straight_bay(zones)
    position, rotation = poses(bay, np.arange(10.0, 30.0, 0.05), 0.6)
    (seen,) = observe(bay, CAMERA, position, rotation, 10.0, 40.0)
    assert seen.asked_length == pytest.approx(38.0 - 12.34 - 0.55)
    (gap,) = not_covered([seen], ())
    assert gap.to_m == 38.0
    assert seen.covered_length == pytest.approx(seen.asked_length - (gap.to_m - gap.from_m))


def test_a_request_beyond_the_stay_ends_at_its_anchorage():
    (seen,) = observe(BAY, CAMERA, *poses(BAY, np.array([25.0]), 0.6), 50.0, 90.0)
    assert seen.asked_length == pytest.approx(10.0)


def test_where_nothing_is_asked_for_nothing_is_covered():
    bay = straight_bay((Interval(0.0, 60.0, "end zone"),))
    seen = observe(bay, CAMERA, *poses(bay, np.array([25.0]), 0.6), 10.0, 40.0)
    assert coverage_fraction(seen) == clock_coverage(seen) == 0.0
    assert not_covered(seen, ()) == ()


def test_the_plan_gives_the_reason_and_its_edges_do_not_splinter():
    """Two reasons side by side, then a stretch that should have been seen; footprints end a little off the plan."""
    s = np.arange(10.0, 20.3, 0.05)
    (seen,) = observe(BAY, CAMERA, *poses(BAY, s, 0.6), 10.0, 40.0)
    reasons = (
        Uncovered("S1", 21.0, 25.0, "slack"),
        Uncovered("S1", 25.0, 30.0, "slip"),
        Uncovered("S9", 0.0, 60.0, "no"),
    )
    gaps = not_covered([seen], reasons)
    assert [gap.why for gap in gaps] == ["slack", "slip", UNSEEN]
    assert gaps[0].from_m < 21.0
    assert gaps[0].to_m == pytest.approx(25.0, abs=0.1)
    assert gaps[1].to_m == gaps[2].from_m == pytest.approx(30.5, abs=0.1)
    assert gaps[2].to_m == 40.0


def test_a_narrow_sector_still_needs_the_nearest_sample():
    narrow = msgspec.structs.replace(CAMERA, faced_half_sector=1e-6)
    (seen,) = observe(BAY, narrow, *poses(BAY, np.array([25.0]), 0.6), 10.0, 40.0)
    assert np.all(seen.faced.sum(axis=1) == 1)
    assert 0.0 < coverage_fraction([seen]) < 0.1


def brute_force(bay: Bay, k: int, position: Array, rotation: Array, s: Array, clock: Array) -> NDArray[np.bool_]:
    """The definition, pose by pose and cell by cell, without windows."""
    stay = bay.stays[k]
    twelve, three = stay.clock_frame(s)
    normal = np.cos(clock)[:, None] * twelve[:, None] + np.sin(clock)[:, None] * three[:, None]
    surface = stay.position(s)[:, None] + bay.radius(k) * normal
    seen = np.zeros(surface.shape[:2], bool)
    for p, view in zip(position, rotation[:, :, 2], strict=True):
        stand_off = float(stay.nearest(p)[1]) - bay.radius(k)
        if CAMERA.stand_off[0] <= stand_off <= CAMERA.stand_off[1]:
            line = p - surface
            distance = np.linalg.norm(line, axis=-1)
            incidence = np.arccos(np.clip(np.sum(line * normal, -1) / distance, -1.0, 1.0))
            off_axis = np.arccos(np.clip(-line @ view / distance, -1.0, 1.0))
            seen |= (incidence <= CAMERA.max_incidence) & (off_axis <= 0.5 * CAMERA.field_of_view)
    return seen


@given(st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_windows_lose_nothing(seed: int):
    rng = np.random.default_rng(seed)
    bay = straight_bay(interior=2)
    n = 12
    position = bay.place(rng.uniform(0.8, 2.2, n), rng.uniform(8.0, 22.0, n), rng.uniform(0.2, 1.2, n))
    rotation = np.stack([from_vector(rng.normal(0.0, 0.5, 3)) @ bay.frame(1.5, 15.0) for _ in range(n)])
    for k, seen in zip(bay.interior, observe(bay, CAMERA, position, rotation, 10.0, 20.0), strict=True):
        np.testing.assert_array_equal(seen.seen, brute_force(bay, k, position, rotation, seen.stations, seen.clock))


def test_sagging_stays_are_followed():
    """On a catenary with 0.5 m of sag the same flight along the curve covers it."""
    stays = tuple(replace(straight_stay(k), weight=600.0, tension=4.0e5) for k in range(3))
    bay = Bay.of(Fan("T1L-main", stays), 0, 2, "under", SQUAD)
    assert bay.stays[1].sag > 0.4
    s = np.arange(10.0, 40.0, 0.1)
    position = bay.place(np.full(len(s), 1.0), s, bay.radius(1) + 0.6)
    rotation = np.stack([bay.frame(1.0, float(x)) for x in s])
    assert coverage_fraction(observe(bay, CAMERA, position, rotation, 10.0, 40.0)) == pytest.approx(1.0)
