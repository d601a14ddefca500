"""The anchors command: the paper's values, its contract, and what it refuses."""

from __future__ import annotations

import csv

import numpy as np
import pytest

EVERY = ["anchors", "table-iii", "--path", "eq28", "--window-m", "0.05", "--move"]
KEYS = {
    "mean_tension_factor",
    "feasible",
    "poses",
    "travel_m",
    "fixed_mean_tension_factor",
    "tension_factor",
    "configurations",
    "certified_gap",
    "seconds",
}


@pytest.mark.parametrize(
    ("move", "method", "name"),
    [
        ("1", ["--method", "algorithm-2", "--step-m", "0.01"], "a1_grid_1_cm"),
        ("1", [], "a1_continuous"),
        ("1,2,3,4", ["--method", "algorithm-2", "--step-m", "0.01"], "all_grid_1_cm"),
        ("4,3,2,1", [], "all_continuous"),
    ],
)
def test_published_means(steeplejack, reference, move, method, name):
    answer = steeplejack(*EVERY, move, *method, "--json").answer
    assert set(answer) >= KEYS
    assert answer["mean_tension_factor"] == pytest.approx(reference["eq28"]["movable"][name], abs=1e-6)
    assert answer["fixed_mean_tension_factor"] == pytest.approx(reference["eq28"]["mean"], abs=1e-6)
    assert answer["poses"] == len(answer["tension_factor"]) == len(answer["configurations"]) == 51
    held = [value for value in answer["tension_factor"] if value is not None]
    assert len(held) == answer["feasible"]
    assert sum(held) / 51 == pytest.approx(answer["mean_tension_factor"], abs=1e-12)
    offsets = np.array([v for v in answer["configurations"] if v is not None])
    assert np.abs(offsets).max() <= 0.05 + 1e-12
    if move == "1":
        assert np.all(offsets[:, 1:] == 0.0)
        assert answer["feasible"] < 51
    if not method:
        assert 0.0 <= answer["certified_gap"] <= 1e-6


def test_a_price_on_travel_keeps_nearly_everything(steeplejack):
    answer = steeplejack(*EVERY, "1,2,3,4", "--travel-price", "0.02", "--json").answer
    assert answer["travel_m"] < 0.25
    assert answer["mean_tension_factor"] >= 0.98 * 0.517095
    assert answer["drives_not_held"] == 0
    offsets = np.array(answer["configurations"])
    assert answer["certified_gap"] >= 0.02 * answer["travel_m"]
    assert np.all(np.abs(np.diff(offsets[:, 0])) <= answer["travel_m"])


def test_files_hold_the_answer(steeplejack, folder):
    arguments = ["1,4", "--objective", "slip-margin", "--mass-kg", "8", "--tension-n", "10", "250", "--method"]
    outcome = steeplejack(*EVERY, *arguments, "algorithm-2", "--step-m", "0.025", "--json", "--out", "found")
    answer = outcome.answer
    rows = list(csv.DictReader((folder / "found" / "anchors.csv").read_text().splitlines()))
    assert len(rows) == 51
    margins = [float(row["value"]) if row["held"] == "1" else None for row in rows]
    for told, written in zip(answer["slip_margin"], margins, strict=True):
        assert told == (None if written is None else pytest.approx(written, rel=1e-6))
    assert answer["certified_gap"] is None
    assert (folder / "found" / "anchors.svg").read_text().startswith("<?xml")


def test_a_path_from_a_file(steeplejack, folder):
    (folder / "path.csv").write_text("x_m,y_m,phi_deg,note\n-0.1,0.45,50,a\n0,0.4,50,b\n")
    answer = steeplejack(
        "anchors", "table-iii", "--path", "path.csv", "--move", "2", "--window-m", "0", "--json"
    ).answer
    assert answer["tension_factor"] == pytest.approx([0.777337915, 0.500401150], abs=1e-9)
    assert answer["travel_m"] == 0.0


def test_a_path_nobody_holds_names_the_limit(steeplejack, folder):
    (folder / "path.csv").write_text("x_m,y_m,phi_deg\n3,3,50\n")
    question = ["anchors", "table-iii", "--path", "path.csv", "--move", "1,2,3,4", "--window-m", "0.05", "--json"]
    outcome = steeplejack(*question)
    assert outcome.code == 3
    assert "wrench closure" in outcome.answer["binding"]
    assert outcome.answer["tension_factor"] == outcome.answer["configurations"] == [None]
    assert outcome.err.count("\n") == 1


@pytest.mark.parametrize(
    ("tensions", "limit"),
    [(("200", "210"), "least tension of 200 N"), (("1", "20"), "largest tension of 20 N")],
)
def test_a_load_nobody_holds_names_the_limit(steeplejack, folder, tensions, limit):
    (folder / "path.csv").write_text("x_m,y_m,phi_deg\n-0.1,0.45,50\n")
    question = ["anchors", "table-iii", "--path", "path.csv", "--move", "1,2,3,4", "--window-m", "0.02"]
    outcome = steeplejack(*question, "--mass-kg", "8", "--tension-n", *tensions, "--travel-price", "1", "--json")
    assert outcome.code == 3
    assert limit in outcome.answer["binding"]
    assert outcome.answer["fixed_mean_tension_factor"] == 0.0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--path", "eq28", "--move", "1,5", "--window-m", "0.05"], "--move: 1,5"),
        (["--path", "eq28", "--move", "1,1", "--window-m", "0.05"], "--move: 1,1"),
        (["--path", "eq28", "--move", "", "--window-m", "0.05"], "--move"),
        (["--path", "eq28", "--move", "1", "--window-m", "-1"], "--window-m: -1"),
        (["--path", "eq28", "--move", "1", "--window-m", "nan"], "--window-m: nan"),
        (["--path", "eq28", "--move", "1", "--window-m", "0.05", "--step-m", "0.01"], "--step-m"),
        (["--path", "eq28", "--move", "1", "--window-m", "0.05", "--method", "algorithm-2"], "--step-m: none"),
        (["--path", "eq28", "--move", "1", "--window-m", "0.05", "--travel-price", "-1"], "--travel-price: -1"),
        (["--path", "eq28", "--move", "1", "--window-m", "0.05", "--objective", "slip-margin"], "no load"),
        (["--path", "eq28", "--move", "1", "--window-m", "0.05", "--mass-kg", "8"], "one without the other"),
        (["--path", "eq28", "--move", "1", "--window-m", "1e9"], "--window-m: anchor 1"),
        (
            [
                "--path",
                "eq28",
                "--move",
                "1,2,3,4",
                "--window-m",
                "0.05",
                "--method",
                "algorithm-2",
                "--step-m",
                "1e-6",
            ],
            "--step-m: 1e-06 m",
        ),
        (["--path", "nowhere.csv", "--move", "1", "--window-m", "0.05"], "nowhere.csv"),
        (["--path", "bad.csv", "--move", "1", "--window-m", "0.05"], "path bad.csv line 3 y_m: 'high'"),
        (["--path", "short.csv", "--move", "1", "--window-m", "0.05"], "no column phi_deg"),
        (["--path", "empty.csv", "--move", "1", "--window-m", "0.05"], "no rows"),
    ],
)
def test_bad_questions_are_one_line_and_write_nothing(steeplejack, folder, arguments, said):
    (folder / "bad.csv").write_text("x_m,y_m,phi_deg\n0,0.4,50\n0,high,50\n")
    (folder / "short.csv").write_text("x_m,y_m\n0,0.4\n")
    (folder / "empty.csv").write_text("")
    outcome = steeplejack("anchors", "table-iii", *arguments, "--out", "found", "--json")
    assert outcome.code == 2
    assert outcome.out == ""
    assert said in outcome.err
    assert outcome.err.count("\n") == 1
    assert not (folder / "found").exists()
