"""Commands of the main job: inspect and report."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
import typer

from steeplejack.cli.terminal import Ended, Json, Out, Robot, Worksite, bar, emit, mass, say, target, window
from steeplejack.cli.terminal import bridge as load_bridge
from steeplejack.errors import InputError
from steeplejack.planning import Request, Rules, Scene, asked_stretch, choose_bay, choose_stretch, plan, verdicts, write
from steeplejack.robots.squad import BUILT_IN, Bay, load_squad


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
    face: Annotated[Literal["under", "upper"], typer.Option(help="Face of the fan the platform flies at.")] = "under",
    payload_kg: Annotated[float, typer.Option(help="Carried beyond the bare platform.")] = 0.0,
    tension_n: Annotated[tuple[float, float], typer.Option(help="Working window of the driving cables.")] = (
        20.0,
        250.0,
    ),
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
    from steeplejack.report import write_report
    from steeplejack.simulation import Session

    bridge, squad = load_bridge(worksite), load_squad(robot)
    low, high = window("--tension-n", *tension_n)
    mass("--payload-kg", payload_kg)
    target(out)
    asked = None if stays is None else _pair(stays, "--stays")
    chosen, bounds, assumed = choose_bay(bridge, squad, fan, asked, accept_unknown)
    bay = Bay.of(chosen, *bounds, face, squad)
    stretch = asked_stretch(bay, from_m, to_m)
    rules = Rules(tension=(low, high), payload=payload_kg)
    say(f"{bridge.name}, fan {chosen.id}, stays {bounds[0]}:{bounds[1]}, {face} face")
    for item in assumed:
        say(f"assumed: {item}")
    if stretch is None:
        with bar("choose", None):
            stretch = choose_stretch(bridge, bay, squad, rules)
    start, end = stretch
    scene = Scene.of(bay, squad, rules, np.array(bridge.gravity))
    request = Request(
        worksite,
        squad.name,
        chosen.id,
        bounds,
        float(start),
        float(end),
        face,
        float(payload_kg),
        (float(low), float(high)),
    )
    with bar("plan", 1.0) as step:
        mission = plan(scene, request, assumed, step)
    out.mkdir(parents=True, exist_ok=True)
    paths = {"log": out / "run.mcap", "report": out / "report.html", "mission": out / "inspection.mission.json"}
    write(mission, paths["mission"])
    say(f"{mission.stances} stances, {mission.moves} squad moves, {start:.1f}-{end:.1f} m of {len(bay.interior)} stays")
    session = Session(mission, bridge, bay, squad, verdicts(bridge, squad), seed)
    began = time.perf_counter()
    with bar("simulate", session.expected_duration) as step:
        result = session.run(paths["log"], pictures, step)
    factor = result.duration / (time.perf_counter() - began)
    with bar("report", None):
        summary = write_report(paths["log"], paths["report"])
    answer = {
        **msgspec.to_builtins(summary),
        "real_time_factor": round(factor, 2),
        **{name: str(path) for name, path in paths.items()},
    }
    if json:
        emit(answer)
    else:
        _print_summary(answer)
    if not result.completed:
        raise Ended(f"the run ended early but safely: {'; '.join(result.faults)}; log and report are complete to there")


def _print_summary(answer: dict[str, Any]) -> None:
    along, across = answer["error_along_mm"], answer["error_across_mm"]
    rows = [
        ("covered, faced sector", f"{100 * answer['coverage_fraction']:.1f} %"),
        ("covered, all round", f"{100 * answer['clock_coverage']:.1f} %"),
        ("stances, squad moves", f"{answer['stances']}, {answer['moves']}"),
        ("duration", f"{answer['duration_s'] / 60:.1f} min, {answer['real_time_factor']:.1f} times real time"),
        ("platform travel", f"{answer['distance_m']:.0f} m"),
        ("stand-off", f"{answer['stand_off_m']['min']:.2f}-{answer['stand_off_m']['max']:.2f} m"),
        ("largest tension", f"{answer['max_tension_n']:.0f} N"),
        ("least slip margin", f"{answer['min_slip_margin']:.3f}"),
        ("error along the stay", f"{along['mean']:+.1f} +- {along['std']:.1f} mm"),
        ("error across", f"{across['mean']:+.1f} +- {across['std']:.1f} mm"),
        (
            "absolute error",
            f"mean {answer['absolute_error_mm']['mean']:.0f}, max {answer['absolute_error_mm']['max']:.0f} mm",
        ),
        ("log", answer["log"]),
        ("mission", answer["mission"]),
        ("report", answer["report"]),
    ]
    for name, value in rows:
        print(f"{name:<24}{value}")
    for gap in answer["not_covered"]:
        print(f"not covered: {gap['stay']} {gap['from_m']:.1f}-{gap['to_m']:.1f} m: {gap['why']}")


def report(
    log: Annotated[Path, typer.Argument(help="A run's MCAP log.")], out: Out = Path("out"), json: Json = False
) -> None:
    """Write the report again, from the log alone."""
    from steeplejack.report import read_log, write_report

    if not log.is_file():
        raise InputError(str(log), "no such file", "a log written by `steeplejack inspect`")
    target(out)
    read_log(log)  # before anything is written
    out.mkdir(parents=True, exist_ok=True)
    path = out / "report.html"
    with bar("report", None):
        summary = msgspec.to_builtins(write_report(log, path))
    if json:
        emit({**summary, "log": str(log), "report": str(path)})
    else:
        print(path)
