"""How questions about a pose can end; all numbered alike: 0 yes, 1 no, 2 singular, 3 undefined.

Each status says of what it is, and its `advice` what to do. What singular and undefined mean stands in `degeneracy`.
"""

from __future__ import annotations

from enum import IntEnum

YES, NO, SINGULAR, UNDEFINED, MISSED = range(5)


class ClosureStatus(IntEnum):
    """How a closure question ended; `advice` says what to do."""

    INSIDE = YES
    OUTSIDE = NO
    SINGULAR = SINGULAR
    UNDEFINED = UNDEFINED

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _CLOSURE[self]


class FeasibilityStatus(IntEnum):
    """How a feasibility question ended; `advice` says what to do."""

    FEASIBLE = YES
    INFEASIBLE = NO
    SINGULAR = SINGULAR
    UNDEFINED = UNDEFINED

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _FEASIBILITY[self]


class DistributionStatus(IntEnum):
    """How a tension distribution ended; `advice` says what to do."""

    FEASIBLE = YES
    INFEASIBLE = NO
    SINGULAR = SINGULAR
    UNDEFINED = UNDEFINED
    MISSED = MISSED

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _DISTRIBUTION[self]


class RankStatus(IntEnum):
    """What the rows of a structure matrix span; `advice` says what to do."""

    FULL = YES
    SINGULAR = SINGULAR
    UNDEFINED = UNDEFINED

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _RANK[self]


class WrenchSetStatus(IntEnum):
    """What an available wrench set is like; `advice` says what to do."""

    SOLID = YES
    EMPTY = NO
    SINGULAR = SINGULAR
    UNDEFINED = UNDEFINED

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _WRENCH_SET[self]


_UNRESISTED = "the cables cannot resist the certificate's wrench at all; move off the singular pose"

_CLOSURE = {
    ClosureStatus.INSIDE: "the cables, tight enough, resist every wrench",
    ClosureStatus.OUTSIDE: "no cable pulls against the certificate's wrench; move the pose or the anchors",
    ClosureStatus.SINGULAR: _UNRESISTED,
    ClosureStatus.UNDEFINED: "an entry is not finite or a cable has no length; check pose and anchors",
}
_FEASIBILITY = {
    FeasibilityStatus.FEASIBLE: "tensions within their limits hold every task wrench",
    FeasibilityStatus.INFEASIBLE: "no tensions within their limits hold the worst wrench; move the pose, or widen the "
    "window",
    FeasibilityStatus.SINGULAR: _UNRESISTED,
    FeasibilityStatus.UNDEFINED: "an input is no number or a cable has no length; check pose, task and bounds",
}
_DISTRIBUTION = {
    DistributionStatus.FEASIBLE: "tensions hold the load inside their bounds",
    DistributionStatus.INFEASIBLE: "no tensions inside the bounds hold the load; move the pose or the anchors, or "
    "widen the window",
    DistributionStatus.SINGULAR: _UNRESISTED,
    DistributionStatus.UNDEFINED: "an input is no number, a cable has no length, or a bound is infinite that the "
    "method needs (qp without a reference needs the middle of every window); check pose, wrench and bounds",
    DistributionStatus.MISSED: "tensions inside the bounds exist, but this method left them; use a complete one, such "
    "as qp",
}
_RANK = {
    RankStatus.FULL: "the cables resist every wrench if they may push and pull",
    RankStatus.SINGULAR: "some wrench is resisted by no cable; move off the singular pose",
    RankStatus.UNDEFINED: "an entry is not finite or a cable has no length; check the pose and the geometry",
}
_WRENCH_SET = {
    WrenchSetStatus.SOLID: "the set has an inside; its facets bound it",
    WrenchSetStatus.EMPTY: "a least tension is above its greatest; correct the window",
    WrenchSetStatus.SINGULAR: "the pose is singular, so the set has no inside; move off it",
    WrenchSetStatus.UNDEFINED: "an input is no number or a cable has no length; check pose, anchors and bounds",
}
