"""What the public functions of cable mechanics take, checked and laid out for their kernels in one place.

Policy for bad input. What cannot be a question at all (no numbers, shapes that do not fit each other, an unknown
method, a length of zero) raises `InputError` naming the argument, what it was and what would be valid. What is wrong
with *one* of many poses never stops the others: NaN, an infinite entry where only finite ones mean something, a cable
without length or an empty window get a status of their own. Whole numbers, lists and scalars are taken as they come;
a batch of no poses has an answer of no poses. Least tensions may be negative: limbs that push as well as pull, and
tensions counted from a preload, are balanced by the same mathematics; files of cable robots refuse them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError

Array = NDArray[np.float64]

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


def characteristic(length: float) -> float:
    """A characteristic length.

    Raises:
        InputError: Not a finite length above 0.
    """
    given = numbers("characteristic length", length)
    if given.ndim or not 0.0 < given < math.inf:
        raise InputError("characteristic length", f"{length} m", "a finite length above 0")
    return float(given)


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


def positive(where: str, value: float) -> float:
    """A finite number above zero.

    Raises:
        InputError: Anything else.
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(where, f"{value!r}", "positive and finite") from None
    if not (number > 0.0 and math.isfinite(number)):
        raise InputError(where, f"{number:g}", "positive and finite")
    return number


def limits(lower: ArrayLike, upper: ArrayLike, cables: int) -> tuple[Array, Array]:
    """Least and greatest tensions, (m,) each; infinite ones allowed [N].

    Raises:
        InputError: Not one number or one a cable, not a number, or a least above its greatest.
    """
    try:
        low, high = (np.array(np.broadcast_to(np.asarray(v, dtype=np.float64), (cables,))) for v in (lower, upper))
    except (TypeError, ValueError):
        raise InputError("tension limits", "other than one a cable", f"a scalar or ({cables},)") from None
    if not np.all(low <= high) or np.any(low == np.inf) or np.any(high == -np.inf):
        raise InputError("tension limits", f"{low.tolist()} to {high.tolist()} N", "numbers, least below greatest")
    return low, high
