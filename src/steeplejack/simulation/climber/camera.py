"""A film strip of a climb, rendered without a screen."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from steeplejack.planning.climb.plan import ClimbPlan
from steeplejack.runtime.recorder import Picture
from steeplejack.simulation.climber.plant import ClimberPlant
from steeplejack.simulation.engine import mujoco

Array = NDArray[np.float64]

WIDTH, HEIGHT = 520, 720
QUALITY = 84  # of the JPEG
AWAY = 0.75  # [m] from the robot's middle


class ClimbPhotographer:
    """Takes pictures at even times of a climb, following the robot from the side it leans to.

    Args:
        plant: The robot in physics.
        plan: What it will do.
        count: Number of pictures.
    """

    def __init__(self, plant: ClimberPlant, plan: ClimbPlan, count: int) -> None:
        self._plant = plant
        self._renderer = mujoco.Renderer(plant.model, HEIGHT, WIDTH)
        self._due = [float(time) for time in np.linspace(0.0, plan.duration * 0.995, count)]
        self._view = self._aim()

    def __call__(self, time: float) -> Picture | None:
        """A picture when one is due."""
        if not self._due or time < self._due[0]:
            return None
        self._due.pop(0)
        truth = self._plant.truth()
        self._view.lookat[:] = 0.5 * (truth.lower[:3, 3] + truth.upper[:3, 3])
        self._renderer.update_scene(self._plant.data, self._view)
        stream = io.BytesIO()
        Image.fromarray(self._renderer.render()).save(stream, "JPEG", quality=QUALITY)
        stamp = {"sec": int(time), "nsec": int(1e9 * (time % 1.0))}
        return Picture(stamp, f"t = {time:.1f} s", stream.getvalue(), "jpeg")

    def close(self) -> None:
        """Free the renderer."""
        self._renderer.close()

    def _aim(self) -> mujoco.MjvCamera:  # pyright: ignore
        """A camera across the plane of the limbs, a little from the front; it does not turn with the robot."""
        axes = self._plant.truth().lower[:3, :3]
        eye = -0.82 * axes[:, 1] - 0.5 * axes[:, 0] + 0.28 * np.array([0.0, 0.0, 1.0])
        eye /= np.linalg.norm(eye)
        view = mujoco.MjvCamera()
        view.distance = AWAY
        view.azimuth = float(np.degrees(np.arctan2(-eye[1], -eye[0])))
        view.elevation = float(np.degrees(np.arcsin(-eye[2])))
        return view
