"""Commands in the plane of the cables: pose, tensions, grip."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import typer

from steeplejack.cli.terminal import INFEASIBLE, Json, Robot, Worksite, emit, mass, planar, say, show, window
from steeplejack.errors import InputError
from steeplejack.mechanics.cable import Method
from steeplejack.robots.squad import BUILT_IN, load_squad

Lengths = tuple[float, float, float, float]
Pose = tuple[float, float, float]
Pair = tuple[float, float]


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
    emit(answer) if json else show(answer)


def tensions(
    worksite: Worksite,
    pose: Annotated[Pose, typer.Option(help="X and Y in metres, PHI in degrees.")],
    mass_kg: Annotated[float, typer.Option(help="Held at rest, at p.")],
    tension_n: Annotated[Pair, typer.Option(help="Tension window.")],
    method: Annotated[Method, typer.Option(help="Which of the feasible tensions.")] = "min-max",
    robot: Robot = BUILT_IN,
    json: Json = False,
) -> None:
    """Tensions that hold a mass at a pose within a window (Eq. 7 and 9), or the proof that none do."""
    from steeplejack.mechanics.cable import DistributionStatus
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
    emit(answer) if json else show(answer)
    if not feasible:
        advice = DistributionStatus(int(held.status)).name.lower()
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
    emit(answer) if json else show(answer)
