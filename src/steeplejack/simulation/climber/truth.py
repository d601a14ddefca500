"""How the robot in physics really is; for the log and for tests, never for the controller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from steeplejack.simulation.climber.solids import Array

ENDS = ("lower", "upper")


@dataclass(frozen=True)
class Contacts:
    """Where the pads of a gripper touch a pipe, in the gripper's frame.

    Attributes:
        places: (k, 3) [m].
        normals: Of the pipe's surface, outward (k, 3) [1].
        jaws: 1 on the jaw at +X, -1 on the other (k,).
        friction: (k,) [1].
    """

    places: Array
    normals: Array
    jaws: Array
    friction: Array


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
        pads: Where those of each touch.
        touching: Pairs of geoms that touch and should not.
    """

    lower: Array
    upper: Array
    forces: Array
    normal: Array
    press: Array
    wrench: Array
    pads: tuple[Contacts, Contacts]
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
        held = [self._held(pressing[~wrong & (gripper == end)], frames[end]) for end in range(2)]
        borne = [_borne(pads, force) for pads, force, _normal in held]
        normal = np.array([float(pushed.sum()) for _pads, _force, pushed in held])
        press, wrench = (np.array(each) for each in zip(*borne, strict=True))
        lower, upper = (_transform(frame) for frame in frames)
        forces = self._data.actuator_force[:3].copy()
        return Truth(lower, upper, forces, normal, press, wrench, (held[0][0], held[1][0]), touching)

    def _held(self, contacts: NDArray[np.int64], frame: Array) -> tuple[Contacts, Array, Array]:
        """Where pads of a gripper touch, the forces on them in its frame (k, 3) and the normal ones (k,) [N]."""
        contact = self._data.contact
        geoms, address = contact.geom[contacts], contact.efc_address[contacts]
        force = self._data.efc_force[address[:, None] + np.arange(3)]  # elliptic cones: along the axes
        pad = np.where(self._gripper[geoms[:, 1]] >= 0, geoms[:, 1], geoms[:, 0])
        pushed = np.where(pad == geoms[:, 1], 1.0, -1.0)[:, None]  # the force is that on the second geom
        turn = frame[3:].reshape(3, 3)  # columns are the gripper's axes
        axes = pushed[:, None] * (contact.frame[contacts].reshape(-1, 3, 3) @ turn)
        places = (contact.pos[contacts] - frame[:3]) @ turn
        pads = Contacts(places, axes[:, 0], self._side[pad], contact.friction[contacts, 0])
        return pads, np.einsum("ck,ckj->cj", force, axes), force[:, 0]


def _borne(pads: Contacts, forces: Array) -> tuple[float, Array]:
    """What a gripper's jaws press with along their way, and the wrench its pads bear."""
    wrench = np.concatenate((np.cross(pads.places, forces).sum(axis=0), forces.sum(axis=0)))
    return float(pads.jaws @ forces[:, 0]), wrench


def _transform(frame: Array) -> Array:
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = frame[3:].reshape(3, 3), frame[:3]
    return out
