"""What grips bear, where masses are and where bars are: the robot's formulas against the physics built separately."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hung_climber import LAYOUT, ROBOT, hung, leaning
from scipy.optimize import brentq

from steeplejack.robots.pipe_climber.bars import linkage_bars, mechanism_bars
from steeplejack.robots.pipe_climber.pads import STRAIGHT, grip_body, grip_use, pad_row
from steeplejack.robots.pipe_climber.weights import first_moments, grip_loads
from steeplejack.simulation.climber.pipe import frame_at, solids_of
from steeplejack.simulation.climber.plant import ClimberPlant, Start
from steeplejack.simulation.climber.solids import Solid
from steeplejack.worksite.pipe_builtin import load_pipe
from steeplejack.worksite.pipe_line import laid

pytestmark = pytest.mark.long

Pull = tuple[float, float, float]
RADIUS = 0.03
POSE = (0.0, 0.17, 0.0, 0.0)
PIPES = {"lower": (-0.5, 0.06), "upper": (0.11, 2.0)}  # so short that the open gripper finds nothing to rest on


def moved(end: str, gravity: np.ndarray) -> float:
    """How far a gripper that holds alone has moved on its pipe after 0.75 s [m]."""
    low, high = PIPES[end]
    pipe = Solid("pipe", "cylinder", np.array([0.0, 0.0, low]), np.array([0.0, 0.0, high]), RADIUS)
    start = Start(np.eye(4), np.array(POSE), np.full(2, RADIUS), (end == "lower", end == "upper"))
    plant = ClimberPlant(ROBOT, LAYOUT, [pipe], gravity, start, (ROBOT.gripper.friction,) * 2)
    before = getattr(plant.truth(), end).copy()
    plant.advance(1500)
    return float(np.linalg.norm(getattr(plant.truth(), end)[:3, 3] - before[:3, 3]))


@pytest.mark.parametrize(("end", "clock"), [("lower", 0.5 * math.pi), ("upper", 0.5 * math.pi), ("upper", 0.9)])
def test_a_grip_slips_in_physics_where_its_use_passes_one(end: str, clock: float):
    leans = np.linspace(0.0, 0.5 * math.pi, 181)
    loads = np.array([grip_loads(ROBOT, LAYOUT, np.array(POSE), leaning(lean, clock)) for lean in leans])
    use = grip_use(grip_body(ROBOT, RADIUS), loads[:, 0 if end == "lower" else 1])
    held, lost = leans[np.flatnonzero(use < 0.93)[-1]], leans[int(np.argmax(use))]
    assert moved(end, leaning(float(held), clock)) < 3e-4
    if use.max() > 1.07:
        assert moved(end, leaning(float(lost), clock)) > 1e-3


BEND, ENTRY = 0.25, 0.105
"""Places of a gripper, whole in a bend that begins at 0.1 m and with its last row alone in it [m]."""


def held_in_a_bend(toward: float, place: float) -> tuple[np.ndarray, np.ndarray, list[Solid]]:
    """Frame of the lower gripper (4, 4), lines under its rows, and the pipe about it, none under the other gripper."""
    pieces = [(0.1, math.inf, 0.0, None), (0.3, 0.3, toward, None)]
    pipe = laid("bent", 2.0 * RADIUS, pieces, np.zeros(3), np.eye(3))
    frame = frame_at(pipe, place, 0.0, pad_row(ROBOT))
    lines = pipe.lines(place + pad_row(ROBOT) * np.array([-1.0, 1.0])) @ frame[:3, :3]
    run = replace(load_pipe("bend-300"), pipes=(pipe,), obstacles=(), crossings=())
    near = [one for one in solids_of(run) if np.linalg.norm(0.5 * (one.start + one.end) - frame[:3, 3]) < 0.075]
    return frame, lines, [one for one in near if one.kind == "pipe"]


@pytest.mark.parametrize(
    ("toward", "place", "pull", "straight"),
    [
        (0.0, BEND, (0.0, 0.0, -9.81), 0.245),
        (0.0, BEND, (-6.0, 0.0, -7.7), 0.193),
        (2.4, BEND, (0.0, -6.0, 7.7), 0.237),
        (0.0, ENTRY, (-6.0, 0.0, -7.7), 0.193),
        (math.pi, ENTRY, (-6.0, 0.0, -7.7), 0.193),
    ],
)
def test_in_a_bend_a_grip_slips_where_leaning_pads_say(toward: float, place: float, pull: Pull, straight: float):
    """Friction it takes by pads that lean, by pads on a straight, and in physics; pull in the gripper's frame.

    Where one row alone lies in the bend that row alone would ask for twice as much: the gripper gives way a little, and
    then all pads bear.
    """
    frame, lines, solids = held_in_a_bend(toward, place)
    load = grip_loads(ROBOT, LAYOUT, np.array(POSE), np.array(pull))[0]

    def over(friction: float, under: np.ndarray) -> float:
        rough = msgspec.structs.replace(ROBOT, gripper=msgspec.structs.replace(ROBOT.gripper, friction=friction))
        return float(grip_use(grip_body(rough, RADIUS, lines=under), load)) - 1.0

    asked = float(brentq(over, 0.05, 1.3, (lines,)))
    assert brentq(over, 0.05, 1.3, (STRAIGHT,)) == pytest.approx(straight, abs=1e-3)
    assert abs(asked / straight - 1.0) > 0.09
    gone: list[list[float]] = []
    for friction in (1.08 * asked, 0.93 * asked):
        start = Start(frame, np.array(POSE), np.full(2, RADIUS), (True, False))
        plant = ClimberPlant(ROBOT, LAYOUT, solids, frame[:3, :3] @ pull, start, (friction, friction))
        before, moved_by = plant.truth().lower[:3, 3].copy(), list[float]()
        for _ in range(2):
            plant.advance(750)
            moved_by.append(float(np.linalg.norm(plant.truth().lower[:3, 3] - before)))
        gone.append(moved_by)
    assert gone[0][1] < 1e-3 and abs(gone[0][1] - gone[0][0]) < 5e-5  # it has settled
    assert gone[1][1] > 1e-2


@pytest.mark.parametrize("pose", [(0.0, 0.15, 0.0, 0.0), (0.0, 0.2, 0.0, 0.4), (0.02, 0.17, 0.15, -0.3)])
def test_masses_and_bars_are_where_the_physics_has_them(pose: tuple[float, float, float, float]):
    plant = hung((True, True), pose)
    lower = plant.truth().lower
    mass, moment = first_moments(ROBOT, LAYOUT, np.array(pose))
    middle = lower[:3, :3].T @ (plant.data.subtree_com[1] - lower[:3, 3])
    np.testing.assert_allclose(moment / mass, middle, atol=5e-4)
    c, s = math.cos(pose[3]), math.sin(pose[3])
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    mechanism, radii = mechanism_bars(ROBOT, LAYOUT, pose[:3])
    ring, thick = linkage_bars(ROBOT, pose[3])
    bars = np.concatenate((mechanism[0] @ turn.T, ring[0])) @ lower[:3, :3].T + lower[:3, 3]
    model, data = plant.model, plant.data
    capsules = [k for k in range(model.ngeom) if model.geom_type[k] == 3 and model.geom_bodyid[k] > 0]
    half = np.array([model.geom_size[k, 1] * data.geom_xmat[k].reshape(3, 3)[:, 2] for k in capsules])
    ends = np.stack((data.geom_xpos[capsules] - half, data.geom_xpos[capsules] + half), axis=1)
    assert len(capsules) == len(bars)
    for bar, radius in zip(bars, np.concatenate((radii, thick)), strict=True):
        away = [min(np.abs(one - bar).max(), np.abs(one[::-1] - bar).max()) for one in ends]
        assert min(away) < 2e-3
        assert model.geom_size[capsules[int(np.argmin(away))], 0] == pytest.approx(radius)
