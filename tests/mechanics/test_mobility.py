"""Mobility: known answers by every route, the routes against each other, and what is no linkage."""

from __future__ import annotations

import tomllib
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from known_linkages import any_linkage, hinges, linkage, loop, random_loop, seen_from
from numpy.typing import NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.limb import (
    LINKAGES,
    Joint,
    Linkage,
    Mobility,
    load_linkage,
    mobility,
    same,
    transform_twists,
)
from steeplejack.mechanics.limb.closure import Closure
from steeplejack.mechanics.limb.excursion import excursions
from steeplejack.mechanics.limb.graph import whole
from steeplejack.mechanics.limb.mobility import gauge_of
from steeplejack.mechanics.limb.reciprocity import link_freedoms, platform_freedoms
from steeplejack.mechanics.limb.systems import null_space
from steeplejack.robots.pipe_climber import Layout, load_pipe_climber
from steeplejack.robots.pipe_climber.mechanism import parallel_mechanism, rcm_linkage, whole_robot
from steeplejack.spatial.rotation import from_vector, to_vector

pytestmark = pytest.mark.long

Array = NDArray[np.float64]

REFERENCE: dict[str, dict[str, Any]] = tomllib.loads(
    (Path(__file__).parents[1] / "reference" / "mobility.toml").read_text()
)


@cache
def known(name: str) -> Linkage:
    robot = load_pipe_climber()
    if name in LINKAGES:
        return load_linkage(name)
    if name == "3-rpr":
        return parallel_mechanism(Layout.of(robot), robot.linkage.half_width)
    return rcm_linkage(robot.rcm) if name == "rcm" else whole_robot(robot)


@cache
def found(name: str) -> Mobility:
    return mobility(known(name))


@pytest.mark.parametrize("name", REFERENCE)
def test_known_answers_by_every_route(name: str) -> None:
    expected, answer = REFERENCE[name], found(name)
    counts = {answer.by_reciprocal_screws, answer.by_closure, answer.kutzbach.mobility, answer.mobility}
    assert counts == {expected["mobility"]}
    assert answer.agree
    assert (answer.kutzbach.order, answer.kutzbach.redundant) == (expected["order"], expected["redundant"])
    assert answer.kind == "full cycle"
    assert answer.passive == 0
    assert len(answer.twists) + len(answer.wrenches) == 6
    if "freedoms" in expected:
        assert (answer.freedoms, answer.constraints) == (expected["freedoms"], expected["constraints"])
    assert answer.locked == (None if name in ("bennett", "sarrus") else 0)


@pytest.mark.parametrize("name", REFERENCE)
def test_routes_agree_at_displaced_configurations(name: str) -> None:
    """Reciprocity of links, union of limbs and loop closure, where nothing is aligned with the axes any more."""
    part = whole(known(name))
    closure = Closure.of(part, gauge_of(known(name)))
    for excursion in excursions(closure, np.random.default_rng(3))[:2]:
        here = closure.at(excursion.coordinates)
        twists = {joint.name: here.twists[closure.columns[joint.name]] for joint in part.joints}
        output = (here.output @ null_space(here.jacobian).T).T
        links = link_freedoms(part, twists)
        assert links.mobility == excursion.instantaneous == excursion.lasting == REFERENCE[name]["mobility"]
        assert same(links.output, output)
        assert same(platform_freedoms(part, twists), output)


@pytest.mark.parametrize("name", ["stewart-gough", "3-rrs", "bennett", "pipe-climber"])
def test_jacobians_are_the_derivatives_of_finite_motion(name: str) -> None:
    closure = Closure.of(whole(known(name)), gauge_of(known(name)))
    start = excursions(closure, np.random.default_rng(1))[0].coordinates
    here, step = closure.at(start), 1e-6
    for column in range(closure.freedoms):
        change = step * np.eye(closure.freedoms)[column]
        after, before = closure.at(start + change), closure.at(start - change)
        assert here.jacobian[:, column] == pytest.approx(
            (after.misclosure - before.misclosure) / (2.0 * step), abs=1e-8
        )
        turn = to_vector(after.moved.rotation @ before.moved.rotation.T) / (2.0 * step)
        travel = (after.moved.translation - before.moved.translation) / (2.0 * step)
        linear = travel - np.cross(turn, here.moved.translation)
        assert here.output[:, column] == pytest.approx(np.concatenate((turn, linear)), abs=1e-8)


@pytest.mark.parametrize("name", ["rcm", "planar-3-rrr"])
def test_planar_mobility_in_exact_arithmetic(name: str) -> None:
    """Two equations a hinge between planar link velocities (omega, vx, vy), eliminated in fractions."""
    chosen = known(name)
    moving = [link for link in chosen.links if link != chosen.base]
    rows = list[list[Fraction]]()
    for joint in chosen.joints:
        assert joint.point is not None
        x, y = (Fraction(str(round(value, 12))) for value in joint.point[:2])
        for equation in ((-y, Fraction(1), Fraction(0)), (x, Fraction(0), Fraction(1))):
            row = [Fraction(0)] * (3 * len(moving))
            for link, sign in zip(joint.links, (1, -1), strict=True):
                if link in moving:
                    start = 3 * moving.index(link)
                    row[start : start + 3] = [sign * value for value in equation]
            rows.append(row)
    assert 3 * len(moving) - exact_rank(rows) == REFERENCE[name]["mobility"]


def exact_rank(rows: list[list[Fraction]]) -> int:
    rank = 0
    for column in range(len(rows[0])):
        pivot = next((k for k in range(rank, len(rows)) if rows[k][column]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        for k in range(rank + 1, len(rows)):
            factor = rows[k][column] / rows[rank][column]
            rows[k] = [a - factor * b for a, b in zip(rows[k], rows[rank], strict=True)]
        rank += 1
    return rank


@pytest.mark.parametrize("scale", [1e-3, 1e3])
@pytest.mark.parametrize("name", ["3-rrs", "bennett", "rcm"])
def test_frame_and_size_do_not_matter(name: str, scale: float) -> None:
    rng = np.random.default_rng(2)
    rotation, translation = from_vector(rng.normal(size=3)), scale * rng.normal(size=3)
    there = mobility(seen_from(known(name), rotation, translation, scale))
    here = found(name)
    assert (there.mobility, there.kutzbach, there.kind, there.agree) == (here.mobility, here.kutzbach, here.kind, True)
    carried = here.twists * np.repeat([1.0, scale], 3)
    gauge = gauge_of(seen_from(known(name), rotation, translation, scale))
    assert same(gauge.twists(there.twists), gauge.twists(transform_twists(rotation, translation, carried)))


@pytest.mark.parametrize("scale", [1e-9, 1e9])
@pytest.mark.parametrize("name", REFERENCE)
def test_nanometres_and_gigametres_count_alike(name: str, scale: float) -> None:
    rng = np.random.default_rng(7)
    there = mobility(seen_from(known(name), from_vector(rng.normal(size=3)), scale * rng.normal(size=3), scale))
    here = found(name)
    assert (there.mobility, there.kutzbach, there.kind, there.agree) == (here.mobility, here.kutzbach, here.kind, True)
    assert (there.locked, there.passive) == (here.locked, here.passive)
    assert there.least_kept == pytest.approx(here.least_kept, rel=1e-6)


def test_hinges_that_meet_but_for_rounding() -> None:
    """Points 1e-16 m apart are one, near the frame's origin too, where nothing else has a size."""
    rng = np.random.default_rng(8)
    for centre in (np.zeros(3), np.array([0.1, 0.2, 0.3])):
        points = centre + 1e-16 * rng.normal(size=(4, 3))
        hinges_ = [
            {"kind": "revolute", "axis": tuple(axis), "point": tuple(point)}
            for axis, point in zip(rng.normal(size=(4, 3)).tolist(), points.tolist(), strict=True)
        ]
        answer = mobility(loop(hinges_))
        assert (answer.mobility, answer.kutzbach.order, answer.agree) == (1, 3, True)


@pytest.mark.parametrize("name", ["3-rrs", "pipe-climber"])
def test_base_and_output_can_change_places(name: str) -> None:
    chosen = known(name)
    turned = mobility(msgspec.structs.replace(chosen, base=chosen.output, output=chosen.base))
    assert (turned.mobility, turned.kutzbach, turned.agree) == (found(name).mobility, found(name).kutzbach, True)
    assert same(turned.twists, found(name).twists)  # the relative motion is the same but for its sign


@pytest.mark.parametrize(("kinds", "expected"), [
    (["revolute"] * 6, 0),
    (["revolute"] * 7, 1),
    (["revolute"] * 8, 2),
    (["revolute", "cylindrical", "cylindrical", "cylindrical"], 1),
    (["revolute", "spherical", "spherical", "revolute"], 2),
    (["prismatic"] * 3, 0),
    (["prismatic"] * 4, 1),
])  # fmt: skip
def test_loops_of_random_joints(kinds: list[str], expected: int) -> None:
    answer = mobility(random_loop(kinds, np.random.default_rng(len(kinds))))
    assert answer.mobility == answer.by_closure == expected
    assert answer.agree
    assert answer.kind == ("full cycle" if expected else "structure")


def test_routes_agree_on_any_linkage() -> None:
    """Reciprocity and loop closure share no equation; aligned and coincident axes make nearly all of these special."""
    rng, counted = np.random.default_rng(6), 0
    for _case in range(50):
        chosen = any_linkage(rng)
        if chosen is not None:
            assert mobility(chosen).agree, chosen
            counted += 1
    assert counted >= 40


def test_hinges_that_meet_in_a_point() -> None:
    axes = np.random.default_rng(4).normal(size=(4, 3))
    answer = mobility(loop([{"kind": "revolute", "axis": tuple(a.tolist()), "point": (0.1, 0.2, 0.3)} for a in axes]))
    assert (answer.mobility, answer.kutzbach.order, answer.agree) == (1, 3, True)


def test_a_screw_jack() -> None:
    along = {"axis": (0.0, 0.0, 1.0), "point": (0.0, 0.0, 0.0)}
    jack = loop([{"kind": "revolute", **along}, {"kind": "helical", "pitch": 0.002, **along},
                 {"kind": "prismatic", "axis": (0.0, 0.0, 1.0)}])  # fmt: skip
    answer = mobility(jack)
    assert (answer.mobility, answer.kutzbach.order, answer.freedoms) == (1, 2, ["translation along Z"])
    nut = mobility(msgspec.structs.replace(jack, base="2", output="1"))
    assert nut.freedoms == ["screw motion about Z with a pitch of 0.002 m/rad"]


def test_legs_between_balls_spin() -> None:
    """Six SPS legs: twelve freedoms, six of them spins that the platform does not notice."""
    joints = [
        Joint(name=joint.name, kind="spherical", links=joint.links, point=joint.point)
        if joint.kind == "universal"
        else joint
        for joint in known("stewart-gough").joints
    ]
    answer = mobility(msgspec.structs.replace(known("stewart-gough"), joints=tuple(joints)))
    assert (answer.mobility, answer.passive, answer.locked, len(answer.freedoms)) == (12, 6, 6, 6)
    assert answer.agree


def test_limbs_with_loops_of_their_own() -> None:
    """The Delta robot: a crank and a parallelogram of balls in each limb; three translations, six rods that spin."""
    joints = list[Joint]()
    for k, angle in enumerate(2.0 * np.pi * np.arange(3) / 3.0):
        radial, side = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([-np.sin(angle), np.cos(angle), 0.0])

        def at(r: float, z: float, s: float, radial: Array = radial, side: Array = side) -> Any:
            return tuple(float(x) for x in r * radial + s * side + [0.0, 0.0, z])

        joints.append(Joint(name=f"A{k}", kind="revolute", links=("base", f"crank{k}"), axis=at(0, 0, 1),
                            point=at(0.2, 0, 0), actuated=True))  # fmt: skip
        for rod, s in (("l", -0.05), ("r", 0.05)):
            middle = f"rod{k}{rod}"
            joints.append(
                Joint(name=f"B{middle}", kind="spherical", links=(f"crank{k}", middle), point=at(0.4, 0.1, s))
            )
            joints.append(Joint(name=f"C{middle}", kind="spherical", links=(middle, "plate"), point=at(0.1, 0.6, s)))
    answer = mobility(linkage(joints, "base", "plate"))
    assert answer.freedoms == ["translation along X", "translation along Y", "translation along Z"]
    assert (answer.mobility, answer.passive, answer.locked, answer.agree) == (9, 6, 6, True)
    assert [limb.simple for limb in answer.limbs[0]] == [False] * 3
    assert all(len(limb.constraints) == 1 for limb in answer.limbs[0])
    assert all("couple" in limb.constraints[0] for limb in answer.limbs[0])


@pytest.mark.parametrize(("points", "here", "beyond", "kind"), [
    ([(0, 0), (0, 1), (2, 1.3), (3, 0)], 1, 1, "full cycle"),
    ([(0, 0), (1, 0), (3, 0), (2, 0)], 2, 1, "singular reference"),  # a parallelogram folded flat
    ([(0, 0), (1, 0), (2, 0), (3, 0)], 2, 0, "instantaneous"),  # four bars stretched to their limit
    ([(0, 0), (1, 0), (2, 0)], 1, 0, "instantaneous"),
    ([(0, 0), (1, 0), (1, 1)], 0, 0, "structure"),
])  # fmt: skip
def test_full_cycle_or_instantaneous(points: list[tuple[float, float]], here: int, beyond: int, kind: str) -> None:
    answer = mobility(hinges(points))
    assert (answer.by_closure, answer.mobility, answer.kind, answer.agree) == (here, beyond, kind, True)


def test_a_freedom_that_is_never_kept_is_not_counted() -> None:
    """A four-bar linkage with a stretched bar between two hinges of its crank: it shakes in every configuration."""
    turn = {"kind": "revolute", "axis": (0.0, 0.0, 1.0)}
    ends = [("0", "1", (0, 0)), ("1", "2", (0, 1)), ("2", "3", (2, 1.3)), ("3", "0", (3, 0)),
            ("1", "4", (0, 0.2)), ("4", "5", (0, 0.5)), ("5", "1", (0, 0.8))]  # fmt: skip
    joints = [
        msgspec.convert({"name": f"{k}", "links": (a, b), "point": (x, y, 0.0), **turn}, type=Joint)
        for k, (a, b, (x, y)) in enumerate(ends)
    ]
    answer = mobility(linkage(joints, "0", "2"))
    assert (answer.by_closure, answer.mobility, answer.kind) == (2, 1, "singular reference")


def test_bennett_condition_missed() -> None:
    bent = known("bennett")
    first = bent.joints[0]
    off = msgspec.structs.replace(first, axis=(1e-4, 0.0, 1.0))
    answer = mobility(msgspec.structs.replace(bent, joints=(off, *bent.joints[1:])))
    assert (answer.mobility, answer.kind, answer.agree) == (0, "structure", True)


@pytest.mark.parametrize(("hinge", "expected"), [("A1", 1), ("C2", 1), ("M2", 2), ("E4", 2)])
def test_the_redundant_hinges_of_the_rcm_linkage(hinge: str, expected: int) -> None:
    """Without a corner it still has one freedom and no redundant constraint; the middle hinges are all needed."""
    chosen = known("rcm")
    joints = tuple(joint for joint in chosen.joints if joint.name != hinge)
    answer = mobility(msgspec.structs.replace(chosen, joints=joints))
    assert (answer.mobility, answer.agree) == (expected, True)
    assert answer.kutzbach.redundant == (0 if expected == 1 else 1)


@pytest.mark.parametrize("turn", [-0.7, 0.3, np.pi / 4])
def test_the_plate_turns_about_the_pipe(turn: float) -> None:
    answer = mobility(rcm_linkage(load_pipe_climber().rcm, turn))
    assert (answer.mobility, answer.freedoms) == (1, ["rotation about Z"])


def test_either_gripper_and_every_pose() -> None:
    robot = load_pipe_climber()
    upper = mobility(whole_robot(robot, fixed="upper"))
    assert (upper.mobility, upper.freedoms) == (4, found("pipe-climber").freedoms)
    for convention in ("text", "equations"):
        layout = Layout((0.1, 0.1, 0.075, 0.075), convention)
        answer = mobility(parallel_mechanism(layout, 0.02, (0.03, 0.15, -0.4)))
        assert (answer.mobility, answer.locked, answer.freedoms) == (3, 0, found("3-rpr").freedoms)


def test_cylinders_that_do_not_hold_the_platform() -> None:
    """K = L1 (L2 - L4) + L3 L4 = 0 in the convention of the equations: singular with both platforms parallel."""
    answer = mobility(parallel_mechanism(Layout((0.10, 0.05, 0.05, 0.10), "equations"), 0.02))
    assert (answer.mobility, answer.locked, answer.kind) == (3, 1, "full cycle")


def test_limbs_in_words() -> None:
    stages = found("pipe-climber").limbs
    assert [[limb.joints for limb in stage] for stage in stages] == [["RRRRRRRR"], ["RPR"] * 3]
    assert stages[1][0].constraints == ["force along Y", "couple about X", "couple about Z"]
    rrs = found("3-rrs").limbs[0]
    assert [limb.connectivity for limb in rrs] == [5, 5, 5]
    assert rrs[0].constraints == ["force along Y through (0.2, 0, 0.3) m"]


HINGE = 'kind = "revolute"\nlinks = ["a", "b"]\npoint = [0, 0, 0]\naxis = [0, 0, 1]'
GOOD = f"""name = "n"
description = ""
source = ""
links = ["a", "b"]
base = "a"
output = "b"
[[joints]]
name = "J"
{HINGE}
"""
REFUSED = {
    "axis of no number": ("axis = [0, 0, 1]", "axis = [0, nan, 1]", ("'J'", "axis", "not finite")),
    "axis without end": ("axis = [0, 0, 1]", "axis = [0, inf, 1]", ("'J'", "axis", "not finite")),
    "axis without length": ("axis = [0, 0, 1]", "axis = [0, 0, 0]", ("'J'", "no length")),
    "axis too long": ("axis = [0, 0, 1]", "axis = [0, 0]", ("axis",)),
    "point far away": ("point = [0, 0, 0]", "point = [0, 1e200, 0]", ("point", "1e+12")),
    "no axis": ("axis = [0, 0, 1]", "", ("without axis",)),
    "a pitch for nothing": ("axis = [0, 0, 1]", "axis = [0, 0, 1]\npitch = 0.1", ("with pitch",)),
    "unknown kind": ('"revolute"', '"hinge"', ("hinge",)),
    "unknown link of a joint": ('links = ["a", "b"]\npoint', 'links = ["a", "c"]\npoint', ("unknown link 'c'",)),
    "a joint of one link": ('links = ["a", "b"]\npoint', 'links = ["a", "a"]\npoint', ("to itself",)),
    "unknown base": ('base = "a"', 'base = "z"', ("base", "'z'")),
    "output is base": ('output = "b"', 'output = "a"', ("output", "base as well")),
    "a loose link": ('links = ["a", "b"]\nbase', 'links = ["a", "b", "c"]\nbase', ("'c'", "not connected")),
    "a link twice": ('links = ["a", "b"]\nbase', 'links = ["a", "b", "b"]\nbase', ("'b' twice",)),
    "a name of nothing": ('name = "J"', 'name = ""', ("name ''",)),
    "parallel axes": ('"revolute"', '"universal"\nsecond_axis = [0, 0, -2]', ("parallel",)),
    "unknown field": ('name = "J"', 'name = "J"\ncolour = 1', ("colour",)),
    "no table": ("[[joints]]", "[[joints", ("TOML", "") ),
    "no joints": (GOOD[GOOD.index("[[joints]]") :], "joints = []", ("joints", "none")),
    "a joint twice": ("[[joints]]", f'[[joints]]\nname = "J"\n{HINGE}\n[[joints]]', ("'J' twice",)),
}  # fmt: skip


def test_the_file_they_spoil_is_good(tmp_path: Path) -> None:
    (tmp_path / "n.toml").write_text(GOOD)
    answer = mobility(load_linkage(tmp_path / "n.toml"))
    assert (answer.mobility, answer.freedoms, answer.kind) == (1, ["rotation about Z"], "full cycle")


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_linkage(name: str, tmp_path: Path) -> None:
    before, after, words = REFUSED[name]
    assert before in GOOD
    path = tmp_path / "n.toml"
    path.write_text(GOOD.replace(before, after, 1))
    with pytest.raises(InputError) as error:
        load_linkage(path)
    assert "\n" not in str(error.value)
    assert "n.toml" in str(error.value)
    for word in words:
        assert word.lower() in str(error.value).lower()


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", b"", b"[" * 5000, b"a = 1\n" * 300_000])
def test_no_file_of_a_linkage(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "n.toml"
    path.write_bytes(content)
    with pytest.raises(InputError, match="n.toml"):
        load_linkage(path)


@pytest.mark.parametrize("name", ["nowhere.toml", "\0", ".", "benett"])
def test_no_such_linkage(name: str) -> None:
    with pytest.raises(InputError, match="bennett"):
        load_linkage(name)


def test_how_near_to_a_singular_configuration() -> None:
    """The least singular value that counts falls in proportion as four bars come close to lying flat."""
    kept = [mobility(hinges([(0, 0), (1, h), (3, h), (2, 0)])).least_kept for h in (1e-2, 1e-3, 1e-4)]
    assert np.array(kept[:2]) / kept[1:] == pytest.approx(10.0, rel=1e-3)


def test_no_linkage_of_hundreds_of_joints() -> None:
    with pytest.raises(InputError, match="at most 120"):
        hinges([(float(k), float(k * k)) for k in range(121)])
