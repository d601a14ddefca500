"""Commands in the plane of the cables: map, pose, tensions, grip."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import typer

from steeplejack.cli.terminal import (
    INFEASIBLE,
    Json,
    Robot,
    Worksite,
    emit,
    mass,
    planar,
    positive,
    say,
    target,
    window,
)
from steeplejack.errors import InputError
from steeplejack.robots.squad import BUILT_IN, load_squad

Lengths = tuple[float, float, float, float]
Pose = tuple[float, float, float]
Pair = tuple[float, float]


def _angles(text: str) -> list[float]:
    """One orientation P or a range A:B:S, both ends included [rad]."""
    parts = text.split(":")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = []
    if len(numbers) == 1:
        return [math.radians(numbers[0])]
    if len(numbers) == 3 and numbers[2] > 0.0 and numbers[0] <= numbers[1]:
        low, high, step = numbers
        count = math.floor((high - low) / step + 1e-9) + 1
        return [math.radians(low + k * step) for k in range(count)]
    raise InputError("--phi-deg", text, "P or A:B:S with A <= B and S > 0, in degrees")


def _anchors(path: Path) -> list[list[float]]:
    """Four anchors X Y in metres, a line each."""
    try:
        rows = [line.replace(",", " ").split() for line in path.read_text().splitlines() if line.strip()]
        points = [[float(value) for value in row] for row in rows]
    except (OSError, ValueError, UnicodeDecodeError) as error:
        raise InputError(f"--anchors {path}", str(error), "a text file of four lines X Y in metres") from None
    if [len(point) for point in points] != [2, 2, 2, 2] or not np.isfinite(points).all():
        raise InputError(f"--anchors {path}", f"{len(points)} lines", "four lines X Y of finite metres")
    return points


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
    from steeplejack.design import summarise, write_map
    from steeplejack.design import tension_map as compute
    from steeplejack.design.tension_map import Load
    from steeplejack.robots.squad.planar import planar_attachments, stay_directions

    site, squad = planar(worksite), load_squad(robot)
    points = site.anchors if anchors is None else np.array(_anchors(anchors))
    load = None
    if criterion == "wrench-feasible":
        if mass_kg is None or tension_n is None:
            raise InputError("--criterion wrench-feasible", "no mass or tension window", "--mass-kg M --tension-n A B")
        stays = stay_directions(points, site.stays) if slip_n is not None else None
        limit = np.inf if slip_n is None else positive("--slip-n", slip_n, "N")
        load = Load(mass_kg, window("--tension-n", *tension_n), (site.gravity[0], site.gravity[1]), stays, limit)
    if out is not None:
        target(out)
    began = time.perf_counter()
    dataset = compute(points, planar_attachments(squad), _angles(phi_deg), step_m, load)
    summary = summarise(dataset)
    seconds = time.perf_counter() - began
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
        "seconds": seconds,
    }
    if best is not None and ":" in phi_deg:
        answer["max"]["phi_deg"] = math.degrees(best[2])
    if load is not None:
        answer["inside_wrench_closure"] = summary.inside_wrench_closure
    if out is not None:
        from steeplejack.design.charts import map_figure, save_figure

        out.mkdir(parents=True, exist_ok=True)
        write_map(dataset, out / "map.nc")
        save_figure(map_figure(dataset, site.stays), out / "map.svg")
        answer |= {"map": str(out / "map.nc"), "figure": str(out / "map.svg")}
    if json:
        emit(answer)
    else:
        _table(answer)


def pose(
    worksite: Worksite,
    lengths_m: Annotated[Lengths, typer.Option(help="Loaded lengths of cables 1 to 4.")],
    robot: Robot = BUILT_IN,
    json: Json = False,
) -> None:
    """Forward kinematics (Eq. 18): the pose from four cable lengths, with residual and uniqueness."""
    from steeplejack.robots.squad.planar import PlanarSquad

    found = PlanarSquad.of(load_squad(robot), planar(worksite).anchors).pose(lengths_m)
    x, y, phi = (float(value) for value in found.pose)
    answer = {
        "x_m": x,
        "y_m": y,
        "phi_deg": math.degrees(phi),
        "residual_m": found.residual,
        "iterations": found.iterations,
        "unique": found.unique,
    }
    emit(answer) if json else _table(answer)


def tensions(
    worksite: Worksite,
    pose: Annotated[Pose, typer.Option(help="X and Y in metres, PHI in degrees.")],
    mass_kg: Annotated[float, typer.Option(help="Held at rest, at p.")],
    tension_n: Annotated[Pair, typer.Option(help="Tension window.")],
    method: Annotated[Literal["min-max", "min-norm", "max-margin"], typer.Option()] = "min-max",
    robot: Robot = BUILT_IN,
    json: Json = False,
) -> None:
    """Tensions that hold a mass at a pose within a window (Eq. 7 and 9), or the proof that none do."""
    from steeplejack.mechanics.cable import Status
    from steeplejack.robots.squad.planar import PlanarSquad

    site, squad = planar(worksite), load_squad(robot)
    low, high = window("--tension-n", *tension_n)
    mass("--mass-kg", mass_kg)
    x, y, degrees = pose
    if not all(map(math.isfinite, pose)):
        raise InputError("--pose", f"{x:g} {y:g} {degrees:g}", "X and Y in metres and PHI in degrees, all finite")
    held = PlanarSquad.of(squad, site.anchors).tensions(
        (x, y, math.radians(degrees)), mass_kg, (low, high), site.gravity, method
    )
    feasible = bool(held.feasible)
    answer = {
        "tensions_n": held.tensions.tolist() if feasible else None,
        "feasible": feasible,
        "margin": float(held.margin) if math.isfinite(float(held.margin)) else None,
        "certificate": None if feasible else held.certificate.tolist(),
    }
    emit(answer) if json else _table(answer)
    if not feasible:
        advice = Status(int(held.status)).name.lower()
        say(f"no tensions of {low:g}-{high:g} N hold {mass_kg:g} kg there: {advice}")
        raise typer.Exit(INFEASIBLE)


def grip(
    radius_m: Annotated[float, typer.Option(help="Radius of the stay.")],
    inclination_deg: Annotated[float, typer.Option(help="Of the stay.")],
    palm_m: Annotated[float, typer.Option(help="Palm length L; the paper does not give it.")],
    sign: Annotated[Literal["+", "-"], typer.Option(help="+ load pulls away from the palms, - it presses.")],
    force_n: Annotated[float, typer.Option(help="External force; the paper's 300 N.")] = 300.0,
    robot: Robot = BUILT_IN,
    json: Json = False,
) -> None:
    """Least palm force that holds an anchor base (Eq. 16-17)."""
    from steeplejack.robots.squad.adhesion import min_grip_force

    gripper = load_squad(robot).gripper
    found = min_grip_force(
        force_n,
        radius_m,
        math.radians(inclination_deg),
        palm_m,
        sign,
        gripper.friction,
        gripper.joint_distance,
        gripper.joint_height,
    )
    answer = {"min_force_n": found.min_force, "gamma_deg": math.degrees(found.gamma)}
    emit(answer) if json else _table(answer)


def _table(answer: dict[str, Any]) -> None:
    for name, value in answer.items():
        print(f"{name:<24}{f'{value:.9g}' if isinstance(value, float) else value}")
