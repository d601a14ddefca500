"""Geometrico-static equilibria: derivatives, closed forms, slack cables, inextensible limits, stability, bad input."""

from __future__ import annotations

import numpy as np
import pytest
from hanging import hanging

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    LockedPlatform,
    Rest,
    equilibria,
    natural_frequencies,
    pulley_runs,
    settle,
    spatial_structure_matrix,
)
from steeplejack.mechanics.cable.rest.modes import planar_mass_matrix, spatial_mass_matrix
from steeplejack.mechanics.cable.rest.potential import bounded_step, evaluate
from steeplejack.spatial import from_vector

pytestmark = pytest.mark.long

SEEDS = range(12)


def energy(platform: LockedPlatform, position, rotation) -> float:
    """Potential from the definition."""
    ends = position + platform.attachments @ rotation.T
    lengths, _along = pulley_runs(platform.anchors, platform.axes, platform.radii, ends)
    stretch = np.maximum(lengths - platform.unstressed, 0.0)
    elastic = np.sum(0.5 * platform.axial_stiffness / platform.unstressed * stretch**2)
    return float(elastic - np.sum(platform.forces * (position + platform.points @ rotation.T)))


def with_pulleys(platform: LockedPlatform) -> LockedPlatform:
    m = len(platform.anchors)
    return LockedPlatform.spatial(
        platform.anchors,
        platform.attachments,
        platform.unstressed + 0.1,
        platform.forces[0],
        axial_stiffness=platform.axial_stiffness,
        centre=platform.points[0],
        forces=[[3.0, -2.0, 5.0]],
        points=[[0.2, 0.1, -0.1]],
        radii=np.full(m, 0.08),
        axes=np.tile([0.0, 0.0, 1.0], (m, 1)),
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_gradient_and_hessian_by_finite_differences(seed):
    case = hanging(seed)
    for platform in (case.platform, with_pulleys(case.platform)):
        spring = platform.axial_stiffness / platform.unstressed

        def at(x, platform=platform, spring=spring):
            gradient, hessian, tensions = np.empty(6), np.empty((6, 6)), np.empty(len(spring))
            turn = from_vector(np.array(x[:3])) @ case.rotation
            robot = (platform.anchors, platform.axes, platform.radii, platform.attachments, platform.unstressed)
            value = evaluate(
                robot, (platform.forces, platform.points, 0.0), spring, np.zeros(len(spring)),
                case.position + x[3:], turn, 0.0, gradient, hessian, tensions,
            )  # fmt: skip
            return value, gradient, hessian

        value, gradient, hessian = at(np.zeros(6))
        assert value == pytest.approx(energy(platform, case.position, case.rotation), rel=1e-12)
        h, unit = 1e-5, np.eye(6)
        slope = [(at(h * e)[0] - at(-h * e)[0]) / (2 * h) for e in unit]
        np.testing.assert_allclose(slope, gradient, atol=1e-5 * np.abs(gradient).max())
        h = 1e-3
        second = [
            [sum(a * b * at(h * (a * e + b * f))[0] for a in (1, -1) for b in (1, -1)) / (4 * h * h) for f in unit]
            for e in unit
        ]
        lengths, _along = pulley_runs(
            platform.anchors, platform.axes, platform.radii,
            case.position + platform.attachments @ case.rotation.T,
        )  # fmt: skip
        if np.abs(lengths - platform.unstressed).min() > 3e-3:  # no cable goes taut within the stencil
            np.testing.assert_allclose(second, hessian, atol=1e-4 * np.abs(hessian).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_forces_balance_and_the_energy_is_least(seed):
    case = hanging(seed)
    rest = settle(case.platform, case.position, case.rotation)
    assert rest.status is Rest.STABLE
    structure = spatial_structure_matrix(case.platform.anchors, case.platform.attachments, rest.position, rest.rotation)
    weight = case.platform.forces[0]
    load = np.concatenate((np.cross(rest.rotation @ case.centre, weight), weight))
    assert np.abs(structure @ rest.tensions + load).max() < 1e-8 * np.abs(weight).max()
    stretch = np.maximum(rest.lengths - case.platform.unstressed, 0.0)
    np.testing.assert_allclose(
        rest.tensions, case.platform.axial_stiffness / case.platform.unstressed * stretch, atol=1e-6
    )
    assert rest.energy == pytest.approx(energy(case.platform, rest.position, rest.rotation), rel=1e-9)
    rng = np.random.default_rng(seed)
    for _ in range(50):
        x = rng.normal(size=6) * 1e-2
        turn = from_vector(x[:3].copy()) @ rest.rotation
        assert energy(case.platform, rest.position + x[3:], turn) >= rest.energy


def test_slack_cables_are_among_the_cases():
    rests = [settle(case.platform, case.position, case.rotation) for case in map(hanging, SEEDS)]
    assert any(rest.taut.all() for rest in rests) and any(not rest.taut.all() for rest in rests)


def test_a_lamp_on_one_cable_hangs_straight_down():
    """Length L + mg L / EA, frequency of the pendulum and of the spring, as by hand."""
    mass, stiffness, length, radius = 3.0, 5e3, 2.0, 0.2
    weight = mass * 9.81
    platform = LockedPlatform.planar(
        [[1.0, 4.0]], [[0.0, 0.0]], length, [0.0, -weight], axial_stiffness=stiffness, gyration=radius
    )
    rest = settle(platform, [2.0, 3.5], 0.4)
    assert rest.status is Rest.NEUTRAL  # a point mass: turning it about its attachment costs nothing
    stretched = length * (1.0 + weight / stiffness)
    np.testing.assert_allclose(rest.position[:2], [1.0, 4.0 - stretched], atol=1e-9)
    arm = LockedPlatform.planar(
        [[1.0, 4.0]], [[0.0, 0.3]], length, [0.0, -weight], axial_stiffness=stiffness, gyration=radius
    )
    rest = settle(arm, [2.0, 3.5], 0.4)
    assert rest.stable
    np.testing.assert_allclose(rest.pose, [1.0, 4.0 - stretched - 0.3, 0.0], atol=1e-8)
    found = natural_frequencies(rest, planar_mass_matrix(mass, mass * radius**2, [0.0, 0.0], rest.phi))
    # Double pendulum of a massless string and a rigid body, from its characteristic polynomial; and the bounce.
    a, b, g = stretched, 0.3, 9.81
    squares = np.roots([a * radius**2, -g * (radius**2 + b * (a + b)), g * g * b])
    swing = np.sqrt(np.sort(squares))
    bounce = np.sqrt(stiffness / length / mass)
    np.testing.assert_allclose(found * 2.0 * np.pi, [*swing, bounce], rtol=1e-6)


def test_an_upside_down_start_falls_over():
    """On an unstable rest the descent leaves it, and ends below."""
    platform = LockedPlatform.planar([[0.0, 0.0]], [[0.0, 0.3]], 1.0, [0.0, -10.0], axial_stiffness=1e3, gyration=0.1)
    balanced = 1.0 * (1.0 + 10.0 / 1e3)
    rest = settle(platform, [0.0, -balanced + 0.3], np.pi)
    assert rest.stable and rest.steps > 3
    np.testing.assert_allclose(rest.position[:2], [0.0, -balanced - 0.3], atol=1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_stiffer_and_stiffer_cables_tend_to_inextensible_ones(seed):
    case = hanging(seed)
    platform = case.platform
    places = []
    for stiffness in (1e6, 1e8, np.inf):
        same = LockedPlatform.spatial(
            platform.anchors, platform.attachments, platform.unstressed, platform.forces[0],
            axial_stiffness=stiffness, centre=case.centre,
        )  # fmt: skip
        rest = settle(same, case.position, case.rotation)
        assert rest.status is Rest.STABLE
        places.append(rest.position)
    assert np.all(rest.lengths <= platform.unstressed * (1.0 + 1e-9))
    np.testing.assert_allclose(rest.lengths[rest.taut], platform.unstressed[rest.taut], rtol=1e-9)
    assert rest.free.shape[1] >= 6 - rest.taut.sum()
    assert np.linalg.norm(places[1] - places[2]) <= 0.02 * np.linalg.norm(places[0] - places[2]) + 1e-9


def test_frequencies_of_inextensible_cables_are_the_limit_of_elastic_ones():
    case = hanging(3)
    platform = case.platform
    found = []
    for stiffness in (1e9, np.inf):
        same = LockedPlatform.spatial(
            platform.anchors, platform.attachments, platform.unstressed, platform.forces[0],
            axial_stiffness=stiffness, centre=case.centre,
        )  # fmt: skip
        rest = settle(same, case.position, case.rotation)
        mass = spatial_mass_matrix(case.mass, case.inertia, case.centre, rest.rotation)
        found.append(natural_frequencies(rest, mass))
    assert 0 < len(found[1]) < 6
    np.testing.assert_allclose(found[0][: len(found[1])], found[1], rtol=1e-4)


@pytest.mark.parametrize(("length", "force"), [(1e-9, 1.0), (1e9, 1.0), (1.0, 1e-9), (1.0, 1e9)])
def test_units_do_not_matter(length, force):
    case = hanging(5)
    platform = case.platform
    rest = settle(platform, case.position, case.rotation)
    other = settle(
        LockedPlatform.spatial(
            length * platform.anchors, length * platform.attachments, length * platform.unstressed,
            force * platform.forces[0], axial_stiffness=force * platform.axial_stiffness, centre=length * case.centre,
        ),
        length * case.position,
        case.rotation,
    )  # fmt: skip
    assert other.status is rest.status and (other.taut == rest.taut).all()
    np.testing.assert_allclose(other.position / length, rest.position, atol=1e-8)
    np.testing.assert_allclose(other.tensions / force, rest.tensions, atol=1e-5)


def test_several_equilibria_are_told_apart():
    """A bar wider than its anchors hangs parallel, or upside down on crossed cables: depths by Pythagoras."""
    platform = LockedPlatform.planar([[-0.3, 0.0], [0.3, 0.0]], [[-0.5, 0.0], [0.5, 0.0]], 1.5, [0.0, -50.0])
    rng = np.random.default_rng(1)
    found = equilibria(platform, rng.uniform([-1, -2], [1, 0.5], (40, 2)), rng.uniform(-np.pi, np.pi, 40))
    assert len(found) == 2
    assert all(rest.stable for rest in found)
    depths = [np.sqrt(1.5**2 - 0.2**2), np.sqrt(1.5**2 - 0.8**2)]
    np.testing.assert_allclose([rest.position for rest in found], [[0.0, -depth, 0.0] for depth in depths], atol=1e-8)
    np.testing.assert_allclose(np.cos([rest.phi for rest in found]), [1.0, -1.0], atol=1e-12)
    np.testing.assert_allclose([rest.energy for rest in found], [-50.0 * depth for depth in depths], atol=1e-8)


def test_nothing_to_hold_on_to():
    loose = LockedPlatform.planar([[0.0, 0.0], [2.0, 0.0]], [[0.0, 0.0], [0.1, 0.0]], 5.0, [0.0, 0.0])
    assert settle(loose, [1.0, -1.0], 0.0).status is Rest.LOOSE
    held = LockedPlatform.planar(
        [[-1.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 0.0]], 0.9, [0.0, 0.0], axial_stiffness=[np.inf, 1e3]
    )  # pretension without a load: the inextensible cable holds against the elastic one
    rest = settle(held, [0.1, 0.1], 0.0)
    np.testing.assert_allclose(rest.position[:2], [-0.1, 0.0], atol=1e-7)
    np.testing.assert_allclose(rest.tensions, 1e3 / 0.9 * 0.2, rtol=1e-6)
    spun = LockedPlatform.planar([[0.0, 0.0]], [[0.0, 0.0]], 1.0, [0.0, -1.0], axial_stiffness=1e3, moment=2.0)
    assert settle(spun, [0.0, -1.0], 0.0).status is Rest.UNFINISHED
    short = LockedPlatform.planar([[-1.0, 0.0], [1.0, 0.0]], [[-0.1, 0.0], [0.1, 0.0]], 0.8, [0.0, -1.0])
    assert settle(short, [0.0, -0.1], 0.0).status is Rest.UNFINISHED  # no pose has both lengths
    inside = LockedPlatform.planar(
        [[0.0, 0.0]], [[0.0, 0.0]], 1.0, [0.0, -1.0], radii=0.5, axes=[[0.0, 1.0]], gyration=0.1
    )
    assert settle(inside, [0.4, 0.1], 0.0).status is Rest.UNDEFINED
    assert all(rest.advice for rest in Rest)


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"unstressed": 0.0}, "unstressed"),
        ({"unstressed": [1.0, np.nan]}, "unstressed"),
        ({"axial_stiffness": -1.0}, "axial_stiffness"),
        ({"anchors": [[0.0, np.inf], [1.0, 0.0]]}, "anchors"),
        ({"attachments": [[0.0, 0.0]]}, "attachments"),
        ({"weight": [0.0, 0.0, -1.0]}, "forces"),
        ({"radii": -0.1, "axes": [[0.0, 1.0], [0.0, 1.0]]}, "radii"),
        ({"radii": 0.1}, "axes"),
        ({"radii": 0.1, "axes": [[0.0, 0.0], [0.0, 1.0]]}, "axes"),
        ({"moment": np.nan}, "moment"),
        ({"gyration": 0.0}, "gyration"),
    ],
)
def test_bad_input_is_named(change, where):
    good = {
        "anchors": [[0.0, 0.0], [1.0, 0.0]],
        "attachments": [[0.0, 0.0], [0.1, 0.0]],
        "unstressed": 1.0,
        "weight": [0.0, -1.0],
    }
    with pytest.raises(InputError, match=where):
        LockedPlatform.planar(**(good | change))


def test_a_start_has_to_be_a_pose():
    platform = hanging(0).platform
    with pytest.raises(InputError, match="position"):
        settle(platform, [0.0, 0.0], np.eye(3))
    with pytest.raises(InputError, match="rotation"):
        settle(platform, np.zeros(3), 2.0 * np.eye(3))
    with pytest.raises(InputError, match="position"):
        settle(platform, "here", np.eye(3))
    with pytest.raises(InputError, match="rotation"):
        settle(platform, np.zeros(3), np.nan)
    with pytest.raises(InputError, match="rotation"):
        settle(LockedPlatform.planar([[0.0, 1.0]], [[0.0, 0.0]], 1.0, [0.0, -1.0]), np.zeros(2), np.inf)
    with pytest.raises(InputError, match="positions and rotations"):
        equilibria(platform, np.zeros((3, 3)), np.tile(np.eye(3), (2, 1, 1)))
    rest = settle(platform, np.zeros(3), np.eye(3))
    for bad in (np.eye(3), -np.eye(6), np.eye(6) + np.eye(6, k=1), np.full((6, 6), np.nan)):
        with pytest.raises(InputError, match="mass matrix"):
            natural_frequencies(rest, bad)


def test_bounded_steps_are_the_least_in_the_ball(rng):
    """Against dense sampling, hard cases (no slope along the least eigenvalue) included."""
    for trial in range(200):
        values, slopes = np.sort(rng.normal(size=3)), rng.normal(size=3)
        slopes[0] *= float(trial % 3 > 0)
        radius, step = rng.uniform(0.1, 3.0), np.empty(3)
        bounded_step(values, slopes, radius, 1e-12, 1e-12, step)
        assert np.linalg.norm(step) <= radius * (1.0 + 1e-12)
        points = rng.normal(size=(4000, 3))
        points *= radius * rng.random((4000, 1)) ** (1 / 3) / np.linalg.norm(points, axis=1, keepdims=True)

        def model(p, values=values, slopes=slopes):
            return p @ slopes + 0.5 * (p * p) @ values

        least = model(points).min()
        assert model(step) <= least + 0.15 * abs(least)


def test_a_platform_that_falls_onto_its_pulley_has_no_rest():
    """The cable loses its course at the rim: no equilibrium is claimed there, and nothing is raised."""
    platform = LockedPlatform.planar(
        [[0.0, 0.0]], [[0.0, 0.0]], 5.0, [0.0, -100.0], radii=0.3, axes=[[0.0, 1.0]], gyration=0.1
    )
    rest = settle(platform, [0.3, 1.0], 0.3)
    assert rest.status is Rest.UNFINISHED
    np.testing.assert_allclose(rest.position[:2], [0.3, 0.3], atol=1e-6)


def test_a_start_inside_a_pulley_has_no_stiffness():
    platform = LockedPlatform.planar(
        [[0.0, 0.0]], [[0.0, 0.0]], 5.0, [0.0, -100.0], radii=0.3, axes=[[0.0, 1.0]], gyration=0.1
    )
    rest = settle(platform, [0.3, 0.1], 0.3)
    assert rest.status is Rest.UNDEFINED
    assert np.isnan(rest.stiffness).all() and np.isnan(rest.energy)
    assert natural_frequencies(rest, np.eye(3)).size == 0


def test_tension_that_is_only_rounding_is_none():
    """A platform without load that was pulled in hangs loose, not in an equilibrium of 1e-13 N."""
    platform = LockedPlatform.planar([[0.0, 1.0]], [[0.0, 0.1]], 1.0, [0.0, 0.0], axial_stiffness=100.0)
    rest = settle(platform, [3.0, 0.7], 0.9)
    assert rest.status is Rest.LOOSE
