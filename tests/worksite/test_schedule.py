"""Stay schedules: what comes back is what went in, and every bad cell is named by line and column."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from random_schedules import as_csv, schedules

from steeplejack.errors import InputError
from steeplejack.worksite import Stay, read_schedule
from steeplejack.worksite.schedule import STEEL_MODULUS

GUO = Path(__file__).parents[2].parent / "shared" / "data" / "guo2019" / "stays.csv"
HEADER = (
    "cable_id,tower,plane,side,index,x_deck_m,y_deck_m,z_deck_m,x_tower_m,y_tower_m,z_tower_m,"
    "diameter_m,area_m2,force_kN,w_kN_per_m,status"
)
FIRST = "a,1,L,main,1,0,14,50,-20,4,110,0.12,0.0075,3500,0.6,drawn"
SECOND = "b,1,L,main,2,10,14,50,-20,4,114,,,,,drawn"
GOOD = "\n".join([HEADER, FIRST, SECOND])


def refusal(content: bytes | str) -> str:
    """The one line a schedule is refused with."""
    with pytest.raises(InputError) as error:
        read_schedule(content if isinstance(content, bytes) else content.encode(), "stays.csv")
    assert "\n" not in str(error.value)
    return str(error.value)


@given(schedules())
@settings(max_examples=100, deadline=None)
def test_round_trip(drawn: list[Stay]):
    bridge = read_schedule(as_csv(drawn), "random")
    assert len(bridge.stays) == len(drawn) == sum(len(fan.stays) for fan in bridge.fans.values())
    for stay, origin in zip(bridge.stays, drawn, strict=True):
        for name in ("id", "fan", "index", "lower", "upper", "diameter", "unknown"):
            assert getattr(stay, name) == getattr(origin, name)
        for name in ("weight", "tension", "axial_stiffness"):
            assert getattr(stay, name) == pytest.approx(getattr(origin, name))


def test_units_are_converted_at_the_edge():
    first, second = read_schedule(GOOD.encode(), "stays.csv").stays
    assert (first.diameter, first.weight, first.tension) == (0.12, 600.0, 3.5e6)
    assert first.axial_stiffness == pytest.approx(0.0075 * STEEL_MODULUS)
    assert second.unknown == ("diameter", "weight", "tension")
    assert second.axial_stiffness is None


def test_end_zones_are_declared_as_estimates():
    bridge = read_schedule(GOOD.encode(), "stays.csv")
    for stay in bridge.stays:
        np.testing.assert_allclose(stay.free_intervals(0.0, 1e3), [(2.5, stay.length - 2.5)])
        assert all("estimate" in zone.note for zone in stay.intervals)
    assert bridge.notes[0] == "drawn"
    assert "estimate" in bridge.notes[-1]


@pytest.mark.parametrize(
    "text", [GOOD.replace("\n", "\r\n"), "\ufeff" + GOOD, GOOD + "\n\n,,,,,,,,,,,,,,,\n", GOOD.replace(",", " , ")]
)
def test_harmless_variants_are_read_alike(text):
    assert read_schedule(text.encode(), "s").stays == read_schedule(GOOD.encode(), "s").stays


def test_order_of_columns_is_free_and_optional_ones_may_be_missing():
    columns = HEADER.split(",")[:11]
    lines = [columns, *(line.split(",")[:11] for line in (FIRST, SECOND))]
    turned = "\n".join(",".join(reversed(line)) for line in lines)
    assert [stay.upper for stay in read_schedule(turned.encode()).stays] == [(-20.0, 4.0, 110.0), (-20.0, 4.0, 114.0)]


@pytest.mark.parametrize("column", HEADER.split(",")[:11])
def test_missing_column_is_named(column):
    assert f"stays.csv line 1: missing column {column};" in refusal(GOOD.replace(column, "other", 1))


@pytest.mark.parametrize(("column", "value", "said"), [
    ("z_tower_m", "high", "'high'; a finite number"),
    ("z_tower_m", "nan", "'nan'; a finite number"),
    ("x_deck_m", "-inf", "'-inf'; a finite number"),
    ("x_deck_m", "1e999", "'1e999'; a finite number"),
    ("x_deck_m", "1_0", "'1_0'; a finite number"),
    ("x_deck_m", "", "empty; a value is required here"),
    ("cable_id", " ", "empty; a value is required here"),
    ("tower", "one/two", "'one/two'; letters and digits"),
    ("plane", "M", "'M'; one of L, R"),
    ("side", "back", "'back'; one of main, side"),
    ("index", "2.0", "'2.0'; a whole number"),
    ("index", "-2", "'-2'; a whole number"),
    ("index", "two", "'two'; a whole number"),
    ("index", "1", "place 1 of fan T1L-main is taken at stays.csv line 2; each place in a fan once"),
    ("cable_id", "a", "'a' stands already at stays.csv line 2; each id once"),
    ("z_tower_m", "50", "stay b has its tower anchorage at 50 m, not above its deck anchorage; a height over 50 m"),
    ("z_tower_m", "12", "stay b has its tower anchorage at 12 m, not above its deck anchorage; a height over 50 m"),
    ("diameter_m", "-0.1", "-0.1; a number above 0"),
    ("diameter_m", "0", "0; a number above 0"),
    ("diameter_m", "120", "stay b has diameter 120 m; under 1 m"),
    ("area_m2", "-0.001", "-0.001; a number above 0"),
    ("force_kN", "much", "'much'; a finite number"),
    ("w_kN_per_m", "-1", "-1; a number above 0"),
])  # fmt: skip
def test_bad_cell_is_named_by_line_and_column(column, value, said):
    cells = SECOND.split(",")
    cells[HEADER.split(",").index(column)] = value
    assert f"stays.csv line 3, column {column}: {said}" in refusal("\n".join([HEADER, FIRST, ",".join(cells)]))


@pytest.mark.parametrize(("line", "said"), [
    ("b,1,L,main,2,10,14,50,10,14,50,,,,,", "line 3, columns x_deck_m to z_tower_m: stay b has zero length;"),
    ("b,1,L,main,2,0,0,0,9e5,0,2e5,,,,,", "line 3, columns x_deck_m to z_tower_m: stay b is 921954 m long;"),
    ("b,1,L,main,2,0,0,0,300,0,400,,,100,0.6,", "line 3, column force_kN: stay b has tension 100000 N; at least"),
    ("b,1,L,main,2,0,0,0,30,0,40,,0.0001,5000,0.6,", "line 3, column area_m2: stay b strains 26% under its tension;"),
    ("b,1,L,main,2,0,0,0,30,0,40", "line 3: 11 cells; 16 as in the header"),
    ('b,1,L,"main,2', "line 3: unexpected end of data; comma-separated values"),
])  # fmt: skip
def test_bad_line_is_named(line, said):
    assert f"stays.csv {said}" in refusal("\n".join([HEADER, FIRST, line]))


@pytest.mark.parametrize(("content", "said"), [
    (b"", "stays.csv: an empty file;"),
    (b" \n\n", "stays.csv: an empty file;"),
    (HEADER.encode(), "stays.csv: no stays under the header;"),
    (b"\x7fELF\x00\x01", "stays.csv: a binary file;"),
    (b"cable_id,\xff\xfe", "stays.csv: not text at byte 9;"),
    ((HEADER + ",index\n").encode(), "stays.csv line 1: column index stands twice;"),
    (GOOD.replace(",", ";").encode(), "stays.csv line 1: missing column cable_id;"),
])  # fmt: skip
def test_file_that_is_no_schedule_is_refused(content, said):
    assert refusal(content).startswith(said)


def test_missing_file_and_folder_are_refused(tmp_path):
    for path in (tmp_path / "none.csv", tmp_path):
        with pytest.raises(InputError) as error:
            read_schedule(path)
        assert error.value.where == str(path)


def test_path_is_named_as_it_was_given(tmp_path):
    path = tmp_path / "bay.csv"
    path.write_text(GOOD.replace("114", "low"))
    with pytest.raises(InputError) as error:
        read_schedule(path)
    assert error.value.where == f"{path} line 3, column z_tower_m"
    path.write_text(GOOD)
    assert read_schedule(path).name == "bay"


@pytest.mark.skipif(not GUO.exists(), reason="../shared/data/guo2019/stays.csv is not here")
def test_real_bridge_sags_as_published(worksite_reference):
    import csv

    reference = worksite_reference["guo2019"]
    bridge = read_schedule(GUO)
    with GUO.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(bridge.stays) == reference["stays"]
    sags = [stay.sag for stay in bridge.stays]
    parabola = [float(r["sag_mid_m"]) for r in rows]
    np.testing.assert_allclose(sags, parabola, atol=reference["sag_tolerance"], rtol=reference["strain"])
    chords = [math.dist(stay.lower, stay.upper) for stay in bridge.stays]
    np.testing.assert_allclose(chords, [float(r["chord_m"]) for r in rows], atol=2e-3)
    angles = [math.degrees(stay.inclination) for stay in bridge.stays]
    np.testing.assert_allclose(angles, [float(r["incl_deg"]) for r in rows], atol=0.01)
    assert {fan: len(bridge.fan(fan).stays) for fan in bridge.fans} == {
        f"T{tower}{plane}-{side}": count
        for tower, count in ((1, 11), (2, 17))
        for plane in "LR"
        for side in ("main", "side")
    }
