"""The exact grasp: the reference, no position above it, and what a change of view leaves alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from grasp_questions import GRASP, SQUARE, random_question, scattered, track_question
from scipy.optimize import minimize
from scipy.spatial import Delaunay

from steeplejack.design import best_pose
from steeplejack.design.grasps import Grasp, GraspQuestion, GraspRegion, best_grasp, grasp_front, grasp_on_grid
from steeplejack.errors import InfeasibleError, InputError

MIRROR = np.array([-1.0, 1.0])


def is_in(question: GraspQuestion, grasp: Grasp) -> bool:
    region = question.region
    half = np.array([region.half_length, region.half_width])
    return bool(np.all(np.abs(region.coordinates(grasp.position)) <= half + 1e-12))


def climbed(question: GraspQuestion, start: np.ndarray) -> float:
    """Tension factor after a search without gradients from a position, kept in the region."""
    half = np.array([question.region.half_length, question.region.half_width])

    def loss(share: np.ndarray) -> float:
        return -float(question.tension_factor(question.region.placed(np.clip(share, -1.0, 1.0) * half)))

    begin = question.region.coordinates(start) / half
    return -minimize(loss, begin, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12}).fun


def test_the_reference(reference):
    question = track_question(reference)
    found = best_grasp(question)
    np.testing.assert_allclose(found.position, GRASP["exact"]["position"], atol=1e-7)
    assert found.tension_factor == pytest.approx(GRASP["exact"]["factor"], abs=1e-8)
    assert found.distance == pytest.approx(question.region.half_width, abs=1e-9)
    assert found.gap is not None and 0.0 <= found.gap <= 1e-9


def test_with_room_enough_it_is_the_best_pose(reference):
    found = best_grasp(track_question(reference, 30.0))
    assert found.tension_factor == pytest.approx(reference["best"]["factor"], abs=1e-10)
    np.testing.assert_allclose(found.position, reference["best"]["at"], atol=1e-7)


def test_nothing_in_the_region_is_above_it(rng):
    """Random robots, turns and regions: against scattered positions, each search from the best of them, and proofs."""
    held = 0
    for _ in range(200):
        question = random_question(rng)
        positions = scattered(question, 3000, rng)
        factors = question.tension_factor(positions)
        try:
            found = best_grasp(question)
        except InfeasibleError as error:
            assert "proved" in error.binding
            assert factors.max() == 0.0
            continue
        held += 1
        assert is_in(question, found)
        assert found.gap is not None and found.gap <= 1e-6
        assert found.tension_factor == pytest.approx(float(question.tension_factor(found.position)), abs=1e-12)
        assert found.tension_factor + found.gap >= factors.max()
        if held % 4 == 0 and factors.max() > 0.0:
            assert found.tension_factor + found.gap >= -1e-10 + climbed(question, positions[np.argmax(factors)])
    assert held > 40


def test_algorithm_1_comes_near_it_from_below(reference):
    question = track_question(reference)
    exact = best_grasp(question).tension_factor
    lacks = [
        exact - grasp_on_grid(question, step, 1e-9).tension_factor for step in (0.01, 0.003, 0.001, 0.0003, 0.0001)
    ]
    assert min(lacks) > 0.0
    assert lacks[-1] < 1e-3
    assert lacks[-1] < 0.03 * lacks[0]


@pytest.mark.parametrize("turn", [0.4, np.pi / 2.0, -2.5])
def test_a_turned_problem_has_the_turned_answer(reference, turn):
    """Also where the stay becomes upright or level."""
    question = track_question(reference)
    given = GRASP["region"]
    level = np.arctan(given["slope"])
    for angle in (turn, -level, np.pi / 2.0 - level):
        c, s = np.cos(angle), np.sin(angle)
        about = np.array([[c, -s], [s, c]])
        shift = np.array([40.0, -7.0])
        region = replace(
            question.region, point=about @ question.region.point + shift, direction=about @ question.region.direction
        )
        moved = GraspQuestion(question.anchors @ about.T + shift, question.attachments, question.phi + angle, region)
        found = best_grasp(moved)
        np.testing.assert_allclose(found.position, about @ best_grasp(question).position + shift, atol=2e-6)
        assert found.tension_factor == pytest.approx(GRASP["exact"]["factor"], abs=1e-8)


def test_a_mirrored_problem_has_the_mirrored_answer(reference):
    """The mirror turns the common sign of the null vector."""
    question = track_question(reference)
    region = replace(
        question.region, point=question.region.point * MIRROR, direction=question.region.direction * MIRROR
    )
    found = best_grasp(GraspQuestion(question.anchors * MIRROR, question.attachments * MIRROR, -question.phi, region))
    np.testing.assert_allclose(found.position, best_grasp(question).position * MIRROR, atol=1e-7)
    assert found.tension_factor == pytest.approx(GRASP["exact"]["factor"], abs=1e-8)


@pytest.mark.parametrize("scale", [1e-3, 1e4])
def test_size_does_not_matter(reference, scale):
    question = track_question(reference)
    was = question.region
    region = GraspRegion(scale * was.point, was.direction, scale * was.half_width, scale * was.half_length)
    found = best_grasp(GraspQuestion(scale * question.anchors, scale * question.attachments, question.phi, region))
    assert found.tension_factor == pytest.approx(GRASP["exact"]["factor"], abs=1e-8)
    np.testing.assert_allclose(found.position / scale, best_grasp(question).position, atol=1e-7)


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, -1.0)])
def test_level_and_upright_stays(reference, direction):
    question = track_question(reference)
    region = GraspRegion.eq19(question.region.point, direction, 0.03, 0.05)
    found = best_grasp(replace(question, region=region))
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, 301), np.linspace(-1.0, 1.0, 301))
    factors = question.tension_factor(region.placed(np.stack((0.05 * x, 0.03 * y), axis=-1)))
    assert 0.0 <= found.tension_factor - factors.max() < 1e-3


def test_a_region_partly_outside_the_workspace(reference):
    question = track_question(reference)
    region = GraspRegion((0.30, 0.395), (1.0, 0.0), 0.02, 0.06)
    found = best_grasp(replace(question, region=region))
    assert 0.0 < found.tension_factor
    assert float(question.tension_factor(region.corners).min()) == 0.0


@pytest.mark.parametrize(("half_width", "half_length"), [(0.0, 0.03), (0.02, 0.0), (0.0, 0.0)])
def test_regions_without_width(reference, half_width, half_length):
    question = track_question(reference)
    thin = replace(question, region=replace(question.region, half_width=half_width, half_length=half_length))
    found = best_grasp(thin)
    share = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 201)] * 2), axis=-1)
    factors = question.tension_factor(thin.region.placed(share * [half_length, half_width]))
    assert 0.0 <= found.tension_factor - factors.max() + 1e-12 < 1e-3


def test_of_equal_maxima_the_nearest_to_the_axis(rng):
    """A robot that is its own mirror image has two maxima; an axis off the middle is nearer to one of them."""
    anchors, attachments = (
        SQUARE * [1.3, 1.0],
        np.array([[-0.3, 0.1], [0.3, 0.1], [0.3, -0.1], [-0.3, -0.1]])[::-1] * [1.0, 0.4],
    )
    whole = GraspRegion((0.0, 0.0), (1.0, 0.0), 0.9, 1.2)
    question = GraspQuestion(anchors, attachments, 0.0, whole)
    for off in (0.07, -0.07):
        moved = replace(question, region=replace(whole, point=(0.0, off)))
        found = best_grasp(moved)
        twin = found.position * [1.0, -1.0]
        assert moved.tension_factor(twin) == pytest.approx(found.tension_factor, abs=1e-9)
        assert found.distance <= moved.region.distance(twin) + 1e-6


def test_an_empty_region_is_proved_and_named(reference):
    question = track_question(reference)
    away = replace(question, region=GraspRegion((3.0, 3.0), (1.0, -1.0), 0.5, 0.5))
    with pytest.raises(InfeasibleError, match=r"\(3, 3\) m at phi = 50 deg: no position of the region .* proved"):
        best_grasp(away)
    with pytest.raises(InfeasibleError, match="proved"):
        best_grasp(replace(question, attachments=np.zeros((4, 2))))
    with pytest.raises(InfeasibleError, match="proved"):
        best_grasp(replace(question, anchors=np.zeros((4, 2)), attachments=np.zeros((4, 2))))


def test_a_larger_region_is_never_worse(rng):
    for _ in range(40):
        question = random_question(rng)
        region = question.region
        wider = replace(region, half_width=1.3 * region.half_width, half_length=1.1 * region.half_length)
        try:
            before = best_grasp(question).tension_factor
        except InfeasibleError:
            continue
        assert best_grasp(replace(question, region=wider)).tension_factor >= before - 1e-8


def test_no_position_outside_the_places_of_the_anchors_is_held(rng):
    """The reason for which a region is trimmed to them."""
    for _ in range(20):
        question = random_question(rng)
        where = rng.uniform(-3.0, 3.0, (4000, 2))
        outside = Delaunay(question.places).find_simplex(where) < 0
        assert not question.tension_factor(where[outside]).any()


def test_a_region_of_any_size_has_the_same_best(reference):
    """Trimming keeps every position that may be held, however large the region, and whether or not it is centred."""
    question = track_question(reference)
    best = reference["best"]["factor"]
    for size in (1.0, 1e2, 1e4, 1e6):
        for off in (0.0, 0.5 * size):
            point = question.region.placed((off, 0.0))
            region = replace(question.region, point=point, half_width=size, half_length=size)
            assert best_grasp(replace(question, region=region)).tension_factor == pytest.approx(best, abs=1e-8)
    front = grasp_front(question, [0.0, question.region.half_width, 1e3, 1e6])
    assert front.tension_factor[1] == pytest.approx(GRASP["exact"]["factor"], abs=1e-8)
    assert front.tension_factor[3] == front.tension_factor[2] >= front.tension_factor[1]


@pytest.mark.parametrize(
    ("changes", "name"), [({"half_width": 1e200}, "half_width"), ({"half_length": 1e7}, "half_length"),
                          ({"point": (1e300, 0.0)}, "distance")])  # fmt: skip
def test_regions_beyond_all_cables_are_refused(reference, changes, name):
    question = track_question(reference)
    with pytest.raises(InputError, match=f"{name} of the grasp region"):
        replace(question, region=replace(question.region, **changes))


def test_the_pose_search_of_the_package_finds_no_more(reference):
    question = track_question(reference, 30.0)
    rough = best_pose(question.anchors, question.attachments, question.phi)
    assert best_grasp(question).tension_factor >= rough.tension_factor - 1e-10


@pytest.mark.parametrize("gap", [0.0, -1.0, np.nan, 2.0])
def test_bad_gaps_are_refused(reference, gap):
    with pytest.raises(InputError, match="gap"):
        best_grasp(track_question(reference), gap)
