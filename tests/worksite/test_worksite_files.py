"""Built-in worksites against published figures, and TOML worksites good and bad."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.worksite import BUILT_IN, Bridge, PlanarSite, list_worksites, load_worksite

CSV = "cable_id,tower,plane,side,index,x_deck_m,y_deck_m,z_deck_m,x_tower_m,y_tower_m,z_tower_m,diameter_m\n"
ROWS = "a,1,L,main,1,30,0,0,0,0,40,\nb,1,L,main,2,60,0,0,0,0,80,0.1\n"
HEAD = 'kind = "bridge"\nname = "n"\ndescription = "d"\nsource = "drawing"\n'
WRITTEN = (
    HEAD
    + """
[[stays]]
id = "a"
tower = "1"
plane = "L"
side = "main"
index = 1
lower = [30.0, 0.0, 0.0]
upper = [0.0, 0.0, 40.0]
mass_per_metre = 60.0
tension = 3.0e6
area = 0.0075
"""
)
ASSUMED = """
[assumed]
diameter_range = [0.12, 0.16]
mass_per_metre = 50.0
tension_per_mass = 6e4
[assumed.source]
diameter_range = "estimate"
mass_per_metre = "estimate"
tension_per_mass = "measured"
"""
PLANAR = """
kind = "planar"
name = "p"
description = "d"
source = "s"
anchors = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
stays = [{ id = "1", slope = -1.0, intercept = 0.0, source = "s" }]
"""


def written(tmp_path: Path, text: str, rows: str = ROWS) -> Path:
    """A worksite file with a schedule beside it."""
    (tmp_path / "stays.csv").write_text(CSV + rows)
    path = tmp_path / "site.toml"
    path.write_text(text)
    return path


def refusal(path: Path | str) -> str:
    with pytest.raises(InputError) as error:
        load_worksite(path)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize("name", [name for name in BUILT_IN if name != "table-iii"])
def test_built_in_bridge_has_its_published_totals(name, worksite_reference):
    reference, bridge = worksite_reference["bridges"][name], load_worksite(name)
    assert isinstance(bridge, Bridge)
    assert bridge.name == name
    assert (len(bridge.stays), len(bridge.fans)) == (reference["stays"], reference["fans"])
    assert max(math.dist(s.lower, s.upper) for s in bridge.stays) == pytest.approx(reference["longest"], abs=0.01)
    known = [stay.diameter for stay in bridge.stays if stay.diameter is not None]
    if "diameters" in reference:
        assert len(known) == len(bridge.stays)
        np.testing.assert_allclose([min(known), max(known)], reference["diameters"])
    else:
        assert known == []
    assert any("not as-built" in note for note in bridge.notes)
    assert any("estimate" in note for note in bridge.notes)


def test_ecs620_like_hangs_from_its_published_frequency(worksite_reference):
    reference, bridge = worksite_reference["longest-stay"], load_worksite("ecs620-like")
    assert isinstance(bridge, Bridge)
    for stay in bridge.stays:
        assert stay.unknown == ()
        assert stay.weight == pytest.approx(60.0 * 9.81)
        assert stay.tension == pytest.approx(60.0 * reference["tension_per_mass"])
    stay = min(bridge.stays, key=lambda s: abs(math.dist(s.lower, s.upper) - reference["chord"]))
    assert math.degrees(stay.inclination) == pytest.approx(reference["inclination_deg"], abs=0.5)
    assert stay.sag == pytest.approx(reference["sag"], abs=0.05)
    frequency = math.sqrt(reference["tension_per_mass"]) / (2.0 * reference["chord"])
    assert frequency == pytest.approx(reference["frequency_hz"], abs=0.005)


@pytest.mark.parametrize("name", ["sutong-like", "stonecutters-like"])
def test_diameter_grows_linearly_with_length(name):
    bridge = load_worksite(name)
    assert isinstance(bridge, Bridge)
    chords = np.array([math.dist(s.lower, s.upper) for s in bridge.stays])
    diameters = np.array([s.diameter for s in bridge.stays], dtype=float)
    assert np.corrcoef(chords, diameters)[0, 1] == pytest.approx(1.0, abs=1e-12)
    assert bridge.stays[0].unknown == ("weight", "tension")


def test_table_iii_is_the_papers(worksite_reference):
    reference, site = worksite_reference["table-iii"], load_worksite("table-iii")
    assert isinstance(site, PlanarSite)
    a1, a2, a3, a4 = 100.0 * site.anchors
    np.testing.assert_allclose([*a1, *a2, *a3, *a4], [0.0, 0.0, 40.24, 40.45, -35.22, 89.66, -62.44, 62.44])
    angles = {name: math.degrees(math.atan(-slope)) for name, (slope, _) in site.stays.items()}
    assert angles["1"] == pytest.approx(reference["beta_deg"])
    assert angles["2"] == pytest.approx(reference["alpha_deg"], abs=5e-5)
    for name, anchors in (("1", (a1, a4)), ("2", (a2, a3))):
        slope, intercept = site.stays[name]
        np.testing.assert_allclose(
            [slope * x + 100.0 * intercept for x, _ in anchors], [y for _, y in anchors], atol=1e-10
        )
    slope, intercept = site.stays["2"]
    assert -100.0 * intercept / slope == pytest.approx(reference["foot_of_stay_2_cm"], abs=5e-4)
    slope, intercept = site.stays["3"]
    x, y = reference["track_at_start_cm"]
    assert slope * x + 100.0 * intercept == pytest.approx(y, abs=1e-9)
    assert site.gravity == (0.0, -9.81)
    with pytest.raises(ValueError, match="read-only"):
        site.anchors[0, 0] = 1.0


def test_list_names_every_worksite_with_its_source():
    assert tuple(site.name for site in list_worksites()) == BUILT_IN
    assert all(site.description and site.source for site in list_worksites())
    assert all("not as-built" in site.source for site in list_worksites() if site.name != "table-iii")


def test_schedule_is_loaded_by_its_path(tmp_path):
    bridge = load_worksite(written(tmp_path, HEAD).parent / "stays.csv")
    assert isinstance(bridge, Bridge)
    assert [stay.id for stay in bridge.stays] == ["a", "b"]


def test_assumed_values_fill_gaps_only(tmp_path):
    bridge = load_worksite(written(tmp_path, HEAD + 'schedule = "stays.csv"\n' + ASSUMED))
    assert isinstance(bridge, Bridge)
    a, b = bridge.stays
    assert (a.diameter, b.diameter) == (0.12, 0.1)
    assert a.weight == pytest.approx(50.0 * 9.81)
    assert a.tension == pytest.approx(50.0 * 6e4)
    assert "tension_per_mass: measured" in bridge.notes


def test_written_stays_zones_and_obstacles(tmp_path):
    extra = 'end_zones = { lower = 4.0, upper = 1.0, source = "survey" }\n'
    obstacle = '[[obstacles]]\nstay = "a"\nstart = 20.0\nend = 20.4\nheight = 0.02\nnote = "collar"\n'
    bridge = load_worksite(written(tmp_path, WRITTEN.replace("\n[[stays]]", extra + "[[stays]]") + obstacle))
    assert isinstance(bridge, Bridge)
    (stay,) = bridge.stays
    assert stay.weight == pytest.approx(588.6)
    assert stay.axial_stiffness == pytest.approx(195e9 * 0.0075)
    np.testing.assert_allclose(stay.free_intervals(0.0, 1e3), [(4.0, 20.0), (20.4, stay.length - 1.0)])
    assert stay.intervals[2].note == "collar"


def test_planar_site_is_read(tmp_path):
    site = load_worksite(written(tmp_path, PLANAR))
    assert isinstance(site, PlanarSite)
    assert site.anchors.shape == (4, 2)
    assert site.stays == {"1": (-1.0, 0.0)}


OBSTACLE = '[[obstacles]]\nstay = "{}"\nstart = {}\nend = {}\nnote = "collar"\n'
SECOND = WRITTEN[WRITTEN.index("[[stays]]") :]


@pytest.mark.parametrize(("text", "said"), [
    ("", "an empty file"),
    ("kind = ", "Invalid value"),
    ("\udcff", "decode"),
    (WRITTEN.replace("bridge", "tunnel"), "$.kind"),
    (WRITTEN.replace('kind = "bridge"\n', ""), "kind"),
    (WRITTEN + "diametre = 0.1\n", "diametre"),
    (WRITTEN.replace("mass_per_metre = 60.0", "mass_per_metre = -60.0"), "$.stays[0].mass_per_metre"),
    (WRITTEN.replace("60.0", '"heavy"'), "$.stays[0].mass_per_metre"),
    (WRITTEN.replace('"L"', '"M"'), "$.stays[0].plane"),
    (WRITTEN.replace("3.0e6", "1e3"), "stays[0].tension: stay a has tension 1000 N; at least its own weight"),
    (WRITTEN.replace("3.0e6", "inf"), "stays[0].tension"),
    (WRITTEN.replace("0.0075", "1e-5"), "stays[0].area: stay a strains"),
    (WRITTEN.replace("40.0]", "nan]"), "stays[0].upper: stay a has the anchorage"),
    (WRITTEN.replace("40.0]", "-4.0]"), "stays[0].upper: stay a has its tower anchorage at -4 m"),
    (WRITTEN.replace("[30.0, 0.0, 0.0]", "[0.0, 0.0, 40.0]"), "stays[0].lower and upper: stay a has zero length"),
    (WRITTEN + SECOND, "stays[1]: stay a repeats the id"),
    (WRITTEN + SECOND.replace('"a"', '"b"'), "stays[1]: stay b repeats the place"),
    (HEAD, "either `schedule` or `stays` is needed"),
    (HEAD + 'schedule = "none.csv"\n', "none.csv: No such file"),
    (WRITTEN.replace("\n[[stays]]", 'schedule = "stays.csv"\n[[stays]]'), "either `schedule` or `stays` is needed"),
    (WRITTEN + "[assumed]\ndiameter = 0.1\n[assumed.source]\n", "`diameter` needs both a value and an entry"),
    (WRITTEN + '[assumed]\n[assumed.source]\ndiameter = "x"\n', "`diameter` needs both a value and an entry"),
    (WRITTEN + '[assumed]\ntension = 1e6\ntension_per_mass = 1e4\nsource = { tension = "x", tension_per_mass = "x" }\n',
     "exclude each other"),
    (WRITTEN + '[assumed]\ndiameter = 12.0\nsource = { diameter = "x" }\n', "assumed.diameter: stay a has"),
    (WRITTEN + OBSTACLE.format("z", 1, 2), "obstacles[0].stay: no stay 'z'"),
    (WRITTEN + OBSTACLE.format("a", 20, 10), "obstacles[0]: from 20 to 10 m"),
    (WRITTEN + OBSTACLE.format("a", 20, 90), "obstacles[0]: from 20 to 90 m"),
    (PLANAR.replace("[1.0, 0.0], ", ""), "$.anchors"),
    (PLANAR.replace("slope = -1.0", "slope = nan"), "not finite"),
    (PLANAR.replace('source = "s" }', 'source = "s" }, { id = "1", slope = 1.0, intercept = 0.0, source = "s" }'),
     "an id stands twice"),
])  # fmt: skip
def test_bad_worksite_file_is_refused_in_one_line(tmp_path, text, said):
    path = written(tmp_path, "")
    path.write_bytes(text.encode(errors="surrogateescape"))
    assert said in refusal(path)


@pytest.mark.parametrize("name", ["ecs620", "bridge.ifc", ""])
def test_unknown_worksite_is_refused_with_the_names(name):
    assert "ecs620-like" in refusal(name)


def test_missing_files_are_refused(tmp_path):
    for name in ("none.toml", "none.csv"):
        assert refusal(tmp_path / name).startswith(f"{tmp_path / name}: No such file")
