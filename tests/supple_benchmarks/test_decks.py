"""The benchmark of decks: what is compared, and that a deck that fails ends nothing."""

from __future__ import annotations

import json

import pytest

from supple.errors import ImportFormatError
from supple_benchmarks.decks.perform import compared, perform, totals

BAR = """*NODE
1, 0, 0, 0
2, 1, 0, 0
*ELEMENT, TYPE=B31, ELSET=BAR
1, 1, 2
*BEAM SECTION, ELSET=BAR, MATERIAL=STEEL, SECTION=RECT
0.1, 0.1
0, 0, 1
*MATERIAL, NAME=STEEL
*ELASTIC
2.1E11, 0.3
*DENSITY
7850
*BOUNDARY
1, 1, 6
"""


def test_errors_are_relative_and_motions_without_energy_do_not_count():
    found = {"mass": 2.02, "centre": [0, 0, 0.2], "size": 4.0, "frequencies_hz": [1e-6, 11.0, 20.0]}
    expected = {"mass": 2.0, "cg": [0, 0, 0], "frequencies_hz": [1e-9, 1e-8, 10.0, 20.0, 30.0]}
    errors = compared(found, expected)
    assert errors["mass_error"] == pytest.approx(0.01)
    assert errors["centre_error"] == pytest.approx(0.05)
    assert errors["frequency_errors"] == pytest.approx([0.1, 0.0])
    assert compared({"mass": None}, expected) == {}
    whole = found | errors | {"read": True, "left_out": []}
    summary = totals({"a": whole, "b": {"read": False, "left_out": []}})
    assert (summary["decks"], summary["read"], summary["mass_error_within"]) == (2, 1, 0)


@pytest.mark.slow
def test_a_deck_is_read_and_weighed(tmp_path):
    (tmp_path / "bar.inp").write_text(BAR)
    (tmp_path / "expected.json").write_text(json.dumps({"bar.inp": {"mass": 78.5, "cg": [0.5, 0, 0]}}))
    report = tmp_path / "report.json"
    perform(tmp_path, report, 60.0)
    numbers = json.loads(report.read_text())
    assert numbers["decks"]["bar.inp"]["mass_error"] < 1e-12
    assert numbers["decks"]["bar.inp"]["elements"] == {"B31": 1}
    assert numbers["totals"]["read"] == 1


@pytest.mark.slow
def test_a_folder_with_a_deck_that_fails_and_one_that_is_not_there(tmp_path):
    (tmp_path / "bar.inp").write_text(BAR)
    (tmp_path / "broken.inp").write_text("no deck at all")
    expected = {"bar.inp": {"mass": 78.5, "cg": [0.5, 0, 0]}, "broken.inp": {}, "absent.inp": {"mass": 1.0}}
    (tmp_path / "expected.json").write_text(json.dumps(expected))
    report = tmp_path / "report.json"
    perform(tmp_path, report, 60.0)
    numbers = json.loads(report.read_text())
    assert not numbers["decks"]["broken.inp"]["read"]
    assert "absent.inp" in numbers["decks"]["absent.inp"]["why"]
    assert numbers["totals"]["read"] == 1
    perform(tmp_path, report, 0.0)
    assert "took longer than 0 s" in json.loads(report.read_text())["decks"]["bar.inp"]["why"]


def test_a_folder_without_expected_numbers_is_refused(tmp_path):
    with pytest.raises(ImportFormatError, match=r"give a folder with expected\.json"):
        perform(tmp_path, tmp_path / "report.json", 60.0)
