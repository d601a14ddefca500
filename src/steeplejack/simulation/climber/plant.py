"""The pipe climber in MuJoCo behind the plant protocol: drives that take time, jaws that press, sensors that count.

A cylinder is a screw: told a speed it turns at that speed, no faster than its motor, and the rod follows as the spring
of rod, screw and nut lets it, up to the cylinder's force. A screw that stands still holds. So does the linkage's
servo. A jaw's drive moves its goal at the speed that opens or closes it within the robot's close time; against the
pipe it presses with the gripper's force, told as the sum of the normal forces of its pads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from steeplejack.control.climber.jaws import open_place, pipe_radius
from steeplejack.control.climber.signals import Command, Measurement
from steeplejack.robots.pipe_climber import Layout, PipeClimber
from steeplejack.robots.pipe_climber.inverse import limb_lengths, limb_vectors
from steeplejack.robots.pipe_climber.pads import pad_place
from steeplejack.simulation.climber import drives
from steeplejack.simulation.climber.scene import JAW_STIFFNESS, SCREW_DAMPING, SERVO_DAMPING, TIMESTEP, build
from steeplejack.simulation.climber.sensors import SensorErrors
from steeplejack.simulation.climber.solids import Array, Solid
from steeplejack.simulation.climber.truth import ENDS, Eyes, Truth
from steeplejack.simulation.engine import mujoco

PRESS = 1.3  # how far a closed jaw's goal lies inside what it touches, in parts of what its force needs [1]
END = 5e-4  # [m] from the end of a cylinder's window to the stop of its screw
HASTE = 0.75  # share of the close time in which a jaw's goal moves, the rest is for the force to build up [1]
SERVO_SPEED = np.pi / 3.0 / 0.18  # [rad/s] of an HTS-20L without load, by its data


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


class ClimberPlant:
    """A climber on a pipe, in physics.

    Args:
        robot: The machine.
        layout: Hinges of its limbs.
        solids: Pipe and obstacles.
        gravity: Of the worksite (3,) [m/s2].
        start: Where it hangs.
        friction: Of the pads of the lower and the upper gripper [1].
        payload: At the middle of the upper gripper [kg].
        errors: Of the sensors; those of none by default.
    """

    def __init__(
        self,
        robot: PipeClimber,
        layout: Layout,
        solids: Sequence[Solid],
        gravity: Array,
        start: Start,
        friction: tuple[float, float],
        payload: float = 0.0,
        errors: SensorErrors | None = None,
    ) -> None:
        self.robot, self.layout, self.friction, self.payload = robot, layout, friction, payload
        self._errors, self._gravity = errors or SensorErrors(), gravity
        self._leaning = self._errors.leaning()
        self.model = model = build(robot, layout, solids, gravity, friction, payload)
        self.data = data = mujoco.MjData(model)
        self._limbs = np.array([model.joint(f"limb{i}").qposadr[0] for i in (1, 2, 3)])
        self._turn = int(model.joint("G1").qposadr[0])
        self._jaws = np.array([[model.joint(f"{end}_{jaw}").qposadr[0] for jaw in "ab"] for end in ENDS])
        self._eyes = Eyes(model, data)
        self._touch = np.stack((model.geom_contype, model.geom_conaffinity), axis=-1)
        bars = [int(model.body(name).id) for name in ("G1", "G2", "G3", "G4")]
        self._ring = np.flatnonzero(np.isin(model.geom_bodyid, bars))
        self._first_jaw = int(model.actuator("lower_a").id)
        self._passed = np.zeros((2, 2))
        parts, press = robot.build, PRESS * robot.gripper.force / JAW_STIFFNESS
        slack = robot.cylinders.force / parts.screw_stiffness
        rate = (parts.jaw_clearance + press) / (HASTE * robot.gripper.close_time)
        self._retracted = retracted = np.array(robot.cylinders.retracted)
        self._windows = np.stack((retracted - END, retracted + robot.cylinders.stroke + END), axis=-1)
        leads = SCREW_DAMPING / parts.screw_stiffness, SERVO_DAMPING / parts.servo_stiffness
        self._constants = np.array(
            [slack, press, rate, robot.gripper.force, 0.5 * parts.jaw_width, *leads, robot.rcm.limit]
        )
        # Views into MuJoCo's own arrays, taken once: the properties cost more than the arithmetic.
        self._qpos, self._controls, self._ranges = data.qpos, data.ctrl, model.actuator_forcerange
        self._goals = np.zeros(8)
        self._forces, self._rates = data.actuator_force, data.actuator_velocity
        self._places = np.concatenate([self._limbs, self._jaws[:, 0]])
        self.work = 0.0  # [J] that cylinders and servo have put in, what they got back not counted
        self._strongest = 0.0
        self._hang(start)
        opening = np.array([open_place(robot, float(r)) for r in start.radius])
        self._command = Command(np.zeros(3), 0.0, np.array(start.closed), opening)
        self._frames = self._eyes.frames()

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
            stands = pad_place if start.closed[i] else open_place
            data.qpos[self._jaws[i]] = stands(robot, float(start.radius[i]))
        goals = data.qpos[self._jaws[:, 0]] - np.where(start.closed, self._constants[1], 0.0)
        self._goals[:] = self._controls[:] = np.concatenate([lengths, [beta], np.repeat(goals, 2)])
        mujoco.mj_forward(model, data)

    def apply(self, command: Command) -> None:
        """Take over a command."""
        self._command = command

    def advance(self, steps: int) -> None:
        """Advance the physics; drives with it, or rods would meet their screws in jerks of a newton."""
        model, data, command = self.model, self.data, self._command
        most = np.array([*[self.robot.cylinders.speed] * 3, SERVO_SPEED])
        speeds = np.clip(np.append(command.speeds, command.servo_speed), -most, most)
        for _ in range(steps):
            drives.advance(
                TIMESTEP, self._controls, self._goals, self._ranges, self._qpos[self._places], speeds, self._windows,
                command.closed, command.opening, self._constants,
            )  # fmt: skip
            mujoco.mj_step(model, data)
            self._strongest, power = drives.load(self._forces, self._rates, self._strongest)
            self.work += TIMESTEP * power
        self._count()

    def strongest(self) -> float:
        """Largest force of a cylinder since the last call [N]."""
        largest, self._strongest = self._strongest, 0.0
        return largest

    def _count(self) -> None:
        """Sum up what has passed through the grippers, along and around the pipe."""
        now = self._eyes.frames()
        drives.passed(self._frames, now, pipe_radius(self.robot, self._qpos[self._jaws[:, 0]]), self._passed)
        self._frames = now

    def measure(self) -> Measurement:
        """Read the sensors."""
        build, force, errors = self.robot.build, self._forces, self._errors
        place, lengths, turn = self._qpos[self._jaws[:, 0]], self._qpos[self._limbs], self._qpos[self._turn]
        lengths = lengths + errors.encoder * (lengths - self._retracted) + errors.zero
        turn = (1.0 + errors.servo[0]) * turn + errors.servo[1]
        grip = np.maximum(-0.5 * (force[self._first_jaw :: 2] + force[self._first_jaw + 1 :: 2]), 0.0)
        return Measurement(
            lengths=_grained(lengths, build.encoder_step),
            forces=(1.0 + errors.current) * force[:3],
            beta=round(turn / build.angle_step) * build.angle_step,
            jaws=place,
            grip=(1.0 + errors.grip) * grip * np.hypot(place, 0.5 * build.jaw_width) / place,
            passed=_grained((1.0 + errors.passed)[:, None] * self._passed, build.slip_step),
            gravity=self._leaning @ (self._gravity @ self._frames[0, 3:].reshape(3, 3)),
        )

    def set_friction(self, lower: float, upper: float) -> None:
        """Change the pads' friction, as oil or water does."""
        for gripper, friction in enumerate((lower, upper)):
            self.model.geom_friction[self._eyes.pads(gripper), 0] = friction

    def set_aside(self, lower: bool, upper: bool) -> None:
        """Swing the jaws of a gripper clear of everything, and the bars of the linkage with the lower one's, or back.

        On the way from one pipe to another; how they do it has no body here.
        """
        for gripper, aside in enumerate((lower, upper)):
            mine = np.concatenate((self._eyes.pads(gripper), self._ring if gripper == 0 else []))
            away = mine.astype(np.int64)
            self.model.geom_contype[away] = 0 if aside else self._touch[away, 0]
            self.model.geom_conaffinity[away] = 0 if aside else self._touch[away, 1]

    def truth(self) -> Truth:
        """The true state."""
        return self._eyes()


def _grained(values: Array, grain: float) -> Array:
    return np.rint(values / grain) * grain
