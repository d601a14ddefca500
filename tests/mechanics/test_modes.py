"""Natural frequencies against closed forms, an energy quotient and MuJoCo."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.rest.modes import natural_modes, planar_mass_matrix, spatial_mass_matrix
from steeplejack.mechanics.cable.rest.stiffness import planar_stiffness, spatial_stiffness
from steeplejack.robots.cable_robot import load_cable_robot

GRAVITY = 9.81


def test_a_point_mass_on_one_cable_is_a_pendulum():
    """Two swings at sqrt(g / l), one bounce at sqrt(k / m); spin about the cable is neutral."""
    mass, length, rate = 4.0, 2.5, 8e3
    stiffness = spatial_stiffness(
        [[0.0, 0.0, length]], [[0.0, 0.0, 0.0]], np.zeros(3), np.eye(3), [mass * GRAVITY], rate
    )
    modes = natural_modes(stiffness[3:, 3:], mass * np.eye(3))
    np.testing.assert_allclose(modes.squares, [GRAVITY / length, GRAVITY / length, rate / mass], rtol=1e-12)
    np.testing.assert_allclose(modes.frequencies, np.sqrt(modes.squares) / (2 * np.pi))
    assert modes.stable


def test_a_compound_pendulum():
    """A body on three cables that meet at one anchor far stiffer than its weight swings like a compound pendulum."""
    anchor, mass, inertia = np.array([0.0, 0.0, 2.0]), 5.0, np.diag([0.4, 0.6, 0.5])
    attachments = np.array([[0.5, 0.1, 0.0], [-0.3, 0.4, 0.0], [-0.2, -0.5, 0.0]])
    vectors = anchor - attachments
    tensions = np.linalg.solve((vectors / np.linalg.norm(vectors, axis=1)[:, None]).T, [0.0, 0.0, mass * GRAVITY])
    assert (tensions > 0.0).all()
    stiffness = spatial_stiffness(
        np.tile(anchor, (3, 1)), attachments, np.zeros(3), np.eye(3), tensions, 1e10, [0.0, 0.0, -mass * GRAVITY]
    )
    modes = natural_modes(stiffness, spatial_mass_matrix(mass, inertia, np.zeros(3), np.eye(3)))
    swings = np.sort([mass * GRAVITY * 2.0 / (i + mass * 4.0) for i in (0.4, 0.6)])
    assert modes.squares[0] == pytest.approx(0.0, abs=1e-3)
    np.testing.assert_allclose(modes.squares[1:3], swings, rtol=1e-5)


def test_an_unstable_direction_is_said_to_be_one():
    stiffness = spatial_stiffness(
        [[0.0, 0.0, 3.0]] * 1,
        [[0.0, 0.0, 0.0]],
        np.zeros(3),
        np.eye(3),
        [50.0],
        1e4,
        [0.0, 0.0, -50.0],
        [0.0, 0.0, 0.4],
    )
    modes = natural_modes(stiffness, spatial_mass_matrix(5.0, 0.1 * np.eye(3), [0.0, 0.0, 0.4], np.eye(3)))
    assert not modes.stable
    assert modes.squares[0] < 0.0
    assert np.isnan(modes.frequencies[0])


@pytest.mark.parametrize("kind", ("planar", "spatial"))
def test_mass_matrices_give_the_kinetic_energy(kind, rng):
    mass, inertia, centre = 7.0, np.array([[1.2, 0.1, -0.2], [0.1, 0.9, 0.05], [-0.2, 0.05, 1.5]]), [0.3, -0.2, 0.4]
    twist = rng.normal(size=6)
    if kind == "planar":
        phi, (vx, vy, omega) = 0.8, twist[:3]
        arm = Rotation.from_rotvec([0.0, 0.0, phi]).as_matrix()[:2, :2] @ centre[:2]
        velocity = np.array([vx - omega * arm[1], vy + omega * arm[0]])
        energy = 0.5 * mass * velocity @ velocity + 0.5 * 1.5 * omega**2
        found = 0.5 * twist[:3] @ planar_mass_matrix(mass, 1.5, centre[:2], phi) @ twist[:3]
    else:
        turn = Rotation.random(rng=rng).as_matrix()
        velocity = twist[3:] + np.cross(twist[:3], turn @ centre)
        energy = 0.5 * mass * velocity @ velocity + 0.5 * twist[:3] @ turn @ inertia @ turn.T @ twist[:3]
        found = 0.5 * twist @ spatial_mass_matrix(mass, inertia, centre, turn) @ twist
    assert found == pytest.approx(energy, rel=1e-12)


def test_modes_are_those_of_the_generalised_eigenproblem_in_any_units(rng):
    root, mass = rng.normal(size=(6, 6)), rng.normal(size=(6, 6))
    stiffness, mass = root @ root.T, mass @ mass.T + np.eye(6)
    for unit in (1.0, 1e-9, 1e9):
        scale = np.diag(np.repeat([unit, 1.0], 3))
        modes = natural_modes(scale @ stiffness @ scale, scale @ mass @ scale)
        np.testing.assert_allclose(modes.squares, eigh(stiffness, mass)[0], rtol=1e-8)
        shapes = scale @ modes.shapes
        np.testing.assert_allclose(shapes.T @ mass @ shapes, np.eye(6), atol=1e-8)
        assert modes.stable


def test_undefined_stiffness_and_bad_mass():
    stiffness = np.stack((np.eye(3), np.full((3, 3), np.nan)))
    modes = natural_modes(stiffness, np.eye(3))
    np.testing.assert_array_equal(modes.stable, [True, False])
    assert np.isnan(modes.squares[1]).all()
    for bad in (np.diag([1.0, 1.0, 0.0]), np.diag([1.0, 1.0, -1.0]), np.full((3, 3), np.nan)):
        with pytest.raises(InputError, match="mass matrix"):
            natural_modes(np.eye(3), bad)


def test_planar_modes_of_table_iii_are_those_of_its_spatial_twin():
    """Embedded in space, the three in-plane modes of a planar robot are among its six."""
    robot = load_cable_robot("ccrobot-s-planar")
    pose, tensions = np.array([-0.1, 0.45, np.deg2rad(50.0)]), np.array([200.0, 150.0, 180.0, 160.0])
    plane = natural_modes(
        planar_stiffness(robot.anchors, robot.attachments, pose, tensions, 1e5), robot.mass_matrix(pose)
    )
    flat = [np.pad(points, ((0, 0), (0, 1))) for points in (robot.anchors, robot.attachments)]
    turn = Rotation.from_rotvec([0.0, 0.0, pose[2]]).as_matrix()
    full = spatial_stiffness(*flat, [pose[0], pose[1], 0.0], turn, tensions, 1e5)
    mass = spatial_mass_matrix(robot.mass, np.diag([0.2, 0.2, float(robot.inertia)]), np.zeros(3), turn)
    every = natural_modes(full, mass).squares
    for square in plane.squares:
        assert np.abs(every / square - 1.0).min() < 1e-9


def text(numbers):
    """Numbers as XML wants them."""
    return " ".join(repr(float(number)) for number in np.ravel(numbers))


def test_cogiro_against_mujoco(rng):
    """Spatial tendons of the same rest lengths and rates: stiffness and inertia of the engine give the same modes."""
    robot = load_cable_robot("cogiro")
    position, turn = np.array([1.0, -0.7, 2.0]), Rotation.from_rotvec([0.05, -0.1, 0.2]).as_matrix()
    structure, load = robot.structure(position, turn), robot.weight([0.0, 0.0, -GRAVITY], position, turn)
    tensions = 1500.0 - np.linalg.pinv(structure) @ (load + structure @ np.full(8, 1500.0))
    assert robot.axial_stiffness is not None
    lengths = robot.lengths(position, turn)
    rates = (robot.axial_stiffness + tensions) / lengths
    taut = tensions > 0.0
    sites, anchors = (
        "".join(f'<site name="{name}{i}" pos="{text(point)}"/>' for i, point in enumerate(points))
        for name, points in (("b", robot.attachments), ("a", robot.anchors))
    )
    tendons = "".join(
        f'<spatial stiffness="{text(rates[i])}" springlength="{text([0.0, lengths[i] - tensions[i] / rates[i]])}">'
        f'<site site="a{i}"/><site site="b{i}"/></spatial>'
        for i in np.flatnonzero(taut)
    )
    inertia = text(robot.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])
    quaternion = Rotation.from_matrix(turn).as_quat(scalar_first=True)
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option gravity="0 0 {-GRAVITY}"/><worldbody>{anchors}
        <body pos="{text(position)}" quat="{text(quaternion)}"><freejoint/>
        <inertial mass="{robot.mass}" pos="{text(robot.centre_of_mass)}" fullinertia="{inertia}"/>{sites}</body>
        </worldbody><tendon>{tendons}</tendon></mujoco>"""
    )
    data = mujoco.MjData(model)
    start = data.qpos.copy()

    def push(move):
        """Generalised force at rest after a move (linear; angular in the body's axes)."""
        data.qpos[:] = start
        mujoco.mj_integratePos(model, data.qpos, move, 1.0)
        data.qvel[:] = 0.0
        mujoco.mj_forward(model, data)
        return data.qfrc_passive - data.qfrc_bias

    np.testing.assert_allclose(push(np.zeros(6)), 0.0, atol=1e-6 * tensions.max())
    slope = -np.stack([(push(s) - push(-s)) / 2e-6 for s in np.eye(6) * 1e-6], axis=-1)
    mass = np.zeros((6, 6))
    push(np.zeros(6))
    mujoco.mj_fullM(model, data, mass)
    wanted = eigh(0.5 * (slope + slope.T), mass)[0]
    found = natural_modes(
        robot.stiffness(np.where(taut, tensions, 0.0), [0.0, 0.0, -GRAVITY], position, turn),
        robot.mass_matrix(position, turn),
    )
    np.testing.assert_allclose(found.squares, wanted, rtol=1e-4)


def inertia_of(*moments):
    """Principal moments as a matrix."""
    return np.diag(moments)


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"mass": -1.0}, "mass"),
        ({"mass": 0.0}, "mass"),
        ({"mass": np.nan}, "mass"),
        ({"mass": [1.0, 2.0]}, "mass"),
        ({"inertia": np.eye(2)}, "inertia"),
        ({"inertia": inertia_of(1.0, 1.0, -1.0)}, "inertia"),
        ({"inertia": inertia_of(1.0, 1.0, 2.1)}, "inertia"),
        ({"inertia": np.eye(3) + np.eye(3, k=1) * 0.1}, "inertia"),
        ({"inertia": np.full((3, 3), np.nan)}, "inertia"),
        ({"centre": np.zeros(2)}, "centre"),
        ({"centre": [0.0, np.inf, 0.0]}, "centre"),
        ({"rotation": np.eye(2)}, "rotation"),
    ],
)
def test_bodies_there_are_none_of_are_refused(changes, where):
    given = {"mass": 2.0, "inertia": inertia_of(1.0, 1.2, 1.5), "centre": np.zeros(3), "rotation": np.eye(3)}
    with pytest.raises(InputError) as error:
        spatial_mass_matrix(**(given | changes))
    assert error.value.where == where


def test_planar_bodies_there_are_none_of_are_refused():
    for mass, inertia, centre, where in (
        (-2.0, 1.0, np.zeros(2), "mass"),
        (2.0, -1.0, np.zeros(2), "inertia"),
        (2.0, np.nan, np.zeros(2), "inertia"),
        (2.0, 1.0, np.zeros(3), "centre"),
    ):
        with pytest.raises(InputError) as error:
            planar_mass_matrix(mass, inertia, centre, 0.1)
        assert error.value.where == where


@pytest.mark.parametrize(
    ("stiffness", "mass", "where"),
    [
        (np.eye(3) + np.eye(3, k=1), np.eye(3), "stiffness"),
        (np.eye(3), np.eye(3) + np.eye(3, k=1), "mass matrix"),
        (np.eye(3), np.eye(6), "mass matrix"),
        (np.ones((2, 3)), np.eye(3), "stiffness"),
        (np.ones((2, 3, 3)), np.tile(np.eye(3), (5, 1, 1)), "mass matrix"),
        ("stiff", np.eye(3), "stiffness"),
    ],
)
def test_matrices_that_do_not_fit_are_refused(stiffness, mass, where):
    with pytest.raises(InputError) as error:
        natural_modes(stiffness, mass)
    assert error.value.where == where
