"""Every method of `METHODS` keeps what the table promises: complete, optimal, within its options, at any scale."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import oracles
import pytest
from published_robots import PLANAR, SPATIAL
from scipy.optimize import linprog
from tension_questions import balanced_by, descent_left, drawn, excess, published

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import METHODS, DistributionStatus, certificate_gap, distribute, tension_polygon
from steeplejack.mechanics.cable.degeneracy import TOLERANCE

pytestmark = pytest.mark.long

COMPLETE = [name for name, record in METHODS.items() if record.complete]
SHAPES = [(3, 4), (6, 7), (3, 5), (6, 8), (3, 6), (6, 10)]


def taken(method, n, m):
    most = METHODS[method].most_redundancy
    return most is None or m - n <= most


def balances(structures, wrenches, tensions):
    """Residual of each row over the size of what it adds up [1]."""
    residual = np.abs(np.einsum("...ij,...j->...i", structures, tensions) + wrenches)
    size = np.einsum("...ij,...j->...i", np.abs(structures), np.abs(tensions)) + np.abs(wrenches)
    return (residual / size).max(axis=-1)


@pytest.mark.parametrize("robot", (*PLANAR, *SPATIAL), ids=lambda robot: robot.name)
def test_complete_methods_answer_wherever_there_is_an_answer(robot, rng):
    asked = published(robot, rng, 3000)
    answers = {name: distribute(*asked, name) for name in METHODS}
    held = answers["min-norm"].feasible
    assert 20 < np.count_nonzero(held)
    for name, answer in answers.items():
        np.testing.assert_array_equal(answer.margin, answers["min-norm"].margin)
        possible = answer.margin >= -TOLERANCE
        np.testing.assert_array_equal(possible & ~answer.feasible, answer.status == DistributionStatus.MISSED)
        if METHODS[name].complete:
            np.testing.assert_array_equal(answer.feasible, possible)
        assert excess(answer.tensions, *asked[2:])[answer.feasible].max() < 1e-8 * robot.window[1]
        assert balances(asked[0], asked[1], answer.tensions)[answer.feasible].max() < 1e-11
    refused = answers["min-norm"].status == DistributionStatus.INFEASIBLE
    assert (certificate_gap(answers["min-norm"].certificate, *asked)[refused] > 0.0).all()


@pytest.mark.parametrize(("n", "m"), SHAPES)
def test_no_load_made_of_feasible_tensions_is_missed(n, m, rng):
    structures, _, lower, upper = drawn(rng, n, m, 2000)
    window = upper - lower
    insides = [rng.uniform(lower, upper), lower + np.round(rng.uniform(size=window.shape)) * window]
    insides.append(lower + np.clip(rng.uniform(-1.0, 2.0, window.shape), 0.0, 1.0) * window)
    for inside in insides:  # anywhere in the box, at its corners, on its faces
        wrenches = balanced_by(structures, inside)
        for name in (name for name in COMPLETE if taken(name, n, m)):
            answer = distribute(structures, wrenches, lower, upper, name)
            assert answer.feasible.all()
            assert excess(answer.tensions, lower, upper).max() < 1e-8 * 250.0


def test_the_closed_form_misses_many_and_says_so(rng):
    asked = drawn(rng, 6, 8, 3000)
    found = {name: distribute(*asked, name) for name in ("closed-form", "improved-closed-form", "qp")}
    possible = np.count_nonzero(found["qp"].feasible)
    missed = {name: np.count_nonzero(answer.status == DistributionStatus.MISSED) for name, answer in found.items()}
    assert missed["closed-form"] > 0.2 * possible
    assert 0 < missed["improved-closed-form"] < 0.1 * possible
    assert missed["qp"] == 0
    left = found["closed-form"].status == DistributionStatus.MISSED
    assert (excess(found["closed-form"].tensions, *asked[2:])[left] > 0.0).all()
    assert not found["closed-form"].feasible[left].any()
    assert "use a complete one" in DistributionStatus.MISSED.advice


@pytest.mark.parametrize(("n", "m"), SHAPES)
def test_margin_and_proof_for_any_number_of_cables(n, m, rng):
    asked = drawn(rng, n, m, 150)
    answer = distribute(*asked, "qp")
    half = 0.5 * (asked[3] - asked[2]).max(axis=-1)
    for k in range(150):
        structure, wrench, lower, upper = (array[k] for array in asked)
        sides = np.vstack((-np.eye(m), np.eye(m)))
        program = linprog(
            np.append(np.zeros(m), -1.0),
            A_ub=np.column_stack((sides, np.ones(2 * m))),
            b_ub=np.concatenate((-lower, upper)),
            A_eq=np.column_stack((structure, np.zeros(n))),
            b_eq=-wrench,
            bounds=[(None, None)] * (m + 1),
        )
        assert answer.margin[k] * half[k] == pytest.approx(-program.fun, rel=1e-7, abs=1e-6)
    gap = certificate_gap(answer.certificate, *asked)[~answer.feasible]
    np.testing.assert_allclose(gap, (-answer.margin * half)[~answer.feasible], rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize(("n", "m"), SHAPES)
def test_linear_objectives_equal_highs(n, m, rng):
    asked = drawn(rng, n, m, 120, outside=5.0)
    cost = rng.normal(size=m)
    largest, total = distribute(*asked, "min-max"), distribute(*asked, "lp", weights=cost)
    for k in np.flatnonzero(largest.feasible)[:60]:
        structure, wrench, lower, upper = (array[k] for array in asked)
        sides = list(zip(lower, upper, strict=True))
        equal = {"A_eq": np.column_stack((structure, np.zeros(n))), "b_eq": -wrench}
        above = np.column_stack((np.eye(m), -np.ones(m)))
        program = linprog(
            np.append(np.zeros(m), 1.0), A_ub=above, b_ub=np.zeros(m), bounds=[*sides, (None, None)], **equal
        )
        assert largest.tensions[k].max() == pytest.approx(program.fun, rel=1e-7)
        cheapest = linprog(cost, A_eq=structure, b_eq=-wrench, bounds=sides)
        assert cost @ total.tensions[k] == pytest.approx(cheapest.fun, rel=1e-7, abs=1e-6)


@pytest.mark.parametrize(("n", "m"), SHAPES)
def test_convex_objectives_leave_no_descent(n, m, rng):
    asked = drawn(rng, n, m, 100, outside=5.0)
    weights, reference = rng.uniform(0.1, 5.0, (100, m)), rng.uniform(-50.0, 300.0, (100, m))
    cases = [
        (distribute(*asked, "min-norm"), lambda f, k: f),
        (distribute(*asked, "qp"), lambda f, k: f - 0.5 * (asked[2] + asked[3])[k]),
        (
            distribute(*asked, "qp", weights=weights, reference=reference),
            lambda f, k: weights[k] * (f - reference[k]),
        ),
        *(
            (
                distribute(*asked, "p-norm", reference=centre, power=power),
                lambda f, k, centre=centre, power=power: (
                    np.sign(f - centre) * np.abs((f - centre) / np.abs(f - centre).max()) ** (power - 1.0)
                ),
            )
            for centre, power in ((0.0, 4.0), (100.0, 4.0), (0.0, 2.5), (0.0, 16.0))
        ),
    ]
    for answer, gradient in cases:
        for k in np.flatnonzero(answer.feasible):
            tensions = answer.tensions[k]
            left = descent_left(asked[0][k], tensions, gradient(tensions, k), asked[2][k], asked[3][k])
            assert left < 1e-6


def test_ties_are_settled_as_stated(rng):
    structure, wrench = np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]]), np.array([-80.0, 0.0])
    least = distribute(structure, wrench, 0.0, [100.0, 100.0, 30.0, 30.0], "min-max")
    np.testing.assert_allclose(least.tensions, [40.0, 40.0, 0.0, 0.0], atol=1e-7)
    deep = distribute(structure, wrench, 0.0, [100.0, 100.0, 30.0, 30.0], "max-margin")
    np.testing.assert_allclose(deep.tensions, [40.0, 40.0, 15.0, 15.0], atol=1e-7)


def test_methods_agree_where_they_ask_the_same(rng):
    asked = drawn(rng, 6, 8, 400, outside=0.0)
    closed, qp = distribute(*asked, "closed-form"), distribute(*asked, "qp")
    assert closed.feasible.any()
    np.testing.assert_allclose(qp.tensions[closed.feasible], closed.tensions[closed.feasible], atol=1e-7)
    squares, norm = distribute(*asked, "p-norm", power=2.0), distribute(*asked, "min-norm")
    np.testing.assert_allclose(squares.tensions, norm.tensions, atol=1e-6)
    steep, largest = distribute(*asked, "p-norm", power=64.0), distribute(*asked, "min-max")
    ratio = steep.tensions.max(axis=-1) / largest.tensions.max(axis=-1)
    assert (1.0 - 1e-9 < ratio).all()
    assert ratio.max() < 8.0 ** (1.0 / 64.0) + 1e-9


def test_qp_returns_a_feasible_reference(rng):
    structures, _, lower, upper = drawn(rng, 6, 9, 200)
    wanted = rng.uniform(lower, upper)
    answer = distribute(structures, balanced_by(structures, wanted), lower, upper, "qp", reference=wanted)
    np.testing.assert_allclose(answer.tensions, wanted, atol=1e-8)


def test_barycentre_is_the_centre_of_the_polygon(rng):
    asked = drawn(rng, 6, 8, 100, outside=0.0)
    answer, polygons = distribute(*asked, "barycentre"), tension_polygon(*asked)
    for k in np.flatnonzero(polygons.count > 2):
        corners = polygons.corners[k, : polygons.count[k]]
        hub, after = corners.mean(axis=0), np.roll(corners, -1, axis=0)
        edges = corners - hub, after - hub
        lengths = np.einsum("ki,ki->k", edges[0], edges[0]) * np.einsum("ki,ki->k", edges[1], edges[1])
        areas = np.sqrt(np.maximum(lengths - np.einsum("ki,ki->k", *edges) ** 2, 0.0))
        centre = (areas[:, None] * (corners + after + hub) / 3.0).sum(axis=0) / areas.sum()
        np.testing.assert_allclose(answer.tensions[k], centre, atol=1e-5)
    line = drawn(rng, 3, 4, 50, outside=0.0)
    ends = [distribute(*line, "lp", weights=sign * np.ones(4)).tensions for sign in (1.0, -1.0)]
    np.testing.assert_allclose(distribute(*line, "barycentre").tensions, 0.5 * (ends[0] + ends[1]), atol=1e-8)


def test_as_many_cables_as_rows_leave_no_choice(rng):
    asked = drawn(rng, 6, 6, 200, outside=3.0)
    expected = np.linalg.solve(asked[0], -asked[1][..., None])[..., 0]
    inside = excess(expected, *asked[2:]) <= 0.0
    assert 0 < np.count_nonzero(inside) < 200
    for name in METHODS:
        answer = distribute(*asked, name)
        np.testing.assert_array_equal(answer.feasible, inside)
        np.testing.assert_allclose(answer.tensions, expected, rtol=1e-8, atol=1e-6)
        assert (certificate_gap(answer.certificate, *asked)[~inside] > 0.0).all()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("n", "m"), [(3, 4), (6, 8)])
def test_neither_units_nor_the_order_of_cables_matter(method, n, m, rng):
    structures, wrenches, lower, upper = asked = drawn(rng, n, m, 300)
    answer = distribute(*asked, method)
    size = upper.max()
    for scale in (1e-9, 1e9):
        forces = distribute(structures, scale * wrenches, scale * lower, scale * upper, method)
        np.testing.assert_array_equal(forces.status, answer.status)
        np.testing.assert_allclose(forces.tensions / scale, answer.tensions, atol=1e-6 * size)
        unit = np.where(np.arange(n) == 2 if n == 3 else np.arange(n) < 3, scale, 1.0)
        lengths = distribute(structures * unit[:, None], wrenches * unit, lower, upper, method)
        np.testing.assert_array_equal(lengths.status, answer.status)
        np.testing.assert_allclose(lengths.tensions, answer.tensions, atol=1e-6 * size)
    order = rng.permutation(m)
    shuffled = distribute(structures[..., order], wrenches, lower[:, order], upper[:, order], method)
    np.testing.assert_array_equal(shuffled.status, answer.status)
    np.testing.assert_allclose(shuffled.tensions, answer.tensions[:, order], atol=1e-6 * size)


def test_hostile_robots_get_a_status_or_a_checked_answer(rng):
    count = 3000
    structures, wrenches, lower, upper = drawn(rng, 6, 8, count)
    structures[:500, :, 3] = structures[:500, :, 5]  # coincident cables
    structures[500:1000, :, 2] = 0.0  # no length
    structures[1000:1300, 4] = structures[1000:1300, :2].sum(axis=1)  # singular
    structures[1300:1600, 4] = 1e-8 * structures[1300:1600, 0]  # the same row in another unit
    structures[1600:1700, 1, 1] = np.nan
    wrenches[1700:1800, 2] = np.inf
    upper[1800:1900, 0] = np.inf
    upper[1900:2100] = lower[1900:2100] + np.eye(8)[rng.integers(0, 8, 200)]  # one open window
    structures[2100:2400] = rng.integers(-1, 2, (300, 6, 8))  # ties and parallel sides
    for scale, place in ((1e-9, slice(2400, 2600)), (1e9, slice(2600, 2800))):
        structures[place, 3:] *= scale
        wrenches[place, 3:] *= scale
    for method in METHODS:
        answer = distribute(structures, wrenches, lower, upper, method)
        assert (answer.status[500:1000] == DistributionStatus.UNDEFINED).all()
        assert (answer.status[1000:1600] == DistributionStatus.SINGULAR).all()
        assert (answer.status[1600:1800] == DistributionStatus.UNDEFINED).all()
        assert (answer.status[1800:1900] == DistributionStatus.UNDEFINED).all() or METHODS[method].open_windows
        held = answer.feasible
        assert excess(answer.tensions, lower, upper)[held].max() < 1e-6
        assert balances(structures, wrenches, answer.tensions)[held].max() < 1e-7
        no = np.isin(answer.status, (DistributionStatus.INFEASIBLE,))
        assert (certificate_gap(answer.certificate, structures, wrenches, lower, upper)[no] > 0.0).all()
        assert not METHODS[method].complete or (answer.status != DistributionStatus.MISSED).all()


@pytest.mark.parametrize(
    ("method", "options", "message"),
    [
        ("min-norm", {"reference": 5.0}, "not read by min-norm; only with p-norm or qp"),
        ("closed-form", {"weights": 1.0}, "only with qp or lp"),
        ("qp", {"power": 4.0}, "only with p-norm"),
        ("p-norm", {"power": 1.5}, "2 to 64"),
        ("p-norm", {"power": np.nan}, "2 to 64"),
        ("qp", {"weights": [1.0] * 8 + [0.0]}, "positive"),
        ("qp", {"reference": [1.0, 2.0]}, "shape"),
        ("barycentre", {}, "barycentre with 3 cables too many; at most 2"),
    ],
)
def test_what_a_method_does_not_take_is_refused(method, options, message, rng):
    with pytest.raises(InputError, match=message):
        distribute(*drawn(rng, 6, 9, 2), method, **options)


@pytest.mark.parametrize(
    ("structure", "wrench", "upper"),
    [(np.ones((4, 3)), np.ones(4), 1.0), (np.ones((3, 4)), np.ones(4), 1.0), (np.ones((3, 4)), np.ones(3), np.ones(3))],
)
def test_shapes_that_do_not_fit_are_refused(structure, wrench, upper):
    with pytest.raises(InputError):
        distribute(structure, wrench, 0.0, upper)


def test_the_page_says_what_the_table_says():
    page = (Path(__file__).parents[2] / "docs" / "how-to-choose-a-distribution.md").read_text()
    for name, record in METHODS.items():
        words = ("yes" if promise else "no" for promise in (record.complete, record.continuous))
        redundancy = "any" if record.most_redundancy is None else f"up to {record.most_redundancy}"
        assert f"| `{name}` | {record.chooses} | {' | '.join(words)} | {redundancy} |" in page


@pytest.mark.parametrize("name", [name for name, record in METHODS.items() if record.open_windows])
@pytest.mark.parametrize(("n", "m"), SHAPES)
def test_open_windows_agree_with_highs(name, n, m, rng):
    """Some upper bounds infinite: feasible exactly where a linear program finds tensions above the lower ones."""
    structures, wrenches, lower, upper = drawn(rng, n, m, 60)
    upper = np.where(rng.uniform(size=upper.shape) < 0.7, np.inf, upper)
    options = {"reference": 100.0} if name == "qp" else {}
    answer = distribute(structures, wrenches, lower, upper, name, **options)
    asked = zip(structures, wrenches, lower, upper, strict=True)
    for k, (structure, wrench, low, high) in enumerate(asked):
        program = linprog(np.ones(m), A_eq=structure, b_eq=-wrench, bounds=list(zip(low, high, strict=True)))
        assert answer.feasible[k] == (program.status == 0)
        if name == "lp" and answer.feasible[k]:
            assert answer.tensions[k].sum() == pytest.approx(program.fun, rel=1e-7)
    refused = answer.status == DistributionStatus.INFEASIBLE
    gap = certificate_gap(answer.certificate, structures, wrenches, lower, upper)
    assert (gap[refused] > 0.0).all()
    assert balances(structures, wrenches, answer.tensions)[answer.feasible].max() < 1e-9


@pytest.mark.parametrize("name", [name for name, record in METHODS.items() if not record.open_windows])
def test_methods_without_a_meaning_for_open_windows_say_so(name, rng):
    answer = distribute(*drawn(rng, 3, 4, 5)[:3], np.inf, name)
    assert (answer.status == DistributionStatus.UNDEFINED).all()


@pytest.mark.parametrize("bounds", [(-np.inf, np.inf), (1.0, np.inf), (-np.inf, 5.0), (-1e308, 1e308)])
def test_a_box_without_a_middle_is_undefined_to_qp_and_the_advice_says_why(bounds, rng):
    answer = distribute(*drawn(rng, 3, 4, 5)[:2], *bounds, "qp")
    assert (answer.status == DistributionStatus.UNDEFINED).all()
    assert "the middle of every window" in DistributionStatus.UNDEFINED.advice


def test_feasible_and_not_found_never_happens_by_an_independent_program(rng):
    """Complete methods find tensions wherever HiGHS does, whatever margin they report themselves."""
    for n, m in SHAPES:
        asked = drawn(rng, n, m, 40)
        held = np.array([oracles.window_margin(*question) for question in zip(*asked, strict=True)])
        for name in (name for name in COMPLETE if taken(name, n, m)):
            answer = distribute(*asked, name)
            assert answer.feasible[held > oracles.BAND].all()
            assert not answer.feasible[held < -oracles.BAND].any()
