"""The validation: what its command promises, and every case; the longest with `make soak`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer import Typer
from typer.testing import CliRunner

from supple_benchmarks.commands import validation
from supple_benchmarks.validation import every_case
from supple_benchmarks.validation.report import markdown_table, with_table
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase, largest_difference

KEYS = {"name", "quantity", "value", "reference", "source", "error", "allowed"}


def right():
    return [
        Comparison("length, m", 1.01, 1.0, "a ruler", 0.02),
        Comparison("gap, m", 1e-9, 0.0, "none", 1e-6, 1.0),
    ]


def wrong():
    return [Comparison("length, m", 1.1, 1.0, "a ruler", 0.02)]


def failing():
    raise ZeroDivisionError("no mass")


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Runs the command on some cases, and gives its outcome and its report."""

    def run(*compare, options=()):
        cases = [ValidationCase(each.__name__, each, quick=each is not wrong) for each in compare]
        monkeypatch.setattr(every_case, "CASES", tuple(cases))
        app = Typer()
        app.command()(validation)
        target = tmp_path / "report.json"
        outcome = CliRunner().invoke(app, ["--json", str(target), *options])
        return outcome, json.loads(target.read_text())

    return run


def test_cases_within_what_they_allow_end_well(run):
    outcome, report = run(right)
    assert outcome.exit_code == 0
    assert [set(row) for row in report["cases"]] == [KEYS, KEYS]
    row = report["cases"][0]
    assert row["error"] == pytest.approx(0.01)
    assert (row["name"], row["quantity"], row["source"]) == ("right", "length, m", "a ruler")


def test_a_case_outside_of_what_it_allows_is_an_error(run):
    outcome, report = run(right, wrong)
    assert outcome.exit_code != 0
    assert "1 of 3 rows exceed their allowed errors or failed: wrong: length, m" in outcome.output
    assert report["cases"][-1]["error"] == pytest.approx(0.1)


def test_a_case_that_fails_is_an_error_and_the_others_go_on(run):
    outcome, report = run(failing, right)
    assert outcome.exit_code != 0
    assert "failing: ZeroDivisionError: no mass" in outcome.output
    assert report["cases"][0]["failure"] == "ZeroDivisionError: no mass"
    assert report["cases"][0]["error"] is None
    assert KEYS <= set(report["cases"][0])
    assert report["cases"][1]["name"] == "right"


def test_a_number_that_is_none_is_outside(run):
    def lost():
        return [Comparison("length, m", float("nan"), 1.0, "a ruler", 1e9)]

    outcome, report = run(lost)
    assert outcome.exit_code != 0
    assert report["cases"][0]["value"] is None


def test_the_quick_form_leaves_out_the_longest_cases(run):
    outcome, report = run(right, wrong, options=["--quick"])
    assert outcome.exit_code == 0
    assert {row["name"] for row in report["cases"]} == {"right"}


def test_the_table_of_the_documentation_has_a_line_for_each_row(run):
    _, report = run(right)
    *_, length, gap = markdown_table(report["cases"]).splitlines()
    assert length == "| right | length, m | 1.01 | 1 | 1.0e-02 | 2.0e-02 | a ruler |"
    assert gap.startswith("| right | gap, m | 1e-09 | 0 |")


def test_the_table_takes_its_place_in_the_page_again_and_again(run):
    _, report = run(right)
    page = "Before\n<!-- table -->\n<!-- end of table -->\nAfter\n"
    filled = with_table(page, report["cases"])
    assert filled == with_table(filled, report["cases"])
    assert filled.splitlines()[0] == "Before"
    assert filled.splitlines()[-1] == "After"
    assert filled.count("| right |") == 2


def test_the_largest_difference_of_histories_is_one_of_their_sizes():
    exact = np.array([[3.0, 4.0], [0.0, 1.0]])
    each = largest_difference("place, m", exact + np.array([[0.0, 0.1], [0.0, 0.0]]), exact, "none", 0.03)
    assert (each.value, each.error) == pytest.approx((0.1, 0.02))
    assert largest_difference("angle", [1.0, 2.5], [1.0, 2.0], "none", 0.1, scale=5.0).error == pytest.approx(
        0.1
    )


def test_every_topic_is_listed():
    folder = Path(every_case.__file__).parent
    topics = {path.stem for path in folder.glob("*.py") if "\nCASES" in path.read_text(encoding="utf-8")}
    assert topics - {"every_case"} == set(every_case.TOPICS)


def test_names_of_cases_differ():
    names = [case.name for case in every_case.CASES]
    assert len(set(names)) == len(names)


def test_the_page_has_every_case():
    """Where it does not: make the report anew, then `python benchmarks/validation_page.py`."""
    page = (Path(__file__).parents[2] / "docs" / "validation.md").read_text(encoding="utf-8")
    assert [case.name for case in every_case.CASES if f"| {case.name} |" not in page] == []


MARKED = [
    pytest.param(case, id=case.name, marks=pytest.mark.slow if case.quick else pytest.mark.soak)
    for case in every_case.CASES
]


@pytest.mark.parametrize("case", MARKED)
def test_every_case_is_within_what_it_allows(case):
    for each in case.compare():
        assert each.holds, f"{each.quantity}: {each.value} beside {each.reference}, error {each.error:.2g}"
