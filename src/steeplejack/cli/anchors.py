"""The anchors command: where the bases should stand along their stays, for the poses of a path."""

from __future__ import annotations

import csv
import io
import math
import time
from collections.abc import Generator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import typer
from numpy.typing import NDArray

from steeplejack.cli.terminal import (
    INFEASIBLE,
    Json,
    Robot,
    Worksite,
    bar,
    emit,
    mass,
    planar,
    say,
    show,
    target,
    writing,
)
from steeplejack.cli.terminal import window as tension_window
from steeplejack.errors import InputError
from steeplejack.robots.squad import BUILT_IN, load_squad

if TYPE_CHECKING:
    from steeplejack.design.anchors import AnchorPath, Duty, Reconfiguration
    from steeplejack.robots.squad import Squad
    from steeplejack.worksite import PlanarSite

Array = NDArray[np.float64]
Pair = tuple[float, float]

BOUNDLESS = 1e12  # [N] a pull no cable of this squad reaches


def anchors(
    worksite: Worksite,
    path: Annotated[str, typer.Option(help="eq28, or a CSV file with columns x_m, y_m, phi_deg.")],
    move: Annotated[str, typer.Option(help="Anchors that may move, as 1,2,4.")],
    window_m: Annotated[float, typer.Option(help="+- along x about each anchor's present place.")],
    method: Annotated[Literal["exact", "algorithm-2"], typer.Option()] = "exact",
    step_m: Annotated[float | None, typer.Option(help="Grid of algorithm-2.")] = None,
    travel_price: Annotated[
        float | None, typer.Option(help="Mean objective a metre of driving must be worth; without it pose by pose.")
    ] = None,
    objective: Annotated[Literal["tension-factor", "slip-margin"], typer.Option()] = "tension-factor",
    mass_kg: Annotated[float | None, typer.Option(help="Held at rest, at p; needed by slip-margin.")] = None,
    tension_n: Annotated[Pair | None, typer.Option(help="Tension window; needed by slip-margin.")] = None,
    robot: Robot = BUILT_IN,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for anchors.csv and anchors.svg.")] = None,
    json: Json = False,
) -> None:
    """Best places of the anchor bases along a path (Algorithm 2 and its exact optimum, Eq. 21-28)."""
    from steeplejack.design.anchors.along import first_grid

    site, squad = planar(worksite), load_squad(robot)
    problem = _problem(site, squad, path, _movable(move), window_m)
    duty = _duty(site, squad, objective, mass_kg, tension_n)
    step = _step(method, step_m)
    if travel_price is not None and not 0.0 <= travel_price < math.inf:
        raise InputError("--travel-price", f"{travel_price:g}", "a finite price per metre, 0 or more")
    if out is not None:
        target(out)
    began = time.perf_counter()
    with _options_named():
        if step is not None:
            first_grid(problem, step, ends=False)  # says at once that a grid is too fine
        with bar("searching", None) if travel_price is not None or duty.mass is not None else nullcontext():
            found, bound = _solve(problem, duty, step, travel_price)
    answer = _answer(problem, found, bound, duty) | {"seconds": time.perf_counter() - began}
    if not found.held.any():
        answer["binding"] = _binding(problem, duty)
    if out is not None:
        answer |= _write(problem, found, duty, out)
    emit(answer) if json else show(_summary(answer))
    if not found.held.any():
        say(f"no pose of the path is held by any places inside the windows: {answer['binding']}")
        raise typer.Exit(INFEASIBLE)


@contextmanager
def _options_named() -> Generator[None]:
    """Names the option in an error about what it says."""
    named = {"step": "--step-m", "window": "--window-m", "travel price": "--travel-price"}
    try:
        yield
    except InputError as error:
        option = next((name for text, name in named.items() if error.where.startswith(text)), None)
        if option is None:
            raise
        about = error.where.partition(" of ")[2]
        raise InputError(option, f"{about}, {error.what}" if about else error.what, error.valid) from error


def _movable(text: str) -> list[int]:
    """Anchors by index from a list as 1,2,4."""
    try:
        numbers = [int(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if not numbers or len(set(numbers)) != len(numbers) or not set(numbers) <= {1, 2, 3, 4}:
        raise InputError("--move", text, "different anchors out of 1 to 4, as 1,2,4")
    return [number - 1 for number in numbers]


def _problem(site: PlanarSite, squad: Squad, path: str, movable: list[int], window_m: float) -> Reconfiguration:
    """The anchors on their stays, and the poses."""
    from steeplejack.design.anchors import Reconfiguration, eq28, read_path
    from steeplejack.robots.squad.planar import planar_attachments, stay_directions

    if not 0.0 <= window_m < math.inf:
        raise InputError("--window-m", f"{window_m:g} m", "a finite distance, 0 or more")
    along = stay_directions(site.anchors, site.stays)
    if np.any(np.abs(along[movable, 0]) < 1e-9):
        raise InputError("--window-m", "a vertical stay", "stays along which x changes, since the window is along x")
    windows = np.zeros((4, 2))
    windows[movable] = [-window_m, window_m]
    poses = eq28() if path == "eq28" else read_path(path)
    directions = along / np.where(np.abs(along[:, :1]) < 1e-9, 1.0, along[:, :1])
    return Reconfiguration(site.anchors, directions, planar_attachments(squad), windows, poses)


def _duty(
    site: PlanarSite,
    squad: Squad,
    objective: Literal["tension-factor", "slip-margin"],
    mass_kg: float | None,
    tension_n: Pair | None,
) -> Duty:
    """What the platform bears on the way: wrench closure alone, or a load within tension and pull limits."""
    from steeplejack.design.anchors import Duty

    if (mass_kg is None) != (tension_n is None):
        raise InputError("--mass-kg and --tension-n", "one without the other", "both or neither")
    if mass_kg is None or tension_n is None:
        if objective == "slip-margin":
            raise InputError("--objective slip-margin", "no load", "--mass-kg M and --tension-n A B")
        return Duty()
    base = squad.base
    held = mass("--mass-kg", mass_kg)
    limits = tension_window("--tension-n", *tension_n)
    return Duty(objective, held, limits, site.gravity, base.hold_force, base.drive_force)


def _step(method: str, step_m: float | None) -> float | None:
    """The grid of algorithm-2; the exact method chooses its own."""
    if method == "exact":
        if step_m is not None:
            raise InputError("--step-m", "the exact method has no grid", "with --method algorithm-2 only")
        return None
    if step_m is None or not 0.0 < step_m < math.inf:
        raise InputError(
            "--step-m", "none" if step_m is None else f"{step_m:g} m", "the grid of algorithm-2, above 0 m"
        )
    return step_m


def _solve(
    problem: Reconfiguration, duty: Duty, step: float | None, price: float | None
) -> tuple[AnchorPath, float | None]:
    """Configurations, and the certified bound of the mean objective where there is one.

    Pose by pose without a load the optimum is certified; the tension factor that is possible anywhere also bounds what
    is possible under a load or with a price.
    """
    from steeplejack.design.anchors import algorithm_2, anchor_path, anchors_along, optimal_anchors

    bound = None
    if duty.objective == "tension-factor":
        best = optimal_anchors(problem)
        bound = float(np.mean(best.upper))
        if price is None and duty.mass is None:
            offsets = best.offsets if step is None else np.nan_to_num(algorithm_2(problem, step).offsets)
            return anchor_path(problem, offsets, duty), bound
    return anchors_along(problem, duty, price or 0.0, step, continuous=step is None), bound


def _answer(problem: Reconfiguration, found: AnchorPath, bound: float | None, duty: Duty) -> dict[str, Any]:
    """The contract's numbers."""
    fixed = _factors(problem, np.zeros_like(found.offsets), duty)
    factor = _factors(problem, found.offsets, duty)
    rows = zip(found.held, factor, found.offsets, strict=True)
    factors, configurations = zip(*((float(tf), v.tolist()) if ok else (None, None) for ok, tf, v in rows), strict=True)
    answer: dict[str, Any] = {
        "mean_tension_factor": float(np.mean(factor)),
        "feasible": int(np.count_nonzero(found.held)),
        "poses": len(found.held),
        "travel_m": found.travel,
        "fixed_mean_tension_factor": float(np.mean(fixed)),
        "tension_factor": list(factors),
        "configurations": list(configurations),
        "certified_gap": None if bound is None else bound - found.net,
        "drives_not_held": sum(order is None for order in found.orders),
    }
    if duty.objective == "slip-margin":
        margins = zip(found.held, found.value, strict=True)
        answer["mean_slip_margin"] = found.mean
        answer["slip_margin"] = [float(value) if ok else None for ok, value in margins]
    return answer


def _summary(answer: dict[str, Any]) -> dict[str, Any]:
    """What a person reads; the lists per pose are for --json and --out."""
    return {name: value for name, value in answer.items() if not isinstance(value, list)}


def _factors(problem: Reconfiguration, offsets: Array, duty: Duty) -> Array:
    """Tension factor of a configuration a pose, 0 where the duty is not met."""
    from steeplejack.design.anchors import anchor_path, tension_factors

    return np.where(anchor_path(problem, offsets, duty).held, tension_factors(problem, offsets), 0.0)


def _binding(problem: Reconfiguration, duty: Duty) -> str:
    """Why no pose is held, for the first of them: the cable that would have to push, or the limit under the load."""
    from steeplejack.design.anchors import binding_limits
    from steeplejack.design.anchors.along import first_grid, first_step
    from steeplejack.design.anchors.worth import GRIPPED, worth

    first = replace(problem, poses=problem.poses[:1])
    if duty.mass is None:
        return f"no wrench closure at {binding_limits(first)[0].text}"
    grid = first_grid(first, first_step(problem.windows))
    least, largest = duty.window
    without = {
        f"least tension of {least:g} N": replace(duty, window=(0.0, largest)),
        f"largest tension of {largest:g} N": replace(duty, window=(least, np.inf)),
        f"pull of {duty.hold:g} N along the stays": replace(duty, hold=BOUNDLESS, drive=BOUNDLESS),
    }
    binding = [name for name, freer in without.items() if np.any(worth(first, grid, freer)[1] & GRIPPED)]
    if not binding:
        return f"at pose 1 several of {', '.join(without)} together"
    return f"at pose 1 the {' or the '.join(binding)}"


def _write(problem: Reconfiguration, found: AnchorPath, duty: Duty, out: Path) -> dict[str, str]:
    """Write the configurations as a table and as a figure."""
    from steeplejack.design.charts import save_figure
    from steeplejack.design.charts.travel import path_figure

    out.mkdir(parents=True, exist_ok=True)
    table, figure = out / "anchors.csv", out / "anchors.svg"
    lines = io.StringIO()
    rows = csv.writer(lines, lineterminator="\n")
    axes = [f"a{i}_{axis}_m" for i in range(1, 5) for axis in "xy"]
    rows.writerow(["pose", "x_m", "y_m", "phi_deg", "held", "value", *axes, "drives_before"])
    for k, pose in enumerate(problem.poses):
        order = found.orders[k - 1] if k else ()
        drives = "none holds" if order is None else " ".join(str(base + 1) for base in order)
        places = problem.placed(found.offsets[k]).ravel()
        numbers = [pose[0], pose[1], math.degrees(pose[2])]
        cells = [f"{value:.9g}" for value in (*numbers, found.value[k], *places)]
        rows.writerow([k + 1, *cells[:3], int(found.held[k]), *cells[3:], drives])
    with writing(table):
        table.write_text(lines.getvalue())
    with writing(figure):
        save_figure(path_figure(problem, found, duty.objective), figure)
    return {"table": str(table), "figure": str(figure)}
