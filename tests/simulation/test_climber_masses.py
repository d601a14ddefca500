"""What drives bear of a move's inertia, against the mass matrix of the robot in physics with its loops closed."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from hung_climber import LAYOUT, ROBOT

from steeplejack.robots.pipe_climber.grippers import free_gripper
from steeplejack.robots.pipe_climber.inertia import inertia
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.simulation.climber.plant import ClimberPlant, Start
from steeplejack.simulation.climber.solids import Solid

STEP, PAYLOAD = 1e-5, 0.8
UPPER = np.array([[0.6, -0.8, 0.0, 0.2], [0.8, 0.6, 0.0, -0.1], [0.0, 0.0, 1.0, 0.4], [0.0, 0.0, 0.0, 1.0]])


def plant_at(freedoms: np.ndarray, end: int, payload: float) -> ClimberPlant:
    """The robot in a pose, its lower or its upper gripper at one place, jaws as on the thickest pipe."""
    lower = UPPER if end == 0 else UPPER @ np.linalg.inv(free_gripper(freedoms, ROBOT.linkage.claw_offset))
    pipe = Solid("pipe", "cylinder", np.array([9.0, 0.0, 0.0]), np.array([9.0, 0.0, 1.0]), 0.03)  # out of the way
    start = Start(lower, freedoms, np.full(2, 0.5 * ROBOT.gripper.pipe_diameter[1]), (True, True))
    return ClimberPlant(ROBOT, LAYOUT, [pipe], np.zeros(3), start, (0.3, 0.3), payload)


def mass_matrix(freedoms: np.ndarray, end: int, payload: float) -> np.ndarray:
    """Of the four freedoms, screws included: every joint's rates follow from those of the freedoms."""
    here = plant_at(freedoms, end, payload)
    model, data = here.model, here.data
    ways, momenta = np.zeros((4, model.nv)), np.zeros((4, model.nv))
    for way, momentum, step in zip(ways, momenta, STEP * np.eye(4), strict=True):
        places = [plant_at(freedoms + sign * step, end, payload).data.qpos for sign in (-1.0, 1.0)]
        mujoco.mj_differentiatePos(model, way, 2.0 * STEP, *places)
        mujoco.mj_mulM(model, data, momentum, way)
    return ways @ momenta.T


@pytest.mark.parametrize("end", [0, 1])
@pytest.mark.parametrize("payload", [0.0, PAYLOAD])
def test_drives_move_the_robot_of_the_physics(end: int, payload: float) -> None:
    for freedoms, rates in (
        ([0.0, 0.16, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]), ([0.012, 0.17, 0.3, 0.4], [0.2, 0.5, -3.0, 8.0]),
        ([-0.01, 0.18, -0.25, -0.3], [-0.3, 0.4, 2.0, -20.0]),
    ):  # fmt: skip
        pose = np.array(freedoms)
        borne = mass_matrix(pose, end, payload) @ rates
        wanted = np.append(np.linalg.solve(jacobian(LAYOUT, pose[:3]).T, borne[:3]), borne[3])
        found = inertia(ROBOT, LAYOUT, pose[None], [rates], end, payload)[1][0]
        np.testing.assert_allclose(found, wanted, atol=1e-6 * np.abs(wanted).max())
