"""The pipe climber's main job: plan a climb, run it in physics, log and report it."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import typer

from steeplejack.cli.climber_options import ClimberRobot
from steeplejack.cli.terminal import Ended, Json, Out, bar, emit, mass, say, stoppable, target, writing
from steeplejack.errors import InfeasibleError, InputError
from steeplejack.robots.pipe_climber import BUILT_IN, Layout, PipeClimber, load_pipe_climber
from steeplejack.worksite.pipe_builtin import load_pipe

if TYPE_CHECKING:
    from steeplejack.runtime.climb_record import EndRecord
    from steeplejack.simulation.climber.session import ClimbSession

Pipe = Annotated[str, typer.Argument(help="Built-in name or TOML file of a run of pipes.")]


def climb(
    pipe: Pipe,
    robot: ClimberRobot = BUILT_IN,
    mu: Annotated[
        float | None,
        typer.Option(help="Friction of the pads on this pipe, for plan and physics.", show_default="the file's"),
    ] = None,
    mu_in_physics: Annotated[
        float | None,
        typer.Option(help="Friction in physics alone, unknown to the plan: an experiment.", show_default="as --mu"),
    ] = None,
    payload_kg: Annotated[float, typer.Option(help="Carried by the upper gripper.")] = 0.0,
    seed: Annotated[int, typer.Option(min=0, help="Of the sensors' errors.")] = 0,
    pictures: Annotated[bool, typer.Option(help="Render a film strip into the log.")] = True,
    video: Annotated[bool, typer.Option("--video", help="Render a film too: climb.webp, and in the report.")] = False,
    out: Out = Path("out"),
    json: Json = False,
) -> None:
    """Plan, simulate in physics, log and report a climb over a run of pipes."""
    from steeplejack.planning.climb import plan_climb
    from steeplejack.simulation.climber.session import ClimbSession

    run, machine = load_pipe(pipe), _rubbing(load_pipe_climber(robot), mu)
    friction = _friction("--mu-in-physics", mu_in_physics, machine)
    mass("--payload-kg", payload_kg)
    target(out)
    say(f"{run.name}: {run.description}")
    with bar("plan", None):
        plan = plan_climb(run, machine, payload_kg, _after_a_while())
    if not plan.complete:
        raise InfeasibleError(f"climbing {run.name} to its goal", plan.blocked or "the goal is out of reach")
    where = f"to {plan.reached_m:.3f} m along the pipe"
    say(f"{_counted(plan.steps)} {where}, {plan.duration:.0f} s planned for {_about(machine, friction)}")
    session = ClimbSession(plan, run, machine, Layout.of(machine), (friction, friction), payload_kg, seed)
    end, answer = _climbed(session, pictures, video, out)
    emit(answer) if json else show_summary(answer)
    if end.why:
        how = "hanging safely with both grippers closed" if end.safe else "not at rest"
        raise Ended(f"the climb ended early, {how}: {end.why}; log and report are complete to there")


def _counted(steps: int) -> str:
    """A number of steps in words."""
    return f"{steps} step{'' if steps == 1 else 's'}"


def _friction(option: str, asked: float | None, machine: PipeClimber) -> float:
    """The coefficient, as asked for or else as declared."""
    friction, thinnest = machine.gripper.friction if asked is None else asked, machine.gripper.pipe_diameter[0]
    most = machine.build.jamming_friction(0.5 * thinnest)
    if not 0.0 < friction < most:
        valid = f"above 0, below {most:.4g}, where pads jam on a pipe of {1e3 * thinnest:g} mm"
        raise InputError(option, f"{friction:g}", valid)
    return friction


def _rubbing(machine: PipeClimber, mu: float | None) -> PipeClimber:
    """The machine with pads of a friction, if one is asked for."""
    gripper = machine.gripper
    friction = _friction("--mu", mu, machine)
    return msgspec.structs.replace(machine, gripper=msgspec.structs.replace(gripper, friction=friction))


def _about(machine: PipeClimber, friction: float) -> str:
    """What plan and physics count on, in words."""
    planned = machine.gripper.friction
    kept = f"mu = {planned:g} with {100.0 * machine.gait.reserve:.0f} % of the grip in reserve"
    return kept if friction == planned else f"{kept}; in physics mu = {friction:g}"


def _after_a_while() -> Callable[[str], None]:
    """Says what goes on, not before two seconds and every two at most."""
    last = time.monotonic()

    def tell(text: str) -> None:
        nonlocal last
        if time.monotonic() - last >= 2.0:
            last = time.monotonic()
            say(f"{text} ...")

    return tell


def _climbed(session: ClimbSession, pictures: bool, video: bool, out: Path) -> tuple[EndRecord, dict[str, Any]]:
    """Run it, report it; how it ended, and the answer of the command."""
    from steeplejack.report.climb import film_of, write_climb_report

    out.mkdir(parents=True, exist_ok=True)
    log, page = out / "climb.mcap", out / "climb.html"
    with bar("simulate", session.plan.duration) as step, writing(log), stoppable() as asked_to_stop:
        end = session.simulate(log, pictures, video, step, asked_to_stop)
    with bar("report", None), writing(page):
        summary = write_climb_report(log, page)
    answer = msgspec.to_builtins(summary) | {"log": str(log), "report": str(page)}
    film = film_of(log) if video else None
    if film is not None:
        path = out / "climb.webp"
        with writing(path):
            path.write_bytes(film)
        answer["video"] = str(path)
    return end, answer


def show_summary(answer: dict[str, Any]) -> None:
    """Print the answer of ``climb`` for a person."""
    way = answer["distance_m"]
    back = round(-1e3 * way)
    rows = {
        "climbed": f"nothing: slid back {back} mm" if back > 0 else f"{way:z.3f} m in {_counted(answer['steps'])}",
        "duration": f"{answer['duration_s']:.1f} s, {answer['mean_speed_mm_s']:.2f} mm/s on average",
        "largest actuator force": f"{answer['max_actuator_force_n']:.1f} N",
        "least transmission": f"{answer['min_transmission']:.3f}",
        "least friction left": _left(answer["min_friction_margin_moving"], answer["min_friction_margin"]),
        "slips": "not known" if answer["slips"] is None else answer["slips"],
        "collisions": answer["collisions"],
        "log": answer["log"],
        "report": answer["report"],
    } | {name: answer[name] for name in ("video",) if name in answer}
    for name, value in rows.items():
        print(f"{name:<24}{value}")


def _left(moving: float | None, least: float | None) -> str:
    """Friction left while one gripper moves the robot, and at other times where that is less."""
    if least is None:
        return "not measured"
    told = "" if moving is None else f"{moving:z.3f} while moving"
    return told if least == moving else ", ".join(filter(None, (told, f"{least:z.3f} otherwise")))
