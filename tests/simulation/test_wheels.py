"""Wheels hold and pull up to what they can: traction, brake, and the brake let go again."""

import numpy as np
import pytest

from steeplejack.runtime import Command

BASE = 1


def rolling(case):
    """A squad with the palms of one base open, its command, and the pull of its cable along the stay [N]."""
    plant = case.plant(0, 0)
    plant.palm[BASE] = 0.0
    plant._set_friction()
    grip = np.ones(4, bool)
    grip[BASE] = False
    order = Command(plant.tensions.copy(), np.zeros(4), np.zeros(4), grip, np.ones(4, bool))
    truth = plant.truth()
    end = truth.position + truth.rotation @ np.array(case.squad.platform.attachments[BASE])
    towards = end - truth.exits[BASE]
    pull = truth.tension[BASE] * float(towards / np.linalg.norm(towards) @ plant.rails[BASE].axes[:, 0])
    return plant, order, pull


def moved(plant, order: Command, push: float) -> float:
    """How far the base gets along its stay [m] in 0.2 s under an outer force [N]."""
    before = plant.s[BASE]
    plant.data.qfrc_applied[plant._along_dof[BASE]] = push
    plant.apply(order)
    plant.advance(400)
    return float(plant.s[BASE] - before)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("asked", [1.0, 10.0])
def test_traction_ends_where_the_wheels_slip(case, sense: float, asked: float) -> None:
    """Against 5 % less than the wheels hold a base climbs, against 5 % more it is pushed back, whatever is asked."""
    most = case.squad.base.drive_force
    for share, forward in ((0.95, True), (1.05, False)):
        plant, order, pull = rolling(case)
        order.drive[BASE] = sense * asked * most
        way = sense * moved(plant, order, -sense * share * most - pull)
        assert (way > 1e-3) == forward
        assert (way < -1e-3) != forward


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_wheel_brake_holds_to_its_limit(case, sense: float) -> None:
    for share, slips in ((0.97, False), (1.05, True)):
        plant, order, pull = rolling(case)
        order.wheel_brake[BASE] = True
        way = moved(plant, order, sense * share * case.squad.base.wheel_brake - pull)
        assert (abs(way) > 1e-3) == slips


def test_a_wheel_brake_lets_go_when_it_is_opened(case) -> None:
    plant, order, pull = rolling(case)
    order.wheel_brake[BASE] = True
    assert abs(moved(plant, order, 50.0 - pull)) < 1e-4
    order.wheel_brake[BASE] = False
    assert moved(plant, order, 50.0 - pull) > 1e-2
