"""Commands of the main job: inspect and report."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import numpy as np
import typer

from steeplejack.cli.terminal import (
    Ended,
    Json,
    Out,
    Robot,
    Worksite,
    bar,
    emit,
    mass,
    say,
    stoppable,
    target,
    window,
    writing,
)
from steeplejack.cli.terminal import bridge as load_bridge
from steeplejack.errors import InputError
from steeplejack.planning import (
    Mission,
    Request,
    Rules,
    Scene,
    asked_stretch,
    choose_bay,
    choose_stretch,
    plan,
    verdicts,
    write,
)
from steeplejack.robots.squad import BUILT_IN, Bay, Face, Squad, load_squad
from steeplejack.worksite import Bridge

if TYPE_CHECKING:
    from steeplejack.runtime import Result
    from steeplejack.simulation import Session


def _pair(text: str, option: str) -> tuple[int, int]:
    first, colon, last = text.partition(":")
    if not (colon and first.isdecimal() and last.isdecimal() and int(first) < int(last)):
        raise InputError(option, text, "FIRST:LAST, two stay numbers such as 5:9")
    return int(first), int(last)


def inspect(
    worksite: Worksite,
    fan: Annotated[str | None, typer.Option(help="T{tower}{plane}-{side}, such as T1L-main.")] = None,
    stays: Annotated[str | None, typer.Option(help="Boundary stays FIRST:LAST; those between are inspected.")] = None,
    from_m: Annotated[float | None, typer.Option(help="Start along the stays from the lower anchorage.")] = None,
    to_m: Annotated[float | None, typer.Option(help="End along the stays.")] = None,
    face: Annotated[Face, typer.Option(help="Face of the fan the platform flies at.")] = "under",
    payload_kg: Annotated[float, typer.Option(help="Carried beyond the bare platform.")] = 0.0,
    tension_n: Annotated[
        tuple[float, float] | None,
        typer.Option(help="Working window of the driving cables.", show_default="the robot file's"),
    ] = None,
    chord: Annotated[
        bool, typer.Option("--chord", help="Take the stays as straight chords; needs no weight and tension.")
    ] = False,
    accept_unknown: Annotated[
        bool, typer.Option("--accept-unknown", help="Assume what the bridge's data lack.")
    ] = False,
    robot: Robot = BUILT_IN,
    seed: Annotated[int, typer.Option(min=0, help="Of the sensors' noise and drift.")] = 0,
    pictures: Annotated[bool, typer.Option(help="Render pictures of the squad at work into the log.")] = True,
    out: Out = Path("out"),
    json: Json = False,
) -> None:
    """Check, plan, simulate in physics, log and report an inspection with the zero-downtime gait."""
    from steeplejack.simulation import Session

    bridge, squad = load_bridge(worksite), load_squad(robot)
    bridge = bridge.as_chords() if chord else bridge
    rules = Rules(_window(tension_n, squad), mass("--payload-kg", payload_kg))
    target(out)
    asked = None if stays is None else _pair(stays, "--stays")
    chosen, bounds, assumed = choose_bay(bridge, squad, fan, asked, accept_unknown)
    bay = Bay.of(chosen, *bounds, face, squad)
    stretch = asked_stretch(bay, from_m, to_m)
    say(f"{bridge.name}, fan {chosen.id}, stays {bounds[0]}:{bounds[1]}, {face} face")
    for item in assumed:
        say(f"assumed: {item}")
    mission = _planned(worksite, bridge, bay, squad, rules, stretch, assumed)
    session = Session(mission, bridge, bay, squad, verdicts(bridge, squad), seed)
    result, answer = _flown(session, pictures, out)
    emit(answer) if json else show_summary(answer)
    if not result.completed:
        raise Ended(f"the run ended early but safely: {'; '.join(result.faults)}; log and report are complete to there")


def _window(asked: tuple[float, float] | None, squad: Squad) -> tuple[float, float]:
    """The working window [N], as asked for or the robot file's, where the winches can tell and pull it.

    Motor currents tell a tension give or take the winch's friction, so a cable kept at less than twice that is not
    told from a slack one; a winch that pulls in leaves the cable what its motor gives less friction.
    """
    where, (low, high) = ("[cable] tension", squad.cable.tension) if asked is None else ("--tension-n", asked)
    low, high = window(where, low, high)
    winch = squad.winch
    least = 2.0 * winch.friction
    most = winch.max_torque * winch.ratio / winch.drum_radius - winch.friction
    if low < least:
        raise InputError(where, f"{low:g} N", f"from {least:g} N: under twice the winch's friction it may be slack")
    if high > most:
        raise InputError(where, f"{high:g} N", f"up to {most:.4g} N, what the winch can pull")
    return low, high


def _planned(
    worksite: str,
    bridge: Bridge,
    bay: Bay,
    squad: Squad,
    rules: Rules,
    stretch: tuple[float, float] | None,
    assumed: tuple[str, ...],
) -> Mission:
    """The mission over a stretch [m] of a bay, chosen where none was asked for."""
    if stretch is None:
        with bar("choose", None):
            stretch = choose_stretch(bridge, bay, squad, rules)
    start, end = (float(place) for place in stretch)
    ends = bay.stays[0].index, bay.stays[-1].index
    request = Request(worksite, squad.name, bay.fan, ends, start, end, bay.face, rules.payload, rules.tension)
    with bar("plan", 1.0) as step:
        mission = plan(Scene.of(bay, squad, rules, np.array(bridge.gravity)), request, assumed, step)
    say(f"{mission.stances} stances, {mission.moves} squad moves, {start:.1f}-{end:.1f} m of {len(bay.interior)} stays")
    return mission


def _flown(session: Session, pictures: bool, out: Path) -> tuple[Result, dict[str, Any]]:
    """Write the mission, run it, report it; how it ended, and the answer of the command."""
    from steeplejack.report import write_report

    out.mkdir(parents=True, exist_ok=True)
    log, page, mission = out / "run.mcap", out / "report.html", out / "inspection.mission.json"
    with writing(mission):
        write(session.mission, mission)
    began = time.perf_counter()
    with bar("simulate", session.expected_duration) as step, writing(log), stoppable() as asked_to_stop:
        result = session.run(log, pictures, step, asked_to_stop)
    factor = result.duration / (time.perf_counter() - began)
    with bar("report", None), writing(page):
        summary = write_report(log, page)
    answer = msgspec.to_builtins(summary) | {"real_time_factor": round(factor, 2)}
    return result, answer | {"log": str(log), "report": str(page), "mission": str(mission)}


def show_summary(answer: dict[str, Any]) -> None:
    """Print the answer of ``inspect`` for a person; a run that ended before it saw anything has no errors to show."""
    along, across, absolute = (answer[f"{name}_mm"] for name in ("error_along", "error_across", "absolute_error"))
    off = answer["stand_off_m"]
    rows = {
        "covered, faced sector": f"{100 * answer['coverage_fraction']:.1f} %",
        "covered, all round": f"{100 * answer['clock_coverage']:.1f} %",
        "stances, squad moves": f"{answer['stances']}, {answer['moves']}",
        "duration": f"{answer['duration_s'] / 60:.1f} min, {answer['real_time_factor']:.1f} times real time",
        "platform travel": f"{answer['distance_m']:.0f} m",
        "stand-off": f"{_between(off['min'], off['max'], '.2f')} m",
        "largest tension": f"{answer['max_tension_n']:.0f} N",
        "least slip margin": f"{answer['min_slip_margin']:.3f}",
        "error along the stay": f"{_figure(along['mean'], '+.1f')} +- {_figure(along['std'], '.1f')} mm",
        "error across": f"{_figure(across['mean'], '+.1f')} +- {_figure(across['std'], '.1f')} mm",
        "absolute error": f"mean {_figure(absolute['mean'], '.0f')}, max {_figure(absolute['max'], '.0f')} mm",
        **{name: answer[name] for name in ("log", "mission", "report")},
    }
    for name, value in rows.items():
        print(f"{name:<24}{value}")
    for gap in answer["not_covered"]:
        print(f"not covered: {gap['stay']} {gap['from_m']:.1f}-{gap['to_m']:.1f} m: {gap['why']}")


def _figure(value: float, form: str) -> str:
    return "?" if math.isnan(value) else format(value, form)


def _between(low: float, high: float, form: str) -> str:
    """Two ends of a range, or one figure where both are printed alike."""
    return "-".join(dict.fromkeys(_figure(value, form) for value in (low, high)))


def report(
    log: Annotated[Path, typer.Argument(help="A run's MCAP log.")], out: Out = Path("out"), json: Json = False
) -> None:
    """Write the report again, from the log alone."""
    from steeplejack.report import read_log, write_report
    from steeplejack.report.climb import is_climb, read_climb, write_climb_report

    if not log.is_file():
        raise InputError(str(log), "no such file", "a log written by `steeplejack inspect` or `steeplejack climb`")
    target(out)
    climbed = is_climb(log)
    read_climb(log) if climbed else read_log(log)  # before anything is written
    out.mkdir(parents=True, exist_ok=True)
    path = out / "report.html"
    with bar("report", None), writing(path):
        summary = msgspec.to_builtins(write_climb_report(log, path) if climbed else write_report(log, path))
    if json:
        emit({**summary, "log": str(log), "report": str(path)})
    else:
        print(path)
