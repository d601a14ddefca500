"""What a cable robot says of a pose, a rotation or a gravity that it cannot take: the argument that is at fault."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.robots.cable_robot import CableRobot, load_cable_robot

DOWN, FALL, PLACE = [0.0, -9.81], [0.0, 0.0, -9.81], [1.0, 0.5, 2.0]


@pytest.fixture(scope="module")
def planar():
    return load_cable_robot("planar-4-4")


@pytest.fixture(scope="module")
def spatial():
    return load_cable_robot("cogiro")


def test_a_pose_of_another_shape_is_refused(planar, spatial):
    for pose in ([5.0, 3.0], "somewhere", None, 5.0, [], [[5.0, 3.0]]):
        for question in (planar.lengths, planar.structure, planar.mass_matrix):
            with pytest.raises(InputError, match="pose"):
                question(pose)
        for question in (spatial.lengths, spatial.structure, spatial.mass_matrix):
            with pytest.raises(InputError, match="pose"):
                question(pose, np.eye(3))
        with pytest.raises(InputError, match="pose"):
            planar.locked(DOWN, pose)


def test_gravity_is_named_where_it_is_at_fault(planar, spatial):
    elastic = CableRobot(**{**vars(planar), "axial_stiffness": np.full(4, 1e5)})
    for gravity in (FALL, -9.81, "down", None, [DOWN, DOWN]):
        for question in (planar.weight, planar.locked):
            with pytest.raises(InputError) as refused:
                question(gravity, [5.0, 3.0, 0.02])
            assert refused.value.where == "gravity"
        with pytest.raises(InputError, match="gravity"):
            elastic.stiffness(np.ones(4), gravity, [5.0, 3.0, 0.02])
    for gravity in (DOWN, -9.81):
        with pytest.raises(InputError, match="gravity"):
            spatial.locked(gravity, PLACE, np.eye(3))


def test_a_pose_without_a_course_over_a_pulley_cannot_be_locked(planar):
    with_pulleys = CableRobot(
        **{**vars(planar), "pulley_radii": np.full(4, 0.3), "pulley_axes": np.tile([0.0, 1.0], (4, 1))}
    )
    inside = planar.anchors[0] - planar.attachments[0] + [0.2, 0.01]
    assert np.isnan(with_pulleys.lengths([*inside, 0.0])[0])
    with pytest.raises(InputError, match="a cable has no course there"):
        with_pulleys.locked(DOWN, [*inside, 0.0])
    with pytest.raises(InputError, match="position"):
        planar.locked(DOWN, [5.0, np.nan, 0.0])


def test_a_locked_platform_has_the_lengths_of_its_pose(planar):
    pose = [5.0, 3.0, 0.02]
    np.testing.assert_allclose(planar.locked(DOWN, pose).unstressed, planar.lengths(pose), rtol=1e-12)
