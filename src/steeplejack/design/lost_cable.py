"""What a lost cable does at every pose of a grid or a mission, as a labelled dataset and as the worst of each cable.

Every pose is one at which the winches are locked and a cable is lost; the statics are those of
`steeplejack.mechanics.cable.lost_cable_map`, without dynamic overshoot.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.region.grid import grid_nodes
from steeplejack.mechanics.cable.rest.lost import LostCableMap
from steeplejack.mechanics.cable.structure import planar_structure_matrix
from steeplejack.mechanics.cable.wrench.closure import in_wrench_closure

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MOST_POSES = 1_000_000  # [1] a quarter of an hour on one core, and some 400 MB
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class WorstCase:
    """What the loss of one cable does at worst.

    Drop, tension and lowest corner are over the poses from which the platform settles, each the worst by itself: the
    poses they belong to differ. Where ``unsettled`` is not 0 they say nothing about the other poses, which may be
    worse.

    Attributes:
        cable: The cable lost, from 1.
        settled: Poses from which the platform comes to rest.
        unsettled: The others.
        drop: How far the reference point sinks, at most [m]; None where it nowhere settles.
        at: Index of the pose of that drop; None where it nowhere settles.
        tension: Greatest of the cables that are left, at rest [N].
        tension_at: Index of the pose of that tension.
        lowest: Least height of a corner on the way [m].
        lowest_at: Index of the pose of that height.
        stays_above: Whether every corner stays above the floor at every pose; None where no floor is given.
        unsettled_tension: Greatest tension at which the search stopped without rest, a sign of size and no bound; None
            where it settles from everywhere, or stopped nowhere at a number [N].
    """

    cable: int
    settled: int
    unsettled: int
    drop: float | None
    at: int | None
    tension: float | None
    tension_at: int | None
    lowest: float | None
    lowest_at: int | None
    stays_above: bool | None
    unsettled_tension: float | None


def closure_nodes(anchors: ArrayLike, attachments: ArrayLike, phis: ArrayLike, step: float) -> Array:
    """Poses of a grid in wrench closure: integer multiples of a step inside the anchors' box, at every orientation.

    Args:
        anchors: (m, 2) [m].
        attachments: In the platform frame, (m, 2) [m].
        phis: (k,) [rad].
        step: Distance of nodes [m].

    Returns:
        ``(x, y, phi)``, (n, 3) [m, m, rad].

    Raises:
        InputError: A step that is not positive or too fine, or an orientation that is not finite.
    """
    fixed, angles = np.asarray(anchors, dtype=np.float64), np.atleast_1d(np.asarray(phis, dtype=np.float64))
    if not (np.isfinite(step) and step > 0.0):
        raise InputError("step", f"{step:g} m", "positive and finite")
    if not np.isfinite(angles).all():
        raise InputError("phis", f"{angles.tolist()}", "finite angles")
    low, high = fixed.min(axis=0), fixed.max(axis=0)
    count = angles.size * float(np.prod((high - low) / step + 1.0))
    if count > MOST_POSES:
        raise InputError("step", f"{step:g} m makes {count:.3g} poses", f"at most {MOST_POSES}")
    x, y = (grid_nodes(float(a), float(b), step) for a, b in zip(low, high, strict=True))
    grid = np.stack(np.meshgrid(angles, y, x, indexing="ij"), axis=-1).reshape(-1, 3)[:, ::-1]
    return grid[in_wrench_closure(planar_structure_matrix(fixed, attachments, grid))]


def lost_cable_dataset(
    lost: LostCableMap,
    positions: ArrayLike,
    cables: Sequence[int],
    up: ArrayLike,
    more: Mapping[str, tuple[Sequence[Any] | Array, dict[str, Any]]],
    attributes: Mapping[str, Any],
    floor: float | None = None,
) -> xr.Dataset:
    """Label a map of lost cables.

    Args:
        lost: The map, of k poses and l cables.
        positions: Of the reference point before the loss, (k, 2) or (k, 3) [m].
        cables: Which were lost, from 0, (l,).
        up: Axis of the world along which heights are measured, (3,).
        more: What else is known of each pose, by name: (k,) values and their attributes.
        attributes: Of the whole.
        floor: Height that the sweep has to stay above [m].

    Returns:
        ``drop``, ``greatest_tension``, ``lowest`` and ``settled`` over (pose, cable), with a floor ``stays_above``; the
        ``tension`` of each surviving cable; ``settled_position`` and the ``sweep`` of all corners, least and greatest
        coordinates. Not a number where the platform does not settle; only there ``unsettled_tension`` is one.
    """
    import xarray as xr  # heavy, and only maps need it

    places = np.asarray(positions, dtype=np.float64)
    d, settled = places.shape[1], lost.settled
    pair, lowest = ("pose", "cable"), _where(settled, lost.lowest(up))
    sweep = np.stack((lost.corner_box[..., 0, :d], lost.corner_box[..., 1, :d]), axis=2)
    yes = {"flag_values": [0, 1], "flag_meanings": "no yes"}
    variables = {
        "drop": (pair, _where(settled, lost.drop), _about("how far the reference point sinks", "m")),
        "greatest_tension": (
            pair,
            _where(settled, lost.greatest_tension),
            _about("greatest tension of the cables left, at rest", "N"),
        ),
        "unsettled_tension": (
            pair,
            _where(~settled, lost.greatest_tension),
            _about("greatest tension where the search stopped without rest, no bound", "N"),
        ),
        "lowest": (pair, lowest, _about("least height of a corner of the platform on the way", "m")),
        "settled": (pair, settled.astype(np.int8), _about("platform comes to rest", "1", **yes)),
        "tension": ((*pair, "survivor"), _where(settled, lost.tensions), _about("tension at rest", "N")),
        "settled_position": (
            (*pair, "axis"),
            _where(settled, lost.position[..., :d]),
            _about("reference point at rest", "m"),
        ),
        "sweep": (
            (*pair, "bound", "axis"),
            _where(settled, sweep),
            _about("box that all corners stay in on the damped path", "m"),
        ),
    }
    if floor is not None:
        above = (settled & (lowest >= floor)).astype(np.int8)
        variables["stays_above"] = (pair, above, _about(f"every corner stays above {floor:g} m", "1", **yes))
    coordinates: dict[str, Any] = {
        "cable": ("cable", np.asarray(cables) + 1, _about("cable lost", "1")),
        "survivor": ("survivor", np.arange(1, lost.tensions.shape[-1] + 1), _about("cable", "1")),
        "bound": ("bound", ["least", "greatest"], {"long_name": "end of the sweep"}),
        "axis": ("axis", list(AXES[:d]), {"long_name": "component"}),
    }
    for name, values in zip(AXES, places.T, strict=False):
        coordinates[name] = ("pose", values, _about(f"{name} of the reference point before the loss", "m"))
    coordinates |= {name: ("pose", values, about) for name, (values, about) in more.items()}
    return xr.Dataset(variables, coordinates, {"Conventions": "CF-1.11", **attributes})


def worst_cases(dataset: xr.Dataset) -> list[WorstCase]:
    """The worst of each cable over all poses.

    Args:
        dataset: From `lost_cable_dataset`.

    Returns:
        One for each cable lost.
    """
    return [_worst(dataset.isel(cable=k)) for k in range(dataset.sizes["cable"])]


def write_lost_cable(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset as NetCDF-4, compressed.

    Args:
        dataset: From `lost_cable_dataset`.
        path: Of the file to write.
    """
    encoding = {str(name): {"zlib": True, "complevel": 4} for name in dataset.data_vars}
    dataset.to_netcdf(path, engine="netcdf4", encoding=encoding)


def _worst(one: xr.Dataset) -> WorstCase:
    """The worst of one cable."""
    count, cable = int(one["settled"].sum()), int(one["cable"])
    others = one.sizes["pose"] - count
    stopped = float(one["unsettled_tension"].max())
    unsettled = None if np.isnan(stopped) else stopped
    above = bool(one["stays_above"].all()) if "stays_above" in one else None
    if count == 0:
        return WorstCase(cable, 0, others, None, None, None, None, None, None, above, unsettled)
    drops, tensions, heights = (one[name].to_numpy() for name in ("drop", "greatest_tension", "lowest"))
    deep, taut, low = int(np.nanargmax(drops)), int(np.nanargmax(tensions)), int(np.nanargmin(heights))
    worst = (float(drops[deep]), deep, float(tensions[taut]), taut, float(heights[low]), low)
    return WorstCase(cable, count, others, *worst, above, unsettled)


def _where(settled: NDArray[np.bool_], values: Array) -> Array:
    """Values (k, l, ...) where settled (k, l), else not a number."""
    return np.where(settled.reshape(settled.shape + (1,) * (values.ndim - 2)), values, np.nan)


def _about(name: str, units: str, **more: object) -> dict[str, object]:
    return {"long_name": name, "units": units, **more}
