"""Cable robots as data: the built-in ones against published values, bound objects against the mechanics, bad files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    Rest,
    certify_poses,
    distribute,
    lost_cable,
    planar_lengths,
    planar_structure_matrix,
    settle,
    spatial_lengths,
    spatial_structure_matrix,
    tension_factor,
    wrench_feasible,
)
from steeplejack.robots.cable_robot import BUILT_IN, list_cable_robots, load_cable_robot, load_caspr
from steeplejack.robots.cable_robot.catalogue import read_parameters

PLANAR = """
name = "triangle"
description = "three cables"
dimension = "planar"
[platform]
mass = 2.0
inertia = 0.1
centre_of_mass = [0.01, -0.02]
source = {mass = "made up", inertia = "made up", centre_of_mass = "made up"}
[cables]
anchors = [[0.0, 0.0], [4.0, 0.0], [2.0, 3.0]]
attachments = [[-0.1, 0.0], [0.1, 0.0], [0.0, 0.1]]
tension_min = 1.0
tension_max = [50.0, 60.0, inf]
source = {anchors = "made up", attachments = "made up", tension_min = "made up", tension_max = "made up"}
"""
PULLEYS = """
[pulleys]
radius = [0.05, 0.0, 0.04]
axis = [[0.0, 1.0]]
source = {radius = "made up", axis = "made up"}
"""


@pytest.fixture
def write(tmp_path):
    """Write a robot file and return its path."""

    def to(text):
        path = tmp_path / "robot.toml"
        path.write_text(text)
        return path

    return to


def test_every_built_in_robot_is_listed_with_its_source():
    listed = list_cable_robots()
    assert tuple(robot.name for robot in listed) == BUILT_IN
    assert [robot.cables for robot in listed] == [4, 4, 4, 8, 8]
    assert [robot.dimension for robot in listed] == ["planar"] * 3 + ["spatial"] * 2
    assert all(robot.source and robot.description for robot in listed)


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_value_of_a_built_in_robot_has_a_source(name):
    parameters = read_parameters(name)
    for table in (parameters.platform, parameters.cables):
        assert all(len(text) > 5 for text in table.source.values())
    robot = load_cable_robot(name)
    assert robot.redundancy == (1 if robot.dimension == "planar" else 2)
    assert robot.lower.shape == robot.upper.shape == (len(robot.anchors),)


def test_published_geometry(reference):
    """The files say what the reference values of the other tests were computed with."""
    squad, cogiro = load_cable_robot("ccrobot-s-planar"), load_cable_robot("cogiro")
    np.testing.assert_array_equal(squad.anchors, reference["table_iii"]["anchors"])
    np.testing.assert_array_equal(squad.attachments, reference["table_iii"]["attachments"])
    np.testing.assert_array_equal(cogiro.anchors, reference["cogiro"]["anchors"])
    np.testing.assert_array_equal(cogiro.attachments, reference["cogiro"]["attachments"])
    x, y, phi = reference["lengths"]["x_y_phi_deg"]
    np.testing.assert_allclose(squad.lengths([x, y, np.deg2rad(phi)]), reference["lengths"]["lengths"], rtol=1e-6)
    for name, robot in zip(("planar-4-4", "kntu-planar"), reference["robot"], strict=True):
        loaded = load_cable_robot(name)
        np.testing.assert_array_equal(loaded.anchors, robot["anchors"])
        for *pose, factor in robot["factors"]:
            assert tension_factor(loaded.structure(pose)) == pytest.approx(factor, abs=1e-6)


def test_ipanema_has_its_corners_in_the_stated_order():
    robot = load_cable_robot("ipanema-2")
    corners = np.tile([[-1, 1], [1, 1], [1, -1], [-1, -1]], (2, 1))
    np.testing.assert_array_equal(np.sign(robot.anchors[:, :2]), corners)
    np.testing.assert_array_equal(np.sign(robot.attachments[:, :2]), corners)


def test_inertia_of_cogiro_about_its_frame_is_the_other_published_one():
    """The document gives both; they agree to its rounding if off-diagonal entries are products, without a minus."""
    robot = load_cable_robot("cogiro")
    printed = np.array([[42.955, -0.414, 2.205], [-0.414, 42.427, -1.849], [2.205, -1.849, 25.557]])
    about_origin = 2.0 * np.diag(np.diag(printed)) - printed
    mass = robot.mass_matrix([0.0, 0.0, 2.0], np.eye(3))
    np.testing.assert_allclose(mass[:3, :3], about_origin, atol=0.012)


def test_a_bound_robot_answers_as_the_mechanics_do(rng):
    planar, spatial = load_cable_robot("kntu-planar"), load_cable_robot("ipanema-2")
    pose = rng.uniform(-0.4, 0.4, (2, 5, 3))
    for bound, plain in ((planar.lengths, planar_lengths), (planar.structure, planar_structure_matrix)):
        np.testing.assert_array_equal(bound(pose), plain(planar.anchors, planar.attachments, pose))
    position, turn = rng.uniform(1.0, 2.0, (2, 5, 3)), Rotation.random(10, rng).as_matrix().reshape(2, 5, 3, 3)
    for bound, plain in ((spatial.lengths, spatial_lengths), (spatial.structure, spatial_structure_matrix)):
        np.testing.assert_array_equal(
            bound(position, turn), plain(spatial.anchors, spatial.attachments, position, turn)
        )
    assert spatial.weight([0.0, 0.0, -9.81], position, turn).shape == (2, 5, 6)
    assert spatial.mass_matrix(position, turn).shape == (2, 5, 6, 6)
    assert planar.mass_matrix(pose).shape == (2, 5, 3, 3)


def test_weight_is_the_slope_of_the_potential(write, rng):
    """Minus the change of m g h along every coordinate."""
    planar, spatial = load_cable_robot(write(PLANAR)), load_cable_robot("cogiro")
    gravity = np.array([0.3, -9.0])
    pose = np.array([1.0, 1.2, 0.6])

    def energy(where):
        turn = Rotation.from_rotvec([0.0, 0.0, where[2]]).as_matrix()[:2, :2]
        return -planar.mass * gravity @ (where[:2] + turn @ planar.centre_of_mass)

    slope = [-(energy(pose + s) - energy(pose - s)) / 2e-6 for s in np.eye(3) * 1e-6]
    np.testing.assert_allclose(planar.weight(gravity, pose), slope, atol=1e-6)
    down, turn = np.array([0.5, -1.0, -9.7]), Rotation.random(rng=rng)

    def height(move):
        turned = (Rotation.from_rotvec(move[:3]) * turn).as_matrix()
        return -spatial.mass * down @ (move[3:] + turned @ spatial.centre_of_mass)

    slope = [-(height(s) - height(-s)) / 2e-6 for s in np.eye(6) * 1e-6]
    np.testing.assert_allclose(spatial.weight(down, np.zeros(3), turn.as_matrix()), slope, rtol=1e-5, atol=1e-5)


def test_numbers_stand_for_all_cables_and_lists_for_each(write):
    robot = load_cable_robot(write(PLANAR))
    np.testing.assert_array_equal(robot.lower, 1.0)
    np.testing.assert_array_equal(robot.upper, [50.0, 60.0, np.inf])
    assert robot.redundancy == 0
    assert robot.axial_stiffness is None
    with pytest.raises(InputError, match="no axial stiffness"):
        robot.stiffness(np.ones(3), [0.0, -9.81], [2.0, 1.0, 0.0])


def test_pulleys_change_lengths_and_directions_together(write):
    """``dl/dx = -J`` holds over pulleys, and a pulley of radius 0 is a straight cable."""
    robot, straight = load_cable_robot(write(PLANAR + PULLEYS)), load_cable_robot(write(PLANAR))
    pose = np.array([2.1, 1.1, 0.3])
    slope = [(robot.lengths(pose + s) - robot.lengths(pose - s)) / 2e-6 for s in np.eye(3) * 1e-6]
    np.testing.assert_allclose(-robot.structure(pose), slope, atol=1e-8)
    longer = robot.lengths(pose) - straight.lengths(pose)
    assert longer[1] == 0.0
    assert (np.abs(longer[[0, 2]]) > 1e-4).all()


def test_planar_and_spatial_poses_are_not_mixed_up():
    with pytest.raises(InputError, match=r"pose of cogiro: no rotation"):
        load_cable_robot("cogiro").structure([0.0, 0.0, 2.0])
    with pytest.raises(InputError, match=r"pose of kntu-planar: a rotation"):
        load_cable_robot("kntu-planar").lengths([0.0, 0.0, 0.0], np.eye(3))


@pytest.mark.long
def test_locked_winches_leave_the_platform_where_it_hangs():
    """CoGiRo hung on tensions that balance it settles where it is, and without a cable its weight sinks."""
    robot, gravity, place, turn = load_cable_robot("cogiro"), [0.0, 0.0, -9.81], [0.5, -0.3, 2.0], np.eye(3)
    weight = robot.weight(gravity, place, turn)
    held = distribute(robot.structure(place, turn), weight, robot.lower, robot.upper, "qp")
    locked = robot.locked(gravity, place, turn, held.tensions)
    rest = settle(locked, place, turn)
    assert Rest(rest.status) == Rest.STABLE
    np.testing.assert_allclose(rest.position, place, atol=1e-6)
    np.testing.assert_allclose(rest.tensions, held.tensions, rtol=1e-4)
    without = lost_cable(robot.locked(gravity, place, turn), 0, place, turn).rest
    assert (without.position + without.rotation @ robot.centre_of_mass)[2] < place[2] + robot.centre_of_mass[2]


def test_locked_winches_of_a_planar_robot(write):
    robot, pose = load_cable_robot(write(PLANAR)), np.array([2.0, 1.2, 0.1])
    locked = robot.locked([0.0, -9.81], pose)
    np.testing.assert_allclose(locked.unstressed, robot.lengths(pose))
    assert locked.gyration == pytest.approx(np.sqrt(0.1 / 2.0))
    assert np.isinf(locked.axial_stiffness).all()
    with pytest.raises(InputError, match="no axial stiffness"):
        robot.locked([0.0, -9.81], pose, tensions=10.0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    (
        ('name = "triangle"', 'name = "triangle"\ncolour = "red"', "unknown field `colour`"),
        ("mass = 2.0", "mass = -2.0", r"\$.platform.mass"),
        ("mass = 2.0", 'mass = "two"', r"\$.platform.mass"),
        ("mass = 2.0", "mass = nan", r"\$.platform.mass"),
        ("mass = 2.0", "mass = inf", r"`mass` has an entry that is not a finite number - at `\$.platform`"),
        ("inertia = 0.1\n", "inertia = [[1.0,0.0,0.0],[0.0,1.0,0.0],[0.0,0.0,1.0]]\n", "planar robot is one number"),
        ("[4.0, 0.0]", "[4.0, 0.0, 0.0]", "`cables.anchors`, entry 2, has 3 coordinates and needs 2"),
        ("[4.0, 0.0]", "[4.0, inf]", "`anchors` has an entry that is not a finite number"),
        (", [0.0, 0.1]]", "]", "`cables.attachments` has 2 entries for 3 cables"),
        ("[50.0, 60.0, inf]", "[50.0, 60.0]", "`cables.tension_max` has 2 entries for 3 cables"),
        ("[50.0, 60.0, inf]", "0.5", r"tension window \[1.0, 0.5\] of cable 1 is upside down"),
        ("tension_min = 1.0", "tension_min = -1.0", r"\$.cables.tension_min"),
        ("tension_min = 1.0", "tension_min = nan", "tension_min"),
        ('mass = "made up", ', "", "`mass` needs both a value and an entry under `source`"),
        ('dimension = "planar"', 'dimension = "flat"', r"Invalid enum value 'flat'"),
        ('dimension = "planar"', 'dimension = "spatial"', "2 coordinates and needs 3"),
        ("anchors = [[", "anchors = [[[", "robot.toml"),
        ("axis = [[0.0, 1.0]]", "axis = [[0.0, 0.0]]", "direction without length"),
        ("axis = [[0.0, 1.0]]", "axis = [[0.0, 1e-320]]", "direction without length"),
        ("axis = [[0.0, 1.0]]", "axis = []", "`pulleys.axis` has 0 entries for 3 cables"),
        ("radius = [0.05, 0.0, 0.04]", "radius = -0.01", r"\$.pulleys.radius"),
        ('name = "triangle"\n', "", "missing required field `name`"),
        ('name = "triangle"', 'name = " "', "`name` is not one line of text"),
        ('name = "triangle"', 'name = "a\\nb"', "`name` is not one line of text"),
        ('description = "three cables"', "description = 3", r"Expected `str`, got `int` - at `\$.description`"),
        ('mass = "made up", ', 'mass = "", ', "`source.mass` is not one line of text"),
        ('mass = "made up", ', "mass = 3, ", r"\$.platform.source"),
        ('mass = "made up", ', 'mass = "made up", colour = "red", ', "`colour` needs both a value and an entry"),
        ("mass = 2.0", "mass = 0.0", r"\$.platform.mass"),
        ("mass = 2.0", "mass = true", "got `bool`"),
        ("mass = 2.0", "mass = 2020-01-01", "got `date`"),
        ("mass = 2.0", "mass = [2.0]", "got `array`"),
        ("mass = 2.0", f"mass = {'9' * 400}", "Number out of range"),
        ("mass = 2.0", "mass = 2.0\nmass = 3.0", "Cannot overwrite a value"),
        ("[cables]", "[platform]\n[cables]", "twice"),
        ("[[0.0, 0.0], [4.0, 0.0], [2.0, 3.0]]", "[]", r"length >= 1 - at `\$.cables.anchors`"),
        ("[[0.0, 0.0], [4.0, 0.0], [2.0, 3.0]]", '"here"', r"got `str` - at `\$.cables.anchors`"),
        ("[4.0, 0.0]", '[4.0, "x"]', r"\$.cables.anchors\[1\]\[1\]"),
        ("[4.0, 0.0]", "[4.0, nan]", "`anchors` has an entry that is not a finite number"),
        ("tension_min = 1.0", "tension_min = []", "`cables.tension_min` has 0 entries for 3 cables"),
        ("tension_min = 1.0", "tension_min = inf", "`tension_min` has an entry that is not a finite number"),
        ("[50.0, 60.0, inf]", "nan", "tension_max"),
        ("[50.0, 60.0, inf]", "1.0", "upside down or empty"),
        ("axis = [[0.0, 1.0]]", "axis = [[0.0, 1.0], [1.0, 0.0]]", "`pulleys.axis` has 2 entries for 3 cables"),
    ),
)
def test_a_file_that_cannot_be_used_is_refused_by_name(write, old, new, message):
    text = PLANAR + PULLEYS
    assert old in text
    with pytest.raises(InputError, match=message) as caught:
        load_cable_robot(write(text.replace(old, new, 1)))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("rows", "message"),
    (
        ("[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]", "3 x 3"),
        ("[[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]", "not symmetric"),
        ("[[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]]", "not positive definite"),
        ("1.0", "3 x 3"),
    ),
)
def test_spatial_inertia_is_checked(write, rows, message):
    text = (
        'name = "one"\ndescription = "one cable"\ndimension = "spatial"\n[platform]\nmass = 1.0\n'
        f"inertia = {rows}\ncentre_of_mass = [0.0, 0.0, 0.0]\n"
        'source = {mass = "-", inertia = "-", centre_of_mass = "-"}\n'
        "[cables]\nanchors = [[0.0, 0.0, 1.0]]\nattachments = [[0.0, 0.0, 0.0]]\ntension_min = 0.0\n"
        'tension_max = 1.0\nsource = {anchors = "-", attachments = "-", tension_min = "-", tension_max = "-"}\n'
    )
    with pytest.raises(InputError, match=message):
        load_cable_robot(write(text))


@pytest.mark.parametrize("name", ("no-such-robot", "", "."))
def test_no_such_robot(name):
    with pytest.raises(InputError, match="ccrobot-s-planar, planar-4-4"):
        load_cable_robot(name)


def test_a_file_that_is_not_text(tmp_path):
    path = tmp_path / "robot.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"robot.toml"):
        load_cable_robot(path)


@pytest.mark.parametrize("content", [("a = " + "[" * 5000).encode(), "a = 1".encode("utf-32")])
def test_a_file_no_reader_can_take(tmp_path, content):
    path = tmp_path / "robot.toml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"robot.toml") as caught:
        load_cable_robot(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "an empty file"),
        (bytes(range(256)), "can't decode"),
        (b"\0" * 1000, "Invalid statement"),
        (b"\xef\xbb\xbf", "an empty file"),
        (b'{"name": "json"}', "Invalid statement"),
        (b".".join([b"a"] * 500) + b" = 1", "unknown field `a`"),
        (b"a" * 3000 + b" = 1", "unknown field `a+ \\.\\.\\. a+"),
        (b'name = "' + b"a" * (1 << 20) + b'"', "more than 1048576 bytes"),
    ],
    ids=("empty", "binary", "zeros", "mark", "json", "deep", "long", "huge"),
)
def test_content_that_is_no_robot(tmp_path, content, message):
    path = tmp_path / "robot.toml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        load_cable_robot(path)
    assert len(str(caught.value)) < 400
    assert "\n" not in str(caught.value)


def test_a_byte_order_mark_and_other_line_ends_are_taken(tmp_path):
    path = tmp_path / "robot.toml"
    path.write_bytes(b"\xef\xbb\xbf" + PLANAR.replace("\n", "\r\n").encode())
    assert load_cable_robot(path).name == "triangle"


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("robot\0.toml", "null"),
        (None, "NoneType"),
        (5, "not int"),
        ("a" * 5000, "too long"),
        ("/dev/zero", "not a file"),
    ],
    ids=("nul", "none", "number", "long", "device"),
)
def test_a_path_that_leads_to_no_file(path, message):
    with pytest.raises(InputError, match=message) as caught:
        load_cable_robot(path)
    with pytest.raises(InputError) as other:
        load_caspr(path)
    assert max(len(str(caught.value)), len(str(other.value))) < 400


def test_a_weight_beside_the_reference_point_counts_once(rng):
    robot = replace(load_cable_robot("cogiro"), centre_of_mass=np.array([0.5, -0.3, 0.4]))
    down, seen = [0.0, 0.0, -9.81], set[bool]()
    question = robot.pose_question(down)
    for _ in range(12):
        place, vector = rng.uniform([-6.0, -4.0, 1.0], [6.0, 4.0, 3.0]), rng.uniform(-0.2, 0.2, 3)
        turn = Rotation.from_rotvec(vector).as_matrix()
        held = wrench_feasible(robot.structure(place, turn), robot.lower, robot.upper, robot.weight(down, place, turn))
        if abs(held.margin) > 1.0:
            box = np.concatenate((place, vector))[:, None] + [-1e-6, 1e-6]
            region = certify_poses(question, box, most=100)
            assert (region.inner > 0.0, region.outer > 0.0) == (bool(held.feasible), bool(held.feasible))
            seen.add(bool(held.feasible))
    assert seen == {False, True}


def test_questions_of_straight_cables_refuse_pulleys():
    robot = load_cable_robot("cogiro")
    wheels = replace(robot, pulley_radii=np.full(8, 0.05), pulley_axes=np.tile([0.0, 0.0, -1.0], (8, 1)))
    for asked in (lambda: wheels.straight, lambda: wheels.pose_question([0.0, 0.0, -9.81])):
        with pytest.raises(InputError, match="pulleys of radius 0.05 m"):
            asked()
    with pytest.raises(InputError, match="planar"):
        load_cable_robot("planar-4-4").pose_question([0.0, 0.0, -9.81])
