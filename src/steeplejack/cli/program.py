"""The program: its commands with an example each, and what becomes of their failures."""

from __future__ import annotations

import errno
import os
import sys

import typer

from steeplejack.cli import (
    anchors,
    climb,
    climber,
    climber_design,
    grasp,
    inspect,
    lost,
    mobility,
    plane,
    sites,
    tension_map,
)
from steeplejack.cli.terminal import BAD_INPUT, CLOSED_PIPE, ENDED_EARLY, INFEASIBLE, INTERRUPTED, Ended, emit, say
from steeplejack.errors import InfeasibleError, SteeplejackError

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Robots that climb tall structures with parallel mechanisms: check, plan, simulate, inspect, report.",
)
COMMANDS = {
    "check": (sites.check, "steeplejack check sutong-like"),
    "inspect": (inspect.inspect, "steeplejack inspect ecs620-like --fan T1L-main --stays 5:9"),
    "report": (inspect.report, "steeplejack report out/run.mcap --out out"),
    "map": (tension_map.tension_map, "steeplejack map table-iii --phi-deg 50 --step-m 0.01 --out out"),
    "anchors": (anchors.anchors, "steeplejack anchors table-iii --path eq28 --move 1,2,3,4 --window-m 0.05"),
    "grasp": (
        grasp.grasp,
        "steeplejack grasp table-iii --stay 3 --x-m -0.1 --half-width-m 0.03 --half-length-m 0.05 --phi-deg 50",
    ),
    "pose": (plane.pose, "steeplejack pose table-iii --lengths-m 0.32825749 0.37297465 0.39453155 0.43263676"),
    "tensions": (plane.tensions, "steeplejack tensions table-iii --pose -0.1 0.45 50 --mass-kg 8 --tension-n 10 250"),
    "lost-cable": (
        lost.lost_cable,
        "steeplejack lost-cable table-iii --pose -0.23074604 0.55283179 50 --cable 2 --mass-kg 30",
    ),
    "grip": (plane.grip, "steeplejack grip --radius-m 0.05 --inclination-deg 45 --palm-m 0.09 --sign +"),
    "climb": (climb.climb, "steeplejack climb straight-vertical --out out"),
    "legs": (climber.legs, "steeplejack legs --pose 0.020 0.150 0"),
    "platform": (climber.platform, "steeplejack platform --q-m 0.159765453 0.177552809 0.151327460"),
    "motion": (climber.motion, "steeplejack motion eq27 --hz-m 0.1 --at 5"),
    "singularity": (climber.singularity, "steeplejack singularity --alpha-deg -30 --out out"),
    "mobility": (mobility.mobility, "steeplejack mobility --dims 0.100 0.100 0.075 0.075"),
    "reach": (climber_design.reach, "steeplejack reach --alpha-deg 0 --step-m 0.001 --joint-neutral home --out out"),
    "transmission": (
        climber_design.transmission,
        "steeplejack transmission --alpha-deg 0 --step-m 0.001 --rectangle -0.05 0.05 0.13 0.2 --out out",
    ),
    "dimensions": (
        climber_design.dimensions,
        "steeplejack dimensions --rectangle -0.05 0.05 0.13 0.2 --scale l1 --step 0.01 --out out",
    ),
    "robots": (sites.robots, "steeplejack robots"),
    "worksites": (sites.worksites, "steeplejack worksites"),
    "warmup": (sites.warmup, "steeplejack warmup"),
}
VALID = {
    errno.ENOSPC: "a disk with room",
    errno.EDQUOT: "a disk with room",
    errno.EACCES: "a file you have permission for",
    errno.EPERM: "a file you have permission for",
    errno.ENOENT: "a file that exists",
    errno.EISDIR: "a file, not a folder",
}
for _name, (_command, _example) in COMMANDS.items():
    app.command(_name, epilog=f"Example: {_example}")(_command)


def main() -> None:
    """Run the command line; every foreseeable failure is one line and its exit code."""
    try:
        code = _run()
        sys.stdout.flush()
    except BrokenPipeError:  # whoever read the output has gone
        _drop_output()
        code = CLOSED_PIPE
    except OSError as error:
        _drop_output()
        say(f"{error.filename or 'output'}: {error.strerror or error}; {_valid(error)}")
        code = BAD_INPUT
    sys.exit(code)


def _run() -> int:
    """The exit code of the command; of what went wrong, only failures of the operating system and bugs come out."""
    try:
        code = app(standalone_mode=False)
    except OSError:
        raise
    except (typer.Abort, KeyboardInterrupt):
        code = INTERRUPTED
    except Exception as error:
        code, text = _failure(error)
        if isinstance(error, InfeasibleError) and "--json" in sys.argv:
            emit({"feasible": False, "what": error.what, "binding": error.binding})
        say(text.replace("\n", " "))
    if code == INTERRUPTED:
        say("interrupted")
    return code if isinstance(code, int) else 0


def _failure(error: Exception) -> tuple[int, str]:
    """Exit code and line of a foreseeable failure; raises what nobody foresaw."""
    if isinstance(error, Ended):
        return ENDED_EARLY, str(error)
    if isinstance(error, InfeasibleError):
        return INFEASIBLE, f"no feasible answer: {error}"
    if isinstance(error, SteeplejackError):
        return BAD_INPUT, str(error)
    usage = getattr(error, "format_message", None)  # of the option parser, whose errors have no public base
    if usage is None:
        raise error
    return BAD_INPUT, f"{usage() or 'no command given'}; see --help"


def _valid(error: OSError) -> str:
    """What would have been valid where the operating system refused."""
    return VALID.get(error.errno or 0, "a file that can be read, in a place that can be written to")


def _drop_output() -> None:
    """Leave nothing that the interpreter would write on its way out to an output that is closed or full."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
