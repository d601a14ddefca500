"""The map command: the tension factor over the anchors' box."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import typer
from numpy.typing import NDArray

from steeplejack.cli.terminal import (
    Json,
    Robot,
    Worksite,
    angles,
    emit,
    mass,
    planar,
    positive,
    show,
    target,
    window,
    writing,
)
from steeplejack.errors import InputError
from steeplejack.files import read_source
from steeplejack.robots.squad import BUILT_IN, load_squad
from steeplejack.worksite import PlanarSite

if TYPE_CHECKING:
    import xarray as xr

    from steeplejack.design import Load, MapSummary

Pair = tuple[float, float]

FOUR = "a text file of four lines X Y in metres"


def _anchors(path: Path) -> list[list[float]]:
    """Four anchors X Y in metres, a line each."""
    try:
        rows = [
            line.replace(",", " ").split() for line in read_source(path, FOUR).decode().splitlines() if line.strip()
        ]
        points = [[float(value) for value in row] for row in rows]
    except ValueError as error:  # of the numbers, or of the encoding
        raise InputError(f"--anchors {path}", str(error), FOUR) from None
    if [len(point) for point in points] != [2, 2, 2, 2] or not np.isfinite(points).all():
        raise InputError(f"--anchors {path}", f"{len(points)} lines", "four lines X Y of finite metres")
    return points


def _load(
    site: PlanarSite, anchors: NDArray[np.float64], mass_kg: float | None, tension_n: Pair | None, slip_n: float | None
) -> Load:
    """What wrench feasibility asks for."""
    from steeplejack.design import Load
    from steeplejack.robots.squad.planar import stay_directions

    if mass_kg is None or tension_n is None:
        raise InputError("--criterion wrench-feasible", "no mass or tension window", "--mass-kg M --tension-n A B")
    stays = stay_directions(anchors, site.stays) if slip_n is not None else None
    limit = np.inf if slip_n is None else positive("--slip-n", slip_n, "N")
    held, tensions = mass("--mass-kg", mass_kg), window("--tension-n", *tension_n)
    return Load(held, tensions, site.gravity, stays, limit)


def _refuse_load(options: dict[str, object]) -> None:
    """Wrench closure is a matter of geometry alone: a load would be ignored."""
    for option, value in options.items():
        if value is not None:
            raise InputError(option, "wrench closure takes no load", "with --criterion wrench-feasible only")


def tension_map(
    worksite: Worksite,
    phi_deg: Annotated[str, typer.Option(help="Orientation P or range A:B:S.")],
    step_m: Annotated[float, typer.Option(help="Distance of nodes.")],
    anchors: Annotated[Path | None, typer.Option(help="Four lines X Y in metres instead of the worksite's.")] = None,
    criterion: Annotated[Literal["wrench-closure", "wrench-feasible"], typer.Option()] = "wrench-closure",
    mass_kg: Annotated[float | None, typer.Option(help="Weight at p, for wrench-feasible.")] = None,
    tension_n: Annotated[Pair | None, typer.Option(help="Tension window, for wrench-feasible.")] = None,
    slip_n: Annotated[float | None, typer.Option(help="Largest pull along the stay.")] = None,
    robot: Robot = BUILT_IN,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for map.nc and map.svg.")] = None,
    json: Json = False,
) -> None:
    """Tension-factor map over the anchors' box (Fig. 8 and 9, Eq. 12-15)."""
    from steeplejack.design import summarise
    from steeplejack.design import tension_map as compute
    from steeplejack.robots.squad.planar import planar_attachments

    site, squad = planar(worksite), load_squad(robot)
    points = site.anchors if anchors is None else np.array(_anchors(anchors))
    load = None
    if criterion == "wrench-feasible":
        load = _load(site, points, mass_kg, tension_n, slip_n)
    else:
        _refuse_load({"--mass-kg": mass_kg, "--tension-n": tension_n, "--slip-n": slip_n})
    if out is not None:
        target(out)
    began = time.perf_counter()
    dataset = compute(points, planar_attachments(squad), angles(phi_deg), step_m, load)
    summary = summarise(dataset)
    seconds = time.perf_counter() - began
    answer = _map_answer(summary, ":" in phi_deg, load is not None) | {"seconds": seconds}
    if out is not None:
        answer |= _write_map(dataset, site, out)
    emit(answer) if json else show(answer)


def _map_answer(summary: MapSummary, several: bool, loaded: bool) -> dict[str, Any]:
    """The numbers of a map, with the best orientation where there are several."""
    best = summary.best_pose
    answer: dict[str, Any] = {
        "nodes": summary.nodes,
        "inside": summary.inside,
        "area_m2": summary.area,
        "max": {
            "tension_factor": summary.max_tension_factor,
            "x_m": None if best is None else best[0],
            "y_m": None if best is None else best[1],
        },
        "mean_tension_factor": summary.mean_tension_factor,
    }
    if best is not None and several:
        answer["max"]["phi_deg"] = math.degrees(best[2])
    if loaded:
        answer["inside_wrench_closure"] = summary.inside_wrench_closure
    return answer


def _write_map(dataset: xr.Dataset, site: PlanarSite, out: Path) -> dict[str, str]:
    """Write the map as a dataset and as a figure."""
    from steeplejack.design import write_map
    from steeplejack.design.charts import map_figure, save_figure

    out.mkdir(parents=True, exist_ok=True)
    data, figure = out / "map.nc", out / "map.svg"
    try:
        write_map(dataset, data)
    except RuntimeError as error:  # how the netCDF library tells of a full disk
        raise InputError(str(data), str(error), "a folder on a disk with room") from None
    with writing(figure):
        save_figure(map_figure(dataset, site.stays), figure)
    return {"map": str(data), "figure": str(figure)}
