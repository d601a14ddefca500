"""Static forces of the pipe climber: virtual work, published loads, preload, and the grip."""

from __future__ import annotations

import math

import numpy as np
import pytest
from climber_cases import CONVENTIONS, LAYOUTS, REFERENCE, layout, named, poses
from scipy.optimize import linprog

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber import Layout, load_pipe_climber
from steeplejack.robots.pipe_climber.inverse import limb_vectors
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.singularity import singular_x
from steeplejack.robots.pipe_climber.statics import actuator_forces, friction_needed, grip_margin, largest_load

CASE = REFERENCE["load"]
GRIPPER = load_pipe_climber().gripper


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_the_reference_axial_load(convention: str) -> None:
    found = largest_load(layout(convention), CASE["pose"], [0.0, -1.0, 0.0], CASE["actuator"])
    assert float(found.size) == pytest.approx(CASE["axial"][convention], abs=5e-4)
    assert np.abs(found.forces).max() == pytest.approx(CASE["actuator"])


@pytest.mark.parametrize("mechanism", LAYOUTS, ids=named)
def test_forces_along_the_limbs_balance_the_wrench(mechanism: Layout, rng: np.random.Generator) -> None:
    """Newton's and Euler's equations of the platform, without the Jacobian."""
    pose, wrench = poses(rng, 50), rng.normal(size=(50, 3)) * [20.0, 20.0, 1.0]
    forces = actuator_forces(mechanism, pose, wrench)
    vectors = limb_vectors(mechanism, pose)
    pushes = forces[..., None] * vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    assert pushes.sum(axis=1) + wrench[:, :2] == pytest.approx(np.zeros((50, 2)), abs=1e-9)
    arms = vectors + np.stack((mechanism.base, np.zeros(3)), axis=-1) - pose[:, None, :2]
    moments = arms[..., 1] * pushes[..., 0] - arms[..., 0] * pushes[..., 1]
    assert moments.sum(axis=1) + wrench[:, 2] == pytest.approx(np.zeros(50), abs=1e-9)


def test_largest_load_against_a_linear_program(rng: np.random.Generator) -> None:
    for pose, direction in zip(poses(rng, 20), rng.normal(size=(20, 3)) * [1.0, 1.0, 0.05], strict=True):
        preload = np.array([0.0, -2.0 * 9.81 / 2.0, 0.0])
        found = largest_load(layout(), pose, direction, 50.0, preload)
        # Unknowns f and the multiple: maximise it with J^T f + multiple * direction = -preload.
        rows = np.column_stack((jacobian(layout(), pose).T, direction))
        bounds = [(-50.0, 50.0)] * 3 + [(0.0, None)]
        best = linprog([0.0, 0.0, 0.0, -1.0], A_eq=rows, b_eq=-preload, bounds=bounds)
        assert float(found.size) == pytest.approx(-best.fun, rel=1e-7)
        assert abs(found.forces[int(found.limb) - 1]) == pytest.approx(50.0)


def test_what_cannot_be_held_says_so() -> None:
    nothing = largest_load(layout(), [0.0, 0.16, 0.0], [0.0, -1.0, 0.0], 50.0, preload=[0.0, -80.0, 0.0])
    assert math.isnan(nothing.size)
    assert int(nothing.limb) == 0
    singular = [float(singular_x(layout(), 0.15, -0.9)), 0.15, -0.9]
    assert np.isnan(actuator_forces(layout(), singular, [0.0, -10.0, 0.0])).all()
    assert math.isnan(largest_load(layout(), singular, [0.0, -1.0, 0.0], 50.0).size)
    for limit in (0.0, math.nan):
        with pytest.raises(InputError, match="limit"):
            largest_load(layout(), [0.0, 0.16, 0.0], [0.0, -1.0, 0.0], limit)
    with pytest.raises(InputError, match="zeros"):
        largest_load(layout(), [0.0, 0.16, 0.0], [0.0, 0.0, 0.0], 50.0)


def test_friction_for_hanging_2_kg() -> None:
    assert friction_needed(GRIPPER, 2.0 * 9.81) == pytest.approx(CASE["friction_for_2_kg"], abs=5e-6)
    assert grip_margin(GRIPPER, 2.0 * 9.81) == pytest.approx(1.0 - 0.24525 / GRIPPER.friction)
    assert grip_margin(GRIPPER, 30.0) < 0.0


def test_a_torque_about_the_pipe_needs_friction_too() -> None:
    assert friction_needed(GRIPPER, 3.0, 0.16, 0.04) == pytest.approx(5.0 / 80.0)
    assert friction_needed(GRIPPER, 3.0, 0.0, 0.04) == friction_needed(GRIPPER, 3.0)


def test_loads_a_grip_cannot_be_asked_about() -> None:
    with pytest.raises(InputError, match=r"radius: none with a torque of 5 N m"):
        grip_margin(GRIPPER, 10.0, torque=5.0)
    for radius in (0.0, -0.03, math.inf, math.nan):
        with pytest.raises(InputError, match="radius"):
            grip_margin(GRIPPER, 10.0, 5.0, radius)
    for axial, torque in ((math.nan, 0.0), (math.inf, 0.0), (10.0, math.nan)):
        with pytest.raises(InputError, match="load of the grip"):
            friction_needed(GRIPPER, axial, torque, 0.03)
