"""The validation: what its command promises, and every case; the longest with `make soak`."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.polynomial import Legendre, Polynomial
from scipy.linalg import eigh
from typer import Typer
from typer.testing import CliRunner

from supple.errors import ArgumentError
from supple_benchmarks.commands import validation
from supple_benchmarks.validation import error_statements, every_case
from supple_benchmarks.validation.report import markdown_table, tables, with_table
from supple_benchmarks.validation.validation_case import (
    Comparison,
    ValidationCase,
    largest_difference,
    matched,
)
from supple_benchmarks.validation.vibrations import plates

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


@pytest.mark.parametrize("page", ["no marks\n", "Before\n<!-- table -->\nAfter\n", "<!-- end of table -->\n"])
def test_a_page_without_a_place_for_the_table_is_refused(page):
    with pytest.raises(ArgumentError, match="no place for the table"):
        with_table(page, [])


def test_a_failed_case_is_marked_as_failed_in_the_table(run):
    _, report = run(failing, right, wrong)
    (_, _, rows), _ = tables(report)
    assert [row[-1] for row in rows if row[0].startswith("  ")] == ["failed", "", "", "OUTSIDE"]


def test_two_expected_values_do_not_share_a_found_one():
    assert matched([5.0, 1.1, 2.0], [1.0, 1.2]) == [1.1, 2.0]
    assert matched([1.1], [5.0, 1.0]) == pytest.approx([np.nan, 1.1], nan_ok=True)


def test_a_quantity_without_an_estimate_is_a_row_that_does_not_hold(monkeypatch):
    errors = {"strip": SimpleNamespace(basis=None)}
    corrected = SimpleNamespace(system=None, solution=SimpleNamespace(errors=errors))
    monkeypatch.setattr(error_statements, "self_correct", lambda *_, **__: corrected)
    monkeypatch.setattr(error_statements, "simulate", lambda *_: None)
    monkeypatch.setattr(error_statements, "quantity_distance", lambda *_: 1.0)
    (row,) = error_statements._corrected(None, None, None, ())
    assert row.quantity == "estimated error, strip"
    assert not row.holds


def test_the_largest_difference_of_histories_is_one_of_their_sizes():
    exact = np.array([[3.0, 4.0], [0.0, 1.0]])
    each = largest_difference("place, m", exact + np.array([[0.0, 0.1], [0.0, 0.0]]), exact, "none", 0.03)
    assert (each.value, each.error) == pytest.approx((0.1, 0.02))
    assert largest_difference("angle", [1.0, 2.5], [1.0, 2.0], "none", 0.1, scale=5.0).error == pytest.approx(
        0.1
    )


def _plate_by_ritz(x: tuple[int, int], y: tuple[int, int], nu: float = 0.3, n: int = 10) -> np.ndarray:
    """w a^2 sqrt(rho h / D) of a square plate; x, y : order of the zero of w at both edges (2: clamped)."""
    points, weights = np.polynomial.legendre.leggauss(2 * n)
    integrals = []
    for first, last in (x, y):
        held = Polynomial([1, 1]) ** first * Polynomial([1, -1]) ** last
        shapes = [held * Legendre.basis(k).convert(kind=Polynomial) for k in range(n)]
        rates = [np.array([2**d * shape.deriv(d)(points) for shape in shapes]) for d in range(3)]
        integrals.append([[(a * weights) @ b.T for b in rates] for a in rates])
    X, Y = integrals
    stiffness = np.kron(X[2][2], Y[0][0]) + np.kron(X[0][0], Y[2][2])
    stiffness += nu * (np.kron(X[2][0], Y[0][2]) + np.kron(X[0][2], Y[2][0]))
    stiffness += 2 * (1 - nu) * np.kron(X[1][1], Y[1][1])
    return np.sqrt(np.abs(eigh(stiffness, np.kron(X[0][0], Y[0][0]), eigvals_only=True)))


def test_the_references_of_the_square_plates_are_those_of_ritz():
    exact = [*_plate_by_ritz((2, 2), (2, 2))[:1], *_plate_by_ritz((2, 0), (0, 0))[:2]]
    exact += [*_plate_by_ritz((0, 0), (0, 0))[3:6]]
    assert [each.reference for each in plates()] == pytest.approx(exact, abs=5e-4)


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
