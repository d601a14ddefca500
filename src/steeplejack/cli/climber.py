"""Commands about the pipe climber's kinematics: legs, platform, motion, singularity."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from steeplejack.cli.climber_options import ClimberConvention, ClimberDims, ClimberRobot, JointNeutral, climber, pose_of
from steeplejack.cli.terminal import INFEASIBLE, Json, emit, say, show, target, writing
from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.layout import LARGEST, LEAST
from steeplejack.robots.pipe_climber.parameters import BUILT_IN, PipeClimber

if TYPE_CHECKING:
    from steeplejack.robots.pipe_climber.inverse import Excess

Triple = tuple[float, float, float]

OPEN = "the limbs do not close: no pose has these lengths"


def legs(
    pose: Annotated[Triple, typer.Option(help="X and W in metres, ALPHA in degrees: pose of O2.")],
    robot: ClimberRobot = BUILT_IN,
    convention: ClimberConvention = None,
    dims: ClimberDims = None,
    joint_neutral: JointNeutral = None,
    json: Json = False,
) -> None:
    """Inverse kinematics: lengths of the three limbs, and the limits they do not hold.

    The limits are those of the mechanism as analysed. Where a limb leaves the window of its own cylinder in the robot
    file, retracted to retracted + stroke, `outside_stroke` says so; it is no failure.
    """
    from steeplejack.robots.pipe_climber.inverse import exceeded, limb_lengths

    machine, layout = climber(robot, convention, dims, joint_neutral)
    given = pose_of("--pose", pose)
    beyond, lengths = exceeded(layout, given), limb_lengths(layout, given).tolist()
    answer = {
        "q_m": lengths,
        "exceeded": [_listed(one) for one in beyond],
        "outside_stroke": [
            {"limb": limb, "value_m": length, "limit_m": limit} for limb, length, limit in _off_stroke(machine, lengths)
        ],
    }
    if json:
        emit(answer)
    else:
        show({"q_m": lengths})
        for limb, length, bound in _off_stroke(machine, lengths):
            print(f"limb {limb} is {length:.6g} m long, its own cylinder ends at {bound:.6g} m")
    if beyond:
        say("out of reach: " + "; ".join(map(str, beyond)))
        raise typer.Exit(INFEASIBLE)


def platform(
    q_m: Annotated[Triple, typer.Option("--q-m", help="Lengths of limbs 1 to 3.")],
    robot: ClimberRobot = BUILT_IN,
    convention: ClimberConvention = None,
    dims: ClimberDims = None,
    json: Json = False,
) -> None:
    """Forward kinematics: every real pose of three limb lengths, proved to be all, and lengths out of reach."""
    from steeplejack.robots.pipe_climber.certificate import certified_poses
    from steeplejack.robots.pipe_climber.inverse import exceeded_lengths

    _, layout = climber(robot, convention, dims)
    if not all(LEAST <= length <= LARGEST for length in q_m):
        valid = f"three finite lengths of {LEAST:g} to {LARGEST:g} m"
        raise InputError("--q-m", " ".join(f"{length:g}" for length in q_m), valid)
    solutions = [
        {"x_m": one.pose[0], "w_m": one.pose[1], "alpha_deg": math.degrees(one.pose[2]), "working_mode": one.mode}
        for one in certified_poses(layout, q_m)
    ]
    beyond = exceeded_lengths(layout, q_m)
    if json:
        answer = {"solutions": solutions, "certified": True, "exceeded": [_listed(one) for one in beyond]}
        emit(answer if solutions else answer | {"binding": OPEN})
    else:
        for one in solutions:
            place = f"x {one['x_m']:.9g} m, w {one['w_m']:.9g} m, alpha {one['alpha_deg']:.9g} deg"
            print(f"{place}   {one['working_mode']}")
        print(f"{len(solutions)} real solutions, proved")
    if beyond or not solutions:
        reasons = ["out of reach: " + "; ".join(map(str, beyond))] if beyond else []
        say("; ".join(reasons if solutions else [OPEN, *reasons]))
        raise typer.Exit(INFEASIBLE)


def motion(
    motion: Annotated[
        str, typer.Argument(help="eq27, eq27-printed, a TOML file of polynomials or a CSV file of samples.")
    ],
    at: Annotated[float, typer.Option("--at", help="Moment of the motion [s].")],
    hz_m: Annotated[float | None, typer.Option(help="From O2 to the claw; by default as in the robot file.")] = None,
    robot: ClimberRobot = BUILT_IN,
    convention: ClimberConvention = None,
    dims: ClimberDims = None,
    joint_neutral: JointNeutral = None,
    json: Json = False,
) -> None:
    """Limbs along a motion of the claw: lengths, speeds and accelerations at a moment, violations over all of it."""
    from steeplejack.robots.pipe_climber.motion import limb_states
    from steeplejack.robots.pipe_climber.motion_file import load_motion
    from steeplejack.robots.pipe_climber.violations import violations

    machine, layout = climber(robot, convention, dims, joint_neutral)
    offset = machine.linkage.claw_offset if hz_m is None else hz_m
    if not abs(offset) <= LARGEST:
        raise InputError("--hz-m", f"{offset:g} m", f"a finite length of up to {LARGEST:g} m")
    moved = load_motion(motion)
    if not 0.0 <= at <= moved.duration:
        raise InputError("--at", f"{at:g} s", f"within the motion, 0 to {moved.duration:g} s")
    lengths, speeds, accelerations = limb_states(layout, moved, at, offset)
    found = violations(machine, layout, moved, offset)
    answer = {"q_m": lengths.tolist(), "qd_m_s": speeds.tolist(), "qdd_m_s2": accelerations.tolist()}
    if json:
        emit(answer | {"violations": [one._asdict() for one in found]})
        return
    show(answer)
    for one in found:
        who = f"limb {one.limb} {one.what}" if one.limb else one.what
        span = f"{one.from_s:.4g} to {one.to_s:.4g} s, worst at {one.at_s:.4g} s"
        print(f"violated: {who:<24} {one.value:.5g} {one.unit}, limit {one.limit:.5g}   {span}")


def singularity(
    alpha_deg: Annotated[float, typer.Option(help="Turn of the platform about Y.")],
    robot: ClimberRobot = BUILT_IN,
    convention: ClimberConvention = None,
    dims: ClimberDims = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for singularity.svg.")] = None,
    json: Json = False,
) -> None:
    """The singular surface at one alpha, and how near the poses within the actuators' reach come to it."""
    from steeplejack.robots.pipe_climber.singular_slice import ROWS_PER_METRE, singular_slice

    _, layout = climber(robot, convention, dims)
    if not math.isfinite(alpha_deg):
        raise InputError("--alpha-deg", f"{alpha_deg:g} deg", "a finite angle")
    if out is not None:
        target(out)
    found = singular_slice(layout, math.radians(alpha_deg))
    answer: dict[str, Any] = {
        "min_abs_det": found.least / layout.lengths[0],
        "min_at_m": list(found.least_at),
        "sign_changes": found.crossings,
        "signs": list(found.signs),
    }
    if out is not None:
        answer["figure"] = str(_drawn(layout, math.radians(alpha_deg), out))
    if json:
        emit({"x_of_w": found.curve.tolist(), "w_step_m": 1.0 / ROWS_PER_METRE, **answer})
    else:
        show(answer)


def _listed(one: Excess) -> dict[str, Any]:
    """A limit that is not held, as `exceeded` of an answer lists it."""
    unit = "m" if one.what == "length" else "rad"
    return {"limb": one.limb, "what": one.what, **_measured(one.value, one.limit, unit)}


def _off_stroke(machine: PipeClimber, lengths: list[float]) -> list[tuple[int, float, float]]:
    """Limbs that are shorter or longer than their own cylinders allow: limb, its length, the bound [m]."""
    from steeplejack.robots.pipe_climber.inverse import ROUNDING

    found: list[tuple[int, float, float]] = []
    for limb, (length, retracted) in enumerate(zip(lengths, machine.cylinders.retracted, strict=True), 1):
        extended = retracted + machine.cylinders.stroke
        if not retracted * (1.0 - ROUNDING) <= length <= extended * (1.0 + ROUNDING):
            found.append((limb, length, retracted if length < retracted else extended))
    return found


def _measured(value: float, limit: float, unit: str) -> dict[str, float]:
    """Value and limit with their unit in the key."""
    if unit == "m":
        return {"value_m": value, "limit_m": limit}
    return {"value_deg": math.degrees(value), "limit_deg": math.degrees(limit)}


def _drawn(layout: Any, alpha: float, out: Path) -> Path:
    """Write the figure of the slice."""
    from steeplejack.design.charts.singularity import singularity_figure
    from steeplejack.design.charts.style import save_figure

    out.mkdir(parents=True, exist_ok=True)
    path = out / "singularity.svg"
    with writing(path):
        save_figure(singularity_figure(layout, alpha), path)
    return path
