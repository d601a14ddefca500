"""The RCM linkage and the whole robot: closure, the fixed remote centre, four freedoms from either gripper."""

from __future__ import annotations

import math

import numpy as np
import pytest
from climber_cases import Array

from steeplejack.errors import InfeasibleError, InputError
from steeplejack.robots.pipe_climber import load_pipe_climber
from steeplejack.robots.pipe_climber.grippers import End, free_gripper, free_gripper_jacobian, freedoms_of
from steeplejack.robots.pipe_climber.linkage import beta_of, linkage_angles, linkage_closure, linkage_joints

RCM = load_pipe_climber().rcm
ENDS: tuple[End, End] = ("lower", "upper")


def test_links_keep_their_lengths_and_pins_turn_about_the_pipe() -> None:
    beta = np.radians(np.linspace(-80.0, 80.0, 33))
    m1, m2, a1, a2, c1, c2, e3, e4 = np.moveaxis(linkage_joints(RCM, beta), -2, 0)

    def distance(a: Array, b: Array) -> Array:
        return np.linalg.norm(a - b, axis=-1)

    for crank in ((m1, a1), (m2, a2), (m1, c1), (m2, c2)):
        assert distance(*crank) == pytest.approx(RCM.crank)
    for coupler in ((a1, a2), (c1, c2)):
        assert distance(*coupler) == pytest.approx(RCM.coupler)
    for half in ((a1, e3), (e3, a2), (c1, e4), (e4, c2)):
        assert distance(*half) == pytest.approx(0.5 * RCM.coupler)
    assert 0.5 * (e3 + e4) == pytest.approx(np.zeros((33, 2)), abs=1e-17)  # the remote centre does not move
    assert distance(e3, e4) == pytest.approx(2.0 * RCM.crank)
    assert beta_of(RCM, linkage_joints(RCM, beta)) == pytest.approx(beta, abs=1e-15)


def test_loops_close_with_one_freedom_and_two_redundant_conditions() -> None:
    for beta in np.radians([-45.0, -30.0, 0.0, 17.0, 45.0]):
        angles = linkage_angles(RCM, beta)
        assert linkage_closure(RCM, angles) == pytest.approx(np.zeros((3, 2)), abs=1e-16)
        steps = 1e-6 * np.eye(5)
        rows = (linkage_closure(RCM, angles + steps) - linkage_closure(RCM, angles - steps)).reshape(5, 6).T / 2e-6
        sizes = np.linalg.svd(rows)[1]
        assert (sizes > 1e-3).sum() == 4  # 5 angles, 6 conditions, rank 4: mobility 1 and v = 2
        assert rows @ [1.0, 1.0, 0.0, 0.0, 1.0] == pytest.approx(np.zeros(6), abs=1e-9)


def test_off_the_parallelogram_loops_stay_open() -> None:
    assert np.abs(linkage_closure(RCM, [0.3, 0.3, 0.0, 0.0, 0.2])).max() > 1e-3


@pytest.mark.parametrize("beta", [math.pi / 2, -2.0, math.nan])
def test_folded_linkages_are_refused(beta: float) -> None:
    with pytest.raises(InputError, match="within 90 deg"):
        linkage_joints(RCM, beta)


def freedoms(rng: np.random.Generator, count: int) -> Array:
    return rng.uniform([-0.05, 0.1, -0.6, -0.8], [0.05, 0.22, 0.6, 0.8], (count, 4))


@pytest.mark.parametrize("fixed", ENDS)
def test_four_freedoms_there_and_back(fixed: End, rng: np.random.Generator) -> None:
    for given in freedoms(rng, 30):
        pose = free_gripper(given, 0.07, fixed)
        assert freedoms_of(pose, 0.07, fixed) == pytest.approx(given, abs=1e-15)


def test_either_gripper_sees_the_other(rng: np.random.Generator) -> None:
    given = freedoms(rng, 10)
    product = free_gripper(given, 0.07, "lower") @ free_gripper(given, 0.07, "upper")
    assert product == pytest.approx(np.broadcast_to(np.eye(4), product.shape), abs=1e-15)


def test_beta_turns_about_the_fixed_pipe_and_leaves_the_limbs_alone() -> None:
    still, turned = free_gripper([[0.02, 0.16, 0.3, 0.0], [0.02, 0.16, 0.3, 0.5]], 0.07)
    half = np.eye(4)
    half[:2, :2] = [[math.cos(0.5), -math.sin(0.5)], [math.sin(0.5), math.cos(0.5)]]
    assert turned == pytest.approx(half @ still, abs=1e-15)
    assert np.hypot(*turned[:2, 3]) == pytest.approx(np.hypot(*still[:2, 3]))
    assert turned[2] == pytest.approx(still[2])


@pytest.mark.parametrize("fixed", ENDS)
def test_twists_of_the_free_gripper_against_finite_differences(fixed: End, rng: np.random.Generator) -> None:
    given, step = freedoms(rng, 30), 1e-5
    pose, columns = free_gripper(given, 0.07, fixed), free_gripper_jacobian(given, 0.07, fixed)
    for axis in range(4):
        move = step * np.eye(4)[axis]
        rate = (free_gripper(given + move, 0.07, fixed) - free_gripper(given - move, 0.07, fixed)) / (2.0 * step)
        spin = rate[:, :3, :3] @ np.swapaxes(pose[:, :3, :3], -1, -2)
        twist = np.stack((spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0], *rate[:, :3, 3].T), axis=-1)
        assert columns[..., axis] == pytest.approx(twist, abs=1e-9)
    assert (np.linalg.matrix_rank(columns) == 4).all()


def test_a_freedom_that_is_missing_is_named() -> None:
    tilted = np.eye(4)
    tilted[1:3, 1:3] = [[math.cos(0.1), -math.sin(0.1)], [math.sin(0.1), math.cos(0.1)]]
    with pytest.raises(InfeasibleError, match="no such turn"):
        freedoms_of(tilted, 0.0)
    aside = np.eye(4)
    aside[1, 3] = 0.01
    with pytest.raises(InfeasibleError, match="no such travel"):
        freedoms_of(aside, 0.0)


@pytest.mark.parametrize("fixed", ENDS)
def test_what_is_no_rigid_transform_is_refused(fixed: End) -> None:
    larger, huge, mirrored, projective = np.eye(4), np.eye(4), np.diag([1.0, -1.0, 1.0, 1.0]), np.eye(4)
    larger[:3, :3] *= 2.0
    huge[0, 0] = 1e300
    projective[3, 0] = 0.1
    cases = [(larger, "orthonormal"), (huge, "orthonormal"), (mirrored, "mirror"), (projective, "last row")]
    cases += [(np.diag([1.0, 1.0, 1.0, math.nan]), "finite"), (np.eye(3), "shape")]
    for given, named in cases:
        with pytest.raises(InputError, match=named):
            freedoms_of(given, 0.0, fixed)
    with pytest.raises(InputError, match="numbers"):
        freedoms_of([[1.0], [2.0, 3.0]], 0.0, fixed)


def test_freedoms_are_four() -> None:
    with pytest.raises(InputError, match="x, w, alpha, beta"):
        free_gripper([0.0, 0.16, 0.0], 0.0)
