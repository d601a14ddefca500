"""The command line: composes the rooms into commands. Names, keys and exit codes are a contract for scripts."""

from __future__ import annotations

import sys
from typing import NoReturn

import typer

from steeplejack.cli import inspect, plane, sites
from steeplejack.cli.terminal import BAD_INPUT, ENDED_EARLY, INFEASIBLE, INTERRUPTED, Ended, emit
from steeplejack.errors import InfeasibleError, InputError

__all__ = ["app", "main"]

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
    "map": (plane.tension_map, "steeplejack map table-iii --phi-deg 50 --step-m 0.01 --out out"),
    "pose": (plane.pose, "steeplejack pose table-iii --lengths-m 0.32825749 0.37297465 0.39453155 0.43263676"),
    "tensions": (plane.tensions, "steeplejack tensions table-iii --pose -0.1 0.45 50 --mass-kg 8 --tension-n 10 250"),
    "grip": (plane.grip, "steeplejack grip --radius-m 0.05 --inclination-deg 45 --palm-m 0.09 --sign +"),
    "robots": (sites.robots, "steeplejack robots"),
    "worksites": (sites.worksites, "steeplejack worksites"),
    "warmup": (sites.warmup, "steeplejack warmup"),
}
for _name, (_command, _example) in COMMANDS.items():
    app.command(_name, epilog=f"Example: {_example}")(_command)


def main() -> None:
    """Run the command line; every foreseeable failure is one line and its exit code."""
    try:
        code = app(standalone_mode=False)
    except InputError as error:
        _fail(str(error), BAD_INPUT)
    except InfeasibleError as error:
        if "--json" in sys.argv:
            emit({"feasible": False, "what": error.what, "binding": error.binding})
        _fail(f"no feasible answer: {error}", INFEASIBLE)
    except Ended as error:
        _fail(str(error), ENDED_EARLY)
    except (typer.Abort, KeyboardInterrupt):
        _fail("interrupted", INTERRUPTED)
    except Exception as error:
        text = getattr(error, "format_message", None)
        if text is None:
            raise
        _fail(f"{text() or 'no command given'}; see --help", BAD_INPUT)  # usage errors of the option parser
    sys.exit(code if isinstance(code, int) else 0)


def _fail(text: str, code: int) -> NoReturn:
    print(text.replace("\n", " "), file=sys.stderr)
    sys.exit(code)
