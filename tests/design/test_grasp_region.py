"""The rectangle of Eq. 19, for stays of any direction."""

from __future__ import annotations

import numpy as np
import pytest
from grasp_questions import GRASP, track_question

from steeplejack.design.grasps import GraspQuestion, GraspRegion
from steeplejack.errors import InputError


def test_inclined_stays_have_the_region_as_printed(reference, rng):
    """Inside the rectangle where, and only where, the four inequalities hold."""
    given = GRASP["region"]
    region = track_question(reference).region
    positions = region.point + rng.uniform(-0.08, 0.08, (5000, 2))
    x, y = positions.T
    a, b = given["slope"], given["intercept"]
    c = region.point[1] + given["x0"] / a
    printed = (np.abs(y - (a * x + b)) <= given["delta"]) & (np.abs(y - (c - x / a)) <= given["epsilon"])
    inside = np.all(np.abs(region.coordinates(positions)) <= [region.half_length, region.half_width], axis=-1)
    np.testing.assert_array_equal(inside, printed)
    assert 0 < inside.sum() < len(inside)
    foot = np.abs(a * x - y + b) / np.sqrt(a * a + 1.0)
    np.testing.assert_allclose(region.distance(positions), foot, atol=1e-15)


@pytest.mark.parametrize(("direction", "width", "length"), [
    ((1.0, 0.0), 0.03, 0.05), ((-7.0, 0.0), 0.03, 0.05), ((0.0, 1.0), 0.03, 0.05), ((1e-300, -3.0), 0.03, 0.05),
    ((1.0, 1.0), 0.03 / np.sqrt(2.0), 0.05 / np.sqrt(2.0)), ((4.0, -3.0), 0.024, 0.03),
])  # fmt: skip
def test_offsets_of_vertical_lines_are_across_them(direction, width, length):
    region = GraspRegion.eq19((0.2, 0.1), direction, 0.03, 0.05)
    assert (region.half_width, region.half_length) == pytest.approx((width, length), rel=1e-12)


def test_coordinates_and_places_are_inverse(rng):
    region = GraspRegion((0.3, -0.2), (2.0, -5.0), 0.1, 0.2)
    coordinates = rng.normal(size=(10, 2))
    np.testing.assert_allclose(region.coordinates(region.placed(coordinates)), coordinates, atol=1e-14)
    np.testing.assert_allclose(np.ptp(region.coordinates(region.corners), axis=0), [0.4, 0.2], atol=1e-15)
    np.testing.assert_allclose(region.axes @ region.axes.T, np.eye(2), atol=1e-15)


@pytest.mark.parametrize(("changes", "where"), [
    ({"half_width": -0.01}, "half_width"), ({"half_length": np.inf}, "half_length"),
    ({"half_width": np.nan}, "half_width"),
    ({"direction": (0.0, 0.0)}, "direction"), ({"direction": (np.nan, 1.0)}, "direction"), ({"point": (1.0,)}, "point"),
])  # fmt: skip
def test_what_is_no_rectangle_is_refused(changes, where):
    with pytest.raises(InputError, match=where):
        GraspRegion(**({"point": (0.0, 0.0), "direction": (1.0, 1.0), "half_width": 0.1, "half_length": 0.1} | changes))


@pytest.mark.parametrize(("delta", "epsilon", "where"), [(-0.1, 0.1, "delta"), (0.1, np.nan, "epsilon")])
def test_offsets_below_nothing_are_refused(delta, epsilon, where):
    with pytest.raises(InputError, match=where):
        GraspRegion.eq19((0.0, 0.0), (1.0, 1.0), delta, epsilon)


@pytest.mark.parametrize(("changes", "where"), [
    ({"phi": np.nan}, "phi"), ({"anchors": np.zeros((3, 2))}, "anchors"),
    ({"attachments": np.full((4, 2), np.inf)}, "attach"),
])  # fmt: skip
def test_what_is_no_question_is_refused(changes, where):
    region = GraspRegion((0.0, 0.0), (1.0, 1.0), 0.1, 0.1)
    with pytest.raises(InputError, match=where):
        GraspQuestion(
            **({"anchors": np.ones((4, 2)), "attachments": np.ones((4, 2)), "phi": 0.0, "region": region} | changes)
        )
