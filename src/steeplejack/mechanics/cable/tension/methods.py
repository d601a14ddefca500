"""What each way of choosing tensions promises: the table behind `distribute`, its tests and its page in the docs.

A method is *complete* if it returns tensions inside the box whenever there are some, and *continuous* if tensions do
not jump while pose, wrench and bounds move continuously and the margin stays positive. Both are tested.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Method = Literal[
    "closed-form",
    "improved-closed-form",
    "barycentre",
    "min-max",
    "min-norm",
    "p-norm",
    "max-margin",
    "qp",
    "lp",
]
Option = Literal["reference", "weights", "power"]

(CLOSED_FORM, IMPROVED, BARYCENTRE, MIN_MAX, MIN_NORM, P_NORM, MAX_MARGIN, QP, LP) = range(9)


@dataclass(frozen=True)
class MethodRecord:
    """One way of choosing among the feasible tensions.

    Attributes:
        number: What the compiled code calls it.
        chooses: What it chooses, in one line.
        complete: Whether it finds tensions wherever there are some.
        continuous: Whether tensions are continuous along a path on which the margin stays positive.
        most_redundancy: Greatest number of cables too many it takes; None for any.
        open_windows: Whether it takes infinite upper bounds: ``qp`` with a reference given, ``lp`` without negative
            weights.
        options: Options of `distribute` it reads.
        source: Where it comes from.
    """

    number: int
    chooses: str
    complete: bool
    continuous: bool
    most_redundancy: int | None
    open_windows: bool
    options: tuple[Option, ...]
    source: str


METHODS: dict[Method, MethodRecord] = {
    "closed-form": MethodRecord(
        number=CLOSED_FORM,
        chooses="nearest to the middle of the box, bounds ignored",
        complete=False,
        continuous=True,
        most_redundancy=None,
        open_windows=False,
        options=(),
        source="Pott, Bruckmann and Mikelsons 2009",
    ),
    "improved-closed-form": MethodRecord(
        number=IMPROVED,
        chooses="the closed form, with violated bounds met one after another, the worst first",
        complete=False,
        continuous=False,
        most_redundancy=None,
        open_windows=False,
        options=(),
        source="Pott 2013",
    ),
    "barycentre": MethodRecord(
        number=BARYCENTRE,
        chooses="centre of the set of feasible tensions (interval or polygon)",
        complete=True,
        continuous=True,
        most_redundancy=2,
        open_windows=False,
        options=(),
        source="Mikelsons et al. 2008; Lamaury and Gouttefarde 2013",
    ),
    "min-max": MethodRecord(
        number=MIN_MAX,
        chooses="largest tension least; of those the least sum of squares",
        complete=True,
        continuous=False,
        most_redundancy=None,
        open_windows=True,
        options=(),
        source="linear program; Shiang, Cannon and Gorman 2000",
    ),
    "min-norm": MethodRecord(
        number=MIN_NORM,
        chooses="least sum of squares",
        complete=True,
        continuous=True,
        most_redundancy=None,
        open_windows=True,
        options=(),
        source="quadratic program; Verhoeven 2004",
    ),
    "p-norm": MethodRecord(
        number=P_NORM,
        chooses="least sum of powers of the distance from a reference (power 4 and zero unless given)",
        complete=True,
        continuous=True,
        most_redundancy=None,
        open_windows=True,
        options=("reference", "power"),
        source="Gosselin and Grenier 2011",
    ),
    "max-margin": MethodRecord(
        number=MAX_MARGIN,
        chooses="deepest inside the box; of those the nearest to its middle",
        complete=True,
        continuous=False,
        most_redundancy=None,
        open_windows=False,
        options=(),
        source="linear program; Borgstrom et al. 2009",
    ),
    "qp": MethodRecord(
        number=QP,
        chooses="least weighted squares of the distance from a reference (ones and the middle of the box unless given)",
        complete=True,
        continuous=True,
        most_redundancy=None,
        open_windows=True,
        options=("reference", "weights"),
        source="quadratic program; Bruckmann et al. 2006",
    ),
    "lp": MethodRecord(
        number=LP,
        chooses="least weighted sum (ones unless given), at a corner of the set of feasible tensions",
        complete=True,
        continuous=False,
        most_redundancy=None,
        open_windows=True,
        options=("weights",),
        source="linear program; Oh and Agrawal 2005",
    ),
}
"""Every method by name, simplest first."""
