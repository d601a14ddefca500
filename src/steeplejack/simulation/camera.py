"""Pictures of the squad at work, rendered without a screen."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from steeplejack.planning.mission import Leg
from steeplejack.runtime.recorder import Picture
from steeplejack.simulation.engine import mujoco
from steeplejack.simulation.plant import SquadPlant

Array = NDArray[np.float64]

WIDTH, HEIGHT = 960, 600
QUALITY = 82  # of the JPEG


class Photographer:
    """Takes a few pictures of a run: close by while the platform inspects, from afar while a base drives.

    Args:
        plant: The simulated squad.
        legs: The mission's legs.
        starts: When each leg is expected to start, and the last to end [s].
        normal: Outward normal of the inspected face (3,).
        most: Number of pictures of each kind.
    """

    def __init__(self, plant: SquadPlant, legs: tuple[Leg, ...], starts: Array, normal: Array, most: int = 4) -> None:
        self._plant, self._normal = plant, normal
        self._renderer = mujoco.Renderer(plant.model, HEIGHT, WIDTH)
        self._due: list[tuple[float, int]] = []
        for kind in ("inspect", "drive"):
            chosen = [i for i, leg in enumerate(legs) if leg.kind == kind]
            for i in np.unique(np.linspace(0, len(chosen) - 1, min(most, len(chosen))).astype(int)) if chosen else ():
                leg = chosen[int(i)]
                self._due.append((float(0.5 * (starts[leg] + starts[leg + 1])), leg))
        self._due.sort()
        self._legs = legs

    def __call__(self, time: float) -> Picture | None:
        """A picture when one is due."""
        if not self._due or time < self._due[0][0]:
            return None
        leg = self._legs[self._due.pop(0)[1]]
        what = f"base {leg.base} drives" if leg.base else f"inspecting {leg.stay}"
        return self._take(time, f"{what}, t = {time:.0f} s", wide=leg.base is not None)

    def close(self) -> None:
        """Free the renderer."""
        self._renderer.close()

    def _mark(self, points: Array, size: float) -> None:
        """Spheres at the bases and the platform, which a wide picture would lose."""
        scene = self._renderer.scene
        for i, point in enumerate(points):
            colour = np.array([0.12, 0.38, 0.62, 1.0] if i == 4 else [0.93, 0.55, 0.13, 1.0], np.float32)
            shape = np.full(3, size)
            kind = mujoco.mjtGeom.mjGEOM_SPHERE
            mujoco.mjv_initGeom(scene.geoms[scene.ngeom], kind, shape, point, np.eye(3).ravel(), colour)
            scene.ngeom += 1

    def _take(self, time: float, caption: str, wide: bool) -> Picture:
        truth = self._plant.truth()
        points = np.vstack([truth.exits, truth.position])
        target = points.mean(axis=0) if wide else truth.position
        distance = 1.05 * float(np.linalg.norm(np.ptp(points, axis=0))) if wide else 2.4
        # From under the face, a little to the side and below, looking back at the stays.
        side = np.cross(self._normal, np.array([0.0, 0.0, 1.0]))
        eye = 0.93 * self._normal + 0.28 * side + np.array([0.0, 0.0, -0.25])
        eye /= np.linalg.norm(eye)
        view = mujoco.MjvCamera()
        view.lookat[:] = target
        view.distance = distance
        view.azimuth = float(np.degrees(np.arctan2(-eye[1], -eye[0])))
        view.elevation = float(np.degrees(np.arcsin(-eye[2])))
        model = self._plant.model
        model.tendon_width[:] = 0.004 * distance
        self._renderer.update_scene(self._plant.data, view)
        if wide:
            self._mark(points, 0.012 * distance)
            caption += "; marks and cables drawn larger"
        stream = io.BytesIO()
        Image.fromarray(self._renderer.render()).save(stream, "JPEG", quality=QUALITY)
        stamp = {"sec": int(time), "nsec": int(1e9 * (time % 1.0))}
        return Picture(stamp, caption, stream.getvalue(), "jpeg")
