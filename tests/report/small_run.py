"""A short run on straight stays, written sample by sample, so that every error in it is known."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from steeplejack.planning.mission import FORMAT, Leg, Mission, Request, Uncovered, Waypoint
from steeplejack.robots.squad.anchorage import exits, facing
from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Squad, load_squad
from steeplejack.runtime.recorder import Event, Picture, Recorder, Seed, Site, State, StayRecord, VerdictRecord
from steeplejack.spatial import to_quaternion
from steeplejack.worksite import Fan, Interval, Stay

Array = NDArray[np.float64]
Offset = Callable[[int, Array], Array]  # sample number, axes (3, 3) across, along, towards the stays -> offset (3,) [m]

SQUAD: Squad = load_squad()
GRAVITY = (0.0, 0.0, -9.81)
STEP = 0.05  # [s]
FROM, TO = 20.0, 26.0
STAND_OFF = 0.6
TENSION = (150.0, 120.0, 110.0, 160.0)
CLEAN = ("B0", "S1", "S2", "B3")


def no_offset(sample: int, axes: Array) -> Array:
    return np.zeros(3)


def bay_of(names: tuple[str, ...] = CLEAN, squad: Squad = SQUAD) -> Bay:
    """Four parallel stays 4 m apart in a plane that leans."""
    stays: list[Stay] = []
    for k, name in enumerate(names):
        x, y, z = 1.0 * k, 4.0 * k, 0.6 * k
        zones = (Interval(0.0, 2.5, "end zone", note="estimate: tube"), Interval(68.0, 72.0, "end zone"))
        upper = (x + 55.0, y - 6.0, z + 42.0)
        stays.append(Stay(name, "1", "L", "main", k, (x, y, z), upper, diameter=0.11, intervals=zones))
    return Bay.of(Fan("T1L-main", tuple(stays)), 0, len(names) - 1, "under", squad)


@dataclass
class Run:
    """What is put into the log; the defaults are a run without fault or error."""

    names: tuple[str, ...] = CLEAN
    offset: Offset = no_offset  # actual less desired position
    drift: Array = field(default_factory=lambda: np.zeros((4, 3)))  # true less measured winch exits [m]
    until: float = np.inf  # [s] of a breach
    breach: str = "cable slack (4)"
    uncovered: tuple[Uncovered, ...] = ()
    legs: tuple[int, ...] = (0, 1, 2, 3)  # see spans_of
    note: str = "mission complete"
    picture: bytes | None = None
    picture_format: str = "png"
    assumed: tuple[str, ...] = ()
    margin: float = 0.4
    turn: Array = field(default_factory=lambda: np.eye(3))  # actual from desired rotation, platform frame
    actual: Squad | None = None  # that physics ran, where it is not the file's


def png() -> bytes:
    stream = io.BytesIO()
    Image.new("RGB", (8, 6), (20, 90, 150)).save(stream, "PNG")
    return stream.getvalue()


def waypoint(place: tuple[float, float, float], travel: float, s: Array, bay: Bay) -> Waypoint:
    position = bay.place(*place)
    a, b, c, d = (float(x) for x in s)
    w, x, y, z = (float(q) for q in to_quaternion(bay.frame(place[0], place[1])))
    p = (float(position[0]), float(position[1]), float(position[2]))
    clock = (0.0, 0.0, 0.0, 0.0)
    return Waypoint(travel, place, p, (w, x, y, z), TENSION, (a, b, c, d), clock)


@dataclass(frozen=True)
class Span:
    """A leg by its ends: places (3,) of the platform, places (4,) of the bases [m]."""

    kind: Literal["inspect", "fly", "drive"]
    stance: int
    start: Array
    end: Array
    s0: Array
    s1: Array

    def leg(self, run: Run, bay: Bay) -> Leg:
        """As it stands in the mission."""
        points = tuple(
            waypoint((float(p[0]), float(p[1]), float(p[2])), travel, s, bay)
            for p, travel, s in ((self.start, 0.0, self.s0), (self.end, 6.0, self.s1))
        )
        stay = run.names[round(self.start[0])] if self.kind == "inspect" else None
        return Leg(self.kind, self.stance, stay, 3 if self.kind == "drive" else None, 0.25, 0.1, points)


def spans_of(run: Run, bay: Bay) -> list[Span]:
    """Up the first interior stay, over to the second, base 3 drives, down the second."""
    off = bay.radius(1) + STAND_OFF
    before, after = np.array([15.0, 16.0, 40.0, 38.0]), np.array([15.0, 16.0, 44.0, 38.0])
    low, high = np.array([1.0, FROM, off]), np.array([1.0, TO, off])
    over, back = np.array([2.0, TO, off]), np.array([2.0, FROM, off])
    every = (
        Span("inspect", 0, low, high, before, before),
        Span("fly", 0, high, over, before, before),
        Span("drive", 1, over, over, before, after),
        Span("inspect", 1, over, back, after, after),
    )
    return [every[i] for i in run.legs]


def mission_of(run: Run, bay: Bay, legs: list[Leg]) -> Mission:
    request = Request("small", SQUAD.name, bay.fan, (0, len(run.names) - 1), FROM, TO, "under", 0.0, (20.0, 250.0))
    carriers = tuple(run.names[k] for k in bay.carriers)
    return Mission(
        FORMAT,
        request,
        (run.names[0], run.names[-1]),
        run.names[1:-1],
        (carriers[0], carriers[1], carriers[2], carriers[3]),
        0.1,
        run.assumed,
        tuple(legs),
        run.uncovered,
    ).sealed()


def write_run(path: Path, run: Run | None = None, samples: int = 120) -> Path:
    """Write the log of a run, ``samples`` samples a leg."""
    run = run or Run()
    bay = bay_of(run.names)
    spans = spans_of(run, bay)
    legs = [span.leg(run, bay) for span in spans]
    recorder = Recorder(path)
    stays = tuple(StayRecord.of(stay) for stay in bay.stays)
    verdicts = (
        *(VerdictRecord(name, True, (), ()) for name in run.names[:-1]),
        VerdictRecord(run.names[-1], None, (), ("diameter",)),
        VerdictRecord("far", False, ("diameter 160 mm outside 90-120 mm",), ()),
    )
    recorder.write("/worksite", Site("small", "made up", GRAVITY, stays, verdicts), 0.0)
    recorder.write("/robot", SQUAD, 0.0)
    if run.actual is not None:
        recorder.write("/robot/actual", run.actual, 0.0)
    recorder.write("/mission", mission_of(run, bay, legs), 0.0)
    recorder.write("/seed", Seed(7, "0.0.0"), 0.0)
    if run.picture is not None:
        recorder.write(
            "/camera", Picture({"sec": 1, "nsec": 0}, f"at {run.names[1]}", run.picture, run.picture_format), 1.0
        )
    time = 0.0
    for number, (leg, span) in enumerate(zip(legs, spans, strict=True)):
        recorder.write("/event", Event(time, "phase", f"leg {number}: {leg.kind}"), time)
        for sample in _states(run, bay, number, leg, span, time, samples):
            recorder.write("/state", sample, sample.time_s)
        time += STEP * samples
        if time > run.until:
            recorder.write("/event", Event(time, "breach", run.breach), time)
            recorder.write("/event", Event(time, "stop", "stopped on brakes, palms closed"), time)
            break
    else:
        recorder.write("/event", Event(time, "note", run.note), time)
    recorder.close()
    return path


def _states(run: Run, bay: Bay, number: int, leg: Leg, span: Span, since: float, samples: int) -> Iterator[State]:
    share = np.linspace(0.0, 1.0, samples)[:, None]
    places, s = span.start + share * (span.end - span.start), span.s0 + share * (span.s1 - span.s0)
    desired = bay.place(places[:, 0], places[:, 1], places[:, 2])
    axes = bay.frame(1.5, 0.5 * (FROM + TO))  # the same everywhere: the stays are straight and parallel
    quaternion, tension = to_quaternion(axes).tolist(), list(TENSION)
    turned = to_quaternion(axes @ run.turn).tolist()
    measured, _tangents, _arms = exits(bay, SQUAD, s, facing(bay, s, bay.place(1.5, 0.5 * (FROM + TO), 0.6)))
    for i in range(samples):
        time = since + STEP * i
        phase = "stopped on brakes" if time > run.until else "drive" if leg.kind == "drive" else "fly"
        yield State(
            time, number, phase, leg.stay or "", 3 if phase == "drive" else 0,
            desired[i].tolist(), desired[i].tolist(), (desired[i] + run.offset(i, axes)).tolist(),
            quaternion, quaternion, turned, [0.0, 0.0, 0.0],
            tension, tension, tension, 170.0, 100.0, run.margin, [0.6, 0.5, run.margin, 0.7], 0.3,
            *3 * [s[i].tolist()], measured[i].tolist(), (measured[i] + run.drift).tolist(), 0.001, 0,
        )  # fmt: skip
