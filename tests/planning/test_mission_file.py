"""The mission file: what is read is what was written, and anything else is refused in one line."""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from steeplejack.errors import InputError
from steeplejack.planning import Leg, Mission, Request, Uncovered, Waypoint, decode, encode, write
from steeplejack.planning.mission import FORMAT

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
FOURS, THREES = st.tuples(*[NUMBERS] * 4), st.tuples(*[NUMBERS] * 3)
WAYPOINTS = st.builds(Waypoint, NUMBERS, THREES, THREES, FOURS, FOURS, FOURS, FOURS)
LEGS = st.builds(
    Leg,
    st.sampled_from(["inspect", "fly", "drive", "brace"]),
    st.integers(0, 9),
    st.none() | st.text(),
    st.none() | st.integers(1, 4),
    NUMBERS,
    NUMBERS,
    st.lists(WAYPOINTS, max_size=4).map(tuple),
)
UNCOVERED = st.lists(st.builds(Uncovered, st.text(), NUMBERS, NUMBERS, st.text()), max_size=3)


def made(legs: tuple[Leg, ...], name: str, uncovered: tuple[Uncovered, ...]) -> Mission:
    asked = Request(name, "ccrobot-s", "T1L-main", (5, 9), 20.0, 53.3, "under", 0.0, (20.0, 250.0))
    stays = ("T1L-M05", "T1L-M09")
    return Mission(FORMAT, asked, stays, ("T1L-M06",), (*stays, *stays[::-1]), 0.1, (), legs, uncovered).sealed()


def refusal(content: bytes) -> str:
    with pytest.raises(InputError) as error:
        decode(content, "a.mission.json")
    assert "\n" not in str(error.value)
    assert error.value.where == "a.mission.json"
    return str(error.value)


@given(st.lists(LEGS, max_size=3).map(tuple), st.text(), UNCOVERED.map(tuple))
@settings(max_examples=100, deadline=None)
def test_random_missions_come_back(legs: tuple[Leg, ...], name: str, uncovered: tuple[Uncovered, ...]) -> None:
    mission = made(legs, name, uncovered)
    assert decode(encode(mission), "here") == mission


@pytest.mark.parametrize("name", ['"legs": []', '"waypoints":[]', "a\nb", 'quote " and \\'])
def test_names_that_look_like_the_layout_do_no_harm(name: str) -> None:
    point = Waypoint(0.0, (1.0, 2.0, 3.0), (1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0), *[(1.0, 2.0, 3.0, 4.0)] * 3)
    mission = made((Leg("inspect", 0, name, None, 1.0, 1.0, (point, point)),), name, ())
    assert decode(encode(mission), "here") == mission


def test_planned_mission_comes_back_from_its_file(mission: Mission, tmp_path: Path) -> None:
    path = tmp_path / "inspection.mission.json"
    write(mission, path)
    assert decode(path.read_bytes(), str(path)) == mission
    assert json.loads(path.read_bytes())["assumed"] == ["diameter: as a test assumes"]


def test_one_waypoint_a_line(mission: Mission) -> None:
    """A person finds a waypoint with grep; a difference between two plans shows line by line."""
    lines = encode(mission).decode().splitlines()
    points = [json.loads(line.strip().rstrip(",")) for line in lines if line.startswith("   {")]
    assert [point["position_m"] for point in points] == [
        list(point.position_m) for leg in mission.legs for point in leg.waypoints
    ]
    assert max(len(line) for line in lines) < 500
    assert sum('"kind":' in line for line in lines) == len(mission.legs)


def test_hash_is_that_of_the_content(mission: Mission) -> None:
    assert len(mission.sha256) == 64
    assert mission.sealed() == mission
    other = msgspec.structs.replace(mission, reserve=0.2).sealed()
    assert other.sha256 != mission.sha256


@pytest.mark.parametrize("number", ["tension_n", "base_s_m", "position_m", "travel"])
def test_an_edited_number_is_found(mission: Mission, number: str) -> None:
    raw = json.loads(encode(mission))
    point = raw["legs"][-1]["waypoints"][-1]
    if number == "travel":
        point[number] += 1e-6
    else:
        point[number][2] += 1e-4
    assert "does not match its sha256" in refusal(json.dumps(raw).encode())


def test_another_layout_of_the_same_numbers_is_the_same_mission(mission: Mission) -> None:
    assert decode(json.dumps(json.loads(encode(mission))).encode(), "here") == mission


def test_wrong_format_is_named(mission: Mission) -> None:
    later = msgspec.structs.replace(mission, format="steeplejack-mission-9").sealed()
    assert "steeplejack-mission-9" in refusal(encode(later))


def test_unknown_and_missing_keys_are_named(mission: Mission) -> None:
    raw = json.loads(encode(mission))
    assert "colour" in refusal(json.dumps(raw | {"colour": "red"}).encode())
    raw["legs"][0]["waypoints"][0]["colour"] = 1
    assert "colour` - at `$.legs[" in refusal(json.dumps(raw).encode())
    raw = json.loads(encode(mission))
    del raw["carriers"]
    assert "carriers" in refusal(json.dumps(raw).encode())


@pytest.mark.parametrize("content", [b"", b"{", b"\x00\x01", b"\xff\xfe", b"[]", b"null", b'{"format": 3}'])
def test_what_is_no_mission_is_refused(content: bytes) -> None:
    assert "a mission written by" in refusal(content)


def test_text_in_a_number_is_named(mission: Mission) -> None:
    raw = json.loads(encode(mission))
    raw["request"]["from_m"] = "thirty"
    assert "$.request.from_m" in refusal(json.dumps(raw).encode())
