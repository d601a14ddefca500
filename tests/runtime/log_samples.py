"""Samples of a run as the supervisor writes them, full of digits; and, run as a program, a run in real time.

``python log_samples.py FILE`` records 20 samples a second until it is killed and prints the time of each when written.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from steeplejack.runtime.recorder import Recorder, State

PERIOD = 0.05  # [s] between samples, as in runtime.run


def sample(at: float, rng: np.random.Generator | None) -> State:
    """A sample with random numbers, or with the shortest there are."""

    def numbers(*shape: int) -> list:  # type: ignore[type-arg]
        return (np.zeros(shape) if rng is None else rng.normal(0.0, 100.0, shape)).tolist()

    three, four = (lambda: numbers(3)), (lambda: numbers(4))
    return State(
        at, 0, "fly", "", 0, three(), three(), three(), four(), four(), four(), three(), four(), four(), four(),
        0.0, 0.0, 0.0, four(), 0.0, four(), four(), four(), numbers(4, 3), numbers(4, 3), 0.0, 0,
    )  # fmt: skip


def record(path: Path) -> None:
    """Record in real time until killed."""
    recorder, rng = Recorder(path), np.random.default_rng(3)
    began = time.monotonic()
    for k in range(10_000):
        time.sleep(max(0.0, began + k * PERIOD - time.monotonic()))
        recorder.write("/state", sample(k * PERIOD, rng), k * PERIOD)
        print(k * PERIOD, flush=True)


if __name__ == "__main__":
    record(Path(sys.argv[1]))
