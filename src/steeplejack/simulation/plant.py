"""The squad in MuJoCo behind the plant protocol: sensors with noise, palms that take time, wheels that slip."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from steeplejack.robots.squad.anchorage import Stance
from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Squad
from steeplejack.runtime.plant import Command, Measurement, Truth
from steeplejack.simulation import bases, winch
from steeplejack.simulation.engine import mujoco
from steeplejack.simulation.scene import TIMESTEP, Rail, build, rail
from steeplejack.simulation.sensors import Sensors, arc_length, sense

Array = NDArray[np.float64]


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
        self.squad = squad
        self.rails: tuple[Rail, ...] = tuple(rail(bay, bay.carriers[i], *ranges[i]) for i in range(4))
        self.model = build(bay, squad, self.rails, mass, gravity)
        self.data = mujoco.MjData(self.model)
        self.sensors = Sensors(squad, rng)
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
        self._references = np.array([each.reference for each in self.rails])
        self._arcs = np.stack([each.arc for each in self.rails])
        for i in range(4):
            x = self.rails[i].x(stance.s[i])
            data.qpos[self._along[i]] = x
            data.qpos[self._bow[i]] = self.rails[i].y(x)
            data.qpos[self._turn[i]] = stance.clock[i]
        data.qpos[self._free : self._free + 3] = position
        mujoco.mju_mat2Quat(data.qpos[self._free + 3 : self._free + 7], np.ascontiguousarray(rotation).ravel())
        mujoco.mj_forward(model, data)
        # Views into MuJoCo's own arrays, taken once: the properties cost more than the arithmetic.
        self._qpos, self._qvel, self._inputs = data.qpos, data.qvel, data.ctrl
        self._lengths, self._rates = data.ten_length, data.ten_velocity
        self.tensions, self._drives = self._inputs[:4], self._inputs[4:]  # the actuators' inputs themselves
        self._strongest = np.array([squad.base.drive_force, squad.base.twist_torque])
        self.tensions[:] = tensions
        self.paid = data.ten_length.copy() / (1.0 + self.tensions / squad.cable.axial_stiffness)
        self.pay_rates = np.zeros(4)
        self._least, self._largest = self.tensions.copy(), self.tensions.copy()
        self.delivered = self.tensions.copy()
        self.palm = np.full(4, squad.gripper.force)
        self._start = np.array(stance.s, float)
        self._command = Command(self.tensions.copy(), np.zeros(4), np.zeros(4), np.ones(4, bool), np.zeros(4, bool))
        self._wheel_brake = self._command.wheel_brake.copy()
        self._measurement, self._read_at = Measurement(), 0.0
        self._read(0.0)  # what the encoders count from
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
        # Palms and wheel brake share the load; the better of the two is what a base can count on.
        wheels = np.where(self._wheel_brake, base.wheel_brake, 0.0)
        self.model.dof_frictionloss[self._along_dof] = np.maximum(base.hold_force * share, wheels)
        self.model.dof_frictionloss[self._turn_dof] = base.twist_torque * share

    def apply(self, command: Command) -> None:
        """Take over a command."""
        self._command = command

    def advance(self, steps: int) -> None:
        """Advance the physics; palms move at their own speed, and what they hold follows their preload."""
        model, data, command, gripper = self.model, self.data, self._command, self.squad.gripper
        most = gripper.force * steps * TIMESTEP / gripper.close_time
        if bases.squeeze(self.palm, command.grip, gripper.force, most, command.wheel_brake, self._wheel_brake):
            self._set_friction()
        bases.drive(
            self._drives, command.drive, command.turn, command.grip, self._qvel, self._turn_dof, self._strongest
        )
        for _ in range(steps):
            mujoco.mj_step1(model, data)
            winch.advance(
                self._lengths, self._rates, self.paid, self.pay_rates,
                command.pull, command.brake, self._constants, TIMESTEP, self.delivered,
                self.tensions, self._least, self._largest,
            )  # fmt: skip
            mujoco.mj_step2(model, data)

    def measure(self) -> Measurement:
        """Read the sensors."""
        now = self.data.time
        self._read(now - self._read_at)
        self._read_at = now
        return self._measurement

    def _read(self, elapsed: float) -> None:
        """Overwrite the last reading, ``elapsed`` [s] old."""
        sensors = self.sensors
        sense(
            self._measurement.values,
            elapsed,
            self.paid,
            self.delivered,
            self.s,
            self._start,
            self._qpos[self._turn],
            self.palm,
            sensors.noise(),
            sensors.errors,
            sensors.grains,
        )

    @property
    def s(self) -> Array:
        """True base positions (4,) [m]."""
        return arc_length(self._qpos[self._along], self._references, self._arcs)

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
