"""The safety monitor: every breach, every limit on both sides, and no mutant of it survives."""

from __future__ import annotations

import ast
import copy
import inspect
import math
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from situations import CASES, LIMITS, Case, changed, well

from steeplejack.robots.squad import load_squad
from steeplejack.safety import BREACHES, Limits, check, monitor

Check = Callable[..., tuple[int, int]]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_names_the_breach_and_where(case: Case) -> None:
    assert check(**case.arguments) == case.answer


def test_every_code_is_reached_and_has_words() -> None:
    assert {case.answer[0] for case in CASES} == set(range(len(BREACHES)))
    assert BREACHES[0] == ""
    assert len(set(BREACHES)) == len(BREACHES)


LOOSER = {
    "largest and least pull": ("pull", 300.0, 2, {"commanded": np.array([0.0, 1e6])}),
    "least pull": ("pull", 1.0, 2, {"commanded": np.array([0.0, 1e6])}),
    "largest tension": ("tension", 290.0, 3, {"tension": np.array([5.0, 1e6]), "hold": 1e6, "drive": 1e6}),
    "slack": ("tension", 2.0, 4, {"tension": np.array([0.0, 275.0])}),
    "winch speed": ("pay_rate", 1.5, 7, {"winch_speed": 2.0}),
    "base speed": ("s_rate", 1.5, 8, {"base_speed": 2.0, "creep": 2.0}),
    "creep": ("s_rate", 0.1, 10, {"creep": 0.2}),
    "hold": ("tension", 250.0, 5, {"hold": 260.0, "drive": 260.0}),
}


@pytest.mark.parametrize("name", LOOSER)
def test_a_loosened_limit_lets_the_violation_through(name: str) -> None:
    array, value, code, looser = LOOSER[name]
    arguments = changed(array, 2, value)
    assert check(**arguments) == (code, 2)
    assert check(**arguments | {"limits": LIMITS._replace(**looser)}) == (0, -1)


def test_a_loosened_drive_limit_and_fence_let_the_violation_through() -> None:
    pulled = changed("tension", 1, 150.0)  # base 1 is under way
    assert check(**pulled) == (6, 1)
    assert check(**pulled | {"limits": LIMITS._replace(drive=160.0)}) == (0, -1)
    strayed = well() | {"goal": np.array([2.0, 3.0, 4.6])}
    assert check(**strayed) == (9, -1)
    assert check(**strayed | {"limits": LIMITS._replace(fence=0.7)}) == (0, -1)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=200, deadline=None)
def test_pull_along_the_stay_against_another_route(seed: int) -> None:
    """Rotated, asymmetric squads: the first base whose share of the tension exceeds its limit."""
    rng = np.random.default_rng(seed)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    tangents = rng.normal(size=(4, 3))
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    arguments = well() | {
        "exits": rng.uniform(-30.0, 30.0, (4, 3)),
        "attachments": rng.uniform(-0.2, 0.2, (4, 3)),
        "position": (place := rng.uniform(-2.0, 2.0, 3)),
        "goal": place,
        "rotation": rotation,
        "tangents": tangents,
        "tension": rng.uniform(20.0, 270.0, 4),
        "moving": rng.random(4) < 0.3,
    }
    cables = arguments["exits"] - (place + (rotation @ arguments["attachments"].T).T)
    cosine = np.einsum("ij,ij->i", cables, tangents) / np.linalg.norm(cables, axis=1)
    limit = np.where(arguments["moving"], LIMITS.drive, LIMITS.hold)
    over = np.flatnonzero(np.abs(arguments["tension"] * cosine) > limit)
    wanted = (0, -1) if not len(over) else (6 if arguments["moving"][over[0]] else 5, int(over[0]))
    assert check(**arguments) == wanted


def test_limits_of_the_machine() -> None:
    squad = load_squad()
    limits = Limits.of(squad, (20.0, 250.0))
    assert (limits.hold, limits.drive) == (245.25, 147.15)  # Table IV: 25 kg and 15 kg
    assert (limits.winch_speed, limits.base_speed) == (squad.winch.max_speed, squad.base.max_speed)
    assert limits.commanded[0] < 20.0 < 250.0 < limits.commanded[1]
    np.testing.assert_allclose(limits.tension, [5.0, 275.0])
    assert Limits.of(squad, (0.0, 250.0)).commanded[0] == 0.0


def test_imports_no_controller() -> None:
    """What checks the controller must not be built from it."""
    allowed = {"steeplejack.mechanics", "steeplejack.robots", "steeplejack.spatial", "steeplejack.errors"}
    for path in Path(inspect.getfile(monitor)).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            for name in names:
                room = ".".join(name.split(".")[:2])
                assert not name.startswith("steeplejack") or room in allowed | {"steeplejack.safety"}, name


# Mutation: each comparison, connective, negation, sum, absolute value and constant of the checker changed in turn.

SWAPS: dict[type[ast.AST], tuple[type[ast.AST], ...]] = {
    ast.Gt: (ast.GtE, ast.Lt),
    ast.Lt: (ast.LtE, ast.Gt),
    ast.And: (ast.Or,),
    ast.Or: (ast.And,),
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
}


def _body() -> ast.FunctionDef:
    (function,) = ast.parse(inspect.getsource(monitor._check.py_func)).body
    assert isinstance(function, ast.FunctionDef)
    function.decorator_list = []
    return function


def _with(core: object) -> Check:
    """The checker around another core."""
    return FunctionType(check.__code__, vars(monitor) | {"_check": core})


def _changes(node: ast.AST) -> list[Callable[[Any], None]]:
    """Ways to change one node in place."""
    if isinstance(node, ast.Compare):
        swaps = SWAPS[type(node.ops[0])]
        return [lambda n, op=op: n.ops.__setitem__(0, op()) for op in swaps]
    if isinstance(node, ast.BoolOp | ast.BinOp) and type(node.op) in SWAPS:
        return [lambda n, op=op: setattr(n, "op", op()) for op in SWAPS[type(node.op)]]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return [lambda n: setattr(n, "operand", ast.UnaryOp(ast.Not(), n.operand))]
    if isinstance(node, ast.If):
        return [lambda n: setattr(n, "test", ast.Constant(False)), lambda n: setattr(n, "test", ast.Constant(True))]
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "abs":
        return [lambda n: setattr(n.func, "id", "float")]
    if isinstance(node, ast.Constant) and isinstance(node.value, int):
        return [lambda n: setattr(n, "value", n.value + 1)]
    return []


def _mutants() -> list[tuple[str, Check]]:
    whole = _body()
    found: list[tuple[str, Check]] = []
    # Signs of the sum that only asks whether everything is finite make no difference.
    finite = [node for node in ast.walk(whole) if isinstance(node, ast.Call) and "isfinite" in ast.unparse(node.func)]
    equivalent = {id(part) for call in finite for part in ast.walk(call)}
    for position, node in enumerate(ast.walk(whole)):
        if id(node) in equivalent:
            continue
        for change in _changes(node):
            mutant = copy.deepcopy(whole)
            change(list(ast.walk(mutant))[position])
            module = ast.fix_missing_locations(ast.Module([mutant], []))
            scope = dict(vars(monitor))
            exec(compile(module, "<mutant>", "exec"), scope)
            found.append((f"line {getattr(node, 'lineno', 0)}: {ast.unparse(node)}", _with(scope["_check"])))
    return found


def _survives(mutant: Check) -> bool:
    for case in CASES:
        try:
            if mutant(**case.arguments) != case.answer:
                return False
        except (IndexError, ZeroDivisionError):
            return False
    return True


def test_no_mutant_survives() -> None:
    with np.errstate(all="ignore"):
        assert _survives(_with(monitor._check.py_func))
        mutants = _mutants()
        assert len(mutants) > 60
        assert [name for name, mutant in mutants if _survives(mutant)] == []


def test_a_breach_is_never_nan_blind() -> None:
    """A comparison with nan is false, so a checker without its own test for it would call nan well."""
    for name in ("pull", "tension", "pay_rate", "s_rate"):
        assert check(**changed(name, slice(None), math.nan)) == (1, 0)
