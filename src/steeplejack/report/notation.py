"""How a report writes figures: real minus signs, a dash where there is no figure."""

from __future__ import annotations

import math

from steeplejack.report.analysis import Spread


def number(value: float, digits: int = 1) -> str:
    """A figure with a real minus sign, a dash where there is none."""
    return "–" if not math.isfinite(value) else f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")


def between(low: float, high: float, digits: int = 1) -> str:
    """A range, or one figure where both ends are written alike."""
    return "–".join(dict.fromkeys(number(value, digits) for value in (low, high)))


def spread(values: Spread) -> str:
    """Mean and standard deviation in one."""
    if not math.isfinite(values.mean):
        return "–"
    return f"{round(values.mean, 1) + 0.0:+.1f} ± {values.std:.1f}".replace("-", "−")


def minutes(seconds: float) -> str:
    """A duration as minutes and seconds."""
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60:02d} s"


def clock(seconds: float) -> str:
    """A time of the run as minutes, seconds and tenths."""
    tenths = round(10.0 * seconds)
    return f"{tenths // 600}:{tenths % 600 / 10.0:04.1f}"
