"""Tension-factor map over positions at one orientation or several (Fig. 8-9, Eq. 12-15), as a labelled dataset.

Nodes are the integer multiples of the step, from the worksite's origin, inside the bounding box of the anchors. A node
is *inside* where it is in wrench closure, or, when a `Load` is given, where bounded tensions hold that load. Source:
Zheng et al., CCRobot-S, IEEE T-RO, Eq. 11-15.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.region.grid import grid_nodes, margin_grid, tension_factor_grid

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MOST_NODES = 50_000_000  # [1] 0.4 GB a variable

SOURCE = "Zheng et al., CCRobot-S, IEEE Transactions on Robotics, Eq. 2-15"


@dataclass(frozen=True, eq=False)
class Load:
    """What wrench feasibility asks for: a mass held at rest by bounded tensions.

    Attributes:
        mass: Of the platform with its load, at p [kg].
        window: Least and greatest tension [N].
        gravity: Of the worksite, (2,) [m/s2].
        stays: Unit directions of the stays the anchors sit on, (4, 2) [1]; needed with a pull limit.
        pull_limit: Greatest component of a tension along its stay [N]; infinite for none.
    """

    mass: float
    window: tuple[float, float]
    gravity: tuple[float, float]
    stays: Array | None = None
    pull_limit: float = np.inf

    def __post_init__(self) -> None:
        """Refuse a load that means nothing."""
        if not (np.isfinite(self.mass) and self.mass >= 0.0):
            raise InputError("mass", f"{self.mass:g} kg", "finite and not negative")
        if not 0.0 <= self.window[0] < self.window[1] < np.inf:
            raise InputError("tension window", f"{self.window[0]:g} to {self.window[1]:g} N", "0 <= least < greatest")
        if not self.pull_limit > 0.0:
            raise InputError("pull limit", f"{self.pull_limit:g} N", "positive")
        if self.stays is None and np.isfinite(self.pull_limit):
            raise InputError("pull limit", "no stay directions", "the direction of the stay under each anchor")


@dataclass(frozen=True)
class MapSummary:
    """The numbers of a map.

    Attributes:
        nodes: Grid nodes over all orientations.
        inside: Nodes inside.
        inside_wrench_closure: Those of them in wrench closure.
        area: Positions inside at one orientation at least, counted as step squared each [m2].
        max_tension_factor: Largest TF inside (Eq. 13), 0 where nothing is inside [1].
        best_pose: ``(x, y, phi)`` of it [m, m, rad]; None where nothing is inside.
        mean_tension_factor: Mean TF inside, pooled over orientations (Eq. 15); None where nothing is inside [1].
    """

    nodes: int
    inside: int
    inside_wrench_closure: int
    area: float
    max_tension_factor: float
    best_pose: tuple[float, float, float] | None
    mean_tension_factor: float | None


def tension_map(
    anchors: ArrayLike, attachments: ArrayLike, phis: ArrayLike, step: float, load: Load | None = None
) -> xr.Dataset:
    """Map the tension factor, and with a load the margin, over the anchors' box.

    Args:
        anchors: (4, 2) [m].
        attachments: In the platform frame, (4, 2) [m].
        phis: One orientation or several, () or (k,) [rad].
        step: Distance of nodes [m].
        load: Makes wrench feasibility the criterion; wrench closure if None.

    Returns:
        ``tension_factor`` and ``inside``, and with a load ``margin``, over (phi, y, x), with units and CF attributes;
        anchors and attachments beside them.

    Raises:
        InputError: A step that is not positive, too fine for memory or coarser than the box; orientations not finite.
    """
    fixed, local = np.asarray(anchors, dtype=np.float64), np.asarray(attachments, dtype=np.float64)
    angles = np.atleast_1d(np.asarray(phis, dtype=np.float64))
    xs, ys = _axes(fixed, angles, step)
    factors = np.empty((angles.size, ys.size, xs.size))
    for phi, layer in zip(angles, factors, strict=True):
        tension_factor_grid(fixed, local, phi, xs, ys, out=layer)
    if load is None:
        return _dataset(fixed, local, angles, xs, ys, step, factors, factors > 0.0, None)
    wrench = [load.mass * load.gravity[0], load.mass * load.gravity[1], 0.0]
    margins = np.stack(
        [margin_grid(fixed, local, phi, xs, ys, wrench, *load.window, load.stays, load.pull_limit) for phi in angles]
    )
    return _dataset(fixed, local, angles, xs, ys, step, factors, margins >= 0.0, margins)


def summarise(dataset: xr.Dataset) -> MapSummary:
    """Count, measure and average a map.

    Args:
        dataset: From `tension_map`.

    Returns:
        Its numbers; maximum and mean are over the nodes inside.
    """
    factors = dataset["tension_factor"].to_numpy()
    inside = dataset["inside"].to_numpy() > 0
    count = int(np.count_nonzero(inside))
    masked = np.where(inside, factors, -1.0)
    k, j, i = np.unravel_index(int(np.argmax(masked)), masked.shape)
    x, y, phi = (dataset[name].to_numpy() for name in ("x", "y", "phi"))
    return MapSummary(
        nodes=inside.size,
        inside=count,
        inside_wrench_closure=int(np.count_nonzero(inside & (factors > 0.0))),
        area=float(np.count_nonzero(inside.any(axis=0)) * dataset.attrs["step"] ** 2),
        max_tension_factor=float(masked[k, j, i]) if count else 0.0,
        best_pose=(float(x[i]), float(y[j]), float(phi[k])) if count else None,
        mean_tension_factor=float(factors[inside].sum() / count) if count else None,
    )


def write_map(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a map as NetCDF-4, compressed.

    Args:
        dataset: From `tension_map`.
        path: Of the file to write.
    """
    grids = [str(name) for name, values in dataset.data_vars.items() if values.dims == ("phi", "y", "x")]
    dataset.to_netcdf(path, engine="netcdf4", encoding={name: {"zlib": True, "complevel": 4} for name in grids})


def _axes(anchors: Array, angles: Array, step: float) -> tuple[Array, Array]:
    """Nodes along x and y inside the anchors' box."""
    if not (np.isfinite(step) and step > 0.0):
        raise InputError("step", f"{step:g} m", "positive and finite")
    if not (angles.size and np.isfinite(angles).all()):
        raise InputError("phi", f"{angles.tolist()}", "at least one finite angle")
    (left, bottom), (right, top) = anchors.min(axis=0), anchors.max(axis=0)
    count = angles.size * ((right - left) / step + 1.0) * ((top - bottom) / step + 1.0)
    if count > MOST_NODES:
        raise InputError("step", f"{step:g} m makes {count:.3g} nodes", f"at most {MOST_NODES:.0e} nodes")
    xs, ys = grid_nodes(left, right, step), grid_nodes(bottom, top, step)
    if not (xs.size and ys.size):
        box = f"{right - left:g} by {top - bottom:g} m"
        raise InputError("step", f"{step:g} m", f"finer, so that nodes fall in the anchors' box of {box}")
    return xs, ys


def _dataset(
    anchors: Array,
    attachments: Array,
    phis: Array,
    xs: Array,
    ys: Array,
    step: float,
    factors: Array,
    inside: NDArray[np.bool_],
    margins: Array | None,
) -> xr.Dataset:
    """Label the arrays."""
    import xarray as xr  # heavy, and only maps need it

    grid, points = ("phi", "y", "x"), ("cable", "axis")
    criterion = "wrench closure" if margins is None else "wrench feasibility"
    flags = {"flag_values": [0, 1], "flag_meanings": "outside inside"}
    variables = {
        "tension_factor": (grid, factors, _about("tension factor, 0 outside wrench closure", "1")),
        "inside": (grid, inside.astype(np.int8), _about(f"node satisfies {criterion}", "1", **flags)),
        "anchor": (points, anchors, _about("where a driving cable leaves its anchor base", "m")),
        "attachment": (points, attachments, _about("where a driving cable meets the platform, platform frame", "m")),
    }
    if margins is not None:
        variables["margin"] = (grid, margins, _about("depth inside the tension box over half the widest window", "1"))
    coordinates = {
        "phi": ("phi", phis, _about("orientation of the platform, counter-clockwise", "radian")),
        "y": ("y", ys, _about("height above the worksite's origin", "m", axis="Y")),
        "x": ("x", xs, _about("distance along the bridge from the worksite's origin", "m", axis="X")),
        "cable": ("cable", np.arange(1, 5), _about("driving cable", "1")),
        "axis": ("axis", ["x", "y"], {"long_name": "component"}),
    }
    attributes = {
        "Conventions": "CF-1.11",
        "title": "Tension factor of a planar four-cable robot",
        "references": SOURCE,
        "criterion": criterion,
        "step": step,
    }
    return xr.Dataset(variables, coordinates, attributes)


def _about(name: str, units: str, **more: object) -> dict[str, object]:
    return {"long_name": name, "units": units, **more}
