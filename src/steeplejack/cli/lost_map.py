"""Lost cables over many poses: every cable at every node of a grid, or at every waypoint of a mission."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer
from numpy.typing import NDArray

from steeplejack.cli.terminal import INFEASIBLE, angles, bar, bridge, emit, planar, say, writing
from steeplejack.errors import InputError
from steeplejack.files import read_source
from steeplejack.robots.squad import Bay, load_squad

if TYPE_CHECKING:
    import xarray as xr

    from steeplejack.design.lost_cable import WorstCase
    from steeplejack.mechanics.cable import LockedPlatform
    from steeplejack.planning import Leg

Array = NDArray[np.float64]

LARGEST_MISSION = 1 << 26  # [bytes]
PATIENCE = 2.0  # [s] before a progress bar appears


@dataclass(frozen=True, eq=False)
class Cases:
    """Poses at which cables are lost, and what to say of each."""

    platform: LockedPlatform
    positions: Array  # (k, d) [m]
    rotations: Array  # (k,) [rad] or (k, 3, 3)
    anchors: Array  # (k, m, d) [m]
    tensions: Array | float  # before the loss [N]
    cables: Sequence[int]  # from 0
    corners: Array  # (c, d) [m]
    up: tuple[float, float, float]
    more: dict[str, tuple[Any, dict[str, Any]]]  # coordinates of the dataset
    attributes: dict[str, Any]  # of the dataset
    names: list[dict[str, Any]]  # what the answer calls each pose


def over_grid(worksite: str, phi_deg: str, step_m: float, mass_kg: float, cable: int | None, robot: str) -> Cases:
    """Every node in wrench closure of a grid over a planar worksite; cables do not stretch."""
    from steeplejack.design.lost_cable import closure_nodes
    from steeplejack.mechanics.cable import LockedPlatform
    from steeplejack.robots.squad.planar import planar_attachments

    site, squad = planar(worksite), load_squad(robot)
    attachments = planar_attachments(squad)
    nodes = closure_nodes(site.anchors, attachments, angles(phi_deg), step_m)
    weight = [mass_kg * part for part in site.gravity]
    fixed = np.asarray(site.anchors)
    radian = {"long_name": "orientation of the platform, counter-clockwise", "units": "radian"}
    return Cases(
        platform=LockedPlatform.planar(fixed, attachments, 1.0, weight),
        positions=nodes[:, :2],
        rotations=nodes[:, 2],
        anchors=np.broadcast_to(fixed, (len(nodes), *fixed.shape)),
        tensions=0.0,
        cables=_cables(cable),
        corners=_corners(squad.platform.size, (0.0, 0.0, 0.0))[:4, :2],
        up=(0.0, 1.0, 0.0),
        more={"phi": (nodes[:, 2], radian)},
        attributes={"title": f"Lost cables over {worksite}", "mass": mass_kg, "step": step_m, "anchors": fixed},
        names=[{"x_m": x, "y_m": y, "phi_deg": math.degrees(phi)} for x, y, phi in nodes.tolist()],
    )


def along_mission(worksite: str, path: Path, cable: int | None) -> Cases:
    """Every waypoint of a mission, in space, with the tensions planned there in elastic cables."""
    from steeplejack.mechanics.cable import LockedPlatform
    from steeplejack.planning import decode
    from steeplejack.robots.squad.anchorage import exits
    from steeplejack.spatial.rotation import from_quaternion

    content = read_source(path, "a mission written by `steeplejack inspect`", LARGEST_MISSION)
    mission, site = decode(content, str(path)), bridge(worksite)
    asked = mission.request
    squad = load_squad(asked.robot)
    bay = Bay.of(site.fan(asked.fan), *asked.stays, asked.face, squad)
    points = [point for leg in mission.legs for point in leg.waypoints]
    clock = np.deg2rad([point.base_clock_deg for point in points])
    anchors, _tangents, _arms = exits(bay, squad, np.array([point.base_s_m for point in points]), clock)
    weight = (squad.platform.mass + asked.payload_kg) * np.array(site.gravity)
    return Cases(
        platform=LockedPlatform.spatial(
            anchors[0],
            squad.platform.attachments,
            1.0,
            weight,
            axial_stiffness=squad.cable.axial_stiffness,
            centre=squad.platform.centre_of_mass,
        ),
        positions=np.array([point.position_m for point in points]),
        rotations=np.array([from_quaternion(np.array(point.quaternion)) for point in points]),
        anchors=anchors,
        tensions=np.array([point.tension_n for point in points]),
        cables=_cables(cable),
        corners=_corners(squad.platform.size, squad.platform.centre_of_mass),
        up=(0.0, 0.0, 1.0),
        more=_of_legs(mission.legs),
        attributes={"title": f"Lost cables along a mission on {worksite}", "mission": mission.sha256},
        names=[
            {"x_m": x, "y_m": y, "z_m": z, "leg": number, "kind": leg.kind, "travel": point.travel}
            for number, leg in enumerate(mission.legs, 1)
            for point in leg.waypoints
            for x, y, z in (point.position_m,)
        ],
    )


def answer(cases: Cases, floor: float | None, out: Path | None, json: bool) -> None:
    """Compute, say the worst of every cable, and write the files if asked to."""
    from steeplejack.design.lost_cable import worst_cases

    if not len(cases.positions):
        say("no node of the grid is in wrench closure: nothing to lose a cable from")
        raise typer.Exit(INFEASIBLE)
    began = time.perf_counter()
    dataset = _dataset(cases, floor)
    worst = worst_cases(dataset)
    found: dict[str, Any] = {
        "poses": len(cases.positions),
        "cables": [_worst(one, cases.names) for one in worst],
        "seconds": time.perf_counter() - began,
    }
    if out is not None:
        found |= _write(dataset, out)
    emit(found) if json else _show(found)


def _dataset(cases: Cases, floor: float | None) -> xr.Dataset:
    """Lose every cable at every pose, with a progress bar where that takes longer than a moment."""
    from steeplejack.design.lost_cable import lost_cable_dataset
    from steeplejack.mechanics.cable import lost_cable_map

    with ExitStack() as stack:
        lost = lost_cable_map(
            cases.platform,
            cases.positions,
            cases.rotations,
            anchors=cases.anchors,
            tensions=cases.tensions,
            cables=cases.cables,
            corners=cases.corners,
            progress=_patient(stack, len(cases.positions)),
        )
    attributes = {name: value for name, value in cases.attributes.items() if name != "anchors"}
    if floor is not None:
        attributes["floor"] = floor
    dataset = lost_cable_dataset(lost, cases.positions, cases.cables, cases.up, cases.more, attributes, floor)
    if "anchors" in cases.attributes:
        about = {"long_name": "where a driving cable leaves its anchor base", "units": "m"}
        dataset["anchor"] = (("survivor", "axis"), cases.attributes["anchors"], about)
    return dataset


def _patient(stack: ExitStack, total: int) -> Callable[[int], None]:
    """Progress that shows a bar only once the work has taken longer than a moment."""
    began, shown = time.perf_counter(), list[Callable[[float], None]]()

    def progress(done: int) -> None:
        if not shown and time.perf_counter() - began > PATIENCE:
            shown.append(stack.enter_context(bar("settle", float(total))))
        if shown:
            shown[0](float(done))

    return progress


def _worst(one: WorstCase, names: list[dict[str, Any]]) -> dict[str, Any]:
    """The worst of one cable, by the keys of the contract."""
    return {
        "cable": one.cable,
        "settles": one.settled,
        "max_drop_m": one.drop,
        "at": None if one.at is None else names[one.at],
        "max_tension_n": one.tension,
        "max_tension_at": None if one.tension_at is None else names[one.tension_at],
        "lowest_m": one.lowest,
        "lowest_at": None if one.lowest_at is None else names[one.lowest_at],
        "stays_above": one.stays_above,
        "unsettled": one.unsettled,
        "unsettled_tension_n": one.unsettled_tension,
    }


def _show(found: dict[str, Any]) -> None:
    """A table for a person: the worst of every cable, each extreme with the pose it belongs to."""
    print(f"{'cable lost':<12}{'at worst':<24}from")
    for one in found["cables"]:
        if one["at"] is None:
            print(f"{one['cable']:<12}does not settle anywhere")
            continue
        rows = (
            (f"sinks by {one['max_drop_m']:.3f} m", one["at"]),
            (f"tension {one['max_tension_n']:.4g} N", one["max_tension_at"]),
            (f"lowest {one['lowest_m']:.3f} m", one["lowest_at"]),
        )
        for k, (what, place) in enumerate(rows):
            print(f"{'' if k else one['cable']:<12}{what:<24}{_place(place)}")
        if one["stays_above"] is not None:
            print(f"{'':<12}{'stays above the floor' if one['stays_above'] else 'goes below the floor'}")
    for one in found["cables"]:
        if one["unsettled"]:
            print(_unsettled(one))
    print(f"{found['poses']} poses, {found['seconds']:.1f} s")
    for name in ("dataset", "figure"):
        if name in found:
            print(f"{name:<12}{found[name]}")


def _place(place: dict[str, Any]) -> str:
    """A pose by the names of its coordinates, which end in their units."""
    return ", ".join(
        f"{name} {value:.4g}" if isinstance(value, float) else f"{name} {value}" for name, value in place.items()
    )


def _unsettled(one: dict[str, Any]) -> str:
    """What the table does not cover of a cable."""
    reached = one["unsettled_tension_n"]
    size = "" if reached is None else f"; the search stopped at up to {reached:.3g} N, which is no bound"
    return f"cable {one['cable']}: no rest from {one['unsettled']} poses, which the table leaves out{size}"


def _write(dataset: xr.Dataset, out: Path) -> dict[str, str]:
    """Write the dataset and its figure."""
    from steeplejack.design.charts import save_figure
    from steeplejack.design.charts.lost_cable import lost_cable_figure
    from steeplejack.design.lost_cable import write_lost_cable

    out.mkdir(parents=True, exist_ok=True)
    data, figure = out / "lost-cable.nc", out / "lost-cable.svg"
    try:
        write_lost_cable(dataset, data)
    except RuntimeError as error:  # how the netCDF library tells of a full disk
        raise InputError(str(data), str(error), "a folder on a disk with room") from None
    with writing(figure):
        save_figure(lost_cable_figure(dataset), figure)
    return {"dataset": str(data), "figure": str(figure)}


def _cables(cable: int | None) -> list[int]:
    """Which cables to lose, from 0."""
    return list(range(4)) if cable is None else [cable - 1]


def _corners(size: Sequence[float], centre: Sequence[float]) -> Array:
    """Corners of the platform's body about its centre, (8, 3) [m]; the first four go once around in x and y."""
    signs = np.array([[x, y, z] for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    return 0.5 * np.asarray(size) * signs + np.asarray(centre)


def _of_legs(legs: Sequence[Leg]) -> dict[str, tuple[Any, dict[str, Any]]]:
    """Coordinates that say where in the mission each waypoint is."""
    number = [k for k, leg in enumerate(legs, 1) for _point in leg.waypoints]
    kind = [leg.kind for leg in legs for _point in leg.waypoints]
    travel = [point.travel for leg in legs for point in leg.waypoints]
    return {
        "leg": (number, {"long_name": "leg of the mission", "units": "1"}),
        "kind": (kind, {"long_name": "what the leg is for"}),
        "travel": (travel, {"long_name": "travel along the leg [m], of tensions [N]"}),
    }
