"""What functions on regions accept: arrays of numbers of the right shape, or one line that says what is wrong."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError

Array = NDArray[np.float64]


def numbers(where: str, values: ArrayLike, tail: tuple[int, ...]) -> Array:
    """An array of numbers (..., *tail), not all of them finite perhaps; a contiguous copy.

    Raises:
        InputError: No numbers, or another shape.
    """
    wanted = f"({', '.join(['...', *map(str, tail)])})"
    try:
        array = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise InputError(where, "not an array of numbers", f"shape {wanted}") from None
    if array.shape[array.ndim - len(tail) :] != tail or array.ndim < len(tail):
        raise InputError(where, f"shape {array.shape}", f"shape {wanted}")
    return array


def finite(where: str, values: ArrayLike, tail: tuple[int, ...]) -> Array:
    """Finite numbers (..., *tail), a contiguous copy.

    Raises:
        InputError: No numbers, another shape, or a number that is not finite.
    """
    array = numbers(where, values, tail)
    if not np.isfinite(array).all():
        raise InputError(where, "a number that is not finite", "finite numbers")
    return array


def points(where: str, values: ArrayLike, size: int) -> Array:
    """Finite points (m, size), a contiguous copy.

    Raises:
        InputError: No numbers, another shape, or a number that is not finite.
    """
    array = finite(where, values, (size,))
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
