"""Commands about machines and worksites: check, robots, worksites, warmup."""

from __future__ import annotations

import time

import typer

from steeplejack.cli.terminal import INFEASIBLE, Json, Robot, Worksite, bridge, emit, say
from steeplejack.planning import verdicts
from steeplejack.robots.pipe_climber import load_pipe_climber
from steeplejack.robots.squad import BUILT_IN, load_squad
from steeplejack.worksite import list_worksites
from steeplejack.worksite.pipe_builtin import list_pipes


def check(worksite: Worksite, robot: Robot = BUILT_IN, json: Json = False) -> None:
    """Does the machine fit the stays? Per stay, and why not."""
    site, squad = bridge(worksite), load_squad(robot)
    found = verdicts(site, squad)
    fit, unfit = (sum(verdict.fits is value for verdict in found) for value in (True, False))
    if json:
        stays = [{"id": v.stay, "fits": v.fits, "reasons": v.reasons, "unknown": v.unknown} for v in found]
        emit({"stays": stays, "fit": fit, "unfit": unfit, "undecided": len(found) - fit - unfit})
    else:
        for verdict in found:
            word = {True: "fits", False: "does not fit", None: "unknown"}[verdict.fits]
            why = ", ".join((*verdict.reasons, *(f"{name} unknown" for name in verdict.unknown)))
            print(f"{verdict.stay:<12} {word:<14}{why}".rstrip())
        print(f"{site.name}: {fit} fit, {unfit} do not, {len(found) - fit - unfit} undecided")
    if unfit == len(found):
        say(f"no stay of {site.name} fits {squad.name}: {found[0].reasons[0]}")
        raise typer.Exit(INFEASIBLE)


def robots(json: Json = False) -> None:
    """List the built-in robots with their sources."""
    machines = {
        load_squad().name: "Zheng et al., CCRobot-S, IEEE T-RO, presented at ICRA 2026; estimates marked in the file",
        load_pipe_climber().name: "Ye et al., Robotica 2024, doi 10.1017/S0263574724002133; estimates marked in it",
        load_pipe_climber(
            "pipe-climber-cross"
        ).name: "the same with long cylinders and wide tilt, an estimate: it crosses",
    }
    if json:
        emit({"robots": [{"name": name, "source": source} for name, source in machines.items()]})
    else:
        for name, source in machines.items():
            print(f"{name:<14} {source}")


def worksites(json: Json = False) -> None:
    """List the built-in worksites with their sources."""
    rows = (*list_worksites(), *list_pipes())
    if json:
        emit({"worksites": [{"name": r.name, "description": r.description, "source": r.source} for r in rows]})
    else:
        for row in rows:
            print(f"{row.name:<18} {row.description}\n{'':<18} {row.source}")


def warmup(json: Json = False) -> None:
    """Compile every kernel once, so that the first real command does not wait for it."""
    from steeplejack.simulation import warm

    began = time.perf_counter()
    warm()
    seconds = round(time.perf_counter() - began, 1)
    if json:
        emit({"seconds": seconds})
    else:
        print(f"kernels compiled and kept, {seconds} s")
