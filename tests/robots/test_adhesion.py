"""Palm force of Eq. 16-17: the reference, the triangle, the range of validity."""

from __future__ import annotations

import math

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.robots.squad.adhesion import min_grip_force, palm_angle

MU = 0.3


def grip(**changes):
    given = {"external_force": 300.0, "radius": 0.05, "inclination": math.pi / 4, "palm_length": 0.09, "sign": "+"}
    return min_grip_force(**(given | changes))


def test_reference(reference):
    given = reference["grip"]
    answer = min_grip_force(
        given["external_force"], given["radius"], math.radians(given["inclination_deg"]), given["palm_length"], "+"
    )
    assert answer.min_force == pytest.approx(given["min_force"], rel=1e-6)


def test_gamma_is_the_angle_at_the_palm_tip():
    radius, palm, distance, height = 0.055, 0.08, 0.12, 0.015
    gamma = palm_angle(radius, palm, distance, height)
    centre, joint = np.zeros(2), np.array([distance / 2, radius + height])
    far = np.linalg.norm(joint)
    along = (radius**2 - palm**2 + far**2) / (2 * far)  # the palm tip, by intersecting two circles
    across = math.sqrt(radius**2 - along**2)
    tip = along * joint / far + across * np.array([-joint[1], joint[0]]) / far
    to_centre, to_joint = centre - tip, joint - tip
    cosine = to_centre @ to_joint / np.linalg.norm(to_centre) / np.linalg.norm(to_joint)
    assert math.cos(gamma) == pytest.approx(cosine)


@pytest.mark.parametrize("sign", ["+", "-"])
@pytest.mark.parametrize("inclination", [0.2, 0.7, 1.3, math.pi / 2])
def test_the_force_just_satisfies_eq_16(sign, inclination):
    answer = grip(sign=sign, inclination=inclination)
    press = math.sin(inclination) + (1 if sign == "+" else -1) * MU * math.cos(inclination)
    needed = max(300.0 * press, 0.0)
    held = 2 * MU * answer.min_force * math.cos(math.pi / 2 - answer.gamma)
    assert held == pytest.approx(needed, abs=1e-9)


def test_friction_alone_holds_on_a_gentle_slope():
    assert grip(sign="-", inclination=0.9 * math.atan(MU)).min_force == 0.0
    assert grip(sign="-", inclination=1.1 * math.atan(MU)).min_force > 0.0
    assert grip(external_force=0.0).min_force == 0.0


def test_palm_lengths_that_close_for_every_radius(reference):
    shortest, longest = reference["grip"]["palm_lengths"]
    for radius in np.linspace(0.045, 0.060, 31):
        for palm in (shortest + 1e-6, longest - 1e-6):
            assert 0.0 < palm_angle(float(radius), palm, 0.12, 0.015) < math.pi
    for palm in (shortest - 1e-6, longest + 1e-6):
        with pytest.raises(InputError, match="palm length.*between"):
            palm_angle(0.045, palm, 0.12, 0.015)


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"external_force": -1.0}, "external force"),
        ({"external_force": math.nan}, "external force"),
        ({"radius": 0.0}, "radius"),
        ({"inclination": -0.1}, "inclination"),
        ({"inclination": 1.7}, "inclination"),
        ({"inclination": math.nan}, "inclination"),
        ({"palm_length": -0.09}, "palm length"),
        ({"sign": "x"}, "sign"),
        ({"friction": 0.0}, "friction"),
        ({"joint_distance": 0.0}, "joint distance"),
        ({"joint_height": -0.2}, "joint height"),
    ],
)
def test_what_is_out_of_range_is_named(changes, where):
    with pytest.raises(InputError) as error:
        grip(**changes)
    assert error.value.where == where
