"""Command for the planned-for accident: a driving cable is lost."""

from __future__ import annotations

import math
from typing import Annotated

import typer

from steeplejack.cli.terminal import INFEASIBLE, Json, Robot, Worksite, emit, mass, planar, positive, say, show
from steeplejack.errors import InputError
from steeplejack.robots.squad import BUILT_IN, load_squad

Pose = tuple[float, float, float]


def lost_cable(
    worksite: Worksite,
    pose: Annotated[Pose, typer.Option(help="X and Y in metres, PHI in degrees: where the platform was.")],
    cable: Annotated[int, typer.Option(help="Which cable is lost, 1 to 4.")],
    mass_kg: Annotated[float, typer.Option(help="Of the platform with its load, at p.")],
    robot: Robot = BUILT_IN,
    json: Json = False,
) -> None:
    """Where the platform settles when a cable is lost and the winches are locked; without dynamic overshoot."""
    from steeplejack.mechanics.cable import LockedPlatform, Rest, locked_at
    from steeplejack.mechanics.cable import lost_cable as settle_without
    from steeplejack.robots.squad.planar import planar_attachments

    site = planar(worksite)
    positive("--mass-kg", mass("--mass-kg", mass_kg), "kg")
    x, y, degrees = pose
    if not all(map(math.isfinite, pose)):
        raise InputError("--pose", f"{x:g} {y:g} {degrees:g}", "X and Y in metres and PHI in degrees, all finite")
    if not 1 <= cable <= len(site.anchors):
        raise InputError("--cable", f"{cable}", f"1 to {len(site.anchors)}")
    weight = [mass_kg * part for part in site.gravity]
    platform = LockedPlatform.planar(site.anchors, planar_attachments(load_squad(robot)), 1.0, weight)
    start, phi = (x, y), math.radians(degrees)
    lost = settle_without(locked_at(platform, start, phi), cable - 1, start, phi)
    end = lost.rest
    answer = {
        "x_m": float(end.position[0]),
        "y_m": float(end.position[1]),
        "phi_deg": degrees + math.degrees(end.turned),
        "tensions_n": end.tensions.tolist(),
        "taut": [i + 1 for i in range(len(end.taut)) if end.taut[i]],
        "drop_m": lost.drop,
    }
    emit(answer) if json else show(answer)
    if end.status not in (Rest.STABLE, Rest.NEUTRAL):
        say(f"the platform does not settle: {end.status.advice}")
        raise typer.Exit(INFEASIBLE)
