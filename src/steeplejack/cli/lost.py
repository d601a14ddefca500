"""Command for the planned-for accident: a driving cable is lost, at one pose, over a grid or along a mission."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from steeplejack.cli import lost_map
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
    show,
    target,
)
from steeplejack.errors import InputError
from steeplejack.robots.squad import BUILT_IN, load_squad

Pose = tuple[float, float, float]


def lost_cable(
    worksite: Worksite,
    pose: Annotated[
        Pose | None, typer.Option(help="X and Y in metres, PHI in degrees: where the platform was.")
    ] = None,
    phi_deg: Annotated[str | None, typer.Option(help="Instead of a pose a grid: orientation P or range A:B:S.")] = None,
    step_m: Annotated[float | None, typer.Option(help="Distance of the grid's nodes.")] = None,
    mission: Annotated[Path | None, typer.Option(help="Instead of a pose the waypoints of a mission file.")] = None,
    cable: Annotated[
        int | None, typer.Option(help="Which cable is lost, 1 to 4; each in turn on a grid or mission.")
    ] = None,
    mass_kg: Annotated[
        float | None, typer.Option(help="Of the platform with its load, at p; a mission has its own.")
    ] = None,
    floor_m: Annotated[float | None, typer.Option(help="Height the platform has to stay above all the way.")] = None,
    robot: Robot = BUILT_IN,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for lost-cable.nc and lost-cable.svg.")] = None,
    json: Json = False,
) -> None:
    """Where the platform settles when a cable is lost and the winches are locked; without dynamic overshoot."""
    asked = {"--pose": pose, "--phi-deg": phi_deg, "--mission": mission}
    given = [option for option, value in asked.items() if value is not None]
    if len(given) != 1:
        raise InputError("lost-cable", " and ".join(given) or "no pose", "one of --pose, --phi-deg and --mission")
    if cable is not None and not 1 <= cable <= 4:
        raise InputError("--cable", f"{cable}", "1 to 4")
    if floor_m is not None and not math.isfinite(floor_m):
        raise InputError("--floor-m", f"{floor_m:g} m", "a finite height")
    if out is not None:
        target(out)
    if pose is not None:
        _only_maps_take({"--step-m": step_m, "--floor-m": floor_m, "--out": out})
        _at_one_pose(worksite, pose, cable, _needed(mass_kg), robot, json)
    elif mission is not None:
        if mass_kg is not None or step_m is not None:
            raise InputError("--mission", "with --mass-kg or --step-m", "neither: the mission has masses and places")
        cases = lost_map.along_mission(worksite, mission, cable)
        lost_map.answer(cases, floor_m, out, json)
    else:
        if step_m is None:
            raise InputError("--phi-deg", "no step", "--step-m H")
        cases = lost_map.over_grid(worksite, phi_deg or "", step_m, _needed(mass_kg), cable, robot)
        lost_map.answer(cases, floor_m, out, json)


def _needed(mass_kg: float | None) -> float:
    """The mass [kg], which only a mission brings with it."""
    if mass_kg is None:
        raise InputError("--mass-kg", "none", "the mass of the platform with its load")
    return positive("--mass-kg", mass("--mass-kg", mass_kg), "kg")


def _only_maps_take(options: dict[str, object]) -> None:
    """Refuse what would be ignored at a single pose."""
    for option, value in options.items():
        if value is not None:
            raise InputError(option, "with --pose", "with --phi-deg or --mission only")


def _at_one_pose(worksite: str, pose: Pose, cable: int | None, mass_kg: float, robot: str, json: bool) -> None:
    """One cable lost at one pose."""
    from steeplejack.mechanics.cable import LockedPlatform, Rest, locked_at
    from steeplejack.mechanics.cable import lost_cable as settle_without
    from steeplejack.robots.squad.planar import planar_attachments

    site = planar(worksite)
    x, y, degrees = pose
    if not all(map(math.isfinite, pose)):
        raise InputError("--pose", f"{x:g} {y:g} {degrees:g}", "X and Y in metres and PHI in degrees, all finite")
    if cable is None:
        raise InputError("--cable", "none", f"which cable is lost, 1 to {len(site.anchors)}")
    weight = [mass_kg * part for part in site.gravity]
    platform = LockedPlatform.planar(site.anchors, planar_attachments(load_squad(robot)), 1.0, weight)
    start, phi = (x, y), math.radians(degrees)
    lost = settle_without(locked_at(platform, start, phi), cable - 1, start, phi)
    end = lost.rest
    found = {
        "x_m": float(end.position[0]),
        "y_m": float(end.position[1]),
        "phi_deg": degrees + math.degrees(end.turned),
        "tensions_n": end.tensions.tolist(),
        "taut": [i + 1 for i in range(len(end.taut)) if end.taut[i]],
        "drop_m": lost.drop,
    }
    emit(found) if json else show(found)
    if end.status not in (Rest.STABLE, Rest.NEUTRAL):
        say(f"the platform does not settle, and the numbers are those at which the search stopped: {end.status.advice}")
        raise typer.Exit(INFEASIBLE)
