"""What a report says about accuracy, in plain language, beside the figures the paper published."""

from __future__ import annotations

import numpy as np

from steeplejack.report.accuracy import Accuracy
from steeplejack.report.analysis import Spread
from steeplejack.report.html import Markup, element, section, table
from steeplejack.report.log import Log
from steeplejack.report.notation import number, spread

HEAD = ("", "along [mm]", "across [mm]", "stand-off [mm]", "absolute, mean [mm]", "absolute, largest [mm]")
EXPLANATION = (
    "Two errors, because they have two causes. The first three columns say how well the platform followed its plan "
    "relative to where the bases really stood: the quality of the control. The base positions come from wheels that "
    "slip a little and inclinometers that read a little wrong, and what that alone does to the platform has been taken "
    "out of these columns. Stand-off is not controlled: off the face the platform hangs where gravity and "
    "pretension balance it.",
    "The absolute columns leave it in: they say how far the platform, and so a place it sees on a stay, may be "
    "from where this report puts it.",
)


def tracking_section(log: Log, accuracy: Accuracy, path: Markup, errors: Markup) -> Markup:
    """Errors per stay and in all, the paper's beside them, and both figures."""
    rows = [
        _row(log.bay.stays[k].id, accuracy, accuracy.stay == k) for k in log.bay.interior if (accuracy.stay == k).any()
    ]
    rows.append(_row(element("b", "all stays"), accuracy, np.ones(len(accuracy.sample), bool)))
    rows.append(("paper, its X and Y on a replica", "+1.4 ± 9.0", "−3.9 ± 10.4", "–", "–", "–"))
    drift = log.squad.base.odometry_drift
    note = (
        f"Mean ± standard deviation. Wheel odometry drifts by {1e3 * drift:g} mm per metre driven, inclinometers are "
        f"off by {1e3 * log.squad.base.clock_bias:g} mrad (standard deviations)."
    )
    return section(
        "Accuracy",
        *(element("p", paragraph) for paragraph in EXPLANATION),
        table(HEAD, rows, numeric=range(1, len(HEAD))),
        element("p", note),
        path,
        errors,
    )


def _row(name: object, accuracy: Accuracy, here: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> tuple[object, ...]:
    relative = (spread(Spread.of(1e3 * accuracy.relative[here, i])) for i in range(3))
    absolute = 1e3 * accuracy.absolute[here]
    mean, largest = (absolute.mean(), absolute.max()) if len(absolute) else (np.nan, np.nan)
    return (name, *relative, number(float(mean)), number(float(largest)))
