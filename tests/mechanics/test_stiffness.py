"""Stiffness against finite differences of wrench and energy at locked winches, and against MuJoCo."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.pulleys import pulley_runs
from steeplejack.mechanics.cable.rest.stiffness import cable_rates, planar_stiffness, spatial_stiffness

STEP = 1e-6
AXIAL = 2e4


class Machine:
    """A random asymmetric robot at a random rotated pose with locked winches, in tension but not in equilibrium."""

    def __init__(self, rng, cables, radius=0.0):
        self.anchors = rng.uniform(-4.0, 4.0, (cables, 3)) + [0.0, 0.0, 3.0]
        self.attachments = rng.uniform(-0.5, 0.5, (cables, 3))
        self.radii = np.full(cables, radius)
        self.axes = rng.normal(size=(cables, 3))
        self.position, self.rotation = rng.uniform(-0.5, 0.5, 3), Rotation.random(rng=rng)
        self.weight, self.centre = np.array([20.0, -10.0, -300.0]), np.array([0.05, -0.1, 0.2])
        self.tensions = rng.uniform(50.0, 500.0, cables)
        self.unstressed = self.lengths(np.zeros(6)) / (1.0 + self.tensions / AXIAL)

    def place(self, move):
        """Position and rotation after a move (rotation; displacement)."""
        return self.position + move[3:], (Rotation.from_rotvec(move[:3]) * self.rotation).as_matrix()

    def lengths(self, move):
        """Cable lengths after a move."""
        position, rotation = self.place(move)
        return pulley_runs(self.anchors, self.axes, self.radii, position + self.attachments @ rotation.T)[0]

    def energy(self, move):
        """Potential after a move, cables slack rather than pushing."""
        position, rotation = self.place(move)
        stretch = np.maximum(self.lengths(move) - self.unstressed, 0.0)
        return np.sum(0.5 * AXIAL / self.unstressed * stretch**2) - self.weight @ (position + rotation @ self.centre)

    def wrench(self, move):
        """Wrench of cables and weight after a move."""
        position, rotation = self.place(move)
        arms = self.attachments @ rotation.T
        lengths, along = pulley_runs(self.anchors, self.axes, self.radii, position + arms)
        pull = (AXIAL / self.unstressed * np.maximum(lengths - self.unstressed, 0.0))[:, None] * along
        lever = rotation @ self.centre
        moment = np.cross(arms, pull).sum(axis=0) + np.cross(lever, self.weight)
        return np.concatenate((moment, pull.sum(axis=0) + self.weight))

    @property
    def stiffness(self):
        """The answer under test."""
        lengths = self.lengths(np.zeros(6))
        rates = cable_rates(AXIAL, lengths, self.tensions)
        return spatial_stiffness(
            self.anchors, self.attachments, *self.place(np.zeros(6)), self.tensions, rates,
            self.weight, self.centre, self.axes, self.radii,
        )  # fmt: skip


@pytest.mark.parametrize("radius", (0.0, 0.07))
@pytest.mark.parametrize("cables", (1, 4, 8))
def test_stiffness_is_the_slope_of_the_wrench_at_locked_winches(radius, cables, rng):
    """Its symmetric part everywhere; what is left is half the cross matrix of the moment that is out of balance."""
    machine = Machine(rng, cables, radius)
    steps = np.eye(6) * STEP
    slope = -np.stack([(machine.wrench(s) - machine.wrench(-s)) / (2 * STEP) for s in steps], axis=-1)
    found = machine.stiffness
    np.testing.assert_allclose(found, 0.5 * (slope + slope.T), atol=1e-5 * np.abs(slope).max())
    x, y, z = machine.wrench(np.zeros(6))[:3]
    skew = np.zeros((6, 6))
    skew[:3, :3] = 0.5 * np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    np.testing.assert_allclose(0.5 * (slope - slope.T), skew, atol=1e-5 * np.abs(slope).max())


@pytest.mark.parametrize("radius", (0.0, 0.07))
def test_stiffness_is_the_hessian_of_the_energy(radius, rng):
    machine = Machine(rng, 7, radius)
    for _ in range(20):
        move = rng.normal(size=6)
        step = 1e-4 * move
        ahead, here, behind = (machine.energy(s * step) for s in (1.0, 0.0, -1.0))
        assert (ahead - 2 * here + behind) / 1e-8 == pytest.approx(move @ machine.stiffness @ move, rel=1e-4)


def test_planar_stiffness_is_the_slope_of_the_planar_wrench(rng):
    anchors, attachments = rng.uniform(-4.0, 4.0, (5, 2)), rng.uniform(-0.5, 0.5, (5, 2))
    pose, tensions, weight, centre = (
        np.array([0.3, -0.2, 0.7]),
        rng.uniform(50.0, 500.0, 5),
        [5.0, -200.0],
        [0.1, -0.05],
    )

    def state(where):
        cos, sin = np.cos(where[2]), np.sin(where[2])
        turn = np.array([[cos, -sin], [sin, cos]])
        arms = attachments @ turn.T
        vectors = anchors - arms - where[:2]
        return arms, vectors, np.linalg.norm(vectors, axis=-1), turn @ centre

    rates = cable_rates(AXIAL, state(pose)[2], tensions)

    def wrench(where):
        arms, vectors, lengths, lever = state(where)
        pull = (tensions + rates * (lengths - state(pose)[2]))[:, None] * vectors / lengths[:, None]
        moment = np.sum(arms[:, 0] * pull[:, 1] - arms[:, 1] * pull[:, 0]) + lever[0] * weight[1] - lever[1] * weight[0]
        return np.append(pull.sum(axis=0) + weight, moment)

    slope = -np.stack([(wrench(pose + s) - wrench(pose - s)) / (2 * STEP) for s in np.eye(3) * STEP], axis=-1)
    found = planar_stiffness(anchors, attachments, pose, tensions, rates, weight, centre)
    np.testing.assert_allclose(found, slope, atol=1e-6 * np.abs(slope).max())


def test_slack_cables_add_nothing_and_batches_are_loops(rng):
    machine = Machine(rng, 6)
    position, rotation = machine.place(np.zeros(6))
    tensions = machine.tensions * rng.choice([0.0, 1.0, -0.1], (5, 6))
    batch = spatial_stiffness(machine.anchors, machine.attachments, position, rotation, tensions, 1e3)
    for pull, found in zip(tensions, batch, strict=True):
        taut = pull > 0.0
        alone = spatial_stiffness(machine.anchors[taut], machine.attachments[taut], position, rotation, pull[taut], 1e3)
        np.testing.assert_allclose(found, alone, rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize(("length", "force"), ((1e-9, 1.0), (1e9, 1.0), (1.0, 1e-9), (1.0, 1e9)))
def test_units_do_not_matter(length, force, rng):
    machine = Machine(rng, 6)
    position, rotation = machine.place(np.zeros(6))
    plain = spatial_stiffness(machine.anchors, machine.attachments, position, rotation, machine.tensions, 1e3)
    scaled = spatial_stiffness(
        machine.anchors * length, machine.attachments * length, position * length, rotation,
        machine.tensions * force, 1e3 * force / length,
    )  # fmt: skip
    units = np.repeat([length, 1.0], 3)
    np.testing.assert_allclose(scaled, plain * np.outer(units, units) * force / length, rtol=1e-9, atol=0.0)


@pytest.mark.parametrize("where", ("anchor", "nan", "infinite"))
def test_hostile_geometry_has_no_stiffness(where, rng):
    machine = Machine(rng, 5)
    position, rotation = machine.place(np.zeros(6))
    anchors = machine.anchors.copy()
    anchors[2] = position + rotation @ machine.attachments[2] if where == "anchor" else np.nan
    if where == "infinite":
        anchors[2] = np.inf
    both = np.stack((machine.anchors, anchors))
    found = spatial_stiffness(both, machine.attachments, position, rotation, machine.tensions, 1e3)
    assert np.isfinite(found[0]).all()
    assert np.isnan(found[1]).all()


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"attachments": np.zeros((4, 2))}, "attachments"),
        ({"attachments": np.zeros((5, 3))}, "anchors"),
        ({"anchors": np.zeros((4, 2))}, "anchors"),
        ({"position": np.zeros(2)}, "position"),
        ({"rotation": np.eye(2)}, "rotation"),
        ({"tensions": np.ones(5)}, "tensions"),
        ({"rates": np.ones(3)}, "rates"),
        ({"weight": np.zeros(2)}, "weight"),
        ({"centre": np.zeros(4)}, "centre"),
        ({"axes": np.ones((3, 3)), "radii": 0.1}, "axes"),
        ({"axes": np.ones((4, 3)), "radii": np.ones(3)}, "radii"),
        ({"position": np.zeros((2, 3)), "tensions": np.ones((3, 4))}, "tensions"),
        ({"position": "here"}, "position"),
        ({"axes": np.ones((4, 3)), "radii": [0.1, 0.1, np.nan, 0.1]}, "radii"),
    ],
)
def test_shapes_that_do_not_fit_are_refused(changes, where):
    given = {
        "anchors": np.eye(4, 3), "attachments": np.zeros((4, 3)), "position": np.ones(3), "rotation": np.eye(3),
        "tensions": np.ones(4), "rates": 1.0,
    }  # fmt: skip
    with pytest.raises(InputError) as error:
        spatial_stiffness(**(given | changes))
    assert error.value.where == where


def test_rates_are_those_of_elastic_cables():
    np.testing.assert_allclose(cable_rates(1e4, [2.0, 2.02], [0.0, 100.0]), [5e3, 5e3], rtol=1e-12)
    np.testing.assert_allclose(cable_rates(1e4, 2.0, -50.0), 5e3)
    assert cable_rates(1e4, 0.0, 1.0) == np.inf
    for stiffness, lengths, where in (
        (-1.0, 1.0, "axial_stiffness"),
        (0.0, 1.0, "axial_stiffness"),
        (1.0, "m", "lengths"),
        ([1.0, 1.0], [1.0, 1.0, 1.0], "lengths"),
    ):
        with pytest.raises(InputError) as error:
            cable_rates(stiffness, lengths, 1.0)
        assert error.value.where == where
