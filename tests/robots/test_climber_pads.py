"""Grips on eight pads: use of a grip against the same programme by HiGHS, closed forms, and what no pads can do."""

from __future__ import annotations

import math
from importlib.resources import files
from pathlib import Path

import msgspec
import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber import Layout, PipeClimber, load_pipe_climber
from steeplejack.robots.pipe_climber.grippers import free_gripper
from steeplejack.robots.pipe_climber.pads import EDGES, grip_body, grip_use, pad_clock, pad_row, pad_wrenches
from steeplejack.robots.pipe_climber.statics import friction_needed
from steeplejack.robots.pipe_climber.weights import first_moments, grip_loads

ROBOT = load_pipe_climber()
LAYOUT = Layout.of(ROBOT)
RADIUS = 0.03
BODY = grip_body(ROBOT, RADIUS)


def by_highs(body: np.ndarray, load: np.ndarray) -> float:
    found = linprog(np.ones(len(body)), A_eq=body.T, b_eq=-load, bounds=(0.0, None))
    assert found.status == 0
    return float(found.fun)


def test_use_is_that_of_highs(rng: np.random.Generator):
    loads = rng.normal(size=(60, 6)) * [0.8, 0.8, 0.8, 12.0, 12.0, 12.0]
    loads[20:40] = loads[20] + 0.02 * loads[20:40]  # near one another, so that one basis leads to the next
    np.testing.assert_allclose(grip_use(BODY, loads), [by_highs(BODY, one) for one in loads], rtol=1e-6)


def test_along_the_pipe_it_is_the_closed_form_and_about_it_no_more():
    for axial in (19.62, -19.62):
        needed = friction_needed(ROBOT.gripper, axial) / ROBOT.gripper.friction
        assert float(grip_use(BODY, [0.0, 0.0, 0.0, 0.0, 0.0, axial])) == pytest.approx(needed, rel=1e-9)
    # A torque draws the pipe between the pads of each jaw, which then press more than the closed form counts on.
    needed = friction_needed(ROBOT.gripper, 0.0, 0.4, RADIUS) / ROBOT.gripper.friction
    assert 0.8 * needed < float(grip_use(BODY, [0.0, 0.0, 0.4, 0.0, 0.0, 0.0])) < needed
    assert float(grip_use(BODY, np.zeros(6))) == 0.0


def test_use_is_a_gauge(rng: np.random.Generator):
    a, b = rng.normal(size=(2, 30, 6)) * [0.5, 0.5, 0.5, 10.0, 10.0, 10.0]
    np.testing.assert_allclose(grip_use(BODY, 3e-6 * a), 3e-6 * grip_use(BODY, a), rtol=1e-7)
    assert (grip_use(BODY, a + b) <= grip_use(BODY, a) + grip_use(BODY, b) + 1e-7).all()
    # Both jaws, all four pads and both ways along the pipe are alike.
    for signs in ((1, -1, -1, 1, -1, -1), (-1, 1, -1, -1, 1, -1), (-1, -1, 1, -1, -1, 1), (1, -1, -1, -1, 1, 1)):
        np.testing.assert_allclose(grip_use(BODY, a * signs), grip_use(BODY, a), rtol=1e-6)


def test_tilting_alone_is_borne_by_pads_at_both_ends():
    """A moment about Y: normals of opposite pads two rows apart, and friction along the pipe with them."""
    smooth = msgspec.structs.replace(ROBOT, gripper=msgspec.structs.replace(ROBOT.gripper, friction=1e-9))
    most = 2.0 * pad_row(ROBOT) * ROBOT.gripper.force * math.cos(pad_clock(ROBOT, RADIUS))
    assert float(grip_use(grip_body(smooth, RADIUS), [0.0, most, 0.0, 0.0, 0.0, 0.0])) == pytest.approx(1.0, rel=1e-6)
    assert float(grip_use(BODY, [0.0, most, 0.0, 0.0, 0.0, 0.0])) < 1.0
    assert float(grip_use(grip_body(smooth, RADIUS), [0.0, 0.0, 0.0, 0.0, 0.0, 1.0])) > 1e3


def test_pads_that_stand_askew_give_what_they_gave_turned(rng: np.random.Generator):
    """About the jaws' way, which leaves what they press with as it is; pyramids then turn in their cones, 2 %."""
    phi, row, edges = pad_clock(ROBOT, RADIUS), pad_row(ROBOT), 64
    signs = np.array(np.meshgrid([1.0, -1.0], [1.0, -1.0], [1.0, -1.0])).reshape(3, -1)
    jaws = signs[0]
    normals = np.stack((jaws * math.cos(phi), signs[1] * math.sin(phi), 0.0 * jaws), axis=-1)
    places = RADIUS * normals + row * np.outer(signs[2], [0.0, 0.0, 1.0])
    press = ROBOT.gripper.jaws * ROBOT.gripper.force * math.cos(phi)
    loads = rng.normal(size=(20, 6)) * [0.5, 0.5, 0.5, 8.0, 8.0, 8.0]
    alike = grip_use(pad_wrenches(places, normals, jaws, ROBOT.gripper.friction, press), loads)
    np.testing.assert_allclose(alike, grip_use(BODY, loads), rtol=1e-9)
    turn = Rotation.from_rotvec([0.4, 0.0, 0.0]).as_matrix()
    straight = pad_wrenches(places, normals, jaws, ROBOT.gripper.friction, press, edges)
    askew = pad_wrenches(places @ turn.T, normals @ turn.T, jaws, ROBOT.gripper.friction, press, edges)
    turned = np.concatenate((loads[:, :3] @ turn.T, loads[:, 3:] @ turn.T), axis=1)
    np.testing.assert_allclose(grip_use(askew, turned), grip_use(straight, loads), rtol=2.0 * (math.pi / edges) ** 2)


def bent(radius: float, toward: float) -> np.ndarray:
    """Lines under the rows of a gripper on the chord of a bend of a radius [m] toward a clock [rad]."""
    row, inward = pad_row(ROBOT), np.array([math.cos(toward), math.sin(toward), 0.0])
    half = math.asin(row / radius)
    centre = radius * math.cos(half) * inward
    lines = np.empty((2, 2, 3))
    for k, side in enumerate((-1.0, 1.0)):
        lines[k, 0] = [0.0, 0.0, math.cos(half)] + side * math.sin(half) * inward
        lines[k, 1] = (centre - [0.0, 0.0, side * row]) / radius**2
    return lines


@pytest.mark.parametrize(("radius", "toward"), [(0.3, 0.0), (0.12, 0.5 * math.pi), (0.15, 2.4), (0.066, math.pi)])
def test_in_a_bend_pads_push_from_where_the_torus_is_nearest(radius: float, toward: float):
    """Without friction each pad's wrench is a line through its middle and the nearest point of the bend's circle."""
    smooth, lines = rubbing(1e-12), bent(radius, toward)
    inward, half = np.array([math.cos(toward), math.sin(toward), 0.0]), math.asin(pad_row(ROBOT) / radius)
    centre = radius * math.cos(half) * inward
    corners = grip_body(smooth, RADIUS, lines=lines).reshape(8, EDGES, 6).mean(axis=1)
    rows = [end * pad_row(ROBOT) for _jaw in range(2) for _side in range(2) for end in (1.0, -1.0)]
    aside = [side * 0.5 * ROBOT.build.jaw_width for _jaw in range(2) for side in (1.0, 1.0, -1.0, -1.0)]
    for (*moment, x, y, z), beside, row in zip(corners, aside, rows, strict=True):
        size = math.hypot(x, y, z)
        normal, arm = np.array([x, y, z]) / size, np.array(moment) / size
        across, rest = np.cross([1.0, 0.0, 0.0], normal), arm - np.cross([0.0, beside, row], normal)
        pad = np.array([across @ rest / (across @ across), beside, row])
        np.testing.assert_allclose(np.cross(pad, normal), arm, atol=1e-12)  # it goes through the pad's middle
        away = pad - centre
        flat = away - np.cross([0.0, 0.0, 1.0], inward) * (away @ np.cross([0.0, 0.0, 1.0], inward))
        nearest = centre + radius * flat / np.linalg.norm(flat)
        np.testing.assert_allclose(pad - nearest, (RADIUS + ROBOT.build.pad_radius) * normal, atol=1e-12)


def test_a_bend_of_no_curvature_is_straight_and_half_a_turn_changes_nothing(rng: np.random.Generator):
    loads = rng.normal(size=(20, 6)) * [0.5, 0.5, 0.5, 8.0, 8.0, 8.0]
    almost = grip_use(grip_body(ROBOT, RADIUS, lines=bent(1e6, 0.7)), loads)
    np.testing.assert_allclose(almost, grip_use(BODY, loads), rtol=1e-6)
    for toward in (0.0, 0.7, 2.0):
        here, there = (grip_body(ROBOT, RADIUS, lines=bent(0.3, toward + turn)) for turn in (0.0, math.pi))
        turned = loads * [-1.0, -1.0, 1.0, -1.0, -1.0, 1.0]
        np.testing.assert_allclose(grip_use(here, loads), grip_use(there, turned), rtol=1e-7)
    # Along the pipe: rows that lean against each other draw as hard as they push.
    axial = [0.0, 0.0, 0.0, 0.0, 0.0, 20.0]
    bend = float(grip_use(grip_body(ROBOT, RADIUS, lines=bent(0.3, 0.0)), axial))
    assert bend == pytest.approx(float(grip_use(BODY, axial)), rel=0.05)


def test_a_bend_too_tight_for_pads_is_refused():
    with pytest.raises(InputError, match="^bend radius: 64 mm; above 65 mm$"):
        grip_body(ROBOT, RADIUS, lines=bent(0.064, 0.0))


def test_edges_along_which_a_pad_jams_are_left_out():
    """A pad at 45 degrees from its jaw's way jams where friction draws it in more than its push moves it out."""
    place, normal = np.array([[0.02, 0.02, 0.0]]), math.sqrt(0.5) * np.array([[1.0, 1.0, 0.0]])
    for friction, left in ((0.9, EDGES), (1.05, EDGES - 1)):
        assert len(pad_wrenches(place, normal, np.ones(1), friction, 1.0)) == left


def test_loads_are_the_weight_at_the_middle_of_mass(rng: np.random.Generator):
    freedoms = np.column_stack((
        rng.uniform(-0.02, 0.02, 8), rng.uniform(0.15, 0.2, 8), rng.uniform(-0.4, 0.4, 8), rng.uniform(-0.5, 0.5, 8),
    ))  # fmt: skip
    gravity = rng.normal(size=(8, 3))
    mass, moment = first_moments(ROBOT, LAYOUT, freedoms, 0.3)
    assert mass == pytest.approx(ROBOT.body.mass + 0.3)
    loads, uppers = grip_loads(ROBOT, LAYOUT, freedoms, gravity, 0.3), free_gripper(freedoms, 0.0)
    for k in range(8):
        turn, place = uppers[k, :3, :3], uppers[k, :3, 3]
        np.testing.assert_allclose(loads[k, 0, :3], np.cross(moment[k], gravity[k]), atol=1e-12)
        np.testing.assert_allclose(turn @ loads[k, 1, 3:], mass * gravity[k], atol=1e-12)
        about = np.cross(moment[k] / mass - place, mass * gravity[k])
        np.testing.assert_allclose(turn @ loads[k, 1, :3], about, atol=1e-12)


def rubbing(friction: float) -> PipeClimber:
    return msgspec.structs.replace(ROBOT, gripper=msgspec.structs.replace(ROBOT.gripper, friction=friction))


@pytest.mark.parametrize(("radius", "most"), [(0.025, 1.7321), (0.030, 2.1082)])
def test_friction_at_which_pads_jam_is_cot_phi(radius: float, most: float):
    jams = ROBOT.build.jamming_friction(radius)
    assert jams == pytest.approx(1.0 / math.tan(pad_clock(ROBOT, radius)), rel=1e-12)
    assert jams == pytest.approx(most, abs=1e-4)


def test_friction_short_of_jamming_holds_the_more_the_more_there_is():
    load = [0.1, 0.1, 0.1, 2.0, 2.0, 10.0]
    frictions = np.append(np.linspace(0.1, 1.7, 9), 1.732)
    uses = [float(grip_use(grip_body(rubbing(mu), 0.025), load)) for mu in frictions]
    assert (np.diff(uses) < 0.0).all() and uses[-1] > 0.0


def test_friction_with_which_pads_jam_is_refused(tmp_path: Path):
    valid = "below 1.732, where pads jam on a pipe of 50 mm"
    with pytest.raises(InputError, match=f"^`gripper.friction`: 1.74; {valid}$"):
        rubbing(1.74)
    thin = 0.020  # thinner than what the grippers are for
    with pytest.raises(InputError, match="^friction: 1.5; below 1.333, where pads jam on a pipe of 40 mm$"):
        grip_body(rubbing(1.5), thin)
    shipped = files("steeplejack.robots.pipe_climber").joinpath("pipe_climber.toml").read_text()
    for was, now, said in (
        ("friction = 0.3 ", "friction = 1.8 ", valid),
        ("pipe_diameter = [0.050,", "pipe_diameter = [0.019,", "from 0.019 m; above 0.02 m"),
    ):
        assert was in shipped
        file = tmp_path / "robot.toml"
        file.write_text(shipped.replace(was, now))
        with pytest.raises(InputError, match=f"{file.name}, `gripper.*{said}") as refused:
            load_pipe_climber(file)
        assert "\n" not in str(refused.value)


def test_a_linkage_whose_parallelogram_would_be_flat_is_refused():
    with pytest.raises(InputError, match=r"^`rcm.limit`: 1.5708 rad; below pi / 2, where the parallelogram is flat$"):
        msgspec.structs.replace(ROBOT, rcm=msgspec.structs.replace(ROBOT.rcm, limit=0.5 * math.pi))


def test_bad_input_is_refused_or_not_a_number():
    assert np.isnan(grip_use(BODY, [math.nan, 0.0, 0.0, 0.0, 0.0, 1.0]))
    with pytest.raises(InputError, match="moment and force"):
        grip_use(BODY, np.zeros(3))
    with pytest.raises(InputError, match="pipe radius"):
        grip_body(ROBOT, 0.005)
