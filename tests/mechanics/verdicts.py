"""What a linear program, and rational arithmetic where it is close, say of tension windows; and what answers owe them.

Shared by the tests and by benchmarks/agreement.py. The oracles are those of `oracles`, which use nothing of the
package.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import oracles

from steeplejack.mechanics.cable import METHODS, DistributionStatus, Method, TensionDistribution

OUTSIDE = 1e-9
"""Share of its window by which a tension said to be inside may pass a bound: rounding [1]."""

UNBALANCED = 1e-11
"""Residual of a row of the equilibrium over the sizes it adds up: rounding [1]."""


@dataclass(frozen=True)
class Verdicts:
    """Whether tensions within their windows balance a wrench, question by question.

    Attributes:
        held: Whether they do, (k,).
        margin: Of the linear program, in half-windows, (k,) [1].
        close: Whether that was within ``BAND`` of zero and rational arithmetic decided, (k,).
    """

    held: np.ndarray
    margin: np.ndarray
    close: np.ndarray

    @classmethod
    def of(cls, structures, wrenches, lower, upper) -> Verdicts:
        """Ask about each of k questions: (k, n, m), (k, n), (k, m), (k, m)."""
        questions = list(zip(structures, wrenches, lower, upper, strict=True))
        margin = np.array([oracles.window_margin(*question) for question in questions])
        held, close = margin > 0.0, np.abs(margin) < oracles.BAND
        for k in np.flatnonzero(close):
            held[k] = oracles.holds_exactly(*questions[k])
        return cls(held, margin, close)


def taken(method: Method, structures) -> bool:
    """Whether a method takes that many cables too many."""
    most = METHODS[method].most_redundancy
    return most is None or structures.shape[-1] - structures.shape[-2] <= most


def shortcomings(method: Method, answer: TensionDistribution, asked, verdicts: Verdicts) -> dict[str, int | float]:
    """What a distribution got wrong, and the worst of what it got right.

    Args:
        method: Which; one that does not claim completeness may miss, but must say so.
        answer: What it returned.
        asked: Structures, wrenches, lower and upper bounds.
        verdicts: The truth about them.

    Returns:
        ``found``; ``disagreements`` with the verdict; ``bad_tensions``, outside a bound or out of balance;
        ``bad_proofs``, a no without a valid certificate; the worst ``excess`` and ``residual`` of found ones [1], and
        how far ``margin`` is apart from the linear program's [1].
    """
    structures, wrenches, lower, upper = asked
    possible = (
        answer.feasible if METHODS[method].complete else answer.feasible | (answer.status == DistributionStatus.MISSED)
    )
    f = answer.tensions[answer.feasible]
    low, high, load, rows = (value[answer.feasible] for value in (lower, upper, wrenches, structures))
    excess = (np.maximum(low - f, f - high) / (high - low)).max(axis=-1)
    size = np.einsum("kij,kj->ki", np.abs(rows), np.abs(f)) + np.abs(load)
    residual = (np.abs(np.einsum("kij,kj->ki", rows, f) + load) / size).max(axis=-1)
    refused = zip(*(value[~possible] for value in (answer.certificate, *asked)), strict=True)
    return {
        "found": int(answer.feasible.sum()),
        "disagreements": int(np.count_nonzero(possible != verdicts.held)),
        "bad_tensions": int(np.count_nonzero((excess > OUTSIDE) | ~(residual < UNBALANCED))),
        "bad_proofs": sum(not oracles.certified_gap(*question) > 0.0 for question in refused),
        "excess": float(excess.max(initial=0.0)),
        "residual": float(residual.max(initial=0.0)),
        "margin_apart": float(np.abs(answer.margin - verdicts.margin).max()),
    }
