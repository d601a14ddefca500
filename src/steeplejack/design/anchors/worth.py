"""What a configuration of the anchors is worth at a pose: its tension factor, or the slip margin under a load.

Four cables in a plane leave one freedom of the tensions, ``f = f_p + lambda n``. Along it every limit is linear, so the
tensions that are allowed form an interval, and the largest least margin on it lies at an end or where the margins of
two bases cross. Source: squad.md's limits on a base, over Zheng et al., CCRobot-S, IEEE T-RO, Eq. 7-12.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.design.anchors.problem import Reconfiguration
from steeplejack.design.anchors.twists import factor_of
from steeplejack.errors import InputError
from steeplejack.mechanics.cable.wrench.hyperplanes import TOLERANCE

Array = NDArray[np.float64]
Flags = NDArray[np.uint8]
Objective = Literal["tension-factor", "slip-margin"]

GRIPPED = np.uint8(16)  # the bit of a configuration that holds with every base gripped; bit i: with base i driving


@dataclass(frozen=True)
class Duty:
    """What the platform must bear while the anchors are rearranged, and what counts as good.

    Attributes:
        objective: Tension factor (Eq. 12), or the largest least ``1 - pull / limit`` over the bases.
        mass: Held at rest, at p [kg]; None asks for wrench closure alone.
        window: Least and largest tension [N].
        gravity: Of the worksite, (2,) [m/s2].
        hold: Largest pull along the stay of a gripped base [N].
        drive: The same of a base that drives [N].
    """

    objective: Objective = "tension-factor"
    mass: float | None = None
    window: tuple[float, float] = (0.0, np.inf)
    gravity: tuple[float, float] = (0.0, -9.81)
    hold: float = np.inf
    drive: float = np.inf
    load: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Refuse a duty that means nothing; keep it as the array the kernel takes."""
        if self.objective not in ("tension-factor", "slip-margin"):
            raise InputError("objective", repr(self.objective), "tension-factor or slip-margin")
        if not np.isfinite(self.gravity).all():
            raise InputError("gravity", f"{tuple(self.gravity)} m/s2", "two finite numbers")
        if self.objective == "slip-margin" and (self.mass is None or not np.isfinite(self.hold)):
            raise InputError("objective slip-margin", "no load or no pull limit", "a mass, a tension window and limits")
        if self.mass is not None and not 0.0 <= self.mass < np.inf:
            raise InputError("mass", f"{self.mass:g} kg", "finite and not negative")
        if not 0.0 <= self.window[0] < self.window[1]:
            raise InputError("tension window", f"{self.window[0]:g} to {self.window[1]:g} N", "0 <= least < largest")
        if not 0.0 < self.drive <= self.hold:
            raise InputError("pull limits", f"hold {self.hold:g} N, drive {self.drive:g} N", "0 < drive <= hold")
        mass = -1.0 if self.mass is None else self.mass
        slip = 1.0 if self.objective == "slip-margin" else 0.0
        values = (mass, *self.window, *self.gravity, self.hold, self.drive, slip)
        object.__setattr__(self, "load", np.array(values, dtype=np.float64))


def worth(problem: Reconfiguration, offsets: tuple[Array, Array, Array, Array], duty: Duty) -> tuple[Array, Flags]:
    """Every combination of offsets at every pose.

    Args:
        problem: Anchors, platform and poses.
        offsets: Candidates of each anchor along x, four of (n_i,) [m].
        duty: What is borne and what counts.

    Returns:
        Objective (k, n_1, n_2, n_3, n_4) [1], 0 where not held, and flags of the same shape: bit 4 where held with
        every base gripped, bit i where held too with base i driving.
    """
    shape = (len(problem.poses), *(len(values) for values in offsets))
    value, flags = np.empty(shape), np.empty(shape, dtype=np.uint8)
    for k, pose in enumerate(problem.poses):
        _worth_grid(
            problem.anchors, problem.directions, problem.attachments, pose, *offsets, duty.load, value[k], flags[k]
        )
    return value, flags


def worth_of(problem: Reconfiguration, configurations: Array, duty: Duty) -> tuple[Array, Flags]:
    """The same of one configuration a pose.

    Args:
        problem: Anchors, platform and k poses.
        configurations: Offsets along x, (k, 4) [m].
        duty: What is borne and what counts.

    Returns:
        Objective (k,) [1] and flags (k,), as `worth`.
    """
    value, flags = np.empty(len(problem.poses)), np.empty(len(problem.poses), dtype=np.uint8)
    _worth_path(
        problem.anchors,
        problem.directions,
        problem.attachments,
        problem.poses,
        np.ascontiguousarray(configurations, dtype=np.float64),
        duty.load,
        value,
        flags,
    )
    return value, flags


@njit(cache=True)
def _worth_grid(
    anchors: Array,
    directions: Array,
    attachments: Array,
    pose: Array,
    v1: Array,
    v2: Array,
    v3: Array,
    v4: Array,
    load: Array,
    value: Array,
    flags: Flags,
) -> None:
    columns = (
        _columns(anchors, directions, attachments, pose, 0, v1),
        _columns(anchors, directions, attachments, pose, 1, v2),
        _columns(anchors, directions, attachments, pose, 2, v3),
        _columns(anchors, directions, attachments, pose, 3, v4),
    )
    four, scratch = np.empty((4, 4)), np.empty((2, 4))
    for a in range(v1.size):
        four[0] = columns[0][a]
        for b in range(v2.size):
            four[1] = columns[1][b]
            for c in range(v3.size):
                four[2] = columns[2][c]
                for d in range(v4.size):
                    four[3] = columns[3][d]
                    value[a, b, c, d], flags[a, b, c, d] = _judge(four, load, scratch)


@njit(cache=True)
def _worth_path(
    anchors: Array,
    directions: Array,
    attachments: Array,
    poses: Array,
    configurations: Array,
    load: Array,
    value: Array,
    flags: Flags,
) -> None:
    four, scratch, one = np.empty((4, 4)), np.empty((2, 4)), np.empty(1)
    for k in range(poses.shape[0]):
        for i in range(4):
            one[0] = configurations[k, i]
            four[i] = _columns(anchors, directions, attachments, poses[k], i, one)[0]
        value[k], flags[k] = _judge(four, load, scratch)


@njit(cache=True)
def _columns(anchors: Array, directions: Array, attachments: Array, pose: Array, i: int, offsets: Array) -> Array:
    """Columns of the structure matrix (u_x, u_y, b x u) and the share of the pull along the stay, (n, 4)."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    bx = cos * attachments[i, 0] - sin * attachments[i, 1]
    by = sin * attachments[i, 0] + cos * attachments[i, 1]
    along = np.hypot(directions[i, 0], directions[i, 1])
    out = np.empty((offsets.size, 4))
    for j in range(offsets.size):
        x = anchors[i, 0] + offsets[j] * directions[i, 0] - pose[0] - bx
        y = anchors[i, 1] + offsets[j] * directions[i, 1] - pose[1] - by
        length = np.hypot(x, y)
        ux, uy = (x / length, y / length) if length > 0.0 else (0.0, 0.0)
        out[j, 0], out[j, 1], out[j, 2] = ux, uy, bx * uy - by * ux
        out[j, 3] = abs(ux * directions[i, 0] + uy * directions[i, 1]) / along
    return out


@njit(cache=True)
def _null_vector(c: Array, null: Array) -> None:
    """Cofactors of the four columns c[i, :3], their sum not negative."""
    null[0] = _determinant(c[1], c[2], c[3])
    null[1] = -_determinant(c[0], c[2], c[3])
    null[2] = _determinant(c[0], c[1], c[3])
    null[3] = -_determinant(c[0], c[1], c[2])
    if null[0] + null[1] + null[2] + null[3] < 0.0:
        for i in range(4):
            null[i] = -null[i]


@njit(cache=True)
def _determinant(a: Array, b: Array, c: Array) -> float:
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])


@njit(cache=True)
def _judge(c: Array, load: Array, scratch: Array) -> tuple[float, np.uint8]:
    """Objective and flags of one configuration at one pose."""
    null, particular = scratch[0], scratch[1]
    _null_vector(c, null)
    factor = factor_of(c)
    if load[0] < 0.0:
        return factor, np.uint8(31) if factor > 0.0 else np.uint8(0)
    if not _particular(c, null, load[0] * load[3], load[0] * load[4], particular):
        return 0.0, np.uint8(0)
    low, high = _interval(c, particular, null, load, 4)
    if low > high:
        return 0.0, np.uint8(0)
    value = _largest_margin(c, particular, null, low, high, load[5]) if load[7] > 0.0 else factor
    flags = 16
    for driving in range(4):
        low, high = _interval(c, particular, null, load, driving)
        if low <= high:
            flags |= 1 << driving
    return value, np.uint8(flags)


@njit(cache=True)
def _particular(c: Array, null: Array, fx: float, fy: float, out: Array) -> bool:
    """Tensions that balance a force (fx, fy) at p with the cable slack that the null vector can best replace.

    False at a singular pose, judged as `twists.factor_of` does.
    """
    k, square, volume = 0, 0.0, 1.0
    for i in range(4):
        square += null[i] * null[i]
        if abs(null[i]) > abs(null[k]):
            k = i
    for row in range(3):
        volume *= c[0, row] ** 2 + c[1, row] ** 2 + c[2, row] ** 2 + c[3, row] ** 2
    if not square > TOLERANCE * TOLERANCE * volume:
        return False
    i, j, h = (k + 1) % 4, (k + 2) % 4, (k + 3) % 4
    det = _determinant(c[i], c[j], c[h])
    out[k] = 0.0
    out[i] = _against(fx, fy, c[j], c[h]) / det
    out[j] = _against(fx, fy, c[h], c[i]) / det
    out[h] = _against(fx, fy, c[i], c[j]) / det
    return True


@njit(cache=True)
def _against(fx: float, fy: float, b: Array, c: Array) -> float:
    """Determinant of (-fx, -fy, 0), b and c."""
    return -fx * (b[1] * c[2] - b[2] * c[1]) + fy * (b[0] * c[2] - b[2] * c[0])


@njit(cache=True)
def _interval(c: Array, particular: Array, null: Array, load: Array, driving: int) -> tuple[float, float]:
    """Interval of lambda within the window and the pull limits; ``driving`` 4 for none."""
    low, high = -np.inf, np.inf
    for i in range(4):
        limit = load[6] if i == driving else load[5]
        top = load[2]
        if c[i, 3] > 0.0 and limit / c[i, 3] < top:
            top = limit / c[i, 3]
        if top < load[1] or (null[i] == 0.0 and not load[1] <= particular[i] <= top):
            return 1.0, 0.0
        if null[i] == 0.0:
            continue
        first, second = (load[1] - particular[i]) / null[i], (top - particular[i]) / null[i]
        low, high = max(low, min(first, second)), min(high, max(first, second))
    return low, high


@njit(cache=True)
def _largest_margin(c: Array, particular: Array, null: Array, low: float, high: float, hold: float) -> float:
    """Largest least ``1 - pull / hold`` on an interval of lambda: at an end, or where two bases' margins cross."""
    best = -np.inf
    for i in range(4):
        for j in range(i, 4):
            for at in range(2):
                if i == j:
                    x = low if at == 0 else high
                else:
                    slope = c[i, 3] * null[i] - c[j, 3] * null[j]
                    if slope == 0.0:
                        continue
                    x = (c[j, 3] * particular[j] - c[i, 3] * particular[i]) / slope
                if not (low <= x <= high and np.isfinite(x)):
                    continue
                worst = np.inf
                for k in range(4):
                    worst = min(worst, 1.0 - c[k, 3] * (particular[k] + x * null[k]) / hold)
                best = max(best, worst)
    return best
