"""Interference against dense sampling, crossings against distances, and surroundings that mean nothing."""

from __future__ import annotations

import numpy as np
import pytest
from published_robots import COGIRO, IPANEMA_2, rotations

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.region import clearance
from steeplejack.mechanics.cable.region.certified import Label
from steeplejack.mechanics.cable.region.interference import (
    Surroundings,
    box_faces,
    cable_crossings,
    crossing_planes,
    interference_gaps,
    interference_rays,
    interference_region,
    platform_overlap,
)

pytestmark = pytest.mark.long

TILTED, TURNED = rotations(np.array([[0.05, 0.1, -0.08], [0.3, -0.2, 0.6]]))
STAYS = np.array(
    [
        [[-6.0, 2.4, 1.9], [0.0, 2.6, 2.2], [6.0, 2.4, 2.1]],
        [[2.5, -5.0, 4.0], [2.5, 0.0, 4.5], [2.6, 5.0, 5.0]],
    ]
)


@pytest.fixture(scope="module")
def crowded():
    anchors = [[-4.0, -3.0, 5.0], [4.0, -3.0, 5.0], [4.0, 3.0, 5.0], [-4.0, 3.0, 5.0], [0.5, -4.0, 0.5]]
    attachments = [[-0.4, -0.3, 0.2], [0.4, -0.3, 0.2], [0.4, 0.3, 0.2], [-0.4, 0.3, 0.2], [0.0, 0.3, 0.3]]
    return Surroundings.of(anchors, attachments, TILTED, STAYS, [0.05, 0.1], [0, -1, -1, -1, -1])


def brute(surroundings, position, count=201):
    """Least gap over points on the axes; above the true one by half a spacing at most."""
    share = np.linspace(0.0, 1.0, count)[:, None]
    ends = position + surroundings.arms
    cables = [a + share * (b - a) for a, b in zip(surroundings.anchors, ends, strict=True)]
    gaps = [np.linalg.norm(cables[i][:, None] - cables[j], axis=-1).min() for i, j in surroundings.pairs]
    for i, cable in enumerate(cables):
        for k, stay in enumerate(surroundings.stays):
            if surroundings.own[i] != k:
                points = np.concatenate([a + share * (b - a) for a, b in zip(stay[:-1], stay[1:], strict=True)])
                gaps.append(np.linalg.norm(cable[:, None] - points, axis=-1).min() - surroundings.radii[k])
    return min(gaps)


def test_gaps_are_those_of_dense_points(crowded, rng):
    positions = rng.uniform([-3.0, -2.0, 1.0], [3.0, 2.0, 4.0], (12, 3))
    gaps, causes = interference_gaps(crowded, positions)
    dense = np.array([brute(crowded, position) for position in positions])
    assert (gaps <= dense + 1e-12).all()
    np.testing.assert_allclose(gaps, dense, atol=0.03)
    assert (causes >= 0).all() and (causes < len(crowded.pairs) + 5 * 2).all()


def test_gaps_change_no_faster_than_the_platform(crowded, rng):
    positions = rng.uniform([-3.0, -2.0, 1.0], [3.0, 2.0, 4.0], (2000, 3))
    steps = rng.normal(size=(2000, 3)) * 10.0 ** rng.uniform(-4, 0, (2000, 1))
    change = interference_gaps(crowded, positions + steps)[0] - interference_gaps(crowded, positions)[0]
    assert (np.abs(change) <= np.linalg.norm(steps, axis=1) + 1e-6).all()


def test_no_sample_in_a_box_of_the_other_kind(crowded, rng):
    region = interference_region(crowded, [[-2.0, 2.0], [-1.5, 1.5], [1.0, 4.0]], 0.05, 0.2)
    assert region.reached and 0.0 < region.inner < region.outer
    for label in (Label.INSIDE, Label.OUTSIDE):
        boxes = region.of(label)
        chosen = boxes[rng.integers(0, len(boxes), 50_000)]
        positions = chosen[..., 0] + rng.random((50_000, 3)) * np.ptp(chosen, axis=2)
        gaps, _ = interference_gaps(crowded, positions)
        assert (gaps >= 0.05).all() if label == Label.INSIDE else (gaps < 0.05).all()


def test_rays_cross_where_the_gap_is_the_clearance(crowded, rng):
    starts, ends = rng.uniform([-3.0, -2.0, 1.0], [3.0, 2.0, 4.0], (2, 40, 3))
    rays = interference_rays(crowded, starts, ends, 0.1, 1e-8)
    poses = np.concatenate([rays.crossings(ray) for ray in range(40)])
    assert len(poses) > 20
    np.testing.assert_allclose(interference_gaps(crowded, poses)[0], 0.1, atol=2e-6)
    for label, sign in ((Label.INSIDE, 1.0), (Label.OUTSIDE, -1.0)):
        ray, piece = np.nonzero(rays.labels == label)
        share = 0.5 * (rays.places[ray, piece] + rays.places[ray, piece + 1])[:, None]
        gaps, _ = interference_gaps(crowded, starts[ray] + share * (ends[ray] - starts[ray]))
        assert (sign * (gaps - 0.1) >= -1e-6).all()


def test_two_cables_meet_exactly_at_a_crossing(rng):
    bare = Surroundings.of(COGIRO.anchors, COGIRO.attachments, TURNED)
    starts, ends = rng.uniform([-5.0, -4.0, 0.0], [5.0, 4.0, 5.0], (2, 300, 3))
    shares = cable_crossings(bare, starts, ends)
    ray, pair = np.nonzero(np.isfinite(shares))
    assert len(ray) > 50
    positions = starts[ray] + shares[ray, pair][:, None] * (ends[ray] - starts[ray])
    for position, q in zip(positions, pair, strict=True):
        alone = Surroundings(bare.anchors, bare.arms, bare.pairs[q : q + 1], bare.stays, bare.radii, bare.own)
        assert interference_gaps(alone, position)[0] < 1e-9


def test_every_contact_is_found_as_a_crossing(rng):
    """Rays sampled finely: the signed volume of two meeting cables changes sign, so least gaps dip to zero there."""
    bare = Surroundings.of(COGIRO.anchors, COGIRO.attachments, TURNED)
    starts, ends = rng.uniform([-5.0, -4.0, 0.0], [5.0, 4.0, 5.0], (2, 30, 3))
    met = np.isfinite(cable_crossings(bare, starts, ends)).any(axis=1)
    touched = interference_rays(bare, starts, ends, 1e-4, 1e-6).share(Label.OUTSIDE) > 0.0
    assert (touched[met]).all()
    assert met.sum() >= touched.sum() - 1  # a near miss within 0.1 mm is no crossing


def test_in_a_crossing_plane_two_cables_lie_in_one_plane(rng):
    bare = Surroundings.of(COGIRO.anchors, COGIRO.attachments, TURNED)
    normals, offsets = crossing_planes(bare)
    for q, (i, j) in enumerate(bare.pairs):
        position = rng.normal(size=3)
        position += normals[q] * (offsets[q] - normals[q] @ position) / (normals[q] @ normals[q])
        ends = position + bare.arms
        edges = bare.anchors[j] - bare.anchors[i], bare.anchors[i] - ends[i], bare.anchors[j] - ends[j]
        assert abs(np.linalg.det(edges)) <= 1e-9 * np.prod([np.linalg.norm(edge) for edge in edges])


def test_cables_that_share_an_end_are_left_out():
    anchors, attachments = IPANEMA_2.anchors.copy(), IPANEMA_2.attachments.copy()
    attachments[1], anchors[5] = attachments[0], anchors[4]
    pairs = {tuple(pair) for pair in Surroundings.of(anchors, attachments, np.eye(3)).pairs.tolist()}
    assert len(pairs) == 26 and not pairs & {(0, 1), (4, 5)}


def test_nothing_to_meet_is_an_infinite_gap():
    lone = Surroundings.of([[0.0, 0.0, 1.0]], [[0.0, 0.0, 0.0]], np.eye(3))
    gap, cause = interference_gaps(lone, np.zeros(3))
    assert gap == np.inf and cause == -1
    region = interference_region(lone, [[0.0, 1.0]] * 3, 0.1)
    assert region.labels.tolist() == [Label.INSIDE]


def test_overlap_is_the_length_inside_the_platform(rng):
    normals, offsets = box_faces([-0.3, -0.2, -0.1], [0.3, 0.2, 0.1])
    attachments = np.array([[0.3, 0.2, 0.1], [-0.3, 0.0, 0.0], [0.0, 0.0, -0.1], [0.0, 0.5, 0.0]])
    anchors = rng.normal(size=(4, 3)) * 3.0
    positions = rng.normal(size=(200, 3))
    turned = rotations(rng.normal(size=(200, 3)))
    lengths = platform_overlap(anchors, attachments, positions, turned, normals, offsets)
    share = (np.arange(4000) + 0.5) / 4000
    for position, rotation, row in zip(positions[:40], turned, lengths, strict=False):
        cables = (anchors - position) @ rotation - attachments
        points = attachments[:, None] + share[:, None] * cables[:, None]
        inside = (points @ normals.T < offsets - 1e-12).all(axis=-1).mean(axis=1)
        np.testing.assert_allclose(row, inside * np.linalg.norm(cables, axis=-1), atol=0.005)
    assert (lengths == 0.0).any() and (lengths > 0.05).any()


def test_a_cable_along_a_face_is_free():
    normals, offsets = box_faces([-1.0] * 3, [1.0] * 3)
    lengths = platform_overlap([[5.0, 0.0, 1.0]], [[0.0, 0.0, 1.0]], np.zeros(3), np.eye(3), normals, offsets)
    assert lengths.tolist() == [0.0]


def test_a_cable_along_a_face_is_free_at_every_rotation(rng):
    """Turned, the cable leaves the face by no more than rounding, which is no way into the platform."""
    normals, offsets = box_faces([-1.0] * 3, [1.0] * 3)
    turned = rotations(rng.normal(size=(200, 3)))
    anchors = turned @ [5.0, 0.0, 1.0]
    for rotation, anchor in zip(turned, anchors, strict=True):
        lengths = platform_overlap([anchor], [[0.0, 0.0, 1.0]], np.zeros(3), rotation, normals, offsets)
        assert lengths.tolist() == [0.0]
    inside = platform_overlap(
        [turned[0] @ [5.0, 0.0, 0.5]], [[0.0, 0.0, 0.5]], np.zeros(3), turned[0], normals, offsets
    )
    assert inside == pytest.approx([1.0], abs=1e-12)


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"anchors": [[0.0, 0.0, np.nan]]}, "anchors"),
        ({"anchors": [[0.0, 0.0]]}, "anchors"),
        ({"anchors": "there"}, "anchors"),
        ({"attachments": [[0.0, 0.0, 0.0]] * 2}, "cables"),
        ({"stays": [[[0.0, 0.0, 0.0]]]}, "stays"),
        ({"stays": [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]], "radii": np.nan}, "radii"),
        ({"stays": [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]], "radii": [0.1, 0.2]}, "radii"),
        ({"stays": [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]], "own": 1}, "own"),
        ({"stays": [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]], "own": 0.5}, "own"),
        ({"stays": [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]], "radii": -0.1}, "radii"),
        ({"rotation": 2.0 * np.eye(3)}, "rotation"),
        ({"rotation": np.diag([1.0, 1.0, -1.0])}, "rotation"),
    ],
)
def test_surroundings_that_mean_nothing_are_refused(changes, where):
    given = {"anchors": [[0.0, 0.0, 1.0]], "attachments": [[0.0, 0.0, 0.0]], "rotation": np.eye(3)}
    with pytest.raises(InputError) as error:
        Surroundings.of(**(given | changes))
    assert error.value.where == where


def test_clearances_that_mean_nothing_are_refused(crowded):
    with pytest.raises(InputError, match="clearance"):
        interference_region(crowded, [[0.0, 1.0]] * 3, 0.0)
    with pytest.raises(InputError, match="tolerance"):
        interference_rays(crowded, np.zeros(3), np.ones(3), 0.1, np.nan)


ORIGIN, X, Y, Z = np.zeros(3), *np.eye(3)


@pytest.mark.parametrize(
    ("segments", "distance"),
    [
        ((ORIGIN, X, Y, X + Y), 1.0),  # parallel, side by side
        ((ORIGIN, X, X + Y, Y), 1.0),  # the same, the other way round
        ((ORIGIN, X, 3.0 * X + Y, 5.0 * X + Y), np.sqrt(5.0)),  # parallel, apart along their direction
        ((ORIGIN, X, 0.5 * X, 2.0 * X), 0.0),  # on one line, overlapping
        ((ORIGIN, X, X, 2.0 * X), 0.0),  # on one line, end to end
        ((ORIGIN, X, 3.0 * X, 2.0 * X), 1.0),  # on one line, apart
        ((ORIGIN, X, ORIGIN, X), 0.0),  # the same
        ((ORIGIN, X, 0.25 * X, 0.25 * X + Y), 0.0),  # an end on the other's middle
        ((ORIGIN, X, 0.5 * X - Y, 0.5 * X + Y), 0.0),  # crossing
        ((ORIGIN, X, 0.5 * X - Y + Z, 0.5 * X + Y + Z), 1.0),  # crossing above each other
        ((ORIGIN, ORIGIN, X + Y, X + Y), np.sqrt(2.0)),  # two points
        ((ORIGIN, ORIGIN, Y - X, Y + X), 1.0),  # a point and a segment
        ((ORIGIN, X, 2.0 * X, 2.0 * X), 1.0),  # a segment and a point on its line
    ],
)
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_distances_of_degenerate_segments(segments, distance, scale):
    turn = rotations(np.array([[0.3, -1.1, 0.7]]))[0]
    for turned in (np.eye(3), turn):
        a, b, c, d = (scale * turned @ end for end in segments)
        for ends in ((a, b, c, d), (c, d, a, b), (b, a, d, c)):
            found = clearance.segment_distance(*(np.ascontiguousarray(end) for end in ends))
            assert found == pytest.approx(scale * distance, rel=1e-12, abs=8e-15 * scale)


def test_a_cable_along_a_stay_inside_it_and_through_it():
    stay = np.array([[[-5.0, 0.0, 0.0], [0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]])
    for anchor, gap in (([2.0, 0.0, 0.3], 0.2), ([2.0, 0.0, 0.05], -0.05), ([2.0, 0.0, 0.0], -0.1)):
        start = np.array([-1.0, 0.0, anchor[2]])
        found, cause = interference_gaps(Surroundings.of([anchor], np.zeros((1, 3)), np.eye(3), stay, 0.1), start)
        assert found == pytest.approx(gap, abs=1e-15) and cause == 0
        carried = Surroundings.of([anchor], np.zeros((1, 3)), np.eye(3), stay, 0.1, own=0)
        assert interference_gaps(carried, start)[0] == np.inf
    through = Surroundings.of([[0.0, 1.0, 0.0]], np.zeros((1, 3)), np.eye(3), stay, 0.1)
    assert interference_gaps(through, [0.0, -1.0, 0.0])[0] == -0.1


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"normals": 2.0 * np.eye(3)}, "normals"),
        ({"offsets": [1.0, 1.0]}, "platform"),
        ({"positions": [0.0, 0.0]}, "positions"),
        ({"rotations": np.ones((3, 3))}, "rotations"),
        ({"attachments": np.zeros((2, 3))}, "cables"),
    ],
)
def test_platforms_that_mean_nothing_are_refused(changes, where):
    given = {"anchors": [[0.0, 0.0, 5.0]], "attachments": np.zeros((1, 3)), "positions": np.zeros(3)}
    given |= {"rotations": np.eye(3), "normals": np.eye(3), "offsets": np.ones(3)}
    with pytest.raises(InputError) as error:
        platform_overlap(**(given | changes))
    assert error.value.where == where
    with pytest.raises(InputError, match="box"):
        box_faces([0.0, 0.0, 1.0], [1.0, 1.0, 0.0])
