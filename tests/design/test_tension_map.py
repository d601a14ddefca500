"""Labelled maps of Table III: counts, statistics, area, files and bad input."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.design import summarise, tension_map, write_map
from steeplejack.design.tension_map import Load
from steeplejack.errors import InputError
from steeplejack.mechanics.cable import null_vector, planar_lengths, planar_structure_matrix, tension_factor
from steeplejack.robots.squad.planar import stay_directions


@pytest.fixture(scope="module")
def table(reference):
    return np.array(reference["table_iii"]["anchors"]), np.array(reference["table_iii"]["attachments"])


@pytest.fixture(scope="module")
def load(reference):
    given = reference["workspace"]
    return Load(given["mass"], tuple(given["window"]), tuple(reference["table_iii"]["gravity"]))


def exact_area(anchors, attachments, phi, rows):
    """Area in wrench closure: exact along rows, where cofactors of long columns are quadratics in x; midpoints in y."""
    (left, bottom), (right, top) = anchors.min(axis=0), anchors.max(axis=0)
    ys = bottom + (np.arange(rows) + 0.5) / rows * (top - bottom)
    xs = np.linspace(left, right, 3)
    x, y = np.meshgrid(xs, ys)
    poses = np.stack((x, y, np.full(x.shape, phi)), axis=-1)
    lengths = planar_lengths(anchors, attachments, poses)
    samples = null_vector(planar_structure_matrix(anchors, attachments, poses)) / lengths
    samples *= lengths.prod(axis=-1, keepdims=True)
    a, b, c = np.linalg.solve(np.vander(xs, 3), samples.transpose(1, 0, 2).reshape(3, -1)).reshape(3, rows, 4)
    half = np.sqrt(np.maximum(b**2 - 4.0 * a * c, 0.0))
    roots = np.clip(np.concatenate(((-b - half) / (2.0 * a), (-b + half) / (2.0 * a)), axis=-1), left, right)
    ends = np.sort(np.concatenate((roots, np.full((rows, 1), left), np.full((rows, 1), right)), axis=-1), axis=-1)
    middles = 0.5 * (ends[:, 1:] + ends[:, :-1])
    where = np.stack((middles, np.broadcast_to(ys[:, None], middles.shape), np.full(middles.shape, phi)), axis=-1)
    inside = tension_factor(planar_structure_matrix(anchors, attachments, where)) > 0.0
    return float((np.diff(ends) * inside).sum() * (top - bottom) / rows)


def test_reference_maps(table, reference):
    for given in reference["map"]:
        summary = summarise(tension_map(*table, np.deg2rad(given["phi_deg"]), 0.01))
        assert summary.nodes == 103 * 90
        assert summary.inside == summary.inside_wrench_closure == given["inside"]
        assert summary.area == pytest.approx(given["inside"] * 1e-4)
        assert summary.max_tension_factor == pytest.approx(given["max"], rel=1e-6, abs=5e-7)
        assert summary.mean_tension_factor == pytest.approx(given["mean"], rel=1e-6, abs=5e-7)
        if "at" in given:
            np.testing.assert_allclose(summary.best_pose, [*given["at"], np.deg2rad(50.0)])


def test_area_of_the_workspace(table, reference):
    area = exact_area(*table, np.deg2rad(50.0), 20_000)
    assert area == pytest.approx(reference["workspace"]["area"], rel=1e-6)
    assert summarise(tension_map(*table, np.deg2rad(50.0), 0.0005)).area == pytest.approx(area, rel=2e-5)


def test_a_range_of_orientations_pools_nodes(table):
    angles = np.deg2rad([44.0, 50.0, 56.0])
    each = [summarise(tension_map(*table, angle, 0.01)) for angle in angles]
    pooled = summarise(tension_map(*table, angles, 0.01))
    assert pooled.inside == sum(summary.inside for summary in each)
    total = sum(summary.inside * summary.mean_tension_factor for summary in each)
    assert pooled.mean_tension_factor == pytest.approx(total / pooled.inside)
    assert max(s.area for s in each) < pooled.area < sum(s.area for s in each)
    assert pooled.best_pose == each[1].best_pose


def test_thirty_kilograms_fit_276_of_1610_nodes(table, reference, load):
    summary = summarise(tension_map(*table, np.deg2rad(50.0), 0.01, load))
    assert summary.inside_wrench_closure == reference["workspace"]["feasible"]
    assert summary.inside > summary.inside_wrench_closure


def test_a_pull_limit_takes_nodes_away(table, load):
    free = summarise(tension_map(*table, np.deg2rad(50.0), 0.01, load))
    foot = 1.02267
    slope = -np.tan(np.deg2rad(33.1097))
    stays = stay_directions(table[0], {"1": (-1.0, 0.0), "2": (slope, -slope * foot)})
    limited = Load(load.mass, load.window, load.gravity, stays, 100.0)
    dataset = tension_map(*table, np.deg2rad(50.0), 0.01, limited)
    assert 0 < summarise(dataset).inside < free.inside
    assert dataset.attrs["criterion"] == "wrench feasibility"


def test_nothing_inside_has_no_best_pose(table, load):
    heavy = Load(1000.0, load.window, load.gravity)
    summary = summarise(tension_map(*table, np.deg2rad(50.0), 0.05, heavy))
    assert (summary.inside, summary.area, summary.max_tension_factor) == (0, 0.0, 0.0)
    assert summary.best_pose is None and summary.mean_tension_factor is None


def test_the_dataset_says_what_it_holds(table, load):
    dataset = tension_map(*table, np.deg2rad([49.0, 50.0]), 0.02, load)
    assert dataset["tension_factor"].dims == dataset["margin"].dims == dataset["inside"].dims == ("phi", "y", "x")
    for name, units in (("x", "m"), ("y", "m"), ("phi", "radian"), ("tension_factor", "1"), ("margin", "1")):
        assert dataset[name].attrs["units"] == units
        assert dataset[name].attrs["long_name"]
    assert dataset.attrs["Conventions"].startswith("CF-")
    np.testing.assert_array_equal(dataset["anchor"], table[0])


def test_netcdf_round_trip(table, load, tmp_path):
    import xarray as xr

    dataset = tension_map(*table, np.deg2rad(50.0), 0.02, load)
    write_map(dataset, tmp_path / "map.nc")
    with xr.open_dataset(tmp_path / "map.nc") as read:
        xr.testing.assert_identical(read.load(), dataset)
        assert summarise(read) == summarise(dataset)


@pytest.mark.parametrize("step", [0.0, -0.01, np.nan, 5.0, 1e-6])
def test_bad_steps_are_refused(table, step):
    with pytest.raises(InputError, match="step"):
        tension_map([[0.2, 0.2], [0.5, 0.3], [0.4, 0.9], [0.1, 0.8]], table[1], 0.5, step)


@pytest.mark.parametrize("phis", [[], [np.nan]])
def test_bad_orientations_are_refused(table, phis):
    with pytest.raises(InputError, match="phi"):
        tension_map(*table, phis, 0.1)


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"mass": -1.0}, "mass"),
        ({"window": (250.0, 10.0)}, "tension window"),
        ({"window": (10.0, np.inf)}, "tension window"),
        ({"pull_limit": 0.0}, "pull limit"),
        ({"pull_limit": 100.0}, "pull limit"),
    ],
)
def test_bad_loads_are_refused(changes, where):
    with pytest.raises(InputError) as error:
        Load(**({"mass": 30.0, "window": (10.0, 250.0), "gravity": (0.0, -9.81)} | changes))
    assert error.value.where == where
