"""The climber's MuJoCo model: masses, closed loops, grips that neither creep nor hold what they cannot, forces."""

from __future__ import annotations

import numpy as np
import pytest
from hung_climber import GRAVITY, LAYOUT, ROBOT, hung

from steeplejack.control.climber import Command
from steeplejack.control.climber.jaws import open_place
from steeplejack.planning.climb.plan import Pose
from steeplejack.robots.pipe_climber.bearing import holding_forces
from steeplejack.robots.pipe_climber.grippers import free_gripper, freedoms_of
from steeplejack.robots.pipe_climber.inverse import limb_vectors
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.pads import pad_row
from steeplejack.robots.pipe_climber.statics import actuator_forces
from steeplejack.robots.pipe_climber.weights import BODY_SHARE, linkage_mass
from steeplejack.simulation.climber.pipe import frame_at, solids_of
from steeplejack.simulation.climber.plant import ClimberPlant, Start
from steeplejack.simulation.climber.solids import Solid
from steeplejack.worksite.pipe_builtin import load_pipe

TILTED: Pose = (0.015, 0.175, 0.12, 0.2)


def test_masses_are_the_robot_files() -> None:
    model = hung((True, True)).model
    assert model.body_mass.sum() == pytest.approx(ROBOT.body.mass, abs=1e-9)
    bars = sum(float(model.body(name).mass[0]) for name in ("G1", "G2", "G3", "G4"))
    assert bars == pytest.approx(linkage_mass(ROBOT))
    for i in (1, 2, 3):
        limb = float(model.body(f"cylinder{i}").mass[0] + model.body(f"rod{i}").mass[0])
        assert limb == pytest.approx(ROBOT.cylinders.mass)


def test_parts_heavier_than_the_robot_are_refused() -> None:
    from msgspec.structs import replace

    from steeplejack.errors import InputError

    heavy = replace(ROBOT, build=replace(ROBOT.build, gripper_mass=0.9))
    with pytest.raises(InputError, match="linkage"):
        linkage_mass(heavy)


@pytest.mark.parametrize("pose", [(0.0, 0.16, 0.0, 0.0), TILTED, (-0.02, 0.15, -0.1, -0.4)])
def test_loops_close_where_the_kinematics_put_them(pose: Pose) -> None:
    plant = hung((True, True), pose)
    truth = plant.truth()
    upper = np.linalg.solve(truth.lower, truth.upper)
    assert np.allclose(upper, free_gripper(pose, ROBOT.linkage.claw_offset), atol=1e-9)
    closures = plant.data.efc_pos[plant.data.efc_type == 0]
    assert np.abs(closures).max() < 1e-9


@pytest.mark.parametrize("closed", [(True, False), (False, True)])
def test_a_loaded_grip_creeps_less_than_a_tenth_of_a_millimetre_a_minute(closed: tuple[bool, bool]) -> None:
    plant = hung(closed)
    held = closed.index(True)
    plant.advance(1500)  # the load settles into the pads
    before = (plant.truth().lower, plant.truth().upper)[held][2, 3]
    plant.advance(2000)
    after = (plant.truth().lower, plant.truth().upper)[held][2, 3]
    assert abs(after - before) * 60.0 < 1e-4
    assert plant.truth().wrench[held, 5] == pytest.approx(ROBOT.body.mass * 9.81, rel=0.02)
    assert plant.truth().normal[held] == pytest.approx(2 * ROBOT.gripper.force, rel=0.05)


def test_a_gripper_slips_below_the_friction_that_statics_ask_for() -> None:
    """2 kg on two jaws of 40 N need 0.24525 (`robots.pipe_climber.statics.friction_needed`)."""
    fallen = []
    for mu in (0.235, 0.26):
        plant = hung((False, True), mu=mu)
        plant.advance(800)
        fallen.append(-plant.measure().passed[1, 0])
    assert fallen[0] > 2e-3
    assert fallen[1] < 5e-4


def _weight(pose: np.ndarray) -> float:
    """Potential energy of what the limbs carry and of the limbs themselves, the lower platform upright [J]."""
    _x, w, alpha = pose
    build, cylinder = ROBOT.build, ROBOT.cylinders
    body = cylinder.reach[0] - 0.005
    back, grip = float(LAYOUT.platform[2]), build.gripper_mass - 2.0 * build.jaw_mass
    moment = build.plate_mass * 0.5 * back - 0.03 * grip  # of masses beside O2 along the platform's x axis
    lift = 0.01 * grip
    energy = (build.plate_mass + build.gripper_mass) * w - moment * np.sin(alpha) + lift * np.cos(alpha)
    vectors = limb_vectors(LAYOUT, pose)
    for vector in vectors:
        length = np.hypot(*vector)
        middle = BODY_SHARE * 0.5 * body + (1.0 - BODY_SHARE) * (length - 0.5 * body)
        energy += cylinder.mass * middle * vector[1] / length
    return 9.81 * float(energy)


def _wrench(pose: np.ndarray) -> np.ndarray:
    steps = 1e-6 * np.eye(3)
    return -np.array([(_weight(pose + step) - _weight(pose - step)) / 2e-6 for step in steps])


@pytest.mark.parametrize("pose", [(0.0, 0.16, 0.0), (0.0, 0.195, 0.0), TILTED[:3], (-0.02, 0.18, -0.15)])
def test_forces_at_slow_speed_are_those_of_the_static_jacobian(pose: tuple[float, float, float]) -> None:
    """The platform is moved at 2 mm/s with the lower gripper on the pipe; J^T f balances the weight within 5 %."""
    plant = hung((True, False), (*pose, 0.0), mu=1.0, top=0.06)
    plant.apply(Command(np.zeros(3), 0.0, np.array([True, False]), np.full(2, open_place(ROBOT, 0.03))))
    plant.advance(200)
    speeds = jacobian(LAYOUT, pose)[:, 1] * 2e-3
    plant.apply(Command(speeds, 0.0, np.array([True, False]), np.full(2, open_place(ROBOT, 0.03))))
    plant.advance(800)
    truth = plant.truth()
    upper = np.linalg.solve(truth.lower, truth.upper)
    at = np.array([upper[0, 3], upper[2, 3], np.arctan2(-upper[2, 0], upper[2, 2])])
    assert at[1] - pose[1] == pytest.approx(8e-4, rel=0.1)
    expected = actuator_forces(LAYOUT, at, _wrench(at))
    assert np.abs(truth.forces - expected).max() < 0.05 * np.abs(expected).max()


def test_gravity_may_come_from_anywhere() -> None:
    pipe = Solid("pipe", "cylinder", np.array([0.0, 0.0, -0.5]), np.array([0.0, 0.0, 2.0]), 0.03)
    start = Start(np.eye(4), np.array([0.0, 0.16, 0.0, 0.0]), np.full(2, 0.03), (True, True))
    for direction in np.eye(3):
        plant = ClimberPlant(ROBOT, LAYOUT, [pipe], 9.81 * direction, start, (0.3, 0.3))
        before = plant.truth().lower[:3, 3]
        plant.advance(600)
        assert np.linalg.norm(plant.truth().lower[:3, 3] - before) < 2e-4
    assert np.linalg.norm(GRAVITY) == pytest.approx(9.81)


def test_a_cylinder_gives_no_more_than_its_force() -> None:
    plant = hung((True, True), mu=1.0)
    opening = np.full(2, open_place(ROBOT, 0.03))
    plant.apply(Command(np.full(3, ROBOT.cylinders.speed), 0.0, np.array([True, True]), opening))
    plant.advance(400)  # pushes against two closed grippers
    assert plant.strongest() <= ROBOT.cylinders.force * (1.0 + 1e-9)


@pytest.mark.parametrize("end", [0, 1])
@pytest.mark.parametrize("w", [0.16, 0.19])
def test_either_gripper_alone_makes_the_forces_that_are_handed_over(end: int, w: float) -> None:
    """At 2 mm/s, one gripper on the pipe and the other open about it: `control.climber.load` within 5 %."""
    closed = np.array([end == 0, end == 1])
    plant, opening = hung((end == 0, end == 1), (0.0, w, 0.0, 0.0), mu=1.0), np.full(2, open_place(ROBOT, 0.03))
    plant.apply(Command(jacobian(LAYOUT, (0.0, w, 0.0))[:, 1] * 2e-3, 0.0, closed, opening))
    plant.advance(800)
    expected = holding_forces(ROBOT, LAYOUT, np.array([0.0, w + 8e-4, 0.0, 0.0]), GRAVITY)[end]
    assert np.abs(plant.truth().forces - expected).max() < 0.05 * np.abs(expected).max()


@pytest.mark.parametrize("s", [0.28, 0.60])
@pytest.mark.parametrize("end", [0, 1])
def test_either_gripper_alone_makes_those_forces_in_a_bend(s: float, end: int) -> None:
    """Where the bend begins and in its middle, the upper gripper 150 mm on: tilted, and gravity across the robot."""
    run, row = load_pipe("bend-300"), pad_row(ROBOT)
    pipe = run.pipes[0]
    lower, upper = frame_at(pipe, s, 0.0, row), frame_at(pipe, s + 0.15, 0.0, row)
    pose = freedoms_of(np.linalg.solve(lower, upper), ROBOT.linkage.claw_offset, tolerance=1e-4)
    closed, opening = np.array([end == 0, end == 1]), np.full(2, open_place(ROBOT, 0.03))
    start = Start(lower, pose, np.full(2, 0.03), (end == 0, end == 1))
    plant = ClimberPlant(ROBOT, LAYOUT, solids_of(run), GRAVITY, start, (1.5, 1.5))
    along = np.array([np.sin(pose[2]), np.cos(pose[2]), 0.0])
    plant.apply(Command(jacobian(LAYOUT, pose[:3]) @ along * 2e-3, 0.0, closed, opening))
    plant.advance(800)
    truth = plant.truth()
    there = freedoms_of(np.linalg.solve(truth.lower, truth.upper), ROBOT.linkage.claw_offset, tolerance=1e-2)
    expected = holding_forces(ROBOT, LAYOUT, there, GRAVITY @ truth.lower[:3, :3])[end]
    assert np.abs(truth.forces - expected).max() < 0.05 * np.abs(expected).max()
