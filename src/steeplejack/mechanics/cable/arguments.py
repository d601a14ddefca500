"""What the public functions of cable mechanics take, checked and laid out for their kernels in one place.

Policy for bad input. What cannot be a question at all (no numbers, shapes that do not fit each other, an unknown
method, a length of zero) raises `InputError` naming the argument, what it was and what would be valid. What is wrong
with *one* of many poses never stops the others: NaN, an infinite entry where only finite ones mean something, a cable
without length or an empty window get a status of their own. Whole numbers, lists and scalars are taken as they come;
a batch of no poses has an answer of no poses. Least tensions may be negative: limbs that push as well as pull, and
tensions counted from a preload, are balanced by the same mathematics; files of cable robots refuse them.

Rotations follow from this: one matrix (3, 3) of numbers that is no rotation is refused, and so is a rotation a whole
map shares; among many (k, 3, 3) it is a pose that is none, not a number in every result and ``UNDEFINED`` where there
is a status. A matrix with an entry that is not finite is such a pose even alone (`rotation_matrices`).

Numbers whose squares or products pass the largest float make results that are infinite or not a number, and poses that
no status calls held; they raise no warning.
"""

from __future__ import annotations

import math
import operator
from typing import TypeVar

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.spatial.rotation import ORTHONORMAL, rotation_matrix

Array = NDArray[np.float64]
Kind = TypeVar("Kind")

MOST_CABLES = 32
"""Cables for which subsets of columns are still counted in hundred thousands."""


def numbers(where: str, values: ArrayLike) -> Array:
    """Values as floating-point numbers; ``where`` is the argument's name.

    Raises:
        InputError: Not real numbers, or rows of unlike length.
    """
    try:
        given = np.asarray(values)
    except ValueError:
        raise InputError(where, "rows of unlike length", "an array of numbers") from None
    if given.dtype.kind not in "fiub":
        raise InputError(where, f"entries of type {given.dtype}", "real numbers")
    return given.astype(np.float64, copy=False)


def vectors(where: str, values: ArrayLike, *tail: int | str) -> Array:
    """Values as numbers with the given last axes; a name stands for any length of at least one.

    Raises:
        InputError: Not numbers, or other last axes.
    """
    given = numbers(where, values)
    fits = given.ndim >= len(tail) and all(
        size > 0 if isinstance(wanted, str) else size == wanted
        for size, wanted in zip(given.shape[given.ndim - len(tail) :], tail, strict=True)
    )
    if not fits:
        raise InputError(where, f"shape {given.shape}", f"(..., {', '.join(map(str, tail))})")
    return given


def structures_of(structure: ArrayLike, fewest: int = 1, most: int | None = None) -> tuple[Array, tuple[int, ...]]:
    """Structure matrices with their leading axes flattened to one, (k, n, m), and those axes.

    Args:
        structure: (..., n, m).
        fewest: Rows n at least.
        most: Rows n at most, and `MOST_CABLES` columns; any number of both if None.

    Raises:
        InputError: A shape that is no structure matrix.
    """
    matrix = vectors("structure", structure, "n", "m")
    n, m = matrix.shape[-2:]
    if n < fewest or (most is not None and not (n <= most and m <= MOST_CABLES)):
        rows = f"n from {fewest} to {most} and m from 1 to {MOST_CABLES}" if most else f"n of at least {fewest}"
        raise InputError("structure", f"shape {matrix.shape}", f"(..., n, m) with {rows}")
    return spread(matrix, matrix.shape[:-2], (n, m)), matrix.shape[:-2]


def leading(*values: tuple[str, tuple[int, ...], int]) -> tuple[int, ...]:
    """Leading axes that values broadcast to, each given by name, shape and the number of its own last axes.

    Raises:
        InputError: Leading axes that do not fit those before.
    """
    shape: tuple[int, ...] = ()
    for where, given, own in values:
        try:
            shape = np.broadcast_shapes(shape, given[: max(len(given) - own, 0)])
        except ValueError:
            raise InputError(where, f"shape {given}", f"leading axes that broadcast with {shape}") from None
    return shape


def each_cable(where: str, values: ArrayLike, m: int) -> Array:
    """One number for all cables, or one for each of them: () or (..., m).

    Raises:
        InputError: Another number of them.
    """
    given = numbers(where, values)
    if given.ndim and given.shape[-1] not in (1, m):
        raise InputError(where, f"shape {given.shape}", f"a scalar or (..., {m})")
    return given


def stiffness_of(values: ArrayLike) -> Array:
    """Axial stiffness ``EA`` of cables, of any shape [N]; not a number where it is not known, infinite if rigid.

    Raises:
        InputError: No numbers, or one that is zero or less.
    """
    given = numbers("axial_stiffness", values)
    if np.any(given <= 0.0):
        raise InputError("axial_stiffness", f"{float(given[given <= 0.0].min()):g} N", "EA above 0")
    return given


def characteristic(length: float) -> float:
    """A characteristic length.

    Raises:
        InputError: Not a finite length above 0.
    """
    given = number("characteristic length", length)
    if not 0.0 < given < math.inf:
        raise InputError("characteristic length", f"{given:g} m", "a finite length above 0")
    return given


def spread(values: Array, shape: tuple[int, ...], tail: tuple[int, ...]) -> Array:
    """Broadcast to ``shape + tail``, leading axes flattened to one; always a copy, so that one compilation serves."""
    return np.array(np.broadcast_to(values, (*shape, *tail)), order="C").reshape(math.prod(shape), *tail)


def owned(where: str, values: ArrayLike, *tail: int) -> Array:
    """Values with the given last axes, not all of them finite perhaps; a contiguous copy: one compilation serves.

    Raises:
        InputError: Not numbers, or other last axes.
    """
    return np.array(vectors(where, values, *tail), order="C")


def finite(where: str, values: ArrayLike, *tail: int) -> Array:
    """Finite numbers (..., *tail), a contiguous copy.

    Raises:
        InputError: No numbers, another shape, or a number that is not finite.
    """
    array = owned(where, values, *tail)
    if not np.isfinite(array).all():
        raise InputError(where, "a number that is not finite", "finite numbers")
    return array


def points(where: str, values: ArrayLike, size: int) -> Array:
    """Finite points (m, size), a contiguous copy.

    Raises:
        InputError: No numbers, another shape, or a number that is not finite.
    """
    array = finite(where, values, size)
    if array.ndim != 2:
        raise InputError(where, f"shape {array.shape}", f"shape (m, {size})")
    return array


def one(where: str, value: ArrayLike, size: int) -> Array:
    """One vector (size,), not all of it finite perhaps; a copy.

    Raises:
        InputError: No numbers, or another shape.
    """
    given = owned(where, value, size)
    if given.ndim != 1:
        raise InputError(where, f"shape {given.shape}", f"({size},)")
    return given


def rows(where: str, values: ArrayLike, size: int) -> Array:
    """Points (m, size), one at least, not all of them finite perhaps.

    Raises:
        InputError: No numbers, or another shape.
    """
    given = vectors(where, values, "m", size)
    if given.ndim != 2:
        raise InputError(where, f"shape {given.shape}", f"(m, {size})")
    return given


def cables(anchors: ArrayLike, attachments: ArrayLike, size: int, least: int = 1) -> tuple[Array, Array]:
    """Anchors and attachments, (m, size) each.

    Raises:
        InputError: No finite points, or not as many of one as of the other, or fewer than ``least``.
    """
    fixed, local = points("anchors", anchors, size), points("attachments", attachments, size)
    if len(fixed) != len(local) or len(fixed) < least:
        raise InputError(
            "cables", f"{len(fixed)} anchors and {len(local)} attachments", f"as many of each, {least} at least"
        )
    return fixed, local


def rotation_matrices(where: str, values: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3), a copy; not a number in every entry of one that is none (see the policy above).

    Raises:
        InputError: No numbers, another shape, or one matrix of finite numbers that is no rotation.
    """
    turns = owned(where, values, 3, 3)
    _strike_out(turns.reshape(-1, 3, 3), ORTHONORMAL)
    if turns.ndim == 2 and np.isnan(turns[0, 0]) and np.isfinite(numbers(where, values)).all():
        return rotation_matrix(values, where)
    return turns


@njit(cache=True)
def _strike_out(matrices: Array, tolerance: float) -> None:
    """Write what is not a number over every matrix (k, 3, 3) that is no rotation."""
    for k in range(matrices.shape[0]):
        r, good = matrices[k], True
        for i in range(3):
            for j in range(3):
                product = 0.0 if i != j else -1.0
                for c in range(3):
                    product += r[i, c] * r[j, c]
                good = good and abs(product) <= tolerance
        volume = r[0, 0] * (r[1, 1] * r[2, 2] - r[1, 2] * r[2, 1]) - r[0, 1] * (r[1, 0] * r[2, 2] - r[1, 2] * r[2, 0])
        volume += r[0, 2] * (r[1, 0] * r[2, 1] - r[1, 1] * r[2, 0])
        if not (good and volume > 0.0):
            matrices[k] = np.nan


def angles(where: str, values: ArrayLike) -> Array:
    """Angles (...) [rad], a copy; not a number where one is infinite.

    Raises:
        InputError: No numbers.
    """
    given = numbers(where, values)
    return np.where(np.isinf(given), np.nan, given)


def number(where: str, value: ArrayLike) -> float:
    """One number.

    Raises:
        InputError: No number, or more than one.
    """
    given = numbers(where, value)
    if given.ndim:
        raise InputError(where, f"shape {given.shape}", "one number")
    return float(given)


def positive(where: str, value: ArrayLike) -> float:
    """A finite number above zero.

    Raises:
        InputError: Anything else.
    """
    given = number(where, value)
    if not 0.0 < given < math.inf:
        raise InputError(where, f"{given:g}", "positive and finite")
    return given


def whole(where: str, value: int, least: int, most: int) -> int:
    """A whole number between two, both included; neither a truth value nor a number with a point.

    Raises:
        InputError: Anything else.
    """
    try:
        given = None if isinstance(value, (bool, np.bool_)) else operator.index(value)
    except TypeError:
        given = None
    if given is None or not least <= given <= most:
        raise InputError(where, " ".join(f"{value!r}".split()), f"a whole number from {least} to {most}")
    return given


def kind(where: str, value: object, wanted: type[Kind]) -> Kind:
    """A value of one type: one of the package's own, or text.

    Raises:
        InputError: Of another type.
    """
    if not isinstance(value, wanted):
        raise InputError(where, f"of type {type(value).__name__}", f"{wanted.__name__}")
    return value


def limits(lower: ArrayLike, upper: ArrayLike, cables: int) -> tuple[Array, Array]:
    """Least and greatest tensions, (m,) each; infinite ones allowed [N].

    Raises:
        InputError: Not one number or one a cable, not a number, or a least above its greatest; names the first cable.
    """
    given = (numbers("tension limits", lower), numbers("tension limits", upper))
    if not {value.shape for value in given} <= {(), (1,), (cables,)}:
        found = f"shapes {given[0].shape} and {given[1].shape}"
        raise InputError("tension limits", found, f"a scalar or ({cables},)")
    low, high = (np.array(np.broadcast_to(value, (cables,))) for value in given)
    bad = ~((low <= high) & (low < np.inf) & (high > -np.inf))
    if bad.any():
        i = int(np.argmax(bad))
        found = f"{low[i]:g} to {high[i]:g} N of cable {i + 1}"
        raise InputError("tension limits", found, "numbers, least not above greatest")
    return low, high


def finite_limits(lower: ArrayLike, upper: ArrayLike, cables: int) -> tuple[Array, Array]:
    """Least and greatest tensions as of `limits`, (m,) each, whose windows are finite [N].

    Raises:
        InputError: Also for a window that is not finite; names the first cable.
    """
    low, high = limits(lower, upper, cables)
    with np.errstate(over="ignore"):
        endless = ~np.isfinite(high - low)
    if endless.any():
        i = int(np.argmax(endless))
        found = f"{low[i]:g} to {high[i]:g} N of cable {i + 1}"
        raise InputError("tension limits", found, "finite windows")
    return low, high


def open_limits(lower: ArrayLike, upper: ArrayLike, cables: int) -> tuple[Array, Array]:
    """Least and greatest tensions as of `finite_limits`, (m,) each, with room between them [N].

    Raises:
        InputError: Also for a window without width; names the first cable.
    """
    low, high = finite_limits(lower, upper, cables)
    if not (low < high).all():
        i = int(np.argmin(low < high))
        raise InputError("tension limits", f"{low[i]:g} to {high[i]:g} N of cable {i + 1}", "least below greatest")
    return low, high
