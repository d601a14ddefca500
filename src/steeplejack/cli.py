"""The command line: composes the rooms into commands. Names, keys and exit codes are a contract, see docs/cli.md."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
import typer

from steeplejack.errors import InfeasibleError, InputError, SteeplejackError

BAD_INPUT, INFEASIBLE, ENDED_EARLY, INTERRUPTED = 2, 3, 4, 130

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Robots that climb tall structures with parallel mechanisms: check, plan, simulate, inspect, report.",
)

Json = Annotated[bool, typer.Option("--json", help="One JSON object on stdout, everything else on stderr.")]
Out = Annotated[Path, typer.Option("--out", help="Folder for the files it writes.")]
Worksite = Annotated[str, typer.Argument(help="Built-in name, TOML worksite or CSV stay schedule.")]
Robot = Annotated[str, typer.Option("--robot", help="ccrobot-s or a TOML robot file.")]


class Ended(SteeplejackError):
    """A run that ended early but safely."""


def main() -> None:
    """Run the command line; every foreseeable failure is one line and its exit code."""
    try:
        app(standalone_mode=False)
    except InputError as error:
        _fail(str(error), BAD_INPUT)
    except InfeasibleError as error:
        if "--json" in sys.argv:
            _emit({"feasible": False, "what": error.what, "binding": error.binding})
        _fail(f"no feasible answer: {error}", INFEASIBLE)
    except Ended as error:
        _fail(str(error), ENDED_EARLY)
    except typer.Exit as error:
        sys.exit(error.exit_code)
    except typer.Abort:
        _fail("interrupted", INTERRUPTED)
    except KeyboardInterrupt:
        _fail("interrupted", INTERRUPTED)
    except Exception as error:  # usage errors of the option parser carry their own text
        if not hasattr(error, "format_message"):
            raise
        _fail(f"{error.format_message()}; see --help", BAD_INPUT)  # pyright: ignore[reportAttributeAccessIssue]


def _fail(text: str, code: int) -> None:
    print(text.replace("\n", " "), file=sys.stderr)
    sys.exit(code)


def _emit(answer: Any) -> None:
    print(msgspec.json.encode(answer).decode())


def _say(text: str) -> None:
    print(text, file=sys.stderr)


@contextmanager
def _bar(title: str, total: float) -> Iterator[Callable[[float], None]]:
    """A progress bar on stderr; the callable takes how far the work is."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description:<22}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True)) as progress:
        task = progress.add_task(title, total=total)
        yield lambda done: progress.update(task, completed=min(done, total))
        progress.update(task, completed=total)


def _bridge(worksite: str) -> Any:
    from steeplejack.worksite import Bridge, load_worksite

    site = load_worksite(worksite)
    if not isinstance(site, Bridge):
        raise InputError("WORKSITE", f"{worksite} is a planar example", "a bridge or a stay schedule")
    return site


def _planar(worksite: str) -> Any:
    from steeplejack.worksite import PlanarSite, load_worksite

    site = load_worksite(worksite)
    if not isinstance(site, PlanarSite):
        raise InputError("WORKSITE", f"{worksite} is a bridge", "a planar worksite such as table-iii")
    return site


def _pair(text: str, option: str) -> tuple[int, int]:
    first, colon, last = text.partition(":")
    if not (colon and first.isdigit() and last.isdigit() and int(first) < int(last)):
        raise InputError(option, text, "FIRST:LAST, two stay numbers such as 5:9")
    return int(first), int(last)


@app.command(epilog="Example: steeplejack check sutong-like")
def check(worksite: Worksite, robot: Robot = "ccrobot-s", json: Json = False) -> None:
    """Does the machine fit the stays? Per stay, and why not."""
    from steeplejack.planning import verdicts
    from steeplejack.robots.squad import load_squad

    bridge, squad = _bridge(worksite), load_squad(robot)
    found = verdicts(bridge, squad)
    counts = {kind: sum(v.fits is value for v in found) for kind, value in (("fit", True), ("unfit", False))}
    undecided = len(found) - sum(counts.values())
    if json:
        stays = [{"id": v.stay, "fits": v.fits, "reasons": v.reasons, "unknown": v.unknown} for v in found]
        _emit({"stays": stays, **counts, "undecided": undecided})
    else:
        for v in found:
            word = {True: "fits", False: "does not fit", None: "unknown"}[v.fits]
            print(f"{v.stay:<12} {word:<14}{', '.join((*v.reasons, *(f'{u} unknown' for u in v.unknown)))}")
        print(f"{bridge.name}: {counts['fit']} fit, {counts['unfit']} do not, {undecided} undecided")
    if counts["unfit"] == len(found):
        _say(f"no stay of {bridge.name} fits {squad.name}: {found[0].reasons[0]}")
        raise typer.Exit(INFEASIBLE)


@app.command(epilog="Example: steeplejack inspect ecs620-like --fan T1L-main --stays 5:9")
def inspect(
    worksite: Worksite,
    fan: Annotated[str | None, typer.Option(help="T{tower}{plane}-{side}, such as T1L-main.")] = None,
    stays: Annotated[str | None, typer.Option(help="Boundary stays FIRST:LAST; those between are inspected.")] = None,
    from_m: Annotated[float | None, typer.Option(help="Start along the stays from the lower anchorage.")] = None,
    to_m: Annotated[float | None, typer.Option(help="End along the stays.")] = None,
    face: Annotated[Literal["under", "upper"], typer.Option(help="Face of the fan the platform flies at.")] = "under",
    payload_kg: Annotated[float, typer.Option(help="Carried beyond the bare platform.")] = 0.0,
    tension_n: Annotated[tuple[float, float], typer.Option(help="Working window of the driving cables.")] = (20.0, 250.0),
    accept_unknown: Annotated[bool, typer.Option("--accept-unknown", help="Assume what the bridge's data lack.")] = False,
    robot: Robot = "ccrobot-s",
    seed: Annotated[int, typer.Option(help="Of the sensors' noise and drift.")] = 0,
    pictures: Annotated[bool, typer.Option(help="Render pictures of the squad at work into the log.")] = True,
    out: Out = Path("out"),
    json: Json = False,
) -> None:
    """Check, plan, simulate in physics, log and report an inspection with the zero-downtime gait."""
    import time

    from steeplejack.planning import Request, Rules, Scene, choose_bay, choose_stretch, plan, verdicts, write
    from steeplejack.report import write_report
    from steeplejack.robots.squad import Bay, load_squad
    from steeplejack.simulation import Session

    bridge, squad = _bridge(worksite), load_squad(robot)
    low, high = tension_n
    if not 0.0 < low < high:
        raise InputError("--tension-n", f"{low:g} {high:g}", "two tensions in N, the smaller first, above 0")
    if payload_kg < 0.0:
        raise InputError("--payload-kg", f"{payload_kg:g}", "0 or more")
    asked = None if stays is None else _pair(stays, "--stays")
    chosen, bounds, assumed = choose_bay(bridge, squad, fan, asked, accept_unknown)
    bay = Bay.of(chosen, *bounds, face, squad)
    rules = Rules(tension=(low, high), payload=payload_kg)
    _say(f"{bridge.name}, fan {chosen.id}, stays {bounds[0]}:{bounds[1]}, {face} face")
    for item in assumed:
        _say(f"assumed: {item}")
    start, end = choose_stretch(bridge, bay, squad, rules, (from_m, to_m))
    scene = Scene.of(bay, squad, rules, bridge.gravity)
    request = Request(
        worksite, squad.name, chosen.id, bounds, float(start), float(end), face, float(payload_kg), (float(low), float(high))
    )
    with _bar("plan", 1.0) as step:
        mission = plan(scene, request, assumed, step)
    out.mkdir(parents=True, exist_ok=True)
    paths = {"log": out / "run.mcap", "report": out / "report.html", "mission": out / "inspection.mission.json"}
    write(mission, paths["mission"])
    _say(f"{mission.stances} stances, {mission.moves} squad moves, {start:.1f}-{end:.1f} m of {len(bay.interior)} stays")
    session = Session(mission, bridge, bay, squad, verdicts(bridge, squad), seed)
    began = time.perf_counter()
    with _bar("simulate", session.expected_duration) as step:
        result = session.run(paths["log"], pictures, step)
    factor = result.duration / (time.perf_counter() - began)
    summary = write_report(paths["log"], paths["report"])
    answer = {
        **msgspec.to_builtins(summary),
        "real_time_factor": round(factor, 2),
        **{name: str(path) for name, path in paths.items()},
    }
    if json:
        _emit(answer)
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
        ("absolute error", f"mean {answer['absolute_error_mm']['mean']:.0f}, max {answer['absolute_error_mm']['max']:.0f} mm"),
        ("log", answer["log"]),
        ("mission", answer["mission"]),
        ("report", answer["report"]),
    ]
    for name, value in rows:
        print(f"{name:<24}{value}")
    for gap in answer["not_covered"]:
        print(f"not covered: {gap['stay']} {gap['from_m']:.1f}-{gap['to_m']:.1f} m: {gap['why']}")


@app.command(epilog="Example: steeplejack report out/run.mcap --out out")
def report(
    log: Annotated[Path, typer.Argument(help="A run's MCAP log.")], out: Out = Path("out"), json: Json = False
) -> None:
    """Write the report again, from the log alone."""
    from steeplejack.report import write_report

    if not log.is_file():
        raise InputError(str(log), "no such file", "a log written by `steeplejack inspect`")
    out.mkdir(parents=True, exist_ok=True)
    path = out / "report.html"
    summary = msgspec.to_builtins(write_report(log, path))
    if json:
        _emit({**summary, "log": str(log), "report": str(path)})
    else:
        print(path)


@app.command(epilog="Example: steeplejack robots")
def robots(json: Json = False) -> None:
    """List the built-in robots with their sources."""
    from steeplejack.robots.squad import BUILT_IN, load_squad

    squad = load_squad()
    source = "Zheng et al., CCRobot-S, IEEE T-RO, presented at ICRA 2026; estimates marked in the file"
    answer = [{"name": BUILT_IN, "mass_kg": squad.platform.mass, "source": source}]
    if json:
        _emit({"robots": answer})
    else:
        for row in answer:
            print(f"{row['name']:<12} {row['source']}")


@app.command(epilog="Example: steeplejack worksites")
def worksites(json: Json = False) -> None:
    """List the built-in worksites with their sources."""
    from steeplejack.worksite import list_worksites

    rows = list_worksites()
    if json:
        _emit({"worksites": [{"name": r.name, "description": r.description, "source": r.source} for r in rows]})
    else:
        for row in rows:
            print(f"{row.name:<18} {row.description}\n{'':<18} {row.source}")
