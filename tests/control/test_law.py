"""The control law: passive at the winches, bounded, exact where the bounds allow."""

import numpy as np
import pytest

from steeplejack.control import allocation, estimator
from steeplejack.control.law import law, least_squares
from steeplejack.mechanics.cable.rest import statics
from steeplejack.robots.squad import suspension
from steeplejack.robots.squad.in_plane import plane_matrix
from steeplejack.spatial import from_vector

ATTACHMENTS = np.array([[-0.095, -0.095, 0.0], [0.095, -0.095, 0.0], [0.095, 0.095, 0.0], [-0.095, 0.095, 0.0]])
WEIGHT = np.array([0.0, 0.0, -173.6])
GAINS = np.array([1000.0, 300.0, 10.0, 3.0, 1600.0, 200.0, 9.0, 2.0, 10.8])
WINDOW = np.array([20.0, 250.0, 245.25, 147.15])


def pose(seed: int):
    """A hanging platform on asymmetric anchors, with the tensions that hold it."""
    rng = np.random.default_rng(seed)
    frame = from_vector(rng.normal(size=3) * 0.3) @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    anchors = np.array([[-9.0, -6, 0.1], [10, -8, 0.3], [12, 18, -0.2], [-8, 15, 0.1]]) + rng.normal(size=(4, 3)) * 0.3
    position = frame @ np.array([rng.uniform(-2, 2), rng.uniform(1, 4), -0.6])
    rotation, tensions, _room = suspension.hang(
        anchors @ frame.T, ATTACHMENTS, WEIGHT, np.zeros(3), position, frame, np.full(4, 20.0), np.empty((0, 4, 4)),
        np.full(4, 250.0), np.full(4, 110.0),
    )  # fmt: skip
    return anchors @ frame.T, position, rotation, tensions


def command(seed: int, lengths_off: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Change of winch pull for cable lengths off the reference and rates, friction compensation aside."""
    anchors, position, rotation, planned = pose(seed)
    _u, lengths = statics.directions(anchors, ATTACHMENTS, position, rotation)
    tangents = np.tile([0.6, 0.0, 0.8], (4, 1))
    pull, _drive, _turn, status = law(
        anchors, tangents, ATTACHMENTS, lengths + lengths_off, rates, position, rotation, np.zeros(3), np.zeros(3),
        planned, np.zeros((8, 4)), planned, np.zeros(4, bool), 17.7, GAINS, np.array([-1e9, 1e9, 1e12, 1e12]),
    )  # fmt: skip
    assert status == allocation.EXACT
    return pull - planned, planned


@pytest.mark.parametrize("seed", range(6))
def test_at_the_reference_the_planned_tensions_are_commanded(seed: int) -> None:
    change, _planned = command(seed, np.zeros(4), np.zeros(4))
    assert np.abs(change).max() < 1e-6


@pytest.mark.parametrize("seed", range(6))
def test_winches_see_a_passive_spring_and_damper(seed: int) -> None:
    """Pull over length is symmetric and positive semidefinite: longer cables are pulled harder, never pushed."""
    unit = 1e-4 * np.eye(4)
    spring = np.array([command(seed, row, np.zeros(4))[0] for row in unit]).T / 1e-4
    damper = np.array([command(seed, np.zeros(4), row)[0] for row in unit]).T / 1e-4
    for matrix in (spring, damper):
        assert np.abs(matrix - matrix.T).max() < 1e-6 * np.abs(matrix).max()
        values = np.linalg.eigvalsh(matrix)
        assert values[0] > -1e-6 * values[-1]
        assert values[-1] > 0.0


def test_least_squares_inverts_the_plane_matrix() -> None:
    anchors, position, rotation, _planned = pose(3)
    u, _lengths = statics.directions(anchors, ATTACHMENTS, position, rotation)
    matrix, _scale = plane_matrix(u, rotation, ATTACHMENTS)
    wanted = np.array([0.3, -0.2, 0.05])
    assert np.allclose(least_squares(matrix, matrix @ wanted), wanted, rtol=1e-9)


def test_allocation_is_exact_within_bounds_and_says_when_not() -> None:
    rng = np.random.default_rng(0)
    seen = set()
    for seed in range(40):
        anchors, position, rotation, planned = pose(seed % 8)
        u, _lengths = statics.directions(anchors, ATTACHMENTS, position, rotation)
        matrix, _scale = plane_matrix(u, rotation, ATTACHMENTS)
        wrench = rng.normal(size=3) * 10.0 ** rng.uniform(0, 2.5)
        tensions, status = allocation.allocate(matrix, wrench, planned, np.full(4, 15.0), np.full(4, 255.0))
        assert (tensions >= 15.0 - 1e-9).all()
        assert (tensions <= 255.0 + 1e-9).all()
        if status == allocation.EXACT:
            assert np.allclose(matrix.T @ (tensions - planned), wrench, atol=1e-8 * np.abs(wrench).max())
        if status == allocation.SCALED:
            got = matrix.T @ (tensions - planned)
            assert np.allclose(np.cross(got, wrench), 0.0, atol=1e-6 * wrench @ wrench)
        seen.add(status)
    assert {allocation.EXACT, allocation.SCALED} <= seen


@pytest.mark.parametrize("seed", range(6))
def test_estimate_finds_the_pose_from_lengths_and_tensions(seed: int) -> None:
    """Started 3 cm and 3 deg off, with exact measurements, a few steps find the equilibrium."""
    anchors, position, rotation, tensions = pose(seed)
    _u, lengths = statics.directions(anchors, ATTACHMENTS, position, rotation)
    rng = np.random.default_rng(seed)
    guess = position + rng.normal(size=3) * 0.03
    turned = from_vector(rng.normal(size=3) * 0.05) @ rotation
    for _ in range(30):
        guess, turned, speed, left = estimator.estimate(
            guess, turned, anchors, np.zeros((4, 3)), ATTACHMENTS, lengths, np.zeros(4), tensions, WEIGHT, np.zeros(3),
            np.array([0.003, 5.0, 0.5]),
        )  # fmt: skip
    assert np.linalg.norm(guess - position) < 1e-6
    assert np.abs(turned - rotation).max() < 1e-6
    assert np.abs(speed).max() < 1e-9
    assert left < 1e-7


def test_observer_settles_on_the_tension_and_ignores_rotor_inertia() -> None:
    """A rotor accelerated by a constant surplus: the observed tension is the cable's, not the motor's."""
    friction, mass, tau = 2.0, 10.8, 0.01
    constants = np.array([friction, mass, tau, 1.0, 2e5])
    tension, motor, rate, dt = 120.0, 100.0, 0.05, 1e-3
    momentum, offset = np.full(4, 110.0), np.zeros(4)
    for _ in range(400):
        rate += dt * (tension - motor - friction) / mass
        seen, momentum, offset, *_rest = estimator.observe(
            np.full(4, motor), np.full(4, rate), np.full(4, 20.0), np.full(4, 110.0), momentum, offset, constants, dt
        )
    assert np.allclose(seen, tension, atol=0.2)
