"""The safety monitor: every breach, every limit on both sides, and no mutant of it survives."""

from __future__ import annotations

import ast
import copy
import inspect
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from situations import CASES, LIMITS, Case, changed, driving, standing, well

from steeplejack.robots.squad import load_squad
from steeplejack.safety import BREACHES, Limits, limits
from steeplejack.safety import check as compiled

Check = Callable[..., tuple[int, int]]


def _taking_limits(core: Check) -> Check:
    """The compiled check, or a mutant of its source, taking the limits as one."""

    def run(*, limits: Limits, **arguments: Any) -> tuple[int, int]:
        return core(**arguments, limits=limits.vector)

    return run


check = _taking_limits(compiled)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_names_the_breach_and_where(case: Case) -> None:
    assert check(**case.arguments) == case.answer


def test_every_code_is_reached_and_has_words() -> None:
    assert {case.answer[0] for case in CASES} == set(range(len(BREACHES)))
    assert BREACHES[0] == ""
    assert len(set(BREACHES)) == len(BREACHES)


LOOSER = {
    "largest and least pull": ("pull", 300.0, 2, {"commanded": (0.0, 1e6), "hold": 1e6}),
    "least pull": ("pull", 1.0, 2, {"commanded": (0.0, 1e6), "hold": 1e6}),
    "largest tension": ("tension", 290.0, 3, {"tension": (5.0, 1e6), "hold": 1e6, "drive": 1e6}),
    "slack": ("tension", 2.0, 4, {"tension": (0.0, 275.0)}),
    "winch speed": ("pay_rate", 1.5, 7, {"winch_speed": 2.0}),
    "base speed": ("s_rate", 1.5, 8, {"base_speed": 2.0, "creep": 2.0}),
    "creep": ("s_rate", 0.1, 10, {"creep": 0.2}),
    "hold": ("tension", 250.0, 5, {"hold": 260.0, "drive": 260.0}),
    "palm": ("palm", 500.0, 11, {"palm": 400.0}),
    "traction": ("traction", -150.0, 12, {"drive": 160.0}),
    "turn": ("turn", 0.4, 13, {"turn_rate": 0.5}),
    "turned": ("turned", 0.1, 14, {"turn": 0.2}),
    "told to hold": ("pull", 258.0, 17, {"allowance": 20.0}),
    "fence": ("lengths", 32.6, 9, {"fence": 0.7}),
}


@pytest.mark.parametrize("name", LOOSER)
def test_a_loosened_limit_lets_the_violation_through(name: str) -> None:
    array, value, code, looser = LOOSER[name]
    arguments = changed(array, 2, value, **(driving(2) if name in ("traction", "turn") else {}))
    assert check(**arguments) == (code, 2)
    assert check(**arguments | {"limits": replace(LIMITS, **looser)}) == (0, -1)


def test_a_loosened_drive_limit_lets_the_violation_through() -> None:
    pulled = changed("tension", 1, 150.0)  # base 1 is under way
    assert check(**pulled) == (6, 1)
    assert check(**pulled | {"limits": replace(LIMITS, drive=160.0)}) == (0, -1)


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
        "goal": (place := rng.uniform(-2.0, 2.0, 3)),
        "goal_rotation": rotation,
        "tangents": tangents,
        "tension": rng.uniform(20.0, 270.0, 4),
        **(driving(int(rng.integers(4))) if rng.random() < 0.5 else standing()),
    }
    cables = arguments["exits"] - (place + (rotation @ arguments["attachments"].T).T)
    cosine = np.einsum("ij,ij->i", cables, tangents) / np.linalg.norm(cables, axis=1)
    arguments["lengths"] = np.linalg.norm(cables, axis=1) + rng.uniform(-0.4, 0.4, 4)
    limit = np.where(arguments["moving"], LIMITS.drive, LIMITS.hold)
    over = np.flatnonzero(np.abs(arguments["tension"] * cosine) > limit)
    wanted = (0, -1) if not len(over) else (6 if arguments["moving"][over[0]] else 5, int(over[0]))
    assert check(**arguments) == wanted


def test_limits_of_the_machine() -> None:
    squad = load_squad()
    run = Limits.of(squad, (20.0, 250.0), 174.0)
    assert (run.hold, run.drive) == (245.25, 147.15)  # Table IV: 25 kg and 15 kg
    assert (run.winch_speed, run.base_speed) == (squad.winch.max_speed, squad.base.max_speed)
    assert run.commanded[0] < 20.0 < 250.0 < run.commanded[1]
    np.testing.assert_allclose(run.tension, [5.0, 275.0])
    assert 603.0 < run.palm < squad.gripper.force  # Eq. 17 at the rated pull, worst stay of Table IV
    assert Limits.of(squad, (0.0, 250.0), 174.0).commanded[0] == 0.0


def test_imports_no_controller() -> None:
    """What checks the controller must not be built from it."""
    allowed = {"steeplejack.mechanics", "steeplejack.robots", "steeplejack.spatial", "steeplejack.errors"}
    for path in Path(inspect.getfile(limits)).parent.glob("*.py"):
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
    (function,) = ast.parse(inspect.getsource(compiled.py_func)).body
    assert isinstance(function, ast.FunctionDef)
    function.decorator_list = []
    return function


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
    finite = [
        node.value
        for node in ast.walk(whole)
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "numbers"
    ]
    equivalent = {id(part) for call in finite for part in ast.walk(call)}
    for position, node in enumerate(ast.walk(whole)):
        if id(node) in equivalent:
            continue
        for change in _changes(node):
            mutant = copy.deepcopy(whole)
            change(list(ast.walk(mutant))[position])
            module = ast.fix_missing_locations(ast.Module([mutant], []))
            scope = dict(vars(limits))
            exec(compile(module, "<mutant>", "exec"), scope)
            found.append((f"line {getattr(node, 'lineno', 0)}: {ast.unparse(node)}", _taking_limits(scope["check"])))
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
        assert _survives(_taking_limits(compiled.py_func))
        mutants = _mutants()
        assert len(mutants) > 60
        assert [name for name, mutant in mutants if _survives(mutant)] == []


def test_a_breach_is_never_nan_blind() -> None:
    """A comparison with nan is false, so a checker without its own test for it would call nan well."""
    for name in ("pull", "traction", "turn", "tension", "pay_rate", "s_rate", "palm", "lengths"):
        assert check(**changed(name, slice(None), math.nan)) == (1, 0)
