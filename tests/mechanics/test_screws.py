"""Screws: products, frames, joints against finite motion, and reciprocal systems of every order."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.limb import (
    Gauge,
    Joint,
    couple,
    force,
    helical,
    joined,
    met,
    order,
    pitch_of_twist,
    prismatic,
    reciprocal,
    reciprocal_product,
    revolute,
    same,
    transform_twists,
    transform_wrenches,
)
from steeplejack.spatial.rotation import from_vector

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def test_a_force_works_on_a_turn_by_its_moment_about_the_axis(rng: np.random.Generator) -> None:
    axes, directions = (rows / np.linalg.norm(rows, axis=1)[:, None] for rows in rng.normal(size=(2, 40, 3)))
    points, others = rng.normal(size=(2, 40, 3))
    found = reciprocal_product(revolute(axes, points), force(directions, others))
    moment = np.einsum("ij,ij->i", axes, np.cross(others - points, directions))
    assert found == pytest.approx(moment, abs=1e-12)


def test_textbook_pairs_are_reciprocal() -> None:
    axis_through = revolute(Z, [1.0, 2.0, 0.0])
    assert reciprocal_product(axis_through, force(X, [1.0, 2.0, 5.0])) == 0.0  # the force meets the axis
    assert reciprocal_product(axis_through, force(Z, [7.0, 3.0, 0.0])) == 0.0  # or is parallel to it
    assert reciprocal_product(axis_through, couple(X)) == 0.0
    assert reciprocal_product(axis_through, couple(Z)) == 1.0
    assert reciprocal_product(prismatic(Y), force(X, [0.0, 0.0, 3.0])) == 0.0
    assert reciprocal_product(prismatic(Y), couple(Y)) == 0.0  # no couple works on a translation
    assert reciprocal_product(helical(Z, [0.0, 0.0, 0.0], 0.2), force(Z, [0.0, 0.0, 0.0])) == 0.2


def test_pitch() -> None:
    assert pitch_of_twist(helical(X, [0.3, -0.2, 0.7], -0.25)) == pytest.approx(-0.25)
    assert pitch_of_twist(revolute(Y, [1.0, 2.0, 3.0])) == 0.0
    assert pitch_of_twist(prismatic(Z)) == np.inf


def test_reciprocal_products_do_not_depend_on_the_frame(rng: np.random.Generator) -> None:
    rotation, translation = from_vector(rng.normal(size=3)), rng.normal(size=3)
    twists, wrenches = rng.normal(size=(2, 7, 6))
    there = reciprocal_product(
        transform_twists(rotation, translation, twists), transform_wrenches(rotation, translation, wrenches)
    )
    assert there == pytest.approx(reciprocal_product(twists, wrenches), abs=1e-12)


def test_transforms_carry_lines_along(rng: np.random.Generator) -> None:
    rotation, translation = from_vector(rng.normal(size=3)), rng.normal(size=3)
    axis, point = X, rng.normal(size=3)
    moved = revolute(rotation @ axis, rotation @ point + translation)
    assert transform_twists(rotation, translation, revolute(axis, point)) == pytest.approx(moved)
    pushed = force(rotation @ axis, rotation @ point + translation)
    assert transform_wrenches(rotation, translation, force(axis, point)) == pytest.approx(pushed)


@pytest.mark.parametrize(
    ("pitch", "axis"), [(0.0, [0.0, 0.6, 0.8]), (0.3, [1.0, 0.0, 0.0])], ids=["revolute", "helical"]
)
def test_a_joint_moves_points_as_its_twist_says(pitch: float, axis: list[float]) -> None:
    direction, point, place, step = np.array(axis), np.array([0.2, -0.1, 0.4]), np.array([0.5, 0.6, -0.7]), 1e-6

    def moved(angle: float) -> Array:
        return point + from_vector(angle * direction) @ (place - point) + pitch * angle * direction

    twist = helical(direction, point, pitch)
    velocity = np.cross(twist[:3], place) + twist[3:]
    assert velocity == pytest.approx((moved(step) - moved(-step)) / (2.0 * step), abs=1e-9)


@pytest.mark.parametrize("count", range(7))
def test_reciprocal_systems_of_every_order(count: int, rng: np.random.Generator) -> None:
    screws = rng.normal(size=(count, 6))
    doubled = np.concatenate((screws, screws[::-1] * 1e6, np.zeros((1, 6))))
    wrenches = reciprocal(doubled)
    assert (order(doubled), len(wrenches)) == (count, 6 - count)
    assert reciprocal_product(screws[:, None], wrenches) == pytest.approx(np.zeros((count, 6 - count)), abs=1e-12)
    assert same(reciprocal(wrenches), screws)


def test_special_systems() -> None:
    parallel = revolute(np.tile(Z, (5, 1)), np.arange(15.0).reshape(5, 3) % 4.0)
    meeting = revolute(np.array([X, Y, Z, [0.6, 0.8, 0.0]]), np.full((4, 3), 0.7))
    coaxial = np.stack((revolute(Z, [1.0, 1.0, 0.0]), revolute(Z, [1.0, 1.0, 9.0]), helical(Z, [1.0, 1.0, 0.0], 0.1)))
    assert (order(parallel), order(meeting), order(coaxial)) == (3, 3, 2)
    assert same(met(parallel, meeting), revolute(Z, [0.7, 0.7, 0.7])[None])
    assert order(joined(parallel, meeting)) == 5
    assert order(joined()) == 0
    assert len(met()) == 6


JOINTS = {
    "revolute": ({"axis": (0.0, 0.0, 2.0), "point": (1.0, 2.0, 3.0)}, 1),
    "prismatic": ({"axis": (0.0, 3.0, 4.0)}, 1),
    "helical": ({"axis": (0.0, 0.0, 2.0), "point": (1.0, 2.0, 3.0), "pitch": 0.1}, 1),
    "cylindrical": ({"axis": (0.0, 1.0, 2.0), "point": (1.0, 2.0, 3.0)}, 2),
    "universal": ({"axis": (0.0, 0.0, 2.0), "second_axis": (1.0, 0.2, 0.0), "point": (1.0, 2.0, 3.0)}, 2),
    "spherical": ({"point": (1.0, 2.0, 3.0)}, 3),
    "planar": ({"axis": (0.3, 0.0, 2.0)}, 3),
}


@pytest.mark.parametrize("kind", JOINTS)
def test_lower_pairs(kind: str) -> None:
    fields, freedoms = JOINTS[kind]
    joint = Joint(name="J", kind=kind, links=("a", "b"), **fields)  # pyright: ignore[reportArgumentType]
    twists = joint.twists()
    assert (joint.freedoms, order(twists)) == (freedoms, freedoms)
    sizes = np.where(
        np.any(twists[:, :3], axis=1), *(np.linalg.norm(h, axis=1) for h in (twists[:, :3], twists[:, 3:]))
    )
    assert sizes == pytest.approx(1.0)
    if "point" in fields:  # a force through its centre is always carried, unless the joint slides that way
        through = force(X, fields["point"])
        assert reciprocal_product(twists[~np.all(twists[:, :3] == 0.0, axis=1)], through) == pytest.approx(0.0)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_rank_is_free_of_scale_and_place(scale: float) -> None:
    rng = np.random.default_rng(8)
    points = scale * (rng.normal(size=(5, 3)) + [1e3, 0.0, 0.0])
    gauge = Gauge.of(points)
    twists = revolute(np.tile(Y, (5, 1)), points)
    assert order(gauge.twists(twists)) == 3
    assert same(gauge.twists(gauge.plain_twists(np.eye(6)[:2])), np.eye(6)[:2])
    wrenches = reciprocal(gauge.twists(twists))
    assert (
        np.abs(reciprocal_product(twists[:, None], gauge.plain_wrenches(wrenches))).max() < 1e-9 * max(1.0, scale) * 1e3
    )


def test_a_gauge_where_all_points_are_one() -> None:
    assert Gauge.of(np.full((3, 3), 0.1) + 1e-17).length == 1.0
    assert Gauge.of(np.empty((0, 3))).length == 1.0


@pytest.mark.parametrize("screws", [[[np.nan] * 6], [[1.0, 2.0, 3.0]], "a line", [[np.inf] * 6], np.zeros((2, 2, 6))])
def test_no_screws(screws: object) -> None:
    with pytest.raises(InputError, match="screws"):
        reciprocal(screws)  # pyright: ignore[reportArgumentType]
