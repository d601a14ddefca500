"""Equilibria and natural frequencies against MuJoCo: the same cables as tension-only tendons, at rest."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pytest
from hanging import Hanging, hanging

from steeplejack.mechanics.cable import Rest, natural_frequencies, settle
from steeplejack.mechanics.cable.rest.modes import spatial_mass_matrix

pytestmark = pytest.mark.long

mujoco: Any = importlib.import_module("mujoco")

CASES = range(50)
DAMPING = 12.0  # [N s/m, N m s/rad] of the free joint while coming to rest


def numbers(values) -> str:
    return " ".join(f"{v:.17g}" for v in np.ravel(values))


def scene(case: Hanging) -> Any:
    """A free body on tendons whose spring acts beyond the unstressed length only."""
    platform = case.platform
    sites = "".join(f'<site name="a{i}" pos="{numbers(p)}"/>' for i, p in enumerate(platform.anchors))
    ends = "".join(f'<site name="b{i}" pos="{numbers(p)}"/>' for i, p in enumerate(platform.attachments))
    tendons = "".join(
        f'<spatial springlength="0 {length:.17g}" stiffness="{stiffness / length:.17g}">'
        f'<site site="a{i}"/><site site="b{i}"/></spatial>'
        for i, (length, stiffness) in enumerate(zip(platform.unstressed, platform.axial_stiffness, strict=True))
    )
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(case.rotation).ravel())
    return mujoco.MjModel.from_xml_string(f"""
    <mujoco>
      <option timestep="0.004" gravity="0 0 -9.81" integrator="Euler"><flag contact="disable"/></option>
      <worldbody>{sites}
        <body pos="{numbers(case.position)}" quat="{numbers(quaternion)}">
          <joint type="free" damping="{DAMPING}"/>
          <inertial pos="{numbers(case.centre)}" mass="{case.mass}" diaginertia="{numbers(np.diag(case.inertia))}"/>
          {ends}
        </body>
      </worldbody>
      <tendon>{tendons}</tendon>
    </mujoco>""")


def at_rest(model: Any) -> Any:
    """Let it swing out, for two minutes at most."""
    data = mujoco.MjData(model)
    for _ in range(300):
        mujoco.mj_step(model, data, 100)
        if np.abs(data.qvel).max() < 1e-8:
            break
    mujoco.mj_forward(model, data)
    return data


@pytest.fixture(scope="module")
def pairs():
    """Every case with MuJoCo's rest and ours, from the same start."""
    out = []
    for seed in CASES:
        case = hanging(seed)
        model = scene(case)
        out.append((case, model, at_rest(model), settle(case.platform, case.position, case.rotation)))
    return out


def test_places_agree_to_a_tenth_of_a_millimetre_and_tensions_to_a_tenth_of_a_newton(pairs):
    slack = 0
    for case, _model, data, rest in pairs:
        assert rest.status is Rest.STABLE
        ends = rest.position + case.platform.attachments @ rest.rotation.T
        theirs = np.array(data.site_xpos)[len(ends) :]
        np.testing.assert_allclose(theirs, ends, atol=1e-4)
        np.testing.assert_allclose(data.qpos[:3], rest.position, atol=1e-4)
        stretch = np.maximum(np.array(data.ten_length) - case.platform.unstressed, 0.0)
        np.testing.assert_allclose(
            case.platform.axial_stiffness / case.platform.unstressed * stretch, rest.tensions, atol=0.1
        )
        slack += not rest.taut.all()
    assert slack >= 10


def test_natural_frequencies_agree_with_its_linearisation_to_a_percent(pairs):
    """Eigenvalues of MuJoCo's own transition matrix; semi-implicit Euler gives omega = 2 sin(theta / 2) / dt."""
    for case, model, data, rest in pairs:
        model.dof_damping[:] = 0.0
        model.opt.timestep = 1e-3
        data.qvel[:] = 0.0
        size = 2 * model.nv
        transition = np.zeros((size, size))
        mujoco.mjd_transitionFD(model, data, 1e-6, True, transition, None, None, None)
        angles = np.sort(np.angle(np.linalg.eigvals(transition)))[model.nv :]
        theirs = 2.0 * np.sin(0.5 * angles) / model.opt.timestep / (2.0 * np.pi)
        mass = spatial_mass_matrix(case.mass, case.inertia, case.centre, rest.rotation)
        np.testing.assert_allclose(natural_frequencies(rest, mass), theirs, rtol=0.01)
