"""A thousand robots nobody would build: forward kinematics gives a right answer, a clear status or one clear line."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import TrackingStatus, forward_kinematics, pulley_runs, track_planar, track_spatial
from steeplejack.spatial import from_vector

pytestmark = pytest.mark.long

KINDS = ("plain", "plain", "pulleys", "coincident anchors", "one point", "one line", "unreachable", "nan", "zero")


def robot(rng, d):
    """Anchors, attachments, lengths, start and pulleys of a random robot, the pose that made the lengths, its kind."""
    kind = str(rng.choice(KINDS))
    scale = 10.0 ** rng.uniform(-9.0, 9.0)
    m = int(rng.integers(3, 9) if d == 2 else rng.integers(6, 11))
    anchors, attachments = rng.uniform(-1.0, 1.0, (m, d)), rng.uniform(-0.3, 0.3, (m, d))
    if kind == "coincident anchors":
        anchors[1 : 1 + m // 2] = anchors[0]
    if kind == "one point":
        attachments[:] = attachments[0]
    if kind == "one line":
        anchors[:, 1:] = attachments[:, 1:] = 0.0
    pulleys = {}
    if kind == "pulleys":
        pulleys = {"radii": scale * rng.uniform(0.0, 0.05, m), "axes": rng.normal(size=(m, d))}
    position = rng.uniform(-0.6, 0.6, d)
    turn = rng.normal(size=3) * 0.5 if d == 3 else np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)])
    lengths = length(scale * anchors, scale * attachments, scale * position, from_vector(turn), pulleys)
    if kind == "unreachable":
        lengths = lengths * rng.uniform(0.2, 3.0, m)
    if kind == "zero":
        lengths[:] = 0.0
    start = np.concatenate((scale * rng.uniform(-0.5, 0.5, d), rng.normal(size=1 if d == 2 else 3)))
    anchors, attachments = scale * anchors, scale * attachments
    if kind == "nan":
        spoilt = (lengths, anchors, attachments, start)[int(rng.integers(4))]
        spoilt.flat[int(rng.integers(spoilt.size))] = rng.choice([np.nan, np.inf])
    return kind, anchors, attachments, lengths, start, pulleys


def length(anchors, attachments, position, rotation, pulleys):
    """Cable lengths by the plainest route there is."""
    d = anchors.shape[1]
    ends = position + attachments @ rotation[:d, :d].T
    if pulleys:
        return pulley_runs(anchors, pulleys["axes"], pulleys["radii"], ends)[0]
    return np.sqrt(np.sum((anchors - ends) ** 2, axis=1))


def others(rng, anchors, attachments, lengths, pulleys):
    """Distances are in the size of the robot: poses that forty random starts of our own reach, and their residuals."""
    d, size = anchors.shape[1], max(np.abs(anchors).max(), lengths.max())
    many, places = np.broadcast_to(lengths, (40, len(lengths))), size * rng.uniform(-1.0, 1.0, (40, d))
    if d == 2:
        found = track_planar(many, anchors, attachments, np.column_stack((places, rng.uniform(-3, 3, 40))), **pulleys)
        turns = np.array([from_vector(np.array([0.0, 0.0, phi])) for phi in found.pose[:, 2]])
        return found.pose[:, :2], turns, found.residual
    turns = np.array([from_vector(turn) for turn in rng.normal(size=(40, 3)) * 1.5])
    found = track_spatial(many, anchors, attachments, places, turns, **pulleys)
    return found.position, found.rotation, found.residual


@pytest.mark.parametrize(("d", "count"), [(2, 850), (3, 150)])
def test_a_right_answer_or_a_clear_no(d, count):
    rng = np.random.default_rng(20 + d)
    seen, unique, refuted = set(), 0, 0
    for _ in range(count):
        kind, anchors, attachments, lengths, start, pulleys = robot(rng, d)
        try:
            answer = forward_kinematics(lengths, anchors, attachments, start, **pulleys)
        except InputError as error:
            assert kind == "nan" and "\n" not in str(error)
            continue
        seen.add((kind, answer.status))
        if not np.isfinite(lengths).all() or kind == "zero":
            assert answer.status is TrackingStatus.UNDEFINED and not answer.unique and np.isnan(answer.residual)
            continue
        assert answer.status is not TrackingStatus.UNDEFINED
        enough, size = 1e-3 * lengths.max(), max(np.abs(anchors).max(), lengths.max())
        again = length(anchors, attachments, answer.position[:d], answer.rotation, pulleys) - lengths
        assert answer.residual == pytest.approx(np.linalg.norm(again), rel=1e-6, abs=1e-12 * size), kind
        np.testing.assert_allclose(answer.rotation @ answer.rotation.T, np.eye(3), atol=1e-12)
        assert (answer.status is TrackingStatus.CONVERGED) <= (answer.residual <= enough)
        if kind in ("one point", "one line"):  # the turn, or the way off the line, is open
            assert not answer.unique, kind
        if kind in ("plain", "pulleys"):
            assert answer.residual <= enough
        if answer.unique:
            unique += 1
            places, turns, residuals = others(rng, anchors, attachments, lengths, pulleys)
            good = residuals <= enough
            gap = np.linalg.norm(places[good] - answer.position[:d], axis=1) / size
            twist = np.linalg.norm(turns[good] - answer.rotation, axis=(1, 2))
            refuted += bool(np.any(np.maximum(gap, twist) > 2e-3))
    assert unique > count // 5
    assert refuted == 0
    assert {kind for kind, _status in seen} >= set(KINDS) - {"nan"}
