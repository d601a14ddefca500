"""MuJoCo, set to draw without a screen.

MuJoCo chooses its OpenGL platform when it is imported, and a type checker cannot see into its compiled half: both are
settled here, once, for the whole room.
"""

import ctypes.util
import importlib
import os
from typing import Any

if "MUJOCO_GL" not in os.environ and "DISPLAY" not in os.environ:
    os.environ["MUJOCO_GL"] = "egl" if ctypes.util.find_library("EGL") else "disable"

mujoco: Any = importlib.import_module("mujoco")
