"""A plan replayed in kinematics: every reference against every limit, from the phases alone.

Nothing of the search is used. The closed gripper's frame follows from the run, the open one's by the chain of four
freedoms; cylinder lengths, speeds, tilt, turn, forces and singularities are those of the sampled poses, the last proved
along the straight pieces between them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import InputError
from steeplejack.planning.climb.frames import gripper_frames, touching, worst_uses
from steeplejack.planning.climb.gait import BEARS, after
from steeplejack.planning.climb.limits import LIMITS, Machine, margins
from steeplejack.planning.climb.places import passes, trouble
from steeplejack.planning.climb.plan import ClimbPlan, Hold, Phase
from steeplejack.planning.climb.solids import obstacles_of
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.parameters import PipeClimber
from steeplejack.robots.pipe_climber.singular_path import check_waypoints
from steeplejack.worksite.pipe_run import PipeRun

Array = NDArray[np.float64]

OFF_AXIS, OFF_TANGENT = 2e-4, 1e-3
"""How far an open gripper may leave the centre line [m] and its tangent [1] between two samples of a reference."""
LENGTH = 2e-6
"""How far a cylinder may leave its window between two places of the lattice [m]; a screw is no more exact."""
USE = 1e-3
"""By how much the use of a grip or a drive may exceed 1 between two places of the lattice [1]."""
NEARER = 10
"""Steps along the tangent to the place nearest a point; each cubes what is missing, in parts of a bend's radius."""
SPEED = 1e-3
"""In parts of a speed limit [1]."""


def faults(plan: ClimbPlan, run: PipeRun, robot: PipeClimber, payload_kg: float = 0.0) -> list[str]:
    """Everything in a plan that breaks a limit, an order of acts or a rule of clearance; empty for a sound plan."""
    machine = Machine.of(robot, payload_kg)
    found: list[str] = []
    hold = Hold.BOTH
    for number, phase in enumerate(plan.phases):
        try:
            if phase.hold is not BEARS.get((hold, phase.kind)):
                found.append(f"phase {number}: {phase.kind} with {phase.hold.value} holding")
            hold = after(hold, phase.kind)
        except InputError as error:
            return [*found, f"phase {number}: {error}"]
        found += [f"phase {number}: {fault}" for fault in _phase(phase, run, machine)]
    for number, (one, following) in enumerate(zip(plan.phases, plan.phases[1:], strict=False)):
        if np.abs(np.subtract(one.end, following.start)).max() > 1e-9:
            found.append(f"phase {number}: ends elsewhere than the next begins")
    return found if hold is Hold.BOTH else [*found, "the plan ends with one gripper open"]


def _phase(phase: Phase, run: PipeRun, machine: Machine) -> list[str]:
    found = [] if phase.kind == "move" else _grip(phase, run, machine)
    if phase.kind != "move":
        return found
    freedoms = phase.poses
    if np.abs(np.subtract(freedoms[[0, -1]], [phase.start, phase.end])).max() > 1e-7:
        found.append("the reference begins or ends elsewhere than the phase")
    found += _limits(phase, machine) + _speeds(phase, machine)
    if len(freedoms) > 1 and np.ptp(freedoms[:, :3], axis=0).max() > 0.0:
        verdict = check_waypoints(machine.layout, freedoms[:, :3]).verdict
        found += [] if verdict == "free" else [f"singularity: {verdict}"]
    return found + _borne(phase, run, machine) + _collisions(phase, run, machine) + _clearances(phase, run, machine)


def _borne(phase: Phase, run: PipeRun, machine: Machine) -> list[str]:
    """The gripper that holds alone and the drives bear weight and inertia throughout."""
    frames = _frames(phase, run, machine, phase.poses, phase.hold)
    places = ((phase.pipe_lower, phase.s_lower), (phase.pipe_upper, phase.s_upper))
    uses = worst_uses(run, machine, frames, phase.poses, places, phase.hold)
    whats = (f"the {phase.hold.value} gripper slips or tilts", "a cylinder is too weak", "the servo is too weak")
    return [
        f"{what}: {use:.4f} of what a plan may use"
        for what, use in zip(whats, uses, strict=True)
        if not use <= 1.0 + USE
    ]


def _collisions(phase: Phase, run: PipeRun, machine: Machine) -> list[str]:
    """No bar of the robot touches a pipe or an obstacle; between two pipes the linkage is open."""
    lowers, _uppers = _frames(phase, run, machine, phase.poses, phase.hold)
    hits = touching(obstacles_of(run), machine, lowers, phase.poses, 0.0, not phase.crosses)
    return [f"a bar touches a pipe or an obstacle at {int(hits.sum())} samples"] if hits.any() else []


def _grip(phase: Phase, run: PipeRun, machine: Machine) -> list[str]:
    """A gripper closes or opens where both may be closed."""
    found: list[str] = []
    for name, s in ((phase.pipe_lower, phase.s_lower), (phase.pipe_upper, phase.s_upper)):
        why = [what for what, at in trouble(run, machine, run.pipe(name), np.array([s])) if at[0]]
        found += [f"a gripper closed at {s:g} m: {what}" for what in why]
    both = _frames(phase, run, machine, np.array([phase.start]), Hold.LOWER)[1][0]
    point, frame = run.pipe(phase.pipe_upper).chord(phase.s_upper, machine.row)
    off = max(float(np.abs(both[:3, 3] - point).max()), float(np.abs(both[:3, 2] - frame[:, 2]).max()))
    return [*found, f"the upper gripper is {off:g} off its pipe"] if off > 1e-6 else found


def _frames(phase: Phase, run: PipeRun, machine: Machine, freedoms: Array, closed: Hold) -> tuple[Array, Array]:
    """World frames (k, 4, 4) of the lower and upper gripper during a phase."""
    lower = (phase.pipe_lower, phase.s_lower, phase.clock)
    return gripper_frames(run, machine, lower, np.array(phase.start), freedoms, closed)


def _limits(phase: Phase, machine: Machine) -> list[str]:
    """Lengths, tilt, hinges and singularity at every sample, and the linkage's turn."""
    kept = margins(_eased(machine), phase.poses[:, :3])
    found = [f"{limit} by {-low:g}" for limit, low in zip(LIMITS, kept.min(axis=0), strict=True) if low < -1e-9]
    if np.abs(phase.poses[:, 3]).max() > machine.robot.rcm.limit + 1e-6:
        found.append("linkage turned beyond its range")
    return found


def _eased(machine: Machine) -> Machine:
    """The machine with windows wider by what a way may miss them."""
    return replace(machine, shortest=machine.shortest - LENGTH, longest=machine.longest + LENGTH)


def _speeds(phase: Phase, machine: Machine) -> list[str]:
    """Speeds of cylinders and linkage between samples."""
    if len(phase.times) < 2:
        return []
    steps = np.diff(phase.times)
    lengths = limb_lengths(machine.layout, phase.poses[:, :3])
    fastest = float((np.abs(np.diff(lengths, axis=0)) / steps[:, None]).max())
    turning = float((np.abs(np.diff(phase.poses[:, 3])) / steps).max())
    found: list[str] = []
    if fastest > machine.robot.cylinders.speed * (1.0 + SPEED):
        found.append(f"a cylinder at {fastest:g} m/s")
    if turning > machine.robot.gait.turn_speed * (1.0 + SPEED):
        found.append(f"the linkage at {turning:g} rad/s")
    return found


def _clearances(phase: Phase, run: PipeRun, machine: Machine) -> list[str]:
    """The open gripper stays about its pipe and clear of what stands on it, unless it crosses to another one."""
    lowers, uppers = _frames(phase, run, machine, phase.poses, phase.hold)
    open_lower = phase.hold is Hold.UPPER
    frames, name, s = (
        (lowers, phase.pipe_lower, phase.s_lower) if open_lower else (uppers, phase.pipe_upper, phase.s_upper)
    )
    if phase.crosses:  # within the plane of the pipes, where the palm is not
        return []
    pipe = run.pipe(name)
    places = _nearest(run, name, frames[:, :3, 3], s, machine.row)
    points, lines = pipe.chord(places, machine.row)
    off = np.linalg.norm(frames[:, :3, 3] - points, axis=-1)
    lean = np.linalg.norm(frames[:, :3, 2] - lines[:, :, 2], axis=-1)
    if off.max() > OFF_AXIS or lean.max() > OFF_TANGENT:
        return [f"the open gripper leaves its pipe by {off.max():g} m and {lean.max():g} rad"]
    seen = np.einsum("kij,ki->kj", lines, frames[:, :3, 0])
    clocks = np.arctan2(seen[:, 1], seen[:, 0])
    near = np.flatnonzero(~np.diagonal(passes(run, machine, pipe, places, clocks)))
    touching = [not _free(run, machine, name, float(places[k]), float(clocks[k])) for k in near]
    return ["the open gripper's palm meets something"] if any(touching) else []


def _free(run: PipeRun, machine: Machine, name: str, place: float, clock: float) -> bool:
    """Whether an open gripper passes a place, or would a micrometre or a microradian beside it."""
    nudges = ((0.0, 0.0), (1e-6, 0.0), (-1e-6, 0.0), (0.0, 1e-6), (0.0, -1e-6))
    pipe = run.pipe(name)
    return any(
        bool(passes(run, machine, pipe, np.array([place + ahead]), np.array([clock + turn]))[0, 0])
        for ahead, turn in nudges
    )


def _nearest(run: PipeRun, name: str, points: Array, s: float, row: float) -> Array:
    """Places of a pipe nearest to points, from one near them on, (k,) [m]."""
    places = np.full(len(points), s)
    for _ in range(NEARER):
        at, frame = run.pipe(name).chord(places, row)
        places = places + ((points - at) * frame[..., 2]).sum(axis=-1)
    return places
