"""Tables of reports: what becomes of the values of a row."""

from __future__ import annotations

from supple_benchmarks.table import table_of


def test_cells_have_four_digits_and_missing_values_are_empty():
    rows = [{"body": "strip", "error": None}, {"body": "blade", "error": 1.23456e-3, "tip": [1.23456, -2.0]}]
    title, heads, cells = table_of("errors", rows)
    assert (title, heads) == ("errors", ["body", "error", "tip"])
    assert cells == [["strip", "", ""], ["blade", "0.001235", "1.235, -2"]]
