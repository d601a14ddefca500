"""How the robot in physics really is; for the log and for tests, never for the controller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from steeplejack.simulation.climber.solids import Array

ENDS = ("lower", "upper")


@dataclass(frozen=True)
class Truth:
    """Where everything is and what presses on what.

    Attributes:
        lower: Homogeneous transform of the lower gripper in the world (4, 4).
        upper: Of the upper gripper (4, 4).
        forces: Of the cylinders, positive when pushing (3,) [N].
        normal: Sum of the pads' normal forces of each gripper (2,) [N].
        press: What the jaws of each press with along their way, both together (2,) [N].
        wrench: Of the pipe on each gripper through its pads, (moment; force) in its frame (2, 6) [N m, N].
        touching: Pairs of geoms that touch and should not.
    """

    lower: Array
    upper: Array
    forces: Array
    normal: Array
    press: Array
    wrench: Array
    touching: tuple[tuple[str, str], ...]


class Eyes:
    """Reads the truth out of a model.

    Args:
        model: The compiled scene.
        data: Its state.
    """

    def __init__(self, model: Any, data: Any) -> None:
        self._model, self._data = model, data
        self._sites = np.array([int(model.site(end).id) for end in ENDS])
        self._gripper = np.full(model.ngeom, -1)  # of which gripper a geom is a pad
        for i, end in enumerate(ENDS):
            self._gripper[[int(model.geom(f"{end}_{jaw}{k}").id) for jaw in "ab" for k in range(4)]] = i
        names = [model.geom(k).name for k in range(model.ngeom)]
        self._side = np.zeros(model.ngeom)  # of a pad, that of its jaw along X
        for name, side in (("a", 1.0), ("b", -1.0)):
            self._side[[int(model.geom(f"{end}_{name}{k}").id) for end in ENDS for k in range(4)]] = side
        self._names = [name or "a limb" for name in names]
        self._obstacle = np.array([name.startswith("obstacle") for name in names])

    def pads(self, gripper: int) -> NDArray[np.int64]:
        """Geoms that are pads of a gripper (8,)."""
        return np.flatnonzero(self._gripper == gripper)

    def frames(self) -> Array:
        """Places and axes by rows of the grippers in the world (2, 12) [m, 1]."""
        return np.concatenate((self._data.site_xpos[self._sites], self._data.site_xmat[self._sites]), axis=1)

    def __call__(self) -> Truth:
        """The truth now."""
        frames = self.frames()
        contact = self._data.contact
        pressing = np.flatnonzero(contact.exclude == 0)  # the others are too far apart
        geoms = contact.geom[pressing]
        gripper = self._gripper[geoms].max(axis=1)
        wrong = (gripper < 0) | self._obstacle[geoms].any(axis=1)
        touching = tuple((self._names[a], self._names[b]) for a, b in geoms[wrong])
        borne = [self._borne(pressing[~wrong & (gripper == end)], frames[end]) for end in range(2)]
        normal, press, wrench = (np.array(each) for each in zip(*borne, strict=True))
        lower, upper = (_transform(frame) for frame in frames)
        forces = self._data.actuator_force[:3].copy()
        return Truth(lower, upper, forces, normal, press, wrench, touching)

    def _borne(self, contacts: NDArray[np.int64], frame: Array) -> tuple[float, float, Array]:
        """What the pads of a gripper press with and bear: normal forces, along the jaws' way, wrench."""
        if not len(contacts):
            return 0.0, 0.0, np.zeros(6)
        contact = self._data.contact
        geoms, address = contact.geom[contacts], contact.efc_address[contacts]
        force = self._data.efc_force[address[:, None] + np.arange(3)]  # elliptic cones: along the axes
        pad = np.where(self._gripper[geoms[:, 1]] >= 0, geoms[:, 1], geoms[:, 0])
        pushed = np.where(pad == geoms[:, 1], 1.0, -1.0)  # the force is that on the second geom
        turn = frame[3:].reshape(3, 3)  # columns are the gripper's axes
        axes, arms = contact.frame[contacts].reshape(-1, 3, 3), (contact.pos[contacts] - frame[:3]) @ turn
        pads = pushed[:, None] * np.einsum("ck,ckj->cj", force, axes) @ turn
        wrench = np.concatenate((np.cross(arms, pads).sum(axis=0), pads.sum(axis=0)))
        return float(force[:, 0].sum()), float(self._side[pad] @ pads[:, 0]), wrench


def _transform(frame: Array) -> Array:
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = frame[3:].reshape(3, 3), frame[:3]
    return out
