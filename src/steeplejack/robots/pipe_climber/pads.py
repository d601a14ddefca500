"""What a gripper holds: friction on its eight pads against a force and a moment at once.

Two jaws close along X of the gripper; each has four pads, at half the jaw's width to either side and near both ends of
its length. A pad touches the pipe where the centre line is nearest to it, pushes with N >= 0 along the normal there and
rubs with up to ``mu N`` within the pipe's surface. On a straight pipe of radius r that is at clock phi from its jaw's
way, ``sin phi = (width / 2) / (r + r_pad)``; in a bend the gripper sits on the chord between its two rows of pads, and
the surface leans under them. The drive closes both jaws by one gear and presses until on a straight the pads' normal
forces add up to the gripper's force a jaw, so

    sum_i s_i (f_i . x) = 2 F cos phi,    s = +1 on the jaw at +X, -1 on the other

Pads' wrenches are then all mixtures of the points ``2 F cos phi w_g / (s_g f_g . x)``, w_g the wrench of one pad on an
edge of its friction cone: a convex body that holds 0. A load w is held if -w lies in it, and how much of the grip it
takes is the body's gauge

    u(w) = min sum_g y_g   with   sum_g y_g v_g = -w,  y >= 0

u <= 1 is the limit theorem of static friction (as of grasps: Han, Trinkle and Li, IEEE Trans. Robotics 16, 2000): no
distribution of pad forces holds a load with u > 1. For a force along the pipe through its axis u is the ratio of
needed to available friction of `statics.friction_needed`.

All of it wants ``s_g f_g . x > 0``, which is ``mu < cot phi``: with more friction the pads of a jaw jam
(`parameters.Build.jamming_friction`).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.parameters import PipeClimber

Array = NDArray[np.float64]

STRAIGHT = np.array([[[0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]] * 2)
"""Tangent and curvature of a straight pipe under both rows of pads, in the gripper's frame [1, 1/m]."""
CLOSER = 5
"""Steps of Newton's method that close a jaw, from where a straight pipe would stop it."""
EDGES = 16
"""Edges of the pyramids inside the friction cones; along and around the pipe they touch it, else 2 % are lost."""
JAM = 1e-3
"""Share of a pad's push that acts along the jaws' way, below which the pad jams rather than slides [1]."""
INSET = 1.5
"""How far the middle of a pad lies inside the end of its jaw, in radii of the pad [1]."""
ARTIFICIAL = 1e4
"""Price of a wrench no pad gives, in the linear programme [1]."""
MOST_PIVOTS = 300
BOTH, FIRST, LAST = 0, 1, 2
"""Rows of pads that touch a pipe; the first one is that toward the pipe's beginning."""
REFRESH = 400
"""Loads after which a tableau is begun anew, before rounding gathers."""


def pad_row(robot: PipeClimber) -> float:
    """Distance of a row of pads from the gripper's middle along the pipe [m]."""
    return max(0.0, 0.5 * robot.build.jaw_length - INSET * robot.build.pad_radius)


def pad_clock(robot: PipeClimber, radius: float) -> float:
    """phi, how far from the way of its jaw a pad touches a pipe of a radius [m]; in [rad].

    Raises:
        InputError: A pipe so thin that it would slip between the pads of one jaw.
    """
    reach, half = radius + robot.build.pad_radius, 0.5 * robot.build.jaw_width
    if not reach > half:
        raise InputError("pipe radius", f"{radius:g} m", f"above {robot.build.least_radius:g} m")
    return math.asin(half / reach)


def pad_place(robot: PipeClimber, radius: float) -> float:
    """How far pads that touch a pipe of a radius [m] stand from its axis along the way of their jaw [m].

    Raises:
        InputError: As `pad_clock`.
    """
    return (radius + robot.build.pad_radius) * math.cos(pad_clock(robot, radius))


def grip_body(robot: PipeClimber, radius: float, rows: int = BOTH, lines: ArrayLike = STRAIGHT) -> Array:
    """Corners of the set of wrenches that the pads of a closed gripper give.

    All pads count, as they do once a gripper that is loaded has settled: where only one row lies in a bend, the other
    one stands off by up to r (1 / cos(lean) - 1) before, 0.15 mm on a pipe of 60 mm bent with 300 mm and 0.5 mm with
    170 mm. The bend is taken to go on beyond the pads: above 165 mm that is out by less than 1 % of a grip, and tighter
    short pieces of bend by more.

    Args:
        robot: The machine; jaws, pads, force and friction.
        radius: Of the pipe [m].
        rows: Which rows of pads touch it, `BOTH`, `FIRST` or `LAST`: jaws are stiff and slide across the pipe, so that
            of rows on two diameters those on the larger one do.
        lines: Tangent and curvature vector of the pipe's centre line under the first and the last row, in the gripper's
            frame, (2, 2, 3) [1, 1/m].

    Returns:
        (pads x `EDGES`, 6), (moment; force) at the gripper's middle in its frame [N m, N].

    Raises:
        InputError: A pipe too thin for the pads of a jaw, one so thin that they jam with this friction, or a bend
            inside which jaws do not come down to it.
    """
    phi, friction, given = pad_clock(robot, radius), robot.gripper.friction, np.asarray(lines, dtype=np.float64)
    if tightest(given) <= least_bend(robot, radius):
        valid = f"above {1e3 * least_bend(robot, radius):g} mm"
        raise InputError("bend radius", f"{1e3 * tightest(given):g} mm", valid)
    most = robot.build.jamming_friction(radius)
    if not friction < most:
        valid = f"below {most:.4g}, where pads jam on a pipe of {2e3 * radius:g} mm"
        raise InputError("friction", f"{friction:g}", valid)
    ends = {BOTH: (1, 0), FIRST: (0,), LAST: (1,)}[rows]
    corners = np.array([(jaw, side, end) for jaw in (1.0, -1.0) for side in (1.0, -1.0) for end in ends])
    jaw, row = corners[:, 0], corners[:, 2].astype(np.int64)
    places, normals = _contacts(robot, radius, jaw, corners[:, 1], given[row])
    places[:, 2] += pad_row(robot) * (2.0 * row - 1.0)
    return pad_wrenches(places, normals, jaw, friction, robot.gripper.jaws * robot.gripper.force * math.cos(phi))


def least_bend(robot: PipeClimber, radius: float) -> float:
    """Radius of a bend of a pipe of a radius [m] above which jaws surely close on its inside [m].

    Pads a row from the gripper's middle come down to the pipe where the circle of their middles, r + r_pad inside the
    bend, is no smaller than that.
    """
    return pad_row(robot) + radius + robot.build.pad_radius


def tightest(lines: Array) -> float:
    """Least radius of the bends under the rows of pads, infinite on straights [m]; lines as of `grip_body`."""
    curvature = float(np.sqrt((lines[:, 1] ** 2).sum(axis=-1)).max())
    return 1.0 / curvature if curvature > 0.0 else math.inf


def _contacts(robot: PipeClimber, radius: float, jaw: Array, side: Array, lines: Array) -> tuple[Array, Array]:
    """Where pads of closed jaws touch a pipe and its normals there, (k, 3) each, from the centre line under their row.

    Args:
        robot: The machine.
        radius: Of the pipe [m].
        jaw: 1 for a pad of the jaw at +X, -1 for one of the other, (k,).
        side: 1 for a pad at +Y, -1 for one at -Y, (k,).
        lines: Of the centre line, (k, 2, 3).
    """
    reach = radius + robot.build.pad_radius
    pads = np.stack((jaw * pad_place(robot, radius), 0.5 * robot.build.jaw_width * side, 0.0 * jaw), axis=-1)
    nearest, normals = np.empty_like(pads), np.empty_like(pads)
    circles = _circles(lines)
    for _ in range(CLOSER):
        nearest = _nearest(pads, lines[:, 0], *circles)
        normals = pads - nearest
        away = np.sqrt((normals**2).sum(axis=-1))
        normals /= away[:, None]
        pads[:, 0] += (reach - away) / normals[:, 0]
    return nearest + radius * normals, normals


def _circles(lines: Array) -> tuple[Array, Array, Array]:
    """Middles (k, 3), axes (k, 3) and radii (k, 1) of centre lines through the origin; radius 0 for a straight one."""
    curvature = np.sqrt((lines[:, 1] ** 2).sum(axis=-1, keepdims=True))
    radii = np.divide(1.0, curvature, out=np.zeros_like(curvature), where=curvature > 0.0)
    return lines[:, 1] * radii**2, np.cross(lines[:, 0], lines[:, 1]) * radii, radii


def _nearest(points: Array, tangents: Array, middles: Array, axes: Array, radii: Array) -> Array:
    """Points of centre lines nearest to others (k, 3) [m]."""
    out = points - middles
    out = out - axes * (out * axes).sum(axis=-1, keepdims=True)
    on_circles = middles + out * (radii / np.sqrt((out**2).sum(axis=-1, keepdims=True)))
    return np.where(radii > 0.0, on_circles, tangents * (points * tangents).sum(axis=-1, keepdims=True))


def pad_wrenches(
    places: Array, normals: Array, jaws: Array, friction: ArrayLike, press: float, edges: int = EDGES
) -> Array:
    """Corners of the set of wrenches that pads give wherever they stand.

    Args:
        places: Of the contacts, in the gripper's frame (k, 3) [m].
        normals: Of the pipe's surface there, outward (k, 3) [1].
        jaws: 1 for a pad of the jaw at +X, -1 for one of the other (k,).
        friction: Of each contact, or of all [1].
        press: What both jaws together press with along their way [N].
        edges: Of the pyramids inside the friction cones.

    Returns:
        At most (k x edges, 6), (moment; force) at the gripper's middle in its frame [N m, N]; an edge along which a
        pad would jam is left out.
    """
    angle = 2.0 * math.pi * np.arange(edges) / edges
    around = np.cross((0.0, 0.0, 1.0), normals)
    around /= np.linalg.norm(around, axis=-1, keepdims=True)
    along = np.cross(normals, around)
    rubbed = np.cos(angle)[:, None] * around[:, None] + np.sin(angle)[:, None] * along[:, None]
    forces = normals[:, None] + np.broadcast_to(friction, jaws.shape)[:, None, None] * rubbed
    wrenches = np.concatenate((np.cross(places[:, None], forces), forces), axis=-1)
    pressed = jaws[:, None] * forces[..., 0]
    holds = pressed > JAM
    return press * wrenches[holds] / pressed[holds][:, None]


def grip_use(body: Array, loads: ArrayLike) -> Array:
    """How much of a grip loads take: 0 none, 1 all of it, above 1 it slips or tilts.

    Args:
        body: As `grip_body` gives it.
        loads: (moment; force) on the gripper at its middle, in its frame, (..., 6) [N m, N].

    Returns:
        u of the module's text, (...) [1]; NaN where a load is not finite.

    Raises:
        InputError: Not (..., 6) numbers.
    """
    given = np.asarray(loads, dtype=np.float64)
    if given.ndim == 0 or given.shape[-1] != 6:
        raise InputError("loads", f"shape {given.shape}", "(..., 6): moment and force")
    scale, use = np.abs(body).max(axis=0), np.empty(given.size // 6)
    flat = (given / scale).reshape(-1, 6)
    size = np.abs(flat).max(axis=1)
    _use(np.ascontiguousarray((body / scale).T), flat / np.where(size > 0.0, size, 1.0)[:, None], use)
    return (size * use).reshape(given.shape[:-1])


@njit(cache=True, error_model="numpy")
def _use(columns: Array, loads: Array, use: Array) -> None:
    """``grip_use``; columns (6, n), loads (k, 6), fills use (k,).

    The simplex method, begun for each load at the basis that was best for the one before: its prices still hold, so
    a few steps of the dual method lead to the new best one. Six more columns of the tableau carry the basis' inverse.
    """
    count = columns.shape[1]
    table = np.empty((7, count + 7))
    basis = np.full(6, -1, dtype=np.int64)
    since = REFRESH
    for k in range(loads.shape[0]):
        if not np.isfinite(loads[k]).all():
            use[k] = np.nan
            continue
        since += 1
        if since < REFRESH and basis.min() >= 0:
            for i in range(7):
                table[i, count + 6] = 0.0
                for j in range(6):
                    table[i, count + 6] -= table[i, count + j] * loads[k, j]
            if _dual(table, basis, count):
                use[k] = -table[6, count + 6]
                continue
        since = 0
        _begin(table, basis, columns, loads[k])
        _primal(table, basis, count)
        use[k] = 0.0
        for i in range(6):
            use[k] += table[i, count + 6] * (1.0 if basis[i] >= 0 else ARTIFICIAL)
            if basis[i] < 0:
                since = REFRESH
        if since == 0:
            _price(table, basis, columns)


@njit(cache=True)
def _begin(table: Array, basis: NDArray[np.int64], columns: Array, load: Array) -> None:
    """The tableau with six artificial wrenches in the basis, at their price, signed so that the right side is >= 0."""
    count = columns.shape[1]
    table[6, :] = 0.0
    table[6, :count] = 1.0
    for i in range(6):
        sign = -1.0 if load[i] > 0.0 else 1.0
        for j in range(count):
            table[i, j] = sign * columns[i, j]
            table[6, j] -= ARTIFICIAL * table[i, j]
        for j in range(6):
            table[i, count + j] = sign if i == j else 0.0
        table[i, count + 6] = abs(load[i])
        basis[i] = -1


@njit(cache=True)
def _primal(table: Array, basis: NDArray[np.int64], count: int) -> None:
    """Steps of the simplex method from a basis that can be."""
    for _ in range(MOST_PIVOTS):
        enter = int(np.argmin(table[6, :count]))
        if table[6, enter] > -1e-9:
            return
        leave, least = -1, np.inf
        for i in range(6):
            if table[i, enter] > 1e-10:
                ratio = table[i, count + 6] / table[i, enter]
                if ratio < least - 1e-13 or (ratio < least + 1e-13 and basis[i] < 0):
                    leave, least = i, ratio
        if leave < 0:
            return
        _pivot(table, leave, enter)
        basis[leave] = enter


@njit(cache=True)
def _price(table: Array, basis: NDArray[np.int64], columns: Array) -> None:
    """Reduced costs anew from the basis' inverse, without the artificial price and what it cost in digits."""
    count = columns.shape[1]
    for j in range(6):
        table[6, count + j] = 0.0
        for i in range(6):
            table[6, count + j] -= table[i, count + j]
    for j in range(count):
        table[6, j] = 1.0
        for i in range(6):
            table[6, j] += table[6, count + i] * columns[i, j]
    for i in range(6):
        table[6, basis[i]] = 0.0


@njit(cache=True)
def _dual(table: Array, basis: NDArray[np.int64], count: int) -> bool:
    """Steps of the dual simplex method; False where they do not end well."""
    for _ in range(MOST_PIVOTS):
        leave = int(np.argmin(table[:6, count + 6]))
        if table[leave, count + 6] > -1e-10:
            return True
        enter, least = -1, np.inf
        for j in range(count):
            if table[leave, j] < -1e-9:
                ratio = table[6, j] / -table[leave, j]
                if ratio < least:
                    enter, least = j, ratio
        if enter < 0:
            return False
        _pivot(table, leave, enter)
        basis[leave] = enter
    return False


@njit(cache=True)
def _pivot(table: Array, row: int, column: int) -> None:
    """Bring a column into the basis in place of that of a row."""
    by = 1.0 / table[row, column]
    for j in range(table.shape[1]):
        table[row, j] *= by
    for i in range(table.shape[0]):
        if i != row:
            factor = table[i, column]
            if factor != 0.0:
                for j in range(table.shape[1]):
                    table[i, j] -= factor * table[row, j]
