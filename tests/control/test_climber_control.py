"""The climber's gait table and controller: never both grippers open, grips counted, loads shifted."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from steeplejack.control.climber import (
    FIRST,
    TRANSITIONS,
    Act,
    ClimberController,
    Measurement,
    Outcome,
    Reference,
    closed_in,
    taken_up,
)
from steeplejack.control.climber.jaws import open_place
from steeplejack.errors import InputError
from steeplejack.planning.climb.plan import Kind
from steeplejack.robots.pipe_climber import Layout, load_pipe_climber
from steeplejack.robots.pipe_climber.bearing import holding_forces
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.pads import pad_place
from steeplejack.robots.pipe_climber.weights import first_moments

ROBOT = load_pipe_climber()
LAYOUT = Layout.of(ROBOT)
STEP = 4e-3
POSES = [(0.0, 0.16, 0.0, 0.0), (0.015, 0.175, 0.12, 0.2), (-0.02, 0.18, -0.15, -0.4), (0.03, 0.145, 0.45, 0.0)]


def test_no_act_opens_both_grippers_and_every_act_ends() -> None:
    """Every act with everything a phase can want, and every way through the table."""
    wanted = {Act.MOVE: [(True, False), (False, True)], Act.CLOSE: [(True, True)]}
    for act in Act:
        for phase in wanted.get(act, [(True, False), (False, True), (True, True)]):
            for slipped in (0, 1):
                assert any(closed_in(act, phase, slipped))
    running = [act for act in Act if act not in (Act.DONE, Act.STOPPED)]
    for act in running:
        assert TRANSITIONS[act, Outcome.FAILED] is Act.STOPPED
        assert (act, Outcome.REACHED) in TRANSITIONS
    assert {act for act, _ in TRANSITIONS} == set(running)


def test_every_kind_of_phase_has_a_beginning_and_is_taken_up_after_a_rescue() -> None:
    assert set(FIRST) == set(get_args(Kind))
    assert [taken_up(kind) for kind in ("move", "grip-upper", "release-lower")] == [Act.MOVE, Act.CLOSE, Act.OPEN]


def test_both_grippers_hold_while_the_load_is_shifted() -> None:
    assert closed_in(Act.SHIFT, (True, False), 0) == (True, True)
    assert TRANSITIONS[Act.SHIFT, Outcome.REACHED] is Act.OPEN


def measured(**changes: object) -> Measurement:
    values = {
        "lengths": np.full(3, 0.18), "forces": np.zeros(3), "beta": 0.0, "jaws": np.full(2, 0.0316),
        "grip": np.full(2, 40.0), "passed": np.zeros((2, 2)),
        "gravity": np.array([0.0, 0.0, -9.81]),
    }  # fmt: skip
    return Measurement(**{**values, **changes})  # pyright: ignore[reportArgumentType]


def holding(lower: bool, upper: bool, **changes: object) -> Reference:
    plain = Reference(np.full(3, 0.18), np.zeros(3), 0.0, 0.0, np.array([lower, upper]), np.full(2, 0.03))
    return replace(plain, **changes)  # pyright: ignore[reportArgumentType]


def test_a_grip_counts_by_its_force_and_is_seen_to_slip() -> None:
    controller, hold = ClimberController(ROBOT), holding(True, False)
    weak = measured(grip=np.array([30.0, 0.0]))
    state, _, status = controller.step(controller.begin(weak), hold, weak, STEP)
    assert not status.held.any()
    state, command, status = controller.step(state, hold, measured(), STEP)
    assert status.held.tolist() == [True, False] and not status.slipping.any()
    assert np.abs(command.speeds).max() < 1e-12
    along, around = np.array([[-6e-4, 0.0], [0.0, 0.0]]), np.array([[-4e-4, 4e-4], [0.0, 0.0]])
    for passed in (along, around):
        _, _, status = controller.step(state, hold, measured(passed=passed), STEP)
        assert status.slipping.tolist() == [True, False]


def test_cylinders_keep_their_speed_and_stop_on_nonsense() -> None:
    controller = ClimberController(ROBOT)
    far = holding(True, False, lengths=np.full(3, 0.20), rates=np.full(3, 0.017))
    begun = controller.begin(measured())
    _, command, status = controller.step(begun, far, measured(), STEP)
    assert np.abs(command.speeds).max() == pytest.approx(ROBOT.cylinders.speed)
    assert status.lost
    for changes in ({"lengths": np.array([np.nan, 0.18, 0.18])}, {"passed": np.full((2, 2), np.inf)}, {"beta": np.nan}):
        _, command, status = controller.step(begun, far, measured(**changes), STEP)
        assert not status.readable and command.closed.all() and not command.speeds.any()


def test_between_two_grips_cylinders_give_way_to_the_load_they_should_have() -> None:
    controller = ClimberController(ROBOT)
    state = controller.begin(measured(forces=np.array([5.0, 5.0, 0.0])))
    squeezed = measured(forces=np.array([9.0, 5.0, 0.0]))
    _, command, status = controller.step(state, holding(True, True), squeezed, STEP)
    assert command.speeds[0] < 0.0 and not command.speeds[1:].any()  # pushes too hard: shortens
    assert status.burden == pytest.approx(4.0) and not status.lost
    wanted = np.array([-7.0, -7.0, 2.0])
    for lower in (True, False):  # also while one opens
        _, command, status = controller.step(state, holding(lower, True, load=wanted), squeezed, STEP)
        assert (np.sign(command.speeds) == [-1, -1, 1]).all() and status.burden == pytest.approx(16.0)


@pytest.mark.parametrize("freedoms", POSES)
@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (-6.0, 2.0, -7.0)])
def test_holding_forces_balance_the_weight_of_either_half(
    freedoms: tuple[float, ...], gravity: tuple[float, ...]
) -> None:
    """Virtual work: with either gripper fixed, moving the mechanism slowly costs what the weight gains."""
    given, pull, payload = np.array(freedoms), np.array(gravity), 0.3
    rows, forces = jacobian(LAYOUT, given[:3]), holding_forces(ROBOT, LAYOUT, given, pull, payload)

    def gained(pose: np.ndarray, upper_fixed: bool) -> float:
        """Work of gravity since the world's frame, the lower gripper's at `given`."""
        mass, moment = first_moments(ROBOT, LAYOUT, pose, payload)
        if not upper_fixed:
            return float(moment @ pull)
        carry = frame(given) @ np.linalg.inv(frame(pose))  # of the lower gripper, with the upper one where it was
        return float((carry[:3, :3] @ moment + mass * carry[:3, 3]) @ pull)

    for end in range(2):
        for axis in range(3):
            step = 1e-6 * np.eye(4)[axis]
            slope = (gained(given + step, bool(end)) - gained(given - step, bool(end))) / 2e-6
            assert rows[:, axis] @ forces[end] + slope == pytest.approx(0.0, abs=1e-6 * 30.0)


def frame(freedoms: np.ndarray) -> np.ndarray:
    from steeplejack.robots.pipe_climber.grippers import free_gripper

    return free_gripper(freedoms, ROBOT.linkage.claw_offset)


def test_pads_wedge_a_pipe_and_cannot_hold_a_wire() -> None:
    place = pad_place(ROBOT, 0.03)
    reach = 0.03 + ROBOT.build.pad_radius
    assert np.hypot(place, 0.5 * ROBOT.build.jaw_width) == pytest.approx(reach)
    assert open_place(ROBOT, 0.03) - place == pytest.approx(ROBOT.build.jaw_clearance)
    with pytest.raises(InputError, match="pipe radius"):
        pad_place(ROBOT, 0.009)
