"""Structure derivatives and gradients of tension factor and margins against finite differences along the manifold."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    characteristic_length,
    distribute,
    planar_structure_matrix,
    pulley_runs,
    spatial_structure_matrix,
    tension_factor,
)
from steeplejack.mechanics.cable.measure.derivatives import (
    gradient,
    planar_structure_derivatives,
    planar_weight_derivative,
    spatial_structure_derivatives,
    spatial_weight_derivative,
)
from steeplejack.mechanics.cable.measure.slopes import capacity_margin_slope, margin_slope, tension_factor_slope
from steeplejack.mechanics.cable.wrench.feasibility import capacity_margin
from steeplejack.robots.cable_robot import load_cable_robot

pytestmark = pytest.mark.long

PLANAR = ("ccrobot-s-planar", "planar-4-4", "kntu-planar")
SPATIAL = ("ipanema-2", "cogiro")
EVERY = (*PLANAR, *SPATIAL, *(f"{name} over pulleys" for name in (*PLANAR, *SPATIAL)))
STEP = 1e-5
CLOSE = 1e-6  # [1] of a gradient's largest entry


class Place:
    """A robot at many poses, and at poses, anchors and attachments beside them."""

    def __init__(self, case, rng, count):
        name, *pulleys = case.split(" over ")
        self.robot = load_cable_robot(name)
        self.planar = self.robot.dimension == "planar"
        anchors = self.robot.anchors
        middle, half = anchors.mean(axis=0), 0.3 * np.ptp(anchors, axis=0)
        if name == "cogiro":
            middle, half = np.array([0.0, 0.0, 2.5]), np.array([3.0, 2.0, 1.0])
        self.anchors, self.attachments = anchors, self.robot.attachments
        self.axes = self.radii = None
        if pulleys:
            self.axes = rng.normal(size=anchors.shape)
            self.radii = rng.uniform(0.01, 0.03, len(anchors)) * np.ptp(anchors, axis=0).max()
        self.position = rng.uniform(middle - half, middle + half, (count, len(middle)))
        turn = rng.uniform(-0.25, 0.25, (count, 1 if self.planar else 3))
        if name == "ccrobot-s-planar":
            turn += np.deg2rad(50.0)
        self.rotation = Rotation.from_rotvec(turn if not self.planar else turn * [0.0, 0.0, 1.0])

    def moved(self, coordinate=None, anchor=None, attachment=None, step=0.0):
        """The same place, one coordinate of the pose, an anchor or an attachment away."""
        other = object.__new__(Place)
        vars(other).update(vars(self))
        if anchor is not None:
            other.anchors = self.anchors.copy()
            other.anchors[anchor] += step
        if attachment is not None:
            other.attachments = self.attachments.copy()
            other.attachments[attachment] += step
        if coordinate is not None:
            shift, turn = np.zeros(self.position.shape[-1]), np.zeros(3)
            if self.planar:
                (turn if coordinate == 2 else shift)[coordinate] = step
            else:
                (turn if coordinate < 3 else shift)[coordinate % 3] = step
            other.position = self.position + shift
            other.rotation = Rotation.from_rotvec(turn) * self.rotation
        return other

    @property
    def pose(self):
        """``(x, y, phi)`` of a planar robot."""
        return np.concatenate((self.position, self.rotation.as_rotvec()[:, 2:]), axis=-1)

    @property
    def exits(self):
        """Where straight cables would come from: the anchors, or a point along the free stretches."""
        if self.radii is None:
            return self.anchors
        turn = self.rotation.as_matrix()[:, : self.anchors.shape[1], : self.anchors.shape[1]]
        ends = self.position[:, None] + self.attachments @ np.swapaxes(turn, -1, -2)
        return ends + pulley_runs(self.anchors, self.axes, self.radii, ends)[1]

    @property
    def structure(self):
        """Structure matrices."""
        if self.planar:
            return planar_structure_matrix(self.exits, self.attachments, self.pose)
        return spatial_structure_matrix(self.exits, self.attachments, self.position, self.rotation.as_matrix())

    @property
    def derivatives(self):
        """And their derivatives."""
        wheels = (self.axes, self.radii)
        if self.planar:
            return planar_structure_derivatives(self.anchors, self.attachments, self.pose, *wheels)
        turn = self.rotation.as_matrix()
        return spatial_structure_derivatives(self.anchors, self.attachments, self.position, turn, *wheels)

    @property
    def weight(self):
        """Wrench of the weight and its derivative in the pose; planar robots get a centre of mass off the middle."""
        force = self.robot.mass * 9.81 * np.eye(self.position.shape[-1])[-1] * -1.0
        turn = None if self.planar else self.rotation.as_matrix()
        centre = self.robot.centre_of_mass + (0.02 if self.planar else 0.0)
        moved = type(self.robot)(**(vars(self.robot) | {"centre_of_mass": centre}))
        wrench = moved.weight(force / self.robot.mass, self.pose if self.planar else self.position, turn)
        if self.planar:
            return wrench, planar_weight_derivative(force, centre, self.pose)
        return wrench, spatial_weight_derivative(force, centre, turn)


def slopes(place, function, step=STEP):
    """Central differences of a function of the place in pose, anchors and attachments."""

    def difference(scale, **where):
        ahead, behind = (function(place.moved(**where, step=s * scale)) for s in (1.0, -1.0))
        return (ahead - behind) / (2.0 * step)

    n = 3 if place.planar else 6
    m, d = place.anchors.shape
    pose = np.stack([difference(step, coordinate=c) for c in range(n)], axis=-1)
    points = [
        np.stack([np.stack([difference(step * e, **{name: i}) for e in np.eye(d)], -1) for i in range(m)], -2)
        for name in ("anchor", "attachment")
    ]
    return pose, *points


@pytest.mark.parametrize("name", EVERY)
def test_structure_derivatives(name, rng):
    place = Place(name, rng, 10)
    pose, anchors, attachments = slopes(place, lambda p: p.structure)
    found = place.derivatives
    np.testing.assert_allclose(found.pose, pose, atol=CLOSE * np.abs(pose).max())
    m = len(place.anchors)
    for got, wanted in ((found.anchors, anchors), (found.attachments, attachments)):
        every = np.zeros(wanted.shape)
        every[..., np.arange(m), np.arange(m), :] = got
        np.testing.assert_allclose(every, wanted, atol=CLOSE * np.abs(wanted).max())


@pytest.mark.parametrize("name", PLANAR + SPATIAL)
def test_weight_derivative(name, rng):
    place = Place(name, rng, 10)
    pose, *_ = slopes(place, lambda p: p.weight[0])
    np.testing.assert_allclose(place.weight[1], pose, atol=1e-6)


def agree(found, wanted, smooth, least):
    """Gradients equal finite differences where smooth; finite differences are too rough next to a kink."""
    for got, fine in zip((found.pose, found.anchors, found.attachments), wanted, strict=True):
        size = np.abs(fine[smooth]).max()
        wrong = np.abs(got - fine)[smooth] > CLOSE * size
        assert wrong.reshape(smooth.sum(), -1).any(axis=-1).sum() <= least


@pytest.mark.parametrize("name", [name for name in EVERY if "cogiro" not in name])
def test_tension_factor_gradient(name, rng):
    """Redundancy 1 (planar robots, Eq. 12) and 2 (IPAnema): poses, anchors and attachments."""
    place = Place(name, rng, 60 if "ipanema-2" in name else 100)
    found = gradient(tension_factor_slope(place.structure), place.derivatives)
    np.testing.assert_allclose(found.value, tension_factor(place.structure), atol=1e-12)
    inside = found.smooth & (found.value > 0.01)
    assert inside.sum() >= 15
    agree(found, slopes(place, lambda p: tension_factor(p.structure)), inside, 1)
    outside = found.smooth & (found.value == 0.0)
    for part in (found.pose, found.anchors, found.attachments):
        assert not part[outside].any()


@pytest.mark.parametrize("name", EVERY)
def test_capacity_margin_gradient(name, rng):
    place = Place(name, rng, 40)
    robot, length = place.robot, characteristic_length(place.attachments)
    load, turning = place.weight

    def margin(p):
        return capacity_margin(p.structure, robot.lower, robot.upper, p.weight[0], length)

    slope = capacity_margin_slope(place.structure, load, robot.lower, robot.upper, length)
    found = gradient(slope, place.derivatives, turning)
    np.testing.assert_allclose(found.value, margin(place), rtol=1e-9, atol=1e-9 * robot.upper.max())
    assert found.smooth.sum() >= 30
    assert "planar-4-4" in name or (found.value > 0.0).any()
    agree(found, slopes(place, margin), found.smooth, 1)


@pytest.mark.parametrize("name", EVERY)
def test_margin_gradient(name, rng):
    """The depth in the tension box, of one cable too many (planar robots) and of two (spatial ones)."""
    place = Place(name, rng, 100 if "ipanema" not in name and "cogiro" not in name else 20)
    robot = place.robot
    load, turning = place.weight

    def margin(p):
        return distribute(p.structure, p.weight[0], robot.lower, robot.upper, "max-margin").margin

    found = gradient(margin_slope(place.structure, load, robot.lower, robot.upper), place.derivatives, turning)
    np.testing.assert_allclose(found.value, margin(place), rtol=1e-8, atol=1e-10)
    assert found.smooth.sum() >= 0.9 * len(load)
    agree(found, slopes(place, margin), found.smooth, 1)


@pytest.mark.parametrize(("rows", "cables"), ((3, 3), (3, 6), (6, 6), (6, 7), (6, 8), (6, 10)))
def test_margin_slope_of_any_number_of_cables_against_a_linear_program(rows, cables, rng):
    """Depth, and its slopes in every entry, are those of max d, lower + d <= f <= upper - d, structure f + w = 0."""
    structure, load = np.linalg.qr(rng.normal(size=(cables, rows)))[0].T, rng.normal(size=rows)
    lower, upper = rng.uniform(0.0, 1.0, cables), rng.uniform(5.0, 9.0, cables)
    slope = margin_slope(structure, load, lower, upper)
    assert slope.smooth
    assert slope.value == pytest.approx(depth_by_simplex(structure, load, lower, upper), abs=1e-9)
    for _ in range(10):
        change, push = rng.normal(size=structure.shape), rng.normal(size=rows)
        ahead, behind = (depth_by_simplex(structure + s * change, load + s * push, lower, upper) for s in (1e-5, -1e-5))
        wanted = np.sum(slope.structure * change) + slope.wrench @ push
        assert (ahead - behind) / 2e-5 == pytest.approx(wanted, rel=1e-3, abs=1e-4)


def depth_by_simplex(structure, load, lower, upper):
    """Greatest depth in the tension box over half its widest window, by HiGHS."""
    m = len(lower)
    rows = np.hstack((np.vstack((-np.eye(m), np.eye(m))), np.ones((2 * m, 1))))
    answer = linprog(
        -np.eye(m + 1)[m],
        A_ub=rows,
        b_ub=np.concatenate((-lower, upper)),
        A_eq=np.hstack((structure, np.zeros((len(load), 1)))),
        b_eq=-load,
        bounds=(None, None),
    )
    return -answer.fun / (0.5 * np.max(upper - lower))


def test_depth_is_capped_by_the_narrowest_window():
    """A cable with hardly a choice sets the depth by itself, whatever the pose: no slope, and smooth."""
    structure = np.array([[1.0, -1.0, 0.0, 0.0, 0.3], [0.0, 0.0, 1.0, -1.0, 0.1], [1.0, 1.0, -1.0, -1.0, -0.4]])
    lower, upper = np.zeros(5), np.array([10.0, 10.0, 10.0, 10.0, 0.1])
    slope = margin_slope(structure, np.zeros(3), lower, upper)
    assert slope.value == pytest.approx(depth_by_simplex(structure, np.zeros(3), lower, upper))
    assert slope.value == pytest.approx(0.01)
    assert slope.smooth and not slope.structure.any() and not slope.wrench.any()


@pytest.mark.parametrize("scale", (1e-9, 1e9))
def test_slopes_do_not_depend_on_units(scale, rng):
    place = Place("ipanema-2", rng, 20)
    matrix = place.structure.copy()
    plain = tension_factor_slope(matrix)
    matrix[:, :3] *= scale
    scaled = tension_factor_slope(matrix)
    np.testing.assert_array_equal(scaled.smooth, plain.smooth)
    np.testing.assert_allclose(scaled.value, plain.value, rtol=1e-9)
    back = scaled.structure.copy()
    back[:, :3] *= scale
    np.testing.assert_allclose(back, plain.structure, rtol=1e-6, atol=1e-9)
    load, robot, length = place.weight[0], place.robot, 0.7
    before = capacity_margin_slope(place.structure, load, 0.0, robot.upper, length)
    after = capacity_margin_slope(
        matrix, scale * load * np.repeat([scale, 1.0], 3), 0.0, scale * robot.upper, scale * length
    )
    np.testing.assert_allclose(after.value, scale * before.value, rtol=1e-9)
    np.testing.assert_allclose(after.wrench[:, :3] * scale, before.wrench[:, :3], atol=1e-9)


def test_kinks_are_said_to_be_kinks():
    """On the axes of symmetry of a symmetric robot two facets tie."""
    robot = load_cable_robot("planar-4-4")
    slope = tension_factor_slope(robot.structure([5.0, 3.0, 0.05]))
    assert slope.value > 0.0
    assert not slope.smooth


def test_at_a_kink_no_direction_rises_faster_than_the_slope(rng):
    """One-sided differences, at the tie of two facets: the least of the tied slopes, so at most the one returned."""
    robot = load_cable_robot("planar-4-4")
    place = robot.structure([5.0, 3.0, 0.05])
    bounds = (robot.lower, robot.upper)
    questions = (
        (tension_factor_slope(place), tension_factor),
        (margin_slope(place, np.zeros(3), *bounds), lambda s: distribute(s, np.zeros(3), *bounds, "max-margin").margin),
    )
    for slope, measure in questions:
        assert not slope.smooth
        steeper = 0
        for _ in range(50):
            change = rng.normal(size=place.shape)
            rise = (measure(place + 1e-6 * change) - measure(place)) / 1e-6
            foreseen = np.sum(slope.structure * change)
            assert rise <= foreseen + 1e-4 * np.abs(slope.structure).max()
            steeper += rise < foreseen - 1e-3 * np.abs(slope.structure).max()
        assert steeper > 5


def test_singular_and_hostile_matrices_have_no_slope():
    flat = np.zeros((3, 4))
    flat[0] = 1.0
    bad = np.full((3, 4), np.nan)
    for matrix in (flat, bad, np.zeros((3, 4))):
        factor = tension_factor_slope(matrix)
        assert factor.value == 0.0
        assert np.isnan(factor.structure).all()
        for slope in (
            capacity_margin_slope(matrix, np.ones(3), 1.0, 2.0, 0.1),
            margin_slope(matrix, np.ones(3), 1.0, 2.0),
        ):
            assert slope.value == -np.inf
            assert np.isnan(slope.structure).all()
            assert not slope.smooth
        assert not factor.smooth


@pytest.mark.parametrize("bounds", ((2.0, 1.0), (0.0, np.inf), (np.nan, 1.0), (1.0, 1.0)))
def test_bounds_that_are_no_window_are_refused(bounds):
    for function in (lambda *a: capacity_margin_slope(*a, 0.1), margin_slope):
        with pytest.raises(InputError, match="tension limits"):
            function(np.eye(3, 4), np.ones(3), *bounds)


def test_fuzzed_robots_have_a_slope_or_none(rng):
    """Coincident anchors, cables without length, entries that are not numbers: finite where smooth, never an error."""
    for _ in range(300):
        cables = int(rng.integers(4, 7))
        anchors, attachments = rng.integers(-2, 3, (5, cables, 2)) * 1.0, rng.integers(-1, 2, (cables, 2)) * 1.0
        anchors[rng.random(anchors.shape) < 0.01] = np.nan
        pose = rng.integers(-1, 2, (5, 3)) * [1.0, 1.0, np.pi / 4]
        derivatives = planar_structure_derivatives(anchors, attachments, pose)
        structure = planar_structure_matrix(anchors, attachments, pose)
        load = rng.integers(-2, 3, 3) * 1.0
        slopes_found = [tension_factor_slope(structure), capacity_margin_slope(structure, load, 1.0, 9.0, 0.5)]
        if cables == 4:
            slopes_found.append(margin_slope(structure, load, 1.0, 9.0))
        for slope in slopes_found:
            found = gradient(slope, derivatives)
            whole = found.smooth & np.isfinite(derivatives.pose).all(axis=(-3, -2, -1))
            assert np.isfinite(found.pose[whole]).all()
            assert np.isfinite(found.anchors[whole]).all()
            assert np.isfinite(found.value[whole]).all()


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"structure": np.ones(3)}, "structure"),
        ({"structure": "rows"}, "structure"),
        ({"structure": np.ones((7, 9))}, "structure"),
        ({"wrench": np.ones(6)}, "wrench"),
        ({"wrench": np.ones((2, 3)), "structure": np.ones((5, 3, 4))}, "wrench"),
        ({"lower": np.ones(3)}, "tension limits"),
        ({"upper": "much"}, "tension limits"),
        ({"length": 0.0}, "characteristic length"),
        ({"length": np.nan}, "characteristic length"),
    ],
)
def test_questions_that_are_none_are_refused(changes, where):
    given = {"structure": np.eye(3, 4), "wrench": np.ones(3), "lower": 1.0, "upper": 9.0, "length": 0.5} | changes
    with pytest.raises(InputError) as error:
        capacity_margin_slope(**given)
    assert error.value.where == where


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"anchors": np.zeros((4, 2))}, "anchors"),
        ({"attachments": np.zeros(3)}, "attachments"),
        ({"position": np.zeros(2)}, "position"),
        ({"rotation": np.eye(2)}, "rotation"),
        ({"rotation": np.tile(np.eye(3), (2, 1, 1)), "position": np.zeros((3, 3))}, "rotation"),
        ({"axes": np.ones((3, 3)), "radii": 0.1}, "axes"),
        ({"axes": np.ones((4, 3)), "radii": -0.1}, "radii"),
        ({"axes": np.ones((4, 3)), "radii": np.ones(3)}, "radii"),
    ],
)
def test_geometry_that_does_not_fit_is_refused(changes, where):
    given = {
        "anchors": np.eye(4, 3), "attachments": np.zeros((4, 3)), "position": np.ones(3), "rotation": np.eye(3),
    }  # fmt: skip
    with pytest.raises(InputError) as error:
        spatial_structure_derivatives(**(given | changes))
    assert error.value.where == where


def test_one_bad_pose_leaves_the_others_alone(rng):
    """An attachment inside its pulley and a cable without length, each in one pose of a batch."""
    anchors, attachments = rng.uniform(-3.0, 3.0, (8, 3)), rng.uniform(-0.3, 0.3, (8, 3))
    for radii, place in ((0.0, anchors[2] - attachments[2]), (0.2, anchors[2] - attachments[2] + [0.1, 0.0, 0.0])):
        places = np.stack((np.zeros(3), place))
        found = spatial_structure_derivatives(
            anchors, attachments, places, np.eye(3), np.tile([0.0, 0.0, 1.0], (8, 1)), radii
        )
        np.testing.assert_array_equal(np.isfinite(found.pose).all(axis=(1, 2, 3)), [True, False])
        assert np.isnan(found.anchors[1, :, 2]).any() and np.isfinite(found.anchors[1, :, 3]).all()
