"""The squad in MuJoCo behind the plant protocol: sensors with noise, palms that take time, wheels that slip."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from steeplejack.robots.squad.anchorage import Stance
from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Squad
from steeplejack.runtime.plant import Command, Measurement, Truth
from steeplejack.simulation import winch
from steeplejack.simulation.scene import TIMESTEP, Rail, build, rail

Array = NDArray[np.float64]

TURN_GAIN = 400.0  # [N m s/rad] of the drive that turns a base about its stay while its palms are open


@dataclass(frozen=True)
class Errors:
    """What is wrong with the sensors of one run, drawn once from a seed."""

    odometry: Array  # (4,) [1] scale error of each wheel
    torque: Array  # (4,) [1] scale error of each torque constant

    @classmethod
    def draw(cls, squad: Squad, rng: np.random.Generator) -> Errors:
        """Errors of the size the robot file states."""
        return cls(
            rng.normal(0.0, 1.0, 4) * squad.base.odometry_drift, rng.normal(0.0, 1.0, 4) * squad.winch.torque_scale_error
        )


class SquadPlant:
    """Four bases, four winches and a platform on a bay, in physics.

    Args:
        bay: The stays.
        squad: The machine.
        stance: Where the bases stand at the start, gripped.
        ranges: Stretch of its stay (low, high) that each base will drive over [m].
        position: Platform at the start (3,) [m].
        rotation: Its orientation (3, 3).
        tensions: Tensions at the start (4,) [N].
        mass: Platform and payload [kg].
        gravity: Of the worksite (3,) [m/s2].
        rng: Source of the sensors' noise.
    """

    def __init__(
        self,
        bay: Bay,
        squad: Squad,
        stance: Stance,
        ranges: list[tuple[float, float]],
        position: Array,
        rotation: Array,
        tensions: Array,
        mass: float,
        gravity: Array,
        rng: np.random.Generator,
    ) -> None:
        self.squad, self._rng = squad, rng
        self.rails: tuple[Rail, ...] = tuple(rail(bay, bay.carriers[i], *ranges[i]) for i in range(4))
        self.model = build(bay, squad, self.rails, mass, gravity)
        self.data = mujoco.MjData(self.model)
        self.errors = Errors.draw(squad, rng)
        model, data = self.model, self.data
        self._along = np.array([model.joint(f"along{i}").qposadr[0] for i in range(1, 5)])
        self._bow = np.array([model.joint(f"bow{i}").qposadr[0] for i in range(1, 5)])
        self._turn = np.array([model.joint(f"turn{i}").qposadr[0] for i in range(1, 5)])
        self._along_dof = np.array([model.joint(f"along{i}").dofadr[0] for i in range(1, 5)])
        self._turn_dof = np.array([model.joint(f"turn{i}").dofadr[0] for i in range(1, 5)])
        self._free = int(model.joint("platform").qposadr[0])
        self._free_dof = int(model.joint("platform").dofadr[0])
        self._platform = int(model.body("platform").id)
        self._exit_sites = np.array([model.site(f"exit{i}").id for i in range(1, 5)])
        self._constants = winch.constants(squad)
        for i in range(4):
            x = self.rails[i].x(stance.s[i])
            data.qpos[self._along[i]] = x
            data.qpos[self._bow[i]] = np.polyval(self.rails[i].bow[::-1], x)
            data.qpos[self._turn[i]] = stance.clock[i]
        data.qpos[self._free : self._free + 3] = position
        mujoco.mju_mat2Quat(data.qpos[self._free + 3 : self._free + 7], np.ascontiguousarray(rotation).ravel())
        mujoco.mj_forward(model, data)
        self.tensions = tensions.astype(float).copy()
        self.paid = data.ten_length.copy() / (1.0 + self.tensions / squad.cable.axial_stiffness)
        self.pay_rates = np.zeros(4)
        self._least, self._largest = self.tensions.copy(), self.tensions.copy()
        self._read = self.paid.copy(), 0.0
        self.palm = np.full(4, squad.gripper.force)
        self._start = np.array(stance.s, float)
        self._command = Command(self.tensions.copy(), np.zeros(4), np.zeros(4), np.ones(4, bool), np.zeros(4, bool))
        self._measurement = Measurement()
        self._set_friction()

    @property
    def step(self) -> float:
        """Physics step [s]."""
        return TIMESTEP

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self.data.time)

    def _set_friction(self) -> None:
        """What the palms can hold follows their preload; open palms leave the wheels' traction and nothing else."""
        base, share = self.squad.base, self.palm / self.squad.gripper.force
        self.model.dof_frictionloss[self._along_dof] = base.hold_force * share
        self.model.dof_frictionloss[self._turn_dof] = base.twist_torque * share

    def apply(self, command: Command) -> None:
        """Take over a command."""
        self._command = command

    def advance(self, steps: int) -> None:
        """Advance the physics."""
        model, data, command, base = self.model, self.data, self._command, self.squad.base
        goal = np.where(command.grip, self.squad.gripper.force, 0.0)
        moving = bool(np.any(goal != self.palm))
        rate = self.squad.gripper.force / self.squad.gripper.close_time * TIMESTEP
        traction = np.clip(command.drive, -base.drive_force, base.drive_force)
        data.ctrl[4:8] = traction
        for _ in range(steps):
            if moving:
                self.palm += np.clip(goal - self.palm, -rate, rate)
                self._set_friction()
            mujoco.mj_step1(model, data)
            winch.advance(
                data.ten_length, data.ten_velocity, self.paid, self.pay_rates,
                command.pull, command.brake, self._constants, TIMESTEP, self.tensions,
                self._least, self._largest,
            )  # fmt: skip
            data.ctrl[:4] = self.tensions
            if not command.grip.all():
                slip = TURN_GAIN * (command.turn - data.qvel[self._turn_dof])
                data.ctrl[8:12] = np.where(command.grip, 0.0, np.clip(slip, -base.twist_torque, base.twist_torque))
            else:
                data.ctrl[8:12] = 0.0
            mujoco.mj_step2(model, data)

    def measure(self) -> Measurement:
        """Read the sensors: quantised encoders, noisy currents, drifting odometry."""
        out, squad, data = self._measurement, self.squad, self.data
        count = 2.0 * np.pi * squad.winch.drum_radius / (squad.winch.ratio * squad.winch.encoder_counts)
        out.paid[:] = np.round(self.paid / count) * count
        before, then = self._read
        if data.time > then:
            out.pay_rate[:] = (out.paid - before) / (data.time - then)
            self._read = out.paid.copy(), float(data.time)
        gear = squad.winch.ratio / squad.winch.drum_radius
        noise = self._rng.normal(0.0, squad.winch.current_noise * squad.winch.torque_constant * gear, 4)
        out.pull[:] = self._command.pull * (1.0 + self.errors.torque) + noise
        grain = squad.base.encoder_step
        driven = self.s - self._start
        out.s[:] = self._start + np.round(driven * (1.0 + self.errors.odometry) / grain) * grain
        out.s_rate[:] = data.qvel[self._along_dof] * (1.0 + self.errors.odometry)
        out.clock[:] = data.qpos[self._turn]
        out.palm[:] = self.palm + self._rng.normal(0.0, squad.gripper.palm_noise, 4)
        return out

    @property
    def s(self) -> Array:
        """True base positions (4,) [m]."""
        return np.array([self.rails[i].s(float(self.data.qpos[self._along[i]])) for i in range(4)])

    def extremes(self) -> tuple[Array, Array]:
        """Least and largest true tensions since the last call."""
        out = self._least.copy(), self._largest.copy()
        self._least[:] = self._largest[:] = self.tensions
        return out

    def truth(self) -> Truth:
        """The true state."""
        data, at = self.data, self._free
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, data.qpos[at + 3 : at + 7])
        return Truth(
            data.qpos[at : at + 3].copy(),
            rotation.reshape(3, 3),
            data.qvel[self._free_dof : self._free_dof + 3].copy(),
            self.tensions.copy(),
            data.site_xpos[self._exit_sites].copy(),
            self.s,
        )
