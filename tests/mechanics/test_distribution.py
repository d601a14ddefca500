"""Tensions of four planar cables against linear programs, their proofs of infeasibility, and degenerate inputs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    METHODS,
    DistributionStatus,
    certificate_gap,
    distribute,
    margin_grid,
    planar_arms,
    planar_structure_matrix,
)
from steeplejack.mechanics.cable.degeneracy import TOLERANCE

BAND = 1e-6  # [1] margin below which a linear program may decide either way
CONCURRENT = 0.5 * np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 0.0]])


def questions(rng, count):
    """Random asymmetric robots at any angle, with loads that put many answers near a bound: S, w, lower, upper."""
    anchors = np.array([[-2.0, -1.5], [2.0, -1.2], [2.3, 1.4], [-1.6, 1.8]]) + rng.uniform(-1.0, 1.0, (count, 4, 2))
    attachments = rng.uniform(-0.5, 0.5, (count, 4, 2))
    pose = rng.uniform([-1.2, -1.0, -np.pi], [1.2, 1.0, np.pi], (count, 3))
    structures = np.stack(
        [planar_structure_matrix(a, b, p) for a, b, p in zip(anchors, attachments, pose, strict=True)]
    )
    lower = rng.uniform(0.0, 30.0, (count, 4))
    upper = lower + rng.uniform(50.0, 400.0, (count, 4))
    inside = rng.uniform(lower - 60.0, upper + 60.0)
    return structures, -np.einsum("kij,kj->ki", structures, inside), lower, upper


def greatest_depth(structure, wrench, lower, upper):
    """Greatest least distance to a bound by HiGHS [N]."""
    rows = np.vstack((np.hstack((-np.eye(4), np.ones((4, 1)))), np.hstack((np.eye(4), np.ones((4, 1))))))
    program = linprog(
        [0, 0, 0, 0, -1],
        A_ub=rows,
        b_ub=np.concatenate((-lower, upper)),
        A_eq=np.hstack((structure, np.zeros((3, 1)))),
        b_eq=-wrench,
        bounds=[(None, None)] * 5,
    )
    return -program.fun


@pytest.fixture(scope="module")
def answered():
    structures, wrenches, lower, upper = asked = questions(np.random.default_rng(7), 2000)
    return asked, {method: distribute(structures, wrenches, lower, upper, method) for method in METHODS}


def test_feasibility_agrees_with_highs_on_thousands_of_poses(answered):
    (structures, wrenches, lower, upper), answers = answered
    answer = answers["min-max"]
    assert 400 < answer.feasible.sum() < 1600
    for k in range(2000):
        bounds = np.stack((lower[k], upper[k]), axis=-1)
        program = linprog(np.zeros(4), A_eq=structures[k], b_eq=-wrenches[k], bounds=bounds)
        assert program.status in (0, 2)
        assert (program.status == 0) == answer.feasible[k] or abs(answer.margin[k]) < BAND


def test_margin_is_the_depth_a_linear_program_finds(answered):
    (structures, wrenches, lower, upper), answers = answered
    for k in range(400):
        depth = greatest_depth(structures[k], wrenches[k], lower[k], upper[k])
        half = 0.5 * (upper[k] - lower[k]).max()
        assert answers["min-max"].margin[k] == pytest.approx(depth / half, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("method", METHODS)
def test_tensions_balance_and_stay_inside_where_feasible(answered, method):
    (structures, wrenches, lower, upper), answers = answered
    answer = answers[method]
    residual = np.einsum("kij,kj->ki", structures, answer.tensions) + wrenches
    assert np.abs(residual).max() < 1e-9 * np.abs(answer.tensions).max()
    excess = np.maximum(lower - answer.tensions, answer.tensions - upper).max(axis=-1)
    assert excess[answer.feasible].max() < 1e-8 * upper.max()
    assert excess[~answer.feasible].min() > 0.0
    np.testing.assert_array_equal(answer.margin, answers["min-max"].margin)
    assert ((answer.status == DistributionStatus.MISSED) <= (answer.margin >= 0.0)).all()


def test_min_max_is_the_linear_program(answered):
    (structures, wrenches, lower, upper), answers = answered
    for k in np.flatnonzero(answers["min-max"].feasible)[:300]:
        program = linprog(
            [0, 0, 0, 0, 1],
            A_ub=np.hstack((np.eye(4), -np.ones((4, 1)))),
            b_ub=np.zeros(4),
            A_eq=np.hstack((structures[k], np.zeros((3, 1)))),
            b_eq=-wrenches[k],
            bounds=[*zip(lower[k], upper[k], strict=True), (None, None)],
        )
        assert answers["min-max"].tensions[k].max() == pytest.approx(program.fun, rel=1e-7)


def test_no_feasible_tensions_beat_min_norm_or_max_margin(answered, rng):
    (structures, wrenches, lower, upper), answers = answered
    held = np.flatnonzero(answers["min-norm"].feasible)
    low, high = answers["min-norm"].interval[held].T
    null = np.linalg.svd(structures[held])[2][:, -1]
    null *= np.sign(null.sum(axis=-1, keepdims=True))
    shortest, deepest = answers["min-norm"].tensions[held], answers["max-margin"].tensions[held]
    here = np.sum(shortest * null, axis=-1)
    assert ((low - 1e-6 < here) & (here < high + 1e-6)).all()
    for share in rng.uniform(0.0, 1.0, 20):
        others = shortest + (low + share * (high - low) - here)[:, None] * null
        assert (np.linalg.norm(others, axis=-1) > np.linalg.norm(shortest, axis=-1) - 1e-6).all()
        depth = [np.minimum(f - lower[held], upper[held] - f).min(axis=-1) for f in (others, deepest)]
        assert (depth[0] < depth[1] + 1e-6).all()


def test_interval_ends_touch_a_bound(answered):
    (structures, wrenches, lower, upper), answers = answered
    answer = answers["min-norm"]
    held = np.flatnonzero(answer.feasible)
    null = np.linalg.svd(structures[held])[2][:, -1]
    null *= np.sign(null.sum(axis=-1, keepdims=True))
    middle = np.sum(answer.tensions[held] * null, axis=-1)
    for end in answer.interval[held].T:
        f = answer.tensions[held] + (end - middle)[:, None] * null
        least = np.minimum(f - lower[held], upper[held] - f).min(axis=-1)
        np.testing.assert_allclose(least, 0.0, atol=1e-5)


def test_every_infeasible_answer_proves_itself(answered):
    asked, answers = answered
    answer = answers["min-max"]
    gap = certificate_gap(answer.certificate, *asked)[~answer.feasible]
    half = 0.5 * (asked[3] - asked[2]).max(axis=-1)[~answer.feasible]
    np.testing.assert_allclose(gap, -answer.margin[~answer.feasible] * half, rtol=1e-6, atol=1e-7)
    assert (gap > 0.0).all()
    assert np.isnan(answer.certificate[answer.feasible]).all()


def test_a_certificate_separates_every_corner_of_the_box(answered):
    (structures, wrenches, lower, upper), answers = answered
    k = int(np.argmin(answers["min-max"].margin))
    corners = np.stack(np.meshgrid(*np.stack((lower[k], upper[k]), axis=-1)), axis=-1).reshape(-1, 4)
    power = (corners @ structures[k].T + wrenches[k]) @ answers["min-max"].certificate[k]
    assert power.min() > 0.0


def test_rows_may_be_in_any_unit(answered):
    (structures, wrenches, lower, upper), answers = answered
    unit = np.array([1.0, 1e-4, 1e5])
    scaled = distribute(structures * unit[:, None], wrenches * unit, lower, upper)
    np.testing.assert_array_equal(scaled.status, answers["min-max"].status)
    np.testing.assert_allclose(scaled.tensions, answers["min-max"].tensions, rtol=1e-7, atol=1e-6)


def test_three_force_rows_in_space_with_bounds_of_their_own(rng):
    directions = rng.normal(size=(200, 3, 4)) * [[1.0], [1.0], [0.1]]
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    weight = np.array([0.0, 0.0, -17.7 * 9.81])
    lower, upper = np.array([10.0, 20.0, 10.0, 0.0]), np.array([250.0, 120.0, 400.0, 300.0])
    answer = distribute(directions, weight, lower, upper, "max-margin")
    for k in range(200):
        depth = greatest_depth(directions[k], weight, lower, upper)
        assert answer.margin[k] == pytest.approx(depth / 195.0, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("component", [0.0, 1e-13, -1e-13, 1e-7])
def test_a_cable_the_null_vector_hardly_moves(component):
    null = np.array([0.5, 0.6, 0.6244998, component])
    structure = np.linalg.svd(null[None])[2][1:]
    held = np.array([50.0, 60.0, 70.0, 40.0])
    answer = distribute(structure, -structure @ held, 10.0, [100.0, 100.0, 100.0, 40.0])
    assert answer.margin == pytest.approx(0.0, abs=1e-6)
    infeasible = distribute(structure, -structure @ held, 10.0, [100.0, 100.0, 100.0, 39.0])
    assert infeasible.status == DistributionStatus.INFEASIBLE
    assert (
        certificate_gap(infeasible.certificate, structure, -structure @ held, 10.0, [100.0, 100.0, 100.0, 39.0]) > 0.9
    )


def test_a_fixed_tension_and_an_upside_down_window(rng):
    structure, wrench, _, _ = (array[0] for array in questions(rng, 1))
    free = distribute(structure, wrench, -1e4, 1e4)
    bounds = np.full(4, -1e4), np.full(4, 1e4)
    bounds[0][2] = bounds[1][2] = free.tensions[2]
    fixed = distribute(structure, wrench, *bounds)
    assert fixed.status == DistributionStatus.FEASIBLE
    assert fixed.tensions[2] == pytest.approx(free.tensions[2], abs=1e4 * TOLERANCE)
    bounds[1][2] -= 100.0
    assert distribute(structure, wrench, *bounds).margin == pytest.approx(-0.005)


def test_a_singular_pose_is_infeasible_and_names_the_unresisted_wrench():
    for wrench in ([0.0, -100.0, 0.0], [0.0, -100.0, -3.0]):
        answer = distribute(CONCURRENT, wrench, 10.0, 250.0)
        assert answer.status == DistributionStatus.SINGULAR
        assert not answer.feasible
        assert answer.margin == -np.inf
        assert np.isnan(answer.tensions).all()
        np.testing.assert_allclose(np.abs(answer.certificate), [0.0, 0.0, 1.0], atol=1e-15)
    assert answer.certificate[2] == -1.0


def test_near_a_singular_pose_the_answer_still_balances():
    structure = CONCURRENT.copy()
    structure[2] = [1e-6, -2e-6, 1e-6, 3e-6]
    answer = distribute(structure, [0.0, -100.0, 1e-5], 0.0, 500.0)
    assert answer.status in (DistributionStatus.FEASIBLE, DistributionStatus.INFEASIBLE)
    np.testing.assert_allclose(structure @ answer.tensions, [0.0, 100.0, -1e-5], rtol=1e-9, atol=1e-9)


def test_parallel_cables_name_the_direction_the_load_pushes_in():
    structure = np.tile([[1.0], [0.0], [0.0]], 4)
    for wrench, direction in (
        ([1.0, 0.0, 0.0], None),
        ([1.0, 0.0, -2.0], [0.0, 0.0, -1.0]),
        ([1.0, 3, 4], [0, 0.6, 0.8]),
    ):
        answer = distribute(structure, wrench, 0.0, 1.0)
        assert answer.status == DistributionStatus.SINGULAR
        np.testing.assert_allclose(answer.certificate @ structure, 0.0, atol=1e-15)
        if direction:
            np.testing.assert_allclose(answer.certificate, direction, atol=1e-15)
            assert certificate_gap(answer.certificate, structure, wrench, 0.0, 1.0) > 0.0


def test_a_cable_without_length_pulls_nobody_knows_where(rng):
    structure, wrench, lower, upper = (array[0] for array in questions(rng, 1))
    structure[:, 2] = 0.0
    answer = distribute(structure, wrench, lower, upper)
    assert answer.status == DistributionStatus.UNDEFINED
    assert not answer.feasible
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    x, y = square[2] - planar_arms(0.25 * square, 0.2)[2]
    margins = margin_grid(square, 0.25 * square, 0.2, [x, x - 0.1], [y], [0.0, -9.81, 0.1], 0.0, 1e3)
    assert margins[0, 0] == -np.inf
    assert margins[0, 1] > -np.inf


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("where", ["structure", "wrench"])
def test_what_is_not_finite_is_undefined_and_never_feasible(rng, bad, where):
    structure, wrench, lower, upper = (array[0] for array in questions(rng, 1))
    {"structure": structure[1], "wrench": wrench}[where][0] = bad
    answer = distribute(structure, wrench, lower, upper)
    assert answer.status == DistributionStatus.UNDEFINED
    assert not answer.feasible


def test_batches_equal_loops_and_broadcast(rng):
    structures, wrenches, lower, upper = questions(rng, 6)
    batch = distribute(structures.reshape(2, 3, 3, 4), wrenches[0], lower[0], upper[0])
    assert batch.tensions.shape == (2, 3, 4)
    assert batch.margin.shape == batch.feasible.shape == batch.status.shape == (2, 3)
    for k, tensions in enumerate(batch.tensions.reshape(6, 4)):
        np.testing.assert_array_equal(tensions, distribute(structures[k], wrenches[0], lower[0], upper[0]).tensions)


def test_bad_questions_are_refused(rng):
    structure, wrench, lower, upper = (array[0] for array in questions(rng, 1))
    with pytest.raises(InputError, match="lower"):
        distribute(structure, wrench, [1.0, 2.0], upper)
    with pytest.raises(InputError, match="leading axes"):
        distribute(np.stack((structure, structure)), np.stack((wrench, wrench, wrench)), lower, upper)
    with pytest.raises(InputError, match="one of closed-form, .*min-max"):
        distribute(structure, wrench, lower, upper, "dykstra")  # pyright: ignore[reportArgumentType]


def test_no_pose_of_a_batch_stops_the_others(rng):
    structures, wrenches, lower, upper = (array.copy() for array in questions(rng, 6))
    alone = distribute(structures, wrenches, lower, upper)
    lower[0], upper[0] = upper[0].copy(), lower[0].copy()
    upper[1] = lower[1]
    wrenches[2, 0], upper[3, 1], lower[4, 2] = np.nan, np.nan, -np.inf
    answer = distribute(structures, wrenches, lower, upper)
    assert (answer.status[:2] == DistributionStatus.INFEASIBLE).all()
    assert np.isnan(answer.certificate[0]).all()
    assert (answer.status[2:5] == DistributionStatus.UNDEFINED).all()
    np.testing.assert_array_equal(answer.tensions[5], alone.tensions[5])


def test_every_status_gives_advice():
    assert all(status.advice for status in DistributionStatus)
