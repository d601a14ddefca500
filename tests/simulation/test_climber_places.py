"""Where grippers sit on a pipe, how moves make up for where they are, and what is filmed."""

from __future__ import annotations

import io
import math
from dataclasses import replace
from typing import cast

import mujoco
import numpy as np
import pytest
from hung_climber import LAYOUT, ROBOT, RUN, hung, strides
from PIL import Image

from steeplejack.planning.climb.plan import Phase
from steeplejack.robots.pipe_climber.grippers import free_gripper
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.pads import BOTH, FIRST, pad_row
from steeplejack.simulation.climber.camera import FRAMES, Camera, Film, Strip
from steeplejack.simulation.climber.odometry import Odometer
from steeplejack.simulation.climber.pipe import clearing, frame_at, resting
from steeplejack.simulation.climber.reference import MoveReference
from steeplejack.worksite.pipe_builtin import load_pipe

STEP = 4e-3
ROW = pad_row(ROBOT)


def test_a_gripper_sits_on_the_chord_of_a_bend() -> None:
    """row^2 / 2R inside the centre line; on a straight on the line itself; half of each where one meets the other."""
    bend = load_pipe("bend-300").pipes[0]
    point, axes = bend.centre_line(0.55)
    seat = frame_at(bend, 0.55, 0.0, ROW)
    inward = (seat[:3, 3] - point) @ axes[:, 0]
    assert inward == pytest.approx(0.3 * (1.0 - math.cos(ROW / 0.3)), rel=1e-6)
    assert np.allclose(seat[:3, :3], axes, atol=1e-9)
    joint = frame_at(bend, 0.35, 0.4, ROW)
    lean = math.acos(joint[:3, 2] @ bend.centre_line(0.35)[1][:, 2])
    assert lean == pytest.approx(ROW / (4.0 * 0.3), rel=0.02)
    assert np.allclose(joint[:3, :3].T @ joint[:3, :3], np.eye(3), atol=1e-12)
    straight = frame_at(RUN.pipes[0], 0.5, 0.7, ROW)
    assert np.allclose(straight[:3, :2], [[math.cos(0.7), -math.sin(0.7)], [math.sin(0.7), math.cos(0.7)], [0.0, 0.0]])


def move(hold: str) -> Phase:
    return next(phase for phase in strides(1).phases if phase.kind == "move" and phase.hold.value == hold)


def metered(off: tuple[float, float]) -> Odometer:
    """An odometer that has counted so much of the pipe through closed grippers."""
    meter = Odometer(ROBOT, LAYOUT, np.array([0.4, 0.9]))
    meter.count(np.ones(2, bool), np.array([0.4, 0.9]) + off)
    return meter


def lengths_of(pose: np.ndarray, further: float = 0.0) -> np.ndarray:
    return limb_lengths(LAYOUT, pose[:3] + [0.0, further, 0.0])


def short_of_the_window(hold: str) -> Phase:
    whole = move(hold)
    poses = whole.poses * np.array([1.0, 0.6, 1.0, 1.0]) + np.array([0.0, 0.4 * 0.175, 0.0, 0.0])
    return replace(whole, poses=poses, start=tuple(poses[0]), end=tuple(poses[-1]))


@pytest.mark.parametrize("hold", ["lower", "upper"])
def test_a_move_makes_up_for_where_the_grippers_are(hold: str) -> None:
    """The gripper that moves ends at its place on the pipe, wherever the other one and itself have been."""
    phase = short_of_the_window(hold)
    reference = MoveReference.of(LAYOUT, phase, STEP)
    off = (-3e-4, 2e-4)
    meter = metered(off)
    assert np.allclose(meter.off, off)
    made = meter.corrected(reference, phase, lengths_of(reference.poses[0], off[1] - off[0]))
    gap = made.poses[:, 1] - reference.poses[:, 1]
    assert gap[0] == pytest.approx(off[1] - off[0], abs=1e-7)
    moves = 1 if hold == "lower" else 0
    meter.moved(phase, made, lengths_of(made.poses[-1]), True)
    assert meter.off[moves] == pytest.approx(0.0, abs=1e-7)
    assert meter.off[1 - moves] == pytest.approx(off[1 - moves])
    assert np.allclose(made.joints[:, :3], limb_lengths(LAYOUT, made.poses[:, :3]))
    assert np.allclose(made.joints[0] + STEP * made.rates.sum(axis=0), made.joints[-1])


def test_no_correction_leaves_the_cylinders_windows() -> None:
    """At the end of a full stroke there is nothing left to make up with, and the robot knows by how much it is off."""
    phase = move("lower")
    reference = MoveReference.of(LAYOUT, phase, STEP)
    meter, start = metered((-5e-4, -5e-4)), lengths_of(reference.poses[0])
    made = meter.corrected(reference, phase, start)
    assert made.joints[-1, :3].max() <= np.max(np.array(ROBOT.cylinders.retracted) + ROBOT.cylinders.stroke) + 1e-9
    assert np.allclose(made.poses[-1], reference.poses[-1], atol=1e-9)
    meter.moved(phase, made, lengths_of(made.poses[-1], -4e-5), True)
    assert np.allclose(meter.off, (-5e-4, -5.4e-4), atol=1e-7)
    shorter = metered((5e-4, 5e-4)).corrected(reference, phase, start)
    assert reference.poses[-1, 1] - shorter.poses[-1, 1] == pytest.approx(5e-4)


def test_a_correction_is_no_faster_than_the_cylinders() -> None:
    phase = move("upper")
    reference = MoveReference.of(LAYOUT, phase, STEP)
    made = metered((-2e-3, 0.0)).corrected(reference, phase, lengths_of(reference.poses[0], 2e-3))
    planned = np.abs(reference.rates[:, :3]).max()
    assert np.abs(made.rates[:, :3]).max() <= max(ROBOT.cylinders.speed, planned) * (1.0 + 1e-9)
    assert len(made.poses) > len(reference.poses) and made.duration > reference.duration


def test_only_what_passes_through_a_closed_gripper_counts() -> None:
    """An open gripper's sensor counts half a metre; one that has gone to another pipe is taken to be in its place."""
    meter = metered((0.0, 0.0))
    for passed in (np.array([0.4, 1.0]), np.array([0.4001, 1.4])):
        meter.count(np.array([True, False]), passed)
    meter.count(np.array([True, True]), np.array([0.4002, 1.5]))  # just told to close
    assert np.allclose(meter.off, (2e-4, 0.0))
    phase = short_of_the_window("lower")
    reference = MoveReference.of(LAYOUT, phase, STEP)
    start = lengths_of(reference.poses[0])
    crossing = meter.corrected(reference, phase, start, together=False)
    assert np.allclose(crossing.poses, reference.poses, atol=1e-7)
    meter.moved(phase, crossing, lengths_of(crossing.poses[-1], 1e-4), False)
    assert np.allclose(meter.off, (2e-4, 0.0))


def test_open_jaws_clear_what_lies_between() -> None:
    run = load_pipe("flange")
    at, following = replace(move("lower"), s_lower=0.1, s_upper=0.30), replace(move("lower"), s_lower=0.1, s_upper=0.40)
    one = run.obstacles[0]
    assert clearing(run, at, following, 0.0375) == pytest.approx(float(run.radius(one.start)) + one.height)
    assert clearing(run, at, at, 0.0375) == pytest.approx(float(run.radius(0.2)))


def test_open_jaws_clear_the_thicker_pipe_under_their_end() -> None:
    run = load_pipe("reducer")
    at, following = (
        replace(move("upper"), s_lower=0.41, s_upper=0.60),
        replace(move("upper"), s_lower=0.46, s_upper=0.60),
    )
    assert clearing(run, at, following, 0.0375) == resting(run, at, ROBOT)[0][0] == 0.030
    assert resting(run, at, ROBOT)[1] == (FIRST, BOTH)
    assert resting(run, following, ROBOT)[0] == pytest.approx((0.025, 0.025))


def test_what_pads_press_with_is_what_mujoco_says() -> None:
    plant = hung((True, False), (0.0, 0.16, 0.0, 0.3))
    plant.advance(300)
    truth, wrench, normal, pull = plant.truth(), np.zeros(6), 0.0, np.zeros(3)
    for k in range(plant.data.ncon):
        mujoco.mj_contactForce(plant.model, plant.data, k, wrench)
        axes = plant.data.contact[k].frame.reshape(3, 3)
        normal += wrench[0]
        pull += wrench[:3] @ axes * (1.0 if plant.data.contact[k].geom2 > plant.data.contact[k].geom1 else -1.0)
    assert truth.normal[0] == pytest.approx(normal) and truth.normal[1] == 0.0
    assert truth.wrench[0, 3:] == pytest.approx(truth.lower[:3, :3].T @ pull, abs=1e-3)
    upper = np.linalg.solve(truth.lower, truth.upper)
    assert np.allclose(upper, free_gripper((0.0, 0.16, 0.0, 0.3), 0.0), atol=1e-3)


class Still:
    """A camera that sees grey."""

    def __init__(self) -> None:
        self.taken = 0

    def take(self, shadows: bool = True) -> Image.Image:
        """One more frame."""
        self.taken += 1
        return Image.new("RGB", (52, 72), (self.taken % 256, 128, 128))


def test_a_film_keeps_to_its_number_of_frames() -> None:
    still = Still()
    film, strip = Film(cast(Camera, still), 60.0), Strip(cast(Camera, still), 60.0, 4)
    assert film.finished(0.0) is None
    pictures = [strip(0.02 * k) for k in range(3000)]
    for k in range(3000):
        film(0.02 * k)
    assert sum(one is not None for one in pictures) == 4
    shown = film.finished(60.0)
    assert shown is not None and shown.format == "webp" and shown.frame_id == "3.8 times as fast"
    frames = getattr(Image.open(io.BytesIO(shown.data)), "n_frames", 1)
    assert FRAMES - 2 <= frames <= FRAMES
