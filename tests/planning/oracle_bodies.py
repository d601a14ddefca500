"""The pipe climber as rigid bodies for the oracle: masses and bars from the physics' scene, frames worked out anew.

Nothing of `robots.pipe_climber` but the robot file and the places of its hinges is used: what planning takes from
`weights`, `inertia` and `bars` comes here from the compiled MuJoCo model, what it takes from `inverse`, `jacobian` and
`grippers` from the chain of bodies written out below.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from steeplejack.robots.pipe_climber import Layout, PipeClimber
from steeplejack.simulation.climber.scene import build
from steeplejack.simulation.climber.solids import Solid
from steeplejack.simulation.engine import mujoco

Array = np.ndarray
BEAM = Solid("pipe", "cylinder", np.array([0.0, 0.0, -1.0]), np.array([0.0, 0.0, 1.0]), 0.03)  # the scene wants a pipe
ORDER = (
    "lower_gripper", "lower_jaw_a", "lower_jaw_b", "G1", "G2", "G3", "G4", "lower_platform", "O1", "cylinder1",
    "cylinder2", "cylinder3", "rod1", "rod2", "rod3", "upper_platform", "upper_gripper", "upper_jaw_a", "upper_jaw_b",
)  # fmt: skip
UPPER = ORDER.index("upper_gripper")


@dataclass(frozen=True)
class Bodies:
    """A machine as its bodies in the `ORDER` above, n of them.

    Attributes:
        robot: Its file.
        base: Where the limbs are hinged to the lower platform, along X, (3,) [m].
        platform: Where they are on the upper one, (3,) [m].
        height: Of the linkage's plane over the lower gripper's middle [m].
        jaw: How far the pads of a jaw stand from the gripper's middle, on the thickest pipe [m].
        masses: (n,) [kg].
        middles: Of mass, in each body's frame, (n, 3) [m].
        inertias: About them, along the body's axes, (n, 3, 3) [kg m2].
        carriers: The body that each of m bars is part of, (m,).
        bars: Their ends in its frame, (m, 2, 3) [m].
        radii: (m,) [m].
    """

    robot: PipeClimber
    base: Array
    platform: Array
    height: float
    jaw: float
    masses: Array
    middles: Array
    inertias: Array
    carriers: Array
    bars: Array
    radii: Array

    @classmethod
    def of(cls, robot: PipeClimber) -> Bodies:
        """The bodies of the scene that the physics makes of a robot file."""
        layout = Layout.of(robot)
        model = build(robot, layout, [BEAM], np.zeros(3), (0.3, 0.3))
        order = [model.body(name).id for name in ORDER]
        turns = _turns(model.body_iquat[order])
        inertias = turns @ (model.body_inertia[order][:, :, None] * np.swapaxes(turns, -1, -2))
        capsules = np.flatnonzero((model.geom_type == mujoco.mjtGeom.mjGEOM_CAPSULE) & (model.geom_bodyid > 0))
        axes, half = _turns(model.geom_quat[capsules])[..., 2], model.geom_size[capsules, 1, None]
        middles = model.geom_pos[capsules]
        ends = np.stack((middles - half * axes, middles + half * axes), axis=1)
        carriers = np.array([order.index(body) for body in model.geom_bodyid[capsules]])
        reach = 0.5 * robot.gripper.pipe_diameter[1] + robot.build.pad_radius
        jaw = math.sqrt(reach**2 - (0.5 * robot.build.jaw_width) ** 2)
        return cls(
            robot, layout.base, layout.platform, float(model.body("G1").pos[2]), jaw, model.body_mass[order],
            model.body_ipos[order], inertias, carriers, ends, model.geom_size[capsules, 0],
        )  # fmt: skip

    def limbs(self, poses: Array) -> Array:
        """From hinge to hinge in the mechanism's plane X-Z at poses (k, 3), (k, 3 limbs, 2) [m]."""
        x, w, alpha = (poses[:, axis, None] for axis in range(3))
        along = x + self.platform * np.cos(alpha) - self.base
        return np.stack((along, w - self.platform * np.sin(alpha)), axis=-1)

    def lengths(self, poses: Array) -> Array:
        """Of the cylinders, (k, 3) [m]."""
        return np.hypot(*np.moveaxis(self.limbs(poses), -1, 0))

    def determinant(self, poses: Array) -> Array:
        """Of the cylinders' speeds by the platform's velocity (x, w, alpha), (k,) [m]."""
        limbs = self.limbs(poses)
        unit = limbs / np.linalg.norm(limbs, axis=-1, keepdims=True)
        c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
        arms = -self.platform * (s * unit[..., 0] + c * unit[..., 1])  # how fast P_i goes along its limb as alpha turns
        return np.linalg.det(np.concatenate((unit, arms[..., None]), axis=-1))

    @property
    def windows(self) -> tuple[Array, Array]:
        """Least and largest length of each cylinder, (3,) [m]."""
        cylinders = self.robot.cylinders
        retracted = np.array(cylinders.retracted)
        least, largest = cylinders.reach
        return np.maximum(retracted, least), np.minimum(retracted + cylinders.stroke, largest)

    @property
    def straight_gaps(self) -> tuple[float, float]:
        """Least and largest distance of the grippers on a straight pipe [m]."""
        across, hz = self.platform - self.base, self.robot.linkage.claw_offset
        least, largest = (np.sqrt(lengths**2 - across**2) for lengths in self.windows)
        return float(least.max()) + hz, float(largest.min()) + hz

    def frames(self, freedoms: Array) -> Array:
        """Of every body in the lower gripper's at (x, w, alpha, beta), (k, n, 4, 4)."""
        x, w, alpha, beta = freedoms.T
        rcm, half = self.robot.rcm, self.robot.linkage.half_width
        turned = moved("z", beta)
        cranks = [moved("z", beta, (side * 0.5 * rcm.coupler, 0.0, self.height)) for side in (-1.0, 1.0)]
        couplers = [cranks[0] @ moved("z", -beta, (0.0, side * rcm.crank, 0.0)) for side in (1.0, -1.0)]
        plate = turned @ moved("z", 0.0 * beta, (0.0, rcm.crank, self.height))
        ways, lengths = self.limbs(freedoms[:, :3]), self.lengths(freedoms[:, :3])
        cylinders = [
            turned @ moved("y", np.arctan2(*ways[:, limb].T), (self.base[limb], aside, 0.0))
            for limb, aside in enumerate((half, -half, 0.0))
        ]
        rods = [body @ moved("y", 0.0 * beta, (0.0, 0.0, lengths[:, limb])) for limb, body in enumerate(cylinders)]
        platform = turned @ moved("y", alpha, (x, 0.0, w))
        still = moved("z", 0.0 * beta)
        upper = platform @ moved("z", 0.0 * beta, (0.0, 0.0, self.robot.linkage.claw_offset))
        chain = [still, *self._jaws(still), *cranks, *couplers, plate, turned, *cylinders, *rods, platform]
        return np.stack([*chain, upper, *self._jaws(upper)], axis=1)

    def _jaws(self, gripper: Array) -> list[Array]:
        still = np.zeros(len(gripper))
        return [gripper @ moved("z", still, (side * self.jaw, 0.0, 0.0)) for side in (1.0, -1.0)]

    def bars_at(self, freedoms: Array) -> Array:
        """Ends of all bars in the lower gripper's frame, (k, m, 2, 3) [m]."""
        frames = self.frames(freedoms)[:, self.carriers]
        return np.einsum("kmij,mej->kmei", frames[..., :3, :3], self.bars) + frames[..., None, :3, 3]


def moved(axis: str, angle: Array, offset: tuple[float | Array, ...] = (0.0, 0.0, 0.0)) -> Array:
    """Frames turned about y or z by angles (k,) [rad], at an offset [m], (k, 4, 4)."""
    frames = np.broadcast_to(np.eye(4), (len(angle), 4, 4)).copy()
    first, second = {"y": (2, 0), "z": (0, 1)}[axis]
    frames[:, first, first] = frames[:, second, second] = np.cos(angle)
    frames[:, second, first] = np.sin(angle)
    frames[:, first, second] = -frames[:, second, first]
    for row, along in enumerate(offset):
        frames[:, row, 3] = along
    return frames


def _turns(quaternions: Array) -> Array:
    return Rotation.from_quat(quaternions, scalar_first=True).as_matrix()


def gap_to_axis(bodies: Bodies) -> float:
    """How far bars keep from the axis of a straight pipe, whatever the linkage's turn within its range [m]."""
    least, most = bodies.straight_gaps
    turns = np.linspace(-bodies.robot.rcm.limit, bodies.robot.rcm.limit, 31)
    freedoms = np.column_stack((0.0 * turns, np.linspace(least, most, 31), 0.0 * turns, turns))
    ends = bodies.bars_at(freedoms)
    share = np.linspace(0.0, 1.0, 201)[:, None]
    points = ends[..., None, 0, :] * (1.0 - share) + ends[..., None, 1, :] * share
    away = np.hypot(points[..., 0], points[..., 1]).min(axis=(0, 2)) - bodies.radii
    return math.floor(1e5 * float(away.min())) / 1e5
