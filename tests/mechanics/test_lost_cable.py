"""A lost cable: the published case, other routes to the same rest, paths that never rise, sweeps, maps, bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hanging import hanging
from scipy.optimize import linprog, minimize

from steeplejack.design.lost_cable import closure_nodes, lost_cable_dataset, worst_cases
from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    LockedPlatform,
    Rest,
    locked_at,
    lost_cable,
    lost_cable_map,
    planar_lengths,
    planar_structure_matrix,
    settle,
    spatial_structure_matrix,
)

pytestmark = pytest.mark.long

WEIGHT = (0.0, -30.0 * 9.81)


@pytest.fixture(scope="module")
def table(reference):
    return np.array(reference["table_iii"]["anchors"]), np.array(reference["table_iii"]["attachments"])


@pytest.fixture(scope="module")
def best(reference):
    """Pose of the greatest tension factor at 50 degrees."""
    return np.array([*reference["best"]["at"], np.deg2rad(50.0)])


@pytest.fixture(scope="module")
def machine(table):
    """Table III with 30 kg and inextensible cables."""
    return LockedPlatform.planar(*table, 1.0, WEIGHT)


def test_cable_2_lost_at_the_best_pose(machine, best):
    """Reference of squad.md, to the printed digits: cm, degrees, newtons."""
    lost = lost_cable(locked_at(machine, best[:2], best[2]), 1, best[:2], best[2])
    np.testing.assert_allclose(100.0 * lost.rest.position[:2], [-28.14942, 53.25171], atol=5e-6)
    assert np.rad2deg(lost.rest.phi) == pytest.approx(59.2922, abs=5e-5)
    np.testing.assert_allclose(lost.rest.tensions, [121.53, 0.0, 402.81, 0.0], atol=5e-3)
    assert lost.rest.taut.tolist() == [True, False, True, False]
    assert lost.rest.stable
    assert lost.drop == pytest.approx(best[1] - 0.5325171, abs=5e-8)


def test_survivors_carry_390_to_730_newtons(machine, best):
    greatest = [
        lost_cable(locked_at(machine, best[:2], best[2]), i, best[:2], best[2]).rest.tensions.max() for i in range(4)
    ]
    assert 385.0 < min(greatest) and max(greatest) < 735.0


@pytest.mark.parametrize("cable", range(4))
def test_a_constrained_minimiser_agrees(table, machine, best, cable):
    """Highest-level second route: SLSQP on height under the remaining lengths; and the tensions balance."""
    anchors, attachments = table
    locked = locked_at(machine, best[:2], best[2])
    lost = lost_cable(locked, cable, best[:2], best[2])
    keep = [i for i in range(4) if i != cable]
    near = lost.rest.pose + [1e-3, 2e-3, -2e-3]
    answer = minimize(
        lambda x: x[1],
        near,
        constraints={
            "type": "ineq",
            "fun": lambda x: (locked.unstressed - planar_lengths(anchors, attachments, x))[keep],
        },
        method="SLSQP",
        options={"ftol": 1e-14},
    )
    np.testing.assert_allclose(lost.rest.pose, answer.x, atol=1e-6)
    structure = planar_structure_matrix(anchors, attachments, lost.rest.pose)
    np.testing.assert_allclose(structure @ lost.rest.tensions + [*WEIGHT, 0.0], 0.0, atol=1e-7)
    assert lost.rest.tensions[cable] == 0.0
    assert np.all(lost.rest.lengths[keep] <= locked.unstressed[keep] + 1e-9)


@pytest.mark.parametrize("seed", [1, 2, 4, 7, 9])
def test_the_path_descends_and_stays_in_its_boxes(seed):
    case = hanging(seed)
    before = settle(case.platform, case.position, case.rotation)
    cable = int(np.argmax(before.tensions))
    corners = np.array([[x, y, z] for x in (-0.3, 0.3) for y in (-0.3, 0.3) for z in (-0.2, 0.2)])
    lost = lost_cable(case.platform, cable, before.position, before.rotation, corners=corners)
    assert lost.rest.status in (Rest.STABLE, Rest.NEUTRAL)
    np.testing.assert_allclose(lost.positions[0], before.position, atol=1e-12)
    np.testing.assert_allclose(lost.positions[-1], lost.rest.position, atol=1e-12)
    keep = np.arange(len(case.platform.anchors)) != cable
    ends = lost.positions[:, None] + np.einsum("kij,mj->kmi", lost.rotations, case.platform.attachments)
    stretch = np.maximum(np.linalg.norm(case.platform.anchors - ends, axis=-1) - case.platform.unstressed, 0.0)
    rate = np.where(keep, case.platform.axial_stiffness / case.platform.unstressed, 0.0)
    middle = lost.positions + np.einsum("kij,j->ki", lost.rotations, case.centre)
    energy = 0.5 * (rate * stretch**2).sum(axis=1) - middle @ case.platform.forces[0]
    assert np.all(np.diff(energy) <= 1e-9 * np.abs(energy).max())
    steps = np.linalg.norm(np.diff(middle, axis=0), axis=1)
    assert steps.max() <= 0.01 * case.platform.unstressed.max() * (1.0 + 1e-9)
    np.testing.assert_allclose(lost.reference_box, [lost.positions.min(axis=0), lost.positions.max(axis=0)], atol=1e-12)
    swept = lost.positions[:, None] + np.einsum("kij,cj->kci", lost.rotations, corners)
    np.testing.assert_allclose(lost.corner_box, [swept.min(axis=(0, 1)), swept.max(axis=(0, 1))], atol=1e-12)
    assert lost.drop == pytest.approx(before.position[2] - lost.rest.position[2], abs=1e-12)


@pytest.mark.parametrize("seed", [1, 2, 4])
def test_the_path_is_that_of_a_heavily_damped_fall(seed):
    """Shorter steps end in the same place and stay near the same path."""
    case = hanging(seed)
    before = settle(case.platform, case.position, case.rotation)
    cable = int(np.argmax(before.tensions))
    coarse, fine = (
        lost_cable(case.platform, cable, before.position, before.rotation, stride=stride) for stride in (0.01, 0.0025)
    )
    np.testing.assert_allclose(coarse.rest.position, fine.rest.position, atol=1e-7)
    gap = np.linalg.norm(coarse.positions[:, None] - fine.positions[None], axis=-1).min(axis=1)
    assert gap.max() < 0.02 * case.platform.unstressed.max()


def test_a_map_is_its_single_answers(machine, best):
    places = best[:2] + np.array([[0.0, 0.0], [0.05, -0.05], [-0.02, 0.03], [np.nan, 0.0]])
    angles = best[2] + np.array([0.0, 0.05, -0.02, 0.0])
    table = lost_cable_map(machine, places, angles)
    assert table.position.shape == (4, 4, 3) and table.tensions.shape == (4, 4, 4)
    for k in range(3):
        for cable in range(4):
            one = lost_cable(locked_at(machine, places[k], angles[k]), cable, places[k], angles[k])
            np.testing.assert_allclose(table.position[k, cable], one.rest.position, atol=1e-12)
            np.testing.assert_allclose(table.rotation[k, cable], one.rest.rotation, atol=1e-12)
            np.testing.assert_allclose(table.tensions[k, cable], one.rest.tensions, atol=1e-9)
            np.testing.assert_allclose(
                table.corner_box[k, cable], one.corner_box, atol=1e-3
            )  # steps, and so places, differ with rounding
            assert table.drop[k, cable] == pytest.approx(one.drop, abs=1e-12)
            assert table.status[k, cable] == Rest.STABLE
    assert (table.status[3] == Rest.UNDEFINED).all() and np.isnan(table.tensions[3]).all()
    one = lost_cable_map(machine, places[:1], angles[:1], cables=[2])
    np.testing.assert_array_equal(one.position[:, 0], table.position[:1, 2])


@pytest.mark.parametrize("nudge", [0.0, 1e-12, -1e-10, 1e-8, 1e-7])
def test_what_the_survivors_hold_stays_whatever_the_rounding(machine, table, nudge):
    """Balanced at the start with positive tensions, as a linear solve tells: at rest there, next to singular or not."""
    nodes = closure_nodes(*table, np.deg2rad([44.0, 50.0, 56.0]), 0.06)
    nodes = np.vstack((nodes, [[-0.33, 0.51, np.deg2rad(50.0)], [-0.03, 0.57, np.deg2rad(56.0)]]))
    nodes[:, 2] += nudge
    found = lost_cable_map(machine, nodes[:, :2], nodes[:, 2])
    assert found.settled.all()
    structure, held = planar_structure_matrix(*table, nodes), 0
    for cable in range(4):
        keep = [i for i in range(4) if i != cable]
        balance = np.linalg.solve(
            structure[..., keep], np.tile([[-WEIGHT[0]], [-WEIGHT[1]], [0.0]], (len(nodes), 1, 1))
        )
        pulled = (balance[..., 0] > 0.0).all(axis=-1)
        held += np.count_nonzero(pulled)
        assert np.abs(found.drop[pulled, cable]).max() < 1e-9
        np.testing.assert_allclose(found.tensions[pulled, cable][:, keep], balance[pulled, :, 0], rtol=1e-6)
        assert (found.status[pulled, cable] == Rest.STABLE).all()
    assert held == len(nodes)


def test_more_survivors_than_freedoms_hold_what_a_linear_program_says(rng):
    """In space, eight inextensible cables: where the seven left can balance with positive tensions, nothing moves."""
    held = 0
    for _ in range(20):
        anchors, attachments = rng.uniform(-1.0, 1.0, (8, 3)) * [4.0, 4.0, 1.0], rng.uniform(-0.5, 0.5, (8, 3))
        platform = LockedPlatform.spatial(anchors + [0.0, 0.0, 3.0], attachments, 1.0, [0.0, 0.0, -300.0])
        found = lost_cable_map(platform, np.zeros((1, 3)), np.eye(3)[None])
        structure = spatial_structure_matrix(platform.anchors, attachments, np.zeros(3), np.eye(3))
        for cable in range(8):
            left = np.delete(structure, cable, axis=-1)
            program = linprog(
                [0.0] * 7 + [-1.0],  # the least tension
                A_eq=np.column_stack((left, left.sum(axis=1))),
                b_eq=[0.0, 0.0, 0.0, 0.0, 0.0, 300.0],
                bounds=[(0.0, None)] * 7 + [(0.0, 1e5)],
            )
            if program.status == 0 and program.fun < -1e-6:
                held += 1
                assert found.settled[0, cable] and abs(found.drop[0, cable]) < 1e-9
    assert held > 3


def test_saddles_and_short_cables_are_not_held(table):
    """Balance is not rest: a platform on top of its attachments turns over; nothing holds lengths that cannot meet."""
    upright = LockedPlatform.planar(
        [[0.0, 1.0], [0.0, 1.0]], [[0.0, -0.1], [0.0, -0.1]], [0.9, 0.9], (0.0, -1.0), centre=[0.0, 0.0], gyration=0.1
    )
    tipped = settle(upright, [0.0, 0.2], 0.0)
    assert tipped.stable and abs(tipped.phi) == pytest.approx(np.pi, abs=1e-6)
    short = LockedPlatform.planar(*table, 0.05, WEIGHT)
    assert settle(short, [0.0, 0.4], 0.0).status is Rest.UNFINISHED


def test_the_worst_case_counts_what_it_leaves_out(machine, best):
    found = lost_cable_map(machine, np.tile(best[:2], (3, 1)), best[2] + np.array([0.0, 0.01, 0.02]), cables=[1])
    status, tensions = found.status.copy(), found.tensions.copy()
    status[1:], tensions[2], tensions[1, 0, 0] = Rest.UNFINISHED, np.nan, 9e9
    told = lost_cable_dataset(
        replace(found, status=status, tensions=tensions), np.tile(best[:2], (3, 1)), [1], [0.0, 1.0, 0.0], {}, {}
    )
    (worst,) = worst_cases(told)
    assert (worst.settled, worst.unsettled, worst.unsettled_tension) == (1, 2, 9e9)
    assert worst.tension == pytest.approx(found.tensions[0].max())
    (worst,) = worst_cases(lost_cable_dataset(found, np.tile(best[:2], (3, 1)), [1], [0.0, 1.0, 0.0], {}, {}))
    assert worst.unsettled == 0 and worst.unsettled_tension is None


def test_elastic_cables_shorten_when_locked(table, best):
    """Unstressed lengths follow from the tensions before; a stiff elastic cable tends to the inextensible one."""
    held = np.array([150.0, 160.0, 170.0, 140.0])
    drops = []
    for stiffness in (1e5, 1e7, np.inf):
        platform = LockedPlatform.planar(*table, 1.0, WEIGHT, axial_stiffness=stiffness)
        locked = locked_at(platform, best[:2], best[2], held)
        np.testing.assert_allclose(locked.unstressed * (1.0 + held / stiffness), planar_lengths(*table, best))
        drops.append(lost_cable(locked, 1, best[:2], best[2]).drop)
        many = lost_cable_map(platform, best[None, :2], best[2:], tensions=held, cables=[1])
        assert many.drop[0, 0] == pytest.approx(drops[-1], abs=1e-12)
    assert abs(drops[1] - drops[2]) < 0.02 * abs(drops[0] - drops[2])


def test_bad_input_is_refused(machine, best):
    with pytest.raises(InputError, match="cable"):
        lost_cable(machine, 4, best[:2], best[2])
    alone = LockedPlatform.planar([[0.0, 0.0]], [[0.0, 0.0]], 1.0, WEIGHT)
    with pytest.raises(InputError, match="only one"):
        lost_cable(alone, 0, best[:2], best[2])
    with pytest.raises(InputError, match="position"):
        locked_at(alone, [0.0, 0.0], 0.0)
    with pytest.raises(InputError, match="positions"):
        lost_cable_map(machine, np.zeros((2, 3)), np.zeros(2))


def test_a_bad_pose_in_a_map_stops_no_other(machine, table, best):
    """Not finite, no rotation, or a cable of no length: undefined, and the pose beside it is answered."""
    turn = np.eye(3)
    turn[:2, :2] = [[np.cos(best[2]), -np.sin(best[2])], [np.sin(best[2]), np.cos(best[2])]]
    inside_an_anchor = table[0][0] - turn[:2, :2] @ table[1][0]
    places = np.array([best[:2], best[:2], [np.inf, 0.0], inside_an_anchor, best[:2]])
    turns = np.array([turn, 2.0 * turn, turn, turn, np.diag([1.0, -1.0, 1.0])])
    done = []
    found = lost_cable_map(machine, places, turns, progress=done.append)
    assert found.settled[0].all() and (found.status[1:] == Rest.UNDEFINED).all()
    assert np.isnan(found.drop[1:]).all() and np.isnan(found.tensions[1:]).all() and not found.taut[1:].any()
    assert done == [1, 2, 3, 4, 5]
    np.testing.assert_allclose(found.greatest_tension[0], found.tensions[0].max(axis=-1))
    np.testing.assert_array_equal(found.lowest([0.0, 1.0, 0.0])[0], found.corner_box[0, :, 0, 1])
    np.testing.assert_array_equal(found.lowest([0.0, -1.0, 0.0])[0], -found.corner_box[0, :, 1, 1])
    none = lost_cable_map(machine, np.empty((0, 2)), np.empty(0))
    assert none.drop.shape == (0, 4)


def test_anchors_may_differ_from_pose_to_pose(machine, table, best):
    """Moving the whole robot moves the answer with it."""
    moves = np.array([[0.0, 0.0], [3.0, -2.0], [-1.0, 5.0]])
    found = lost_cable_map(machine, best[:2] + moves, np.full(3, best[2]), anchors=table[0] + moves[:, None])
    np.testing.assert_allclose(found.drop, np.tile(found.drop[:1], (3, 1)), atol=1e-9)
    np.testing.assert_allclose(found.tensions, np.tile(found.tensions[:1], (3, 1, 1)), atol=1e-6)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"cables": [0, 4]}, "cable"),
        ({"cables": [0.5]}, "cable"),
        ({"stride": 0.0}, "stride"),
        ({"stride": np.nan}, "stride"),
        ({"tensions": [1.0, 2.0]}, "tensions"),
        ({"tensions": np.nan}, "tensions"),
        ({"corners": [[np.nan, 0.0]]}, "corners"),
        ({"corners": [[0.0, 0.0, 0.0]]}, "corners"),
        ({"anchors": np.zeros((2, 4, 2))}, "anchors"),
        ({"rotations": [0.0, 1.0]}, "rotations"),
        ({"positions": [["a", "b"]]}, "positions"),
    ],
)
def test_a_map_refuses_what_is_no_question(machine, best, options, words):
    good = {"positions": best[None, :2], "rotations": best[2:]}
    with pytest.raises(InputError, match=words) as refused:
        lost_cable_map(machine, **(good | options))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"anchors": [[0.0, np.nan], [1.0, 0.0]]}, "anchors"),
        ({"attachments": [[0.0, 0.0]]}, "attachments"),
        ({"unstressed": [1.0, 0.0]}, "unstressed"),
        ({"unstressed": "long"}, "unstressed"),
        ({"axial_stiffness": -1.0}, "axial_stiffness"),
        ({"weight": [0.0, np.inf]}, "forces"),
        ({"weight": [0.0, -1e300]}, "forces"),
        ({"weight": [0.0, -1e-300]}, "forces"),
        ({"anchors": [[0.0, 1e200], [1.0, 0.0]]}, "anchors"),
        ({"moment": np.nan}, "moment"),
        ({"radii": 0.1}, "axes"),
        ({"gyration": "wide"}, "gyration"),
        ({"gyration": -1.0}, "gyration"),
    ],
)
def test_a_platform_that_is_none_is_refused(options, words):
    good = {"anchors": [[0, 0], [1, 0]], "attachments": [[0, 0], [0.1, 0]], "unstressed": 1.0, "weight": [0, -1]}
    with pytest.raises(InputError, match=words) as refused:
        LockedPlatform.planar(**(good | options))
    assert "\n" not in str(refused.value)
