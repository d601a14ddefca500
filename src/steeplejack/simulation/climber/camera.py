"""Pictures of a climb, rendered without a screen: a film strip for the report, and a film."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from steeplejack.runtime.recorder import Picture
from steeplejack.simulation.climber.plant import ClimberPlant
from steeplejack.simulation.engine import mujoco

Array = NDArray[np.float64]

WIDTH, HEIGHT = 520, 720
QUALITY = 84  # of the strip's JPEG
AWAY = 0.75  # [m] from the robot's middle
FRAMES, FRAME_TIME = 200, 80  # most frames of a film, and how long each stands [ms]
FILM_WIDTH, FILM_QUALITY = 390, 60
INK = (30, 40, 55)


class Camera:
    """Follows the robot from a side that does not turn with it.

    Args:
        plant: The robot in physics.
    """

    def __init__(self, plant: ClimberPlant) -> None:
        self._plant = plant
        self._renderer = mujoco.Renderer(plant.model, HEIGHT, WIDTH)
        self._view = self._aim()

    def take(self, shadows: bool = True) -> Image.Image:
        """A picture of the robot where it is now; shadows take more than half of its time."""
        truth = self._plant.truth()
        self._view.lookat[:] = 0.5 * (truth.lower[:3, 3] + truth.upper[:3, 3])
        self._renderer.update_scene(self._plant.data, self._view)
        self._renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = shadows
        return Image.fromarray(self._renderer.render())

    def close(self) -> None:
        """Free the renderer."""
        self._renderer.close()

    def _aim(self) -> mujoco.MjvCamera:  # pyright: ignore
        """A camera across the plane of the limbs, a little from the front."""
        axes = self._plant.truth().lower[:3, :3]
        eye = -0.82 * axes[:, 1] - 0.5 * axes[:, 0] + 0.28 * np.array([0.0, 0.0, 1.0])
        eye /= np.linalg.norm(eye)
        view = mujoco.MjvCamera()
        view.distance = AWAY
        view.azimuth = float(np.degrees(np.arctan2(-eye[1], -eye[0])))
        view.elevation = float(np.degrees(np.arcsin(-eye[2])))
        return view


class Strip:
    """Pictures at even times of a climb.

    Args:
        camera: That takes them.
        duration: Of the climb as planned [s].
        count: Of pictures.
    """

    def __init__(self, camera: Camera, duration: float, count: int) -> None:
        self._camera = camera
        self._due = [float(time) for time in np.linspace(0.0, duration * 0.995, count)]

    def __call__(self, time: float) -> Picture | None:
        """A picture when one is due."""
        if not self._due or time < self._due[0]:
            return None
        self._due.pop(0)
        stream = io.BytesIO()
        self._camera.take().save(stream, "JPEG", quality=QUALITY)
        return Picture(_stamp(time), f"t = {time:.1f} s", stream.getvalue(), "jpeg")


class Film:
    """An animated picture of a climb, as fast as its frames allow.

    Args:
        camera: That takes the frames.
        duration: Of the climb as planned [s].
    """

    def __init__(self, camera: Camera, duration: float) -> None:
        self._camera = camera
        self._speed = max(1.0, duration / (1e-3 * FRAME_TIME * FRAMES))
        self._next = 0.0
        self._frames: list[Image.Image] = []
        self._font = ImageFont.load_default(14)

    def __call__(self, time: float) -> None:
        """Take a frame when one is due."""
        if time < self._next:
            return
        self._next += 1e-3 * FRAME_TIME * self._speed
        frame = self._camera.take(shadows=False)
        frame = frame.resize((FILM_WIDTH, round(FILM_WIDTH * frame.height / frame.width)))
        ImageDraw.Draw(frame).text((10, 8), f"{time:.1f} s", fill=INK, font=self._font)
        self._frames.append(frame)

    def finished(self, time: float) -> Picture | None:
        """The film as WebP; None without frames."""
        if not self._frames:
            return None
        stream = io.BytesIO()
        self._frames[0].save(
            stream, "WEBP", save_all=True, append_images=self._frames[1:], duration=FRAME_TIME, loop=0,
            quality=FILM_QUALITY,
        )  # fmt: skip
        return Picture(_stamp(time), f"{self._speed:.1f} times as fast", stream.getvalue(), "webp")


def _stamp(time: float) -> dict[str, int]:
    return {"sec": int(time), "nsec": int(1e9 * (time % 1.0))}
