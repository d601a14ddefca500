"""Spatial equilibria of a platform on four cables against the potential energy, finite differences and an LP."""

import numpy as np
import pytest
from scipy.optimize import linprog

from steeplejack.mechanics.cable.rest import statics
from steeplejack.robots.squad import suspension
from steeplejack.spatial import from_vector

ATTACHMENTS = np.array([[-0.1, -0.09, 0.01], [0.11, -0.1, -0.02], [0.09, 0.1, 0.0], [-0.1, 0.12, 0.015]])
CENTRE = np.array([0.01, -0.02, -0.03])
WEIGHT = np.array([3.0, -5.0, -170.0])
NO_PULL = np.empty((0, 4, 4))
HELD = (0, 1, 2, 11)  # seeds of cases held within tension limits


def case(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Asymmetric anchors about a rotated frame, a position inside them and a frame to start from."""
    frame = from_vector(rng.normal(size=3) * 0.4) @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    local = np.array([[-9.0, -6, 0], [10, -8, 0.3], [12, 15, -0.2], [-7, 18, 0.1]]) + rng.normal(size=(4, 3)) * [
        2,
        2,
        0.2,
    ]
    position = frame @ np.array([rng.uniform(-3, 3), rng.uniform(0, 5), rng.uniform(-0.9, -0.3)])
    return local @ frame.T, position, frame


def potential(
    anchors: np.ndarray, position: np.ndarray, rotation: np.ndarray, unstretched: np.ndarray, ea: float
) -> float:
    ends = position + ATTACHMENTS @ rotation.T
    lengths = np.linalg.norm(anchors - ends, axis=1)
    stretch = np.maximum(lengths - unstretched, 0.0)
    return float(np.sum(0.5 * ea / unstretched * stretch**2) - WEIGHT @ (position + rotation @ CENTRE))


def equilibrium(seed: int):
    rng = np.random.default_rng(seed)
    anchors, position, frame = case(rng)
    rotation, tensions, room = suspension.hang(
        anchors,
        ATTACHMENTS,
        WEIGHT,
        CENTRE,
        position,
        frame,
        np.full(4, 5.0),
        NO_PULL,
        np.full(4, 600.0),
        np.full(4, 150.0),
    )
    return anchors, position, rotation, tensions, room


@pytest.mark.parametrize("seed", range(12))
def test_forces_and_moments_balance(seed: int) -> None:
    anchors, position, rotation, tensions, _room = equilibrium(seed)
    ends = position + ATTACHMENTS @ rotation.T
    u = (anchors - ends) / np.linalg.norm(anchors - ends, axis=1)[:, None]
    forces = tensions[:, None] * u
    moment = np.cross(ATTACHMENTS @ rotation.T, forces).sum(axis=0) + np.cross(rotation @ CENTRE, WEIGHT)
    scale = np.abs(tensions).max()
    assert np.abs(forces.sum(axis=0) + WEIGHT).max() < 1e-9 * scale
    assert np.abs(moment).max() < 1e-8 * scale
    directions, _lengths = statics.directions(anchors, ATTACHMENTS, position, rotation)
    left = statics.residual(ATTACHMENTS, WEIGHT, CENTRE, rotation, directions, tensions)
    assert np.abs(left).max() < 1e-8 * scale


@pytest.mark.parametrize("seed", HELD)
def test_hessian_is_the_second_derivative_of_the_energy(seed: int) -> None:
    anchors, position, rotation, tensions, room = equilibrium(seed)
    assert room > 0.0
    ea = 2e5
    u, lengths = statics.directions(anchors, ATTACHMENTS, position, rotation)
    unstretched = lengths / (1.0 + tensions / ea)
    hessian = statics.stiffness(ATTACHMENTS, WEIGHT, CENTRE, rotation, u, lengths, tensions, ea / unstretched)

    def energy(x: np.ndarray) -> float:
        return potential(anchors, position + x[3:], from_vector(x[:3].copy()) @ rotation, unstretched, ea)

    h, unit = 1e-4, np.eye(6)
    numeric = np.array(
        [
            [
                sum(a * b * energy(h * (a * unit[i] + b * unit[j])) for a in (1, -1) for b in (1, -1)) / (4 * h * h)
                for j in range(6)
            ]
            for i in range(6)
        ]
    )
    assert np.abs(hessian - numeric).max() < 2e-4 * np.abs(hessian).max()
    assert np.allclose(hessian, hessian.T)
    assert (statics.least_pivot(hessian) > 0.0) == bool(np.linalg.eigvalsh(hessian)[0] > 0.0)


def test_room_agrees_with_an_lp() -> None:
    """At the equilibrium's orientation, the interval of lambda is open exactly when an LP finds tensions in bounds."""
    rng = np.random.default_rng(7)
    seen = set()
    for _ in range(300):
        anchors, position, frame = case(rng)
        position = position + frame @ np.array([0, 0, rng.uniform(-1, 0.4)])
        u, _lengths = statics.directions(anchors, ATTACHMENTS, position, frame)
        particular, null, independent = suspension.force_family(u, WEIGHT)
        assert independent
        assert np.abs(u.T @ particular + WEIGHT).max() < 1e-8 * np.abs(particular).max()
        assert np.abs(u.T @ null).max() < 1e-10
        assert abs(particular @ null) < 1e-8 * np.abs(particular).max()
        low, high, _a, _b = suspension.interval(particular, null, np.full(4, 20.0), np.full(4, 250.0))
        answer = linprog(np.zeros(4), A_eq=u.T, b_eq=-WEIGHT, bounds=[(20.0, 250.0)] * 4)
        if abs(high - low) > 1e-3:
            assert (high >= low) == (answer.status == 0)
            seen.add(bool(high >= low))
    assert seen == {True, False}


def test_pull_limits_bound_the_tensions() -> None:
    anchors, position, rotation, _tensions, _room = equilibrium(1)
    direction = np.array([0.6, 0.0, 0.8])
    pull = np.empty((1, 4, 4))
    pull[0, :, :3], pull[0, :, 3] = direction, 100.0
    u, _lengths = statics.directions(anchors, ATTACHMENTS, position, rotation)
    bound, which = suspension.upper_bounds(u, pull, np.full(4, 400.0))
    share = np.abs(u @ direction)
    assert np.allclose(bound, np.minimum(400.0, 100.0 / share))
    assert ((which == 0) == (100.0 / share < 400.0)).all()


def test_cables_in_one_plane_do_not_hold_a_force_across_it() -> None:
    u = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0.6, -0.8, 0]])
    _particular, _null, independent = suspension.force_family(u, WEIGHT)
    assert not independent
