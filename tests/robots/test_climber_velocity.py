"""Velocity and acceleration of the pipe climber: closed form, screws, finite differences and MuJoCo's closed loops."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from climber_cases import LAYOUTS, Array, layout, named, poses
from climber_physics import closed_loops, configuration, coordinates

from steeplejack.robots.pipe_climber import Layout
from steeplejack.robots.pipe_climber.inverse import hinge_angles, limb_lengths
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.joints import joint_accelerations, joint_rates
from steeplejack.robots.pipe_climber.screws import (
    joint_influence,
    joint_twists,
    link_accelerations,
    link_twists,
    platform_twist,
    screw_jacobian,
    screw_joint_accelerations,
    screw_joint_rates,
    transmission_wrenches,
)
from steeplejack.robots.pipe_climber.singularity import singular_x

STEP = 2e-3  # of the seven-point differences below, of order 6


def moving(rng: np.random.Generator, count: int) -> tuple[Array, Array, Array]:
    """Poses with velocities and accelerations."""
    size = np.array([0.1, 0.1, 1.0])
    return poses(rng, count), rng.normal(size=(count, 3)) * size, rng.normal(size=(count, 3)) * size


def slope(values: Array, step: float) -> Array:
    """First derivative from seven values at equal steps along the first axis."""
    return np.tensordot([-1, 9, -45, 0, 45, -9, 1], values, 1) / (60 * step)


def bend(values: Array, step: float) -> Array:
    """Second derivative from the same."""
    return np.tensordot([2, -27, 270, -490, 270, -27, 2], values, 1) / (180 * step**2)


def joints_along(mechanism: Layout, pose: Array, rate: Array, second: Array) -> Array:
    """Joint coordinates at seven moments of ``pose + rate t + second t^2 / 2``, (7, n, 3 limbs, 3 joints)."""
    times = STEP * np.arange(-3, 4)[:, None, None]
    path = pose + rate * times + 0.5 * second * times**2
    ends = hinge_angles(mechanism, path)
    return np.stack((ends[..., 0], limb_lengths(mechanism, path), -ends[..., 1]), axis=-1)


@pytest.mark.parametrize("mechanism", LAYOUTS, ids=named)
def test_jacobian_against_finite_differences_and_screws(mechanism: Layout, rng: np.random.Generator) -> None:
    pose = poses(rng, 100)
    rows = jacobian(mechanism, pose)
    scale = np.array([2e-4, 2e-4, 2e-3])
    for axis in range(3):
        steps = np.arange(-3, 4)[:, None, None] * scale[axis] * np.eye(3)[axis]
        assert slope(limb_lengths(mechanism, pose + steps), scale[axis]) == pytest.approx(rows[..., axis], abs=1e-10)
    assert screw_jacobian(mechanism, pose) == pytest.approx(rows, abs=1e-15)


@pytest.mark.parametrize("mechanism", LAYOUTS, ids=named)
def test_every_joint_against_finite_differences(mechanism: Layout, rng: np.random.Generator) -> None:
    pose, rate, second = moving(rng, 100)
    path = joints_along(mechanism, pose, rate, second)
    rates, seconds = joint_rates(mechanism, pose, rate), joint_accelerations(mechanism, pose, rate, second)
    assert np.abs(slope(path, STEP) - rates).max() < 1e-8 * np.abs(rates).max()
    assert np.abs(bend(path, STEP) - seconds).max() < 1e-6 * np.abs(seconds).max()
    assert (jacobian(mechanism, pose) @ rate[..., None])[..., 0] == pytest.approx(rates[..., 1], abs=1e-15)


@pytest.mark.parametrize("mechanism", LAYOUTS, ids=named)
def test_screws_and_closed_form_agree(mechanism: Layout, rng: np.random.Generator) -> None:
    pose, rate, second = moving(rng, 100)
    assert screw_joint_rates(mechanism, pose, rate) == pytest.approx(joint_rates(mechanism, pose, rate), abs=1e-12)
    by_screws = screw_joint_accelerations(mechanism, pose, rate, second)
    assert by_screws == pytest.approx(joint_accelerations(mechanism, pose, rate, second), abs=1e-11)


@pytest.mark.parametrize("mechanism", LAYOUTS[:2], ids=named)
def test_mujoco_closed_loops_at_100_poses(mechanism: Layout, rng: np.random.Generator) -> None:
    """Positions, velocities and accelerations of both sides of every pin agree in the engine's own terms."""
    model = closed_loops(mechanism)
    data = mujoco.MjData(model)
    for pose, rate, second in zip(*moving(rng, 100), strict=True):
        data.qpos[:] = configuration(mechanism, pose)
        data.qvel[:] = coordinates(joint_rates(mechanism, pose, rate), rate)
        mujoco.mj_forward(model, data)
        assert np.abs(data.efc_pos).max() < 1e-14
        assert np.abs(data.efc_vel).max() < 1e-13
        data.qacc[:] = coordinates(joint_accelerations(mechanism, pose, rate, second), second)
        mujoco.mj_rnePostConstraint(model, data)
        for limb in range(3):
            rod, pin = (linear_acceleration(model, data, f"{side}{limb}") for side in ("rod", "pin"))
            assert rod == pytest.approx(pin, abs=1e-11)


def linear_acceleration(model: mujoco.MjModel, data: mujoco.MjData, body: str) -> Array:
    """Of a body's origin in the world [m/s2]."""
    found = np.zeros(6)
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, body)
    mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_XBODY, number, found, 0)
    return found[3:]


@pytest.mark.parametrize("mechanism", LAYOUTS[:2], ids=named)
def test_mujoco_jacobian_of_the_closed_loops(mechanism: Layout, rng: np.random.Generator) -> None:
    """The engine's constraint rows, solved for the limbs, are J."""
    model = closed_loops(mechanism)
    data = mujoco.MjData(model)
    for pose in poses(rng, 100):
        data.qpos[:] = configuration(mechanism, pose)
        mujoco.mj_forward(model, data)
        rows = np.zeros((data.nefc, model.nv))
        rows[:] = data.efc_J.reshape(data.nefc, model.nv)
        limbs, _, _, _ = np.linalg.lstsq(rows[:, :6], -rows[:, 6:], rcond=None)
        assert limbs[1::2] == pytest.approx(jacobian(mechanism, pose), abs=1e-12)


def test_the_corrected_equations_of_the_paper(rng: np.random.Generator) -> None:
    mechanism = layout()
    pose, rate, second = moving(rng, 20)
    twists, wrenches = joint_twists(mechanism, pose), transmission_wrenches(mechanism, pose)
    powers = np.einsum("...ijk,...ik->...ij", twists, wrenches)
    # Eq. 18: on the actuated joint the wrench does unit power, on the printed S_i1 none.
    assert powers == pytest.approx(np.broadcast_to([0.0, 1.0, 0.0], powers.shape), abs=1e-15)
    # Eq. 15: the three limbs add up to one platform twist.
    last = link_twists(mechanism, pose, rate)[..., -1, :]
    assert last == pytest.approx(np.broadcast_to(platform_twist(pose, rate)[:, None], last.shape), abs=1e-14)
    # Eq. 19-20: influence matrices give every joint's rate from the actuators'.
    speeds = jacobian(mechanism, pose) @ rate[..., None]
    influence = joint_influence(mechanism, pose)
    assert (influence @ speeds[:, None])[..., 0] == pytest.approx(joint_rates(mechanism, pose, rate), abs=1e-12)
    assert influence[:, :, 1, :] == pytest.approx(np.broadcast_to(np.eye(3), (20, 3, 3)), abs=1e-13)
    # Eq. 23-26: the three limbs add up to one acceleration, that of a point at O1 less omega x v.
    ends = link_accelerations(mechanism, pose, rate, second)[..., -1, :]
    assert ends == pytest.approx(np.broadcast_to(ends[:, :1], ends.shape), abs=1e-13)
    step = 1e-4
    ahead, behind = (
        platform_twist(pose + sign * step * rate + 0.5 * step**2 * second, rate + sign * step * second)
        for sign in (1.0, -1.0)
    )
    # The twist at a fixed point differentiates to (omega'; a - omega x v) exactly.
    assert (ahead - behind) / (2.0 * step) == pytest.approx(ends[:, 0], abs=1e-6)


def test_influence_is_unknown_at_a_singular_pose() -> None:
    x = float(singular_x(layout(), 0.15, -0.9))
    assert np.isnan(joint_influence(layout(), [x, 0.15, -0.9])).all()
    assert np.isfinite(joint_influence(layout(), [0.0, 0.16, 0.0])).all()


def test_a_limb_of_no_length_has_no_derivative() -> None:
    assert np.isnan(jacobian(layout(), [-0.075, 0.0, 0.3])[1]).all()
    assert np.isnan(joint_rates(layout(), [-0.075, 0.0, 0.3], [0.0, 1.0, 0.0])[1, 0])


def test_one_row_for_many(rng: np.random.Generator) -> None:
    pose, rate, second = moving(rng, 4)
    assert joint_accelerations(layout(), pose, rate[0], second[0]).shape == (4, 3, 3)
    assert jacobian(layout(), pose.reshape(2, 2, 3)).shape == (2, 2, 3, 3)
    assert math.isnan(jacobian(layout(), [math.nan, 0.1, 0.0])[0, 0])
