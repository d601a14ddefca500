"""Certified regions against sampling, certificates, linear programs, published areas and degenerate robots."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from published_robots import COGIRO, IPANEMA_2, KNTU, rotations
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import (
    null_vector,
    planar_lengths,
    planar_structure_matrix,
    spatial_lengths,
    spatial_structure_matrix,
    tension_factor,
)
from steeplejack.mechanics.cable.region.certified import Label, certify, closure_box
from steeplejack.mechanics.cable.region.determinants import CUBIC
from steeplejack.mechanics.cable.region.facets import planar_facets, spatial_facets
from steeplejack.mechanics.cable.region.rounding import stored_rounding

pytestmark = pytest.mark.long

SAMPLES = 100_000
WRENCH, WINDOW = np.array([0.0, -30.0 * 9.81, 0.0]), (10.0, 250.0)
TILTED = rotations(np.array([[0.05, 0.1, -0.08]]))[0]


@pytest.fixture(scope="module")
def table(reference):
    return np.array(reference["table_iii"]["anchors"]), np.array(reference["table_iii"]["attachments"])


def search(anchors, attachments, low, high):
    return np.vstack((closure_box(anchors, attachments), np.deg2rad([low, high])))


def samples(region, rng, count=SAMPLES):
    """Poses in random boxes, the label of each box and the number of the box."""
    size = np.ptp(region.boxes, axis=2)
    volume = np.where(size > 0.0, size, 1.0).prod(axis=1)
    by_volume = rng.choice(len(volume), count // 2, p=volume / volume.sum())
    box = np.concatenate((by_volume, rng.integers(0, len(volume), count - count // 2)))
    low, high = region.boxes[box, :, 0], region.boxes[box, :, 1]
    return low + rng.random(low.shape) * (high - low), region.labels[box], box


def feasible(structure, wrench, lower, upper):
    """For redundancy one: whether the line of balancing tensions meets the box; and by how much in or out."""
    null = null_vector(structure)
    null /= np.linalg.norm(null, axis=-1, keepdims=True)
    start = -(np.linalg.pinv(structure) @ wrench)
    with np.errstate(divide="ignore"):
        ends = np.sort((np.stack((np.full_like(start, lower), np.full_like(start, upper))) - start) / null, axis=0)
    return ends[1].min(axis=-1) - ends[0].max(axis=-1)


def normal(structure, cables):
    """The certificate direction of a hyperplane: perpendicular to its columns, by the oriented cofactors."""
    columns = structure[:, cables]
    rows = len(structure)
    return np.array([(-1.0) ** (rows - 1 - k) * np.linalg.det(np.delete(columns, k, axis=0)) for k in range(rows)])


def holds(structure, wrench, lower, upper):
    """Linear program: do bounded tensions balance the wrench."""
    size = np.maximum(np.abs(structure).max(axis=1, keepdims=True), 1e-300)
    answer = linprog(
        np.zeros(structure.shape[1]),
        A_eq=structure / size,
        b_eq=-wrench / size[:, 0],
        bounds=np.stack(np.broadcast_arrays(lower, upper, np.empty(structure.shape[1]))[:2], axis=1),
    )
    return answer.status == 0


def closed(structure):
    """Linear program: tensions of at least one without a wrench, with full rank."""
    return np.linalg.matrix_rank(structure) == len(structure) and holds(structure, np.zeros(len(structure)), 1.0, None)


def test_determinants_are_those_of_the_structure_matrix(table, rng):
    anchors, attachments = table
    facets = planar_facets(anchors + 50.0, attachments, [3.0, -300.0, 7.0], *WINDOW)
    for pose in rng.uniform([49.4, 50.0, -3.0], [50.4, 50.9, 3.0], (20, 3)):
        x, y, phi = (pose - facets.origin) / facets.units
        quadratic = np.array([1.0, x, y, x * x, x * y, y * y])
        harmonics = np.array([1.0, np.cos(phi), np.sin(phi), np.cos(2.0 * phi), np.sin(2.0 * phi)])
        lengths = planar_lengths(anchors + 50.0, attachments, pose)
        columns = planar_structure_matrix(anchors + 50.0, attachments, pose) * lengths
        columns /= facets.length * np.array([[1.0], [1.0], [facets.length]])
        wrench = np.array([3.0, -300.0, 7.0 / facets.length]) / 128.0
        whole = [np.linalg.det(columns[:, s]) for s in itertools.combinations(range(4), 3)]
        np.testing.assert_allclose(quadratic @ facets.volumes @ harmonics, whole, atol=1e-12)
        loads = [np.linalg.det(np.column_stack((columns[:, s], wrench))) for s in facets.subsets]
        np.testing.assert_allclose(quadratic @ facets.loads[0] @ harmonics, loads, atol=1e-12)


def test_spatial_determinants_are_cubics(rng):
    anchors, attachments = COGIRO.anchors, COGIRO.attachments
    wrench = np.array([10.0, -20.0, 30.0, 4.0, 5.0, -900.0])
    facets = spatial_facets(anchors, attachments, TILTED, wrench, 100.0, 5000.0)
    scale = np.repeat([facets.length**2, facets.length], 3)[:, None]
    for position in rng.uniform([-4.0, -3.0, 0.0], [4.0, 3.0, 6.0], (5, 3)):
        scaled = (position - facets.origin) / facets.units
        monomials = (scaled ** np.array(CUBIC)).prod(axis=1)
        lengths = spatial_lengths(anchors, attachments, position, TILTED)
        columns = spatial_structure_matrix(anchors, attachments, position, TILTED) * lengths / scale
        whole = [np.linalg.det(columns[:, s]) for s in itertools.combinations(range(8), 6)]
        np.testing.assert_allclose(facets.volumes[:, :, 0] @ monomials, whole, atol=1e-12)
        load = wrench / 4096.0 / np.repeat([facets.length, 1.0], 3)
        loads = [np.linalg.det(np.column_stack((columns[:, s], load))) for s in facets.subsets]
        np.testing.assert_allclose(facets.loads[0, :, :, 0] @ monomials, loads, atol=1e-12)


def test_area_of_table_iii_lies_between_inner_and_outer(table, reference):
    region = certify(planar_facets(*table), search(*table, 50.0, 50.0), 1e-3)
    assert region.reached and region.gap <= 1e-3
    assert region.evaluations < 300_000
    assert region.inner <= reference["workspace"]["area"] <= region.outer
    assert region.outer - region.inner <= 1e-3 * region.outer
    areas = np.ptp(region.boxes[:, :2], axis=2).prod(axis=1)
    assert areas.sum() == pytest.approx(np.ptp(closure_box(*table), axis=1).prod(), rel=1e-12)
    assert areas[region.labels == Label.INSIDE].sum() == pytest.approx(region.inner, rel=1e-12)


@pytest.mark.parametrize(("low", "high", "gap"), [(50.0, 50.0, 1e-3), (44.0, 56.0, 0.1)])
def test_no_sample_in_a_box_of_the_other_kind(table, rng, low, high, gap):
    region = certify(planar_facets(*table), search(*table, low, high), gap)
    poses, labels, _ = samples(region, rng)
    null = null_vector(planar_structure_matrix(*table, poses))
    held = (null > 0.0).all(axis=-1) | (null < 0.0).all(axis=-1)
    assert held[labels == Label.INSIDE].all()
    assert not held[labels == Label.OUTSIDE].any()


@pytest.mark.parametrize(("low", "high", "gap"), [(50.0, 50.0, 1e-3), (44.0, 56.0, 0.15)])
def test_no_sample_of_feasibility_in_a_box_of_the_other_kind(table, rng, low, high, gap):
    region = certify(planar_facets(*table, WRENCH, *WINDOW), search(*table, low, high), gap)
    assert region.reached
    poses, labels, _ = samples(region, rng)
    depth = feasible(planar_structure_matrix(*table, poses), WRENCH, *WINDOW)
    assert (depth[labels == Label.INSIDE] >= -1e-6).all()
    assert (depth[labels == Label.OUTSIDE] <= 1e-6).all()


def test_every_box_outside_names_its_certificate(table, rng):
    for facets, lower, upper in (
        (planar_facets(*table, WRENCH, *WINDOW), *WINDOW),
        (planar_facets(*table), 0.0, np.inf),
    ):
        region = certify(facets, search(*table, 50.0, 50.0), 0.02)
        poses, labels, box = samples(region, rng, 2000)
        assert (region.facets[region.labels != Label.OUTSIDE] == -1).all()
        for pose, number in zip(poses[labels == Label.OUTSIDE], box[labels == Label.OUTSIDE], strict=True):
            subset, side = divmod(region.facets[number], 2)
            structure = planar_structure_matrix(*table, pose)
            z = normal(structure, facets.subsets[subset])
            power = z @ structure
            power[np.abs(power) <= 1e-12 * np.abs(z).max()] = 0.0
            if not facets.limited:
                assert (power >= 0.0).all() if side == 0 else (power <= 0.0).all()
                assert power.any()
                continue
            z, power = (z, power) if side == 1 else (-z, -power)
            least = np.where(power > 0.0, power * lower, power * upper).sum()
            assert least + z @ WRENCH > 0.0


def test_several_wrenches_are_met_together(table, rng):
    wrenches = np.array([[0.0, -200.0, 0.0], [60.0, -200.0, 3.0], [-60.0, -200.0, -3.0]])
    region = certify(planar_facets(*table, wrenches, *WINDOW), search(*table, 50.0, 50.0), 0.02)
    poses, labels, _ = samples(region, rng, 20_000)
    structures = planar_structure_matrix(*table, poses)
    depth = np.min([feasible(structures, wrench, *WINDOW) for wrench in wrenches], axis=0)
    assert (depth[labels == Label.INSIDE] >= -1e-6).all()
    assert (depth[labels == Label.OUTSIDE] <= 1e-6).all()
    assert 0.0 < region.inner < region.outer


@pytest.mark.parametrize("cables", [3, 5, 6])
def test_planar_robots_of_other_redundancies_agree_with_linear_programs(rng, cables):
    turn = np.sort(rng.uniform(0.0, 2.0 * np.pi, cables)) if cables > 3 else np.array([0.3, 1.4, 2.6])
    anchors = np.stack((2.0 * np.cos(turn), 1.5 * np.sin(turn)), axis=1) + rng.uniform(-0.1, 0.1, (cables, 2))
    attachments = rng.uniform(-0.3, 0.3, (cables, 2))
    box = np.array([[-2.0, 2.0], [-1.5, 1.5], [0.2, 0.2]])
    questions = [(planar_facets(anchors, attachments, [3.0, -60.0, 1.0], 2.0, 90.0), True)]
    if cables > 3:
        questions.append((planar_facets(anchors, attachments), False))
    for facets, limited in questions:
        region = certify(facets, box, 0.05, 100_000)
        poses, labels, _ = samples(region, rng, 150)
        for pose, label in zip(poses[labels != Label.UNDECIDED], labels[labels != Label.UNDECIDED], strict=True):
            structure = planar_structure_matrix(anchors, attachments, pose)
            held = holds(structure, np.array([3.0, -60.0, 1.0]), 2.0, 90.0) if limited else closed(structure)
            assert held == (label == Label.INSIDE)


@pytest.mark.parametrize("limited", [False, True])
def test_eight_cables_in_space_agree_with_linear_programs(rng, limited):
    anchors, attachments = IPANEMA_2.anchors, IPANEMA_2.attachments
    weight = np.array([1.0, 2.0, 0.0, 0.0, 0.0, -98.1])
    facets = spatial_facets(anchors, attachments, TILTED, *((weight, 1.0, 200.0) if limited else ()))
    region = certify(facets, closure_box(anchors, attachments), 0.25)
    assert region.reached and 0.0 < region.inner < region.outer
    poses, labels, _ = samples(region, rng, 200)
    for pose, label in zip(poses[labels != Label.UNDECIDED], labels[labels != Label.UNDECIDED], strict=True):
        structure = spatial_structure_matrix(anchors, attachments, pose, TILTED)
        held = holds(structure, weight, 1.0, 200.0) if limited else closed(structure)
        assert held == (label == Label.INSIDE)


def test_cogiro_closes_only_where_its_platform_straddles_the_plane_of_its_anchors():
    facets = spatial_facets(COGIRO.anchors, COGIRO.attachments, TILTED)
    box = closure_box(COGIRO.anchors, COGIRO.attachments)
    box[2] = 0.0, 4.2  # the highest attachment is below the lowest anchor
    region = certify(facets, box)
    assert region.reached and region.outer == 0.0 and region.gap == 0.0
    box[2] = 4.2, 5.5
    region = certify(facets, box, 0.5)
    assert region.inner > 0.0
    middle = region.of(Label.INSIDE)[0].mean(axis=1)
    assert closed(spatial_structure_matrix(COGIRO.anchors, COGIRO.attachments, middle, TILTED))


@pytest.mark.parametrize(("length", "force", "away"), [(1e-9, 1e9, 0.0), (1e9, 1e-9, 0.0), (1.0, 1.0, 1000.0)])
def test_units_and_origin_do_not_matter(table, length, force, away):
    anchors, attachments = table
    box = search(*table, 50.0, 50.0)
    near = certify(planar_facets(*table, WRENCH, *WINDOW), box, 0.02)
    moved = box.copy()
    moved[:2] = (box[:2] + away) * length
    window = tuple(force * limit for limit in WINDOW)
    facets = planar_facets((anchors + away) * length, attachments * length, force * WRENCH, *window)
    far = certify(facets, moved, 0.02)
    assert far.inner / length**2 == pytest.approx(near.inner, rel=1e-3)
    assert far.outer / length**2 == pytest.approx(near.outer, rel=1e-3)


def test_cables_that_coincide_do_not_upset(rng):
    anchors, attachments = np.vstack((KNTU.anchors, KNTU.anchors[:1])), np.vstack((KNTU.attachments,) * 2)[:5]
    box = np.vstack((closure_box(anchors, attachments), [0.1, 0.1]))
    twice = certify(planar_facets(anchors, attachments), box, 0.01)
    once = certify(planar_facets(KNTU.anchors, KNTU.attachments), box, 0.01)
    assert twice.inner == pytest.approx(once.inner, rel=0.01)
    assert twice.reached and once.reached


def test_fuzzed_robots_are_refused_or_right(rng):
    refused = 0
    for trial in range(120):
        anchors = rng.integers(-2, 3, (4, 2)) * 10.0 ** rng.integers(-9, 10)
        attachments = 0.3 * rng.integers(-1, 2, (4, 2)) * np.abs(anchors).max(initial=0.0)
        if trial % 6 == 0:
            attachments[:] = attachments[0]
        phi = float(rng.choice([0.0, 0.1, np.pi / 2.0]))
        try:
            facets = planar_facets(anchors, attachments)
        except InputError:
            refused += 1
            structures = planar_structure_matrix(anchors, attachments, rng.normal(size=(20, 3)))
            assert not tension_factor(structures).any()
            continue
        region = certify(facets, np.vstack((closure_box(anchors, attachments), [phi, phi])), 0.05, 2000)
        poses, labels, _ = samples(region, rng, 200)
        held = tension_factor(planar_structure_matrix(anchors, attachments, poses)) > 0.0
        assert held[labels == Label.INSIDE].all()
        assert not held[labels == Label.OUTSIDE].any()
    assert 20 <= refused < 40


def test_giving_up_says_so(table):
    region = certify(planar_facets(*table), search(*table, 50.0, 50.0), 1e-6, 1000)
    assert not region.reached and region.evaluations <= 1000
    assert region.gap > 1e-6 and Label(region.labels[-1]).advice


SQUARE = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"anchors": [[0.0, np.nan], *SQUARE[1:]]}, "anchors"),
        ({"anchors": [[0.0, np.inf], *SQUARE[1:]]}, "anchors"),
        ({"anchors": [[0.0, 0.0, 0.0]] * 4}, "anchors"),
        ({"anchors": SQUARE[:3], "attachments": SQUARE[:3]}, "cables"),
        ({"attachments": SQUARE[:3]}, "cables"),
        ({"attachments": [[0.1, 0.0]] * 4}, "cables"),
        ({"anchors": [[0.0, 0.0]] * 4, "attachments": [[0.0, 0.0]] * 4}, "anchors"),
        ({"lower": 1.0}, "tension limits"),
        ({"lower": 1.0, "upper": 1.0}, "tension limits"),
        ({"lower": 1.0, "upper": np.inf}, "tension limits"),
        ({"lower": [1.0, 2.0], "upper": 5.0}, "tension limits"),
        ({"lower": 1.0, "upper": 2.0, "wrenches": [0.0, np.nan, 0.0]}, "wrenches"),
        ({"lower": 1.0, "upper": 2.0, "wrenches": [0.0, 0.0]}, "wrenches"),
    ],
)
def test_questions_that_mean_nothing_are_refused(changes, where):
    with pytest.raises(InputError) as error:
        planar_facets(**({"anchors": SQUARE, "attachments": np.array(SQUARE) * 0.1} | changes))
    assert error.value.where == where


@pytest.mark.parametrize(
    ("box", "gap", "where"),
    [
        ([[0.0, 1.0], [0.0, 1.0]], 0.1, "box"),
        ([[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]], 0.1, "box"),
        ([[0.0, np.inf], [0.0, 1.0], [0.0, 0.0]], 0.1, "box"),
        ([[0.0, 0.0], [0.0, 0.0], [0.0, 0.0]], 0.1, "box"),
        ([[0.0, 1.0], [0.0, 1.0], [0.0, 0.0]], 0.0, "gap"),
        ([[0.0, 1.0], [0.0, 1.0], [0.0, 0.0]], np.nan, "gap"),
    ],
)
def test_boxes_that_mean_nothing_are_refused(table, box, gap, where):
    with pytest.raises(InputError) as error:
        certify(planar_facets(*table), box, gap)
    assert error.value.where == where


def test_sizes_too_unlike_are_refused():
    with pytest.raises(InputError, match="unlike"):
        planar_facets(SQUARE, np.array(SQUARE) * 1e-320)


def test_four_cables_through_one_point_agree_with_linear_programs(rng):
    anchors = rng.normal(size=(8, 3))
    anchors *= 3.0 / np.linalg.norm(anchors, axis=1, keepdims=True)
    attachments = rng.uniform(-0.5, 0.5, (8, 3))
    attachments[:4] = attachments[0]
    load = np.array([0.1, 0.2, -0.1, 2.0, 1.0, -30.0])
    facets = spatial_facets(anchors, attachments, TILTED, load, 1.0, 300.0)
    assert len(facets.subsets) == 52  # the four span a space of three: with one cable more they span no hyperplane
    region = certify(facets, closure_box(anchors, attachments), 0.5, 6000)
    poses, labels, _ = samples(region, rng, 120)
    for pose, label in zip(poses[labels != Label.UNDECIDED], labels[labels != Label.UNDECIDED], strict=True):
        structure = spatial_structure_matrix(anchors, attachments, pose, TILTED)
        assert holds(structure, load, 1.0, 300.0) == (label == Label.INSIDE)


def test_rotations_that_are_none_are_refused():
    with pytest.raises(InputError, match="rotation"):
        spatial_facets(COGIRO.anchors, COGIRO.attachments, 1.1 * np.eye(3))


LINE = np.array([0.5, -0.4, 0.3, -0.5, 0.2, -0.1, 0.45, -0.3])
CORNERS = np.array([[4.0 * x, 3.0 * y, z] for z in (5.0, 0.0) for x, y in ((-1, 1), (1, 1), (1, -1), (-1, -1))])
LOAD = np.array([0.0, 0.0, 0.0, 0.0, 0.0, -100.0])


@pytest.mark.parametrize("limited", [(), (LOAD, 1.0, 500.0)])
@pytest.mark.parametrize("seed", range(4))
def test_attachments_on_one_line_are_refused_at_every_rotation(limited, seed):
    rotation = Rotation.random(random_state=seed).as_matrix()
    with pytest.raises(InputError, match="singular"):
        spatial_facets(CORNERS, np.outer(LINE, [1.0, 0.0, 0.0]), rotation, *limited)
    with pytest.raises(InputError, match="singular"):
        spatial_facets(CORNERS, np.full((8, 3), [0.1, 0.2, -0.3]), rotation, *limited)


@pytest.mark.parametrize("limited", [(), (LOAD, 1.0, 500.0)])
@pytest.mark.parametrize("where", ["attachments", "anchors"])
def test_points_on_one_line_but_for_their_rounding_are_never_inside(limited, where, rng):
    """No direction but an axis can be stored without rounding; what that leaves of the determinants decides nothing."""
    for seed in range(3):
        anchors, attachments = CORNERS, rng.uniform(-0.4, 0.4, (8, 3))
        if where == "attachments":
            attachments = np.outer(LINE, [1.0, 2.0, 0.3])
        else:
            anchors = np.outer(8.0 * LINE, [0.3, 1.0, 0.7]) + [0.1, 0.2, 0.3]
        facets = spatial_facets(anchors, attachments, Rotation.random(random_state=seed).as_matrix(), *limited)
        region = certify(facets, [[-3.0, 3.0], [-2.0, 2.0], [1.0, 4.0]], 0.1, 1000)
        assert region.inner == 0.0


@pytest.mark.parametrize("limited", [False, True])
@pytest.mark.parametrize("kind", ["coplanar", "concurrent"])
def test_coplanar_and_concurrent_attachments_agree_with_linear_programs(rng, kind, limited):
    attachments = rng.uniform(-0.6, 0.6, (8, 3))
    if kind == "coplanar":
        attachments = attachments[:, :2] @ Rotation.random(random_state=7).as_matrix()[:2]
    else:
        attachments[:3] = attachments[0]
    rotation = Rotation.random(random_state=3).as_matrix()
    facets = spatial_facets(CORNERS, attachments, rotation, *((LOAD, 1.0, 500.0) if limited else ()))
    region = certify(facets, [[-3.0, 3.0], [-2.0, 2.0], [1.0, 4.0]], 0.3, 8000)
    poses, labels, _ = samples(region, rng, 100)
    sure = labels != Label.UNDECIDED
    assert sure.any()
    for pose, label in zip(poses[sure], labels[sure], strict=True):
        structure = spatial_structure_matrix(CORNERS, attachments, pose, rotation)
        held = holds(structure, LOAD, 1.0, 500.0) if limited else closed(structure)
        assert held == (label == Label.INSIDE)


def test_stored_rounding_bounds_what_a_last_place_changes(rng):
    anchors, attachments = IPANEMA_2.anchors, IPANEMA_2.attachments
    box = np.array([[-1.0, 1.0], [-1.0, 1.0], [1.0, 3.0]])
    near = spatial_facets(anchors, attachments, TILTED, LOAD, 1.0, 500.0)
    low, high = ((end - near.origin) / near.units for end in box.T)
    bound = stored_rounding(near, low, high)
    moved = spatial_facets(anchors, attachments * (1.0 + 2.0**-52), TILTED, LOAD, 1.0, 500.0)
    monomials = (rng.uniform(low, high, (200, 1, 3)) ** np.array(CUBIC)).prod(axis=-1)
    both = [np.concatenate((f.volumes[:, :, 0], f.loads[0, :, :, 0])) @ monomials.T for f in (near, moved)]
    sizes = np.abs(both[0]).max(axis=1)
    assert (np.abs(both[1] - both[0]).max(axis=1) <= bound + 1e-15 * sizes).all()
    assert (bound < 1e-9 * sizes.max()).all()


def test_more_determinants_than_anyone_waits_for_are_refused(rng):
    for facets, d, count, more in ((planar_facets, 2, 36, ()), (spatial_facets, 3, 16, (np.eye(3),))):
        with pytest.raises(InputError, match="6000 at most"):
            facets(rng.normal(size=(count, d)), rng.normal(size=(count, d)), *more)
