"""Boundaries along rays: two routes against each other, published areas, bounded tensions, and degenerate rays."""

from __future__ import annotations

import numpy as np
import pytest
from published_robots import IPANEMA_2, KNTU, PLANAR_4_4, rotations

from steeplejack.errors import InputError
from steeplejack.mechanics.cable import null_vector, planar_structure_matrix, spatial_structure_matrix
from steeplejack.mechanics.cable.region.boundary import certified_rays, closure_rays
from steeplejack.mechanics.cable.region.certified import Label, certify
from steeplejack.mechanics.cable.region.facets import planar_facets, spatial_facets

pytestmark = pytest.mark.long

WRENCH, WINDOW = np.array([0.0, -30.0 * 9.81, 0.0]), (10.0, 250.0)
TILTED = rotations(np.array([[0.05, 0.1, -0.08]]))[0]


@pytest.fixture(scope="module")
def table(reference):
    return np.array(reference["table_iii"]["anchors"]), np.array(reference["table_iii"]["attachments"])


def scan(anchors, phi, along, panels, points=8):
    """Parallel rays over the anchors' box, at Gauss-Legendre nodes of equal panels, with their weights [m]."""
    low, high = anchors.min(axis=0), anchors.max(axis=0)
    nodes, weights = np.polynomial.legendre.leggauss(points)
    share = ((np.arange(panels)[:, None] + 0.5 + 0.5 * nodes) / panels).ravel()
    starts = np.full((share.size, 3), phi)
    starts[:, along], starts[:, 1 - along] = low[along], low[1 - along] + share * np.ptp(anchors, axis=0)[1 - along]
    ends = starts.copy()
    ends[:, along] = high[along]
    return starts, ends, np.tile(0.5 * weights, panels) / panels * np.ptp(anchors, axis=0)[1 - along]


def same_crossings(first, second, tolerance):
    for ray in range(len(first.starts)):
        np.testing.assert_allclose(first.crossings(ray), second.crossings(ray), atol=tolerance)


def in_closure(structure):
    null = null_vector(structure)
    return (null > 0.0).all(axis=-1) | (null < 0.0).all(axis=-1)


@pytest.mark.parametrize("along", [0, 1])
def test_area_of_table_iii_by_rays(table, reference, along):
    starts, ends, weights = scan(table[0], np.deg2rad(50.0), along, 1500)
    rays = closure_rays(planar_facets(*table), starts, ends)
    area = (rays.share(Label.INSIDE) * weights).sum() * np.ptp(table[0], axis=0)[along]
    assert area == pytest.approx(reference["workspace"]["area"], rel=1e-6)


def test_area_in_bounded_tensions_lies_in_the_certified_one(table):
    facets = planar_facets(*table, WRENCH, *WINDOW)
    starts, ends, weights = scan(table[0], np.deg2rad(50.0), 0, 60)
    rays = certified_rays(facets, starts, ends, 1e-9)
    area = (rays.share(Label.INSIDE) * weights).sum() * np.ptp(table[0], axis=0)[0]
    box = np.column_stack((np.append(table[0].min(axis=0), np.deg2rad(50.0)),) * 2)
    box[:2, 1] = table[0].max(axis=0)
    region = certify(facets, box, 2e-3)
    assert region.inner * (1.0 - 1e-4) <= area <= region.outer * (1.0 + 1e-4)


def test_roots_and_subdivision_agree_along_lines(table, rng):
    facets = planar_facets(*table)
    starts, ends = rng.uniform([-0.7, -0.1, 0.87], [0.5, 1.0, 0.87], (2, 200, 3))
    exact, proved = closure_rays(facets, starts, ends), certified_rays(facets, starts, ends)
    same_crossings(exact, proved, 1e-11)
    assert sum(len(exact.crossings(ray)) for ray in range(200)) > 100


def test_roots_and_subdivision_agree_along_turns(table, rng):
    for anchors, attachments in (table, (PLANAR_4_4.anchors, PLANAR_4_4.attachments)):
        facets = planar_facets(anchors, attachments)
        low, high = anchors.min(axis=0), anchors.max(axis=0)
        starts = np.column_stack((rng.uniform(low, high, (100, 2)), rng.uniform(-6.0, 6.0, 100)))
        ends = starts + np.column_stack((np.zeros((100, 2)), rng.uniform(-np.pi, np.pi, 100)))
        exact, proved = closure_rays(facets, starts, ends), certified_rays(facets, starts, ends)
        same_crossings(exact, proved, 1e-9)
        assert sum(len(exact.crossings(ray)) for ray in range(100)) > 5


def test_roots_and_subdivision_agree_in_space(rng):
    facets = spatial_facets(IPANEMA_2.anchors, IPANEMA_2.attachments, TILTED)
    starts, ends = rng.uniform([-4.0, -3.0, 0.0], [4.0, 3.0, 6.0], (2, 60, 3))
    exact, proved = closure_rays(facets, starts, ends), certified_rays(facets, starts, ends)
    same_crossings(exact, proved, 1e-9)
    assert sum(len(exact.crossings(ray)) for ray in range(60)) > 30


def test_closure_changes_at_a_crossing_and_nowhere_else(table, rng):
    facets = planar_facets(*table)
    starts, ends = rng.uniform([-0.7, -0.1, 0.87], [0.5, 1.0, 0.87], (2, 50, 3))
    rays = closure_rays(facets, starts, ends)
    for ray in range(50):
        direction = (ends[ray] - starts[ray]) / np.linalg.norm(ends[ray] - starts[ray])
        for pose in rays.crossings(ray):
            sides = pose + 1e-10 * np.array([[-1.0], [1.0]]) * direction
            assert in_closure(planar_structure_matrix(*table, sides)).sum() == 1
        share = rng.random(200)
        piece = np.sum(share[:, None] > rays.places[ray, 1:], axis=1)
        poses = starts[ray] + share[:, None] * (ends[ray] - starts[ray])
        assert (in_closure(planar_structure_matrix(*table, poses)) == (rays.labels[ray, piece] == Label.INSIDE)).all()


def test_bounded_tensions_run_out_at_a_crossing(table, rng):
    facets = planar_facets(*table, WRENCH, *WINDOW)
    starts = rng.uniform([-0.6, 0.0, 0.7], [0.4, 0.9, 1.0], (80, 3))
    ends = rng.uniform([-0.6, 0.0, 0.7], [0.4, 0.9, 1.0], (80, 3))
    rays = certified_rays(facets, starts, ends, 1e-11)
    poses = np.concatenate([rays.crossings(ray) for ray in range(80)])
    assert len(poses) > 20
    structures = planar_structure_matrix(*table, poses)
    null = null_vector(structures) / np.linalg.norm(null_vector(structures), axis=-1, keepdims=True)
    start = -(np.linalg.pinv(structures) @ WRENCH)
    limits = np.sort((np.array(WINDOW)[:, None, None] - start) / null, axis=0)
    np.testing.assert_allclose(limits[1].min(axis=-1) - limits[0].max(axis=-1), 0.0, atol=1e-6)


def test_what_coincides_or_stays_singular_is_outside():
    facets = planar_facets(np.vstack((KNTU.anchors, KNTU.anchors[:1])), np.vstack((KNTU.attachments,) * 2)[:5])
    start, end = [-1.1, 0.2, 0.05], [1.1, 0.2, 0.05]
    once = closure_rays(planar_facets(KNTU.anchors, KNTU.attachments), start, end)
    twice = closure_rays(facets, start, end)
    np.testing.assert_allclose(once.crossings(0), twice.crossings(0), atol=1e-12)


def test_a_ray_through_singular_poses_ends_and_is_never_inside():
    square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
    facets = planar_facets(square, 0.1 * np.array(square))  # singular wherever phi = 0
    start, end = [-0.9, 0.3, 0.0], [0.9, 0.3, 0.0]
    assert closure_rays(facets, start, end).labels.tolist() == [[Label.OUTSIDE]]
    assert certified_rays(facets, start, end).labels.tolist() == [[Label.UNDECIDED]]


def test_rays_without_length_keep_their_label(table):
    facets = planar_facets(*table)
    for pose, label in (([-0.1, 0.45, 0.87], Label.INSIDE), ([0.4, 0.1, 0.87], Label.OUTSIDE)):
        for rays in (closure_rays(facets, pose, pose), certified_rays(facets, pose, pose)):
            assert rays.labels.tolist() == [[label]]
            assert rays.crossings(0).shape == (0, 3)


def test_labels_in_space_are_those_of_the_structure_matrix(rng):
    facets = spatial_facets(IPANEMA_2.anchors, IPANEMA_2.attachments, TILTED, [0, 0, 0, 0, 0, -98.1], 1.0, 200.0)
    start, end = np.array([-3.9, -2.0, 1.5]), np.array([3.9, 2.5, 3.0])
    rays = certified_rays(facets, start, end, 1e-9)
    crossings = rays.crossings(0)
    assert len(crossings) == 2
    inside = crossings.mean(axis=0)
    structure = spatial_structure_matrix(IPANEMA_2.anchors, IPANEMA_2.attachments, inside, TILTED)
    assert np.linalg.matrix_rank(structure) == 6


@pytest.mark.parametrize(
    ("start", "end", "where"),
    [
        ([0.0, 0.0, np.nan], [1.0, 0.0, 0.0], "rays"),
        ([0.0, 0.0], [1.0, 0.0], "rays"),
        ([0.0, 0.0, 0.0], [1.0, 0.0, 0.5], "rays"),
        ([0.0, 0.0, 0.0], [0.0, 0.0, 3.5], "rays"),
    ],
)
def test_rays_that_mean_nothing_are_refused(table, start, end, where):
    with pytest.raises(InputError) as error:
        closure_rays(planar_facets(*table), start, end)
    assert error.value.where == where


def test_questions_a_route_cannot_answer_are_refused(table):
    limited = planar_facets(*table, WRENCH, *WINDOW)
    with pytest.raises(InputError, match="certified_rays"):
        closure_rays(limited, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0])
    with pytest.raises(InputError, match="tolerance"):
        certified_rays(limited, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0)


def test_rays_of_a_robot_singular_but_for_rounding_stay_undecided():
    anchors = np.array([[4.0 * x, 3.0 * y, z] for z in (5.0, 0.0) for x, y in ((-1, 1), (1, 1), (1, -1), (-1, -1))])
    attachments = np.outer([0.5, -0.4, 0.3, -0.5, 0.2, -0.1, 0.45, -0.3], [1.0, 2.0, 0.3])
    facets = spatial_facets(anchors, attachments, TILTED)
    start, end = [[-3.0, -2.0, 1.0], [-1.0, 1.0, 2.0]], [[3.0, 2.0, 4.0], [1.5, -1.0, 2.0]]
    assert (closure_rays(facets, start, end).labels == Label.UNDECIDED).all()
    assert (certified_rays(facets, start, end, 1e-2).labels == Label.UNDECIDED).all()
