"""Commands that design the pipe climber: reach, transmission, dimensions."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

import typer

from steeplejack.cli.climber_options import ClimberConvention, ClimberDims, ClimberRobot, JointNeutral, climber
from steeplejack.cli.terminal import Ended, Json, bar, emit, show, target, writing
from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.parameters import BUILT_IN

if TYPE_CHECKING:
    from steeplejack.design.climber import Chart, Comparison, Rectangle, TransmissionMap

Sides = tuple[float, float, float, float]

Alpha = Annotated[float, typer.Option(help="Orientation of the platform.")]
Prescribed = Annotated[
    Sides | None, typer.Option("--rectangle", help="X0 X1 W0 W1 in metres instead of what the limits allow.")
]
MovingBody = Annotated[
    Literal["platform", "base"],
    typer.Option(help="Whose joints are the characteristic points; the index depends on it."),
]


def reach(
    alpha_deg: Alpha,
    step_m: Annotated[float, typer.Option(help="Side of the grid's cells.")],
    joint_neutral: JointNeutral = None,
    robot: ClimberRobot = BUILT_IN,
    convention: ClimberConvention = None,
    dims: ClimberDims = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for reach.svg.")] = None,
    json: Json = False,
) -> None:
    """Workspace: area at one orientation (Fig. 6), volume over every orientation (Fig. 5), in the working mode."""
    from steeplejack.design.climber import orientations, require_poses, workspace_cells

    _, layout = climber(robot, convention, dims, joint_neutral)
    alpha = _alpha(alpha_deg)
    _step(step_m)
    if out is not None:
        target(out)
    exact = require_poses(layout, alpha)
    places = orientations(layout, step_m)
    answer: dict[str, Any] = {
        "area_m2": int(workspace_cells(layout, alpha, step_m)[0]) * step_m * step_m,
        "volume_m2_rad": places.volume,
        "exact_area_m2": exact,
        "reachable_area_m2": places.reachable_area,
    }
    if out is not None:
        from steeplejack.design.charts.climber import reach_figure

        answer["figure"] = _write(reach_figure(layout, alpha, places), out / "reach.svg")
    emit(answer) if json else show(answer)


def transmission(
    alpha_deg: Alpha,
    step_m: Annotated[float, typer.Option(help="Side of the cells.")],
    joint_neutral: JointNeutral = None,
    rectangle: Prescribed = None,
    moving: MovingBody = "platform",
    robot: ClimberRobot = BUILT_IN,
    convention: ClimberConvention = None,
    dims: ClimberDims = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for transmission.svg.")] = None,
    json: Json = False,
) -> None:
    """Transmission index over the workspace (Fig. 12), or over a rectangle whether or not limits allow it."""
    from steeplejack.design.climber import transmission_map

    _, layout = climber(robot, convention, dims, joint_neutral)
    alpha, region = _alpha(alpha_deg), None if rectangle is None else _rectangle(rectangle)
    _step(step_m)
    if out is not None:
        target(out)
    found = transmission_map(layout, step_m, alpha, region, moving)
    answer: dict[str, Any] = {
        "gti": found.gti,
        "mean": found.mean,
        **{name: dict(zip(("lti", "x_m", "w_m"), place, strict=True)) for name, place in _ends(found).items()},
        "cells": found.cells,
        "within_limits": found.within_limits,
    }
    if out is not None:
        from steeplejack.design.charts.climber import transmission_figure

        name = f"α = {alpha_deg:g}°, {moving} moving"
        answer["figure"] = _write(transmission_figure({name: found}), out / "transmission.svg")
    places = {name: f"{lti:.6g} at x {x:.6g} m, w {w:.6g} m" for name, (lti, x, w) in _ends(found).items()}
    emit(answer) if json else show(answer | places)


def dimensions(
    rectangle: Annotated[Sides, typer.Option(help="X0 X1 W0 W1 in metres: the prescribed workspace, at alpha = 0.")],
    scale: Annotated[
        Literal["l1", "sum"], typer.Option(help="L1 = 100 mm, or L1 + L2 + L3 + L4 = 350 mm, for all designs.")
    ] = "l1",
    step: Annotated[float, typer.Option(help="Of the ratios L3/L1 and L4/L1.")] = 0.01,
    step_m: Annotated[float, typer.Option(help="Side of the cells.")] = 0.001,
    moving: MovingBody = "platform",
    study: Annotated[
        Path | None, typer.Option(help="Search L2/L1 too; finished chunks are kept in this folder and not redone.")
    ] = None,
    workers: Annotated[int, typer.Option(help="With --study: processes of a dask cluster; 0 for none.")] = 0,
    robot: ClimberRobot = BUILT_IN,
    convention: ClimberConvention = None,
    dims: ClimberDims = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder for dimensions.svg, and with --study space.svg.")
    ] = None,
    json: Json = False,
) -> None:
    """Performance chart (Fig. 13-15): the best dimensions, beside the paper's optimum and the original."""
    from steeplejack.design.climber import ORIGINAL, PAPER, Comparison, design_plane, performance_chart, rating

    _, layout = climber(robot, convention, dims)
    asked = Comparison(
        rectangle=_rectangle(rectangle), step=_step(step_m), scale=scale, convention=layout.convention, moving=moving
    )
    designs = design_plane(_ratio(step))
    for option, folder in (("--out", out), ("--study", study)):
        if folder is not None:
            target(folder, option)
    if workers and study is None:
        raise InputError("--workers", f"{workers}", "with --study only")
    if workers < 0:
        raise InputError("--workers", f"{workers}", "0 or more")
    began = time.perf_counter()
    chart = performance_chart(designs, asked) if study is None else _study(asked, step, study, workers)
    seconds = time.perf_counter() - began
    ratio, gti = chart.best()
    answer: dict[str, Any] = {
        "best": {"ratio": ratio, "gti": gti},
        "paper": {"ratio": PAPER, "gti": rating(PAPER, asked), "better": chart.share_above(rating(PAPER, asked))},
        "original": {"ratio": ORIGINAL, "gti": rating(ORIGINAL, asked)},
        "designs": len(chart.ratios),
        "seconds": seconds,
    }
    if dims is not None:
        given = tuple(length / dims[0] for length in dims)
        answer["given"] = {"ratio": given, "gti": rating((given[0], given[1], given[2], given[3]), asked)}
    if out is not None:
        from steeplejack.design.charts.climber import chart_figure

        plane = chart if study is None else performance_chart(designs, asked)
        answer["figure"] = _write(chart_figure(plane), out / "dimensions.svg")
        if study is not None:
            from steeplejack.design.charts.climber_space import space_figure

            answer["space_figure"] = _write(space_figure(chart), out / "space.svg")
    emit(answer) if json else show({name: _in_words(value) for name, value in answer.items()})


def _ends(found: TransmissionMap) -> dict[str, tuple[float, float, float]]:
    """Least and largest value of a map and their places."""
    return {"min": found.least, "max": found.largest}


def _in_words(value: Any) -> Any:
    """A design of the answer for a person; anything else as it is."""
    if not isinstance(value, dict):
        return value
    design = cast("dict[str, Any]", value)
    ratio = " : ".join(f"{length:.4g}" for length in design["ratio"])
    better = f", {design['better']:.0%} of the designs are better" if "better" in design else ""
    return f"{ratio}, GTI {design['gti']:.4f}{better}"


def _study(asked: Comparison, step: float, folder: Path, workers: int) -> Chart:
    """The chart of the whole design space, with a progress bar, on a cluster if there are workers."""
    from steeplejack.design.climber import LostClusterError, Study, claim_study, local_cluster, run_study

    study = Study(asked, step)
    chunks = float(study.chunks)
    claim_study(study, folder)  # before the bar, so that a refusal is all there is on stderr
    try:
        with ExitStack() as stack:
            client = stack.enter_context(local_cluster(workers)) if workers else None
            advance: Callable[[float], None] = stack.enter_context(bar("designs", chunks))
            return run_study(study, folder, client, lambda done, _all: advance(float(done)))
    except LostClusterError as error:
        raise Ended(str(error)) from None


def _write(figure: Any, path: Path) -> str:
    """Write a figure of `design.charts`, whose type only that room may import."""
    from steeplejack.design.charts import save_figure

    path.parent.mkdir(parents=True, exist_ok=True)
    with writing(path):
        save_figure(figure, path)
    return str(path)


def _alpha(degrees: float) -> float:
    if not -180.0 <= degrees <= 180.0:
        raise InputError("--alpha-deg", f"{degrees:g} deg", "-180 to 180 deg")
    return math.radians(degrees)


def _step(metres: float) -> float:
    if not 0.0 < metres < math.inf:
        raise InputError("--step-m", f"{metres:g} m", "above 0 m")
    return metres


def _ratio(step: float) -> float:
    if not math.isfinite(step):
        raise InputError("--step", f"{step:g}", "a ratio such as 0.01")
    return step


def _rectangle(sides: Sides) -> Rectangle:
    from steeplejack.design.climber import Rectangle

    return Rectangle(*sides)
