"""Second routes to closure and feasibility: HiGHS on a normalised margin, rational arithmetic, checks of certificates.

Nothing here uses the package. Rows are brought to one size before a linear program sees them; its variable is a margin
of order one, so the solver's tolerance (1e-7) is far below what it decides.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp

BAND = 1e-6
"""Margin within which a linear program is not believed and rational arithmetic decides [1]."""


def equalised(structure):
    """Rows divided by their largest entry, and those entries (1 for a row of zeros)."""
    size = np.abs(structure).max(axis=-1, keepdims=True)
    size[size == 0.0] = 1.0
    return structure / size, size[:, 0]


def closure_margin(structure):
    """``max t`` with ``structure f = 0`` and ``t <= f <= 1``: the tension factor where the rank is full."""
    rows, _ = equalised(structure)
    n, m = rows.shape
    above = np.hstack((np.eye(m), -np.ones((m, 1))))
    ceiling = np.append(np.ones(m), np.inf)
    return _most(rows, np.zeros(n), above, np.zeros(m), np.full(m, np.inf), ceiling)


def window_margin(structure, wrench, lower, upper):
    """``max t`` with ``structure f = -w`` and every tension ``t`` half-windows inside its window, at most 1."""
    rows, size = equalised(structure)
    m = rows.shape[1]
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    scaled = rows * half
    unit = np.abs(scaled).max()
    side = np.ones((m, 1))
    within = np.vstack((np.hstack((np.eye(m), side)), np.hstack((-np.eye(m), side))))
    right = -(wrench / size + rows @ middle) / unit
    return _most(scaled / unit, right, within, np.full(2 * m, -np.inf), np.ones(2 * m), np.full(m + 1, np.inf))


def _most(rows, right, sides, low, high, ceiling):
    """Largest last variable with ``rows f = right``, ``low <= sides (f, t) <= high`` and ``(f, t) <= ceiling``."""
    n, m = rows.shape
    answer = milp(
        np.append(np.zeros(m), -1.0),
        constraints=LinearConstraint(
            np.vstack((np.hstack((rows, np.zeros((n, 1)))), sides)), np.append(right, low), np.append(right, high)
        ),
        bounds=Bounds(-np.inf, ceiling),
    )
    assert answer.status == 0, answer.message
    return -answer.fun


def has_solution(rows, right):
    """Whether ``rows x = right`` has a solution ``x >= 0``, in rational arithmetic (first phase, Bland's rule)."""
    table = [[Fraction(v) for v in row] + [Fraction(b)] for row, b in zip(rows, right, strict=True)]
    n, m = len(table), len(table[0]) - 1
    for r, row in enumerate(table):
        if row[-1] < 0:
            table[r] = [-v for v in row]
        table[r][m:m] = [Fraction(int(r == c)) for c in range(n)]
    basis = list(range(m, m + n))
    cost = [-sum(row[c] for row in table) if c < m or c == m + n else Fraction(0) for c in range(m + n + 1)]
    while True:
        enter = next((c for c in range(m) if cost[c] < 0), None)
        if enter is None:
            return cost[-1] == 0
        ratios = [(row[-1] / row[enter], basis[r], r) for r, row in enumerate(table) if row[enter] > 0]
        leave = min(ratios)[2]
        pivot = table[leave][enter]
        table[leave] = [v / pivot for v in table[leave]]
        for row in (*(table[r] for r in range(n) if r != leave), cost):
            times = row[enter]
            if times:
                row[:] = [v - times * p for v, p in zip(row, table[leave], strict=True)]
        basis[leave] = enter


def closes_exactly(structure):
    """Whether some ``f >= 1`` has ``structure f = 0`` and the rank is full, for the matrix as rounded."""
    exact = [[Fraction(float(v)) for v in row] for row in structure]
    return rank(exact) == len(exact) and has_solution(exact, [-sum(row) for row in exact])


def holds_exactly(structure, wrench, lower, upper):
    """Whether ``structure f + w = 0`` within the window, for the numbers as rounded."""
    m = structure.shape[1]
    exact = [[Fraction(float(v)) for v in row] for row in structure]
    low, high = [Fraction(float(v)) for v in lower], [Fraction(float(v)) for v in upper]
    held = [sum(a * b for a, b in zip(row, low, strict=True)) for row in exact]
    load = [-Fraction(float(w)) - h for w, h in zip(wrench, held, strict=True)]
    rows = [[*row, *[Fraction(0)] * m] for row in exact]
    for i in range(m):
        rows.append([Fraction(int(c in (i, m + i))) for c in range(2 * m)])
    return has_solution(rows, load + [b - a for a, b in zip(low, high, strict=True)])


def rank(rows):
    """Rank of a rational matrix."""
    table, found = [list(row) for row in rows], 0
    for c in range(len(table[0])):
        pivot = next((r for r in range(found, len(table)) if table[r][c] != 0), None)
        if pivot is None:
            continue
        table[found], table[pivot] = table[pivot], table[found]
        for r in range(found + 1, len(table)):
            times = table[r][c] / table[found][c]
            table[r] = [v - times * p for v, p in zip(table[r], table[found], strict=True)]
        found += 1
        if found == len(table):
            break
    return found


def separates(certificate, structure, rounding=1e-9):
    """Whether ``z`` is not zero and no column has work against it beyond rounding, once rows are of one size."""
    rows, size = equalised(structure)
    z = certificate * size
    limit = rounding * np.linalg.norm(z) * np.linalg.norm(rows, axis=0)
    return bool(np.linalg.norm(z) > 0.0 and np.all(z @ rows >= -limit))


def certified_gap(certificate, structure, wrench, lower, upper):
    """Least ``z . (structure f + w)`` over the window, by the better end of each cable."""
    work = certificate @ structure
    ends = np.where(work > 0.0, lower, upper)
    return float(certificate @ wrench + work @ np.where(work == 0.0, 0.0, ends))
