"""Powers of numbers that are not negative, for the p-norms of tensions."""

from __future__ import annotations

from numba import njit


@njit(cache=True, error_model="numpy")
def raised(share: float, power: float) -> float:
    """A power of a number that is not negative; whole powers by squaring, several times faster than the general one."""
    whole = int(power)
    if whole != power:
        return share**power
    result = 1.0
    while whole > 0:
        if whole & 1:
            result *= share
        share *= share
        whole >>= 1
    return result
