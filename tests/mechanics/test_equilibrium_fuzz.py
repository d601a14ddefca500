"""Five hundred random robots, many of them hopeless: an answer for each, and no equilibrium that does not balance."""

from __future__ import annotations

import time

import numpy as np
import pytest

from steeplejack.mechanics.cable import (
    Equilibrium,
    LockedPlatform,
    Rest,
    natural_frequencies,
    pulley_runs,
    settle,
)
from steeplejack.mechanics.cable.rest.modes import planar_mass_matrix, spatial_mass_matrix
from steeplejack.spatial import from_vector

pytestmark = pytest.mark.long

ROBOTS = 250  # of each dimension
CLOSE = 1e-8  # [1] residual over the greatest force, and strain of inextensible cables, of an equilibrium


def robot(rng: np.random.Generator, axes: int):
    """A platform and a start: lattice points (coincident anchors and attachments), pulleys, no load, any lengths."""
    m = int(rng.integers(1, 9))
    lattice = rng.random() < 0.5
    anchors = rng.integers(-2, 3, (m, axes)) * 1.0 if lattice else rng.normal(size=(m, axes)) * 3.0
    local = rng.integers(-1, 2, (m, axes)) * 0.5 if lattice else rng.normal(size=(m, axes)) * 0.4
    elastic = 10.0 ** rng.uniform(1.0, 7.0, m)
    elastic[rng.random(m) < rng.choice([0.0, 0.3, 1.0])] = np.inf
    wheels = {}
    if rng.random() < 0.3:
        wheels = {"radii": rng.uniform(0.0, 0.3, m), "axes": rng.normal(size=(m, axes))}
    if axes == 2 and rng.random() < 0.1:
        wheels["moment"] = float(rng.normal())
    lengths, scale = rng.choice([0.3, 1.0, 3.0]) * rng.uniform(0.2, 2.0, m), 10.0 ** rng.choice([0, 0, -6, 6])
    load = rng.normal(size=axes) * rng.choice([0.0, 10.0, 1e4])
    make = LockedPlatform.planar if axes == 2 else LockedPlatform.spatial
    wheels = {name: value * (scale if name in ("radii", "moment") else 1.0) for name, value in wheels.items()}
    platform = make(
        scale * anchors, scale * local, scale * lengths, load,
        axial_stiffness=elastic, centre=scale * rng.normal(size=axes) * 0.2, **wheels,
    )  # fmt: skip
    place = scale * (rng.integers(-2, 3, axes) * 1.0 if lattice else rng.normal(size=axes))
    turn = rng.normal(size=3) * rng.choice([0.0, 1.0])
    return platform, place, float(turn[2]) if axes == 2 else from_vector(turn)


def unbalance(platform: LockedPlatform, rest: Equilibrium) -> float:
    """Residual wrench from the definition, moments over the radius of gyration, over the greatest force."""
    ends = platform.attachments @ rest.rotation.T
    _lengths, along = pulley_runs(platform.anchors, platform.axes, platform.radii, rest.position + ends)
    pulls = np.where(rest.taut[:, None], rest.tensions[:, None] * along, 0.0)
    centre = rest.rotation @ platform.points[0]
    arms = np.vstack((ends - centre, platform.points @ rest.rotation.T - centre))
    forces = np.vstack((pulls, platform.forces))
    moment = np.cross(arms, forces).sum(axis=0) + [0.0, 0.0, platform.moment]
    left = np.concatenate((moment / platform.gyration, forces.sum(axis=0)))[platform.freedoms]
    return float(np.abs(left).max() / max(platform.load, rest.tensions.max()))


def strain(platform: LockedPlatform, rest: Equilibrium) -> float:
    """How far tensions are from what the lengths say, over EA or, of inextensible cables, over the length."""
    stretch = rest.lengths / platform.unstressed - 1.0
    with np.errstate(invalid="ignore"):
        elastic = np.abs(np.where(np.isinf(platform.axial_stiffness), 0.0, rest.tensions / platform.axial_stiffness))
    wanted = np.maximum(stretch, 0.0)
    return float(np.abs(wanted - elastic).max())


@pytest.mark.parametrize("axes", (2, 3))
def test_settle_answers_and_every_equilibrium_balances(axes, rng):
    ends, slowest = dict.fromkeys(Rest, 0), 0.0
    settle(*robot(rng, axes))  # compiles
    for case in range(ROBOTS):
        platform, place, turn = robot(rng, axes)
        began = time.process_time()
        rest = settle(platform, place, turn)
        slowest = max(slowest, time.process_time() - began)
        ends[rest.status] += 1
        if rest.status not in (Rest.STABLE, Rest.NEUTRAL):
            continue
        assert np.isfinite(rest.position).all() and np.isfinite(rest.stiffness).all(), case
        assert (rest.tensions >= 0.0).all(), case
        assert unbalance(platform, rest) < CLOSE, case
        assert strain(platform, rest) < CLOSE, case
        if axes == 2:
            mass = planar_mass_matrix(1.0, platform.gyration**2, platform.points[0, :2], rest.phi)
        else:
            mass = spatial_mass_matrix(1.0, 0.5 * platform.gyration**2 * np.eye(3), platform.points[0], rest.rotation)
        swings = natural_frequencies(rest, mass)
        assert rest.status is Rest.NEUTRAL or np.isfinite(swings).all(), case
    assert ends[Rest.STABLE] > 0.3 * ROBOTS
    assert ends[Rest.UNFINISHED] + ends[Rest.UNDEFINED] + ends[Rest.LOOSE] > 0  # hopeless ones are among them
    assert slowest < 3.0  # [s] 0.1 when measured; a hang is what is looked for
