"""The log of a climb read back, also where the run was killed and the file ends in the middle."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import InputError
from steeplejack.report.log import decoded, messages_of, only
from steeplejack.robots.pipe_climber import Layout, PipeClimber
from steeplejack.runtime.climb_record import ClimbSample, EndRecord, GripRecord, PlanRecord, RunRecord
from steeplejack.runtime.recorder import Event, Picture

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Columns:
    """The samples of a climb as columns, in the order of time."""

    time: Array  # (n,) [s]
    phase: NDArray[np.int64]  # (n,) index into the plan
    act: NDArray[np.str_]  # (n,)
    closed: NDArray[np.bool_]  # (n, 2)
    reference: Array  # (n, 4) (x, w, alpha, beta) [m, m, rad, rad]
    actual: Array  # (n, 4)
    lengths: Array  # (n, 3) [m]
    speeds: Array  # (n, 3) [m/s]
    forces: Array  # (n, 3) [N] positive when pushing
    strongest: Array  # (n,) [N] since the sample before
    grip: Array  # (n, 2) [N]
    margin: Array  # (n, 2) [1], NaN where a gripper is not counted on
    slip: Array  # (n, 2) [m] since a gripper closed
    lower: Array  # (n, 3) [m] world
    upper: Array  # (n, 3) [m]
    travelled: Array  # (n,) [m]
    energy: Array  # (n,) [J]
    collisions: NDArray[np.int64]  # (n,)

    @classmethod
    def of(cls, samples: list[ClimbSample]) -> Columns:
        """Columns of at least one sample."""
        margins = [[np.nan if one is None else one for one in sample.margin] for sample in samples]
        return cls(
            np.array([one.time_s for one in samples]),
            np.array([one.phase for one in samples]),
            np.array([one.act for one in samples]),
            np.array([one.closed for one in samples]),
            np.array([one.reference for one in samples]),
            np.array([one.actual for one in samples]),
            np.array([one.lengths_m for one in samples]),
            np.array([one.speeds_m_s for one in samples]),
            np.array([one.forces_n for one in samples]),
            np.array([one.max_force_n for one in samples]),
            np.array([one.grip_n for one in samples]),
            np.array(margins, dtype=np.float64),
            np.array([one.slip_m for one in samples]),
            np.array([one.lower_m for one in samples]),
            np.array([one.upper_m for one in samples]),
            np.array([one.travelled_m for one in samples]),
            np.array([one.energy_j for one in samples]),
            np.array([one.collisions for one in samples]),
        )


@dataclass(frozen=True)
class ClimbLog:
    """One climb, as recorded; ``end`` is None where the log breaks off."""

    path: Path
    run: RunRecord
    robot: PipeClimber
    plan: PlanRecord
    samples: Columns
    grips: tuple[GripRecord, ...]
    events: tuple[Event, ...]
    pictures: tuple[Picture, ...]
    film: Picture | None
    end: EndRecord | None

    @property
    def layout(self) -> Layout:
        """Hinges of the robot's limbs."""
        return Layout.of(self.robot)


def film_of(path: Path) -> bytes | None:
    """The film in the log of a climb, as WebP; None if it has none."""
    films = decoded(path, messages_of(path)[0], "/film", Picture)
    return films[-1].data if films else None


def is_climb(path: Path) -> bool:
    """Whether a log is that of a climb."""
    return "/climb" in messages_of(path)[0]


def read_climb(path: Path) -> ClimbLog:
    """Read the log of a climb; a file that breaks off gives everything up to there.

    Args:
        path: An MCAP file.

    Raises:
        InputError: It cannot be read, is not an MCAP file, or lacks what a report needs.
    """
    messages, _ = messages_of(path)
    samples = decoded(path, messages, "/climb", ClimbSample)
    if not samples:
        raise InputError(str(path), "no samples in /climb", "a log written by `steeplejack climb`")
    ends = decoded(path, messages, "/end", EndRecord)
    films = decoded(path, messages, "/film", Picture)
    return ClimbLog(
        path,
        only(path, messages, "/run", RunRecord),
        only(path, messages, "/robot", PipeClimber),
        only(path, messages, "/plan", PlanRecord),
        Columns.of(samples),
        tuple(decoded(path, messages, "/grip", GripRecord)),
        tuple(decoded(path, messages, "/event", Event)),
        tuple(decoded(path, messages, "/camera", Picture)),
        films[-1] if films else None,
        ends[-1] if ends else None,
    )
