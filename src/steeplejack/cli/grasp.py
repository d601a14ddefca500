"""The grasp command: where to hold a stay."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import typer

from steeplejack.cli.terminal import Json, Robot, Worksite, emit, planar, show, target, writing
from steeplejack.errors import InputError
from steeplejack.robots.squad import BUILT_IN, load_squad
from steeplejack.worksite import PlanarSite

if TYPE_CHECKING:
    from steeplejack.design.grasps import Grasp, GraspFront, GraspQuestion

FRONT = 61  # points of the front written with --out


def grasp(
    worksite: Worksite,
    stay: Annotated[str, typer.Option(help="Id of the stay to hold.")],
    x_m: Annotated[float, typer.Option(help="X0: the region lies about the point of the stay's axis there.")],
    half_width_m: Annotated[float, typer.Option(help="D: vertical offset of its sides along the stay.")],
    half_length_m: Annotated[float, typer.Option(help="E: vertical offset of its sides across the stay.")],
    phi_deg: Annotated[float, typer.Option(help="Orientation of the platform.")],
    method: Annotated[Literal["exact", "algorithm-1"], typer.Option()] = "exact",
    step_m: Annotated[float | None, typer.Option(help="Distance of nodes, for algorithm-1.")] = None,
    kappa: Annotated[float | None, typer.Option(help="Step of the threshold, for algorithm-1.")] = None,
    robot: Robot = BUILT_IN,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for grasp.svg and front.csv.")] = None,
    json: Json = False,
) -> None:
    """Where to grasp a stay (Algorithm 1, or the exact largest tension factor in its region, Eq. 19)."""
    from steeplejack.design.grasps import GraspQuestion, GraspRegion, best_grasp, grasp_on_grid
    from steeplejack.robots.squad.planar import planar_attachments

    site, squad = planar(worksite), load_squad(robot)
    slope, intercept = _line(site, stay)
    for option, value in (("--x-m", x_m), ("--phi-deg", phi_deg)):
        if not math.isfinite(value):
            raise InputError(option, f"{value:g}", "a finite number")
    for option, value in (("--half-width-m", half_width_m), ("--half-length-m", half_length_m)):
        if not 0.0 <= value < math.inf:
            raise InputError(option, f"{value:g} m", "finite, 0 m or more")
    grid = _grid(method, step_m, kappa)
    if out is not None:
        target(out)
    region = GraspRegion.eq19((x_m, slope * x_m + intercept), (1.0, slope), half_width_m, half_length_m)
    question = GraspQuestion(site.anchors, planar_attachments(squad), math.radians(phi_deg), region)
    found = best_grasp(question) if grid is None else grasp_on_grid(question, *grid)
    answer: dict[str, Any] = {
        "x_m": float(found.position[0]),
        "y_m": float(found.position[1]),
        "tension_factor": found.tension_factor,
        "distance_m": found.distance,
        "evaluations": found.evaluations,
    }
    if found.gap is not None:
        answer["certified_gap"] = found.gap
    if out is not None:
        answer |= _write(question, found, site, out)
    emit(answer) if json else show(answer)


def _line(site: PlanarSite, stay: str) -> tuple[float, float]:
    """Slope and intercept of a stay by its id."""
    if stay not in site.stays:
        raise InputError("--stay", f"no stay {stay} on {site.name}", f"one of {', '.join(site.stays)}")
    return site.stays[stay]


def _grid(method: str, step_m: float | None, kappa: float | None) -> tuple[float, float] | None:
    """Step and kappa of Algorithm 1; None for the exact optimum, which takes neither."""
    options = {"--step-m": step_m, "--kappa": kappa}
    if method == "exact":
        for option, value in options.items():
            if value is not None:
                raise InputError(option, "the exact optimum has no grid", "with --method algorithm-1 only")
        return None
    if step_m is None or kappa is None:
        missing = " and ".join(option for option, value in options.items() if value is None)
        raise InputError("--method algorithm-1", f"no {missing}", "--step-m H --kappa K")
    for option, value, unit in (("--step-m", step_m, " m"), ("--kappa", kappa, "")):
        if not 0.0 < value < math.inf:
            raise InputError(option, f"{value:g}{unit}", f"finite, above 0{unit}")
    return step_m, kappa


def _write(question: GraspQuestion, found: Grasp, site: PlanarSite, out: Path) -> dict[str, str]:
    """Write the figure and the front."""
    from steeplejack.design.charts import grasp_figure, save_figure
    from steeplejack.design.grasps import grasp_front

    front = grasp_front(question, np.linspace(0.0, question.region.half_width, FRONT))
    out.mkdir(parents=True, exist_ok=True)
    figure, table = out / "grasp.svg", out / "front.csv"
    with writing(table):
        _write_front(front, table)
    with writing(figure):
        save_figure(grasp_figure(question, found, front, site.stays), figure)
    return {"figure": str(figure), "front": str(table)}


def _write_front(front: GraspFront, path: Path) -> None:
    """The front, a row a distance; positions are empty where nothing is in wrench closure."""
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("distance_m", "tension_factor", "x_m", "y_m", "certified_gap"))
        columns = (front.distances, front.tension_factor, front.positions, front.gap)
        for distance, factor, (x, y), gap in zip(*columns, strict=True):
            place = (float(x), float(y)) if factor > 0.0 else ("", "")
            rows.writerow((float(distance), float(factor), *place, float(gap)))
