"""Inverse kinematics of the pipe climber: published values, the vector loop, limits, and the claw's offset."""

from __future__ import annotations

import math

import numpy as np
import pytest
from climber_cases import CONVENTIONS, LAYOUTS, REFERENCE, anywhere, layout, named, poses, radians

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber import Layout
from steeplejack.robots.pipe_climber.inverse import exceeded, hinge_angles, limb_lengths, limb_vectors
from steeplejack.robots.pipe_climber.poses import claw_pose, platform_pose


@pytest.mark.parametrize("case", REFERENCE["inverse"])
def test_the_reference_lengths(case: dict[str, list[float]]) -> None:
    found = limb_lengths(layout(str(case["convention"])), radians(case["pose"]))
    assert found == pytest.approx(case["lengths"], abs=5e-10)


@pytest.mark.parametrize("mechanism", LAYOUTS, ids=named)
def test_lengths_are_distances_of_hinges_turned_and_moved(mechanism: Layout, rng: np.random.Generator) -> None:
    for pose in anywhere(rng, 20):
        x, w, alpha = pose
        turn = np.array([[math.cos(alpha), math.sin(alpha)], [-math.sin(alpha), math.cos(alpha)]])
        platform = (turn @ np.stack((mechanism.platform, np.zeros(3)))).T + [x, w]
        expected = np.linalg.norm(platform - np.stack((mechanism.base, np.zeros(3)), axis=-1), axis=1)
        assert limb_lengths(mechanism, pose) == pytest.approx(expected, abs=1e-15)
        assert np.linalg.norm(limb_vectors(mechanism, pose), axis=-1) == pytest.approx(expected, abs=1e-15)


def test_exchanging_the_platforms_is_a_symmetry_of_the_text_only(rng: np.random.Generator) -> None:
    """Seen from the platform, limb 1 is limb 2 and the base is the platform: only with b = (0, -L3, -L1)."""
    for convention, holds in zip(CONVENTIONS, (True, False), strict=True):
        mechanism = layout(convention)
        pose = poses(rng, 50)
        x, w, alpha = pose.T
        # O1 seen from O2 with Z reversed: the mirror image keeps w positive and lengths as they are.
        seen = np.stack((-x * np.cos(alpha) + w * np.sin(alpha), x * np.sin(alpha) + w * np.cos(alpha), alpha), axis=-1)
        same = limb_lengths(mechanism, seen)[:, [1, 0, 2]] - limb_lengths(mechanism, pose)
        assert bool(np.abs(same).max() < 1e-12) is holds


def test_batches_broadcast_and_nan_stays_where_it_is() -> None:
    many = np.zeros((2, 3, 3))
    many[..., 1] = 0.16
    many[1, 2] = np.nan
    lengths = limb_lengths(layout(), many)
    assert lengths.shape == (2, 3, 3)
    assert np.isnan(lengths).sum() == 3
    assert limb_lengths(layout(), np.empty((0, 3))).shape == (0, 3)


@pytest.mark.parametrize("value", [[1.0, 2.0], "pose", [[1, 2, 3], [1, 2]], 5.0])
def test_what_is_no_pose_is_refused(value: object) -> None:
    with pytest.raises(InputError):
        limb_lengths(layout(), value)  # pyright: ignore[reportArgumentType]


def test_every_limit_that_binds_is_named() -> None:
    assert exceeded(layout(), [0.0, 0.16, 0.0]) == []
    far = exceeded(layout(), [0.0, 0.35, 0.0])
    assert [(one.limb, one.what, one.limit) for one in far] == [(limb, "length", 0.24) for limb in (1, 2, 3)]
    assert "largest 0.24 m" in str(far[0])
    near = exceeded(layout(), [0.0, 0.119, 0.0])
    assert [(one.limb, one.limit) for one in near] == [(3, 0.12)]
    turned = exceeded(layout(neutral="normal"), [0.0, 0.150, math.radians(20.0)])
    assert [(one.limb, one.what) for one in turned] == [(1, "hinge at the platform")]
    assert turned[0].value == pytest.approx(math.radians(-41.8622), abs=1e-6)
    assert exceeded(layout(neutral="home"), [0.0, 0.160, 0.0]) == []


def test_a_length_at_its_limit_holds_it() -> None:
    pose = [0.0, math.sqrt(0.24**2 - 0.075**2), 0.0]
    assert exceeded(layout(), pose) == []


def test_hinges_count_from_the_normals_or_from_home(rng: np.random.Generator) -> None:
    mechanism = layout()
    assert hinge_angles(mechanism, mechanism.home, "home") == pytest.approx(np.zeros((3, 2)))
    angles = hinge_angles(mechanism, poses(rng, 20))
    vectors = limb_vectors(mechanism, poses(np.random.default_rng(20260), 20))
    assert np.tan(angles[..., 0]) == pytest.approx(vectors[..., 0] / vectors[..., 1])


def test_the_claw_turns_with_the_platform(rng: np.random.Generator) -> None:
    pose = poses(rng, 10)
    for offset in ("turning", "along-z"):
        there = claw_pose(pose, 0.1, offset)
        assert platform_pose(there, 0.1, offset) == pytest.approx(pose, abs=1e-15)
    apart = claw_pose([0.0, 0.16, math.radians(22.5)], 0.1) - claw_pose([0.0, 0.16, math.radians(22.5)], 0.1, "along-z")
    assert np.hypot(*apart[:2]) == pytest.approx(0.1 * 2.0 * math.sin(math.radians(11.25)))


@pytest.mark.parametrize("lengths", [(0.0, 0.1, 0.1, 0.1), (0.1, -0.1, 0.1, 0.1), (0.1, math.nan, 0.1, 0.1)])
def test_impossible_dimensions_are_refused(lengths: tuple[float, float, float, float]) -> None:
    with pytest.raises(InputError, match="four finite lengths"):
        Layout(lengths)
