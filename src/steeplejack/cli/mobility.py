"""The mobility command: freedoms of the pipe climber, or of any linkage in a file, by every route."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from steeplejack.cli.climber_options import ClimberConvention, ClimberDims, ClimberRobot, climber
from steeplejack.cli.terminal import Json, emit, say, show
from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.parameters import BUILT_IN, PipeClimber

if TYPE_CHECKING:
    from steeplejack.mechanics.limb import Mobility

End = Literal["lower", "upper"]


def mobility(
    robot: ClimberRobot = BUILT_IN,
    convention: ClimberConvention = None,
    dims: ClimberDims = None,
    fixed: Annotated[End | None, typer.Option(help="Which gripper holds the pipe; lower by default.")] = None,
    mechanism: Annotated[
        str | None, typer.Option(help="A linkage instead of the robot: a built-in name or a TOML file.")
    ] = None,
    json: Json = False,
) -> None:
    """Freedoms and constraints by reciprocal screws, by loop closure and by the modified Kutzbach-Gruebler formula."""
    given = {
        "--robot": None if robot == BUILT_IN else robot,
        "--convention": convention,
        "--dims": dims,
        "--fixed": fixed,
    }
    if mechanism is None:
        answer = _robot(*climber(robot, convention, dims), fixed or "lower")
        parts = answer["parts"]
    else:
        for option, value in given.items():
            if value is not None:
                raise InputError(option, "is about the pipe climber", "--mechanism without it")
        answer = _linkage(mechanism)
        parts = {answer["name"]: answer}
    for name, part in parts.items():
        if not part["agree"]:
            say(f"{name}: the routes disagree: the reference configuration is next to a singular one; move it away")
    if json:
        emit(answer)
    else:
        for name, part in parts.items():
            show(_in_words(name, part))


def _robot(machine: PipeClimber, layout: Layout, fixed: End) -> dict[str, Any]:
    """Both mechanisms of the climber, and the robot they make up."""
    from steeplejack.mechanics.limb import mobility as mobility_of
    from steeplejack.robots.pipe_climber.mechanism import parallel_mechanism, rcm_linkage, whole_robot

    parallel = mobility_of(parallel_mechanism(layout, machine.linkage.half_width))
    rcm = mobility_of(rcm_linkage(machine.rcm))
    whole = mobility_of(whole_robot(machine, layout, fixed))
    parts = {"parallel": parallel, "rcm": rcm, "robot": whole}
    return {
        **{name: part.mobility for name, part in parts.items()},
        "freedoms": whole.freedoms,
        "constraints": whole.constraints,
        "parts": {name: _routes(part) for name, part in parts.items()},
    }


def _linkage(mechanism: str) -> dict[str, Any]:
    """A linkage of its own."""
    from steeplejack.mechanics.limb import load_linkage
    from steeplejack.mechanics.limb import mobility as mobility_of

    linkage = load_linkage(mechanism)
    found = mobility_of(linkage)
    return {
        "name": linkage.name,
        **_routes(found),
        "limbs": [
            [{"joints": limb.joints, "connectivity": limb.connectivity, "constraints": limb.constraints} for limb in s]
            for s in found.limbs
        ],
    }


def _in_words(name: str, part: dict[str, Any]) -> dict[str, Any]:
    """The counts of a linkage for a person, a line for every route."""
    f = part["kutzbach"]
    formula = f"{f['order']} ({f['links']} - {f['joints']} - 1) + {f['freedoms']} + {f['redundant']} = {f['mobility']}"
    limbs = {
        f"  limb {number}": f"{limb['joints']}: {'; '.join(limb['constraints']) or 'no constraint'}"
        for number, limb in enumerate((limb for stage in part.get("limbs", []) for limb in stage), start=1)
    }
    return {
        name: f"{part['mobility']}, {part['kind']}",
        "  freedoms": "; ".join(part["freedoms"]) or "none",
        "  constraints": "; ".join(part["constraints"]) or "none",
        "  by reciprocal screws": part["by_reciprocal_screws"],
        "  by loop closure": part["by_closure"],
        "  by the formula": formula,
        **limbs,
    }


def _routes(found: Mobility) -> dict[str, Any]:
    """What every route counted."""
    formula = found.kutzbach
    return {
        "mobility": found.mobility,
        "freedoms": found.freedoms,
        "constraints": found.constraints,
        "kind": found.kind,
        "by_reciprocal_screws": found.by_reciprocal_screws,
        "by_closure": found.by_closure,
        "kutzbach": {
            "order": formula.order,
            "links": formula.links,
            "joints": formula.joints,
            "freedoms": formula.freedoms,
            "redundant": formula.redundant,
            "mobility": formula.mobility,
        },
        "passive": found.passive,
        "locked": found.locked,
        "agree": found.agree,
    }
