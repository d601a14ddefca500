"""A climber on a vertical pipe, and plans for it made by hand."""

from __future__ import annotations

import math

import numpy as np

from steeplejack.planning.climb.plan import ClimbPlan, Hold, Phase, Pose
from steeplejack.robots.pipe_climber import Layout, load_pipe_climber
from steeplejack.simulation.climber.plant import ClimberPlant, Start
from steeplejack.simulation.climber.run import ClimbRun
from steeplejack.simulation.climber.session import ClimbSession
from steeplejack.simulation.climber.solids import Solid
from steeplejack.simulation.climber.watch import Watch
from steeplejack.worksite.pipe_builtin import load_pipe
from steeplejack.worksite.pipe_run import PipeRun

ROBOT = load_pipe_climber()
LAYOUT = Layout.of(ROBOT)
RUN = load_pipe("straight-vertical")
GRAVITY = np.array([0.0, 0.0, -9.81])
LOW, STROKE, RAMP = 0.150, 0.050, 0.040


def hung(
    closed: tuple[bool, bool], pose: Pose = (0.0, 0.16, 0.0, 0.0), mu: float = 0.3, top: float = 2.0
) -> ClimberPlant:
    """A robot hanging still on a vertical pipe that ends at a height [m]."""
    pipe = Solid("pipe", "cylinder", np.array([0.0, 0.0, -0.5]), np.array([0.0, 0.0, top]), 0.03)
    start = Start(np.eye(4), np.array(pose), np.full(2, 0.03), closed)
    return ClimberPlant(ROBOT, LAYOUT, [pipe], GRAVITY, start, (mu, mu))


def travel(length: float, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and way of a move from rest to rest with constant acceleration."""
    duration = length / speed + RAMP
    times = np.linspace(0.0, duration, 200)
    rate = speed / RAMP
    middle = speed * (times - 0.5 * RAMP)
    first, last = 0.5 * rate * times**2, length - 0.5 * rate * (duration - times) ** 2
    return times, np.where(times < RAMP, first, np.where(times > duration - RAMP, last, middle))


def strides(count: int, s: float = 0.05, speed: float = ROBOT.cylinders.speed) -> ClimbPlan:
    """Full strokes straight up, grip and release in their declared time."""
    grip, phases = ROBOT.gripper.close_time, list[Phase]()
    low, high = (0.0, LOW, 0.0, 0.0), (0.0, LOW + STROKE, 0.0, 0.0)
    times, way = travel(STROKE, 0.999 * speed)

    def poses(w: np.ndarray) -> np.ndarray:
        return np.column_stack([0.0 * w, w, 0.0 * w, 0.0 * w])

    for _ in range(count):
        near, far = s + LOW, s + LOW + STROKE
        phases += [
            Phase("release-upper", Hold.LOWER, grip, low, low, s, near, 0.0, ""),
            Phase("move", Hold.LOWER, times[-1], low, high, s, near, 0.0, "", times, poses(LOW + way)),
            Phase("grip-upper", Hold.LOWER, grip, high, high, s, far, 0.0, ""),
            Phase("release-lower", Hold.UPPER, grip, high, high, s, far, 0.0, ""),
            Phase("move", Hold.UPPER, times[-1], high, low, s, far, 0.0, "", times, poses(LOW + STROKE - way)),
            Phase("grip-lower", Hold.UPPER, grip, low, low, s + STROKE, far, 0.0, ""),
        ]
        s += STROKE
    return ClimbPlan(RUN.name, ROBOT.name, tuple(phases), count * STROKE, True, None)


def turns(*angles: float, s: float = 0.05) -> ClimbPlan:
    """Turning about the pipe in place: the upper gripper by an angle [rad], then the lower one after it."""
    grip, phases, clock = ROBOT.gripper.close_time, list[Phase](), 0.0
    for angle in angles:
        times, way = travel(abs(angle), ROBOT.gait.turn_speed)
        upper, way = s + 0.16, np.sign(angle) * way
        still, turned = (0.0, 0.16, 0.0, 0.0), (0.0, 0.16, 0.0, angle)
        there, back = (np.column_stack([0.0 * way, 0.0 * way + 0.16, 0.0 * way, at]) for at in (way, angle - way))
        phases += [
            Phase("release-upper", Hold.LOWER, grip, still, still, s, upper, clock, ""),
            Phase("move", Hold.LOWER, times[-1], still, turned, s, upper, clock, "", times, there),
            Phase("grip-upper", Hold.LOWER, grip, turned, turned, s, upper, clock, ""),
            Phase("release-lower", Hold.UPPER, grip, turned, turned, s, upper, clock, ""),
            Phase("move", Hold.UPPER, times[-1], turned, still, s, upper, clock, "", times, back),
            Phase("grip-lower", Hold.UPPER, grip, still, still, s, upper, clock + angle, ""),
        ]
        clock += angle
    return ClimbPlan(RUN.name, ROBOT.name, tuple(phases), 0.0, True, None)


def started(
    plan: ClimbPlan, mu: float = 0.3, seed: int | None = None, run: PipeRun = RUN
) -> tuple[ClimbRun, ClimberPlant, Watch]:
    """A run that has not begun, its plant, and what watches it; sensors without errors unless there is a seed."""
    plant = ClimbSession(plan, run, ROBOT, LAYOUT, (mu, mu), seed=seed).plant()
    watch = Watch(plant, run, None)
    return ClimbRun(plan, run, ROBOT, LAYOUT, plant, watch), plant, watch


def leaning(lean: float, clock: float) -> np.ndarray:
    """Gravity on a pipe that leans, toward a clock of the robot (3,) [m/s2]."""
    return 9.81 * np.array([math.sin(lean) * math.cos(clock), math.sin(lean) * math.sin(clock), -math.cos(lean)])


def nothing(_time: float) -> None:
    """No progress to show."""
