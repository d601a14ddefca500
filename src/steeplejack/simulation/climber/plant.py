"""The pipe climber in MuJoCo behind the plant protocol: drives that take time, jaws that press, sensors that count.

A cylinder is a screw: told a speed it turns at that speed, no faster than its motor, and the rod follows as the spring
of rod, screw and nut lets it, up to the cylinder's force. A screw that stands still holds. So does the linkage's
servo. A jaw's drive moves its goal at the speed that opens or closes it within the robot's close time; against the
pipe it presses with the gripper's force, told as the sum of the normal forces of its pads.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from steeplejack.control.climber.jaws import pad_place
from steeplejack.control.climber.signals import Command, Measurement
from steeplejack.robots.pipe_climber import Layout, PipeClimber
from steeplejack.robots.pipe_climber.inverse import limb_lengths, limb_vectors
from steeplejack.simulation.climber import drives
from steeplejack.simulation.climber.scene import JAW_STIFFNESS, TIMESTEP, build
from steeplejack.simulation.climber.solids import Array, Solid
from steeplejack.simulation.engine import mujoco

ENDS = ("lower", "upper")
PRESS = 1.3  # how far a closed jaw's goal lies inside what it touches, in parts of what its force needs [1]
HASTE = 0.85  # share of the close time in which a jaw's goal moves, the rest is for the force to build up [1]


@dataclass(frozen=True)
class Start:
    """Where the robot hangs at the start.

    Attributes:
        lower: Homogeneous transform of the lower gripper's frame in the world (4, 4).
        pose: (x, w, alpha, beta) [m, m, rad, rad].
        radius: Of the pipe at the lower and the upper gripper (2,) [m].
        closed: Which of them hold (2,).
    """

    lower: Array
    pose: Array
    radius: Array
    closed: tuple[bool, bool] = (True, True)


@dataclass(frozen=True)
class Truth:
    """How everything really is; for the log and for tests, never for the controller.

    Attributes:
        lower: Homogeneous transform of the lower gripper in the world (4, 4).
        upper: Of the upper gripper (4, 4).
        forces: Of the cylinders, positive when pushing (3,) [N].
        normal: Sum of the pads' normal forces of each gripper (2,) [N].
        friction: What the pads' friction adds up to on each gripper, along its z axis and around it (2, 2) [N].
        touching: Pairs of geoms that touch and should not.
    """

    lower: Array
    upper: Array
    forces: Array
    normal: Array
    friction: Array
    touching: tuple[tuple[str, str], ...]


class ClimberPlant:
    """A climber on a pipe, in physics.

    Args:
        robot: The machine.
        layout: Hinges of its limbs.
        solids: Pipe and obstacles.
        gravity: Of the worksite (3,) [m/s2].
        start: Where it hangs.
        friction: Of the pads of the lower and the upper gripper [1].
    """

    def __init__(
        self,
        robot: PipeClimber,
        layout: Layout,
        solids: Sequence[Solid],
        gravity: Array,
        start: Start,
        friction: tuple[float, float],
    ) -> None:
        self.robot, self.layout, self.friction = robot, layout, friction
        self.model = model = build(robot, layout, solids, gravity, friction)
        self.data = data = mujoco.MjData(model)
        self._limbs = np.array([model.joint(f"limb{i}").qposadr[0] for i in (1, 2, 3)])
        self._limb_dofs = np.array([model.joint(f"limb{i}").dofadr[0] for i in (1, 2, 3)])
        self._turn = int(model.joint("G1").qposadr[0])
        self._jaws = np.array([[model.joint(f"{end}_{jaw}").qposadr[0] for jaw in "ab"] for end in ENDS])
        self._sites = [int(model.site(end).id) for end in ENDS]
        self._pads = {int(model.geom(f"{e}_{j}{k}").id): i for i, e in enumerate(ENDS) for j in "ab" for k in range(4)}
        self._first_jaw = int(model.actuator("lower_a").id)
        self._passed = np.zeros((2, 2))
        parts, press = robot.build, PRESS * robot.gripper.force / JAW_STIFFNESS
        slack = robot.cylinders.force / parts.screw_stiffness
        rate = (parts.jaw_clearance + press) / (HASTE * robot.gripper.close_time)
        self._constants = np.array([slack, press, rate, robot.gripper.force, 0.5 * parts.jaw_width])
        # Views into MuJoCo's own arrays, taken once: the properties cost more than the arithmetic.
        self._qpos, self._goals, self._ranges = data.qpos, data.ctrl, model.actuator_forcerange
        self._forces, self._rates = data.actuator_force, data.actuator_velocity
        self._places = np.concatenate([self._limbs, self._jaws[:, 0]])
        self.work = 0.0  # [J] that cylinders and servo have put in, what they got back not counted
        self._strongest = 0.0
        self._hang(start)
        opening = np.array([pad_place(robot, float(r)) + robot.build.jaw_clearance for r in start.radius])
        self._command = Command(np.zeros(3), 0.0, np.array(start.closed), opening)
        self._frames = self._grips()

    @property
    def step(self) -> float:
        """Physics step [s]."""
        return TIMESTEP

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self.data.time)

    def _hang(self, start: Start) -> None:
        """Put every joint where the loops close and let the jaws press."""
        model, data, robot = self.model, self.data, self.robot
        x, w, alpha, beta = (float(value) for value in start.pose)
        data.qpos[:3] = start.lower[:3, 3]
        mujoco.mju_mat2Quat(data.qpos[3:7], np.ascontiguousarray(start.lower[:3, :3]).ravel())
        lengths, vectors = (of(self.layout, np.array([x, w, alpha])) for of in (limb_lengths, limb_vectors))
        theta = np.arctan2(vectors[:, 0], vectors[:, 1])
        places = {f"base{i + 1}": theta[i] for i in range(3)} | {f"limb{i + 1}": lengths[i] for i in range(3)}
        places |= {"G1": beta, "G2": beta, "G3": -beta, "G4": -beta, "plate": beta, "platform3": alpha - theta[2]}
        for name, value in places.items():
            data.qpos[model.joint(name).qposadr[0]] = value
        for i in range(2):
            clear = 0.0 if start.closed[i] else robot.build.jaw_clearance
            data.qpos[self._jaws[i]] = pad_place(robot, float(start.radius[i])) + clear
        goals = data.qpos[self._jaws[:, 0]] - np.where(start.closed, self._constants[1], 0.0)
        self._goals[:] = np.concatenate([lengths, [beta], np.repeat(goals, 2)])
        mujoco.mj_forward(model, data)

    def apply(self, command: Command) -> None:
        """Take over a command."""
        self._command = command

    def advance(self, steps: int) -> None:
        """Advance the physics, drives step by step."""
        model, data, command = self.model, self.data, self._command
        most = self.robot.cylinders.speed
        speeds = np.append(np.clip(command.speeds, -most, most), command.servo_speed)
        for _ in range(steps):
            drives.advance(
                TIMESTEP, self._goals, self._ranges, self._qpos[self._places],
                speeds, command.closed, command.opening, self._constants,
            )  # fmt: skip
            mujoco.mj_step(model, data)
            self._strongest, power = drives.load(self._forces, self._rates, self._strongest)
            self.work += TIMESTEP * power
        self._count()

    def strongest(self) -> float:
        """Largest force of a cylinder since the last call [N]."""
        largest, self._strongest = self._strongest, 0.0
        return largest

    def _grips(self) -> Array:
        """Frames of the grippers in the world (2, 4, 4)."""
        out = np.zeros((2, 4, 4))
        for i, site in enumerate(self._sites):
            out[i, :3, :3] = self.data.site_xmat[site].reshape(3, 3)
            out[i, :3, 3] = self.data.site_xpos[site]
        out[:, 3, 3] = 1.0
        return out

    def _count(self) -> None:
        """Sum up what has passed through the grippers, along and around the pipe."""
        now, before, robot = self._grips(), self._frames, self.robot
        for i in range(2):
            self._passed[i, 0] += float((now[i, :3, 3] - before[i, :3, 3]) @ before[i, :3, 2])
            turn = before[i, :3, :3].T @ now[i, :3, :3]
            radius = (
                float(np.hypot(self.data.qpos[self._jaws[i, 0]], 0.5 * robot.build.jaw_width)) - robot.build.pad_radius
            )
            self._passed[i, 1] += radius * math.atan2(turn[1, 0], turn[0, 0])
        self._frames = now

    def measure(self) -> Measurement:
        """Read the sensors."""
        data, build = self.data, self.robot.build
        place = data.qpos[self._jaws[:, 0]]
        force = data.actuator_force
        grip = -np.array([force[self._first_jaw + 2 * i : self._first_jaw + 2 * i + 2].mean() for i in range(2)])
        return Measurement(
            lengths=_grained(data.qpos[self._limbs], build.encoder_step),
            forces=force[:3].copy(),
            beta=float(_grained(data.qpos[self._turn], build.angle_step)),
            jaws=place.copy(),
            grip=np.maximum(grip, 0.0) / np.cos(np.arctan2(0.5 * build.jaw_width, place)),
            passed=_grained(self._passed, build.slip_step),
        )

    def set_friction(self, lower: float, upper: float) -> None:
        """Change the pads' friction, as oil or water does."""
        for geom, end in self._pads.items():
            self.model.geom_friction[geom, 0] = (lower, upper)[end]

    def truth(self) -> Truth:
        """The true state."""
        model, data = self.model, self.data
        frames = self._grips()
        normal, friction = np.zeros(2), np.zeros((2, 2))
        touching: list[tuple[str, str]] = []
        wrench = np.zeros(6)
        for k in range(data.ncon):
            contact = data.contact[k]
            if contact.exclude:  # too far apart to press
                continue
            first, second = int(contact.geom1), int(contact.geom2)
            names = model.geom(first).name, model.geom(second).name
            end = self._pads.get(first, self._pads.get(second))
            if end is None or any(name.startswith("obstacle") for name in names):
                touching.append(names)
                continue
            mujoco.mj_contactForce(model, data, k, wrench)
            axes, z = contact.frame.reshape(3, 3), frames[end, :3, 2]
            sign = 1.0 if second in self._pads else -1.0  # the force is that on the second geom
            force = sign * (wrench[1] * axes[1] + wrench[2] * axes[2])
            arm = contact.pos - frames[end, :3, 3]
            around = np.cross(z, arm)
            normal[end] += wrench[0]
            friction[end] += force @ z, force @ around / max(float(np.linalg.norm(around)), 1e-9)
        return Truth(frames[0], frames[1], data.actuator_force[:3].copy(), normal, friction, tuple(touching))


def _grained(values: Array | float, grain: float) -> Array:
    return np.round(np.asarray(values) / grain) * grain
