"""Machines, and trials of plans on random runs: every plan is replayed, every refusal attacked by sampling.

`python tests/planning/climb_cases.py trials.jsonl` tries 500 random runs with the oracle of `oracle_sampler`. Begun
again it goes on with the runs that the file does not have.
"""

from __future__ import annotations

import json
import math
import sys
import time
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from oracle_audit import disagreements
from oracle_sampler import Sampler

from steeplejack.planning.climb import ClimbPlan, faults
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.planner import as_plan, climb
from steeplejack.robots.pipe_climber import PipeClimber, load_pipe_climber
from steeplejack.worksite.pipe_generate import random_pipes
from steeplejack.worksite.pipe_run import PipeRun, build_run

ROBOT = load_pipe_climber()
PARTS = (5,)  # of the stroke; where sampling beats this the planner is asked with all of its lattices
FURTHER = 0.003  # [m] by which sampling may come further: what a cell of the finest lattice is


def changed(robot: PipeClimber, table: str, **values: object) -> PipeClimber:
    return msgspec.structs.replace(robot, **{table: msgspec.structs.replace(getattr(robot, table), **values)})


def analysed(tilt_deg: float = 30.0, claw_offset: float = 0.0) -> PipeClimber:
    """The mechanism as the paper analyses it: every cylinder free over the reach of 120 to 240 mm."""
    robot = changed(ROBOT, "cylinders", retracted=(0.12, 0.12, 0.12), stroke=0.12)
    robot = changed(robot, "joints", limit=math.radians(tilt_deg) * (1.0 + 1e-9))
    return changed(robot, "linkage", claw_offset=claw_offset)


def random_run(seed: int) -> PipeRun:
    return build_run(random_pipes(np.random.default_rng(seed), f"random-{seed}"), f"random-{seed}")


def attacked(sampler: Sampler, plan: ClimbPlan, tries: int, enough: float = math.inf) -> float:
    """How far sampling comes from every standing of a plan that was refused, or at least [m]."""
    states = [
        (phase.s_lower, phase.s_upper, phase.clock, phase.clock + phase.start[3])
        for phase in plan.phases
        if phase.kind.startswith("release") and phase.pipe_lower == phase.pipe_upper == "main"
    ]
    if plan.phases and plan.phases[-1].pipe_lower == plan.phases[-1].pipe_upper == "main":
        last = plan.phases[-1]
        states.append((last.s_lower, last.s_upper, last.clock, last.clock + last.end[3]))
    return sampler.furthest(tries, states + sampler.begun(), enough)


def trial(seed: int, tries: int) -> dict[str, Any]:
    """One random run: whether it is climbed, how far plan and sampling come, and what is wrong with the answer."""
    run = random_run(seed)
    machine = Machine.of(ROBOT)
    plan = as_plan(run, machine, climb(run, machine, PARTS), None)
    far, reached = -math.inf, run.start_s + plan.reached_m
    wrong: list[str] = []
    if not plan.complete:
        sampler = Sampler(run, ROBOT, np.random.default_rng(seed))
        far = attacked(sampler, plan, tries, reached + FURTHER)
        wrong += disagreements(sampler.rules, np.random.default_rng(seed))
        if far > reached + FURTHER:
            plan = as_plan(run, machine, climb(run, machine), None)
            reached = run.start_s + plan.reached_m
            afresh = Sampler(run, ROBOT, np.random.default_rng(seed))
            far = max(far, attacked(afresh, plan, tries, reached + FURTHER))
    wrong += faults(plan, run, ROBOT)
    if not plan.complete and far > reached + FURTHER:
        wrong.append(f"sampling comes to {far:.4f} m, the plan to {reached:.4f} m")
    return {
        "seed": seed,
        "climbed": plan.complete,
        "reached_m": reached,
        "sampled_m": max(far, reached),
        "wrong": wrong,
    }


CRIPPLED = {
    "does not turn": changed(ROBOT, "rcm", limit=1e-3),
    "steps over nothing": changed(ROBOT, "gait", clearance=1e-3, relief=1e-3),
    "short steps": changed(ROBOT, "cylinders", stroke=0.035),
    "wrong clearance": changed(ROBOT, "gait", clearance=0.008, relief=0.012),
}
"""Machines that plan less than the real one can do: what they refuse wrongly the sampling has to notice."""


def noticed(seed: int, crippled: PipeClimber, tries: int) -> bool | None:
    """Whether sampling comes further on a random run than a crippled planner; None if that refuses nothing wrongly."""
    run = random_run(seed)
    able, less = (climb(run, Machine.of(robot), PARTS) for robot in (ROBOT, crippled))
    if less.complete or able.progress < less.progress + FURTHER:
        return None
    plan = as_plan(run, Machine.of(crippled), less, None)
    enough = less.progress + FURTHER
    return attacked(Sampler(run, ROBOT, np.random.default_rng(seed)), plan, tries, enough) > enough


def run_trials(path: Path, first: int, count: int, tries: int) -> None:
    """Trials of a range of seeds, one line of JSON each; those that a file has already are not run again."""
    lines = path.read_text().splitlines() if path.exists() else []
    done = {found["seed"]: found for found in map(json.loads, lines)}
    for seed in range(first, first + count):
        if seed in done:
            continue
        began = time.process_time()
        done[seed] = trial(seed, tries) | {"seconds": time.process_time() - began}
        with path.open("a") as file:
            file.write(json.dumps(done[seed]) + "\n")
        if done[seed]["wrong"]:
            print(done[seed], flush=True)
    found = [done[seed] for seed in range(first, first + count)]
    climbed, sound = (
        sum(map(bool, column)) for column in zip(*((one["climbed"], not one["wrong"]) for one in found), strict=True)
    )
    spent = sum(one["seconds"] for one in found)
    print(f"{climbed} of {count} climbed, the rest refused, {sound} answers confirmed; {spent:.0f} s of one core")


if __name__ == "__main__":
    run_trials(Path(sys.argv[1]), *(int(word) for word in sys.argv[2:5] or (0, 500, 1800)))
