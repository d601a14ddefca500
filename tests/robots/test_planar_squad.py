"""The machine bound to the anchors of Table III."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import certificate_gap
from steeplejack.robots.squad.dynamics import planar_weight
from steeplejack.robots.squad.parameters import load_squad
from steeplejack.robots.squad.planar import PlanarSquad, planar_attachments, stay_directions


@pytest.fixture(scope="module")
def squad(reference):
    return PlanarSquad.of(load_squad(), reference["table_iii"]["anchors"])


def pose(x, y, phi_deg):
    return np.array([x, y, np.deg2rad(phi_deg)])


def eq28(t):
    seconds = np.asarray(t, dtype=float)
    x, y = (2.0 - seconds) / 100.0, (0.8693 * seconds + 23.7107) / 100.0
    return np.stack((x, y, np.full(seconds.shape, np.deg2rad(49.0))), axis=-1)


def test_the_robot_file_has_the_attachments_of_table_iii(squad, reference):
    np.testing.assert_allclose(squad.attachments, reference["table_iii"]["attachments"])


def test_attachments_count_from_the_centre_of_mass():
    import msgspec

    machine = load_squad()
    moved = msgspec.structs.replace(
        machine, platform=msgspec.structs.replace(machine.platform, centre_of_mass=(0.01, -0.02, 0.05))
    )
    np.testing.assert_allclose(planar_attachments(machine) - planar_attachments(moved), [[0.01, -0.02]] * 4)


def test_lengths_and_tension_factors(squad, reference):
    np.testing.assert_allclose(
        squad.lengths(pose(*reference["lengths"]["x_y_phi_deg"])), reference["lengths"]["lengths"], rtol=1e-6
    )
    poses = [pose(*given) for given in reference["tension_factor"]["x_y_phi_deg"]]
    np.testing.assert_allclose(squad.tension_factor(poses), reference["tension_factor"]["factors"], rtol=1e-6)
    assert squad.in_wrench_closure(poses).all()


def test_forward_kinematics_needs_no_start(squad, reference):
    answer = squad.pose(reference["lengths"]["lengths"])
    np.testing.assert_allclose(answer.pose, pose(*reference["lengths"]["x_y_phi_deg"]), atol=1e-7)
    assert answer.unique and answer.converged


def test_mean_tension_factor_along_eq_28(squad, reference):
    assert squad.tension_factor(eq28(np.arange(51))).mean() == pytest.approx(reference["eq28"]["mean"], abs=5e-7)


def test_when_eq_28_leaves_the_workspace(squad, reference):
    inside, outside = 40.0, 50.0
    while outside - inside > 1e-9:
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if squad.in_wrench_closure(eq28(middle)) else (inside, middle)
    assert inside == pytest.approx(reference["eq28"]["leaves"], rel=1e-6)


def test_thirty_kilograms_at_the_best_pose_need_409_newtons(squad, reference):
    given, gravity = reference["workspace"], reference["table_iii"]["gravity"]
    best = pose(*reference["best"]["at"], 50.0)
    assert not squad.tensions(best, given["mass"], tuple(given["window"]), gravity).feasible
    held = squad.tensions(best, given["mass"], (10.0, 1000.0), gravity)
    assert held.tensions.max() == pytest.approx(given["needs"], abs=0.5)


def test_tensions_hold_the_weight_or_prove_they_cannot(squad, reference):
    gravity = reference["table_iii"]["gravity"]
    poses = np.array([pose(-0.15, 0.20, 50.0), pose(-0.10, 0.45, 50.0)])
    answer = squad.tensions(poses, 30.0, (10.0, 250.0), gravity)
    np.testing.assert_array_equal(answer.feasible, [True, False])
    weight = planar_weight(30.0, gravity)
    residual = np.einsum("kij,kj->ki", squad.structure(poses), answer.tensions) + weight
    np.testing.assert_allclose(residual, 0.0, atol=1e-10)
    assert certificate_gap(answer.certificate[1], squad.structure(poses[1]), weight, 10.0, 250.0) > 1.0


def test_stays_under_the_anchors(reference):
    table = reference["table_iii"]
    slope = -np.tan(np.deg2rad(table["upper_stay_deg"]))
    stays = {"1": (-1.0, 0.0), "2": (slope, -slope * table["upper_stay_foot"])}
    directions = stay_directions(table["anchors"], stays)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1.0)
    np.testing.assert_allclose(directions[:, 1] / directions[:, 0], [-1.0, slope, slope, -1.0])
    with pytest.raises(InputError, match="anchor 2.*off the nearest stay"):
        stay_directions(table["anchors"], {"1": (-1.0, 0.0)})


@pytest.mark.parametrize("lengths", [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0, -1.0], [1.0, 2.0, 3.0, np.nan]])
def test_bad_lengths_are_refused(squad, lengths):
    with pytest.raises(InputError, match="lengths"):
        squad.pose(lengths)


@pytest.mark.parametrize("anchors", [[[0.0, 0.0]] * 3, [[0.0, np.nan]] * 4])
def test_bad_anchors_are_refused(anchors):
    with pytest.raises(InputError, match="anchors"):
        PlanarSquad.of(load_squad(), anchors)
