"""The fastest climb over a run of pipes, or the furthest one with the limit that ends it and what would change that."""

from __future__ import annotations

from collections.abc import Callable

from steeplejack.planning.climb.lattice import build_lattice
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.phases import phases
from steeplejack.planning.climb.plan import ClimbPlan
from steeplejack.planning.climb.route import Found, search
from steeplejack.robots.pipe_climber.parameters import PipeClimber
from steeplejack.worksite.pipe_run import PipeRun

PARTS = (5, 10, 20)
"""Into how many parts lattices divide the stroke on a straight, coarsest first."""
STATES = 600_000
"""A finer lattice with more states than this is only searched where the coarser ones find no way."""
NO_STROKE = 0.005
"""[m] What stands for the stroke on a straight where the machine has none, to lay the lattice by."""


def plan_climb(
    run: PipeRun, robot: PipeClimber, payload_kg: float = 0.0, tell: Callable[[str], None] | None = None
) -> ClimbPlan:
    """Plan a climb from the run's start to its goal in the shortest time.

    Args:
        run: Pipes, obstacles, start and goal.
        robot: The machine; its cylinders' windows, speeds and forces, its servo's range and speed and its grippers'
            clearances are kept everywhere.
        payload_kg: Carried by the upper gripper [kg].
        tell: Called with what is looked for next, in words, where the goal cannot be reached.

    Returns:
        The plan; if the goal cannot be reached, the plan to the furthest place, with the reason.

    Raises:
        InputError: A payload that is no mass, a run too long to search.
    """
    machine = Machine.of(robot, payload_kg)
    found = climb(run, machine)
    if found.complete:
        return as_plan(run, machine, found, None)
    from steeplejack.planning.climb.blocked import explain  # it solves climbs itself

    return as_plan(run, machine, found, explain(run, machine, found, *(() if tell is None else (tell,))))


def as_plan(run: PipeRun, machine: Machine, found: Found, blocked: str | None) -> ClimbPlan:
    """The plan of a climb found on a lattice, with references in time."""
    start = found.standings[0].lower[1] if found.standings else run.start_s
    steps = phases(run, machine, found.standings)
    return ClimbPlan(run.name, machine.robot.name, steps, found.progress - start, found.complete, blocked)


def climb(run: PipeRun, machine: Machine, parts: tuple[int, ...] = PARTS) -> Found:
    """The best climb the lattices hold: the finest affordable one; where the first has no way to the goal, the last."""
    stroke = stroke_on_straights(machine)
    best: Found | None = None
    for number in parts:
        if best is not None and not best.complete and number != parts[-1]:
            continue
        lattice = build_lattice(run, machine, stroke / number)
        if best is not None and best.complete and lattice.joined.coaxial.size * lattice.near.size > STATES:
            break
        found = search(lattice)
        better = best is None or (found.complete, found.progress, -found.duration) > (
            best.complete, best.progress + 1e-9 * (not found.complete), -best.duration,
        )  # fmt: skip
        best = found if best is None or better else best
    assert best is not None
    return best


def stroke_on_straights(machine: Machine) -> float:
    """What lattices are laid by [m]."""
    least, largest = machine.straight_gaps
    return max(largest - least, NO_STROKE)
