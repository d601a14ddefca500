"""From a log to figures of merit: coverage, loads, accuracy and time."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.coverage import Seen, clock_coverage, coverage_fraction, not_covered, observe
from steeplejack.planning.mission import Uncovered
from steeplejack.report.accuracy import Accuracy
from steeplejack.report.boundary import Driven, observe_boundary
from steeplejack.report.flown import Flown
from steeplejack.report.log import Log
from steeplejack.runtime.gait import Phase

Array = NDArray[np.float64]

ENDED = "the run ended early"
KINDS = ("inspect", "fly", "brace", "drive")  # of legs, in the order of their activities
ACTIVITIES = (
    "inspecting",
    "flying between stays",
    "shifting load between the bases",
    "driving bases",
    "opening, closing and checking grips",
    "stopped on the brakes",
)
DRIVING, GRIPPING, STOPPED = 3, 4, 5


class Range(msgspec.Struct, frozen=True):
    """Least and largest value; not a number where there are none."""

    min: float
    max: float


class Spread(msgspec.Struct, frozen=True):
    """Mean and standard deviation; not a number where there are no values."""

    mean: float
    std: float

    @classmethod
    def of(cls, values: Array) -> Spread:
        """Of any number of values."""
        return cls(float(np.mean(values)), float(np.std(values))) if len(values) else cls(np.nan, np.nan)


class Size(msgspec.Struct, frozen=True):
    """Mean and largest value; not a number where there are none."""

    mean: float
    max: float


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """What a run achieved; the names are those of ``steeplejack inspect --json``."""

    coverage_fraction: float  # [1] of the interior length asked for, on the faced sector
    clock_coverage: float  # [1] of all sectors over that length
    not_covered: tuple[Uncovered, ...]
    duration_s: float
    distance_m: float  # flown by the platform
    stances: int  # from which it inspected
    moves: int  # squad moves finished
    max_tension_n: float
    min_slip_margin: float  # least of 1 - pull / limit
    min_tension_factor: float  # while inspecting
    stand_off_m: Range  # from the inspected stay's surface
    error_along_mm: Spread  # relative to the true anchors
    error_across_mm: Spread
    error_stand_off_mm: Spread
    absolute_error_mm: Size  # in the world, odometry drift included
    faults: tuple[str, ...]


@dataclass(frozen=True)
class Analysis:
    """The summary and what it was drawn from."""

    summary: Summary
    seen: tuple[Seen, ...]  # interior stays
    driven: tuple[Driven, Driven]  # boundary stays
    accuracy: Accuracy
    flown: Flown
    activity: NDArray[np.int64]  # (n,) index into ``ACTIVITIES`` of every sample
    time_by_activity: Array  # (6,) [s]


def analyse(log: Log) -> Analysis:
    """Everything a report says in numbers, from the log alone."""
    request, states = log.mission.request, log.states
    awake = ~states.stopped
    position, rotation = states.actual_position[awake], states.actual_rotation[awake]
    seen = observe(log.bay, log.squad.camera, position, rotation, request.from_m, request.to_m)
    # Without ring cameras no base sees anything, wherever it drives.
    seeing = states.base_moving if log.squad.base.ring_camera else np.zeros_like(states.base_moving)
    driven = observe_boundary(log.bay, states.actual_s, seeing, request.from_m, request.to_m)
    accuracy = Accuracy.of(log)
    activity = _activity(log)
    steps = np.diff(states.time, append=states.time[-1])
    spent = np.array([float(steps[activity == kind].sum()) for kind in range(len(ACTIVITIES))])
    return Analysis(_summary(log, seen, accuracy), seen, driven, accuracy, Flown.of(log), activity, spent)


def _summary(log: Log, seen: tuple[Seen, ...], accuracy: Accuracy) -> Summary:
    states, legs = log.states, log.mission.legs
    last = len(legs) if log.accomplished else int(states.leg[-1])
    flown = states.leg[accuracy.sample]
    along, across, off = (Spread.of(1e3 * accuracy.relative[:, i]) for i in range(3))
    some = len(accuracy.sample) > 0
    return Summary(
        coverage_fraction=coverage_fraction(seen),
        clock_coverage=clock_coverage(seen),
        not_covered=tuple(_rounded(gap) for gap in not_covered(seen, (*log.mission.uncovered, *_left(log, last)))),
        duration_s=float(states.time[-1]),
        distance_m=float(np.sum(np.linalg.norm(np.diff(states.actual_position, axis=0), axis=1))),
        stances=len({legs[i].stance for i in flown}),
        moves=_moves(log, last),
        max_tension_n=float(states.max_tension.max()),
        min_slip_margin=float(states.slip_margin.min()),
        min_tension_factor=float(states.tension_factor[accuracy.sample].min()) if some else np.nan,
        stand_off_m=Range(float(accuracy.stand_off.min()), float(accuracy.stand_off.max()))
        if some
        else Range(np.nan, np.nan),
        error_along_mm=along,
        error_across_mm=across,
        error_stand_off_mm=off,
        absolute_error_mm=_size(1e3 * accuracy.absolute) if some else Size(np.nan, np.nan),
        faults=log.faults,
    )


def _size(values: Array) -> Size:
    return Size(float(values.mean()), float(values.max()))


def _rounded(gap: Uncovered) -> Uncovered:
    """To the millimetre: cells are a tenth of a metre."""
    return Uncovered(gap.stay, round(gap.from_m, 3), round(gap.to_m, 3), gap.why)


def _left(log: Log, last: int) -> list[Uncovered]:
    """What the legs from number ``last`` on would have inspected."""
    out: list[Uncovered] = []
    for leg in log.mission.legs[last:]:
        if leg.kind == "inspect" and leg.stay is not None:
            places = [point.place[1] for point in leg.waypoints]
            out.append(Uncovered(leg.stay, min(places), max(places), ENDED))
    return out


def _moves(log: Log, last: int) -> int:
    """Squad moves all of whose drives lie before leg ``last``."""
    ends = {leg.stance: i for i, leg in enumerate(log.mission.legs) if leg.kind == "drive"}
    return sum(end < last for end in ends.values())


def _activity(log: Log) -> NDArray[np.int64]:
    """What the squad was doing at every sample, as index into ``ACTIVITIES``."""
    states = log.states
    activity = np.array([KINDS.index(leg.kind) for leg in log.mission.legs])[states.leg]
    activity[(activity == DRIVING) & (states.phase != Phase.DRIVE.value)] = GRIPPING
    activity[states.stopped] = STOPPED
    return activity
