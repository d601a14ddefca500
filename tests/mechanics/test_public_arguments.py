"""Every public function of cable mechanics with each argument in turn replaced by what nobody meant.

It answers or says in an `InputError` what is wrong: no traceback from inside, no warning, no wait.
"""

from __future__ import annotations

import inspect
import time

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.mechanics import cable
from steeplejack.robots.cable_robot import CableRobot, load_cable_robot

pytestmark = pytest.mark.long

SLOW, LONGEST = 60.0, 1000  # [s] with a kernel to compile; letters of a message

FUNCTIONS = sorted(name for name in cable.__all__ if inspect.isfunction(getattr(cable, name)))
METHODS = (
    "LockedPlatform.planar",
    "LockedPlatform.spatial",
    "Surroundings.of",
    "TaskWrenches.point",
    "TaskWrenches.box",
    "TaskWrenches.polytope",
    "TaskWrenches.shifted",
    "CableRobot.planar.lengths",
    "CableRobot.planar.weight",
    "CableRobot.planar.mass_matrix",
    "CableRobot.planar.locked",
    "CableRobot.structure",
    "CableRobot.weight",
    "CableRobot.mass_matrix",
    "CableRobot.locked",
)
ALONE = [
    None, "text", ["a", "b"], b"bytes", object(), {"a": 1}, 1j, True, 0, 2, -1, 0.0, -1.0, 2.5, 1e200, -1e300, 1e-320,
    10**400, float("nan"), float("inf"), -float("inf"), [], [[]], [1, 2, 3], [[1, 2], [3]], np.zeros((0, 3)),
    np.full((4, 2), np.nan), np.array(3), 2.0 * np.eye(3), np.diag([1.0, 1.0, -1.0]),
]  # fmt: skip


def spoilt(value):
    """What may stand in an argument's place, that of other types first and then its own with something wrong."""
    yield from ALONE
    if not isinstance(value, (list, np.ndarray)):
        return
    given = np.array(value, dtype=np.float64)
    for entry in (np.nan, np.inf, -np.inf, 1e200, 1e300, 1e-300, 0.0):
        other = given.copy()
        other.flat[other.size // 2] = entry
        yield other
    yield from (given * 1e200, given * 1e300, given * 1e-300, given * 0.0, -given, given[..., :-1], given[None])
    yield from (np.stack((given, given * np.nan)), given[:1], given[:0], given[::-1], given.astype(int))
    yield from (given.astype(np.float32), given.astype(object), given.astype(str), given + 0j, np.asfortranarray(given))


def faults(function, call):
    """What is wrong with how a function takes each argument in turn: whatever is no answer and no line of complaint."""
    for argument, value in call.items():
        for other in spoilt(value):
            shown, began = f"{argument}={' '.join(repr(other).split())[:60]}", time.monotonic()
            try:
                function(**{**call, argument: other})
            except InputError as refused:
                if "\n" in str(refused) or len(str(refused)) > LONGEST:
                    yield f"{shown}: {refused}"
            except Exception as error:
                yield f"{shown}: {type(error).__name__}: {error}"
            if time.monotonic() - began > SLOW:
                yield f"{shown}: slow"


@pytest.fixture(scope="module")
def asked():
    """Every function with its call."""
    from public_calls import CALLS, OTHERS

    assert set(CALLS) == set(FUNCTIONS)
    assert set(OTHERS) == set(METHODS)
    return {**{name: (getattr(cable, name), call) for name, call in CALLS.items()}, **OTHERS}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_call_names_arguments_of_its_function(asked, name):
    function, call = asked[name]
    assert set(call) <= set(inspect.signature(function).parameters)


@pytest.mark.parametrize("name", sorted([*FUNCTIONS, *METHODS]))
def test_any_argument_gets_an_answer_or_is_refused_by_name(asked, name):
    function, call = asked[name]
    function(**call)
    assert not list(faults(function, call))


def test_a_robot_with_elastic_cables_is_as_strict():
    spatial, place, turn, fall = load_cable_robot("cogiro"), [1.0, 0.5, 2.0], np.eye(3), [0.0, 0.0, -9.81]
    elastic = CableRobot(**{**vars(spatial), "axial_stiffness": np.full(8, 1e5)})
    call = {"tensions": np.full(8, 9.0), "gravity": fall, "pose": place, "rotation": turn}
    assert not [*faults(elastic.stiffness, call), *faults(elastic.locked, call)]
