"""What the published numbers of the pipe climber come to: the robot file, Eq. 8 and 13, strokes, bends, speed."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from climber_cases import REFERENCE, Array, layout

from steeplejack.robots.pipe_climber import Layout, load_pipe_climber
from steeplejack.robots.pipe_climber.forward import forward_kinematics
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.motion import eq27, states

ROBOT = load_pipe_climber()


def test_the_robot_file_holds_the_published_machine() -> None:
    one = REFERENCE["machine"]
    assert ROBOT.linkage.lengths == tuple(REFERENCE["dimensions"]["original"])
    assert ROBOT.cylinders.reach == tuple(one["reach"])
    assert (ROBOT.cylinders.stroke, ROBOT.cylinders.speed, ROBOT.cylinders.force, ROBOT.cylinders.mass) == (
        one["stroke"], one["speed"], one["force"], one["cylinder_mass"],
    )  # fmt: skip
    assert (ROBOT.gripper.force, ROBOT.body.mass) == (one["grip_force"], one["mass"])
    assert math.degrees(ROBOT.joints.limit) == pytest.approx(one["joint_limit_deg"])
    assert math.degrees(ROBOT.rcm.limit) == pytest.approx(one["rcm_limit_deg"])


def test_the_robot_that_crosses_is_the_prototype_but_for_what_its_file_says() -> None:
    """Two files of a hundred lines each: what one of them changes the other must not miss."""

    def values(name: str) -> dict[str, object]:
        tables = msgspec.to_builtins(load_pipe_climber(name))
        return {f"{table}.{key}": value for table, entries in tables.items() if isinstance(entries, dict)
                for key, value in entries.items() if key != "source"}  # fmt: skip

    prototype, crosses = values("pipe-climber"), values("pipe-climber-cross")
    assert prototype.keys() == crosses.keys()
    assert {key for key, value in prototype.items() if crosses[key] != value} == {
        "cylinders.retracted", "cylinders.stroke", "joints.limit", "build.jaw_length", "gait.ramp",
    }  # fmt: skip


def eq_8(lengths: tuple[float, ...], pose: Array, beta: Array, d: float) -> Array:
    """Eq. 8 as printed, z - hz being w, but with the base of the text: B2 at L3, B3 at L1."""
    l1, l2, l3, l4 = lengths
    x, w, alpha = pose.T
    ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    squares = (
        (d * cb - d + l4 * ca * sb) ** 2 + (w + l4 * sa) ** 2 + (x + d * sb - l4 * ca * cb) ** 2,
        (d - d * cb) ** 2 + (x - d * sb + l3) ** 2 + w**2,
        (l2 * ca * sb) ** 2 + (x - l2 * ca * cb + l1) ** 2 + (w + l2 * sa) ** 2,
    )
    return np.sqrt(np.stack(squares, axis=-1))


def test_eq_8_with_beta_asks_for_lengths_that_no_pose_has() -> None:
    one = REFERENCE["beta"]
    path = states(eq27(), np.linspace(0.0, 10.0, 2001), one["claw_offset"])
    true = limb_lengths(layout(), path.pose)
    still = eq_8(layout().lengths, path.pose, np.zeros(2001), one["half_width"])
    assert still == pytest.approx(true, abs=1e-15)  # with beta = 0, D drops out
    turned = eq_8(layout().lengths, path.pose, path.beta[:, 0], one["half_width"])
    assert np.abs(turned - true).max() == pytest.approx(one["off"], abs=5e-5)


def eq_13(mechanism: Layout, lengths: Array, alpha: Array, inner: float) -> Array:
    """Left side of Eq. 13 with beta = hz = 0; ``inner`` is the sign within Eq. 12's delta_2, printed +1."""
    (_, b2, b3), (p1, _, p3) = -mechanism.base, -mechanism.platform
    a1, a3 = -p1 * np.cos(alpha), p1 * np.sin(alpha)
    c1, d2, d3 = b2, b3 - p3 * np.cos(alpha), p3 * np.sin(alpha)
    e1, e2, e3 = a1**2 + a3**2 - lengths[0] ** 2, c1**2 - lengths[1] ** 2, d2**2 + d3**2 - lengths[2] ** 2
    below = 2.0 * ((a1 - c1) * (a3 - d3) - (a1 - d2) * a3)
    delta1 = (e1 - e2) * (d3 - a3) + (e1 - e3) * a3
    delta2 = (e1 - e2) * (a1 - d2) + inner * (e1 - e3) * (a1 - c1)
    return delta1**2 + delta2**2 + 2.0 * a1 * below * delta1 + 2.0 * a3 * below * delta2 + e1 * below**2


def is_cubic_in_cosine(values: Array, alpha: Array) -> bool:
    """Whether values are those of a polynomial of degree 3 in cos alpha, that is of degree 6 in tan(alpha / 2)."""
    cosine = np.cos(alpha)
    fitted = np.polynomial.Polynomial.fit(cosine, values, 3)
    return bool(np.abs(fitted(cosine) - values).max() < 1e-9 * np.abs(values).max())


@pytest.mark.parametrize("convention", ["text", "equations"])
def test_eq_13_has_degree_6_and_needs_a_minus(convention: str, rng: np.random.Generator) -> None:
    """In tan(alpha / 2): (1 + u^2)^3 times a cubic in cos alpha is a sextic; the printed 12 holds (1 + u^2)^3 more."""
    mechanism, alpha = layout(convention), rng.uniform(-math.pi, math.pi, 40)
    lengths = limb_lengths(mechanism, [0.020, 0.150, 0.1])
    assert is_cubic_in_cosine(eq_13(mechanism, lengths, alpha, -1.0), alpha)
    assert not is_cubic_in_cosine(eq_13(mechanism, lengths, alpha, 1.0), alpha)
    solutions = forward_kinematics(mechanism, lengths).poses[:, 2]
    scale = np.abs(eq_13(mechanism, lengths, alpha, -1.0)).max()
    assert np.abs(eq_13(mechanism, lengths, solutions, -1.0)).max() < 1e-12 * scale
    assert np.abs(eq_13(mechanism, lengths, solutions, 1.0)).max() > 1e-3 * scale


@pytest.mark.parametrize("convention", ["text", "equations"])
def test_det_j_with_parallel_platforms_is_minus_k_w_squared(convention: str, rng: np.random.Generator) -> None:
    mechanism = Layout((0.11, 0.09, 0.07, 0.04), convention)  # pyright: ignore
    l1, l2, l3, l4 = mechanism.lengths
    k = l3 * (l2 - l4) + l1 * l4 if convention == "text" else l1 * (l2 - l4) + l3 * l4
    level = rng.uniform([-0.1, 0.05, 0.0], [0.1, 0.24, 0.0], (50, 3))
    expected = -k * level[:, 1] ** 2 / limb_lengths(mechanism, level).prod(axis=1)
    assert np.linalg.det(jacobian(mechanism, level)) == pytest.approx(expected, rel=1e-9)


def travel(windows: Array) -> float:
    """How far O2 goes straight along the pipe, x = alpha = 0, with each cylinder within its window (3, 2) [m]."""
    w = np.linspace(0.10, 0.25, 1_500_001)
    lengths = limb_lengths(layout(), np.stack((0.0 * w, w, 0.0 * w), axis=-1))
    fits = ((lengths >= windows[:, 0]) & (lengths <= windows[:, 1])).all(axis=-1)
    return float(np.ptp(w[fits]))


def test_one_window_for_all_cylinders_loses_a_third_of_the_stroke() -> None:
    one, stroke = REFERENCE["strokes"], REFERENCE["machine"]["stroke"]
    common = np.array([one["common_window"]] * 3)
    assert np.ptp(common, axis=1) == pytest.approx(stroke)
    assert travel(common) == pytest.approx(one["common_travel"], abs=5e-5)
    retracted = np.array(ROBOT.cylinders.retracted)
    windows = np.stack((retracted, retracted + stroke), axis=-1)
    assert windows == pytest.approx(np.array(one["windows"]), abs=5e-5)
    assert travel(windows) == pytest.approx(one["travel"], abs=1e-6)


def test_a_stroke_out_and_back_bounds_the_speed() -> None:
    one, machine = REFERENCE["climbing"], ROBOT.cylinders
    cycle = 2.0 * machine.stroke / machine.speed
    assert cycle == pytest.approx(one["cycle"], abs=5e-3)
    assert machine.stroke / cycle == pytest.approx(one["speed"], abs=5e-5)
    assert machine.stroke / one["paper_cycle"] == pytest.approx(one["paper_speed"], abs=5e-6)
    assert cycle > 5.0


def step_along(radius: float, claw_offset: float) -> float:
    """Greatest step on an arc with both claws on it, from the lengths that poses along it ask for [m].

    The base stands at the arc's begin with the centre toward +X; a claw at angle t is at ``R (1 - cos t, sin t)`` and
    turned by t, O2 is ``hz`` behind it.
    """
    t = np.linspace(1e-4, math.radians(REFERENCE["machine"]["joint_limit_deg"]), 200_001)
    x = radius * (1.0 - np.cos(t)) - claw_offset * np.sin(t)
    w = radius * np.sin(t) - claw_offset * np.cos(t)
    lengths = limb_lengths(layout(), np.stack((x, w, t), axis=-1))
    least, largest = REFERENCE["machine"]["reach"]
    fits = ((lengths >= least) & (lengths <= largest)).all(axis=-1) & (w > 0.0)
    return radius * float(np.ptp(t[fits])) if fits.any() else 0.0


def test_steps_in_the_bend_of_300_mm() -> None:
    one = REFERENCE["bends"]
    for claw_offset, step in one["steps"]:
        found = step_along(one["radius"], claw_offset)
        assert step <= found < step + 1e-3
    assert step_along(one["radius"], one["steps"][-1][0]) == 0.0


def test_least_radius_of_a_bend() -> None:
    one = REFERENCE["bends"]
    assert step_along(one["least_radius"] - 1e-3, 0.0) == 0.0 < step_along(one["least_radius"], 0.0)
    wanted = one["least_radius_of_step"]
    assert step_along(wanted - 1e-3, 0.0) < one["step"] <= step_along(wanted, 0.0)
