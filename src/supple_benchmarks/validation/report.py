"""The table of the validation, on the terminal and in the documentation."""

from __future__ import annotations

from collections.abc import Iterable

from supple.errors import ArgumentError
from supple_benchmarks.table import Report, Row, Table

__all__ = ["markdown_table", "outside", "tables", "with_table"]

BEGIN, END = "<!-- table -->", "<!-- end of table -->"
HEADS = ["case", "quantity", "value", "reference", "error", "allowed"]


def outside(report: Report) -> list[Row]:
    """The rows whose error exceeds the allowed one, is not a number, or is missing (failed case)."""
    return [row for row in report["cases"] if not _holds(row)]


def tables(report: Report) -> list[Table]:
    """A table of all rows, with a mark on each row of `outside`; a table of the failed cases, if any."""
    rows: list[list[str]] = []
    name = None
    for row in report["cases"]:
        if row["name"] != name:
            name = row["name"]
            rows.append([name, *5 * [""]])
        _, quantity, *numbers = _cells(row)
        rows.append([f"  {quantity}", *numbers, _mark(row)])
    heads = ["case", *HEADS[2:], " "]
    found: list[Table] = [("Validation: errors relative to the reference", heads, rows)]
    failed = [[row["name"], row["failure"]] for row in report["cases"] if "failure" in row]
    return [*found, ("Cases that failed", ["case", "failure"], failed)] if failed else found


def markdown_table(rows: Iterable[Row]) -> str:
    """The rows of a report as a Markdown table, with the sources of the references in the last column."""
    heads = [*HEADS, "source of the reference"]
    lines = [heads, ["---", "---", *4 * ["---:"], "---"]]
    lines += [[*_cells(row), row["source"]] for row in rows]
    return "".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |\n" for line in lines)


def with_table(page: str, rows: Iterable[Row]) -> str:
    """The text of a page, with the table of the rows in place of the text between BEGIN and END.

    Raises ArgumentError unless the page has both, once each and in this order: text would be lost.
    """
    if page.count(BEGIN) != 1 or page.partition(BEGIN)[2].count(END) != 1:
        raise ArgumentError(
            f"the page has no place for the table: write {BEGIN} and, after it, {END}, once each"
        )
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{markdown_table(rows)}{END}{after}"


def _holds(row: Row) -> bool:
    return row["error"] is not None and bool(row["error"] <= row["allowed"])


def _mark(row: Row) -> str:
    return "failed" if "failure" in row else "" if _holds(row) else "OUTSIDE"


def _cells(row: Row) -> list[str]:
    if "failure" in row:
        return [row["name"], "failed", *4 * [""]]
    numbers = [f"{row[key]:.6g}" if row[key] is not None else "none" for key in ("value", "reference")]
    errors = [f"{row[key]:.1e}" if row[key] is not None else "none" for key in ("error", "allowed")]
    return [row["name"], row["quantity"], *numbers, *errors]
